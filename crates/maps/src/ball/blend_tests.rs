//! Two photographs of one ball: what one sees badly must not leak into what the other sees well.

use super::blend::ENOUGH;
use super::photo::frame;
use super::tests::reflect;
use super::*;
use environment::Direction;

/// Surroundings of radiance 1 with a bright disc.
#[derive(Clone, Copy)]
struct Disc {
    middle: Direction,
    /// Angular radius.
    radius: f64,
    radiance: f64,
}

fn dot(a: Direction, b: Direction) -> f64 {
    (0..3).map(|c| a[c] * b[c]).sum()
}

impl Disc {
    fn at(&self, direction: Direction) -> f64 {
        let inside = dot(self.middle, direction) > self.radius.cos();
        if inside { self.radiance } else { 1.0 }
    }

    /// Directions along its edge.
    fn edge(&self) -> impl Iterator<Item = Direction> {
        let [right, up, toward] = frame(self.middle);
        let (sin, cos) = self.radius.sin_cos();
        (0..720).map(move |k| {
            let (s, c) = f64::from(k).mul_add(0.5, 0.25).to_radians().sin_cos();
            std::array::from_fn(|i| cos * toward[i] + sin * (c * right[i] + s * up[i]))
        })
    }
}

/// The mirror direction seen at a place of the ball's picture, the outline having radius 1.
fn mirrored(optics: Optics, right: f64, up: f64) -> Option<Direction> {
    match optics {
        Optics::Near(d) => reflect(d, right, up),
        Optics::Orthographic => {
            let z = (1.0 - right * right - up * up).sqrt();
            (z >= 0.0).then_some([2.0 * z * right, 2.0 * z * up, 2.0 * z * z - 1.0])
        }
    }
}

/// A photograph whose pixels are means over their area, as a camera's are; gray behind the ball.
fn photograph(disc: &Disc, optics: Optics, from: Direction, circle: Circle, side: usize) -> Image {
    const PARTS: usize = 4;
    let frame = frame(from);
    let mut image = Image::filled(side, side, [0.0; 3]);
    for (index, pixel) in image.pixels.iter_mut().enumerate() {
        let mut sum = 0.0;
        for part in 0..PARTS * PARTS {
            let place = |i: usize, k: usize| i as f64 + (k as f64 + 0.5) / PARTS as f64;
            let x = place(index % side, part % PARTS) - circle.x;
            let y = place(index / side, part / PARTS) - circle.y;
            sum += match mirrored(optics, x / circle.radius, -y / circle.radius) {
                Some(r) => disc.at(std::array::from_fn(|c| {
                    (0..3).map(|k| r[k] * frame[k][c]).sum()
                })),
                None => 0.5,
            };
        }
        *pixel = [(sum / (PARTS * PARTS) as f64) as f32; 3];
    }
    image
}

/// Where a photograph shows a direction, and its pixels a radian along the radius there.
fn place(photo: &Photo, direction: Direction) -> Option<([f64; 2], f64)> {
    let frame = frame(photo.from);
    let [x, y, z] = [0, 1, 2].map(|k| dot(frame[k], direction));
    let alpha = photo.optics.point(x.hypot(y).atan2(z))?;
    let radius = photo.circle.radius * photo.optics.radius(alpha) / x.hypot(y).max(1e-12);
    let pixels = photo.circle.radius * photo.optics.slope(alpha);
    Some(([radius * x, radius * y], pixels))
}

/// How far a direction lies from the disc's edge, pixels: the least over the photographs that count there.
fn pixels_from_edge(photos: &[Photo], disc: &Disc, direction: Direction) -> f64 {
    let shown = |photo: &Photo| place(photo, direction).map_or(0.0, |(_, pixels)| pixels);
    let best = photos.iter().map(shown).fold(0.0, f64::max);
    let counts = photos.iter().filter(|p| shown(p) >= ENOUGH * best);
    let nearest = counts.filter_map(|photo| {
        let ([x, y], _) = place(photo, direction)?;
        let edge = disc.edge().filter_map(|d| place(photo, d));
        let distance = |([a, b], _): ([f64; 2], f64)| (a - x).hypot(b - y);
        Some(edge.map(distance).fold(f64::INFINITY, f64::min))
    });
    nearest.fold(f64::INFINITY, f64::min)
}

