//! Solid angles against totals and quadrature, places against directions.

use super::*;

/// A size of each projection with about `side` texels a quarter.
fn sizes(side: usize) -> Vec<(Projection, (usize, usize))> {
    let mut all: Vec<_> = Projection::all().map(|p| (p, p.size(4 * side))).collect();
    all.push((Projection::Cross, (3 * side, 4 * side)));
    all.push((Projection::Strip, (side, 6 * side)));
    all
}

#[test]
fn solid_angles_add_up_to_the_sphere() {
    for side in [1, 2, 7, 64, 301] {
        for (projection, size) in sizes(side) {
            projection.check(size.0, size.1).unwrap();
            let angles = projection.solid_angles(size);
            assert!(angles.iter().all(|a| *a >= 0.0), "{projection:?} {size:?}");
            let sum: f64 = angles.iter().sum();
            // Differences of corner functions of size 1 lose some 1e-16 a texel.
            let bound = 1e-14 * angles.len() as f64;
            assert!(
                (sum - 4.0 * PI).abs() < bound.max(1e-13),
                "{projection:?} {size:?}: {sum}"
            );
        }
    }
}

#[test]
fn solid_angles_are_the_integral_of_the_density() {
    for (projection, size) in sizes(8) {
        if let Projection::Ortho = projection {
            continue; // singular at the rim; its closed form is tested by the sum
        }
        let gauss = ambient::quadrature::gauss_legendre(12);
        let mut whole = Vec::new();
        for texel in 0..size.0 * size.1 {
            let (i, j) = (texel % size.0, texel / size.0);
            let shown = |di: f64, dj: f64| {
                projection
                    .direction(size, i as f64 + di, j as f64 + dj)
                    .is_some()
            };
            let corners = [
                (1e-9, 1e-9),
                (1.0 - 1e-9, 1e-9),
                (1e-9, 1.0 - 1e-9),
                (1.0 - 1e-9, 1.0 - 1e-9),
            ];
            let folded = projection == Projection::Octahedral
                && (i + j + 1 == size.0 / 2
                    || i + j + 1 == 3 * size.0 / 2
                    || i.abs_diff(j) == size.0 / 2);
            if folded || !corners.into_iter().all(|(a, b)| shown(a, b)) {
                continue;
            }
            let mut sum = 0.0;
            for (x, wx) in &gauss {
                for (y, wy) in &gauss {
                    let at = |v: f64, k: usize| k as f64 + 0.5 * (v + 1.0);
                    sum += wx * wy * projection.density(size, at(*x, i), at(*y, j));
                }
            }
            whole.push(projection.solid_angle(size, i, j) / sum);
        }
        for ratio in &whole {
            assert!(
                (ratio / whole[0] - 1.0).abs() < 1e-11,
                "{projection:?}: {ratio} {}",
                whole[0]
            );
        }
        assert!(whole.len() > 16);
    }
}

#[test]
fn places_and_directions_are_inverse() {
    for (projection, size) in sizes(16) {
        for j in 0..4 * size.1 {
            for i in 0..4 * size.0 {
                let (x, y) = ((i as f64 + 0.5) / 4.0, (j as f64 + 0.5) / 4.0);
                let Some(d) = projection.direction(size, x, y) else {
                    continue;
                };
                assert!((d.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-14);
                let (u, v) = projection.place(size, d);
                assert!(
                    (u - x).abs() < 1e-9 && (v - y).abs() < 1e-9,
                    "{projection:?} {x} {y}: {u} {v}"
                );
            }
        }
    }
}

#[test]
fn the_axes_are_where_the_documentation_says() {
    let polar = |d| Projection::Polar.place((360, 180), d);
    assert_eq!(polar([0.0, 0.0, 1.0]), (180.0, 90.0));
    assert_eq!(polar([1.0, 0.0, 0.0]), (270.0, 90.0));
    assert_eq!(polar([0.0, 1.0, 0.0]).1, 0.0);
    assert_eq!(
        Projection::Cube.place((10, 60), [1.0, 0.0, 0.0]),
        (5.0, 5.0)
    );
    assert_eq!(
        Projection::Cube.place((10, 60), [0.0, 0.0, -1.0]),
        (5.0, 55.0)
    );
    assert_eq!(
        Projection::Ortho.place((20, 10), [0.0, 1.0, 0.0]),
        (5.0, 0.0)
    );
    for projection in [
        Projection::Ball,
        Projection::Angular,
        Projection::Octahedral,
    ] {
        assert_eq!(
            projection.place((10, 10), [0.0, 0.0, 1.0]),
            (5.0, 5.0),
            "{projection:?}"
        );
        let (x, y) = projection.place((10, 10), [1.0, 0.0, 0.0]);
        assert!(x > 6.0 && (y - 5.0).abs() < 1e-9, "{projection:?}: {x} {y}");
    }
}

#[test]
fn cube_faces_keep_their_precision_at_any_size() {
    // The middle texel of a face of side n subtends 4/n² · (1 - 2/n² + …) sr.
    let n = 4097;
    let omega = Projection::Cube.solid_angle((n, 6 * n), n / 2, n / 2);
    let exact = 4.0 * ((1.0 / n as f64).powi(2) / (1.0 + 2.0 / (n * n) as f64).sqrt()).atan();
    assert!((omega / exact - 1.0).abs() < 1e-9, "{omega} {exact}");
}

#[test]
fn wrong_sizes_are_named() {
    for (projection, size) in [
        (Projection::Polar, (100, 100)),
        (Projection::Cube, (10, 50)),
        (Projection::Cross, (10, 10)),
        (Projection::Octahedral, (5, 5)),
        (Projection::Ball, (0, 0)),
    ] {
        let error = projection.check(size.0, size.1).unwrap_err().to_string();
        assert!(
            error.contains(projection.name()) && !error.contains('\n'),
            "{error}"
        );
    }
}
