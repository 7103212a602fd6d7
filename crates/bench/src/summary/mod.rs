//! What the rows of a benchmark say: times to an error that was measured, ratios at equal error, a table and a picture.

mod curve;
mod plot;
mod spread;
mod table;

pub use plot::svg;
pub(crate) use spread::rounded;
pub use spread::{Spread, median};
pub use table::markdown;

#[cfg(test)]
mod tests;
