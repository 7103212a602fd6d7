//! Where rays go: points of a low-discrepancy sequence, and maps from those points to directions.
//!
//! [`Stream`] labels the points of one texel, [`Streams`] reads sixteen of them at once from a [`PointSet`],
//! [`Mixture`] and [`Lobe`] map points `[u0, u1]` to directions: the mixture by the concentric map of the square, the
//! lobe with `u0` for the zenith angle by an analytic inverse (1 is the pole) and `u1` for the azimuth in turns.

mod guide;
mod hemisphere;
mod joint;
mod lattice;
mod lobe;
mod sobol;
mod stream;
mod turn;
mod wide;

pub use crate::lanes::{LANES, Wide};
pub use guide::{Counts, Guide};
pub use hemisphere::Mixture;
pub use lobe::Lobe;
pub use stream::Stream;
pub use turn::turn_sin_cos;
pub use wide::{Block, PointSet, Streams};

/// What a sample of the first density counts beside one of the second, over the first: the power heuristic of E. Veach,
/// L. Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering" (1995). Finite where either is 0, and
/// 0 where the first is.
pub fn power_over_density(first: f64, second: f64) -> f64 {
    first / (first * first + second * second).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod chi_square;
