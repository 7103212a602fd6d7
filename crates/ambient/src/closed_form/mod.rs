//! Exact ambient terms of points above which nothing stands.
//!
//! [`phong_open`] replaces the sums of equations (15) and (16): they are finite only for integer exponents, their
//! factorials overflow, and beyond 90 degrees they cancel.

mod ball;
mod open;
mod sums;
mod tilted;

pub use ball::ball;
pub use open::{phong_open, phong_open_angle, phong_open_cosine};
pub use sums::{specular_convex, specular_factor};
pub use tilted::{tilted_bent, tilted_diffuse, tilted_mean, tilted_specular, tilted_visibility};
