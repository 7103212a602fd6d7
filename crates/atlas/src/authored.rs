//! Charts of the file's own coordinates, to be packed apart where they stand side by side without a gutter.
//!
//! A chart keeps its shape: it is moved, turned by quarters and scaled, with all charts of its mesh by one
//! factor. So what the author gave to one chart more than to another, it keeps.

use crate::MeshLayout;
use crate::charts::users;
use crate::measure::{mesh_area, uv_area, world_area};
use crate::sheet::Sheet;
use crate::touching::TURN;
use scene::{Mesh, Scene, Sets};
use std::collections::HashMap;

/// The charts of every mesh that takes texels, in the order of meshes. `included` says which instances do.
pub(crate) fn authored_sheets(
    scene: &Scene,
    included: &[bool],
    layouts: &[MeshLayout],
) -> Vec<Sheet> {
    let placed = users(scene, included).into_iter().enumerate();
    let placed = placed.filter(|(_, users)| !users.is_empty());
    placed
        .map(|(mesh, instances)| sheet(scene, mesh, instances, &layouts[mesh]))
        .collect()
}

fn sheet(scene: &Scene, mesh: usize, instances: Vec<u32>, layout: &MeshLayout) -> Sheet {
    let (area, scales) = match instances[..] {
        [only] => (world_area(scene, only as usize), vec![1.0]),
        _ => {
            let own = mesh_area(scene, mesh);
            let scale = |&i: &u32| (world_area(scene, i as usize) / own).sqrt();
            (own, instances.iter().map(scale).collect())
        }
    };
    let scale = (area / uv_area(layout)).sqrt();
    let of = charts(&scene.meshes[mesh], layout);
    let count = of.iter().max().map_or(0, |last| *last as usize + 1);
    let mut sheet = Sheet {
        mesh,
        instances,
        scales,
        sources: Vec::new(),
        points: Vec::new(),
        triangles: Vec::with_capacity(of.len()),
        charts: vec![Vec::new(); count],
        hidden: vec![false; count],
    };
    // Each chart has vertices of its own.
    let mut numbers = HashMap::new();
    for (t, (corners, &chart)) in (0..).zip(layout.triangles.iter().zip(&of)) {
        let number = |v: u32| {
            *numbers.entry((chart, v)).or_insert_with(|| {
                sheet.sources.push(layout.source_vertices[v as usize]);
                let point = layout.uvs[v as usize].as_dvec2() * scale;
                sheet.points.push(point);
                sheet.points.len() as u32 - 1
            })
        };
        let corners = corners.map(number);
        sheet.triangles.push(corners);
        sheet.charts[chart as usize].push(t);
    }
    (0..count).for_each(|chart| sheet.move_to_origin(chart));
    sheet
}

/// The chart of each triangle: sets that hang together by edges at one place, on the surface as by their
/// coordinates, and that do not turn so far there that look-ups across would mix two surfaces.
fn charts(mesh: &Mesh, layout: &MeshLayout) -> Vec<u32> {
    let key = |v: u32| {
        let own = layout.source_vertices[v as usize];
        // Adding 0 makes -0 equal to it.
        let place = (mesh.positions[own as usize] + 0.0)
            .to_array()
            .map(f32::to_bits);
        let uv = (layout.uvs[v as usize] + 0.0).to_array().map(f32::to_bits);
        (place, uv)
    };
    let normal = |t: usize| {
        let at = |v: u32| mesh.positions[v as usize].as_dvec3();
        let [a, b, c] = mesh.triangles[t].map(at);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let mut sets = Sets::new(layout.triangles.len());
    let mut first = HashMap::new();
    for (t, corners) in layout.triangles.iter().enumerate() {
        let keys = corners.map(key);
        for side in 0..3 {
            let [a, b] = [keys[side], keys[(side + 1) % 3]];
            let other = *first.entry((a.min(b), a.max(b))).or_insert(t);
            if other != t && normal(other).dot(normal(t)) >= TURN {
                sets.join(other as u32, t as u32);
            }
        }
    }
    let mut numbers = HashMap::new();
    let number = |t: u32| {
        let next = numbers.len() as u32;
        *numbers.entry(sets.root(t)).or_insert(next)
    };
    (0..layout.triangles.len() as u32).map(number).collect()
}
