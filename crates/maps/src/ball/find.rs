//! The outline of a ball in a photograph, by its edge.
//!
//! Every edge votes for the middles on its normal (C. Kimme, D. Ballard, J. Sklansky, "Finding Circles by an Array of
//! Accumulators", 1975) in a reduced picture. The middle and radius whose circle carries most edges are then fitted to
//! the steepest points of radial profiles, by least squares of the distance without outliers, up to full resolution.

use super::gray::Gray;
use super::photo::Circle;
use environment::{Error, Image};
use std::f64::consts::TAU;

/// An outline that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// The outline.
    pub circle: Circle,
    /// Root mean square distance of the rim's edge points from it, pixels.
    pub residual: f64,
    /// Part of the rim, 0..=1, whose steepest point lies within a pixel of it; a quarter does by chance.
    pub rim: f64,
}

/// Longest side of the picture in which edges vote.
const VOTING_SIDE: usize = 384;

/// Smallest radius, in pixels of that picture.
const MIN_RADIUS: f64 = 8.0;

/// Half the length of a radial profile, pixels; half of it once a fit has settled.
const REACH: f64 = 4.0;

/// The part of a rim that is enough.
const ENOUGH: f64 = 0.5;

/// The outline of the ball in `image`, which lies inside the picture.
///
/// ```
/// use environment::Image;
/// use ambake_maps::ball;
/// let mut image = Image::filled(120, 100, [0.1; 3]);
/// for (at, pixel) in image.pixels.iter_mut().enumerate() {
///     let (x, y) = ((at % 120) as f64 + 0.5, (at / 120) as f64 + 0.5);
///     if (x - 63.0).hypot(y - 48.0) < 35.0 {
///         *pixel = [1.0; 3];
///     }
/// }
/// let circle = ball::find(&image)?.circle;
/// assert!((circle.x - 63.0).abs() < 0.5 && (circle.radius - 35.0).abs() < 0.5, "{circle:?}");
/// # Ok::<(), environment::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] where no circle has an edge on half of its rim.
pub fn find(image: &Image) -> Result<Found, Error> {
    let mut levels = vec![Gray::of(image)];
    while levels[levels.len() - 1].longest() > VOTING_SIDE {
        let half = levels[levels.len() - 1].half();
        levels.push(half);
    }
    let coarse = &levels[levels.len() - 1];
    let best = candidates(coarse)
        .into_iter()
        .map(|circle| fit(coarse, circle))
        .max_by(|a, b| score(a).total_cmp(&score(b)));
    let found = best.map(|mut found| {
        for level in levels.iter().rev().skip(1) {
            let c = found.circle;
            let doubled = Circle {
                x: 2.0 * c.x,
                y: 2.0 * c.y,
                radius: 2.0 * c.radius,
            };
            found = fit(level, doubled);
        }
        found
    });
    let refused = |what: String| {
        Err(Error::Shape(format!(
            "no ball is found: {what}; give --circle X,Y,R"
        )))
    };
    match found {
        Some(found) if found.rim >= ENOUGH => Ok(found),
        Some(Found { circle: c, rim, .. }) => refused(format!(
            "the best circle, {:.1},{:.1},{:.1}, has an edge on {:.0} % of its rim",
            c.x,
            c.y,
            c.radius,
            100.0 * rim
        )),
        None => refused("the picture has no edges".into()),
    }
}

/// A pixel on an edge: its centre and the unit normal of the edge.
struct Edge {
    x: f64,
    y: f64,
    normal: [f64; 2],
}

/// Pixels whose gradient is the largest along itself and above the mean.
fn edges(gray: &Gray) -> Vec<Edge> {
    let (w, h) = (gray.width, gray.height);
    if w < 3 || h < 3 {
        return Vec::new();
    }
    let gradient = |x: usize, y: usize| {
        let row = |dy: usize| gray.at(x + 1, y + dy - 1) - gray.at(x - 1, y + dy - 1);
        let column = |dx: usize| gray.at(x + dx - 1, y + 1) - gray.at(x + dx - 1, y - 1);
        [
            row(0) + 2.0 * row(1) + row(2),
            column(0) + 2.0 * column(1) + column(2),
        ]
    };
    let mut field = vec![[0.0; 2]; w * h];
    for y in 1..h - 1 {
        for x in 1..w - 1 {
            field[y * w + x] = gradient(x, y);
        }
    }
    let size = |x: usize, y: usize| field[y * w + x][0].hypot(field[y * w + x][1]);
    let total: f64 = field.iter().map(|g| g[0].hypot(g[1])).sum();
    let least = total / (w * h) as f64;
    let mut found = Vec::new();
    for y in 1..h - 1 {
        for x in 1..w - 1 {
            let length = size(x, y);
            if length <= least {
                continue;
            }
            let normal = field[y * w + x].map(|v| v / length);
            let [dx, dy] = normal.map(|v| v.round() as isize);
            let near = |s: isize| {
                size(
                    (x as isize + s * dx) as usize,
                    (y as isize + s * dy) as usize,
                )
            };
            if length >= near(1) && length > near(-1) {
                let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
                found.push(Edge { x, y, normal });
            }
        }
    }
    found
}

