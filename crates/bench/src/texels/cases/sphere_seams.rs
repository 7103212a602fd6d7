//! T6: a sphere of six charts, turned, mirrored and of different densities. Values must agree across their borders.

use super::scene;
use crate::exact::polygon_form_factor;
use crate::texels::Error;
use crate::texels::bake::{Baked, Lab, PER_EDGE, STEP, Texels, score};
use crate::texels::build::{level, mesh, polygon, sheet};
use crate::texels::row::Row;
use crate::texels::seams::seams;
use ::bake::Seams;
use glam::{DVec2, DVec3};
use scene::authored::Mesh;
use std::f64::consts::FRAC_PI_4;

const SIZE: u32 = 64;
/// Facets along an edge of a chart.
const CELLS: usize = 16;
/// Points of each facet's edge: 64 of each of the 12 seams.
const PER_FACET: u32 = 4;
/// Half edge of the plane, and its height; the sphere is of radius 1 about the origin.
const PLANE: (f64, f64) = (3.0, -1.2);

/// Where a chart lies: its middle and edge in texels, its turn in degrees, and whether it is mirrored.
struct Chart {
    middle: DVec2,
    edge: f64,
    degrees: f64,
    mirrored: bool,
}

const fn chart(x: f64, y: f64, edge: f64, degrees: f64, mirrored: bool) -> Chart {
    Chart {
        middle: DVec2::new(x, y),
        edge,
        degrees,
        mirrored,
    }
}

/// Densities 1:1, 1:2 and 3:7.
const CHARTS: [Chart; 6] = [
    chart(13.3, 13.3, 22.0, 0.0, false),
    chart(38.1, 13.2, 22.0, 90.0, false),
    chart(13.3, 38.4, 22.0, 0.0, true),
    chart(36.0, 37.0, 11.0, 45.0, false),
    chart(53.5, 33.0, 22.0 * 3.0 / 7.0, 13.0, false),
    chart(54.0, 50.0, 11.0, 13.0, false),
];

/// The faces from `first` to before `end` of the sphere.
fn part(name: &str, [first, end]: [usize; 2]) -> Mesh {
    let mut part = mesh(name);
    for (face, chart) in CHARTS.iter().enumerate().take(end).skip(first) {
        let axis = face / 2;
        let side = if face % 2 == 0 { 1.0 } else { -1.0 };
        let [out, a, b] = [axis, (axis + 1) % 3, (axis + 2) % 3].map(|k| DVec3::AXES[k]);
        let at = |i: usize, j: usize| {
            let angle = |k: usize| FRAC_PI_4 * (2.0 * k as f64 / CELLS as f64 - 1.0);
            let (u, v) = (angle(i).tan(), angle(j).tan());
            let corner = (out * side + a * u * side + b * v).normalize();
            // Squares of the chart: every cell is as large as the next.
            let flat = DVec2::new(i as f64, j as f64) / CELLS as f64 - 0.5;
            let flat = if chart.mirrored {
                flat * DVec2::new(-1.0, 1.0)
            } else {
                flat
            };
            let turn = DVec2::from_angle(chart.degrees.to_radians());
            (corner, chart.middle + turn.rotate(flat) * chart.edge)
        };
        for (i, j) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j))) {
            let cell = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            part.normals
                .extend(cell.map(|(p, _)| p.as_vec3().to_array()));
            polygon(
                &mut part,
                SIZE,
                &cell.map(|(p, _)| p),
                &cell.map(|(_, uv)| uv),
            );
        }
    }
    part
}

fn ground() -> [DVec3; 4] {
    let (half, z) = PLANE;
    level([-half, half], [-half, half], z)
}

pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (variant, parts) in [
        ("one object", [[0, 6]].as_slice()),
        ("two objects", &[[0, 3], [3, 6]]),
    ] {
        let bake = |seams: Seams| {
            let mut meshes: Vec<Mesh> = parts.iter().map(|p| part("sphere", *p)).collect();
            meshes.push(sheet("plane", SIZE, ground(), [4.0, 53.0, 30.0, 61.0]));
            let made = scene("T6", meshes, vec![])?;
            lab.bake_with("T6", made, Texels::Authored(SIZE), |options| {
                options.seams = seams
            })
        };
        // A point of the sphere sees nothing of it; the plane alone takes its share.
        let judge = |baked: &Baked| {
            let judged = baked.judge(PER_EDGE, |point| {
                let taken = || {
                    let plane = ground().map(|p| p - point.position);
                    polygon_form_factor(&plane, point.position.normalize())
                };
                ((point.instance as usize) < parts.len()).then(|| 1.0 - taken())
            });
            score(&judged)
        };
        let (alone, solved) = (bake(Seams::Off)?, bake(Seams::default())?);
        let (before, after) = (judge(&alone), judge(&solved));
        let found = seams(&solved.lit(), PER_FACET);
        let complete = found.edges == 12 * CELLS;
        let step = (
            "step across the seams at 12 x 64 points: 1/255",
            if complete { found.max } else { f64::NAN },
            Some(STEP),
        );
        let risen = (
            "RMSE to truth above that with seams left alone: 0",
            after.rmse - before.rmse,
            Some(0.0),
        );
        for criterion in [step, risen] {
            rows.push(lab.row("T6", variant, after, criterion));
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_stay_on_the_page_and_faces_look_outward() {
        let sphere = part("sphere", [0, 6]);
        assert_eq!(sphere.triangles.len(), 6 * CELLS * CELLS * 2);
        let uvs = sphere.uvs.as_flattened();
        assert!(uvs.iter().all(|&u| (0.02..0.98).contains(&u)));
        for triangle in &sphere.triangles {
            let [a, b, c] =
                triangle.map(|v| DVec3::from(sphere.positions[v as usize].map(f64::from)));
            assert!((b - a).cross(c - a).dot(a) > 0.0, "{a} {b} {c}");
        }
    }
}
