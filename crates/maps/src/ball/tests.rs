//! Angles against vectors, and a round trip through a rendered ball.

use super::photo::frame;
use super::*;
use environment::Direction;
use std::f64::consts::PI;

/// The mirror direction of the ray through a point of the picture, by vectors: camera at (0, 0, d), ball of radius 1.
pub(super) fn reflect(d: f64, right: f64, up: f64) -> Option<Direction> {
    let tangent = (d * d - 1.0).sqrt();
    let ray = [right / tangent, up / tangent, -1.0];
    let square: f64 = ray.iter().map(|v| v * v).sum();
    let ray = ray.map(|v| v / square.sqrt());
    // |camera + s ray| = 1.
    let half = d * ray[2];
    let rest = half * half - d * d + 1.0;
    let s = -half
        - if rest >= 0.0 {
            rest.sqrt()
        } else {
            return None;
        };
    let normal = [s * ray[0], s * ray[1], d + s * ray[2]];
    let dot: f64 = (0..3).map(|c| normal[c] * ray[c]).sum();
    Some(std::array::from_fn(|c| ray[c] - 2.0 * dot * normal[c]))
}

/// A smooth environment with a known integral: 4π (1, 2, 1).
fn sky([x, y, z]: Direction) -> [f32; 3] {
    [1.0 + 0.5 * x, 2.0 + y * z, 1.0 + 0.9 * z].map(|v| v as f32)
}

/// A photograph of `sky` in a ball at a distance, from a direction, with its middle off the pixels.
fn photograph(d: f64, from: Direction, side: usize) -> (Image, Circle) {
    let circle = Circle {
        x: 0.5 * side as f64 + 0.3,
        y: 0.5 * side as f64 - 0.2,
        radius: 0.48 * side as f64,
    };
    let frame = frame(from);
    let mut image = Image::filled(side, side, [7.0; 3]);
    for (index, pixel) in image.pixels.iter_mut().enumerate() {
        let right = ((index % side) as f64 + 0.5 - circle.x) / circle.radius;
        let up = (circle.y - (index / side) as f64 - 0.5) / circle.radius;
        if let Some(r) = reflect(d, right, up) {
            *pixel = sky(std::array::from_fn(|c| {
                (0..3).map(|k| r[k] * frame[k][c]).sum()
            }));
        }
    }
    (image, circle)
}

#[test]
fn the_inverse_finds_the_point_that_mirrors_a_direction() {
    for optics in [
        Optics::Orthographic,
        Optics::Near(1.5),
        Optics::Near(10.0),
        Optics::Near(1e4),
    ] {
        assert!((optics.mirror(optics.rim()) - (PI - optics.blind())).abs() < 1e-12);
        for k in 0..1000 {
            let alpha = optics.rim() * f64::from(k) / 1000.0;
            let found = optics.point(optics.mirror(alpha)).unwrap();
            assert!((found - alpha).abs() < 1e-13, "{optics:?} {alpha}: {found}");
            if let Optics::Near(d) = optics
                && d < 1e3
                && k < 950
            {
                let r = reflect(d, optics.radius(alpha), 0.0).unwrap();
                let theta = r[0].atan2(r[2]);
                // The test's own quadratic loses digits far away and at the rim.
                assert!(
                    (theta - optics.mirror(alpha)).abs() < 1e-6,
                    "{optics:?} {alpha}: {theta}"
                );
            }
        }
    }
    assert_eq!(Optics::Near(10.0).point(PI - 0.1), None);
}

/// Largest difference from `sky` and the mean over the sphere.
fn compare(unwrapped: &Unwrapped, counts: impl Fn(Direction) -> bool) -> (f64, [f64; 3]) {
    let size = (unwrapped.image.width, unwrapped.image.height);
    let (mut worst, mut mean) = (0.0f64, [0.0; 3]);
    for (index, pixel) in unwrapped.image.pixels.iter().enumerate() {
        let (i, j) = (index % size.0, index / size.0);
        let omega = Projection::Polar.solid_angle(size, i, j) / (4.0 * PI);
        mean = std::array::from_fn(|c| mean[c] + omega * f64::from(pixel[c]));
        let d = Projection::Polar
            .direction(size, i as f64 + 0.5, j as f64 + 0.5)
            .unwrap();
        if counts(d) {
            let truth = sky(d);
            let error = (0..3)
                .map(|c| f64::from((pixel[c] - truth[c]).abs()))
                .fold(0.0, f64::max);
            worst = worst.max(error);
        }
    }
    (worst, mean)
}

#[test]
fn a_round_trip_errs_only_about_the_blind_cone() {
    let from = [0.6, 0.2, -0.7];
    let toward = frame(from)[2];
    for d in [3.0, 10.0, 100.0] {
        let (image, circle) = photograph(d, from, 512);
        let optics = Optics::Near(d);
        let photo = Photo {
            image: &image,
            circle,
            from,
            optics,
        };
        let unwrapped = unwrap(&[photo], Projection::Polar, (256, 128), [1.0; 3]).unwrap();
        // The ring of the outermost √2 pixels is replaced, and a texel is 1.4 degrees wide.
        let ring = 1.0 - std::f64::consts::SQRT_2 / circle.radius;
        let whole = (0..100_000).map(|k| optics.rim() * f64::from(k) / 1e5);
        let alpha = whole
            .take_while(|a| optics.radius(*a) < ring)
            .last()
            .unwrap();
        let edge = optics.mirror(alpha) - 2f64.to_radians();
        let angle = |a: Direction| {
            (0..3)
                .map(|c| a[c] * toward[c])
                .sum::<f64>()
                .clamp(-1.0, 1.0)
                .acos()
        };
        let (worst, mean) = compare(&unwrapped, |a| angle(a) < edge);
        println!(
            "d = {d}: worst {worst:.2e}, mean {mean:?}, seen {}",
            unwrapped.seen / (4.0 * PI)
        );
        // At the ring of d = 3 a pixel spans 4 degrees and bends by 0.03 rad; an eighth of it times a slope of 1.2.
        assert!(worst < 5e-3, "d = {d}: {worst}");
        let visible = 0.5 * (1.0 + optics.blind().cos());
        // A texel that is seen in part counts as seen.
        assert!(
            (unwrapped.seen / (4.0 * PI) - visible).abs() < 0.01,
            "{}",
            unwrapped.seen
        );
    }
}

