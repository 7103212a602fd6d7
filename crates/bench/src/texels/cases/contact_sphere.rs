//! T2: a sphere that touches the floor. Light that creeps under it shows an offset that is too large.

use super::scene;
use crate::exact::round;
use crate::texels::Error;
use crate::texels::bake::{Lab, PER_EDGE, STEP, Texels, largest, score};
use crate::texels::build::{level, mesh, polygon, sheet};
use crate::texels::points::Point;
use crate::texels::row::Row;
use glam::{DVec2, DVec3};
use scene::authored::Mesh;
use std::f64::consts::{PI, TAU};

const SIZE: u32 = 128;
/// Texels per unit of the floor.
const DENSITY: f64 = 64.0;
const RADIUS: f64 = 0.5;
/// Where the sphere touches, in texels of the page; off the grid.
const CONTACT: DVec2 = DVec2::new(36.2, 36.7);
const SECTORS: usize = 256;
const RINGS: usize = 128;
/// Length of rays in the variant with a limit.
const REACH: f64 = 0.25;

pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, Error> {
    let low = (DVec2::splat(4.0) - CONTACT) / DENSITY;
    let high = (DVec2::splat(68.0) - CONTACT) / DENSITY;
    let floor = || {
        let corners = level([low.x, high.x], [low.y, high.y], 0.0);
        sheet("floor", SIZE, corners, [4.0, 4.0, 68.0, 68.0])
    };
    let near = 2.0 / DENSITY;
    let distance = |point: &Point| point.position.truncate().length();
    let mut rows = Vec::new();
    for (variant, reach) in [("unlimited rays", None), ("rays of 0.25", Some(REACH))] {
        let made = scene("T2", vec![floor(), sphere()], vec![])?;
        let baked = lab.bake_with("T2", made, Texels::Authored(SIZE), |options| {
            options.max_distance = reach.map(|r| r as f32);
        })?;
        let judged = baked.judge(PER_EDGE, |point| {
            let rho = distance(point);
            let exact = || match reach {
                None => round::resting_sphere(RADIUS, rho).diffuse,
                Some(reach) => within_reach(rho, reach),
            };
            (point.instance == 0).then(exact)
        });
        rows.push(lab.row(
            "T2",
            variant,
            score(&judged),
            (
                "error within 2 texels of the contact: 1/255 at 4,096 rays and the facets'",
                largest(&judged, |j| distance(&j.point) < near),
                Some(lab.noise(STEP) + facets(near)),
            ),
        ));
    }
    Ok(rows)
}

/// The diffuse term at `rho` from the contact where rays end after `reach`.
///
/// A ray meets the sphere first at a distance between d - r (d the distance of the centre) and rho (a tangent). A reach
/// of rho or more sees all of it. A shorter one sees a cone about the centre: by the law of cosines the ray at the
/// angle t from it meets the surface at `reach` where cos t = (reach² + d² - r²) / (2 reach d), and d² = rho² + r². The
/// cone stands above the horizon, so it takes away sin² t times the cosine of the centre's zenith, r / d.
fn within_reach(rho: f64, reach: f64) -> f64 {
    if rho <= reach {
        return round::resting_sphere(RADIUS, rho).diffuse;
    }
    let d = rho.hypot(RADIUS);
    let cosine = (reach * reach + rho * rho) / (2.0 * reach * d);
    1.0 - (1.0 - cosine * cosine).max(0.0) * RADIUS / d
}

/// What the facets change at most within a distance of the contact: the polyhedron lies between the sphere and the
/// concentric one that all its faces touch.
fn facets(near: f64) -> f64 {
    let inner = RADIUS * (PI / SECTORS as f64).cos() * (0.5 * PI / RINGS as f64).cos();
    let change = |rho: f64| {
        let zenith = rho.atan2(RADIUS);
        round::sphere(inner, rho.hypot(RADIUS), zenith).diffuse
            - round::resting_sphere(RADIUS, rho).diffuse
    };
    let all = (0..=64).map(|k| change(near * f64::from(k) / 64.0));
    all.fold(0.0, f64::max)
}

/// The sphere, a pole on the floor; its picture is a small map of latitude and longitude.
fn sphere() -> Mesh {
    let mut sphere = mesh("sphere");
    let at = |i: usize, j: usize| {
        let (polar, turn) = (
            PI * j as f64 / RINGS as f64,
            TAU * (i % SECTORS) as f64 / SECTORS as f64,
        );
        // Twice the squared sine keeps the digits near the contact.
        let height = 2.0 * (0.5 * polar).sin().powi(2);
        let flat = if j == 0 || j == RINGS {
            0.0
        } else {
            polar.sin()
        };
        DVec3::new(flat * turn.cos(), flat * turn.sin(), height) * RADIUS
    };
    let place = |i: f64, j: usize| {
        DVec2::new(
            76.0 + 48.0 * i / SECTORS as f64,
            4.0 + 24.0 * j as f64 / RINGS as f64,
        )
    };
    for j in 0..RINGS {
        for i in 0..SECTORS {
            let (x, y) = (i as f64, i as f64 + 1.0);
            let (corners, places) = if j == 0 {
                (
                    vec![at(i, 0), at(i + 1, 1), at(i, 1)],
                    vec![place(x + 0.5, 0), place(y, 1), place(x, 1)],
                )
            } else if j == RINGS - 1 {
                (
                    vec![at(i, j), at(i + 1, j), at(i, RINGS)],
                    vec![place(x, j), place(y, j), place(x + 0.5, RINGS)],
                )
            } else {
                (
                    vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)],
                    vec![place(x, j), place(y, j), place(y, j + 1), place(x, j + 1)],
                )
            };
            polygon(&mut sphere, SIZE, &corners, &places);
        }
    }
    sphere
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reach_of_the_tangent_sees_the_whole_sphere_and_a_shorter_one_less() {
        for rho in [0.05, 0.1, 0.5, 2.0] {
            let whole = round::resting_sphere(RADIUS, rho).diffuse;
            let limited = within_reach(rho, rho * (1.0 - 1e-9));
            assert!(
                (limited - whole).abs() < 1e-8,
                "{rho}: {limited} and {whole}"
            );
            let nearest = rho.hypot(RADIUS) - RADIUS;
            assert!(within_reach(rho, 0.5 * (nearest + rho)) > whole);
            assert_eq!(within_reach(rho, 0.99 * nearest), 1.0);
        }
        assert!(facets(0.03) < 1e-3, "{}", facets(0.03));
    }
}
