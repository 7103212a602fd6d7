//! Probes against answers on paper. What rays bring: the module `effort`; where things end: `limits`.

mod effort;
mod limits;

use crate::fixture::{Sheets, block, placed, room, world};
use crate::{Gather, Probe, Sky, State};
use ambient::harmonics::{basis, count, matt};
use ambient::quadrature::gauss_legendre;
use environment::{IlluminationMap, Image, Projection, SkyMap};
use glam::DVec3;
use rays::{Lamps, Light, Surfaces};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

const ROOT: f64 = 3.544_907_701_811_032; // √4π

/// Calls `with` with what gathers the light of these sheets under a sky.
fn gathering<R>(sheets: &[Sheets], sky: Sky<'_>, with: impl FnOnce(Gather<'_>) -> R) -> R {
    let (world, backend) = world(sheets);
    let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
    with(Gather {
        surfaces: &surfaces,
        backend: backend.as_ref(),
        sky,
        lamps: &lamps,
        lights: &[],
        baked: None,
        bounces: 255,
        max_distance: f32::INFINITY,
        rays: 1024,
        target: None,
        order: 2,
        reach: 10.0,
        seed: 0,
    })
}

fn sheets(places: Vec<[DVec3; 3]>, albedo: f32, emission: f32) -> Sheets {
    Sheets {
        places,
        albedo,
        emission,
        double_sided: false,
        normal: None,
    }
}

/// Something far away that is in nobody's way.
fn speck() -> Sheets {
    let low = DVec3::new(0.0, -1e4, 0.0);
    sheets(block(low, low + 1e-3), 0.0, 0.0)
}

const UNIFORM: Sky<'static> = Sky(&environment::Sky::Uniform([1.0, 0.5, 0.25]));

/// Coefficients of a radiance that is `light` over the sphere: Gauss in z between the heights where it jumps,
/// longitudes between those.
fn quadrature(heights: &[f64], turns: &[f64], light: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let rule = gauss_legendre(32);
    let mut sums = vec![0.0; 16];
    for z in heights.windows(2) {
        for turn in turns.windows(2) {
            for (a, wa) in &rule {
                for (b, wb) in &rule {
                    let z_half = 0.5 * (z[1] - z[0]);
                    let t_half = 0.5 * (turn[1] - turn[0]);
                    let height = z[0] + z_half * (1.0 + a);
                    let (y, x) = (turn[0] + t_half * (1.0 + b)).sin_cos();
                    let r = (1.0 - height * height).sqrt();
                    let direction = DVec3::new(r * x, r * y, height);
                    let value = wa * wb * z_half * t_half * light(direction);
                    for (sum, basis) in sums.iter_mut().zip(basis(direction)) {
                        *sum += value * basis;
                    }
                }
            }
        }
    }
    sums
}

/// Every coefficient of the first channel lies within five of its standard errors, and these are at most `most`.
fn assert_within(probe: &Probe, exact: &[f64], most: f64) {
    for (k, (found, error)) in probe.light.iter().zip(&probe.std_err).enumerate() {
        let off = found.x - exact[k];
        assert!(
            off.abs() <= 5.0 * error.x + 1e-12 && error.x <= most,
            "{k}: {} for {}, stated {}",
            found.x,
            exact[k],
            error.x
        );
    }
}

#[test]
fn an_open_uniform_sky_is_exact() {
    for order in 0..=3 {
        gathering(&[speck()], UNIFORM, |mut gather| {
            gather.order = order;
            let probe = gather.probe(7, DVec3::ZERO);
            assert_eq!(probe.light.len(), count(order));
            let expected = UNIFORM.floor() * ROOT;
            assert!((probe.light[0] - expected).length() < 1e-12);
            for k in 0..count(order) {
                assert!(k == 0 || probe.light[k].length() < 1e-12, "{k}");
                assert!(probe.std_err[k].length() < 1e-12, "{k}");
            }
            assert_eq!(probe.validity, 1.0);
            let far = probe.distance.iter().all(|d| (d[0] - 10.0).abs() < 1e-4);
            assert!(far, "{:?}", probe.distance);
        });
    }
}

