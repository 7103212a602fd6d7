//! Light for what moves: what arrives at places in the air, from all directions.
//!
//! A probe is an illumination map at a place, kept as real spherical harmonics of low order, each with its standard
//! error. [`Gather`] makes one from the sky, the lights and the surfaces around it. Surfaces tell their own light by a
//! look-up in a finished bake, or it is followed on from them. [`Grid`] and [`fill`] make volumes of probes, and
//! [`interpolation`] says what a look-up between probes costs. [`Gather::reflection`] keeps all directions, for what is
//! no matt surface. The crate casts rays and computes; it opens no files and prints nothing.
//!
//! # Where what is
//!
//! `gather.rs` gathers the light of a probe and `estimate.rs` states its errors. `path.rs` has the light from surface
//! to surface, `grid.rs` and `volume.rs` say where probes stand, `refine.rs` which of a volume are gathered,
//! `reflect.rs` makes reflection maps, `numbers.rs` keeps what was gathered. Harmonics are in
//! `crates/ambient/src/harmonics.rs`, files in `crates/report/src/probes`.
#![forbid(unsafe_code)]

mod error;
mod estimate;
#[cfg(test)]
mod fixture;
mod gather;
mod grid;
mod interpolate;
mod numbers;
mod path;
mod refine;
mod reflect;
mod sky;
#[cfg(test)]
mod tests;
mod volume;

pub use error::Error;
pub use gather::{BakedLight, DISTANCE_EDGE, Gather, LEAST_RAYS, Part, Probe};
pub use grid::Grid;
pub use interpolate::{Interpolation, fill, interpolation, tried};
pub use refine::{complete, lacking};
pub use reflect::{LEAST_EDGE, Level, Reflection};
pub use sky::Sky;
pub use volume::{Placed, State, gather};
