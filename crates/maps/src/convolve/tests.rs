//! Every exact vector of the reference, from every projection, to 1e-6 in the 1984 normalisation.

use super::*;
use crate::quadrature::gauss_legendre;
use crate::{Direction, Image};
use std::f64::consts::PI;

/// A direction that no projection favours.
const AXIS: Direction = [0.48, -0.64, 0.6];

fn dot(a: Direction, b: Direction) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A map whose texels hold the mean radiance of their area, by `count` nodes each way.
fn painted(
    projection: Projection,
    texels: usize,
    count: usize,
    radiance: impl Fn(Direction) -> f64 + Sync,
) -> IlluminationMap {
    let size = projection.size(texels);
    let (rough, fine) = (gauss_legendre(2), gauss_legendre(count));
    let pixel = |at: usize| {
        let (i, j) = ((at % size.0) as f64, (at / size.0) as f64);
        let mean = |rule: &[(f64, f64)]| {
            let (mut sum, mut total, mut range) = (0.0, 0.0, [f64::MAX, f64::MIN]);
            for (x, wx) in rule {
                for (y, wy) in rule {
                    let (x, y) = (i + 0.5 * (x + 1.0), j + 0.5 * (y + 1.0));
                    if let Some(direction) = projection.direction(size, x, y) {
                        let (weight, value) = (
                            wx * wy * projection.density(size, x, y),
                            radiance(direction),
                        );
                        sum += weight * value;
                        total += weight;
                        range = [range[0].min(value), range[1].max(value)];
                    }
                }
            }
            (sum, total, range[0] == range[1])
        };
        let (sum, total, flat) = mean(&rough);
        let (sum, total, _) = if flat {
            (sum, total, flat)
        } else {
            mean(&fine)
        };
        let value = if total > 0.0 {
            sum / total
        } else {
            radiance(projection.nearest_direction(size, i, j))
        };
        [value as f32, 0.5 * value as f32, 0.0]
    };
    let image = Image {
        width: size.0,
        height: size.1,
        pixels: (0..size.0 * size.1).into_par_iter().map(pixel).collect(),
    };
    IlluminationMap::new(image, projection).unwrap()
}

fn request(lobe: Lobe) -> Request {
    Request {
        lobe,
        normalise: Normalise::Seed,
        projection: Projection::Polar,
        size: (36, 18),
    }
}

/// The largest difference between a result and the exact value at the cosine to `AXIS`, and where.
fn worst(map: &ReflectionMap, exact: impl Fn(f64) -> f64) -> (f64, f64) {
    let (width, height) = map.size();
    let mut worst = (0.0, 0.0);
    for j in 0..height {
        for i in 0..width {
            let direction =
                map.projection()
                    .direction((width, height), i as f64 + 0.5, j as f64 + 0.5);
            let Some(direction) = direction else { continue };
            let x = dot(direction, AXIS);
            let [red, green, blue] = map.image().at(i, j);
            assert!((green - 0.5 * red).abs() <= 1e-6 * red.abs() && blue == 0.0);
            let error = (f64::from(red) - exact(x)).abs();
            if error > worst.0 {
                worst = (error, x);
            }
        }
    }
    worst
}

/// Runs every lobe on an environment from every projection and asks for 1e-6. The rim of a disc shows much of the sphere
/// in few texels, which hold only its mean: there the bound is that of a picture, not of the convolution.
fn expect(
    texels: usize,
    count: usize,
    radiance: impl Fn(Direction) -> f64 + Sync,
    cases: &[(Lobe, &dyn Fn(f64) -> f64)],
) {
    for projection in Projection::all() {
        let disc = matches!(
            projection,
            Projection::Ortho | Projection::Ball | Projection::Angular
        );
        // Two or three projections are enough for many texels.
        let most = match projection {
            Projection::Polar | Projection::Cube => 2048,
            Projection::Octahedral => 1536,
            _ => 256,
        };
        if texels > most || (disc && texels < 256) {
            continue;
        }
        let map = painted(projection, texels, count, &radiance);
        // Kinked lobes have a thousand orders: two projections are enough for them.
        let long = matches!(projection, Projection::Polar | Projection::Cube);
        let kinked = |lobe: &Lobe| matches!(lobe, Lobe::Phong(n) if *n < 5.0 && *n > 1.0);
        let cases: Vec<_> = cases
            .iter()
            .filter(|(lobe, _)| long || !kinked(lobe))
            .collect();
        let requests: Vec<_> = cases
            .iter()
            .map(|(lobe, _)| request(lobe.clone()))
            .collect();
        let results = convolve(&map, &requests).unwrap();
        for (result, (lobe, exact)) in results.iter().zip(cases) {
            let (error, x) = worst(result, exact);
            // The hemisphere's own edge cuts texels; along rows it does so exactly.
            let edge = *lobe == Lobe::Phong(0.0) && projection != Projection::Polar;
            let bound = if disc || edge { 1e-4 } else { 1e-6 };
            assert!(
                error < bound,
                "{projection:?} {texels}, {lobe:?}: off by {error:e} at cosine {x}"
            );
        }
    }
}

/// Legendre polynomials up to an order.
fn legendre(x: f64, order: usize) -> Vec<f64> {
    let mut p = vec![1.0, x];
    for l in 1..order {
        let k = l as f64;
        p.push(((2.0 * k + 1.0) * x * p[l] - k * p[l - 1]) / (k + 1.0));
    }
    p
}

/// P_1, P_2 or P_4.
fn low(l: usize, x: f64) -> f64 {
    match l {
        1 => x,
        2 => 1.5 * x * x - 0.5,
        _ => (35.0 * x.powi(4) - 30.0 * x * x + 3.0) / 8.0,
    }
}

