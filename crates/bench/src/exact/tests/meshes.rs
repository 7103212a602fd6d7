//! Tessellated scenes: `meshes.csv` and the OBJ files beside it.

use super::super::{polygon_form_factor, polygon_solid_angle, polygon_specular};
use super::{table, text, v};
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
    let rows = table("meshes.csv");
    for row in &rows {
        let columns: Vec<&str> = row.split(',').collect();
        let (id, file) = (columns[0], columns[1]);
        let number = |i: usize| -> f64 { columns[i].parse().unwrap() };
        let (scale, shift) = (number(2), v(number(3), number(4), number(5)));
        let mut soup = triangles(&text(&format!("meshes/{file}")));
        for point in soup.iter_mut().flatten() {
            *point = *point * scale + shift;
        }
        // A closed convex body shows each direction two faces; keep the one that looks at the point.
        if ["box.obj", "sphere.obj"].contains(&file) {
            soup.retain(|t| (t[1] - t[0]).cross(t[2] - t[0]).dot(t[0]) < 0.0);
        }
        let sum = |f: &dyn Fn(&[DVec3]) -> f64| -> f64 { soup.iter().map(|t| f(t)).sum() };
        let visibility = 1.0 - sum(&|t| polygon_solid_angle(t, DVec3::Z)) / TAU;
        let diffuse = 1.0 - sum(&|t| polygon_form_factor(t, DVec3::Z));
        // Up to 160 triangles are added.
        for (value, exact) in [(visibility, number(6)), (diffuse, number(7))] {
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
                let exact = number(8 + 3 * k + j);
                assert!(
                    (value - exact).abs() < 1e-14,
                    "{id} n {n}: {value} for {exact}"
                );
            }
        }
    }
    assert_eq!(rows.len(), 42);
}
