//! Local regression over the texels of one surface, its window chosen per texel by an estimate of its own error.
//!
//! Each texel's value is fitted by polynomials of position and normal over windows of several sizes. A fit is a linear
//! combination of the texels' values, so its variance follows from theirs, and its mean squared error is estimated without
//! bias by Stein's formula from the distance to the unfitted value: C. Stein, "Estimation of the Mean of a Multivariate Normal
//! Distribution", 1981; for pictures: B. Moon, N. Carr, S.-E. Yoon, "Adaptive Rendering Based on Weighted Local Regression",
//! 2014; F. Rousselle, C. Knaus, M. Zwicker, "Adaptive Rendering with Non-Local Means Filtering", 2012. The estimate is
//! averaged over neighbours of the same surface, and the best candidate is taken; the plain value is one of them.

use super::field::Field;
use super::fit::{Design, LINEAR, TERMS};
use super::window::{Links, REACH, Walk, Window};
use rayon::prelude::*;

/// Denoised values in 0..=1, and standard errors with the estimated bias.
#[derive(Debug)]
pub(crate) struct Denoised {
    pub values: Vec<f32>,
    pub std_errs: Vec<f32>,
}

/// Windows (texels to each side) and terms of the regressions that a texel may take.
const CANDIDATES: [(usize, usize); 7] = [
    (1, LINEAR),
    (2, LINEAR),
    (3, LINEAR),
    (5, LINEAR),
    (2, TERMS),
    (3, TERMS),
    (5, TERMS),
];

/// Texels to each side over which the estimated error of a candidate is averaged.
const SMOOTH: usize = 3;

/// Rows that one task denoises; it fits `SMOOTH` more on either side.
const BAND: usize = 32;

/// A value, its variance and its estimated squared error.
#[derive(Debug, Clone, Copy, Default)]
struct Fit {
    value: f32,
    variance: f32,
    risk: f32,
}

/// The fits of one texel: the plain value, then every candidate.
type Fits = [Fit; CANDIDATES.len() + 1];

/// Denoises `value`, whose independent texels have the standard errors `error`.
pub(crate) fn denoise(field: &Field<'_>, value: &[f32], error: &[f32]) -> Denoised {
    let (size, links, walk) = (field.size, Links::of(field), Walk::new());
    let (mut values, mut errors) = (value.to_vec(), error.to_vec());
    values
        .par_chunks_mut(BAND * size)
        .zip(errors.par_chunks_mut(BAND * size))
        .enumerate()
        .for_each(|(band, (values, errors))| {
            let first = band * BAND;
            let last = first + values.len() / size;
            let from = first.saturating_sub(SMOOTH);
            let mut work = Work::new(field, &links, &walk);
            let fits: Vec<Fits> = (from * size..(last + SMOOTH).min(size) * size)
                .map(|texel| work.fits(texel, value, error))
                .collect();
            for (k, (value, error)) in values.iter_mut().zip(errors).enumerate() {
                let texel = first * size + k;
                if field.covered(texel) {
                    (*value, *error) = work.best(texel, |t| &fits[t - from * size]);
                }
            }
        });
    Denoised {
        values,
        std_errs: errors,
    }
}

/// What one task needs to fit texels.
struct Work<'a> {
    field: &'a Field<'a>,
    links: &'a Links,
    walk: &'a Walk,
    window: Window,
    design: Design,
}

impl<'a> Work<'a> {
    fn new(field: &'a Field<'a>, links: &'a Links, walk: &'a Walk) -> Self {
        Self {
            field,
            links,
            walk,
            window: Window {
                texels: Vec::new(),
                within: [0; REACH + 1],
            },
            design: Design::new(),
        }
    }

    /// The plain value and every candidate's fit of a texel.
    fn fits(&mut self, texel: usize, value: &[f32], error: &[f32]) -> Fits {
        let mut fits = Fits::default();
        if !self.field.covered(texel) {
            return fits;
        }
        let (plain, own) = (f64::from(value[texel]), f64::from(error[texel]).powi(2));
        fits[0] = Fit {
            value: value[texel],
            variance: own as f32,
            risk: own as f32,
        };
        let window = &mut self.window;
        self.walk
            .gather(self.field, self.links, texel, REACH, window);
        self.design.fill(self.field, window);
        let mut sums = [[[0.0; TERMS]; TERMS]; REACH + 1];
        for radius in 1..=REACH {
            sums[radius] = sums[radius - 1];
            if radius == 1 {
                self.design.accumulate(0, window.within[0], &mut sums[1]);
            }
            let (inner, outer) = (window.within[radius - 1], window.within[radius]);
            self.design.accumulate(inner, outer, &mut sums[radius]);
        }
        for (fit, (radius, terms)) in fits[1..].iter_mut().zip(CANDIDATES) {
            let constant = super::fit::constant(&sums[radius], terms);
            let (mut sum, mut variance, mut centre) = (0.0, 0.0, 0.0);
            for (j, &t) in window.texels[..window.within[radius]].iter().enumerate() {
                let weight = self.design.weight(j, &constant);
                sum += weight * f64::from(value[t]);
                variance += (weight * f64::from(error[t])).powi(2);
                if j == 0 {
                    centre = weight;
                }
            }
            let sum = sum.clamp(0.0, 1.0);
            *fit = Fit {
                value: sum as f32,
                variance: variance as f32,
                risk: ((sum - plain).powi(2) - own + 2.0 * centre * own) as f32,
            };
        }
        fits
    }