#[test]
fn two_balls_fill_the_blind_cones_of_each_other() {
    let views = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let shots = views.map(|from| (photograph(5.0, from, 512), from));
    let photos: Vec<Photo> = shots
        .iter()
        .map(|((image, circle), from)| Photo {
            image,
            circle: *circle,
            from: *from,
            optics: Optics::Near(5.0),
        })
        .collect();
    let unwrapped = unwrap(&photos, Projection::Polar, (256, 128), [0.5, 1.0, 2.0]).unwrap();
    assert!(unwrapped.confidence.iter().all(|c| *c > 0.0));
    let (_, mean) = compare(&unwrapped, |_| true);
    let energy: [f64; 3] =
        std::array::from_fn(|c| mean[c] * [0.5, 1.0, 2.0][c] / [1.0, 2.0, 1.0][c] - 1.0);
    println!("energy {energy:?}");
    assert!(energy.iter().all(|e| e.abs() < 1e-3), "{energy:?}");
}

#[test]
fn unusable_circles_and_cameras_are_refused_with_a_cure() {
    let image = Image::filled(8, 8, [1.0; 3]);
    let circle = |x: f64, radius: f64| Circle { x, y: 4.0, radius };
    let cases = [
        (circle(4.0, 9.0), [0.0, 0.0, 1.0], "leaves its 8 x 8 pixels"),
        (circle(f64::NAN, 3.0), [0.0, 0.0, 1.0], "leaves"),
        (circle(4.0, 3.0), [0.0, 1.0, 0.0], "not straight up or down"),
    ];
    for (circle, from, words) in cases {
        let photo = Photo {
            image: &image,
            circle,
            from,
            optics: Optics::Orthographic,
        };
        let message = unwrap(&[photo], Projection::Polar, (64, 32), [1.0; 3]);
        let message = message.unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

/// `sky` behind and in a ball of a reflectance, with area-sampled pixels and a pattern over both.
fn scene(circle: Circle, d: f64, reflectance: f64, size: (usize, usize)) -> Image {
    const PARTS: usize = 5;
    let mut image = Image::filled(size.0, size.1, [0.0; 3]);
    let pattern = |d: Direction| {
        let wave = |k: f64, v: f64| 0.35 * (k * v).sin();
        (wave(9.0, d[0]) + wave(11.0, d[1] + 0.4 * d[2]) + wave(23.0, d[0] * d[1])).exp()
    };
    let tangent = (d * d - 1.0).sqrt();
    for (index, pixel) in image.pixels.iter_mut().enumerate() {
        let mut sum = 0.0;
        for part in 0..PARTS * PARTS {
            let place = |k: usize| (k as f64 + 0.5) / PARTS as f64;
            let x = (index % size.0) as f64 + place(part % PARTS);
            let y = (index / size.0) as f64 + place(part / PARTS);
            let (right, up) = (
                (x - circle.x) / circle.radius,
                (circle.y - y) / circle.radius,
            );
            sum += match reflect(d, right, up) {
                Some(r) => reflectance * pattern(r),
                None => {
                    let ray = [right / tangent, up / tangent, -1.0];
                    let length = ray.iter().map(|v| v * v).sum::<f64>().sqrt();
                    pattern(ray.map(|v| v / length))
                }
            };
        }
        *pixel = [(sum / (PARTS * PARTS) as f64) as f32; 3];
    }
    image
}

#[test]
fn the_outline_is_found_to_half_a_pixel_before_the_scene_that_it_mirrors() {
    // A ball of reflectance 0.8 is hard: what it mirrors at the rim is what stands behind it, a fifth brighter, and the
    // rings just inside are three times as strong.
    for (x, y, radius, reflectance, limit) in [
        (251.3, 180.8, 121.4, 0.6, 0.5),
        (320.0, 240.0, 230.0, 0.4, 0.5),
        (90.2, 110.7, 60.3, 0.8, 1.0),
    ] {
        let circle = Circle { x, y, radius };
        let image = scene(circle, 12.0, reflectance, (640, 480));
        let found = find(&image).unwrap();
        println!("{circle:?} at {reflectance}: {found:?}");
        let c = found.circle;
        let off = [c.x - x, c.y - y, c.radius - radius];
        assert!(off.iter().all(|v| v.abs() < limit), "{off:?}");
    }
}

#[test]
fn pictures_without_a_ball_are_refused() {
    let mut noise = Image::filled(300, 200, [0.0; 3]);
    let mut state = 1u32;
    for pixel in &mut noise.pixels {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *pixel = [(state >> 16) as f32; 3];
    }
    let mut square = Image::filled(300, 200, [0.1; 3]);
    for y in 50..150 {
        square.pixels[y * 300 + 100..y * 300 + 200].fill([1.0; 3]);
    }
    for image in [
        noise,
        square,
        Image::filled(64, 64, [1.0; 3]),
        Image::filled(1, 1, [0.0; 3]),
    ] {
        let message = find(&image).unwrap_err().to_string();
        println!("{message}");
        assert!(message.contains("give --circle"), "{message}");
    }
}
