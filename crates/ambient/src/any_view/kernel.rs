//! What a lobe weighs each harmonic with, by the angle between normal and view.

use super::basis::{Basis, PAIRS};
use crate::convention::lobe_scale;
use crate::ggx::Ggx;
use crate::quadrature::GAUSS_32;
use std::f64::consts::{FRAC_PI_2, PI};

/// The lobe about the mirrored view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lobe {
    /// (R·L)^n of this exponent, `>= 0`.
    Phong(f64),
    /// GGX of this α, without Fresnel's colour: the share of the lobe that is open.
    Ggx(f64),
}

/// The kernel of a lobe for one angle: the mean of y(l, m) over it, by [`super::pair`], with the mirrored view in the
/// plane y = 0 at x >= 0. The first is the term of an open texel: G for Phong, 1 for GGX.
pub type Kernel = [f64; PAIRS];

/// The kernel of a lobe seen at `theta` from the normal, radians, `0..=π/2`.
///
/// Phong: integrated over the lune in the coordinates of the paper's (14), where the lobe separates; within 1e-7 of the
/// closed form for n = 0 and n >= 1, within 1e-6 between. GGX: by the quadrature of its open albedo.
pub fn kernel(basis: &Basis<f64>, lobe: Lobe, theta: f64) -> Kernel {
    let mut sums = [0.0; PAIRS];
    let mut add = |x: f64, y: f64, weight: f64| {
        for (sum, value) in sums.iter_mut().zip(basis.even_at(x, y)) {
            *sum += weight * value;
        }
    };
    match lobe {
        Lobe::Phong(n) => phong(n, theta, &mut add),
        Lobe::Ggx(alpha) => {
            let mut all = 0.0;
            Ggx::new(alpha, theta.cos()).integrate(&mut |drawn, weight| {
                let weight = weight * drawn.weight;
                all += weight;
                // The view stands at x > 0 there, its mirror image at x < 0.
                add(-drawn.direction.x, drawn.direction.y, weight);
            });
            if all > 0.0 {
                sums = sums.map(|sum| sum / all);
            }
        }
    }
    sums
}

/// Nodes over the lune of a Phong lobe: tangential coordinates and weights. Half of it; the other is its mirror image.
fn phong(n: f64, theta: f64, add: &mut impl FnMut(f64, f64, f64)) {
    // Beyond, cos^n is below 1e-10.
    let reach = (46.0 / n.max(1e-9)).sqrt().min(FRAC_PI_2);
    let nodes = |start, end| nodes(start, end, n < SMOOTH);
    let (sin, cos) = theta.sin_cos();
    let scale = 2.0 * lobe_scale(n);
    let (start, end) = ((theta - FRAC_PI_2).max(-reach), reach);
    for (b, weight_b) in nodes(0.0, reach) {
        let (sin_b, cos_b) = b.sin_cos();
        let weight_b = weight_b * scale * cos_b.powf(n + 1.0);
        for (a, weight_a) in nodes(start, end) {
            // From R toward N by a in the plane of both, then out of it by b.
            let (sin_a, cos_a) = a.sin_cos();
            let x = cos_b * (cos_a * sin - sin_a * cos);
            add(x, sin_b, weight_a * weight_b * cos_a.powf(n));
        }
    }
}

/// From this exponent on, powers of a cosine are smooth enough where the cosine ends.
const SMOOTH: f64 = 8.0;

/// The 32-point rule on an interval. `drawn`: drawn toward its ends, where low powers of a cosine need not be smooth.
fn nodes(start: f64, end: f64, drawn: bool) -> impl Iterator<Item = (f64, f64)> {
    let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
    let place = move |t: f64, w: f64| {
        let (at, slope) = match drawn {
            false => (t, 1.0),
            true => ((FRAC_PI_2 * t).sin(), FRAC_PI_2 * (FRAC_PI_2 * t).cos()),
        };
        (middle + half * at, w * half * slope)
    };
    let both = move |(x, w): (f64, f64)| [x, -x].map(|t| place(t, w));
    GAUSS_32.into_iter().flat_map(both)
}

/// Angle of a column of a table, radians: equal steps from 0 to π/2.
pub(super) fn angle(column: usize, columns: usize) -> f64 {
    0.5 * PI * column as f64 / (columns - 1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::any_view::{ORDER, bands, index, pair, pairs};
    use crate::closed_form::phong_open_angle;

    #[test]
    fn open_hemisphere_is_the_closed_form_at_every_angle() {
        let basis = Basis::new();
        for n in [0.0, 0.3, 1.0, 2.5, 5.0, 20.0, 50.0, 1000.0] {
            for degrees in [0, 10, 30, 45, 60, 75, 85, 89, 90] {
                let theta = f64::from(degrees).to_radians();
                let found = kernel(&basis, Lobe::Phong(n), theta)[0];
                let exact = phong_open_angle(n, theta);
                let error = (found - exact).abs();
                assert!(
                    error < if n < 1.0 { 1e-6 } else { 1e-7 },
                    "n {n}, {degrees}: off by {error:e}"
                );
            }
        }
    }

    #[test]
    fn along_the_normal_bands_are_those_of_funk_and_hecke() {
        let basis = Basis::new();
        for n in [0.0, 1.0, 7.5, 60.0] {
            let found = kernel(&basis, Lobe::Phong(n), 0.0);
            let bands = bands(Lobe::Phong(n), ORDER + 1);
            for l in (0..=ORDER).step_by(2) {
                let exact = bands[l] * ((2 * l + 1) as f64).sqrt();
                let error = (found[pair(l, 0)] - exact).abs();
                assert!(error < 1e-6, "n {n}, l {l}: off by {error:e}");
            }
            // Nothing else looks the same all around.
            assert!(found[pair(4, 2)].abs() < 1e-9 && found[pair(1, 1)].abs() < 1e-9);
        }
    }

    #[test]
    fn kernel_of_ggx_is_its_mean_over_drawn_directions() {
        let basis = Basis::new();
        for (alpha, degrees) in [(0.09, 30.0_f64), (0.25, 60.0), (0.64, 80.0), (1.0, 0.0)] {
            let theta = degrees.to_radians();
            let found = kernel(&basis, Lobe::Ggx(alpha), theta);
            let ggx = Ggx::new(alpha, theta.cos());
            let (mut sums, mut all) = ([0.0; PAIRS], 0.0);
            let count = 200;
            for k in 0..count * count {
                let u = [k / count, k % count].map(|k| (f64::from(k) + 0.5) / f64::from(count));
                let drawn = ggx.sample(u);
                let values = basis.at(-drawn.direction.x, drawn.direction.y);
                all += drawn.weight;
                for (l, m) in pairs(ORDER) {
                    sums[pair(l, m)] += drawn.weight * values[index(l, m as isize)];
                }
            }
            for (k, (found, sum)) in found.iter().zip(sums).enumerate() {
                // What forty thousand equal steps miss.
                assert!(
                    (found - sum / all).abs() < 2e-3,
                    "alpha {alpha}, {degrees}, {k}: {found} for {}",
                    sum / all
                );
            }
        }
    }
}
