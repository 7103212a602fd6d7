//! The error of point sets on four exact scenes: RMSE of the diffuse term = C N^-3/4.
//!
//! The scenes are those of the samplers' table in the project's notes on mathematics: an endless wall, a sphere resting
//! on the plane, a sphere aside, a triangle overhead. Each is a predicate on directions from a point, so that nothing
//! but the points is measured; with a footprint, the point moves over a square as a texel's samples do.

use ambient::sampling::{LANES, Mixture, PointSet, Stream, Streams};
use rayon::prelude::*;
use serde::Serialize;

/// A scene that a direction from a point of the plane z = 0 is blocked in, and its exact diffuse term at the origin.
#[derive(Clone, Copy)]
pub struct Occluder {
    /// Its name.
    pub name: &'static str,
    /// Exact value at the origin.
    pub exact: f64,
    blocked: fn([f64; 2], [f64; 3]) -> bool,
}

/// The four scenes.
pub const OCCLUDERS: [Occluder; 4] = [
    Occluder {
        name: "wall",
        exact: 0.853_553_390_593_273_8,
        blocked: |[x, _], d| d[0] > 0.0 && d[2] * (1.0 - x) < d[0],
    },
    Occluder {
        name: "resting sphere",
        exact: 0.284_458_247_200_067_3,
        blocked: |[x, y], d| meets_sphere([0.5 - x, -y, 1.0], 1.0, d),
    },
    Occluder {
        name: "sphere aside",
        exact: 0.957_330_754_136_520_8,
        blocked: |[x, y], d| meets_sphere([1.5 - x, -y, 1.0], 0.5, d),
    },
    Occluder {
        name: "triangle overhead",
        exact: 0.326_380_866_993_873_1,
        blocked: |[x, y], d| {
            let corners = [[-1.0, -1.0, 0.5], [2.0, -0.5, 0.75], [0.0, 2.0, 1.0]];
            let [a, b, c] = corners.map(|p: [f64; 3]| [p[0] - x, p[1] - y, p[2]]);
            let (u, v, w) = (volume(d, a, b), volume(d, b, c), volume(d, c, a));
            (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0)
        },
    },
];

fn meets_sphere(centre: [f64; 3], radius: f64, d: [f64; 3]) -> bool {
    let along = centre[0] * d[0] + centre[1] * d[1] + centre[2] * d[2];
    let square = centre.iter().map(|c| c * c).sum::<f64>();
    along > 0.0 && square - along * along < radius * radius
}

fn volume(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// One measured cell of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Scene.
    pub scene: &'static str,
    /// Point set.
    pub points: &'static str,
    /// Edge of the footprint that the point moves over.
    pub footprint: f64,
    /// Points.
    pub n: u32,
    /// Root mean square error over the randomisations.
    pub rmse: f64,
    /// `rmse * n^(3/4)`.
    pub c: f64,
}

/// The name of a point set in tables.
pub fn name(set: PointSet) -> &'static str {
    match set {
        PointSet::Lattice => "lattice",
        PointSet::Sobol => "owen-sobol",
        PointSet::Random => "random",
    }
}

/// RMSE of `n` points over `16 * batches` randomisations, about the exact value, or about their own mean where the
/// point moves over a footprint of edge `footprint`.
pub fn measure(scene: &Occluder, set: PointSet, n: u32, batches: u32, footprint: f64) -> Row {
    let values: Vec<f64> = (0..batches)
        .into_par_iter()
        .flat_map_iter(|batch| {
            let mut streams = Streams::new(set);
            for lane in 0..LANES {
                let texel = batch * LANES as u32 + lane as u32;
                streams.set(lane, &Stream::new(11, 0, texel, 0, 0));
            }
            let mut open = [0u32; LANES];
            let steps = Streams::blocks(0..n)
                .flat_map(|block| (0..block.steps()).map(move |step| (block, step)));
            for (block, step) in steps {
                if step == 0 {
                    streams.enter(block);
                }
                let [u0, u1, s, t] = streams.point(step);
                let (d, _) = Mixture::COSINE.sample16(&u0, &u1);
                for lane in 0..LANES {
                    let at = [s, t].map(|v| footprint * (f64::from(v[lane]) - 0.5));
                    let d = d.map(|row| f64::from(row[lane]));
                    open[lane] += u32::from(!(scene.blocked)(at, d));
                }
            }
            open.map(|count| f64::from(count) / f64::from(n))
        })
        .collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let truth = if footprint == 0.0 { scene.exact } else { mean };
    let rmse = (values.iter().map(|v| (v - truth).powi(2)).sum::<f64>() / count).sqrt();
    Row {
        scene: scene.name,
        points: name(set),
        footprint,
        n,
        rmse,
        c: rmse * f64::from(n).powf(0.75),
    }
}
