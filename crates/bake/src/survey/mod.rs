//! What lies under each texel: cells of surface, the mean material, the mean position and normals.

mod cell;
mod cells;
#[cfg(test)]
pub(crate) mod fixture;
mod rims;
mod seen;
mod spot;
mod texel;

pub(crate) use cell::{Cell, Sample, kept_in, place_in};
pub(crate) use cells::Cells;

pub(crate) use texel::{Surveyor, Texel};
