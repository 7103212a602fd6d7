//! How much of each band of what is open a lobe passes on.

use super::kernel::Lobe;
use crate::ggx::Ggx;
use crate::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Bands that count.
pub(super) const BANDS: usize = 64;

/// Steps of the roughness of GGX: between them bands are linear.
const STEPS: usize = 32;

/// The first step that is integrated: lobes below are narrower than bands, and go over into a mirror, which passes
/// on all of each.
const FIRST: usize = 5;

/// Heights and azimuths of directions that a kernel is integrated over: so many times 1/α, and not fewer nor more
/// than these.
const NODES: f64 = 20.0;
const LEAST_NODES: f64 = 160.0;
const MOST_NODES: f64 = 800.0;

/// Cosines of views that a mean over all views is taken from.
const VIEWS: usize = 12;

/// How much of each band of a visibility a lobe passes on, from l = 0, root mean square over all views; at most 64.
///
/// Phong: 1, (n+1)/(n+2), … (Funk-Hecke), by the recurrence m(l) = m(l-2) (n - l + 2) / (n + l + 1) of the moments ∫
/// x^n P_l, which holds for any real n. GGX: its lobe is another for each view, so b(l)² = Σ k(l, m; θ)² / (l + 1)
/// is a mean over the views of the hemisphere, with the kernels k of the [module](super).
pub fn bands(lobe: Lobe, count: usize) -> Vec<f64> {
    let mut bands = match lobe {
        Lobe::Phong(n) => {
            let mut bands: Vec<f64> = vec![1.0, (n + 1.0) / (n + 2.0)];
            for l in 2..count {
                let order = l as f64;
                bands.push(bands[l - 2] * (n - order + 2.0) / (n + order + 1.0));
            }
            bands
        }
        Lobe::Ggx(alpha) => {
            let place = alpha.clamp(0.0, 1.0).sqrt() * STEPS as f64;
            let (low, high) = match place as usize {
                step if step < FIRST => (0, FIRST),
                step => (step.min(STEPS - 1), step.min(STEPS - 1) + 1),
            };
            let part = (place - low as f64) / (high - low) as f64;
            let both = of_step(low).iter().zip(of_step(high));
            both.map(|(low, high)| low + part * (high - low)).collect()
        }
    };
    bands.truncate(count);
    bands
}

/// The bands of GGX at a step of the roughness.
fn of_step(step: usize) -> &'static [f64; BANDS] {
    static ROWS: [OnceLock<[f64; BANDS]>; STEPS + 1] = [const { OnceLock::new() }; STEPS + 1];
    ROWS[step].get_or_init(|| match step {
        0 => [1.0; BANDS],
        _ => of_ggx((step as f64 / STEPS as f64).powi(2)),
    })
}

fn of_ggx(alpha: f64) -> [f64; BANDS] {
    let mut squares = [0.0; BANDS];
    for (node, weight) in gauss_legendre(VIEWS) {
        let kernel = kernel(&Ggx::new(alpha, 0.5 * (node + 1.0)));
        for (l, square) in squares.iter_mut().enumerate() {
            let passed: f64 = kernel[l].iter().map(|k| k * k).sum();
            *square += 0.5 * weight * passed / (l + 1) as f64;
        }
    }
    squares.map(f64::sqrt)
}

