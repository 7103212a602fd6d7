//! What lights bring to a surface, against answers known on paper.

use super::*;
use std::f64::consts::PI;

#[test]
fn a_facing_light_of_irradiance_pi_shows_the_albedo() {
    let albedo = DVec3::new(0.5, 0.25, 1.0);
    let sun = Light::Distant {
        toward: DVec3::Z,
        irradiance: DVec3::splat(PI),
    };
    let arrival = sun.at(DVec3::ZERO, [0.5; 2]);
    assert_eq!(arrival.diffuse(DVec3::Z, albedo), albedo);
    assert_eq!(arrival.diffuse(DVec3::NEG_Z, albedo), DVec3::ZERO);
    assert_eq!(arrival.diffuse(DVec3::X, albedo), DVec3::ZERO);
    let slant = DVec3::new(0.8, 0.0, 0.6);
    assert_eq!(arrival.diffuse(slant, albedo), albedo * 0.6);
}

#[test]
fn a_point_light_falls_with_the_square_of_the_distance() {
    let lamp = Light::point([0.0, 0.0, 4.0], [8.0, 4.0, 0.0]);
    let arrival = lamp.at(DVec3::ZERO, [0.5; 2]);
    assert_eq!(arrival.irradiance, DVec3::new(0.5, 0.25, 0.0));
    assert_eq!(arrival.distance, 4.0);
    assert_eq!(
        lamp.at(DVec3::new(0.0, 0.0, 4.0), [0.5; 2]).irradiance,
        DVec3::ZERO
    );
}

/// The mean over all draws of what a surface of this unit normal at the origin receives.
fn received(light: &Light, normal: DVec3) -> f64 {
    const CELLS: usize = 400;
    let middle = |k: usize| (k as f64 + 0.5) / CELLS as f64;
    let of = |cell: usize| {
        let u = [middle(cell / CELLS), middle(cell % CELLS)];
        let arrival = light.at(DVec3::ZERO, u);
        arrival.irradiance.x * normal.dot(arrival.toward).max(0.0)
    };
    (0..CELLS * CELLS).map(of).sum::<f64>() / (CELLS * CELLS) as f64
}

#[test]
fn a_ball_above_the_horizon_brings_pi_times_the_square_of_its_sine_times_the_cosine() {
    for (distance, radius, degrees) in [
        (2.0, 1.0, 0.0),
        (2.0, 1.0, 50.0),
        (1.001, 1.0, 0.0),
        (1e4, 0.5, 80.0_f64),
    ] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let place = [distance * sine, 0.0, distance * cosine];
        let ball = Light::sphere(place, radius, [3.0; 3]);
        let exact = PI * 3.0 * (radius / distance).powi(2) * cosine;
        let found = received(&ball, DVec3::Z);
        assert!(
            (found / exact - 1.0).abs() < 1e-5,
            "{distance} {degrees}: {found}, not {exact}"
        );
    }
    // Half below the horizon, by J. R. Howell's catalogue of configuration factors.
    let half = Light::sphere([2.0, 0.0, 0.0], 1.0, [1.0; 3]);
    let (h, root) = (2.0_f64, 3.0_f64.sqrt());
    let exact = (1.0 / root).atan() - root / (h * h);
    let found = received(&half, DVec3::Z);
    assert!((found / exact - 1.0).abs() < 1e-4, "{found}, not {exact}");
    // The way ends on the ball, and within it is no light.
    let arrival = Light::sphere([0.0, 0.0, 4.0], 1.0, [1.0; 3]).at(DVec3::ZERO, [0.0, 0.0]);
    assert!((arrival.distance - 3.0).abs() < 1e-12, "{arrival:?}");
    let within = Light::sphere([0.1, 0.0, 0.0], 1.0, [1.0; 3]);
    assert_eq!(within.at(DVec3::ZERO, [0.5; 2]).irradiance, DVec3::ZERO);
    let found = within.open(DVec3::ZERO, DVec3::X);
    assert_eq!(found, Some(DVec3::ZERO));
    let ball = Light::sphere([0.0, 0.0, 4.0], 1.0, [3.0; 3]);
    let found = ball.open(DVec3::ZERO, DVec3::Z).expect("a ball").x;
    assert!((found - 3.0 / 16.0).abs() < 1e-12, "{found}");
}

#[test]
fn lights_of_a_file_are_taken_at_their_strength_and_shine_where_it_says() {
    let light = |kind| scene::Light {
        name: String::new(),
        kind,
        strength: DVec3::new(3.0, 2.0, 1.0),
        range: 5.0,
        position: DVec3::new(0.0, 0.0, 2.0),
        direction: DVec3::NEG_Z,
    };
    let sun = Light::from(&light(LightKind::Directional));
    let exact = Light::sun([0.0, 0.0, 1.0], [3.0, 2.0, 1.0]);
    assert_eq!(sun, exact);
    let (inner, outer) = (0.2, 0.6);
    let spot = Light::from(&light(LightKind::Spot { inner, outer }));
    // Below it at a distance of 2 of 5: a quarter of its candela, less the share of the range.
    let found = spot.at(DVec3::ZERO, [0.5; 2]).irradiance;
    let exact = DVec3::new(3.0, 2.0, 1.0) / 4.0 * (1.0 - (2.0f64 / 5.0).powi(4));
    assert!(found.abs_diff_eq(exact, 1e-12), "{found}, not {exact}");
    let above = DVec3::new(0.0, 0.0, 3.0);
    assert_eq!(spot.at(above, [0.5; 2]).irradiance, DVec3::ZERO);
}

