//! Cases that break bakers: each baked on every backend and held against its exact value.
//!
//! A case is a small chart at a known point, so that the mean over its texels is the value at that point, and what
//! stands above it. Its bound is four of the standard errors that the bake itself states, plus what rays of a finite
//! number can resolve, plus how far the triangles are from the shape of the formula (computed on the triangles by the
//! polygon formulas, or bounded in the case). Where single precision cannot hold the case, the case names the bound
//! that does.

mod bake;
mod case;
mod cases;
mod equal;
mod error;
mod input;
mod judge;
mod row;
mod run;
mod setup;

pub use case::{Case, Expected, TableEntry};
pub use cases::cases;
pub use error::Error;
pub use row::{Row, Status, markdown};
pub use run::run;
pub use setup::Setup;