/// Circles that carry many edges, the best of each of the most voted middles.
fn candidates(gray: &Gray) -> Vec<Circle> {
    const MIDDLES: usize = 24;
    let edges = edges(gray);
    let (w, h) = (gray.width, gray.height);
    let room = |x: f64, y: f64| x.min(y).min(w as f64 - x).min(h as f64 - y) + 1.0;
    let mut votes = vec![0u32; w * h];
    for edge in &edges {
        for side in [-1.0, 1.0] {
            let mut r = MIN_RADIUS;
            loop {
                let (x, y) = (
                    edge.x + side * r * edge.normal[0],
                    edge.y + side * r * edge.normal[1],
                );
                if !(0.0..w as f64).contains(&x) || !(0.0..h as f64).contains(&y) {
                    break;
                }
                if r <= room(x, y) {
                    votes[y as usize * w + x as usize] += 1;
                }
                r += 1.0;
            }
        }
    }
    // Votes of a fine edge miss the middle by a pixel or two.
    let sum = |x: usize, y: usize| -> u32 {
        let rows = y.saturating_sub(2)..(y + 3).min(h);
        rows.map(|j| {
            let row = &votes[j * w..(j + 1) * w];
            row[x.saturating_sub(2)..(x + 3).min(w)].iter().sum::<u32>()
        })
        .sum()
    };
    let mut places: Vec<(u32, usize)> = (0..w * h).map(|i| (sum(i % w, i / w), i)).collect();
    places.sort_unstable_by_key(|(votes, i)| (std::cmp::Reverse(*votes), *i));
    let mut middles: Vec<(f64, f64)> = Vec::new();
    for (votes, i) in places {
        let (x, y) = ((i % w) as f64 + 0.5, (i / w) as f64 + 0.5);
        if votes == 0 || middles.len() == MIDDLES {
            break;
        }
        if middles.iter().all(|m| (m.0 - x).hypot(m.1 - y) > 3.0) {
            middles.push((x, y));
        }
    }
    let circle = |(x, y): (f64, f64)| carried(&edges, x, y, room(x, y));
    middles.into_iter().filter_map(circle).collect()
}

/// The circle about a middle with edges on the largest part of its rim.
fn carried(edges: &[Edge], x: f64, y: f64, room: f64) -> Option<Circle> {
    let radii = room as usize + 1;
    // Arcs of two pixels that hold an edge along the rim, by radius.
    let arcs = |r: usize| (0.5 * TAU * r as f64).ceil() as usize + 1;
    let mut held: Vec<Vec<bool>> = (0..=radii).map(|r| vec![false; arcs(r)]).collect();
    for edge in edges {
        let (dx, dy) = (edge.x - x, edge.y - y);
        let distance = dx.hypot(dy);
        let along = (edge.normal[0] * dx + edge.normal[1] * dy).abs();
        if distance < MIN_RADIUS || along < 0.94 * distance {
            continue;
        }
        let turn = dy.atan2(dx) / TAU + 0.5;
        let nearest = distance.round() as usize;
        for r in nearest - 1..=nearest + 1 {
            if let Some(ring) = held.get_mut(r) {
                let arc = (turn * ring.len() as f64) as usize;
                let last = ring.len() - 1;
                ring[arc.min(last)] = true;
            }
        }
    }
    let part = |ring: &Vec<bool>| ring.iter().filter(|b| **b).count() as f64 / ring.len() as f64;
    let rings = held.iter().enumerate().skip(MIN_RADIUS as usize);
    let (r, _) = rings.max_by(|a, b| part(a.1).total_cmp(&part(b.1)))?;
    Some(Circle {
        x,
        y,
        radius: r as f64,
    })
}

/// The circle near `start` that fits the steepest points of its radial profiles.
///
/// Just inside the rim a ball shows its whole back, in rings that are edges too. So the fit begins on both sides of the
/// start, and the circle on which most points lie closest wins.
fn fit(gray: &Gray, start: Circle) -> Found {
    let begin = |off: f64| {
        let radius = (start.radius + off).max(1.0);
        settled(gray, Circle { radius, ..start })
    };
    let fits = [0.0, -2.5, 2.5].map(begin);
    let closest = |a: &&Found, b: &&Found| score(a).total_cmp(&score(b));
    fits.iter().max_by(closest).copied().unwrap_or(fits[0])
}

