//! T5: smooth bodies of few faces, alone in the world. A convex one cannot shade itself.

use super::scene;
use crate::exact::polygon_form_factor;
use crate::texels::Error;
use crate::texels::bake::{Lab, PER_EDGE, Texels, largest, score};
use crate::texels::build::{invert, mesh};
use crate::texels::points::Point;
use crate::texels::row::Row;
use crate::texels::score::Score;
use glam::{DVec2, DVec3};
use scene::authored::Mesh;
use std::f64::consts::TAU;

const SIDES: usize = 8;
const HEIGHT: f64 = 2.0;
const TEXELS: Texels = Texels::Unwrapped(128, 16.0);

pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (variant, mesh) in [
        ("prism of 8 sides", prism(true)),
        ("icosphere, 80 faces", icosphere()),
    ] {
        let baked = lab.bake("T5", scene("T5", vec![mesh], vec![])?, TEXELS)?;
        let judged = baked.judge(PER_EDGE, |_| Some(1.0));
        let criterion = (
            "shade on itself: exactly none",
            largest(&judged, |_| true),
            Some(0.0),
        );
        rows.push(lab.row("T5", variant, score(&judged), criterion));
    }
    let mut pipe = prism(false);
    invert(&mut pipe);
    let baked = lab.bake("T5", scene("T5", vec![pipe], vec![])?, TEXELS)?;
    for (variant, criterion, truth) in [
        (
            "inside of a pipe, to its facets' normals",
            "largest error",
            Box::new(|p: &Point| ends(p.position, p.geometric))
                as Box<dyn Fn(&Point) -> f64 + Sync>,
        ),
        (
            "inside of a pipe, to its facets under shading normals",
            "largest error",
            Box::new(|p: &Point| ends(p.position, p.normal)),
        ),
        (
            "inside of a pipe, to the smooth limit",
            "largest error",
            Box::new(|p: &Point| smooth(p.position.z)),
        ),
    ] {
        let judged = baked.judge(PER_EDGE, |point| Some(truth(point)));
        let score: Score = score(&judged);
        rows.push(lab.row("T5", variant, score, (criterion, score.max, None)));
    }
    Ok(rows)
}

fn rim(k: usize) -> DVec2 {
    DVec2::from_angle(TAU * (k % SIDES) as f64 / SIDES as f64)
}

/// A prism of radius 1 and height 2 with normals that run round it; lids have their own.
fn prism(lids: bool) -> Mesh {
    let mut prism = mesh("prism");
    let mut face = |points: &[(DVec3, DVec3)]| {
        let first = prism.positions.len() as u32;
        for (position, normal) in points {
            prism.positions.push(position.as_vec3().to_array());
            prism.normals.push(normal.as_vec3().to_array());
        }
        for k in 2..points.len() as u32 {
            prism.triangles.push([first, first + k - 1, first + k]);
        }
    };
    for k in 0..SIDES {
        let (a, b) = (rim(k), rim(k + 1));
        let (na, nb) = (a.extend(0.0), b.extend(0.0));
        let top = HEIGHT * DVec3::Z;
        face(&[(na, na), (nb, nb), (nb + top, nb), (na + top, na)]);
    }
    if lids {
        let ring = |z: f64, normal: DVec3| (0..SIDES).map(move |k| (rim(k).extend(z), normal));
        face(&ring(HEIGHT, DVec3::Z).collect::<Vec<_>>());
        face(&ring(0.0, DVec3::NEG_Z).rev().collect::<Vec<_>>());
    }
    prism
}

/// An icosahedron, every face cut in four, the corners on the unit sphere, where they are their own normals.
fn icosphere() -> Mesh {
    let golden = 0.5 + 1.25f64.sqrt();
    let mut points = Vec::new();
    for (a, b) in [
        (-1.0, -golden),
        (-1.0, golden),
        (1.0, -golden),
        (1.0, golden),
    ] {
        points.extend([
            DVec3::new(0.0, a, b),
            DVec3::new(a, b, 0.0),
            DVec3::new(b, 0.0, a),
        ]);
    }
    let points: Vec<DVec3> = points.into_iter().map(DVec3::normalize).collect();
    let near = |a: DVec3, b: DVec3| a.distance(b) < 1.1;
    let mut ball = mesh("icosphere");
    let mut add = |corners: [DVec3; 3]| {
        let first = ball.positions.len() as u32;
        for corner in corners {
            ball.positions.push(corner.as_vec3().to_array());
            ball.normals.push(corner.as_vec3().to_array());
        }
        ball.triangles.push([first, first + 1, first + 2]);
    };
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, mut b, mut c] = [points[i], points[j], points[k]];
                if !(near(a, b) && near(b, c) && near(c, a)) {
                    continue;
                }
                if (b - a).cross(c - a).dot(a) < 0.0 {
                    std::mem::swap(&mut b, &mut c);
                }
                let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                    .into_iter()
                    .for_each(&mut add);
            }
        }
    }
    ball
}

/// What a point inside the pipe sees of the sky through its two ends.
fn ends(p: DVec3, normal: DVec3) -> f64 {
    let end = |z: f64| {
        let ring: Vec<DVec3> = (0..SIDES).map(|k| rim(k).extend(z) - p).collect();
        polygon_form_factor(&ring, normal)
    };
    end(0.0) + end(HEIGHT)
}

/// The same inside the round pipe of radius 1, at the height `z`.
///
/// An element of the wall sees the disc that closes the pipe at the distance 2 h with F = (h² + 1/2) / √(h² + 1) - h
/// (J. R. Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", element of a cylinder's inside to its
/// base).
fn smooth(z: f64) -> f64 {
    let end = |distance: f64| {
        let h = 0.5 * distance;
        (h * h + 0.5) / h.hypot(1.0) - h
    };
    end(z) + end(HEIGHT - z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smooth_limit_lies_among_the_facets() {
        // At the middle of a facet the octagon is nearer than the circle, at its edge they meet.
        let edge = ends(rim(0).extend(0.7), -rim(0).extend(0.0));
        assert!(
            (smooth(0.7) - edge).abs() < 0.06,
            "{} and {edge}",
            smooth(0.7)
        );
        assert!((smooth(0.0) - smooth(HEIGHT)).abs() < 1e-15 && smooth(0.0) > 0.5);
        assert_eq!(icosphere().triangles.len(), 80);
    }
}
