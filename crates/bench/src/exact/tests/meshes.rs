//! Tessellated scenes: `mesh_expected.csv` and the OBJ files beside it.

use super::super::{polygon_form_factor, polygon_solid_angle, polygon_specular};
use super::{reference, v};
use ambient::closed_form::phong_open_angle;
use glam::DVec3;
use std::f64::consts::TAU;

fn triangles(obj: &str) -> Vec<[DVec3; 3]> {
    let mut vertices = Vec::new();
    let mut faces = Vec::new();
    for line in obj.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
                vertices.push(v(p[0], p[1], p[2]));
            }
            Some("f") => {
                let f: Vec<usize> = words.map(|w| w.parse().unwrap()).collect();
                faces.push([0, 1, 2].map(|k| vertices[f[k] - 1]));
            }
            _ => {}
        }
    }
    faces
}

#[test]
fn tessellated_scenes_meet_their_table_in_all_three_terms() {
    let Some(table) = reference("mesh_expected.csv") else {
        return;
    };
    let mut scenes = 0;
    for line in table.lines().skip(1) {
        let columns: Vec<&str> = line.split(',').collect();
        let id = columns[0];
        // The two boxes overlap as seen from the point.
        if id == "twobox" {
            continue;
        }
        let mut soup = triangles(&reference(columns[1]).unwrap());
        // A closed convex body shows each direction two faces; keep the one that looks at the point.
        if id == "box" || id.contains("sphere") {
            soup.retain(|t| (t[1] - t[0]).cross(t[2] - t[0]).dot(t[0]) < 0.0);
        }
        let number = |i: usize| -> f64 { columns[i].parse().unwrap() };
        let sum = |f: &dyn Fn(&[DVec3]) -> f64| -> f64 { soup.iter().map(|t| f(t)).sum() };
        let visibility = 1.0 - sum(&|t| polygon_solid_angle(t, DVec3::Z)) / TAU;
        let diffuse = 1.0 - sum(&|t| polygon_form_factor(t, DVec3::Z));
        // The table has 15 digits, and up to 1,280 triangles are added.
        for (value, exact) in [(visibility, number(9)), (diffuse, number(10))] {
            assert!((value - exact).abs() < 4e-15, "{id}: {value} for {exact}");
        }
        let lobes = [(0.0_f64, 0.0_f64), (30.0, 0.0), (60.0, 90.0)];
        for (k, n) in [5.0, 50.0].into_iter().enumerate() {
            for (j, (zenith, azimuth)) in lobes.into_iter().enumerate() {
                let (s, c) = zenith.to_radians().sin_cos();
                let (y, x) = azimuth.to_radians().sin_cos();
                let axis = v(s * x, s * y, c);
                let open = phong_open_angle(n, zenith.to_radians());
                let value = open - sum(&|t| polygon_specular(t, DVec3::Z, axis, n));
                let exact = number(13 + 3 * k + j);
                // The table has 12 digits.
                assert!(
                    (value - exact).abs() < 1e-12,
                    "{id} n {n}: {value} for {exact}"
                );
            }
        }
        scenes += 1;
    }
    assert_eq!(scenes, 42);
}
