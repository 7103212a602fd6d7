//! Any picture, taken as areas of constant radiance, against a sum over many parts of every texel.

use super::*;

/// Directions with solid angles that share out one texel.
type Parts = Vec<(Direction, f64)>;

/// 8 x 8 Gauss-Legendre nodes of each of the four triangles that the diagonals of a texel make: a fold is one of them.
fn parts(projection: Projection, size: (usize, usize), i: usize, j: usize) -> Parts {
    if let Projection::Ortho | Projection::Ball | Projection::Angular = projection {
        return on_disc(projection, size, i, j);
    }
    let mut parts = Parts::new();
    for (a, wa) in gauss_legendre(8) {
        for (b, wb) in gauss_legendre(8) {
            // Along the way from the middle to an edge, and along that edge.
            let (a, b) = (0.25 * (a + 1.0), 0.5 * (a + 1.0) * 0.5 * b);
            for (dx, dy) in [(a, b), (-a, b), (b, a), (b, -a)] {
                let (x, y) = (i as f64 + 0.5 + dx, j as f64 + 0.5 + dy);
                if let Some(direction) = projection.direction(size, x, y) {
                    parts.push((direction, wa * wb * a * projection.density(size, x, y)));
                }
            }
        }
    }
    scaled(parts, projection.solid_angle(size, i, j))
}

fn midpoints(count: usize) -> Vec<(f64, f64)> {
    let middle = |k: usize| (2.0 * k as f64 + 1.0) / count as f64 - 1.0;
    (0..count).map(|k| (middle(k), 1.0)).collect()
}

fn scaled(mut parts: Parts, omega: f64) -> Parts {
    let total: f64 = parts.iter().map(|(_, weight)| weight).sum();
    let scale = if total > 0.0 { omega / total } else { 0.0 };
    parts.iter_mut().for_each(|(_, weight)| *weight *= scale);
    parts
}

/// 100 lines of 8 nodes, closer at the rim: x = √(1-y²) sin t.
fn on_disc(projection: Projection, size: (usize, usize), i: usize, j: usize) -> Parts {
    let side = size.1 as f64;
    let edge = |k: usize| 2.0 * k as f64 / side - 1.0;
    let mut parts = Parts::new();
    for (v, _) in midpoints(100) {
        let y = 1.0 - 2.0 * (j as f64 + 0.5 * (v + 1.0)) / side;
        let across = (1.0 - y * y).sqrt();
        let [a, b] =
            [i % size.1, i % size.1 + 1].map(|k| (edge(k) / across).clamp(-1.0, 1.0).asin());
        for (t, weight) in gauss_legendre(8) {
            let t = a + 0.5 * (t + 1.0) * (b - a);
            let (x, z) = (across * t.sin(), across * t.cos());
            let r = x.hypot(y);
            let (direction, density) = match projection {
                Projection::Ortho => ([x, y, if i < size.1 { z } else { -z }], 1.0),
                Projection::Ball => ([2.0 * z * x, 2.0 * z * y, 2.0 * z * z - 1.0], z),
                _ => {
                    let (sin, cos) = (PI * r).sin_cos();
                    ([sin * x / r, sin * y / r, cos], z * sin / r)
                }
            };
            parts.push((direction, weight * (b - a) * density));
        }
    }
    scaled(parts, projection.solid_angle(size, i, j))
}

/// Every fifth texel is bright; neighbours differ as much as they can without being lights of their own.
fn grainy(projection: Projection) -> IlluminationMap {
    let size = projection.size(32);
    let mut image = Image::filled(size.0, size.1, [0.0; 3]);
    for (at, pixel) in image.pixels.iter_mut().enumerate() {
        let grain = ((at as u32).wrapping_mul(2_654_435_769) >> 20) as f32 / 4096.0;
        *pixel = [grain.powi(8) * 4.0, f32::from(u8::from(at % 5 == 0)), 1.0];
    }
    IlluminationMap::new(image, projection).unwrap()
}

/// Convolves and returns the largest difference from the sum over parts, over the largest value, for each lobe.
fn errors(projection: Projection, lobes: &[Lobe]) -> Vec<f64> {
    let map = grainy(projection);
    let size = map.size();
    let texels = (0..size.0 * size.1).map(|at| (at % size.0, at / size.0));
    let parts: Vec<(Direction, [f64; 3])> = texels
        .flat_map(|(i, j)| {
            let pixel = map.image().at(i, j).map(f64::from);
            let parts = parts(projection, size, i, j).into_iter();
            parts.map(move |(d, omega)| (d, pixel.map(|v| v * omega)))
        })
        .collect();
    let request = |lobe: &Lobe| Request {
        lobe: lobe.clone(),
        normalise: Normalise::Radiance,
        projection: Projection::Polar,
        size: (4, 2),
    };
    let requests: Vec<Request> = lobes.iter().map(request).collect();
    let results = convolve(&map, &requests).unwrap();
    let error = |(result, request): (&ReflectionMap, &Request)| {
        let scale = request.lobe.scale(request.normalise);
        let difference = |at: usize| {
            let (x, y) = ((at % 4) as f64 + 0.5, (at / 4) as f64 + 0.5);
            let n = Projection::Polar.direction((4, 2), x, y).unwrap();
            let sum = parts.iter().fold([0.0; 3], |sum: [f64; 3], (l, flux)| {
                let value = request.lobe.value(dot(n, *l).min(1.0));
                std::array::from_fn(|c| sum[c] + value * flux[c])
            });
            let ours = result.image().pixels[at];
            let differences = (0..3).map(|c| (f64::from(ours[c]) - scale * sum[c]).abs());
            differences.fold(0.0, f64::max)
        };
        let largest = result.image().pixels.iter().flatten();
        let largest = largest.fold(0.0, |a: f32, b| a.max(*b));
        let all: Vec<f64> = (0..8).into_par_iter().map(difference).collect();
        all.into_iter().fold(0.0, f64::max) / f64::from(largest)
    };
    results.iter().zip(&requests).map(error).collect()
}

#[test]
fn a_grainy_picture_is_convolved_exactly_from_every_projection() {
    let mut lobes = vec![Lobe::Phong(10.0), Lobe::Phong(100.0), Lobe::Lambert];
    for projection in Projection::all() {
        // GGX takes a thousand orders: once is enough.
        match projection {
            Projection::Polar => lobes.extend([0.3, 0.8].map(Lobe::Ggx)),
            _ => lobes.truncate(3),
        }
        for (lobe, error) in lobes.iter().zip(errors(projection, &lobes)) {
            let bound = match projection {
                // The parts stand on 100 lines a texel, which end as roots do: 100^-1.5 of a texel.
                Projection::Ortho | Projection::Ball | Projection::Angular => 1e-3,
                // The parts do not see where the horizon cuts a texel.
                _ if *lobe == Lobe::Lambert => 1e-5,
                _ => 1e-6,
            };
            assert!(error < bound, "{projection:?}, {lobe:?}: off by {error:e}");
        }
    }
}
