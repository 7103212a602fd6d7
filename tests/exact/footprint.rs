//! Averages over texel footprints: each receiver triangle is cut to each texel's square, then integrated to about 1e-6.

use super::mesh::Mesh;
use super::polygon::Shares;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// A point of a receiver.
#[derive(Clone, Copy)]
pub struct Point {
    pub position: DVec3,
    pub normal: DVec3,
    pub geometric: DVec3,
}

/// The exact answer of one texel.
#[derive(Clone, Copy, Default)]
pub struct Texel {
    /// Area of the footprint in texels.
    pub coverage: f64,
    pub mean: Shares,
}

/// For every texel (column, row) of a page of `size` texels that a receiver meets: the mean of `value` over its
/// footprint. Objects named `receiver…` are receivers.
pub fn averages(
    mesh: &Mesh,
    size: usize,
    value: &(dyn Fn(&Point) -> Shares + Sync),
) -> BTreeMap<(usize, usize), Texel> {
    use rayon::prelude::*;
    let mut pieces = Vec::new();
    for face in mesh
        .faces
        .iter()
        .filter(|face| face.object.starts_with("receiver"))
    {
        let geometric = face.normal();
        for k in 1..face.points.len() - 1 {
            let ids = [0, k, k + 1];
            let triangle = Triangle {
                uv: ids.map(|i| face.uvs[i] * size as f64),
                points: ids.map(|i| face.points[i]),
                normals: ids.map(|i| face.normals.get(i).copied().unwrap_or(geometric)),
                geometric,
            };
            let low = triangle.uv[0]
                .min(triangle.uv[1])
                .min(triangle.uv[2])
                .floor();
            let high = triangle.uv[0]
                .max(triangle.uv[1])
                .max(triangle.uv[2])
                .ceil();
            for y in low.y as usize..high.y as usize {
                for x in low.x as usize..high.x as usize {
                    let part = clip(&triangle.uv, DVec2::new(x as f64, y as f64));
                    for j in 1..part.len().max(2) - 1 {
                        let corners = [part[0], part[j], part[j + 1]];
                        if area(&corners) > 1e-12 {
                            pieces.push(((x, y), triangle, corners));
                        }
                    }
                }
            }
        }
    }
    let sums: Vec<_> = pieces
        .par_iter()
        .map(|(texel, triangle, corners)| {
            let at = |uv: DVec2| value(&triangle.at(uv));
            (
                *texel,
                area(corners),
                refine(&at, corners, rule(&at, corners), 1.0),
            )
        })
        .collect();
    let mut texels: BTreeMap<_, Texel> = BTreeMap::new();
    for (texel, area, mean) in sums {
        let entry = texels.entry(texel).or_default();
        entry.coverage += area;
        entry.mean += mean * area;
    }
    for texel in texels.values_mut() {
        texel.mean = texel.mean * (1.0 / texel.coverage);
    }
    texels
}

#[derive(Clone, Copy)]
struct Triangle {
    uv: [DVec2; 3],
    points: [DVec3; 3],
    normals: [DVec3; 3],
    geometric: DVec3,
}

impl Triangle {
    fn at(&self, uv: DVec2) -> Point {
        let [a, b, c] = self.uv;
        let whole = (b - a).perp_dot(c - a);
        let weights = [
            (b - uv).perp_dot(c - uv) / whole,
            (c - uv).perp_dot(a - uv) / whole,
        ];
        let mix = |v: [DVec3; 3]| {
            v[0] * weights[0] + v[1] * weights[1] + v[2] * (1.0 - weights[0] - weights[1])
        };
        Point {
            position: mix(self.points),
            normal: mix(self.normals).normalize(),
            geometric: self.geometric,
        }
    }
}

/// The part of a polygon inside the unit square at `low`.
fn clip(polygon: &[DVec2], low: DVec2) -> Vec<DVec2> {
    let mut part = polygon.to_vec();
    let sides = [
        (DVec2::X, low.x),
        (-DVec2::X, -low.x - 1.0),
        (DVec2::Y, low.y),
        (-DVec2::Y, -low.y - 1.0),
    ];
    for (direction, limit) in sides {
        let mut kept = Vec::with_capacity(part.len() + 1);
        for (k, &a) in part.iter().enumerate() {
            let b = part[(k + 1) % part.len()];
            let (inside_a, inside_b) = (direction.dot(a) - limit, direction.dot(b) - limit);
            if inside_a >= 0.0 {
                kept.push(a);
            }
            if (inside_a >= 0.0) != (inside_b >= 0.0) {
                kept.push(a + (b - a) * (inside_a / (inside_a - inside_b)));
            }
        }
        part = kept;
    }
    part
}

fn area(corners: &[DVec2; 3]) -> f64 {
    0.5 * (corners[1] - corners[0])
        .perp_dot(corners[2] - corners[0])
        .abs()
}

/// The mean over a triangle that is `share` of the first one, split until halving its edges moves that one's mean by
/// less than 1e-6.
fn refine(at: &dyn Fn(DVec2) -> Shares, corners: &[DVec2; 3], rough: Shares, share: f64) -> Shares {
    let [a, b, c] = *corners;
    let (ab, bc, ca) = (a.midpoint(b), b.midpoint(c), c.midpoint(a));
    let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]];
    let means = parts.map(|part| rule(at, &part));
    let fine = means
        .iter()
        .fold(Shares::default(), |sum, mean| sum + *mean * 0.25);
    let moved = fine + rough * -1.0;
    let moved = moved
        .visibility
        .abs()
        .max(moved.diffuse.abs())
        .max(moved.specular.abs());
    if moved * share < 1e-6 {
        return fine;
    }
    (0..4).fold(Shares::default(), |sum, k| {
        sum + refine(at, &parts[k], means[k], 0.25 * share) * 0.25
    })
}

/// Radon's seven-point rule, exact to degree 5: the mean over a triangle.
fn rule(at: &dyn Fn(DVec2) -> Shares, [a, b, c]: &[DVec2; 3]) -> Shares {
    let root = 15.0_f64.sqrt();
    let mut sum = at((*a + *b + *c) / 3.0) * (9.0 / 40.0);
    for (near, weight) in [
        ((6.0 - root) / 21.0, (155.0 - root) / 1200.0),
        ((6.0 + root) / 21.0, (155.0 + root) / 1200.0),
    ] {
        let far = 1.0 - 2.0 * near;
        for [p, q, r] in [[a, b, c], [b, c, a], [c, a, b]] {
            sum += at(*p * far + *q * near + *r * near) * weight;
        }
    }
    sum
}
