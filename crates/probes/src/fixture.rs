//! Small scenes for this crate's tests.

use crate::{Error, Gather, Placed, gather};
use glam::DVec3;
use rays::{BackendKind, RayBackend, TreeKind, World, WorldOptions, build};
use scene::Scene;
use scene::authored::{Material, Mesh};
use std::sync::{Arc, Mutex};

/// Parallelograms of one material: a corner and the two edges that leave it, the front on the side of their cross
/// product.
pub(crate) struct Sheets {
    pub places: Vec<[DVec3; 3]>,
    pub albedo: f32,
    pub emission: f32,
    /// Drawn from both sides.
    pub double_sided: bool,
    /// The normal that all of them are shaded by; `None` for each its own.
    pub normal: Option<DVec3>,
}

/// A box with its corners here, its faces outward.
pub(crate) fn block(low: DVec3, high: DVec3) -> Vec<[DVec3; 3]> {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * (high - low));
    vec![
        [low, y, x],
        [low, z, y],
        [low, x, z],
        [high, -x, -y],
        [high, -y, -z],
        [high, -z, -x],
    ]
}

/// The same with its faces inward.
pub(crate) fn room(low: DVec3, high: DVec3) -> Vec<[DVec3; 3]> {
    let turned = |[corner, a, b]: [DVec3; 3]| [corner, b, a];
    block(low, high).into_iter().map(turned).collect()
}

/// A world of sheets, each an object, and the backend that needs no library.
pub(crate) fn world(all: &[Sheets]) -> (World, Box<dyn RayBackend>) {
    let meshes = all.iter().enumerate().map(|(number, sheets)| {
        let mut mesh = Mesh::default();
        mesh.material = number;
        for &[corner, a, b] in &sheets.places {
            // Corners that meet are one, so that bodies are closed.
            let mut at = |place: DVec3| {
                let place = place.as_vec3().to_array();
                let known = mesh.positions.iter().position(|old| *old == place);
                known.unwrap_or_else(|| {
                    mesh.positions.push(place);
                    mesh.positions.len() - 1
                }) as u32
            };
            let [i, j, k, l] = [corner, corner + a, corner + a + b, corner + b].map(&mut at);
            mesh.triangles.extend([[i, j, k], [i, k, l]]);
        }
        let shaded = |normal: DVec3| vec![normal.as_vec3().to_array(); mesh.positions.len()];
        mesh.normals = sheets.normal.map(shaded).unwrap_or_default();
        mesh
    });
    let materials = all.iter().map(|sheets| {
        let mut material = Material::default();
        material.albedo = [sheets.albedo; 3];
        material.emission = [sheets.emission; 3];
        material.double_sided = sheets.double_sided;
        material
    });
    let scene = Scene::from_meshes(meshes.collect(), materials.collect()).unwrap();
    let options = WorldOptions {
        instancing: false,
        alpha_test_all: false,
    };
    let world = World::new(Arc::new(scene), options).unwrap();
    let backend = build(BackendKind::Obvhs(TreeKind::Cwbvh), &world, 1).unwrap();
    (world, backend)
}

/// The probes at these places in order, labelled from `first` on.
pub(crate) fn placed(
    gatherer: &Gather<'_>,
    places: &[DVec3],
    first: u32,
    most: f64,
) -> Vec<Placed> {
    let wanted: Vec<(u32, DVec3)> = (first..).zip(places.iter().copied()).collect();
    let found = Mutex::new(Vec::new());
    let take = |number, placed| {
        found.lock().unwrap().push((number, placed));
        Ok::<(), Error>(())
    };
    gather(gatherer, &wanted, most, &(), take).unwrap();
    let mut found = found.into_inner().unwrap();
    found.sort_unstable_by_key(|(number, _)| *number);
    found.into_iter().map(|(_, placed)| placed).collect()
}
