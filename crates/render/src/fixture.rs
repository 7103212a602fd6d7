//! Small scenes for this crate's tests.

use glam::Vec3;
use rays::{BackendKind, RayBackend, TreeKind, World, WorldOptions, build};
use scene::authored::{Material, Mesh};
use scene::{Alpha, Scene};
use std::sync::Arc;

/// A parallelogram and what it is made of.
pub(crate) struct Sheet {
    /// A corner and the two edges that leave it; the front is on the side of their cross product.
    pub place: [Vec3; 3],
    pub albedo: Vec3,
    pub specular: Vec3,
    pub exponent: f64,
    pub emission: Vec3,
}

/// A matt white sheet.
pub(crate) fn white(place: [Vec3; 3]) -> Sheet {
    Sheet {
        place,
        albedo: Vec3::ONE,
        specular: Vec3::ZERO,
        exponent: 0.0,
        emission: Vec3::ZERO,
    }
}

/// The plane y = 0, wide enough to have no end.
pub(crate) fn ground() -> Sheet {
    white([
        Vec3::new(-4096.0, 0.0, -4096.0),
        Vec3::Z * 8192.0,
        Vec3::X * 8192.0,
    ])
}

/// A world of sheets and the backend that needs no library.
pub(crate) fn world(sheets: &[Sheet]) -> (World, Box<dyn RayBackend>) {
    world_of(sheets, Alpha::Opaque)
}

/// A world of white sheets that stop this share of the rays.
pub(crate) fn see_through(places: &[[Vec3; 3]], factor: f32) -> (World, Box<dyn RayBackend>) {
    let sheets: Vec<Sheet> = places.iter().map(|place| white(*place)).collect();
    world_of(&sheets, Alpha::Blend { factor, map: None })
}

fn world_of(sheets: &[Sheet], alpha: Alpha) -> (World, Box<dyn RayBackend>) {
    let meshes = sheets.iter().enumerate().map(|(number, sheet)| {
        let [corner, a, b] = sheet.place;
        let mut mesh = Mesh::default();
        mesh.positions = [corner, corner + a, corner + a + b, corner + b]
            .map(|p| p.to_array())
            .to_vec();
        mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
        mesh.material = number;
        mesh
    });
    let materials = sheets.iter().map(|sheet| {
        let mut material = Material::default();
        material.albedo = sheet.albedo.to_array();
        material.specular = sheet.specular.to_array();
        material.exponent = sheet.exponent;
        material.emission = sheet.emission.to_array();
        material
    });
    let mut scene = Scene::from_meshes(meshes.collect(), materials.collect()).unwrap();
    for material in &mut scene.materials {
        material.alpha = alpha.clone();
    }
    let options = WorldOptions {
        instancing: false,
        alpha_test_all: false,
    };
    let world = World::new(Arc::new(scene), options).unwrap();
    let backend = build(BackendKind::Obvhs(TreeKind::Cwbvh), &world, 1).unwrap();
    (world, backend)
}
