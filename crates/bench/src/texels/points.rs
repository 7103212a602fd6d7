//! Points of surfaces, spread over texels.

use super::lit::Lit;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A point of a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    /// In the world, on the triangle as rays meet it.
    pub position: DVec3,
    /// Unit normal that the point shades with.
    pub normal: DVec3,
    /// Unit normal of the triangle's front.
    pub geometric: DVec3,
    /// Index of the scene's instance.
    pub instance: u32,
    /// Page of the triangle.
    pub page: u32,
    /// Where it is looked up, in texels.
    pub place: DVec2,
}

/// The points of every triangle on a regular grid of `per_edge`² in each texel that it touches. A triangle between all
/// points of the grid has one at its middle, so that none goes unseen.
pub(super) fn points(lit: &Lit<'_>, per_edge: u32) -> Vec<Point> {
    lit.triangles()
        .into_par_iter()
        .flat_map_iter(|(instance, triangle)| of_triangle(lit, instance, triangle, per_edge))
        .collect()
}

fn of_triangle(lit: &Lit<'_>, instance: u32, triangle: u32, per_edge: u32) -> Vec<Point> {
    let (places, page) = lit.places(instance, triangle);
    let corners = lit.world.corners(instance, triangle);
    let (normals, geometric) = lit.normals(instance, triangle);
    let point = |weights: [f64; 3]| {
        let mix = |v: [DVec3; 3]| v[0] * weights[0] + v[1] * weights[1] + v[2] * weights[2];
        Point {
            position: lit.world.origin() + mix(corners),
            normal: mix(normals).normalize_or_zero(),
            geometric,
            instance,
            page,
            place: places[0] * weights[0] + places[1] * weights[1] + places[2] * weights[2],
        }
    };
    let mut found: Vec<Point> = grid(places, per_edge)
        .filter_map(|place| weights(places, place))
        .map(point)
        .collect();
    if found.is_empty() {
        found.push(point([1.0 / 3.0; 3]));
    }
    found
}

/// The grid over the box of a triangle.
fn grid(places: [DVec2; 3], per_edge: u32) -> impl Iterator<Item = DVec2> {
    let [a, b, c] = places.map(|p| p * f64::from(per_edge));
    let low = a.min(b).min(c).floor().as_i64vec2();
    let high = a.max(b).max(c).ceil().as_i64vec2();
    let step = 1.0 / f64::from(per_edge);
    (low.y..high.y).flat_map(move |y| {
        (low.x..high.x).map(move |x| DVec2::new(x as f64 + 0.5, y as f64 + 0.5) * step)
    })
}

/// Barycentric weights of a place inside a triangle; `None` outside, or where the triangle has no area.
fn weights([a, b, c]: [DVec2; 3], place: DVec2) -> Option<[f64; 3]> {
    let area = (b - a).perp_dot(c - a);
    let second = (place - a).perp_dot(c - a) / area;
    let third = (b - a).perp_dot(place - a) / area;
    let all = [1.0 - second - third, second, third];
    all.iter().all(|w| *w >= 0.0).then_some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_of_two_triangles_has_every_point_of_its_texels_once() {
        let [a, b, c, d] = [[1.0, 1.0], [4.0, 1.0], [4.0, 4.0], [1.0, 4.0]].map(DVec2::from);
        let count = |t: [DVec2; 3]| grid(t, 4).filter(|&p| weights(t, p).is_some()).count();
        let (lower, upper) = (count([a, b, c]), count([a, c, d]));
        // 9 texels of 16 points; the 12 on the diagonal belong to both.
        assert_eq!(lower + upper, 9 * 16 + 12, "{lower} and {upper}");
    }

    #[test]
    fn a_triangle_without_area_has_no_inside() {
        let flat = [DVec2::ZERO, DVec2::ONE, DVec2::splat(2.0)];
        assert_eq!(weights(flat, DVec2::splat(0.5)), None);
    }
}