#[test]
fn a_mapped_sky_is_its_sum_over_texels() {
    // A bright texel over a gradient.
    let mut image = Image::filled(32, 16, [0.5; 3]);
    for (k, pixel) in image.pixels.iter_mut().enumerate() {
        *pixel = [0.2 + 0.05 * (k / 32) as f32, 0.3, 0.1];
    }
    image.pixels[32 * 5 + 9] = [400.0, 300.0, 200.0];
    let map = IlluminationMap::new(image, Projection::Polar).unwrap();
    let mut exact = vec![0.0; 16];
    // Each texel by 8 x 8 of its cells: the harmonics are smooth, radiance is constant there.
    let fine = (256, 128);
    for y in 0..fine.1 {
        for x in 0..fine.0 {
            let direction = Projection::Polar
                .direction(fine, x as f64 + 0.5, y as f64 + 0.5)
                .unwrap();
            let omega = Projection::Polar.solid_angle(fine, x, y);
            let value = f64::from(map.nearest(direction)[0]) * omega;
            for (sum, basis) in exact.iter_mut().zip(basis(DVec3::from(direction))) {
                *sum += value * basis;
            }
        }
    }
    let sky = environment::Sky::Map(Arc::new(SkyMap::new(&map).unwrap()));
    gathering(&[speck()], Sky(&sky), |mut gather| {
        gather.rays = 16_384;
        gather.order = 3;
        let probe = gather.probe(0, DVec3::ZERO);
        for (k, (found, exact)) in probe.light.iter().zip(&exact).enumerate() {
            // The cells' middles are off by a 256th of the bright texel's own extent, squared.
            let off = (found.x - exact).abs();
            assert!(
                off <= 5.0 * probe.std_err[k].x + 2e-3,
                "{k}: {} for {exact}",
                found.x
            );
        }
    });
}

#[test]
fn beside_an_endless_wall_half_of_the_sky_is_left() {
    let wall = [DVec3::new(1.0, -1e6, -1e6), DVec3::Z * 2e6, DVec3::Y * 2e6];
    gathering(&[sheets(vec![wall], 0.0, 0.0)], UNIFORM, |mut gather| {
        gather.rays = 4096;
        let probe = gather.probe(3, DVec3::ZERO);
        let turns = [FRAC_PI_2, 3.0 * FRAC_PI_2];
        let exact = quadrature(&[-1.0, 0.0, 1.0], &turns, |_| 1.0);
        assert_within(&probe, &exact, 0.01);
        // E / π is (1 - cos θ) / 2 for a normal at θ from the wall. Half a sphere has no even harmonic but the first.
        for degrees in [0.0, 60.0, 90.0, 180.0_f64] {
            let normal = DVec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
            let exact = 0.5 * (1.0 - degrees.to_radians().cos());
            let found = matt(&probe.light, normal).x;
            assert!(
                (found - exact).abs() < 0.01,
                "{degrees}: {found}, not {exact}"
            );
        }
        assert_eq!(probe.validity, 1.0, "its front is seen");
    });
}

#[test]
fn before_a_window_comes_what_the_window_shows() {
    // A black box of 2 with an opening of 1 by 1 in the wall at x = 1, seen from its middle: the frame as four pieces.
    let mut walls = room(DVec3::NEG_ONE, DVec3::ONE);
    walls.retain(|[corner, a, b]| a.cross(*b).x > -0.5 || corner.x < 0.0);
    assert_eq!(walls.len(), 5);
    for (y, z, dy, dz) in [
        (-1.0, -1.0, 2.0, 0.5),
        (-1.0, 0.5, 2.0, 0.5),
        (-1.0, -0.5, 0.5, 1.0),
        (0.5, -0.5, 0.5, 1.0),
    ] {
        walls.push([DVec3::new(1.0, y, z), DVec3::Z * dz, DVec3::Y * dy]);
    }
    gathering(&[sheets(walls, 0.0, 0.0)], UNIFORM, |mut gather| {
        gather.rays = 16_384;
        let probe = gather.probe(0, DVec3::ZERO);
        // Solid angle of a square of edge 2a at distance d: 4 asin(a² / (a² + d²)).
        let (a, d) = (0.5_f64, 1.0_f64);
        let angle = 4.0 * (a * a / (a * a + d * d)).asin();
        let mean = angle / ROOT;
        assert!((probe.light[0].x - mean).abs() < 5.0 * probe.std_err[0].x);
        // E toward the window is π times the form factor of a parallel square.
        let (x, root) = (a / d, (1.0 + (a / d).powi(2)).sqrt());
        let factor = 4.0 * (x / root * (x / root).atan()) / PI;
        // The first order alone carries ∫ x dω = E.
        let first = probe.light[3].x;
        let exact = (3.0 / (4.0 * PI)).sqrt() * PI * factor;
        assert!(
            (first - exact).abs() < 5.0 * probe.std_err[3].x,
            "{first}, not {exact}"
        );
        assert!(probe.std_err[3].x < 0.01);
        let sky = &probe.parts[0];
        assert_eq!(sky, &probe.light, "black surfaces send nothing");
    });
}

