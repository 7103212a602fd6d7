//! Frames shaded from tables: section 3 of G. Miller, R. Hoffman, "Illumination and Reflection Maps" (1984).
//!
//! A [`GBuffer`] holds what a camera sees of an object: normals, views, materials. A [`Shader`] turns it into a picture by
//! looking up reflection maps, at a cost that does not depend on what the maps show. Tables are made once; frames follow.
//!
//! Intensity = Wd(E·N) kd D\[N] + Ws(E·N) ks S\[R] with R = 2(E·N)N − E. E points from the surface to the eye.

mod antialias;
mod balls;
mod encoded;
mod gbuffer;
mod index;
mod path;
mod row;
mod shader;
mod summed;
mod table;
#[cfg(test)]
mod tests;
mod weight;

pub use antialias::Lookup;
pub use balls::Balls;
pub use encoded::NormalCode;
pub use gbuffer::{GBuffer, Surfel, Turn, View};
pub use index::Index;
pub use path::CameraPath;
pub use shader::{Shader, backdrop};
pub use summed::Summed;
pub use table::Table;
pub use weight::Weight;
