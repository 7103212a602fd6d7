//! The surfaces of meshes that are placed together.

use super::spread::MIDDLE;
use super::topology::{self, Surface, corners};
use super::tree::SurfaceTree;
use super::weld::Face;
use super::wound::{FIRST, Sides, Wound};
use scene::Scene;
use std::collections::{HashMap, HashSet};
use std::sync::OnceLock;

/// Surfaces of meshes that are placed together.
#[derive(Debug)]
pub(super) struct Shape {
    /// Surface of each triangle, by mesh.
    pub surface_of: Vec<Vec<u32>>,
    pub surfaces: Vec<Surface>,
    /// Built when first asked.
    pub trees: Vec<OnceLock<SurfaceTree>>,
    /// The faces of each that look inward, found when first asked; see `wound.rs`.
    pub wound: Vec<OnceLock<Wound>>,
    /// Their meshes.
    pub meshes: Vec<u32>,
}

impl Shape {
    /// The shape of some meshes.
    pub fn of(scene: &Scene, meshes: Vec<u32>) -> Self {
        let faces_of = |&mesh: &u32| -> Vec<Face> {
            let count = scene.meshes[mesh as usize].triangles.len() as u32;
            (0..count)
                .map(|triangle| Face::of(mesh, triangle))
                .collect()
        };
        let each = meshes.iter().map(faces_of);
        let found = each.flat_map(|faces| topology::surfaces(scene, &faces));
        let (mut surfaces, open): (Vec<Surface>, Vec<Surface>) =
            found.partition(|surface| surface.volume != 0.0 || meshes.len() == 1);
        surfaces.extend(joined(scene, open));
        let inward = surfaces.iter_mut().filter(|surface| surface.volume < 0.0);
        inward.for_each(|surface| untangle(scene, surface));
        let mut surface_of: Vec<Vec<u32>> = meshes
            .iter()
            .map(|&mesh| vec![0; scene.meshes[mesh as usize].triangles.len()])
            .collect();
        let place: HashMap<u32, usize> = meshes.iter().copied().zip(0..).collect();
        for (index, surface) in surfaces.iter().enumerate() {
            for face in &surface.faces {
                surface_of[place[&face.mesh]][face.triangle as usize] = index as u32;
            }
        }
        Self {
            trees: surfaces.iter().map(|_| OnceLock::new()).collect(),
            wound: surfaces.iter().map(|_| OnceLock::new()).collect(),
            surface_of,
            surfaces,
            meshes,
        }
    }
}

/// What a closed surface encloses says nothing of its faces where it crosses itself: the flue that reaches out below a
/// chimney may hold more than the chimney. Then its faces are asked one by one, and most of them say where it looks.
fn untangle(scene: &Scene, surface: &mut Surface) {
    let tree = SurfaceTree::build(scene, &surface.faces);
    let (mut inward, mut outward) = (0.0, 0.0);
    for face in surface
        .faces
        .iter()
        .step_by(surface.faces.len().div_ceil(FIRST))
    {
        let triangle = corners(scene, *face).map(|corner| corner.as_dvec3());
        let sides = Sides::of((scene, surface, &tree), triangle, MIDDLE);
        match sides {
            sides if sides.is_inward() => inward += sides.area,
            sides if sides.is_outward() => outward += sides.area,
            _ => {}
        }
    }
    surface.tangled |= outward > 0.0;
    if outward > inward {
        surface.volume = -surface.volume;
    }
}

/// Open surfaces of several meshes as those that they make together, a body of several materials; where they make none
/// that has an inside or looks to one side, as a floor and its walls that meet the ceiling elsewhere, as they are.
fn joined(scene: &Scene, open: Vec<Surface>) -> Vec<Surface> {
    let faces: Vec<Face> = open
        .iter()
        .flat_map(|surface| surface.faces.clone())
        .collect();
    let (made, senseless): (Vec<Surface>, Vec<Surface>) = topology::surfaces(scene, &faces)
        .into_iter()
        .partition(|surface| surface.content() != 0.0 || surface.front.is_some());
    let key = |face: &Face| (face.mesh, face.triangle);
    let apart: HashSet<(u32, u32)> = senseless.iter().flat_map(|s| &s.faces).map(key).collect();
    // What hangs together in one mesh does so together with others.
    let stays = open
        .into_iter()
        .filter(|surface| apart.contains(&key(&surface.faces[0])));
    made.into_iter().chain(stays).collect()
}
