//! What of a scene is looked at: its box without what merely surrounds it, and points on its surfaces.

use crate::framing::{drawn, extent};
use glam::DVec3;
use rays::{Bounds, World};
use std::collections::HashMap;

/// Points on surfaces by which views from outside are compared.
const POINTS: usize = 1024;
/// Flat regions are told apart by so much of a normal, and by so much of the scene's extent along it.
const TURN: f64 = 1.0 / 8.0;
const STEP: f64 = 1.0 / 1024.0;

/// Triangles that are looked at, at most, to find where the scene is.
const SAMPLED: usize = 50_000;
/// Thousandths of the triangles that may surround the scene on each side.
const CUT: usize = 10;
/// They do where the rest takes less than this part of the whole extent.
const SMALL: f64 = 0.2;

/// The box of nearly all triangles, where it is far smaller than that of all: a few of them, such as a plane of water,
/// then only surround the scene. `None` for other scenes.
pub(super) fn focus(world: &World, around: &[u32]) -> Option<Bounds> {
    let instances = drawn(world, around);
    let count = |instance: u32| world.part(instance).1.triangles().len() as u32;
    let total: usize = instances.clone().map(|i| count(i) as usize).sum();
    let all = instances.flat_map(|i| (0..count(i)).map(move |triangle| (i, triangle)));
    let middle = |(i, triangle)| world.corners(i, triangle).iter().sum::<DVec3>() / 3.0;
    let middles: Vec<DVec3> = all.step_by(total / SAMPLED + 1).map(middle).collect();
    let range = |axis: usize| {
        let mut along: Vec<f64> = middles.iter().map(|middle| middle[axis]).collect();
        along.sort_unstable_by(f64::total_cmp);
        let cut = along.len() * CUT / 1000;
        [along[cut], along[along.len() - 1 - cut]]
    };
    if middles.len() * CUT < 1000 {
        return None;
    }
    let [x, y, z] = [0, 1, 2].map(range);
    let (min, max) = (DVec3::new(x[0], y[0], z[0]), DVec3::new(x[1], y[1], z[1]));
    let bounds = extent(world, around);
    ((max - min).length() < SMALL * (bounds.max - bounds.min).length())
        .then_some(Bounds { min, max })
}

/// A point on a triangle, of which instance and number are given.
pub(super) struct Point {
    pub at: DVec3,
    pub triangle: (u32, u32),
}

/// A triangle's normal, of the length of twice its area.
pub(super) fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*b - *a).cross(*c - *a)
}

/// Points on the surfaces of a scene, by the roots of the areas of the flat regions of its objects: what is detailed
/// counts for more than its area, and what is large for more than its number. Into how many triangles a region is cut
/// does not count.
pub(super) fn points(world: &World, around: &[u32]) -> Vec<Point> {
    let triangles = drawn(world, around).flat_map(|instance| {
        let count = world.part(instance).1.triangles().len() as u32;
        (0..count).map(move |triangle| ((instance, triangle), world.corners(instance, triangle)))
    });
    let bounds = extent(world, around);
    let [middle, size] = [bounds.center(), bounds.max - bounds.min];
    let apart = (size.length() * STEP).max(f64::MIN_POSITIVE);
    let region = |instance: u32, corners: &[DVec3; 3]| {
        let normal = normal(corners).normalize_or_zero();
        let along = normal.dot(corners.iter().sum::<DVec3>() / 3.0 - middle);
        let turned = (normal / TURN).round().as_ivec3().to_array();
        (instance, turned, (along / apart).round() as i64)
    };
    let area = |corners: &[DVec3; 3]| normal(corners).length();
    let mut regions: HashMap<_, f64> = HashMap::new();
    for ((instance, _), corners) in triangles.clone() {
        *regions.entry(region(instance, &corners)).or_default() += area(&corners);
    }
    let weight = |instance: u32, corners: &[DVec3; 3]| {
        let all = regions.get(&region(instance, corners));
        let all = all.copied().filter(|all| *all > 0.0);
        all.map_or(0.0, |all| area(corners) / all.sqrt())
    };
    let weights = triangles
        .clone()
        .map(|((i, _), corners)| weight(i, &corners));
    let total: f64 = weights.sum();
    let step = total / POINTS as f64;
    let (mut points, mut before) = (Vec::with_capacity(POINTS), 0.0);
    for (triangle, corners) in triangles {
        let [a, b, c] = corners;
        before += weight(triangle.0, &corners);
        while points.len() < POINTS && (points.len() as f64 + 0.5) * step < before {
            // Of a triangle's points each has its own place in it.
            let k = points.len() as f64;
            let [u, v] = [0.754_877_666, 0.569_840_291].map(|turn| (k * turn).fract());
            let root = f64::sqrt(u);
            let at = a + (b - a) * (root * (1.0 - v)) + (c - a) * (root * v);
            points.push(Point { at, triangle });
        }
    }
    points
}
