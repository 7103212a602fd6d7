//! Gains between photographs of one place that were exposed or developed a little differently, from what they both
//! show.
//!
//! With the film's response undone, a photograph is the radiance times one unknown number a channel. Where two
//! photographs show the same direction, the difference of their logarithms is that of their gains. Its median over all
//! such directions is not moved by lights, things that moved, and noise; gains of all photographs follow from the
//! medians of all pairs by least squares, and so do their errors.

use ambient::solve::cholesky;
use environment::Error;

/// One direction that two photographs show.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Both {
    /// Their numbers; the first is the smaller.
    pub photos: [usize; 2],
    /// What they show.
    pub values: [[f64; 3]; 2],
}

/// What photographs are to be multiplied by, so that they agree.
#[derive(Debug, Clone, PartialEq)]
pub struct Gains {
    /// Factors of red, green and blue for each photograph. Those of all photographs have the geometric mean 1.
    pub factors: Vec<[f64; 3]>,
    /// Their standard errors as shares of them.
    pub std_err: Vec<[f64; 3]>,
}

/// Directions darker than this share of the middle of their pair do not count: there noise is large beside the value.
const DARK: f64 = 0.1;

/// Fewest directions that a pair of photographs shares.
const FEWEST: usize = 8;

/// What the median of a normal distribution errs by, over its mean.
const MEDIAN: f64 = 1.2533;

/// The deviation of a normal distribution over the median of absolute deviations.
const ABSOLUTE: f64 = 1.4826;

impl Gains {
    /// Photographs as they are.
    pub fn none(count: usize) -> Gains {
        Gains {
            factors: vec![[1.0; 3]; count],
            std_err: vec![[0.0; 3]; count],
        }
    }

    /// The gains of `count` photographs.
    ///
    /// # Errors
    /// [`Error::Shape`] where some photograph shares too few directions with the others.
    pub(crate) fn of(count: usize, shared: &[Both]) -> Result<Gains, Error> {
        let mut gains = Gains::none(count);
        for channel in 0..3 {
            let pairs = pairs(count, shared, channel);
            if let Some(alone) = alone(count, &pairs) {
                return Err(Error::Shape(format!(
                    "photograph {} shows too little that another shows as well; take wider photographs or leave their \
                     gains as they are by --gains off",
                    alone + 1
                )));
            }
            let (logs, errors) = solve(count, &pairs);
            for photo in 0..count {
                gains.factors[photo][channel] = logs[photo].exp();
                gains.std_err[photo][channel] = errors[photo];
            }
        }
        Ok(gains)
    }
}

/// What a pair of photographs tells: the logarithm of the first one's factor less that of the second, and its variance.
struct Pair {
    photos: [usize; 2],
    log: f64,
    variance: f64,
}

fn pairs(count: usize, shared: &[Both], channel: usize) -> Vec<Pair> {
    let mut lists: Vec<Vec<[f64; 2]>> = vec![Vec::new(); count * count];
    for both in shared {
        let [a, b] = both.values.map(|rgb| rgb[channel]);
        if a > 0.0 && b > 0.0 {
            let [first, second] = both.photos;
            lists[first * count + second].push([a.ln(), b.ln()]);
        }
    }
    let lists = lists.into_iter().enumerate();
    let pair = |(at, list): (usize, Vec<[f64; 2]>)| {
        // Brightness is told from both alike, so that no gain chooses its directions.
        let level = median(list.iter().map(|[a, b]| 0.5 * (a + b)).collect())?;
        let bright = list
            .iter()
            .filter(|[a, b]| 0.5 * (a + b) > level + DARK.ln());
        let differences: Vec<f64> = bright.map(|[a, b]| b - a).collect();
        if differences.len() < FEWEST {
            return None;
        }
        let log = median(differences.clone())?;
        let off = median(differences.iter().map(|d| (d - log).abs()).collect())?;
        // No photograph is finer than f32.
        let spread = (MEDIAN * ABSOLUTE * off).max(1e-7);
        Some(Pair {
            photos: [at / count, at % count],
            log,
            variance: spread * spread / differences.len() as f64,
        })
    };
    lists.filter_map(pair).collect()
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    let (_, found, _) =
        (!values.is_empty()).then(|| values.select_nth_unstable_by(middle, f64::total_cmp))?;
    Some(*found)
}

/// A photograph that no chain of pairs joins to the first.
fn alone(count: usize, pairs: &[Pair]) -> Option<usize> {
    let mut joined = vec![false; count];
    joined[0] = true;
    for _ in 1..count {
        for Pair { photos: [a, b], .. } in pairs {
            let either = joined[*a] || joined[*b];
            (joined[*a], joined[*b]) = (either, either);
        }
    }
    joined.iter().position(|joined| !joined)
}

/// Logarithms of the factors, whose sum is 0, and their standard errors.
fn solve(count: usize, pairs: &[Pair]) -> (Vec<f64>, Vec<f64>) {
    // The sum is held at 0 by one more square, as heavy as the pairs are.
    let weigh = |pair: &Pair| 1.0 / pair.variance;
    let heavy = pairs.iter().map(weigh).fold(0.0, f64::max);
    let mut matrix = vec![heavy; count * count];
    let mut right = vec![0.0; count];
    for pair in pairs {
        let ([a, b], weight) = (pair.photos, weigh(pair));
        matrix[a * count + a] += weight;
        matrix[b * count + b] += weight;
        matrix[a * count + b] -= weight;
        matrix[b * count + a] -= weight;
        right[a] += weight * pair.log;
        right[b] -= weight * pair.log;
    }
    let solved = |mut right: Vec<f64>| {
        let mut matrix = matrix.clone();
        assert!(cholesky(&mut matrix, &mut right), "joined photographs");
        right
    };
    let logs = solved(right);
    let residual = |pair: &Pair| {
        let [a, b] = pair.photos;
        weigh(pair) * (logs[a] - logs[b] - pair.log).powi(2)
    };
    // More pairs than photographs tell whether the pairs' own errors are right.
    let spare = (pairs.len() + 1).saturating_sub(count);
    let squares: f64 = pairs.iter().map(residual).sum();
    let scale = if spare > 0 {
        (squares / spare as f64).max(1.0)
    } else {
        1.0
    };
    let error = |photo: usize| {
        let mut unit = vec![0.0; count];
        unit[photo] = 1.0;
        let held = 1.0 / (heavy * (count * count) as f64);
        (scale * (solved(unit)[photo] - held)).max(0.0).sqrt()
    };
    (logs.clone(), (0..count).map(error).collect())
}
