//! Any view against closed forms and quadrature of its own.

use super::*;
use crate::closed_form::phong_open_angle;
use crate::ggx::Ggx;
use crate::quadrature::gauss_legendre;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Directions of the hemisphere in the frame of a texel, with weights that add up to 1.
fn directions(rows: usize, turns: usize) -> impl Iterator<Item = (DVec3, f64)> {
    let rows = gauss_legendre(rows).into_iter();
    rows.flat_map(move |(node, weight)| {
        let z = 0.5 * (node + 1.0);
        let r = (1.0 - z * z).sqrt();
        (0..turns).map(move |turn| {
            let (s, c) = (TAU * (turn as f64 + 0.5) / turns as f64).sin_cos();
            let direction = DVec3::new(r * c, r * s, z);
            (direction, 0.5 * weight / turns as f64)
        })
    })
}

/// Coefficients of open directions by brute force.
fn coefficients(open: impl Fn(DVec3) -> bool) -> Coefficients {
    let basis = Basis::new();
    let mut sums = [0.0; COUNT];
    for (direction, weight) in directions(128, 256).filter(|(d, _)| open(*d)) {
        for (sum, y) in sums.iter_mut().zip(basis.at(direction.x, direction.y)) {
            *sum += weight * y;
        }
    }
    Coefficients(sums)
}

/// The Phong term of a lobe axis, by polar coordinates about that axis: no harmonics.
fn exact(open: &impl Fn(DVec3) -> bool, axis: DVec3, n: f64) -> f64 {
    let frame = Frame::from_normal(axis);
    let (rows, turns) = (64, 64);
    let mut sum = 0.0;
    for row in 0..rows {
        let cos = ((row as f64 + 0.5) / rows as f64).powf(1.0 / (n + 1.0));
        let sin = (1.0 - cos * cos).sqrt();
        for turn in 0..turns {
            let (s, c) = (TAU * (turn as f64 + 0.5) / turns as f64).sin_cos();
            let l = frame.to_world(DVec3::new(sin * c, sin * s, cos));
            sum += f64::from(u8::from(l.z > 0.0 && open(l)));
        }
    }
    sum / (rows * turns) as f64
}

/// Thirty mirrored views over the hemisphere down to 85 degrees: angle and azimuth.
fn views() -> impl Iterator<Item = (f64, f64)> {
    (0..30).map(|k| {
        (
            85f64.to_radians() * (f64::from(k) + 0.5) / 30.0,
            2.4 * f64::from(k),
        )
    })
}

/// A wall at x = 1 of height 1, endless along y.
fn wall(l: DVec3) -> bool {
    !(l.x > 0.0 && l.z < l.x)
}

/// Under a square lid of edge 2 at height 1, off to one side.
fn lid(l: DVec3) -> bool {
    let p = l / l.z;
    !((p.x - 0.7).abs() < 1.0 && p.y.abs() < 1.0)
}

/// A corridor's floor: walls on both sides, twice as high as it is wide.
fn corridor(l: DVec3) -> bool {
    l.z > 4.0 * l.y.abs()
}

#[test]
fn open_texel_is_the_closed_form_at_every_angle() {
    let normal = DVec3::new(0.3, -0.5, 0.6).normalize();
    let frame = frame(normal);
    for n in [1.0, 5.0, 20.0, 200.0] {
        for degrees in [0.0, 20.0, 50.0, 80.0, 89.9, 90.0f64] {
            let theta = degrees.to_radians();
            let view = frame.to_world(DVec3::new(
                theta.sin() * 0.6,
                theta.sin() * 0.8,
                theta.cos(),
            ));
            let found = Coefficients::OPEN.specular(4, Lobe::Phong(n), normal, view);
            let exact = phong_open_angle(n, theta);
            assert!(
                (found - exact).abs() < 1e-9,
                "{n} {degrees}: {found} {exact}"
            );
            let share = Coefficients::OPEN.specular(8, Lobe::Ggx(0.25), normal, view);
            assert!((share - 1.0).abs() < 1e-12, "{degrees}: {share}");
            let none = Coefficients::default().specular(8, Lobe::Phong(n), normal, view);
            assert_eq!(none, 0.0);
        }
    }
}