/// a_l of max(0, x)ⁿ by its recurrence.
fn power(n: f64, order: usize) -> Vec<f64> {
    let mut a = vec![1.0 / (n + 1.0), 1.0 / (n + 2.0)];
    for l in 0..order {
        a.push(a[l] * (n - l as f64) / (n + l as f64 + 3.0));
    }
    a
}

/// ∫ sinⁿ from an angle to π, times B_n / 4π: S of the half-space.
fn half_space(n: f64, cosine: f64) -> f64 {
    let angle = cosine.clamp(-1.0, 1.0).acos();
    let integral = |from: f64| -> f64 {
        let half = 0.5 * (PI - from) / 8.0;
        let panel = |k: usize| {
            let middle = from + (2 * k + 1) as f64 * half;
            gauss_legendre(24)
                .iter()
                .map(|(x, w)| half * w * (middle + half * x).sin().powf(n))
                .sum::<f64>()
        };
        (0..8).map(panel).sum()
    };
    // B_n makes the whole 1/(2(n+1)).
    integral(angle) / integral(0.0) / (2.0 * (n + 1.0))
}

fn clamped_cosine(n: f64, cosine: f64) -> f64 {
    let order = 3000;
    let (a, b, p) = (power(1.0, order), power(n, order), legendre(cosine, order));
    let terms = (0..order).map(|l| (2 * l + 1) as f64 * a[l] * b[l] * p[l]);
    0.25 * terms.sum::<f64>()
}

#[test]
fn a_constant_map_comes_out_constant_at_any_size() {
    for texels in [64, 256] {
        let whole = |n: f64| move |_: f64| 0.5 / (n + 1.0);
        expect(
            texels,
            1,
            |_| 1.0,
            &[
                (Lobe::Lambert, &|_| 0.25),
                (Lobe::Luminous, &|_| 1.0),
                (Lobe::Phong(0.0), &whole(0.0)),
                (Lobe::Phong(2.0), &whole(2.0)),
                (Lobe::Phong(50.0), &whole(50.0)),
                (Lobe::Phong(1000.0), &whole(1000.0)),
            ],
        );
    }
}

#[test]
fn a_half_space_gives_the_closed_forms() {
    let cases: Vec<(f64, f64, f64)> = vec![
        // n, angle in degrees, printed value
        (1.0, 30.0, 0.2332532),
        (1.0, 150.0, 0.01674682),
        (2.0, 45.0, 0.1515258),
        (2.0, 120.0, 0.03258352),
        (10.0, 60.0, 0.04359399),
        (10.0, 120.0, 0.001860551),
        (50.0, 90.0, 0.004901961),
        (100.0, 60.0, 0.004950495),
    ];
    for (n, angle, value) in cases {
        let ours = half_space(n, angle.to_radians().cos());
        assert!(
            (ours / value - 1.0).abs() < 4e-7,
            "n = {n} at {angle}: {ours} {value}"
        );
    }
    expect(
        2048,
        16,
        |d| f64::from(u8::from(dot(d, AXIS) > 0.0)),
        &[
            (Lobe::Lambert, &|x| (1.0 + x) / 8.0),
            (Lobe::Luminous, &|_| 0.5),
            (Lobe::Phong(2.0), &|x| half_space(2.0, x)),
            (Lobe::Phong(10.0), &|x| half_space(10.0, x)),
            (Lobe::Phong(50.0), &|x| half_space(50.0, x)),
            (Lobe::Phong(100.0), &|x| half_space(100.0, x)),
        ],
    );
}

#[test]
fn a_clamped_cosine_gives_the_closed_forms() {
    let lambert = |x: f64| {
        let angle = x.clamp(-1.0, 1.0).acos();
        (angle.sin() + (PI - angle) * x) / (6.0 * PI)
    };
    for (n, angle, value) in [
        (1.0f64, 30.0f64, 0.1468071),
        (2.0, 120.0, 0.0078125),
        (10.0, 60.0, 0.02103066),
        (50.0, 90.0, 0.0005397845),
    ] {
        let ours = clamped_cosine(n, angle.to_radians().cos());
        assert!(
            (ours / value - 1.0).abs() < 4e-7,
            "n = {n} at {angle}: {ours} {value}"
        );
    }
    expect(
        1536,
        3,
        |d| dot(d, AXIS).max(0.0),
        &[
            (Lobe::Lambert, &lambert),
            (Lobe::Luminous, &|_| 0.25),
            (Lobe::Phong(2.0), &|x| (1.0 + x).powi(2) / 32.0),
            (Lobe::Phong(10.0), &|x| clamped_cosine(10.0, x)),
            (Lobe::Phong(100.0), &|x| clamped_cosine(100.0, x)),
        ],
    );
}

#[test]
fn spherical_harmonics_are_eigenfunctions() {
    for l in [1, 2, 4] {
        // A constant keeps the radiance positive.
        let d = |x: f64| 0.25 + 0.5 * power(1.0, 8)[l] * legendre(x, 8)[l];
        let s = |n: f64| move |x: f64| 0.5 / (n + 1.0) + 0.5 * power(n, 8)[l] * legendre(x, 8)[l];
        expect(
            1536,
            2,
            |d| 1.0 + low(l, dot(d, AXIS)),
            &[
                (Lobe::Lambert, &d),
                (Lobe::Phong(10.0), &s(10.0)),
                (Lobe::Phong(50.0), &s(50.0)),
            ],
        );
    }
}
