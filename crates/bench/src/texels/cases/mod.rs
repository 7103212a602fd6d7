//! The ten scenes, one file each: how it is built, what is exact, and what it is held to.

mod contact_sphere;
mod convex;
mod instances;
mod plates;
mod room;
mod scales;
mod soup;
mod sphere_seams;
mod sunk_box;
mod wall;

use super::bake::Lab;
use super::error::Error;
use super::row::Row;
use scene::Scene;
use scene::authored::{Material, Mesh};

/// Bakes a scene with its variants, and judges them.
type Case = fn(&Lab) -> Result<Vec<Row>, Error>;

/// The scenes in order.
pub(super) const ALL: [Case; 10] = [
    wall::rows,
    contact_sphere::rows,
    sunk_box::rows,
    room::rows,
    convex::rows,
    sphere_seams::rows,
    soup::rows,
    scales::rows,
    plates::rows,
    instances::rows,
];

/// The scene of meshes; an empty list of materials is one white, double-sided one.
fn scene(name: &str, meshes: Vec<Mesh>, materials: Vec<Material>) -> Result<Scene, Error> {
    Scene::from_meshes(meshes, materials).map_err(|source| Error::Scene {
        name: name.into(),
        source,
    })
}
