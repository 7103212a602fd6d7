//! From layout coordinates to texels of a page, in one place: f32 in the layout, f64 from here on.

use crate::{Atlas, MeshLayout, Placement};
use glam::{DVec2, Vec2};
use scene::Scene;

/// The corners of an object's triangle in page UV (0..=1, v grows down), and its page.
///
/// Computed in f64 and rounded once. The file's own bits come back for a set that was kept as it stands.
///
/// # Panics
///
/// If `instance` or `triangle` is out of range.
pub fn triangle_uv(scene: &Scene, atlas: &Atlas, instance: u32, triangle: u32) -> ([Vec2; 3], u32) {
    let placement = &atlas.placements[instance as usize];
    let layout = &atlas.meshes[scene.instances[instance as usize].mesh as usize];
    let corners = corners(layout, placement, triangle as usize, 1.0);
    (
        corners.map(|p| p.as_vec2()),
        page(layout, placement, triangle as usize),
    )
}

/// Page of a triangle.
pub(crate) fn page(layout: &MeshLayout, placement: &Placement, triangle: usize) -> u32 {
    placement.page
        + layout
            .triangle_pages
            .get(triangle)
            .map_or(0, |&p| u32::from(p))
}

/// Corners of a triangle on its page, scaled by `size` (the page edge gives texels).
pub(crate) fn corners(
    layout: &MeshLayout,
    placement: &Placement,
    triangle: usize,
    size: f64,
) -> [DVec2; 3] {
    layout.triangles[triangle].map(|v| place(layout.uvs[v as usize], placement) * size)
}

/// A layout coordinate on the page.
pub(crate) fn place(uv: Vec2, placement: &Placement) -> DVec2 {
    let scale = Vec2::from(placement.scale).as_dvec2();
    let offset = Vec2::from(placement.offset).as_dvec2();
    uv.as_dvec2() * scale + offset
}

/// Twice the signed area of a triangle.
pub(crate) fn twice_area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}
