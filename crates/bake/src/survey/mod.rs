//! What lies under each texel: cells of surface, the mean material, the mean position and normals.

mod cell;
mod rims;
mod seen;
mod texel;

pub(crate) use cell::{Cell, Sample, place_in};

pub(crate) use texel::{Surveyor, Texel};
