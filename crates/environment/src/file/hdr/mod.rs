//! Radiance's RGBE files, both ways: G. Ward, "Real Pixels", Graphics Gems II (1991).
//!
//! A pixel is three mantissas with a common exponent: value = mantissa · 2^(exponent - 136). Mantissas are rounded on
//! writing and taken as they are on reading, so that 1 is 1 in both directions.

mod decode;
mod encode;
#[cfg(test)]
mod tests;

pub(crate) use decode::decode;
pub(crate) use encode::encode;
