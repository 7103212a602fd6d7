//! What a luminous ball sends to a small surface, of which it may stand partly below the horizon.

use std::f64::consts::PI;

/// E/(pi L) of a surface under a ball of radiance L that nothing hides: the form factor of the surface to the ball.
///
/// * `cos`: cosine of the angle between the surface's normal and the ball's middle, -1..=1.
/// * `square`: (radius / distance of the middle)², 0..=1.
///
/// J. Snyder, "Area Light Sources for Real-Time Graphics" (1996), whose integral is that of the cap's projection onto
/// the plane of the surface.
///
/// ```
/// use ambake_ambient::closed_form::ball;
/// // Above the horizon it is that of its middle.
/// assert_eq!(ball(0.8, 0.25), 0.25 * 0.8);
/// // A ball that touches the surface from above fills half of the sphere.
/// assert!((ball(1.0, 1.0) - 1.0).abs() < 1e-15);
/// assert_eq!(ball(-0.8, 0.25), 0.0);
/// ```
pub fn ball(cos: f64, square: f64) -> f64 {
    let (cos, square) = (cos.clamp(-1.0, 1.0), square.clamp(0.0, 1.0));
    if cos * cos >= square {
        return square * cos.max(0.0);
    }
    let sin = (1.0 - cos * cos).sqrt();
    // Cotangent of the ball's half angle, and where the horizon cuts its disc.
    let x = (1.0 / square - 1.0).sqrt();
    let y = (-x * cos / sin).clamp(-1.0, 1.0);
    let chord = sin * (1.0 - y * y).sqrt();
    let above = (cos * y.acos() - x * chord) * square + chord.atan2(x);
    (above / PI).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// The same by the midpoint rule over the ball's cone, with as many steps in its cosine as around it.
    fn sum(cos: f64, square: f64) -> f64 {
        let steps = 20_000;
        let (sin, half) = ((1.0 - cos * cos).sqrt(), 1.0 - (1.0 - square).sqrt());
        let mut sum = 0.0;
        for i in 0..steps {
            let off = (f64::from(i) + 0.5) / f64::from(steps) * half;
            let (c, s) = (1.0 - off, (off * (2.0 - off)).sqrt());
            // The integral of max(0, a + b cos φ) over a turn.
            let (a, b) = (cos * c, sin * s);
            sum += if a >= b {
                TAU * a
            } else if a <= -b {
                0.0
            } else {
                let cut = (-a / b).acos();
                2.0 * (a * cut + b * cut.sin())
            };
        }
        sum * half / f64::from(steps) / PI
    }

    #[test]
    fn balls_above_across_and_below_the_horizon_are_the_integral_over_their_cones() {
        for square in [1e-6, 0.01, 0.2, 0.5, 0.9, 0.999] {
            for k in -20..=20 {
                let cos = f64::from(k) / 20.0;
                let (found, exact) = (ball(cos, square), sum(cos, square));
                assert!(
                    (found - exact).abs() < 1e-6 * square.max(1e-3),
                    "{cos} {square}: {found} {exact}"
                );
            }
        }
        // Continuous where the ball meets the horizon.
        let edge = 0.3_f64.sqrt();
        for side in [edge, -edge] {
            let step = ball(side + 1e-9, 0.3) - ball(side - 1e-9, 0.3);
            assert!(step.abs() < 1e-8, "{step}");
        }
    }
}
