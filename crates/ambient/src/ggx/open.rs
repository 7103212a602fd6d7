//! What an open GGX surface reflects, by quadrature over directions of light.
//!
//! Polar angle and azimuth are counted from the mirrored view, where the lobe has its peak. Beside it lie scales that
//! differ by factors of a million: the lobe is as wide as α, light is masked within the smaller of α and N·V of the
//! horizon, Fresnel's term has a kink within N·V of the backward view. Seen on a logarithmic scale all of them are a
//! few units wide. So each interval `x` is walked in `y` with `x = scale sinh y`, in panels that a Gauss rule
//! integrates. Nothing is differenced: distances from the peak and from the horizon are the variables.

use super::{Albedos, Drawn, Ggx, LEAST_COS};
use crate::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::{LazyLock, OnceLock};

/// The rule of a panel.
static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(16));
/// Longest panel in y.
const PANEL: f64 = 5.0;
/// Widest scale of an azimuth: wider ones are even.
const EVEN: f64 = 3.0;
/// Cosine of a view along the normal: what is reflected is even in the angle, and moves by less than 1e-7 within this
/// one.
const ALONG: f64 = 1.0 - 1e-12;
/// Steps of the table, in roughness and in the root of the cosine.
const STEPS: usize = 128;
/// Steps of it that a value between them is taken from.
const NEAR: usize = 6;
/// Least roughness that is looked up at a slant. The lobes of smoother surfaces are masked within less than a step of
/// the horizon.
const LEAST_ROUGHNESS: f64 = 0.1;

impl Ggx {
    /// A and B under an open sky of 1, within 1e-6 at every α and view. Few of them are integrated: most are
    /// polynomials between those of a table, which integrates what is asked of it once.
    pub fn open(&self) -> Albedos {
        if self.view.z >= ALONG || self.alpha.sqrt() >= LEAST_ROUGHNESS {
            return self.looked_up();
        }
        self.integrated()
    }

    fn looked_up(&self) -> Albedos {
        static TABLE: LazyLock<Vec<OnceLock<Albedos>>> =
            LazyLock::new(|| vec![OnceLock::new(); (STEPS + 1) * (STEPS + 1)]);
        let at = |step: usize| (step as f64 / STEPS as f64).powi(2);
        let known = |rough: usize, cos: usize| {
            let cell = &TABLE[rough * (STEPS + 1) + cos];
            let cosine = LEAST_COS + (1.0 - LEAST_COS) * at(cos);
            cell.get_or_init(|| Ggx::new(at(rough), cosine).integrated())
        };
        let (rough, rows) = near(self.alpha.sqrt());
        let up = match self.view.z >= ALONG {
            true => 1.0,
            false => ((self.view.z - LEAST_COS).max(0.0) / (1.0 - LEAST_COS)).sqrt(),
        };
        let (cos, columns) = near(up);
        let [mut tinted, mut white] = [0.0; 2];
        for (i, row) in rows.iter().enumerate() {
            // On a step of the table, as along the normal, all but one of the weights are 0.
            for (j, column) in columns.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                let albedos = known(rough + i, cos + j);
                tinted += row * column * albedos.tinted;
                white += row * column * albedos.white;
            }
        }
        Albedos { tinted, white }
    }

    fn integrated(&self) -> Albedos {
        let [mut tinted, mut white] = [0.0; 2];
        self.integrate(&mut |drawn, weight| {
            tinted += weight * drawn.weight * (1.0 - drawn.fresnel);
            white += weight * drawn.weight * drawn.fresnel;
        });
        Albedos { tinted, white }
    }

    /// Hands directions above the surface with y >= 0 to `add`, with weights whose sum is the share of the points of
    /// [`Ggx::sample`] that rise above the surface. The other half of the directions is its mirror image in the plane
    /// of the view.
    pub fn integrate(&self, add: &mut impl FnMut(Drawn, f64)) {
        let (alpha, cos) = (self.alpha, self.view.z);
        let theta = self.view.x.atan2(cos);
        // From the mirrored view down to the horizon.
        let down = FRAC_PI_2 - theta;
        let shallow = alpha.min(cos);
        for (up, weight) in graded(2.0 * shallow, theta) {
            self.ring(-up, down + up, weight, add);
        }
        for (step, weight) in graded(2.0 * alpha, 0.5 * down) {
            self.ring(step, down - step, weight, add);
        }
        for (height, weight) in graded(shallow, 0.5 * down) {
            self.ring(down - height, height, weight, add);
        }
    }

    /// Integrates one polar angle, times `weight`: `below` the mirrored view and `height` above the horizon, radians.
    fn ring(&self, below: f64, height: f64, weight: f64, add: &mut impl FnMut(Drawn, f64)) {
        let (alpha2, v) = (self.alpha * self.alpha, self.view);
        let (l, s) = (height.sin(), height.cos());
        // 1 + L·V at the azimuth of the mirrored view, and 1/D there but for factors.
        let half = 0.5 * (PI - 2.0 * height - below);
        let least = 2.0 * half.cos().powi(2);
        let (sin, cos) = (0.5 * below).sin_cos();
        let peak = 2.0 * least * (sin * sin + alpha2 * cos * cos);
        let turned = s * v.x;
        let masked = self.weight(DVec3::new(0.0, s, l));
        let scale = (peak / turned).sqrt().min(EVEN);
        for (azimuth, width) in graded(scale, PI) {
            let rise = (0.5 * azimuth).sin().powi(2);
            let along = least + 2.0 * turned * rise;
            let spread = 2.0 * along / (peak + 4.0 * turned * rise);
            let pdf = alpha2 * spread * spread / (2.0 * PI * self.seen());
            let drawn = Drawn {
                direction: DVec3::new(-s * azimuth.cos(), s * azimuth.sin(), l),
                weight: masked,
                fresnel: super::fresnel((0.5 * along).sqrt()),
            };
            add(drawn, 2.0 * pdf * s * weight * width);
        }
    }
}

