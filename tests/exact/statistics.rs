//! Judging errors by the estimator's own standard errors.
//!
//! A stored standard error comes from two independent randomisations of each texel of a neighbourhood. Three texels are
//! the fewest that any surface here has, so single texels are judged by Student's t with 3 degrees of freedom. Errors
//! of neighbours are independent or tend to cancel, so that the error of a mean over texels is at most what independent
//! ones would have.

use std::fmt;

/// One texel's signed error and its stored standard error.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    pub error: f64,
    pub standard_error: f64,
}

/// What the errors of one term over all texels say.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    pub texels: usize,
    pub rmse: f64,
    pub mean: f64,
    /// Mean over its standard error.
    pub mean_z: f64,
    pub max: f64,
    /// Smallest two-sided probability of a texel's t, times the number of texels.
    pub worst: f64,
    /// Squared errors over squared standard errors, summed over texels; 1 is expected.
    pub ratio: f64,
    /// Standard deviation of `ratio` for normal errors.
    pub ratio_deviation: f64,
}

impl Verdict {
    /// True where the error is at most `limit`, the mean shows no bias, and the standard errors are honest. Errors
    /// below `grain`, the share of one ray, are too few steps to have a spread.
    pub fn passes(&self, limit: f64, grain: f64) -> bool {
        let unbiased = self.mean_z.abs() <= 3.0 || self.mean.abs() < 1e-6;
        let honest = (self.ratio - 1.0).abs() <= 4.0 * self.ratio_deviation || self.rmse < grain;
        self.rmse <= limit && unbiased && honest && self.worst >= 1e-3
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            texels,
            rmse,
            mean,
            mean_z,
            max,
            worst,
            ratio,
            ratio_deviation,
        } = self;
        write!(
            f,
            "texels {texels:4} rmse {rmse:.6} mean {mean:+.7} z {mean_z:+.2} max {max:.6} "
        )?;
        write!(
            f,
            "worst t {worst:.3} ratio {ratio:.2} +- {ratio_deviation:.2}"
        )
    }
}

/// Judges `samples` of an estimator with `rays` rays a texel.
///
/// An estimate is a sum of `rays` equal shares, so below 1 / rays the spread of means says nothing: that much is
/// added to the standard error of single texels.
pub fn judge(samples: &[Sample], rays: f64) -> Verdict {
    let count = samples.len() as f64;
    let sum = |f: &dyn Fn(&Sample) -> f64| samples.iter().map(f).sum::<f64>();
    let squares = sum(&|s| s.error * s.error);
    let variance = sum(&|s| s.standard_error * s.standard_error);
    let mean = sum(&|s| s.error) / count;
    let worst = samples
        .iter()
        .map(|s| student_3_tail(s.error / s.standard_error.hypot(1.0 / rays)));
    // Squared errors have the relative variance 2, squared standard errors of two values 2; unequal texels weigh as
    // fewer. Standard errors are pooled over neighbours, which hides unequal texels: squared errors tell of them, too,
    // by their own fourth powers (three times their squares' square where all texels are equal and normal).
    let effective_of = |squares: f64, fourth: f64, equal: f64| {
        if fourth > 0.0 {
            equal * squares * squares / fourth
        } else {
            count
        }
    };
    let effective = effective_of(variance, sum(&|s| s.standard_error.powi(4)), 1.0)
        .min(effective_of(squares, sum(&|s| s.error.powi(4)), 3.0));
    Verdict {
        texels: samples.len(),
        rmse: (squares / count).sqrt(),
        mean,
        mean_z: if variance > 0.0 {
            mean * count / variance.sqrt()
        } else {
            0.0
        },
        max: samples.iter().map(|s| s.error.abs()).fold(0.0, f64::max),
        worst: worst.fold(1.0, f64::min) * count,
        ratio: if variance > 0.0 {
            squares / variance
        } else {
            1.0
        },
        ratio_deviation: (4.0 / effective).sqrt(),
    }
}

/// Probability that |t| is larger than that of a Student variable with 3 degrees of freedom.
pub fn student_3_tail(t: f64) -> f64 {
    let x = t.abs() / 3.0_f64.sqrt();
    // 1 - (2/pi) (x/(1+x^2) + atan x), from the far side so that small tails keep their digits.
    (2.0 / std::f64::consts::PI) * (x.recip().atan() - x / (1.0 + x * x))
}

#[test]
fn tail_of_student_3_agrees_with_its_table() {
    for (t, two_sided) in [
        (2.353_363, 0.1),
        (3.182_446, 0.05),
        (5.840_909, 0.01),
        (12.923_979, 0.001),
    ] {
        assert!(
            (student_3_tail(t) / two_sided - 1.0).abs() < 1e-6,
            "t = {t}: {}",
            student_3_tail(t)
        );
    }
    assert!((student_3_tail(0.0) - 1.0).abs() < 1e-15);
}
