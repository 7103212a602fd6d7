//! A table of exact values, an independent quadrature, special values and symmetry.

use super::*;

/// Sine and cosine of a whole number of degrees, accurate in both near the axes.
fn degrees(theta: f64) -> (f64, f64) {
    let (s, c) = theta.to_radians().sin_cos();
    if theta > 45.0 && theta < 135.0 {
        (s, (90.0 - theta).to_radians().sin())
    } else if theta >= 135.0 {
        ((180.0 - theta).to_radians().sin(), c)
    } else {
        (s, c)
    }
}

fn open_degrees(n: f64, theta: f64) -> f64 {
    let (s, c) = degrees(theta);
    phong_open(n, c, s)
}

#[test]
fn every_row_of_the_paper_figure_table_is_met() {
    // It belongs to the repository, not to the package: it is read when the test runs.
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/tables/open_specular.csv"
    );
    let table = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut rows = 0;
    for line in table.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let v: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let (s, c) = degrees(v[1]);
        let g = phong_open(v[0], c, s);
        let m = phong_open_cosine(v[0], c, s);
        for (value, exact) in [(g, v[2]), (m, v[3])] {
            // A few units of rounding; the table itself is rounded once.
            assert!((value / exact - 1.0).abs() < 2e-15, "{line}: {value}");
        }
        rows += 1;
    }
    assert_eq!(rows, 80);
}

#[test]
fn the_step_at_ninety_degrees_is_exact_for_a_million() {
    // Elevation of the view above the surface in degrees, G.
    for (elevation, exact) in [
        (1.0, 1.0),
        (0.1, 0.959_536_290_052_362_1),
        (0.01, 0.569_276_688_680_539_7),
        (0.0, 0.5),
        (-0.01, 0.430_723_311_319_460_3),
        (-0.1, 0.040_463_709_947_637_904),
        (-1.0, 1.612_068_901_028_926_6e-68),
    ] {
        let (c, s) = f64::to_radians(elevation).sin_cos();
        let g = phong_open(1e6, c, s);
        let bound = if elevation < 0.0 { 4e-14 } else { 2e-15 };
        assert!((g / exact - 1.0).abs() < bound, "{elevation}: {g}");
    }
    for (n, elevation, exact) in [
        (1e4, 1.0, 0.959_543_862_721_270_7),
        (1e4, -1.0, 0.040_456_137_278_729_34),
        (100.0, 1.0, 0.569_450_066_138_470_6),
        (100.0, -1.0, 0.430_549_933_861_529_4),
        (100.0, 30.0, 0.999_999_962_204_115_9),
    ] {
        let (c, s) = f64::to_radians(elevation).sin_cos();
        let g = phong_open(n, c, s);
        assert!((g / exact - 1.0).abs() < 2e-15, "{n} {elevation}: {g}");
    }
}

/// ∫ exp(n · log_base(x)) over `a..b` by the double-exponential rule: nothing in common with the forms under test.
fn power_integral(n: f64, a: f64, b: f64, log_base: fn(f64) -> f64) -> f64 {
    let half = 0.5 * (b - a);
    let step = 1.0 / 64.0;
    let mut sum = 0.0;
    for k in -260..=260 {
        let t = f64::from(k) * step;
        let arm = 0.5 * PI * t.sinh();
        // Distance to the nearer end, exact where the nodes crowd there.
        let d = 2.0 * half / (1.0 + (2.0 * arm.abs()).exp());
        let x = if t < 0.0 { a + d } else { b - d };
        let weight = half * 0.5 * PI * t.cosh() / (arm.cosh() * arm.cosh());
        sum += weight * (n * log_base(x)).exp() * step;
    }
    sum
}

fn log_cosine(x: f64) -> f64 {
    if x.abs() < 0.8 {
        0.5 * (-x.sin() * x.sin()).ln_1p()
    } else {
        x.cos().abs().ln()
    }
}

fn log_sine(x: f64) -> f64 {
    x.sin().ln()
}