/// The steps of the table beside `place`, 0..=1: the first of [`NEAR`], and the weights of Lagrange's polynomial on
/// them.
fn near(place: f64) -> (usize, [f64; NEAR]) {
    let place = place * STEPS as f64;
    let first = (place as usize + 1)
        .saturating_sub(NEAR / 2)
        .min(STEPS + 1 - NEAR);
    let t = place - first as f64;
    let weights = std::array::from_fn(|i| {
        let others = (0..NEAR).filter(|&j| j != i);
        let factor = |j: usize| (t - j as f64) / (i as f64 - j as f64);
        others.map(factor).product()
    });
    (first, weights)
}

/// Places and weights on `0..length` for an integrand with features at `scale` and wider ones.
fn graded(scale: f64, length: f64) -> impl Iterator<Item = (f64, f64)> {
    let end = (length / scale).asinh();
    let panels = (end / PANEL).ceil();
    let half = 0.5 * end / panels;
    (0..panels as usize).flat_map(move |panel| {
        let middle = half * (2 * panel + 1) as f64;
        RULE.iter().map(move |(x, w)| {
            let y = middle + half * x;
            (scale * y.sinh(), scale * y.cosh() * half * w)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// α, N·V, A and B at random places, even in the logarithms: `quad` of QUADPACK, nested, over the slopes of
    /// microfacets in polar coordinates, a form that shares neither variables nor formulas with this file.
    const SLOPES: [[f64; 4]; 16] = [
        [0.0094, 0.0051, 0.1255807940, 0.7890306445],
        [0.0897, 0.0031, 0.5726494686, 0.4189649700],
        [0.0405, 0.0194, 0.3509598924, 0.5690317314],
        [0.0015, 0.0468, 0.2138444221, 0.7856129002],
        [0.0013, 0.0296, 0.1404703154, 0.8584910239],
        [0.0016, 0.0035, 0.0275887899, 0.8925129803],
        [0.0188, 0.3408, 0.8742772610, 0.1238630169],
        [0.0024, 0.008, 0.0490828758, 0.9033742005],
        [0.0763, 0.7225, 0.9874808076, 0.0025423548],
        [0.0539, 0.0235, 0.4167625870, 0.5073371910],
        [0.8487, 0.0027, 0.9328211323, 0.0534269718],
        [0.3762, 0.0121, 0.8537749640, 0.1215251137],
        [0.0027, 0.0041, 0.0413441130, 0.8566659121],
        [0.0084, 0.3188, 0.8531194373, 0.1464816217],
        [0.0001, 0.001, 0.0052378854, 0.9889447807],
        [0.25, 0.999999999, 0.9157850592, 0.0000273709],
    ];

    /// Largest difference between the table and the integral.
    fn off(ggx: &Ggx) -> f64 {
        let (found, exact) = (ggx.open(), ggx.integrated());
        let tinted = (found.tinted - exact.tinted).abs();
        tinted.max((found.white - exact.white).abs())
    }

    #[test]
    fn the_table_is_the_integral_within_1e_7_along_the_normal_and_1e_6_elsewhere() {
        for k in 0..=400 {
            // Between the steps of the table and on them.
            let alpha = (f64::from(k) / 400.0).powi(2);
            let worst = off(&Ggx::new(alpha, 1.0 - 1e-13 * f64::from(k % 10)));
            assert!(worst < 1e-7, "alpha {alpha}: off by {worst:e}");
        }
        for k in 0..4000 {
            // Roberts' sequence in the plane; half of the views near the horizon.
            let [u, v] = [0.754877666247, 0.569840290998].map(|step| (f64::from(k) * step).fract());
            let (alpha, cos) = (u * u, if k % 2 == 0 { v } else { v.powi(4) });
            let worst = off(&Ggx::new(alpha, cos));
            assert!(worst < 1e-6, "alpha {alpha}, cos {cos}: off by {worst:e}");
        }
    }

    #[test]
    fn albedos_are_those_of_adaptive_quadrature_over_slopes_within_a_millionth() {
        for [alpha, cos, tinted, white] in SLOPES {
            let found = Ggx::new(alpha, cos).open();
            let worst = (found.tinted - tinted)
                .abs()
                .max((found.white - white).abs());
            assert!(worst < 1e-7, "alpha {alpha}, cos {cos}: off by {worst:e}");
        }
    }

    #[test]
    fn albedos_are_the_mean_over_the_points_of_the_sampler() {
        for (alpha, cos) in [
            (0.25, 1.0),
            (0.64, 0.5),
            (1.0, 0.2),
            (0.3, 0.3),
            (0.04, 0.6),
        ] {
            let ggx = Ggx::new(alpha, cos);
            let Albedos { tinted, white } = ggx.open();
            let count = 2000;
            let mut sums = [0.0; 2];
            for k in 0..count * count {
                let u = [k / count, k % count].map(|k| (f64::from(k) + 0.5) / f64::from(count));
                let drawn = ggx.sample(u);
                sums[0] += drawn.weight * (1.0 - drawn.fresnel);
                sums[1] += drawn.weight * drawn.fresnel;
            }
            let [a, b] = sums.map(|sum| sum / f64::from(count * count));
            // A midpoint rule is off by a share of its step where directions end at the horizon.
            let worst = (tinted - a).abs().max((white - b).abs());
            assert!(
                worst < 0.1 / f64::from(count),
                "alpha {alpha}, cos {cos}: off by {worst:e}"
            );
        }
    }

    #[test]
    fn albedos_vary_evenly_between_any_two_places() {
        // Panels are added as α and N·V shrink; no step shows where one is.
        let at = |k: i32| {
            let t = f64::from(k) / 4000.0;
            Ggx::new(10f64.powf(-4.0 * t), 10f64.powf(-3.0 * t)).open()
        };
        let mut last = [at(0), at(1)];
        for k in 2..=4000 {
            let next = at(k);
            for of in [|a: Albedos| a.tinted, |a: Albedos| a.white] {
                let bend = of(next) - 2.0 * of(last[1]) + of(last[0]);
                assert!(bend.abs() < 1e-5, "{k}: {bend:e}");
            }
            last = [last[1], next];
        }
    }
}
