//! Hard cases: tiny, huge, near and tilted. Values of `tests/tables/hard_cases.csv`, which are exact to 20 digits.

use super::super::{
    polygon_form_factor, polygon_solid_angle, polygon_specular, round, shapes, tilted_phong,
};
use super::{endless, flat, upright, v};
use ambient::closed_form::{phong_open, tilted_specular};
use glam::DVec3;
use std::f64::consts::TAU;

/// Relative error below `ulps` units of 2.2e-16.
fn check(what: &str, value: f64, exact: f64, ulps: f64) {
    let error = (value / exact - 1.0).abs() / f64::EPSILON;
    assert!(
        error <= ulps,
        "{what}: {value:e} for {exact:e}, {error} units"
    );
}

#[test]
fn closed_forms_keep_their_relative_accuracy_where_terms_are_tiny() {
    let wall = shapes::wall(1e-6, 1.0);
    check("wall 1e-6", wall.visibility, 0.500_000_318_309_886_2, 2.0);
    check("wall 1e-6", wall.diffuse, 0.500_000_5, 2.0);
    let groove = shapes::groove(1e-3);
    check("groove", groove.visibility, 3.183_098_861_837_906_7e-4, 2.0);
    check("groove", groove.diffuse, 2.499_999_791_666_673_6e-7, 4.0);
    let well = round::well(1.0, 1000.0);
    check("well", well.visibility, 4.999_996_250_003_125e-7, 4.0);
    check("well", well.diffuse, 9.999_990_000_01e-7, 4.0);
    let contact = round::resting_sphere(1.0, 1e-3);
    check("contact", contact.visibility, 9.999_995_000_003_75e-4, 4.0);
    check("contact", contact.diffuse, 1.499_998_125_002_187_5e-6, 4.0);
    for (near, far, visibility, diffuse) in [
        (0.0, 0.01, 0.501_591_522_906_156, 0.502_499_937_503_124_8),
        (0.0, 0.1, 0.515_889_074_023_738_6, 0.524_937_810_560_445_1),
        (1.0, 1.1, 0.757_699_108_021_085_6, 0.861_966_561_793_777_5),
    ] {
        let strip = shapes::wall_average(near, far, 1.0);
        // The quotient by the width of the strip, a tenth.
        check("strip", strip.visibility, visibility, 8.0);
        check("strip", strip.diffuse, diffuse, 4.0);
    }
}

#[test]
fn small_polygons_keep_their_digits() {
    let small = 0.5_f64.powi(13);
    let tiny = [
        v(1.0, 1.0, 1.0),
        v(1.0 + small, 1.0, 1.0),
        v(1.0, 1.0 + small, 1.0),
    ];
    let solid = polygon_solid_angle(&tiny, DVec3::Z) / TAU;
    check("tiny solid angle", solid, 2.281_881_166_064_265_2e-10, 8.0);
    let factor = polygon_form_factor(&tiny, DVec3::Z);
    check("tiny factor", factor, 2.634_817_936_839_899e-10, 8.0);
    let strip = flat([-1e3, 1e3], [1.0, 1.0 + 1e-6], 1.0);
    // The width itself is only known to one part in 1e10: 1 + 1e-6 is rounded.
    let width = (1.0 + 1e-6 - 1.0) / 1e-6;
    let solid = polygon_solid_angle(&strip, DVec3::Z) / TAU / width;
    assert!(
        (solid / 1.591_547_043_597_459_6e-7 - 1.0).abs() < 1e-12,
        "{solid:e}"
    );
    let factor = polygon_form_factor(&strip, DVec3::Z) / width;
    assert!(
        (factor / 1.767_765_625_019_756_2e-7 - 1.0).abs() < 1e-9,
        "{factor:e}"
    );
}

#[test]
fn a_plate_just_above_blocks_and_a_coplanar_plate_does_not() {
    let plate = |z: f64| flat([-1.0, 1.0], [-1.0, 1.0], z);
    for (height, visibility, diffuse) in [
        (1e-2, 9.002_788_053_966_884e-3, 8.182_405_612_374_743e-5),
        (1e-6, 9.003_163_163_156_731e-7, 8.183_098_861_830_974e-13),
    ] {
        let solid = 1.0 - polygon_solid_angle(&plate(height), DVec3::Z) / TAU;
        let factor = 1.0 - polygon_form_factor(&plate(height), DVec3::Z);
        // One minus a number near 1: absolute.
        assert!((solid - visibility).abs() < 1e-15, "{height}: {solid:e}");
        assert!((factor - diffuse).abs() < 1e-15, "{height}: {factor:e}");
    }
    assert_eq!(polygon_solid_angle(&plate(0.0), DVec3::Z), 0.0);
    assert_eq!(polygon_form_factor(&plate(0.0), DVec3::Z), 0.0);
    assert_eq!(polygon_specular(&plate(0.0), DVec3::Z, DVec3::Z, 10.0), 0.0);
}