#[test]
fn a_rectangle_brings_its_form_factor_and_nothing_behind_itself() {
    // One corner straight above, at height 1.5: a parallel rectangle of 2 by 1.
    let (height, a, b) = (1.5, 2.0, 1.0);
    let sides = [[0.0, b, 0.0], [a, 0.0, 0.0]];
    let panel = Light::rect([0.0, 0.0, height], sides, [2.0; 3]);
    let part = |x: f64, y: f64| x / x.hypot(1.0) * (y / x.hypot(1.0)).atan();
    let (x, y) = (a / height, b / height);
    let exact = 2.0 * 0.5 * (part(x, y) + part(y, x));
    let found = received(&panel, DVec3::Z);
    assert!((found / exact - 1.0).abs() < 1e-5, "{found}, not {exact}");
    let turned = Light::rect([0.0, 0.0, height], [sides[1], sides[0]], [2.0; 3]);
    assert_eq!(received(&turned, DVec3::Z), 0.0);
    assert_eq!(received(&panel, DVec3::NEG_Z), 0.0);
}

#[test]
fn a_spot_has_all_of_its_light_inside_and_none_outside() {
    let spot = |inner: f64, outer: f64, range| Light::Point {
        position: DVec3::ZERO,
        intensity: DVec3::splat(9.0),
        cone: Some(Cone {
            axis: DVec3::NEG_Z,
            cosines: [inner.cos(), outer.cos()],
        }),
        range,
    };
    let at = |light: &Light, angle: f64, distance: f64| {
        let (sine, cosine) = angle.sin_cos();
        light
            .at(distance * DVec3::new(sine, 0.0, -cosine), [0.5; 2])
            .irradiance
            .x
    };
    let light = spot(0.3, 0.7, f64::INFINITY);
    // I/r², times the square of where the cosine stands between those of both angles.
    let between = (0.5f64.cos() - 0.7f64.cos()) / (0.3f64.cos() - 0.7f64.cos());
    for (angle, share) in [
        (0.0, 1.0),
        (0.29, 1.0),
        (0.5, between.powi(2)),
        (0.71, 0.0),
        (3.0, 0.0),
    ] {
        let found = at(&light, angle, 3.0);
        assert!(
            (found - share).abs() < 1e-12,
            "{angle}: {found}, not {share}"
        );
    }
    // Angles that are alike make a border, not a division by 0.
    let sharp = spot(0.5, 0.5, f64::INFINITY);
    assert!((at(&sharp, 0.49, 3.0) - 1.0).abs() < 1e-12);
    assert_eq!(at(&sharp, 0.51, 3.0), 0.0);
    // Halfway to its range a sixteenth is missing.
    let near = spot(0.3, 0.7, 6.0);
    assert!((at(&near, 0.0, 3.0) - 15.0 / 16.0).abs() < 1e-12);
    assert!(at(&near, 0.0, 6.0) < 1e-12 && at(&near, 0.0, 7.0) == 0.0);
}

#[test]
fn all_that_a_lambertian_surface_reflects_is_its_albedo_times_what_arrives() {
    // Radiance L in every direction is a flux of π L per area: the energy bound of the chapter, with equality.
    let (albedo, cosine) = (DVec3::ONE, 0.6);
    let sun = Light::Distant {
        toward: DVec3::new(0.8, 0.0, cosine),
        irradiance: DVec3::splat(2.0),
    };
    let radiance = sun.at(DVec3::ZERO, [0.5; 2]).diffuse(DVec3::Z, albedo);
    assert!((PI * radiance.x - cosine * 2.0).abs() < 1e-15);
}

#[test]
fn a_sky_full_of_lights_gives_the_open_phong_term() {
    // Equation (7) summed over even light is equation (14). Midpoints of 512 x 512 cells of equal solid angle.
    const CELLS: usize = 512;
    for (exponent, degrees) in [(0.0, 40.0), (5.0, 0.0), (5.0, 75.0), (20.0, 60.0_f64)] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let mirror = DVec3::new(-sine, 0.0, cosine);
        let material = PhongMaterial {
            specular: DVec3::ONE,
            exponent,
            ..PhongMaterial::default()
        };
        let of = |cell: usize| {
            let (row, column) = (cell / CELLS, cell % CELLS);
            let z = (row as f64 + 0.5) / CELLS as f64;
            let (y, x) = (2.0 * PI * (column as f64 + 0.5) / CELLS as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let sun = Light::Distant {
                toward: DVec3::new(r * x, r * y, z),
                irradiance: DVec3::splat(2.0 * PI / (CELLS * CELLS) as f64),
            };
            let arrival = sun.at(DVec3::ZERO, [0.5; 2]);
            arrival.specular(DVec3::Z, mirror, &material).x
        };
        let sum: f64 = (0..CELLS * CELLS).map(of).sum();
        let exact = ambient::closed_form::phong_open_angle(exponent, degrees.to_radians());
        // The step of the clamped lobe and of the horizon crosses cells.
        assert!(
            (sum - exact).abs() < 1e-4,
            "{exponent} {degrees}: {sum}, not {exact}"
        );
    }
}
