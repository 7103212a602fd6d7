//! Frames shaded from tables: section 3 of G. Miller, R. Hoffman, "Illumination and Reflection Maps" (1984).
//!
//! A [`GBuffer`] holds what a camera sees of an object: normals, views, materials. A [`Shader`] turns it into a picture
//! by looking up reflection maps, at a cost that does not depend on what the maps show. Tables are made once; frames
//! follow.
//!
//! Intensity = Wd(E·N) kd D\[N] + Ws(E·N) ks S\[R] with R = 2(E·N)N − E. E points from the surface to the eye.
//!
//! # Where what is
//!
//! * What a camera sees: `gbuffer.rs`, of a scene by `surfel.rs`, kept as codes by `encoded.rs` and `relit.rs`.
//! * Line 9 of the algorithm: `shader.rs` and `row.rs`. Look-ups: `table.rs`, `antialias.rs`, `summed.rs` with
//!   `slices.rs`. Maps from files: `set.rs`.
//! * Many frames: `sequence.rs`, along a `path.rs`. Six materials on a sheet: `balls.rs`.
//! * Materials fitted to pictures: `fit.rs`.
#![forbid(unsafe_code)]

mod antialias;
mod balls;
mod encoded;
#[cfg(test)]
mod energy_tests;
mod error;
mod fit;
mod gbuffer;
mod index;
#[cfg(test)]
mod object_tests;
mod path;
#[cfg(test)]
mod reflectance_tests;
mod relit;
mod row;
mod sequence;
mod set;
mod shade;
mod shader;
mod slices;
mod summed;
mod surfel;
mod table;
#[cfg(test)]
mod tests;

pub use antialias::Lookup;
pub use balls::Balls;
pub use encoded::NormalCode;
pub use error::Error;
pub use fit::{Fit, Shot, fit};
pub use gbuffer::{GBuffer, Turn, View};
pub use index::Index;
pub use path::CameraPath;
pub use relit::Encoded;
pub use sequence::{Frame, Motion, Sequence};
pub use set::{SurfaceType, TableSet, specular_files};
pub use shade::{backdrop, frame};
pub use shader::Shader;
pub use summed::Summed;
pub use surfel::{Mirrored, Reflected, Shading, Subject, Surfel};
pub use table::Table;