#[test]
fn a_lobe_on_a_silhouette_is_half_blocked() {
    let wall = endless(DVec3::X, v(1.0, 0.0, 1.0));
    let axis = v(0.5, 0.0, 0.5) * 2.0_f64.sqrt();
    for (n, exact) in [
        (10.0, 0.496_563_848_345_539_4),
        (1e3, 0.5),
        (1e5, 0.5),
        (1e6, 0.5),
    ] {
        let blocked: f64 = wall
            .iter()
            .map(|p| polygon_specular(p, DVec3::Z, axis, n))
            .sum();
        assert!((blocked - exact).abs() < 4e-15, "{n}: {blocked}");
    }
}

#[test]
fn tilted_shading_normals_are_cut_by_the_geometric_plane() {
    // Tilt, zenith and azimuth of the view in degrees, n = 20. Zenith from the geometric normal, azimuth 0 on the side
    // of the shading normal.
    for (tilt, zenith, azimuth, exact) in [
        (10.0, 60.0, 0.0, 0.999_529_993_662_038),
        (10.0, 60.0, 180.0, 0.785_934_382_710_918_6),
        (10.0, 80.0, 0.0, 0.944_912_250_234_503),
        (10.0, 80.0, 180.0, 0.214_065_617_289_081_4),
        (30.0, 60.0, 0.0, 0.999_999_953_294_044_1),
        (30.0, 60.0, 180.0, 0.007_558_958_225_936_523),
        (30.0, 80.0, 180.0, 1.016_999_943_813_014_3e-5),
        (60.0, 60.0, 0.0, 0.992_441_041_774_063_5),
        (60.0, 60.0, 180.0, 0.0),
        (60.0, 80.0, 0.0, 0.999_989_829_985_624_9),
    ] {
        let lean = f64::to_radians(tilt);
        let normal = v(lean.sin(), 0.0, lean.cos());
        let side = if azimuth == 0.0 { 1.0 } else { -1.0 };
        let (s, c) = f64::to_radians(zenith).sin_cos();
        let view = v(s * side, 0.0, c);
        let axis = normal * (2.0 * normal.dot(view)) - view;
        let value = tilted_phong(normal, DVec3::Z, axis, 20.0);
        assert!(
            (value - exact).abs() < 4e-15,
            "{tilt} {zenith} {azimuth}: {value} for {exact}"
        );
    }
    for (n, delta) in [(0.5, 0.3), (1.0, 0.0), (7.0, 1.0), (300.0, 1.5), (2.0, 3.0)] {
        let normal = v(f64::sin(delta), 0.0, f64::cos(delta));
        let value = tilted_phong(normal, DVec3::Z, normal, n);
        let exact = tilted_specular(n, delta);
        assert!(
            (value - exact).abs() < 4e-15,
            "{n} {delta}: {value} for {exact}"
        );
    }
    let open = tilted_phong(DVec3::Y, DVec3::Y, v(0.6, 0.8, 0.0), 33.0);
    assert!((open - phong_open(33.0, 0.8, 0.6)).abs() < 4e-15, "{open}");
}

#[test]
fn scaling_by_a_power_of_two_changes_no_bit() {
    let wall = upright(1.0, [-0.3, 0.7], [-0.2, 1.1]);
    let axis = v(0.6, 0.0, 0.8);
    let terms = |p: &[DVec3]| {
        [
            polygon_solid_angle(p, DVec3::Z),
            polygon_form_factor(p, DVec3::Z),
            polygon_specular(p, DVec3::Z, axis, 7.5),
        ]
    };
    for k in [-40, -1, 1, 60] {
        let scaled: Vec<DVec3> = wall.iter().map(|p| *p * 2.0_f64.powi(k)).collect();
        assert_eq!(terms(&scaled), terms(&wall));
    }
}
