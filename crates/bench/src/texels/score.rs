//! How far looked-up values are from the truth.

use serde::Serialize;

/// Statistics of errors over points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Score {
    /// Points that were compared.
    pub points: usize,
    /// Largest absolute error.
    pub max: f64,
    /// Root mean square error.
    pub rmse: f64,
    /// 99.9th percentile of the absolute error.
    pub p999: f64,
    /// Mean of value minus truth: below 0 is too dark.
    pub bias: f64,
}

impl Score {
    /// The score of errors, value minus truth; all 0 where there are none.
    pub fn of(errors: &[f64]) -> Score {
        let mut sizes: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let count = errors.len().max(1) as f64;
        // The smallest size that 99.9 % of the points do not exceed.
        let rank = (0.999 * sizes.len() as f64).ceil() as usize;
        Score {
            points: errors.len(),
            max: sizes.last().copied().unwrap_or(0.0),
            rmse: (sizes.iter().map(|e| e * e).sum::<f64>() / count).sqrt(),
            p999: rank.checked_sub(1).map_or(0.0, |i| sizes[i]),
            bias: errors.iter().sum::<f64>() / count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_outlier_in_two_thousand_moves_the_maximum_and_not_the_percentile() {
        let mut errors = vec![0.01; 1999];
        errors.push(-0.5);
        let score = Score::of(&errors);
        assert_eq!((score.max, score.p999, score.points), (0.5, 0.01, 2000));
        let rmse = ((1999.0 * 1e-4 + 0.25) / 2000.0f64).sqrt();
        assert!((score.rmse - rmse).abs() < 1e-12, "{}", score.rmse);
        assert!((score.bias - (19.99 - 0.5) / 2000.0).abs() < 1e-12);
        assert_eq!(Score::of(&[]).max, 0.0);
    }
}
