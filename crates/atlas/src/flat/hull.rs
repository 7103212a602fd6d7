//! Convex hulls of points in a plane, and the narrowest boxes about them.

use crate::flatten::Welded;
use glam::{DVec2, DVec3};

/// The convex hull of points in the plane of a triangle, and the area of the narrowest box about it.
pub(super) fn hull_in(surface: &Welded, plane: u32, points: Vec<DVec3>) -> (Vec<DVec3>, f64) {
    let normal = surface.normals[plane as usize];
    let (u, v) = normal.any_orthonormal_pair();
    let flat = points.iter().map(|p| DVec2::new(p.dot(u), p.dot(v)));
    let hull = hull(flat.collect());
    let area = narrowest(&hull).1;
    let height = points.first().map_or(0.0, |p| p.dot(normal));
    let solid = |p: &DVec2| u * p.x + v * p.y + normal * height;
    (hull.iter().map(solid).collect(), area)
}

/// The turn after which the box around a convex hull has the least area, which it has with a side along an edge, and
/// that area.
pub(super) fn narrowest(hull: &[DVec2]) -> (DVec2, f64) {
    let turns = (0..hull.len()).map(|i| {
        let edge = (hull[(i + 1) % hull.len()] - hull[i]).normalize_or(DVec2::X);
        let turn = DVec2::new(edge.x, -edge.y);
        let turned = || hull.iter().map(|p| turn.rotate(*p));
        let low = turned().fold(DVec2::INFINITY, DVec2::min);
        let high = turned().fold(DVec2::NEG_INFINITY, DVec2::max);
        (turn, (high - low).element_product())
    });
    let least = turns.min_by(|a, b| a.1.total_cmp(&b.1));
    least.unwrap_or((DVec2::X, 0.0))
}

/// The convex hull of points, turning left.
pub(super) fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull: Vec<DVec2> = Vec::new();
    let back: Vec<DVec2> = points.iter().rev().copied().collect();
    for way in [points, back] {
        let first = hull.len();
        for p in way {
            let bends_right = |hull: &[DVec2]| {
                let [a, b] = [hull[hull.len() - 2], hull[hull.len() - 1]];
                (b - a).perp_dot(p - b) <= 0.0
            };
            while hull.len() >= first + 2 && bends_right(&hull) {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    }
    hull
}