/// k(l, m) of GGX seen from one direction, band after band.
fn kernel(ggx: &Ggx) -> [[f64; BANDS]; BANDS] {
    let nodes = (NODES / ggx.alpha).clamp(LEAST_NODES, MOST_NODES) as usize;
    let mut sums = [[0.0; BANDS]; BANDS];
    for (node, weight) in gauss_legendre(nodes) {
        let z = 0.5 * (node + 1.0);
        let r = (1.0 - z * z).sqrt();
        // What the lobe is at this height, and what it weighs cos mφ with. It is even in φ.
        let mut ring = [0.0; BANDS];
        for step in 0..nodes {
            let (sin, cos) = (PI * (step as f64 + 0.5) / nodes as f64).sin_cos();
            // The view stands at x > 0 there, its mirror image at x < 0.
            let direction = DVec3::new(-r * cos, r * sin, z);
            let lobe = weight * ggx.pdf(direction) * ggx.weight(direction);
            let (mut before, mut turn) = (cos, 1.0);
            for sum in &mut ring {
                *sum += lobe * turn;
                (before, turn) = (turn, 2.0 * cos * turn - before);
            }
        }
        add(&mut sums, z, &ring);
    }
    let all = sums[0][0];
    sums.map(|band| band.map(|sum| sum / all))
}

/// Adds a ring at a height to the sums of all harmonics with l + m even, whose mean square is 1.
fn add(sums: &mut [[f64; BANDS]; BANDS], z: f64, ring: &[f64; BANDS]) {
    let r2 = 1.0 - z * z;
    let mut sectoral = 1.0;
    for (m, turn) in ring.iter().enumerate() {
        let square = |k: usize| (k * k) as f64;
        if m > 0 {
            sectoral *= (r2 * (2 * m + 1) as f64 / (2 * m) as f64).sqrt();
        }
        let twice = if m > 0 { 2f64.sqrt() } else { 1.0 };
        let (mut before, mut value) = (0.0, twice * sectoral);
        for (l, band) in sums.iter_mut().enumerate().skip(m) {
            if (l - m) % 2 == 0 {
                band[m] += turn * value;
            }
            let next = square(l + 1);
            let up = ((4.0 * next - 1.0) / (next - square(m))).sqrt();
            let down = match l > m {
                true => ((square(l) - square(m)) / (4.0 * square(l) - 1.0)).sqrt(),
                false => 0.0,
            };
            (before, value) = (value, up * (z * value - down * before));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::any_view::{Basis, ORDER, kernel as tabulated, pair};

    #[test]
    fn bands_of_ggx_are_those_of_its_kernels_seen_from_many_places() {
        let basis = Basis::new();
        let views = gauss_legendre(32);
        for roughness in [0.2, 0.4, 0.55, 0.7, 1.0_f64] {
            let alpha = roughness.powi(2);
            let found = bands(Lobe::Ggx(alpha), ORDER + 1);
            for (l, found) in found.iter().enumerate() {
                let of = |&(node, weight): &(f64, f64)| {
                    let theta = (0.5 * (node + 1.0)).acos();
                    let kernel = tabulated(&basis, Lobe::Ggx(alpha), theta);
                    let passed = (l % 2..=l).step_by(2).map(|m| kernel[pair(l, m)].powi(2));
                    0.5 * weight * passed.sum::<f64>() / (l + 1) as f64
                };
                let exact = views.iter().map(of).sum::<f64>().sqrt();
                let error = (found - exact).abs();
                // What lies between steps of the roughness, and of the views.
                assert!(error < 0.015, "{roughness}, l {l}: {found}, not {exact}");
            }
        }
    }

    #[test]
    fn bands_of_wide_ggx_hold_the_whole_kernel() {
        // The mean square of the kernel over the hemisphere is Σ (l + 1) b(l)² (Parseval).
        for (alpha, cos) in [(0.16, 0.9), (0.36, 0.5), (1.0, 0.2)] {
            let ggx = Ggx::new(alpha, cos);
            let held: f64 = kernel(&ggx).as_flattened().iter().map(|k| k * k).sum();
            let (mut all, mut squares) = (0.0, 0.0);
            ggx.integrate(&mut |drawn, weight| {
                let own = drawn.weight * ggx.pdf(drawn.direction);
                all += weight * drawn.weight;
                squares += weight * drawn.weight * own * 2.0 * PI;
            });
            let whole = squares / (all * all);
            assert!(
                (held / whole - 1.0).abs() < 0.01,
                "{alpha} {cos}: {held} of {whole}"
            );
        }
    }
}
