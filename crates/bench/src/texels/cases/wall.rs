//! T1: a floor before a long wall. Where samples lie in a texel, and what share of it they stand for.

use super::scene;
use crate::exact::shapes;
use crate::texels::Error;
use crate::texels::bake::{Baked, Lab, PER_EDGE, Texels, score};
use crate::texels::build::{Place, level, sheet};
use crate::texels::points::Point;
use crate::texels::row::Row;
use glam::DVec3;

/// Page edge.
const SIZE: u32 = 64;
/// The floor's chart in texels; its left border, at the foot of the wall, cuts texels at 0.37.
const CHART: [f64; 4] = [4.37, 4.0, 52.37, 36.0];
/// Height of the wall, and how far it reaches to both sides.
const WALL: (f64, f64) = (1.0, 100.0);

/// The floor at a density in texels per unit before its wall.
pub(super) fn bake(lab: &Lab, density: f64, place: Place) -> Result<Baked, Error> {
    let [left, top, right, bottom] = CHART;
    let half = 0.5 * (bottom - top) / density;
    let corners = level([0.0, (right - left) / density], [-half, half], 0.0);
    let mut floor = sheet("floor", SIZE, corners, CHART);
    let (height, reach) = WALL;
    let corners = [
        [0.0, -reach, 0.0],
        [0.0, reach, 0.0],
        [0.0, reach, height],
        [0.0, -reach, height],
    ];
    let mut wall = sheet(
        "wall",
        SIZE,
        corners.map(DVec3::from),
        [56.0, 4.0, 60.0, 60.0],
    );
    place.put(&mut floor);
    place.put(&mut wall);
    lab.bake(
        "T1",
        scene("T1", vec![floor, wall], vec![])?,
        Texels::Authored(SIZE),
    )
}

/// The diffuse term of a point of the floor whose place at home is given. The wall is finite, and so is its
/// formula.
pub(super) fn truth(point: &Point, home: DVec3) -> Option<f64> {
    let (height, reach) = WALL;
    let along = [-reach - home.y, reach - home.y];
    (point.instance == 0 && home.x > 0.0)
        .then(|| shapes::finite_wall(home.x, along, height).diffuse)
}

pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for density in [16.0, 256.0] {
        let baked = bake(lab, density, Place::HOME)?;
        let judged = baked.judge(PER_EDGE, |point| truth(point, point.position));
        let score = score(&judged);
        // The first column of texels lies 0.63 of a texel deep in the chart.
        let deep = (CHART[0].ceil() - CHART[0]) / density;
        let exact = shapes::wall_average(0.0, deep, WALL.0).diffuse;
        let texels: Vec<(f64, f64)> = (CHART[1] as u32..CHART[3] as u32)
            .map(|y| baked.texel([CHART[0] as u32, y]))
            .collect();
        let count = texels.len() as f64;
        let mean = texels.iter().map(|t| t.0).sum::<f64>() / count;
        let std_err = texels.iter().map(|t| t.1 * t.1).sum::<f64>().sqrt() / count;
        let farthest = texels.iter().map(|t| (t.0 - exact).abs());
        rows.push(lab.row(
            "T1",
            format!("{density} texels/unit"),
            score,
            (
                "first column's mean to its clipped average: 3 standard errors",
                (mean - exact).abs(),
                Some(3.0 * std_err),
            ),
        ));
        rows.push(lab.row(
            "T1",
            format!("{density} texels/unit"),
            score,
            (
                "first texels to their clipped average: 0.003 at 4,096 rays",
                farthest.fold(f64::NAN, f64::max),
                Some(lab.noise(0.003)),
            ),
        ));
    }
    Ok(rows)
}
