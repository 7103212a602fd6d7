//! The surfaces of meshes that are placed together.

use super::topology::{self, Face, Surface};
use super::tree::SurfaceTree;
use scene::Scene;
use std::collections::HashMap;
use std::sync::OnceLock;

/// Surfaces of meshes that are placed together.
#[derive(Debug)]
pub(super) struct Shape {
    /// Surface of each triangle, by mesh.
    pub surface_of: Vec<Vec<u32>>,
    pub surfaces: Vec<Surface>,
    /// Built when first asked.
    pub trees: Vec<OnceLock<SurfaceTree>>,
}

impl Shape {
    /// The shape of some meshes.
    pub fn of(scene: &Scene, meshes: Vec<u32>) -> Self {
        let faces_of = |&mesh: &u32| -> Vec<Face> {
            let count = scene.meshes[mesh as usize].triangles.len() as u32;
            (0..count).map(|triangle| Face { mesh, triangle }).collect()
        };
        let mut surfaces = Vec::new();
        let mut open = Vec::new();
        for mesh in &meshes {
            let found = topology::surfaces(scene, &faces_of(mesh));
            for surface in found {
                match surface.volume == 0.0 && meshes.len() > 1 {
                    true => open.extend(surface.faces),
                    false => surfaces.push(surface),
                }
            }
        }
        surfaces.extend(topology::surfaces(scene, &open));
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
            surface_of,
            surfaces,
        }
    }
}
