//! Round shapes: the light of a pinhole, and the contact of a sphere that rests beside the point.

use crate::exact::{Open, round};
use crate::hard::case::{Case, shaped};
use crate::hard::setup::Setup;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

pub(super) fn cases() -> Vec<Case> {
    let pinhole = |name, radius: f64, table| {
        const SIDES: usize = 512;
        let at = |i: usize, r: f64, z: f64| {
            let (y, x) = (TAU * (i % SIDES) as f64 / SIDES as f64).sin_cos();
            [r * x, r * y, z]
        };
        let setup = (0..SIDES).fold(Setup::at(0.0, 1e-2 * radius), |setup, i| {
            setup
                .quad([
                    at(i, radius, 1.0),
                    at(i, 2.0, 1.0),
                    at(i + 1, 2.0, 1.0),
                    at(i + 1, radius, 1.0),
                ])
                .quad([
                    at(i, 2.0, -1.0),
                    at(i + 1, 2.0, -1.0),
                    at(i + 1, 2.0, 1.0),
                    at(i, 2.0, 1.0),
                ])
        });
        let tangent = radius;
        let cosine2 = 1.0 / (1.0 + tangent * tangent);
        let open = Open {
            visibility: tangent * tangent * cosine2 / (1.0 + cosine2.sqrt()),
            diffuse: tangent * tangent * cosine2,
        };
        shaped(name, setup, open, false, Some((table, false)))
    };
    let resting = |name, rho: f64, table| {
        const SECTORS: usize = 192;
        let mut angles = vec![0.0];
        angles.extend(
            (0..)
                .map(|k| 1e-5 * 1.1f64.powi(k))
                .take_while(|&a| a < 3.0),
        );
        angles.push(PI);
        let at = |a: f64, i: usize| {
            let (y, x) = (TAU * (i % SECTORS) as f64 / SECTORS as f64).sin_cos();
            let half = (0.5 * a).sin();
            DVec3::new(a.sin() * x, a.sin() * y, 2.0 * half * half)
        };
        let mut setup = Setup::at(rho, 1e-2 * rho);
        for ring in angles.windows(2) {
            for i in 0..SECTORS {
                let [a, b, c, d] = [
                    at(ring[0], i),
                    at(ring[0], i + 1),
                    at(ring[1], i + 1),
                    at(ring[1], i),
                ];
                if ring[0] > 0.0 {
                    setup.blockers.push([a, c, b]);
                }
                if ring[1] < PI {
                    setup.blockers.push([a, d, c]);
                }
            }
        }
        shaped(
            name,
            setup,
            round::resting_sphere(1.0, rho),
            true,
            Some((table, false)),
        )
    };
    vec![
        pinhole(
            "pinhole of radius 0.1",
            0.1,
            "closed box with round hole radius 1e-1 overhead at height 1",
        ),
        pinhole(
            "pinhole of radius 1e-3",
            1e-3,
            "closed box with round hole radius 1e-3 overhead at height 1",
        ),
        resting(
            "resting sphere, rho 1e-2",
            1e-2,
            "unit sphere resting, rho=1e-2",
        ),
        resting(
            "resting sphere, rho 1e-3",
            1e-3,
            "unit sphere resting, rho=1e-3",
        ),
    ]
}