#[test]
fn wall_is_what_its_closed_forms_say() {
    // AO_u = 1 - g/π with g = 45°; the mean of y(1, 1) ∝ sin cos φ is an integral of its own.
    let found = coefficients(wall);
    assert!((found.0[0] - 0.75).abs() < 2e-3, "{}", found.0[0]);
    // x = cos g cos b over the wedge of elevations g up to 45° and latitudes b, dω = cos b db dg: sin 45° times π/2 is
    // blocked of what has no mean in all. y(1, 1) = √3 x.
    let exact = -3f64.sqrt() * FRAC_PI_2 * 0.5f64.sqrt() / TAU;
    assert!((found.0[index(1, 1)] - exact).abs() < 2e-3);
    assert!(found.0[index(1, -1)].abs() < 1e-12, "the wall is even in y");
}

#[test]
fn orders_leave_what_is_stated() {
    for (name, open) in [
        ("wall", &wall as &dyn Fn(DVec3) -> bool),
        ("lid", &lid),
        ("corridor", &corridor),
    ] {
        let stored = coefficients(open);
        let basis = Basis::new();
        for (order, n, most) in [
            (4, 5.0, 0.03),
            (4, 20.0, 0.07),
            (8, 5.0, 0.01),
            (8, 20.0, 0.03),
            (8, 50.0, 0.05),
        ] {
            let squares: f64 = views()
                .map(|(theta, phi)| {
                    let axis = DVec3::new(
                        theta.sin() * phi.cos(),
                        theta.sin() * phi.sin(),
                        theta.cos(),
                    );
                    let kernel = kernel(&basis, Lobe::Phong(n), theta);
                    let found = stored.term(order, &kernel, [phi.cos(), phi.sin()]);
                    (found - exact(&open, axis, n)).powi(2)
                })
                .sum();
            let rms = (squares / 30.0).sqrt();
            let stated = stated(&stored, &[0.0; COUNT], order, Lobe::Phong(n));
            println!("{name} order {order} n {n}: rms {rms:.4}, stated {stated:.4}");
            assert!(rms < most, "{name} {order} {n}: {rms}");
            assert!(
                rms < 2.5 * stated + 2e-3 && stated < 6.0 * rms + 1e-3,
                "{name} {order} {n}: {rms} where {stated} is stated"
            );
        }
    }
}

/// The share of a GGX lobe that is open, by the directions of its visible normals: no harmonics.
fn exact_ggx(open: &impl Fn(DVec3) -> bool, alpha: f64, (theta, phi): (f64, f64)) -> f64 {
    let ggx = Ggx::new(alpha, theta.cos());
    let (sin, cos) = phi.sin_cos();
    let count = 256;
    let (mut seen, mut all) = (0.0, 0.0);
    for k in 0..count * count {
        let u = [k / count, k % count].map(|k| (f64::from(k) + 0.5) / f64::from(count));
        let drawn = ggx.sample(u);
        // The view stands at x > 0 there, its mirror image at x < 0.
        let (x, y) = (-drawn.direction.x, -drawn.direction.y);
        let turned = DVec3::new(x * cos - y * sin, x * sin + y * cos, drawn.direction.z);
        all += drawn.weight;
        seen += match open(turned) {
            true => drawn.weight,
            false => 0.0,
        };
    }
    seen / all
}

/// PlacedTree six posts, twice as wide as the gaps are.
fn posts(l: DVec3) -> bool {
    l.z > 0.6 || l.y.atan2(l.x).rem_euclid(TAU / 6.0) > 0.35
}

/// Under a window of a dark room.
fn window(l: DVec3) -> bool {
    let p = l / l.z;
    (p.x - 0.5).abs() < 0.7 && p.y.abs() < 0.4
}