#[test]
fn a_closed_box_is_dark_and_a_solid_is_no_place() {
    let mut walls = room(DVec3::NEG_ONE, DVec3::ONE);
    // What stands in it makes it a room.
    walls.extend(block(DVec3::splat(-0.9), DVec3::splat(-0.7)));
    let closed = sheets(walls, 0.8, 0.0);
    let solid = sheets(block(DVec3::splat(-0.5), DVec3::splat(0.5)), 0.8, 0.0);
    let outside = Light::point([5.0, 0.0, 0.0], [100.0; 3]);
    gathering(&[closed], UNIFORM, |gather| {
        let gather = Gather {
            lights: &[outside],
            ..gather
        };
        let probe = gather.probe(0, DVec3::new(0.1, 0.2, 0.3));
        assert!(probe.light.iter().all(|value| *value == DVec3::ZERO));
        assert!(probe.std_err.iter().all(|value| *value == DVec3::ZERO));
        assert_eq!(probe.validity, 1.0, "a room is no solid");
    });
    gathering(&[solid], UNIFORM, |gatherer| {
        let inside = DVec3::new(0.3, 0.1, 0.0);
        assert_eq!(gatherer.probe(0, inside).validity, 0.0);
        let found = placed(&gatherer, &[inside], 0, 0.0);
        assert_eq!(found[0].state, State::Invalid);
        let found = placed(&gatherer, &[inside, DVec3::X], 0, 0.5);
        let moved = &found[0];
        assert_eq!(moved.state, State::Moved);
        assert!(
            (moved.probe.place.x - 0.55).abs() < 1e-6,
            "{}",
            moved.probe.place
        );
        assert_eq!((moved.asked, found[1].state), (inside, State::There));
    });
}

#[test]
fn the_inside_of_a_pillar_is_no_place_though_both_sides_are_drawn() {
    // A pillar without ends between a ground and a lintel is no closed body. Light creeps in below it, and none comes
    // to a dark room.
    let mut pillar = block(DVec3::new(-0.5, 0.02, -0.5), DVec3::new(0.5, 2.0, 0.5));
    pillar.retain(|[_, a, b]| a.cross(*b).y.abs() < 0.5);
    let ground = [
        DVec3::new(-9.0, 0.0, -9.0),
        DVec3::Z * 18.0,
        DVec3::X * 18.0,
    ];
    let mut all = sheets(pillar, 0.5, 0.0);
    all.places.push(ground);
    all.places.extend(block(
        DVec3::new(-3.0, 2.0, -0.5),
        DVec3::new(3.0, 2.5, 0.5),
    ));
    all.double_sided = true;
    // What stands in it makes it a room.
    let mut walls = room(DVec3::new(20.0, 0.0, 0.0), DVec3::new(22.0, 2.0, 2.0));
    walls.extend(block(
        DVec3::new(20.1, 0.1, 0.1),
        DVec3::new(20.3, 0.3, 0.3),
    ));
    let dark = Sheets {
        double_sided: true,
        ..sheets(walls, 0.5, 0.0)
    };
    gathering(&[all, dark], UNIFORM, |gatherer| {
        let places = [
            DVec3::new(0.2, 1.0, 0.1),
            DVec3::new(1.2, 1.0, 0.1),
            DVec3::new(21.0, 1.0, 1.0),
        ];
        assert_ne!(gatherer.probe(0, places[0]).light[0], DVec3::ZERO);
        let found = placed(&gatherer, &places, 0, 1.0);
        let states: Vec<State> = found.iter().map(|placed| placed.state).collect();
        assert_eq!(states, [State::Moved, State::There, State::There]);
        let moved = found[0].probe.place;
        assert!((moved.x - 0.6).abs() < 1e-6, "{moved}");
    });
}

#[test]
fn a_furnace_is_the_geometric_sum() {
    for (albedo, bounces) in [(0.5_f32, 255), (0.5, 2), (0.5, 0), (0.9, 255)] {
        let furnace = sheets(room(DVec3::NEG_ONE, DVec3::splat(2.0)), albedo, 1.0);
        gathering(&[furnace], UNIFORM, |mut gather| {
            gather.bounces = bounces;
            gather.rays = 256;
            let rho = f64::from(albedo);
            let sum: f64 = (0..=bounces).map(|k| rho.powi(k as i32)).sum();
            let exact = [&[sum * ROOT][..], &[0.0; 8]].concat();
            let place = DVec3::new(0.1, 0.2, 0.3);
            let probes: Vec<Probe> = (0..100).map(|k| gather.probe(k, place)).collect();
            for (k, exact) in exact.iter().enumerate() {
                let mean = probes.iter().map(|p| p.light[k].x).sum::<f64>() / 100.0;
                let errors = probes.iter().map(|p| p.std_err[k].x.powi(2));
                let error = errors.sum::<f64>().sqrt() / 100.0;
                let off = (mean - exact).abs();
                assert!(
                    off <= 4.0 * error && error < 0.01 * sum * ROOT,
                    "albedo {albedo}, {bounces} bounces, {k}: {mean} for {exact}, stated {error}"
                );
            }
        });
    }
}