#[test]
fn equation_14_by_independent_quadrature_agrees() {
    let exponents = [
        0.0, 0.5, 1.0, 1.7, 2.0, 2.5, 5.0, 10.0, 37.3, 200.0, 1e3, 1e4, 1e5, 1e6,
    ];
    let angles = [
        0.0, 1.0, 5.0, 20.0, 30.0, 44.0, 45.0, 46.0, 60.0, 75.0, 80.0, 85.0, 88.0, 89.0, 89.5,
        90.0, 90.5, 91.0, 92.0, 95.0, 100.0, 120.0, 150.0, 179.0,
    ];
    for n in exponents {
        // The inner integral over latitude, both halves so that the peak at 0 lies at an end.
        let latitude = 2.0 * power_integral(n + 1.0, 0.0, 0.5 * PI, log_cosine);
        for theta in angles {
            let top = f64::to_radians(90.0 - theta);
            let azimuth = if theta < 90.0 {
                power_integral(n, -0.5 * PI, 0.0, log_cosine)
                    + power_integral(n, 0.0, top, log_cosine)
            } else if theta < 120.0 {
                power_integral(n, -0.5 * PI, top, log_cosine)
            } else {
                // Measured from the corner of the lune, where the cosine has lost its digits.
                power_integral(n, 0.0, f64::to_radians(180.0 - theta), log_sine)
            };
            let exact = (n + 1.0) / TAU * latitude * azimuth;
            let value = open_degrees(n, theta);
            if exact < 1e-290 {
                assert!(value < 1e-289, "{n} {theta}: {value}");
                continue;
            }
            // Rounding of 521 terms, and of n ln sin, which is as large as -ln of the result, on both sides.
            let bound = 1e-14 + 1e-15 * -exact.min(1.0).ln();
            assert!(
                (value / exact - 1.0).abs() < bound,
                "{n} {theta}: {value} for {exact}"
            );
        }
    }
}

#[test]
fn low_exponents_have_their_elementary_values() {
    for i in 0..=180 {
        let theta = f64::from(i);
        let (s, c) = degrees(theta);
        let radians = theta.to_radians();
        // Beyond 90 degrees the elementary forms cancel, so the comparison is absolute.
        for (n, exact) in [
            (0.0, 1.0 - radians / PI),
            (1.0, 0.5 * (1.0 + c)),
            (2.0, (PI - radians + s * c) / PI),
            (3.0, 0.5 * (1.0 + c * (1.0 + 0.5 * s * s))),
        ] {
            let g = phong_open(n, c, s);
            assert!((g - exact).abs() < 1e-15, "{n} {theta}: {g} for {exact}");
        }
    }
}

#[test]
fn both_sides_of_the_horizon_add_up_to_one() {
    for n in [0.0, 0.5, 1.0, 7.0, 33.3, 173.0, 1e4, 1e6] {
        assert_eq!(phong_open(n, 0.0, 1.0), 0.5);
        assert_eq!(phong_open(n, 1.0, 0.0), 1.0);
        assert_eq!(phong_open(n, -1.0, 0.0), 0.0);
        for i in 1..90 {
            let (s, c) = degrees(f64::from(i));
            let sum = phong_open(n, c, s) + phong_open(n, -c, s);
            assert!((sum - 1.0).abs() <= f64::EPSILON, "{n} {i}: {sum}");
        }
    }
}

#[test]
fn the_term_falls_with_the_angle_and_never_leaves_its_range() {
    for n in [
        0.0, 0.5, 1.0, 1.999, 2.0, 2.5, 35.0, 36.0, 173.0, 1000.0, 1e5, 1e6,
    ] {
        let mut before = 1.0;
        for i in 0..=3600 {
            let g = open_degrees(n, f64::from(i) / 20.0);
            assert!((0.0..=1.0).contains(&g), "{n} {i}: {g}");
            assert!(g <= before * (1.0 + 4e-15), "{n} {i}: {g} after {before}");
            before = g;
        }
    }
}

#[test]
fn the_cosine_variant_meets_its_special_values() {
    for n in [0.0, 0.5, 2.0, 10.0, 1e3, 1e6] {
        // At 90 degrees only W(n+2)/(n+1) is left, times (n+2)/2π.
        let head_on = phong_open_cosine(n, 1.0, 0.0);
        assert!((head_on - 1.0).abs() < 1e-15, "{n}: {head_on}");
        let w = 2.0 * power_integral(n + 2.0, 0.0, 0.5 * PI, log_cosine);
        let grazing = (n + 2.0) / (n + 1.0) * w / TAU;
        let value = phong_open_cosine(n, 0.0, 1.0);
        assert!(
            (value / grazing - 1.0).abs() < 1e-14,
            "{n}: {value} for {grazing}"
        );
    }
}