#[test]
fn orders_leave_what_is_stated_of_ggx() {
    // A statement by the Phong lobe of the same material was 2 to 100 times too low from roughness 0.5 on.
    for (name, open) in [
        ("wall", &wall as &dyn Fn(DVec3) -> bool),
        ("lid", &lid),
        ("corridor", &corridor),
        ("posts", &posts),
        ("window", &window),
    ] {
        let stored = coefficients(open);
        let basis = Basis::new();
        for roughness in [0.4, 0.5, 0.6, 0.7_f64] {
            let lobe = Lobe::Ggx(roughness.powi(2));
            let mut squares = [0.0; 2];
            for (theta, phi) in views().step_by(2) {
                let kernel = kernel(&basis, lobe, theta);
                let exact = exact_ggx(&open, roughness.powi(2), (theta, phi));
                for (square, order) in squares.iter_mut().zip(ORDERS) {
                    let found = stored.term(order, &kernel, [phi.cos(), phi.sin()]);
                    *square += (found - exact).powi(2) / 15.0;
                }
            }
            for (square, order) in squares.into_iter().zip(ORDERS) {
                let (rms, stated) = (square.sqrt(), stated(&stored, &[0.0; COUNT], order, lobe));
                println!(
                    "{name} order {order} roughness {roughness}: rms {rms:.4}, stated {stated:.4}"
                );
                // The quadratures are off by a thousandth. Walls and lids leave less than any border, at most of
                // what is small by half.
                assert!(
                    rms < 1.5 * stated + 2e-3 && stated < 3.0 * rms + 6e-3,
                    "{name} {order} {roughness}: {rms} where {stated} is stated"
                );
            }
        }
    }
    // More numbers than a Phong lobe of the same material needs, whose bands end.
    let orders =
        |roughness: f64| [256, 4096].map(|rays| order_for(Lobe::Ggx(roughness.powi(2)), rays));
    assert_eq!([0.4, 0.7].map(orders), [[8, 8], [4, 8]]);
}

#[test]
fn orders_are_chosen_by_what_they_leave_of_three_scenes() {
    let energy = |open: &dyn Fn(DVec3) -> bool, order: usize| {
        let c = coefficients(open);
        let held: f64 = c.0[..count(order)].iter().map(|c| c * c).sum();
        c.0[0] - held
    };
    for order in ORDERS {
        let scenes: [&dyn Fn(DVec3) -> bool; 3] = [&wall, &lid, &corridor];
        let most = scenes
            .map(|open| energy(open, order))
            .into_iter()
            .fold(0.0, f64::max);
        println!("order {order}: {most:.5}");
        for n in [1.0, 5.0, 20.0, 100.0] {
            let lobe = Lobe::Phong(n);
            let (found, exact) = (truncation(order, lobe), order::left(most, order, lobe));
            println!(
                "n {n}: {found:.4} {exact:.4}, noise at 256 rays {:.4}",
                expected_noise(order, lobe, 256)
            );
            assert!(
                (found / exact - 1.0).abs() < 0.02,
                "{order} {n}: {found} {exact}"
            );
        }
    }
    // More rays ask for more numbers, narrower lobes too, and few rays for few.
    assert_eq!(
        [16, 256, 65_536].map(|rays| order_for(Lobe::Phong(5.0), rays)),
        [4, 4, 8]
    );
    assert_eq!(
        [1.0, 5.0, 20.0, 1000.0].map(|n| order_for(Lobe::Phong(n), 256)),
        [4, 4, 8, 8]
    );
}

#[test]
fn table_is_the_kernel_between_its_places() {
    let basis = Basis::new();
    for microfacets in [false, true] {
        let table = KernelTable::new(4, microfacets);
        let mut worst = 0.0f64;
        for k in 0..60 {
            let theta = FRAC_PI_2 * (f64::from(k) + 0.37) / 60.0;
            let lobe = match microfacets {
                false => Lobe::Phong(1.0 + 3.3 * f64::from(k % 13)),
                true => Lobe::Ggx((0.3 + 0.05 * f64::from(k % 13)).powi(2)),
            };
            let exact = kernel(&basis, lobe, theta);
            for (l, m) in pairs(4) {
                let found = table.look_up(l, m, theta, row_of(lobe));
                worst = worst.max((found - exact[pair(l, m)]).abs());
            }
        }
        println!("microfacets {microfacets}: {worst}");
        assert!(worst < 0.006, "{microfacets}: {worst}");
    }
}

#[test]
fn frame_is_orthonormal_and_turns_smoothly() {
    for k in 0..2000 {
        let z = (f64::from(k) + 0.5) / 1000.0 - 1.0;
        let (s, c) = (2.4 * f64::from(k)).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let normal = DVec3::new(r * c, r * s, z);
        let f = frame(normal);
        assert!(f.tangent.dot(normal).abs() < 1e-12);
        assert!((f.tangent.cross(f.bitangent) - normal).length() < 1e-12);
        let near = frame((normal + 1e-6 * DVec3::new(0.3, 0.5, -0.8)).normalize());
        let along = 1.0 + AXIS.dot(normal);
        assert!(
            (near.tangent - f.tangent).length() < 1e-5 / along.sqrt(),
            "{normal}"
        );
    }
    // The six directions of floors and walls lie far from the one without a frame.
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        assert!(AXIS.dot(axis).abs() < 0.86);
    }
    assert!(frame(-AXIS).tangent.is_finite());
}