/// How far a photograph blurs, pixels: a pixel's mean reaches half a pixel beyond an edge, interpolation a whole one.
const BLUR: f64 = 1.5;

/// Largest relative error of a texel all of which lies outside the blur of the disc's edge, and where: degrees from the
/// edge.
fn worst(photos: &[Photo], disc: &Disc) -> (f64, f64) {
    let size = (360, 180);
    let map = unwrap(photos, Projection::Polar, size, [1.0; 3]).unwrap();
    let at = |x: f64, y: f64| Projection::Polar.direction(size, x, y).unwrap();
    let mut errors: Vec<(f64, usize)> = (0..size.0 * size.1)
        .map(|i| {
            let middle = at((i % 360) as f64 + 0.5, (i / 360) as f64 + 0.5);
            let error = f64::from(map.image.pixels[i][0]) / disc.at(middle) - 1.0;
            (error.abs(), i)
        })
        .collect();
    errors.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (error, i) in errors {
        let (x, y) = ((i % 360) as f64, (i / 360) as f64);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        let mut around = corners.iter().map(|(dx, dy)| at(x + dx, y + dy));
        if around.all(|d| pixels_from_edge(photos, disc, d) > BLUR) {
            let from_middle = dot(at(x + 0.5, y + 0.5), disc.middle).clamp(-1.0, 1.0);
            return (error, (from_middle.acos() - disc.radius).abs().to_degrees());
        }
    }
    (0.0, 0.0)
}

/// The worst error where two balls, the second's radius scaled, show the disc, `degrees` from behind the first toward
/// the second.
fn two_balls(optics: Optics, degrees: f64, scale: f64) -> (f64, f64) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let disc = Disc {
        middle: [-cos * 0.98, 0.199, -sin * 0.98],
        radius: 5f64.to_radians(),
        radiance: 1000.0,
    };
    let shots = [([1.0, 0.0, 0.0], 95.0), ([0.0, 0.0, 1.0], 95.0 * scale)];
    let shots = shots.map(|(from, radius)| {
        let (x, y) = (100.3, 99.8);
        let circle = Circle { x, y, radius };
        (photograph(&disc, optics, from, circle, 200), circle, from)
    });
    let photos = shots.each_ref().map(|(image, circle, from)| Photo {
        image,
        circle: *circle,
        from: *from,
        optics,
    });
    worst(&photos, &disc)
}

#[test]
fn the_gains_of_two_balls_are_found_within_a_hundredth() {
    let disc = Disc {
        middle: [0.6, 0.48, 0.64],
        radius: 20f64.to_radians(),
        radiance: 30.0,
    };
    for optics in [Optics::Orthographic, Optics::Near(6.0)] {
        let (x, y) = (100.3, 99.8);
        let circle = Circle { x, y, radius: 95.0 };
        let froms = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let mut images = froms.map(|from| photograph(&disc, optics, from, circle, 200));
        let gains = [1.25, 0.8, 1.0];
        for pixel in &mut images[1].pixels {
            *pixel = std::array::from_fn(|c| pixel[c] * gains[c]);
        }
        let photo = |k: usize| Photo {
            image: &images[k],
            circle,
            from: froms[k],
            optics,
        };
        let found = super::gains(&[photo(0), photo(1)]).unwrap();
        for (c, gain) in gains.into_iter().enumerate() {
            let ratio = found.factors[0][c] / found.factors[1][c];
            assert!(
                (ratio / f64::from(gain) - 1.0).abs() < 0.01,
                "{optics:?} {c}: {ratio}"
            );
        }
    }
}

#[test]
fn a_bright_disc_at_one_balls_rim_does_not_leak_where_the_other_sees_it() {
    for optics in [Optics::Orthographic, Optics::Near(6.0)] {
        // From behind the first ball to where both see alike, and a second ball of fewer pixels.
        for (degrees, scale) in [
            (0.0, 1.0),
            (10.0, 1.0),
            (25.0, 1.0),
            (44.0, 1.0),
            (50.0, 0.6),
        ] {
            let (error, off) = two_balls(optics, degrees, scale);
            println!("{optics:?}, {degrees} degrees, {scale}: {error:.2e}, {off:.1} degrees off");
            // The disc is a thousand times as bright: a leak of 1e-5 would be 1 %.
            assert!(
                error < 0.01,
                "{optics:?}, disc {degrees} degrees behind, scale {scale}: {error} at {off} degrees"
            );
        }
    }
}
