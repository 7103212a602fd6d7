//! Ten scenes that break lightmap bakers, judged as a player sees them: at points of surfaces, through the bilinear
//! look-up of a graphics card, against exact values.
//!
//! A scene is baked with the defaults of the product. The judge takes a regular grid of points of every texel, keeps
//! those on a triangle that can be seen, looks each up in the finished page (gutters filled) and compares it with the
//! exact diffuse term at that point. What a texel holds is not looked at: a value that is right for the texel and wrong
//! on the surface fails. `cases` holds the scenes, one file each, with the criterion and where the exact values come
//! from; `seams` finds the borders of charts from the geometry alone.
//!
//! Criteria that bound noise are stated for 4,096 rays a texel and grow as N^-3/4 for fewer, which is how the error of
//! the sample points falls.

mod bake;
mod best;
mod build;
mod cases;
mod error;
mod facts;
mod lit;
mod points;
mod row;
mod run;
mod score;
mod seams;
#[cfg(test)]
mod tests;

pub use error::Error;
pub use facts::{Facts, ObjectShare};
pub use lit::Lit;
pub use row::{Row, csv, markdown};
pub use run::run;
pub use score::Score;
pub use seams::{Seams, seams};
