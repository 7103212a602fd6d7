//! Projections onto discs: orthographic hemispheres, mirrored ball, angular map. Coordinates in -1..1, y up.

use super::Direction;
use std::f64::consts::PI;

pub(super) fn ortho(x: f64, y: f64, side: f64) -> Option<Direction> {
    let rest = 1.0 - x * x - y * y;
    (rest >= 0.0).then(|| [x, y, side * rest.sqrt()])
}

/// The mirror direction of a distant viewer at +z on the unit sphere.
pub(super) fn ball(x: f64, y: f64) -> Option<Direction> {
    let rest = 1.0 - x * x - y * y;
    (rest >= 0.0).then(|| {
        let twice = 2.0 * rest.sqrt();
        [twice * x, twice * y, 2.0 * rest - 1.0]
    })
}

pub(super) fn ball_place([x, y, z]: Direction) -> (f64, f64) {
    on_circle(x, y, (0.5 * (1.0 - z)).max(0.0).sqrt())
}

pub(super) fn angular(x: f64, y: f64) -> Option<Direction> {
    let r = x.hypot(y);
    (r <= 1.0).then(|| {
        let (sin, cos) = (PI * r).sin_cos();
        let scale = if r > 0.0 { sin / r } else { PI };
        [scale * x, scale * y, cos]
    })
}

pub(super) fn angular_place([x, y, z]: Direction) -> (f64, f64) {
    on_circle(x, y, x.hypot(y).atan2(z) / PI)
}

/// The place at radius `r` in the direction of `(x, y)`; straight down where that has none.
fn on_circle(x: f64, y: f64, r: f64) -> (f64, f64) {
    let length = x.hypot(y);
    if length > 0.0 {
        (x / length * r, y / length * r)
    } else {
        (0.0, -r)
    }
}

/// π sin(πr) / r, the solid angle by area.
pub(super) fn angular_density(x: f64, y: f64) -> f64 {
    let r = x.hypot(y);
    if r >= 1.0 {
        0.0
    } else if r > 0.0 {
        PI * (PI * r).sin() / r
    } else {
        PI * PI
    }
}

/// (1 - cos πr) / r² of s = r²: the field (x, y) · this has the density as its divergence.
pub(super) fn angular_flux(s: f64) -> f64 {
    let half = 0.5 * PI * s.sqrt();
    let sinc = if half > 1e-9 { half.sin() / half } else { 1.0 };
    0.5 * PI * PI * sinc * sinc
}
