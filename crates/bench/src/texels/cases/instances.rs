//! T10: a thousand placements of one mesh: turned, mirrored, squashed, and some in the same place.

use super::scene;
use crate::exact::polygon_form_factor;
use crate::texels::Error;
use crate::texels::bake::{Judged, Lab, Texels, score};
use crate::texels::build::{level, mesh, polygon};
use crate::texels::row::Row;
use glam::{DAffine3, DMat3, DVec2, DVec3};
use scene::Scene;
use scene::authored::Mesh;

const COUNT: usize = 1000;
/// The last placements are those of the first ones again.
const TWICE: usize = 10;
/// So far apart that the others take less than 0.001 from any point.
const SPACING: f64 = 100.0;
const CELLS: usize = 16;
const DENSITY: f64 = 8.0;

/// The floor and the wall of the bracket: what the one sees of the other is its exact value.
fn quads() -> [[DVec3; 4]; 2] {
    let upright = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 1.0, 1.0],
        [0.0, 0.0, 1.0],
    ];
    [level([0.0, 1.0], [0.0, 1.0], 0.0), upright.map(DVec3::from)]
}

/// The bracket, in many facets, with charts of its own.
fn bracket() -> Mesh {
    let mut bracket = mesh("bracket");
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    for (quad, left) in quads().into_iter().zip([0.0, 0.6]) {
        for (i, j) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j))) {
            let at = |(x, y): (f64, f64)| DVec2::new(i as f64 + x, j as f64 + y) / CELLS as f64;
            let cell = corners.map(at);
            let point = |p: DVec2| quad[0] + (quad[1] - quad[0]) * p.x + (quad[3] - quad[0]) * p.y;
            let places = cell.map(|p| 0.4 * p + DVec2::new(left, 0.0));
            polygon(&mut bracket, 1, &cell.map(point), &places);
        }
    }
    bracket
}

/// The placement that `k` of `count` repeats: itself, but for the last ones.
fn original(k: usize, count: usize) -> usize {
    (k + TWICE).checked_sub(count).unwrap_or(k)
}

/// Where placement `k` stands: one in ten is mirrored, one in ten squashed to a tenth.
fn place(k: usize) -> DAffine3 {
    let scale = match k % 10 {
        3 => DVec3::new(-1.0, 1.0, 1.0),
        7 => DVec3::new(1.0, 1.0, 0.1),
        _ => DVec3::ONE,
    };
    let turn =
        DMat3::from_rotation_z(0.7 * k as f64) * DMat3::from_rotation_x(0.3 * (k % 5) as f64);
    let at = DVec3::new((k % 32) as f64, (k / 32) as f64, 0.0) * SPACING;
    DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(scale), at)
}

fn crowd(count: usize) -> Result<Scene, Error> {
    let mut made = scene("T10", vec![bracket()], vec![])?;
    let first = made.instances[0].clone();
    made.instances = (0..count)
        .map(|k| {
            let mut instance = first.clone();
            (instance.transform, instance.node) = (place(original(k, count)), k as u32);
            instance
        })
        .collect();
    Ok(made)
}

/// The judged points of so many placements, and the bytes of their ray structure.
fn judge(lab: &Lab, count: usize) -> Result<(Vec<Judged>, u64), Error> {
    let baked = lab.bake("T10", crowd(count)?, Texels::Unwrapped(1024, DENSITY))?;
    let judged = baked.judge(2, |point| {
        let place = place(original(point.instance as usize, count));
        let home = place.inverse().transform_point3(point.position);
        // The floor is the quad in whose plane the point lies.
        let own = usize::from(home.z > home.x);
        let normals = place.matrix3.inverse().transpose();
        let normal = (normals * [DVec3::Z, DVec3::X][own]).normalize();
        let other = quads()[1 - own].map(|p| place.transform_point3(p) - point.position);
        Some(1.0 - polygon_form_factor(&other, normal))
    });
    Ok((judged, baked.structure_bytes))
}

pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, Error> {
    // 128 texels each: fewer rays than the small scenes.
    let lab = &Lab {
        rays: (lab.rays / 16).max(16),
        ..*lab
    };
    let few = 2 + TWICE;
    let ((alone, few_bytes), (crowd, bytes)) = (judge(lab, few)?, judge(lab, COUNT)?);
    let plain = [0, 1, 2, 4, 5, 6, 8, 9];
    let mut rows = Vec::new();
    for (variant, kinds) in [
        ("plain", plain.as_slice()),
        ("mirrored", &[3]),
        ("squashed", &[7]),
    ] {
        let of = |judged: &[Judged], count| {
            let kind =
                |j: &&Judged| kinds.contains(&(original(j.point.instance as usize, count) % 10));
            score(&judged.iter().filter(kind).copied().collect::<Vec<_>>())
        };
        let (score, alone) = (of(&crowd, COUNT), of(&alone, few));
        let criterion = (
            "RMSE above that of a dozen placements: 0.001 at 4,096 rays",
            score.rmse - alone.rmse,
            Some(lab.noise(0.001)),
        );
        rows.push(lab.row("T10", format!("{variant} placements"), score, criterion));
    }
    let per = (bytes as f64 - few_bytes as f64) / (COUNT - few) as f64;
    let criterion = (
        "bytes a placement adds to the ray structure, by 36 a triangle of the mesh: 0.1",
        per / (bracket().triangles.len() * 36) as f64,
        Some(0.1),
    );
    rows.push(lab.row("T10", "memory", score(&crowd), criterion));
    Ok(rows)
}
