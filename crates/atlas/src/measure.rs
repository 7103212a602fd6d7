//! Areas of objects in the world and on their pages.

use crate::uv::{corners, twice_area};
use crate::{MeshLayout, Placement};
use glam::DVec2;
use scene::Scene;

/// A placement that leaves coordinates as they are.
pub(crate) const AS_IT_STANDS: Placement = Placement {
    page: 0,
    scale: [1.0; 2],
    offset: [0.0; 2],
};

/// Surface area of an object in the world, in square scene units.
pub(crate) fn world_area(scene: &Scene, instance: usize) -> f64 {
    let instance = &scene.instances[instance];
    triangle_areas(scene, instance.mesh as usize, &instance.transform).sum()
}

/// Surface area of a mesh in its own space.
pub(crate) fn mesh_area(scene: &Scene, mesh: usize) -> f64 {
    triangle_areas(scene, mesh, &glam::DAffine3::IDENTITY).sum()
}

fn triangle_areas<'a>(
    scene: &'a Scene,
    mesh: usize,
    transform: &'a glam::DAffine3,
) -> impl Iterator<Item = f64> + 'a {
    let mesh = &scene.meshes[mesh];
    mesh.triangles.iter().map(move |t| {
        let [a, b, c] =
            t.map(|v| transform.transform_vector3(mesh.positions[v as usize].as_dvec3()));
        0.5 * (b - a).cross(c - a).length()
    })
}

/// Area that a layout takes of its own square.
pub(crate) fn uv_area(layout: &MeshLayout) -> f64 {
    (0..layout.triangles.len())
        .map(|t| 0.5 * twice_area(corners(layout, &AS_IT_STANDS, t, 1.0)).abs())
        .sum()
}

/// Bounds of a layout in its own square; `None` without triangles.
pub(crate) fn uv_bounds(layout: &MeshLayout) -> Option<(DVec2, DVec2)> {
    layout
        .triangles
        .iter()
        .flatten()
        .map(|&v| layout.uvs[v as usize].as_dvec2())
        .map(|p| (p, p))
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Number of charts of a layout: sets of triangles that hang together by corners at one coordinate.
pub(crate) fn charts(layout: &MeshLayout) -> u32 {
    let mut known = std::collections::HashMap::new();
    let mut parents: Vec<usize> = Vec::new();
    let mut count = 0;
    let root = |parents: &mut Vec<usize>, mut p: usize| {
        while parents[p] != p {
            parents[p] = parents[parents[p]];
            p = parents[p];
        }
        p
    };
    for triangle in &layout.triangles {
        let corners = triangle.map(|v| {
            // Adding 0 makes -0 equal to it.
            let at = (layout.uvs[v as usize] + 0.0).to_array().map(f32::to_bits);
            *known.entry(at).or_insert_with(|| {
                parents.push(parents.len());
                count += 1;
                parents.len() - 1
            })
        });
        for k in 0..2 {
            let (a, b) = (
                root(&mut parents, corners[k]),
                root(&mut parents, corners[k + 1]),
            );
            if a != b {
                parents[a] = b;
                count -= 1;
            }
        }
    }
    count
}

/// Texels per scene unit that a layout reaches: the mean over the surface of the square root of texel area by area.
pub(crate) fn density(
    scene: &Scene,
    meshes: &[MeshLayout],
    placements: &[Placement],
    size: u32,
) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for (instance, placement) in scene.instances.iter().zip(placements) {
        let layout = &meshes[instance.mesh as usize];
        let areas = triangle_areas(scene, instance.mesh as usize, &instance.transform);
        for (triangle, area) in areas.enumerate() {
            let texels = 0.5 * twice_area(corners(layout, placement, triangle, f64::from(size)));
            sum += (texels.abs() * area).sqrt();
            total += area;
        }
    }
    if total > 0.0 { sum / total } else { 0.0 }
}