#[test]
fn baked_light_is_taken_where_it_is_and_lights_are_seen_where_nothing_hides_them() {
    let wall = [
        DVec3::new(1.0, -50.0, -50.0),
        DVec3::Z * 100.0,
        DVec3::Y * 100.0,
    ];
    let black = Sky(&environment::Sky::BLACK);
    gathering(&[sheets(vec![wall], 0.5, 0.0)], black, |gather| {
        let baked = |_: &rays::SurfaceHit| Some(DVec3::new(0.0, 0.5, 1.0));
        let lights = [
            Light::sun([0.0, 1.0, 0.0], [PI; 3]),
            Light::sun([1.0, 0.0, 0.0], [PI; 3]),
            Light::sphere([-3.0, 0.0, 0.0], 1.0, [2.0; 3]),
        ];
        let gather = Gather {
            baked: Some(&baked),
            lights: &lights,
            ..gather
        };
        let probe = gather.probe(0, DVec3::ZERO);
        let (lit, surfaces) = (&probe.parts[1], &probe.parts[2]);
        // The wall takes nearly half of the sphere, and hides the second sun. The ball takes a cone of sine 1/3.
        assert!((surfaces[0].z - 0.5 * ROOT).abs() < 0.05, "{}", surfaces[0]);
        assert!((2.0 * surfaces[0].y - surfaces[0].z).abs() < 1e-12);
        let ball = 2.0 * TAU * (1.0 - (8.0_f64 / 9.0).sqrt());
        assert!((lit[0].x * ROOT - PI - ball).abs() < 1e-9, "{}", lit[0]);
        // Behind its back it is not there.
        let behind = gather.probe(0, DVec3::new(1.5, 0.0, 0.0));
        assert_eq!(behind.parts[2][0], DVec3::ZERO);
        assert!((behind.validity - 0.5).abs() < 0.01, "{}", behind.validity);
    });
}

#[test]
fn reflections_of_a_half_are_those_on_paper() {
    // A white wall on one side of a black sky: the lobes see the share of them that the wall takes.
    let wall = [DVec3::new(1.0, -1e5, -1e5), DVec3::Z * 2e5, DVec3::Y * 2e5];
    let black = Sky(&environment::Sky::BLACK);
    gathering(&[sheets(vec![wall], 0.0, 2.0)], black, |gather| {
        let place = DVec3::new(0.5, 0.0, 0.0);
        let halves = [0, 1].map(|half| {
            let face = |face| gather.capture(0, [half, face], place, 32, &()).unwrap();
            Image {
                width: 32,
                height: 6 * 32,
                pixels: (0..6).flat_map(face).collect(),
            }
        });
        let found = gather.reflection(place, halves);
        let sizes: Vec<usize> = found.levels.iter().map(|level| level.image.width).collect();
        assert_eq!(sizes, [32, 16, 8]);
        let roughness: Vec<f64> = found.levels.iter().map(|level| level.roughness).collect();
        assert_eq!(roughness, [0.0, 0.5, 1.0]);
        for level in found.levels.iter().chain([&found.diffuse]) {
            let map = IlluminationMap::new(level.image.clone(), Projection::Cube).unwrap();
            // Half of every lobe at right angles, by symmetry, whatever it is.
            let side = f64::from(map.bilinear([0.0, 1.0, 0.0])[0]);
            assert!((side - 1.0).abs() < 0.02, "{}: {side}", level.roughness);
            let [toward, away] = [1.0, -1.0].map(|x| f64::from(map.bilinear([x, 0.0, 0.0])[0]));
            // All of it is seen together from both sides.
            assert!(
                (toward + away - 2.0).abs() < 0.02 && away < 0.1,
                "{toward} {away}"
            );
            assert!(level.error < 0.05, "{}", level.error);
        }
        assert!((found.walls[0] - 0.5).abs() < 1e-6 && found.walls[1].is_infinite());
        let matt = IlluminationMap::new(found.diffuse.image, Projection::Cube).unwrap();
        // E / π of a half-space is L (1 + cos θ) / 2.
        let slant = f64::from(matt.bilinear([0.6, 0.8, 0.0])[0]);
        assert!((slant - 1.6).abs() < 0.02, "{slant}");
    });
}
