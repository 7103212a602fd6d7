//! Statistics of a page.

use crate::seams::SeamStats;
use ambient::Estimate;
use serde::{Deserialize, Serialize};

/// Sums over the finished texels of a page.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PageStats {
    /// Texels that a chart touches.
    pub texels: u64,
    /// Sum of their coverage: used area in texels.
    pub coverage: f64,
    /// Texels of which nothing can be seen.
    pub buried: u64,
    /// Area in texels of what cannot be seen.
    pub buried_area: f64,
    /// Standard errors of diffuse as the rays and the denoiser leave them.
    pub errors: ErrorSums,
    /// The same as the page has them in the end, with what seams moved texels by; `None` where they moved none.
    #[serde(default)]
    pub shown: Option<ErrorSums>,
    /// Sum of the squared standard error of irradiance.
    pub irradiance_squares: f64,
    /// Rays spent, those of all gathers of bounces and lights included.
    pub rays: u64,
    /// Both sides of seams, once the page is finished.
    pub seams: SeamStats,
    /// Seconds spent on tiles, on finishing the page, and on its part of the gathers.
    pub seconds: f64,
}

/// Values from here on show in a picture of 8 bits.
const SEEN: f64 = 1.0 / 255.0;

/// Moments and maximum of standard errors over texels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorSums {
    /// Sum.
    pub sum: f64,
    /// Sum of squares.
    pub squares: f64,
    /// Sum of fourth powers, times the number of texels that share an error.
    pub fourths: f64,
    /// The largest.
    pub max: f64,
    /// The first texel (column, row) that has it.
    pub worst: [u32; 2],
    /// The largest share of the value, of texels whose value is at least 1/255.
    pub relative: f64,
}

impl ErrorSums {
    /// Counts a texel's value with its standard error.
    pub(crate) fn add(&mut self, estimate: Estimate, texel: [u32; 2]) {
        let Estimate { value, std_err } = estimate;
        if value >= SEEN {
            self.relative = self.relative.max(std_err / value);
        }
        self.sum += std_err;
        self.squares += std_err * std_err;
        self.fourths += std_err.powi(4);
        if std_err > self.max {
            (self.max, self.worst) = (std_err, texel);
        }
    }

    /// Counts texels as fewer after a smoothing that brought the sum of squares down from `before`: a mean of m texels
    /// has an m-th of their variance, and m texels share it.
    pub(crate) fn share(&mut self, before: f64) {
        if self.squares > 0.0 {
            self.fourths *= (before / self.squares).max(1.0);
        }
    }

    /// Counts those of later texels.
    fn append(&mut self, later: &Self) {
        self.sum += later.sum;
        self.squares += later.squares;
        self.fourths += later.fourths;
        self.relative = self.relative.max(later.relative);
        if later.max > self.max {
            (self.max, self.worst) = (later.max, later.worst);
        }
    }
}

impl PageStats {
    /// Counts the texels of a later tile.
    pub(crate) fn append(&mut self, tile: &Self) {
        self.texels += tile.texels;
        self.coverage += tile.coverage;
        self.buried += tile.buried;
        self.buried_area += tile.buried_area;
        self.errors.append(&tile.errors);
        self.irradiance_squares += tile.irradiance_squares;
        self.rays += tile.rays;
    }

    /// Texels that can be seen, in part at least. Errors are those of these.
    pub fn seen(&self) -> u64 {
        self.texels - self.buried
    }

    /// Standard errors of diffuse as the layer `error` has them.
    pub fn shown(&self) -> &ErrorSums {
        self.shown.as_ref().unwrap_or(&self.errors)
    }

    /// Estimated root mean square error of the diffuse term over the texels that can be seen: that of the layer
    /// `error`.
    pub fn rmse(&self) -> f64 {
        (self.shown().squares / self.seen().max(1) as f64).sqrt()
    }

    /// The part of [`PageStats::rmse`] that rays and denoiser leave, before seams move texels.
    pub fn rmse_rays(&self) -> f64 {
        (self.errors.squares / self.seen().max(1) as f64).sqrt()
    }

    /// Estimated root mean square error of the irradiance over the texels, mean of its channels.
    pub fn irradiance_rmse(&self) -> f64 {
        (self.irradiance_squares / self.seen().max(1) as f64).sqrt()
    }

    /// What the true root mean square error that the rays leave stays below with 99.9 % confidence.
    ///
    /// The sum of squared errors of independent normal texels has the relative variance `2/t`, its estimate from two
    /// replicates each as much, where `t = (Σ s²)² / Σ s⁴` counts unequal texels as fewer. The normal quantile is 3.09.
    pub fn rmse_bound(&self) -> f64 {
        if self.errors.squares == 0.0 {
            return 0.0;
        }
        let relative = self.errors.fourths / (self.errors.squares * self.errors.squares);
        self.rmse_rays() * (1.0 + 3.09 * (4.0 * relative).sqrt()).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stats(texels: u64, errors: &[f64]) -> PageStats {
        let mut stats = PageStats {
            texels,
            coverage: texels as f64 / 2.0,
            buried: 1,
            buried_area: 0.25,
            irradiance_squares: 3.0,
            rays: 10 * texels,
            ..PageStats::default()
        };
        for (x, &std_err) in errors.iter().enumerate() {
            let estimate = Estimate {
                value: 0.5,
                std_err,
            };
            stats.errors.add(estimate, [x as u32, texels as u32]);
        }
        stats
    }

    #[test]
    fn tiles_add_up_to_their_page() {
        let mut page = stats(3, &[0.25, 0.5]);
        page.append(&stats(4, &[0.5, 0.125, 1.0]));
        let errors = ErrorSums {
            sum: 2.375,
            squares: 0.0625 + 0.25 + 0.25 + 0.015_625 + 1.0,
            fourths: 0.003_906_25 + 0.0625 + 0.0625 + 0.000_244_140_625 + 1.0,
            max: 1.0,
            worst: [2, 4],
            relative: 2.0,
        };
        let sum = PageStats {
            texels: 7,
            coverage: 3.5,
            buried: 2,
            buried_area: 0.5,
            errors,
            irradiance_squares: 6.0,
            rays: 70,
            ..PageStats::default()
        };
        assert_eq!(page, sum);
        assert_eq!(page.seen(), 5);
        // Of equal errors the first texel's place is kept.
        page.append(&stats(9, &[1.0]));
        assert_eq!(page.errors.worst, [2, 4]);
    }

    #[test]
    fn a_bound_of_the_error_counts_unequal_texels_as_fewer() {
        let mut page = stats(5, &[]);
        assert_eq!(page.rmse_bound(), 0.0);
        page.shown = Some(ErrorSums {
            squares: 36.0,
            ..ErrorSums::default()
        });
        (page.errors.squares, page.errors.fourths) = (4.0, 24.0);
        let rmse = [page.rmse(), page.rmse_rays(), page.irradiance_rmse()];
        assert_eq!(rmse, [3.0, 1.0, 0.75f64.sqrt()]);
        // t = 4² / 24 = 2/3, so the relative variance (2 + 2) / t is 6.
        let bound = (1.0 + 3.09 * 6.0f64.sqrt()).sqrt();
        assert!(
            (page.rmse_bound() - bound).abs() < 1e-14,
            "{}",
            page.rmse_bound()
        );
    }
}