    /// Value and error of the candidate with the least estimated error about a covered texel.
    fn best<'f>(&mut self, texel: usize, fits: impl Fn(usize) -> &'f Fits) -> (f32, f32) {
        self.walk
            .gather(self.field, self.links, texel, SMOOTH, &mut self.window);
        let count = self.window.texels.len() as f64;
        let risk = |k: usize| -> f64 {
            let texels = self.window.texels.iter();
            texels.map(|&t| f64::from(fits(t)[k].risk)).sum::<f64>() / count
        };
        let (mut least, mut best) = (risk(0), 0);
        for k in 1..=CANDIDATES.len() {
            let risk = risk(k);
            if risk < least {
                (least, best) = (risk, k);
            }
        }
        let fit = fits(texel)[best];
        let variance = f64::from(fit.variance);
        let bias = (least - variance).max(0.0);
        (fit.value, (variance + bias).sqrt() as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rays::Mix;

    const SIZE: usize = 64;

    /// A flat square seen from above, with noise of one standard deviation added to `truth`; void on the right.
    struct Made {
        coverage: Vec<f32>,
        position: [Vec<f32>; 3],
        normal: [Vec<f32>; 3],
        object: Vec<f32>,
        truth: Vec<f64>,
        value: Vec<f32>,
    }

    fn made(sigma: f64, truth: fn(f64, f64) -> f64, object: fn(usize) -> f32) -> Made {
        let mut mix = Mix(5);
        let mut made = Made {
            coverage: Vec::new(),
            position: Default::default(),
            normal: Default::default(),
            object: Vec::new(),
            truth: Vec::new(),
            value: Vec::new(),
        };
        for i in 0..SIZE * SIZE {
            let (x, y) = (i % SIZE, i / SIZE);
            // What lies in the void is poison: nothing may read it.
            let void = if x >= SIZE - 4 { f32::NAN } else { 0.0 };
            let at = truth(x as f64 / SIZE as f64, y as f64 / SIZE as f64);
            let gauss = (0..12).map(|_| mix.unit()).sum::<f64>() - 6.0;
            made.coverage.push(if void.is_nan() { 0.0 } else { 1.0 });
            made.position[0].push(x as f32 + void);
            made.position[1].push(void);
            made.position[2].push(y as f32 + void);
            made.normal[0].push(void);
            made.normal[1].push(1.0 + void);
            made.normal[2].push(void);
            made.object.push(object(x) + void);
            made.truth.push(at);
            made.value.push((at + sigma * gauss) as f32 + void);
        }
        made
    }

    /// Root mean square error of the plain and of the denoised values, and the denoiser's own estimate of the latter.
    fn errors(made: &Made, sigma: f32) -> [f64; 3] {
        let field = Field {
            size: SIZE,
            coverage: &made.coverage,
            position: [&made.position[0], &made.position[1], &made.position[2]],
            normal: [&made.normal[0], &made.normal[1], &made.normal[2]],
            object: &made.object,
        };
        let found = denoise(&field, &made.value, &vec![sigma; SIZE * SIZE]);
        let covered: Vec<usize> = (0..SIZE * SIZE).filter(|&i| field.covered(i)).collect();
        let rms = |of: &dyn Fn(usize) -> f64| {
            (covered.iter().map(|&i| of(i) * of(i)).sum::<f64>() / covered.len() as f64).sqrt()
        };
        [
            rms(&|i| f64::from(made.value[i]) - made.truth[i]),
            rms(&|i| f64::from(found.values[i]) - made.truth[i]),
            rms(&|i| f64::from(found.std_errs[i])),
        ]
    }

    #[test]
    fn a_slope_is_smoothed_over_the_largest_window() {
        let made = made(0.02, |x, y| 0.2 + 0.3 * x + 0.2 * y, |_| 0.0);
        let [plain, denoised, stated] = errors(&made, 0.02);
        // Of 121 texels a linear fit leaves 0.09 of the noise, a quadratic one 0.14, one at a border twice that.
        assert!(denoised < 0.25 * plain, "{denoised} of {plain}");
        // Stein's estimate averaged over 49 texels has a deviation of √(2/49) of the variance; only its positive half, 0.4 of it
        // on average, counts as bias.
        let most = (denoised * denoised + 0.4 * (2.0_f64 / 49.0).sqrt() * 0.02 * 0.02).sqrt();
        assert!(
            (0.7 * denoised..=most).contains(&stated),
            "stated {stated}, true {denoised}, at most {most}"
        );
    }

    #[test]
    fn a_step_is_not_blurred() {
        let made = made(0.02, |x, _| if x < 0.5 { 0.2 } else { 0.8 }, |_| 0.0);
        let [plain, denoised, stated] = errors(&made, 0.02);
        assert!(denoised < plain, "{denoised} of {plain}");
        assert!(
            (0.6..=1.6).contains(&(stated / denoised)),
            "stated {stated}, true {denoised}"
        );
    }

    #[test]
    fn another_object_beside_is_never_mixed_in() {
        let made = made(
            0.02,
            |x, _| if x < 0.5 { 0.2 } else { 0.8 },
            |x| f32::from(u8::from(x >= SIZE / 2)),
        );
        let [plain, denoised, _] = errors(&made, 0.02);
        assert!(denoised < 0.25 * plain, "{denoised} of {plain}");
    }

    #[test]
    fn values_without_error_stay_as_they_are() {
        let made = made(
            0.0,
            |x, y| (3.0 * x).sin().abs() * 0.5 + 0.4 * y * y,
            |_| 0.0,
        );
        let [_, denoised, stated] = errors(&made, 0.0);
        assert!(
            denoised < 1e-6 && stated == 0.0,
            "{denoised}, stated {stated}"
        );
    }
}
