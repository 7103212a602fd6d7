//! The tables of exact values (`tests/tables` of the repository): smooth scenes, Phong lobes over polygonal scenes,
//! tessellated meshes.

mod hard;
mod meshes;
mod tables;

use glam::DVec3;

/// The text of a file beside the tables. It belongs to the repository, not to the package: it is read when the test
/// runs.
fn text(name: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/tables/");
    let path = format!("{folder}{name}");
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The rows of a table, without its comment and its header.
fn table(name: &str) -> Vec<String> {
    let text = text(name);
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(str::to_owned).collect()
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A rectangle of the plane x = `x`.
fn upright(x: f64, y: [f64; 2], z: [f64; 2]) -> Vec<DVec3> {
    vec![
        v(x, y[0], z[0]),
        v(x, y[1], z[0]),
        v(x, y[1], z[1]),
        v(x, y[0], z[1]),
    ]
}

/// A rectangle of the plane y = `y`.
fn sideways(y: f64, x: [f64; 2], z: [f64; 2]) -> Vec<DVec3> {
    vec![
        v(x[0], y, z[0]),
        v(x[1], y, z[0]),
        v(x[1], y, z[1]),
        v(x[0], y, z[1]),
    ]
}

/// A rectangle of the plane z = `z`.
fn flat(x: [f64; 2], y: [f64; 2], z: f64) -> Vec<DVec3> {
    vec![
        v(x[0], y[0], z),
        v(x[1], y[0], z),
        v(x[1], y[1], z),
        v(x[0], y[1], z),
    ]
}

/// A strip between two directions `low` and `high`, endless along ±y, cut in two so that no corners are opposite.
fn endless(low: DVec3, high: DVec3) -> [Vec<DVec3>; 2] {
    [DVec3::Y, DVec3::NEG_Y].map(|end| vec![low, high, end])
}
