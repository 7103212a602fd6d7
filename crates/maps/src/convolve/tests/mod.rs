//! Every exact vector of the reference, from a projection that can hold it, to 1e-6 in the 1984 normalisation. Points
//! and constants come from every projection (`lights.rs`).

mod lights;
mod pictures;
mod threads;

use super::*;
use ambient::quadrature::gauss_legendre;
use environment::{Direction, Image};
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

/// Runs every lobe on an environment from some projections and asks for 1e-6.
fn expect(
    projections: &[Projection],
    texels: usize,
    count: usize,
    radiance: impl Fn(Direction) -> f64 + Sync,
    cases: &[(Lobe, &dyn Fn(f64) -> f64)],
) {
    for projection in projections {
        let map = painted(*projection, texels, count, &radiance);
        let requests = cases.iter().map(|(lobe, _)| request(lobe.clone()));
        let results = convolve(&map, &requests.collect::<Vec<_>>()).unwrap();
        for (result, (lobe, exact)) in results.iter().zip(cases) {
            let (error, x) = worst(result, exact);
            assert!(
                error < 1e-6,
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
    for texels in [4, 64] {
        let whole = |n: f64| move |_: f64| 0.5 / (n + 1.0);
        expect(
            &[Projection::Polar],
            texels,
            1,
            |_| 1.0,
            &[
                (Lobe::Lambert, &|_| 0.25),
                (Lobe::Luminous, &|_| 1.0),
                (Lobe::Phong(0.0), &whole(0.0)),
                (Lobe::Phong(0.5), &whole(0.5)),
                (Lobe::Phong(50.0), &whole(50.0)),
                (Lobe::Phong(1000.0), &whole(1000.0)),
                (Lobe::Varnish(10.0), &|_| 0.5 / 11.0 + 0.5),
                (Lobe::Mirror, &|_| 1.0),
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
        &[Projection::Polar],
        2048,
        16,
        |d| f64::from(u8::from(dot(d, AXIS) > 0.0)),
        &[
            (Lobe::Lambert, &|x| (1.0 + x) / 8.0),
            (Lobe::Luminous, &|_| 0.5),
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
        &[Projection::Cube, Projection::Octahedral],
        1536,
        3,
        |d| dot(d, AXIS).max(0.0),
        &[
            (Lobe::Lambert, &lambert),
            (Lobe::Luminous, &|_| 0.25),
            (Lobe::Phong(10.0), &|x| clamped_cosine(10.0, x)),
            (Lobe::Phong(100.0), &|x| clamped_cosine(100.0, x)),
        ],
    );
}

#[test]
fn kinked_lobes_give_the_closed_forms() {
    let half = |d: Direction| f64::from(u8::from(dot(d, AXIS) > 0.0));
    expect(
        &[Projection::Polar],
        2048,
        16,
        half,
        &[
            (Lobe::Phong(0.5), &|x| half_space(0.5, x)),
            (Lobe::Phong(1.5), &|x| half_space(1.5, x)),
            (Lobe::Phong(2.0), &|x| half_space(2.0, x)),
            (Lobe::Phong(2.5), &|x| half_space(2.5, x)),
        ],
    );
    let map = painted(Projection::Polar, 2048, 16, half);
    let result = convolve(&map, &[request(Lobe::Phong(0.0))])
        .unwrap()
        .remove(0);
    let (error, x) = worst(&result, |x| 0.5 - x.clamp(-1.0, 1.0).acos() / (2.0 * PI));
    // The edges of both hemispheres cross in two texels, of which the picture holds only the mean.
    let bound = 2.0 * (2.0 * PI / 2048.0).powi(2) / (4.0 * PI);
    assert!(error < bound, "off by {error:e} at cosine {x}");
}

/// ∫ k P_l over 0..1 by 16 nodes in each of the intervals 1-2^-k..1-2^-(k+1).
fn moment(lobe: &Lobe, l: usize) -> f64 {
    let panel = |k: i32| {
        let (half, middle) = (0.25 * 0.5f64.powi(k), 0.75 * 0.5f64.powi(k));
        let nodes = gauss_legendre(16).into_iter();
        nodes
            .map(|(s, w)| {
                let x = 1.0 - middle - half * s;
                half * w * lobe.value(x) * legendre(x, 8)[l]
            })
            .sum::<f64>()
    };
    (0..48).map(panel).sum()
}

#[test]
fn ggx_scales_a_spherical_harmonic_as_quadrature_says() {
    let map = painted(Projection::Polar, 4096, 2, |d| 1.0 + low(2, dot(d, AXIS)));
    let roughness = [0.1, 0.25, 0.5, 1.0];
    let requests = roughness.map(|roughness| Request {
        normalise: Normalise::Radiance,
        ..request(Lobe::Ggx(roughness))
    });
    let results = convolve(&map, &requests).unwrap();
    for (roughness, result) in roughness.into_iter().zip(results) {
        let lobe = Lobe::Ggx(roughness);
        let factor = moment(&lobe, 2) / moment(&lobe, 0);
        let (error, x) = worst(&result, |x| 1.0 + factor * low(2, x));
        assert!(
            error < 1e-5,
            "roughness {roughness}: off by {error:e} at {x}"
        );
    }
}

#[test]
fn a_table_is_integrated_as_the_lines_between_its_points() {
    // F_l = ∫ P_l = (P_{l+1} - P_{l-1}) / (2l+1), and x P_l = ((l+1) P_{l+1} + l P_{l-1}) / (2l+1).
    let pairs = [(-1.0, 0.2), (-0.4, 0.0), (0.3, 0.7), (0.9, 1.0), (1.0, 4.0)];
    let zonal = Lobe::Table(pairs.to_vec()).zonal().unwrap();
    for (l, coefficient) in zonal.iter().enumerate().take(200).skip(1) {
        let f = |x: f64, l: usize| {
            let p = legendre(x, l + 2);
            let before = if l == 0 { -1.0 } else { p[l - 1] };
            (p[l + 1] - before) / (2 * l + 1) as f64
        };
        let line = |p: &[(f64, f64)]| {
            let slope = (p[1].1 - p[0].1) / (p[1].0 - p[0].0);
            let at = |x: f64| {
                let k = l as f64;
                let of_x = ((k + 1.0) * f(x, l + 1) + k * f(x, l - 1)) / (2.0 * k + 1.0);
                (p[0].1 - slope * p[0].0) * f(x, l) + slope * of_x
            };
            at(p[1].0) - at(p[0].0)
        };
        let exact = 2.0 * PI * pairs.windows(2).map(line).sum::<f64>();
        assert!(
            (coefficient - exact).abs() < 1e-12,
            "l = {l}: {coefficient} {exact}"
        );
    }
}

#[test]
fn spherical_harmonics_are_eigenfunctions() {
    for (l, projection) in [
        (1, Projection::Polar),
        (2, Projection::Cube),
        (4, Projection::Octahedral),
        (4, Projection::Polar),
    ] {
        // A constant keeps the radiance positive.
        let d = |x: f64| 0.25 + 0.5 * power(1.0, 8)[l] * legendre(x, 8)[l];
        let s = |n: f64| move |x: f64| 0.5 / (n + 1.0) + 0.5 * power(n, 8)[l] * legendre(x, 8)[l];
        expect(
            &[projection],
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

/// One face of a cube is white, as no other projection can hold it.
#[test]
fn a_white_cube_face_gives_the_closed_forms() {
    for projection in [Projection::Cube, Projection::Cross, Projection::Strip] {
        let size = projection.size(256);
        let mut image = Image::filled(size.0, size.1, [0.0; 3]);
        for (at, pixel) in image.pixels.iter_mut().enumerate() {
            let (x, y) = ((at % size.0) as f64 + 0.5, (at / size.0) as f64 + 0.5);
            let front = |d: Direction| d[2] > d[0].abs().max(d[1].abs());
            *pixel = [f32::from(u8::from(
                projection.direction(size, x, y).is_some_and(front),
            )); 3];
        }
        let map = IlluminationMap::new(image, projection).unwrap();
        // Six texels look along the axes: +x -x +y -y +z -z.
        let axes = |lobe| Request {
            projection: Projection::Cube,
            size: (1, 6),
            ..request(lobe)
        };
        let results = convolve(&map, &[axes(Lobe::Lambert), axes(Lobe::Luminous)]).unwrap();
        let (side, front) = (0.0278670985, 0.1385316060);
        let exact = [[side, side, side, side, front, 0.0], [1.0 / 6.0; 6]];
        for (result, exact) in results.iter().zip(exact) {
            for (pixel, exact) in result.image().pixels.iter().zip(exact) {
                let error = (f64::from(pixel[0]) - exact).abs();
                assert!(error < 1e-6, "{projection:?}: {pixel:?} is not {exact}");
            }
        }
    }
}