/// More for a larger part of the rim and a smaller residual.
fn score(found: &Found) -> f64 {
    found.rim * (1.0 - found.residual)
}

fn settled(gray: &Gray, start: Circle) -> Found {
    let mut circle = start;
    for reach in [REACH, 0.5 * REACH] {
        for _ in 0..12 {
            let next = adjusted(circle, &steepest(gray, circle, reach));
            let moved =
                (next.x - circle.x).hypot(next.y - circle.y) + (next.radius - circle.radius).abs();
            circle = next;
            if moved < 1e-4 {
                break;
            }
        }
    }
    let points = steepest(gray, circle, REACH);
    let near = points.iter().map(|p| p[2]).filter(|d| d.abs() <= 1.0);
    let near: Vec<f64> = near.collect();
    let square: f64 = near.iter().map(|d| d * d).sum();
    Found {
        circle,
        residual: (square / near.len().max(1) as f64).sqrt(),
        rim: near.len() as f64 / points.len() as f64,
    }
}

/// Cosine, sine and distance beyond the circle of the steepest point of every radial profile.
///
/// The slope is that of the picture under a Gaussian of one pixel, whose highest point lies on the edge of a step.
fn steepest(gray: &Gray, circle: Circle, reach: f64) -> Vec<[f64; 3]> {
    const STEPS: usize = 2; // samples a pixel
    let half = reach as usize * STEPS;
    let kernel: Vec<f64> = (-3 * STEPS as isize..=3 * STEPS as isize)
        .map(|k| k as f64 / STEPS as f64)
        .map(|t| t * (-0.5 * t * t).exp())
        .collect();
    let count = (TAU * circle.radius).clamp(90.0, 2000.0) as usize;
    let point = |i: usize| {
        let (sin, cos) = (TAU * i as f64 / count as f64).sin_cos();
        let samples: Vec<f64> = (0..2 * half + kernel.len() + 2)
            .map(|k| {
                let t = (k as f64 - (half + kernel.len() / 2 + 1) as f64) / STEPS as f64;
                let r = circle.radius + t;
                gray.bilinear(circle.x + r * cos, circle.y + r * sin)
            })
            .collect();
        let slopes: Vec<f64> = samples
            .windows(kernel.len())
            .map(|w| w.iter().zip(&kernel).map(|(a, b)| a * b).sum::<f64>().abs())
            .collect();
        let highest = slopes[1..slopes.len() - 1]
            .iter()
            .copied()
            .fold(0.0, f64::max);
        let peak = |k: &usize| {
            let v = slopes[*k];
            v >= 0.5 * highest && v >= slopes[k - 1] && v >= slopes[k + 1]
        };
        let steepest = |k: &usize| slopes[*k] == highest;
        let inner = 1..slopes.len() - 1;
        let top = inner
            .clone()
            .rev()
            .find(peak)
            .or(inner.clone().find(steepest))
            .unwrap_or(1);
        let [a, b, c] = [slopes[top - 1], slopes[top], slopes[top + 1]];
        let bend = a - 2.0 * b + c;
        // At the end of a profile the highest slope is no peak.
        let shift = if bend < 0.0 {
            (0.5 * (a - c) / bend).clamp(-0.5, 0.5)
        } else {
            0.0
        };
        [
            cos,
            sin,
            (top as f64 - 1.0 - half as f64 + shift) / STEPS as f64,
        ]
    };
    (0..count).map(point).collect()
}

/// The circle moved to the least squares of the points' distances, without those far from the median.
fn adjusted(circle: Circle, points: &[[f64; 3]]) -> Circle {
    let middle = |mut values: Vec<f64>| {
        let at = values.len() / 2;
        *values.select_nth_unstable_by(at, f64::total_cmp).1
    };
    let mut change = [0.0; 3];
    for _ in 0..8 {
        let off = |p: &[f64; 3]| p[2] - change[0] * p[0] - change[1] * p[1] - change[2];
        let spread = middle(points.iter().map(|p| off(p).abs()).collect());
        let limit = (3.0 * spread).clamp(0.25, REACH);
        let kept = points.iter().filter(|p| off(p).abs() <= limit);
        // Distance beyond the circle = dx cos + dy sin + dr.
        let (mut matrix, mut right) = ([0.0; 9], [0.0; 3]);
        for [cos, sin, d] in kept {
            let row = [*cos, *sin, 1.0];
            for i in 0..3 {
                right[i] += row[i] * d;
                for j in 0..3 {
                    matrix[3 * i + j] += row[i] * row[j];
                }
            }
        }
        if !ambient::solve::cholesky(&mut matrix, &mut right) {
            return circle;
        }
        change = right;
    }
    Circle {
        x: circle.x + change[0],
        y: circle.y + change[1],
        radius: circle.radius + change[2],
    }
}
