//! Exact solid angles of squares in disc projections.

use ambient::quadrature::GAUSS_8;

/// Solid angle of a rectangle in the orthographic picture of a hemisphere, clipped by the rim.
///
/// The corner function A(x, y) = ∫∫ 1/z over 0..x, 0..y is x asin(y/√(1-x²)) + y asin(x/√(1-y²)) - atan(xy/z) inside
/// the disc and π/2 (x + y - 1) outside; it is odd in both.
pub(super) fn ortho([x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) -> f64 {
    if nearest(x0, x1).hypot(nearest(y0, y1)) >= 1.0 {
        return 0.0;
    }
    let corner = |x: f64, y: f64| {
        let (a, b) = (x.abs(), y.abs());
        let rest = 1.0 - a * a - b * b;
        let value = if rest > 0.0 {
            let z = rest.sqrt();
            a * b.atan2(z) + b * a.atan2(z) - (a * b).atan2(z)
        } else {
            std::f64::consts::FRAC_PI_2 * (a + b - 1.0)
        };
        value * x.signum() * y.signum() * f64::from(u8::from(a > 0.0 && b > 0.0))
    };
    (corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)).max(0.0)
}

/// Integral over a rectangle of a density that depends on the radius and ends at 1.
///
/// `flux(r²)` times (x, y) is a field with that density as its divergence; outside the disc the field is
/// `(x, y) total / r²`. The integral is the flow through the four edges (Gauss-Legendre, exact to rounding).
pub(super) fn radial(
    [x0, x1]: [f64; 2],
    [y0, y1]: [f64; 2],
    flux: impl Fn(f64) -> f64,
    total: f64,
) -> f64 {
    if nearest(x0, x1).hypot(nearest(y0, y1)) >= 1.0 {
        return 0.0;
    }
    let field = |s: f64| if s < 1.0 { flux(s) } else { total / s };
    // Flow through the line at distance c, from a to b, cut where it crosses the rim.
    let edge = |c: f64, a: f64, b: f64| {
        let cross = (1.0 - c * c).max(0.0).sqrt();
        let mut cuts = [a, (-cross).clamp(a, b), cross.clamp(a, b), b];
        cuts.sort_by(f64::total_cmp);
        let pieces = cuts.windows(2).filter(|p| p[1] > p[0]);
        let sum = |p: &[f64]| {
            // Eight nodes are exact to rounding on a quarter of the radius.
            let count = ((p[1] - p[0]) * 4.0).ceil();
            let half = 0.5 * (p[1] - p[0]) / count;
            let at = |t: f64| field(c * c + t * t);
            let part = |k: usize| {
                let middle = p[0] + (2.0 * k as f64 + 1.0) * half;
                let pair =
                    |(x, w): &(f64, f64)| w * (at(middle - half * x) + at(middle + half * x));
                half * GAUSS_8.iter().map(pair).sum::<f64>()
            };
            (0..count as usize).map(part).sum::<f64>()
        };
        c * pieces.map(sum).sum::<f64>()
    };
    (edge(x1, y0, y1) - edge(x0, y0, y1) + edge(y1, x0, x1) - edge(y0, x0, x1)).max(0.0)
}

/// The smallest magnitude in an interval.
fn nearest(a: f64, b: f64) -> f64 {
    if a * b <= 0.0 {
        0.0
    } else {
        a.abs().min(b.abs())
    }
}
