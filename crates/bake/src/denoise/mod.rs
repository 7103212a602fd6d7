//! Denoising: an integrated term smoothed over the texels of a surface where that lowers its error.
//!
//! Windows of several sizes and polynomials of two degrees compete per texel by Stein's unbiased estimate of their error; the plain
//! value is among them, and wins where nothing helps. The standard errors that come back include the bias that is estimated.

mod field;
mod fit;
mod regression;
mod window;

pub(crate) use field::Field;
pub(crate) use regression::denoise;
