//! Which fit a texel takes: estimates of each fit's squared error, and the mean of the fits weighted by them.
//!
//! The rays of a texel come in two independent halves. Their mean M and half their difference H are fitted alike, so H², averaged
//! over neighbours, is the variance of a fit of M whatever the noise is like. From one candidate to the next smoother one the fit
//! moves by dM; the halves being independent, dM² - dH² is the square of what the truth moves by, without a term of the noise. The
//! error of each candidate follows from the one before: plus that square, minus the variance that was saved. Estimated so, from fine to
//! coarse, errors are far less noisy than if each fit were held against the plain values. They only choose; what is stated is another
//! matter ([`super::stated`]). After F. Rousselle, C. Knaus, M. Zwicker,
//! "Adaptive Rendering with Non-Local Means Filtering", 2012, who tell noise from detail by two halves.

use super::fit::{DEGREES, Fits, degrees, fit};
use super::plane::{Plane, TASK};
use super::stated::{Predicted, Squares};
use pulp::Arch;
use rayon::prelude::*;
use std::ops::Range;

/// Strides of the fits; at each a quadratic and a linear one compete.
pub(super) const STRIDES: &[usize] = &[2, 4, 8, 16, 32];

/// Rows on each side of a texel that its value depends on: fewer than a window of the widest stride, which is two strides; 16 over which
/// moves are averaged and 5 over which those of neighbours are pooled; and 5 from which strays ([`super::strays`]) are known.
pub(super) const REACH: usize = 3 * ALIGNED;

/// Windows begin at multiples of this row, whatever their stride.
pub(super) const ALIGNED: usize = STRIDES[STRIDES.len() - 1];

/// Stride from which on moves are averaged over 33 x 33 texels in place of 11 x 11: they change slowly by then, and fewer are mere noise.
const WIDE: usize = 16;

/// Standard deviations of its own noise by which a move must stand out to count.
const STANDS_OUT: f32 = 0.5;

/// Variances of the plain value by which both halves of a single texel must leave a fit to refuse it: a contact of one texel.
const REFUSES: f32 = 25.0;

/// Fits that no other follows from: without features they may be far from the truth where those of the next stride, with them, are not.
const ASIDE: usize = 2;

/// Channels of a term at most.
pub(super) const CHANNELS: usize = 3;

/// What is known of a texel while candidates are tried.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Texel {
    /// Variance of the plain mean; 0 where no ray of the neighbourhood disagrees, unless all of them met nothing that shines.
    pub plain: f32,
    /// No ray of the neighbourhood disagrees.
    pub agrees: bool,
    /// Squared bias that is seen of the texels about it.
    pub near_bias: f32,
    /// Variance and squared bias of the last candidate, mean of the channels.
    variance: f32,
    bias: f32,
    /// Sums over the candidates by their weights.
    weights: f32,
    variances: f32,
    half: f32,
    values: [f32; CHANNELS],
}

impl Texel {
    /// The mean of the candidates in one channel.
    pub fn value(&self, channel: usize) -> f32 {
        self.values[channel] / self.weights
    }

    /// What is predicted of its error and what its halves show; `plain` and `half` are the values before.
    pub fn squares(&self, plain: f32, half: f32, channels: usize) -> Squares {
        let moved =
            self.values[..channels].iter().sum::<f32>() / (channels as f32 * self.weights) - plain;
        let left = self.half / self.weights;
        Squares {
            predicted: Predicted {
                plain: self.plain,
                variance: self.variances,
                near_bias: self.near_bias,
            },
            seen_variance: left * left,
            seen_bias: moved * moved - (left - half) * (left - half),
        }
    }

    /// Counts a candidate of this error and variance, in units of `unit`. Errors below 1e-5 of it weigh alike, and so do those beyond 1e5.
    fn count(
        &mut self,
        [risk, variance]: [f32; 2],
        unit: f32,
        half: f32,
        value: impl Fn(usize) -> f32,
        channels: usize,
    ) {
        let inverse = 1.0 / (risk / unit).clamp(1e-5, 1e5);
        let square = inverse * inverse;
        let weight = square * square * square;
        self.weights += weight;
        self.variances += weight * variance;
        self.half += weight * half;
        for channel in 0..channels {
            self.values[channel] += weight * value(channel);
        }
    }
}

/// A chart, or a band of one, ready to be fitted.
#[derive(Debug)]
pub(super) struct Surface {
    /// 1 where it has texels.
    pub mask: Plane,
    /// What fits may follow beside the place.
    pub features: Vec<Plane>,
    /// The channels of M, then the mean channel of H.
    pub data: Vec<Plane>,
}

/// What all bands of a chart have in common: squares of half differences over all of it.
#[derive(Debug)]
pub(super) struct Whole {
    plain: f64,
    texels: f64,
    /// Of the fits of each stride.
    fitted: Vec<[f64; DEGREES]>,
}

impl Whole {
    /// Of one band, and which rows of it are its own.
    pub fn of(band: &Surface, rows: &Range<usize>) -> Self {
        let (mask, half) = (&band.mask, &band.data[band.data.len() - 1]);
        let mut fits: Fits = std::array::from_fn(|_| vec![Plane::like(mask)]);
        let mut fitted = |&stride: &usize| {
            let half = std::slice::from_ref(half);
            fit(mask, &band.features, half, stride, &mut fits);
            fits.each_ref().map(|fits| squares(&fits[0], rows))
        };
        Self {
            plain: squares(half, rows),
            texels: squares(mask, rows),
            fitted: STRIDES.iter().map(&mut fitted).collect(),
        }
    }

    /// With those of the next band.
    pub fn plus(mut self, next: Self) -> Self {
        self.plain += next.plain;
        self.texels += next.texels;
        let sums = self.fitted.as_flattened_mut().iter_mut();
        for (sum, next) in sums.zip(next.fitted.as_flattened()) {
            *sum += next;
        }
        self
    }
}

/// The texels of a surface after all candidates; `None` where the halves agree everywhere.
///
/// * `strides`: of the fits that compete.
/// * `whole`: of the chart that the surface is a band of.
/// * `near`: becomes the number of the surface's texels about each.
/// * `dark`: by the texel, the standard error of a neighbourhood of so many without light.
pub(super) fn choose(
    surface: &Surface,
    strides: &[usize],
    whole: Option<&Whole>,
    near: &mut Plane,
    dark: impl Fn(usize, f32) -> f32 + Sync,
) -> Option<Vec<Texel>> {
    let Surface {
        mask,
        features,
        data,
    } = surface;
    let channels = data.len() - 1;
    let half = &data[channels];
    let rows = 0..mask.height();
    let (all_plain, count) = match whole {
        Some(whole) => (whole.plain, whole.texels),
        None => (squares(half, &rows), squares(mask, &rows)),
    };
    let unit = (all_plain / count) as f32;
    if unit < f32::MIN_POSITIVE {
        return None;
    }
    let mean = |planes: &[Plane], i: usize| match channels {
        1 => planes[0].values[i],
        _ => planes[..channels].iter().map(|p| p.values[i]).sum::<f32>() / channels as f32,
    };
    let new = || Plane::like(mask);
    near.set_sums(|i| mask.values[i]);
    let mut far = new();
    far.set_wide_sums(|i| mask.values[i]);
    let (mut variances, mut moves) = (new(), new());
    variances.set_sums(|i| half.values[i] * half.values[i]);
    let mut texels = vec![Texel::default(); mask.values.len()];
    each(mask, &mut texels, |i, texel| {
        texel.plain = variances.values[i] / near.values[i];
        texel.agrees = texel.plain == 0.0;
        if texel.agrees && mean(data, i) == 0.0 {
            // What neighbours farther away met may reach here too.
            texel.plain = dark(i, near.values[i]).powi(2);
        }
        texel.variance = texel.plain;
        texel.count(
            [texel.plain; 2],
            unit,
            half.values[i],
            |channel| data[channel].values[i],
            channels,
        );
    });
    let mut fits: Fits = std::array::from_fn(|_| vec![new(); channels + 1]);
    let mut last = data.to_vec();
    for (number, &stride) in strides.iter().enumerate() {
        fit(mask, features, data, stride, &mut fits);
        // Texels that share one move.
        let shared = (stride * stride) as f32 / 4.0;
        for degree in 0..degrees(features) {
            let now = &fits[degree];
            let before = match degree {
                0 => &last,
                _ => &fits[degree - 1],
            };
            let moved = |i: usize, now: &[Plane], before: &[Plane]| {
                let dm = mean(now, i) - mean(before, i);
                let dh = now[channels].values[i] - before[channels].values[i];
                dm * dm - dh * dh
            };
            let squared = |i: usize| now[channels].values[i].powi(2);
            let squared_moves = |i: usize| moved(i, now, before);
            let about = if stride >= WIDE {
                variances.set_wide_sums(squared);
                moves.set_wide_sums(squared_moves);
                &far
            } else {
                variances.set_sums(squared);
                moves.set_sums(squared_moves);
                &*near
            };
            let all_fitted = match whole {
                Some(whole) => whole.fitted[number][degree],
                None => squares(&now[channels], &rows),
            };
            let reduced = (all_fitted / all_plain) as f32;
            each(mask, &mut texels, |i, texel| {
                let count = about.values[i];
                let variance = 0.5 * (variances.values[i] / count + reduced * texel.plain);
                let saved = texel.variance - variance;
                let noise = 2.0 * saved.max(0.0) * (shared / count).min(1.0).sqrt();
                // Its own noise must not speak for or against a texel's choice.
                let own = moved(i, now, before);
                let moves = (moves.values[i] - own) / (count - 1.0).max(1.0);
                let bias = texel.bias + (moves - STANDS_OUT * noise).max(0.0);
                // A texel of twice the value has twice the variance: two rays that meet in the dark are no detail.
                let brighter = (mean(data, i) / mean(now, i).max(f32::MIN_POSITIVE)).max(1.0);
                let alone = moved(i, now, data) - REFUSES * texel.plain * brighter;
                let value = |channel: usize| now[channel].values[i];
                let risk = (variance + bias).max(alone);
                let half = now[channels].values[i];
                texel.count([risk, variance], unit, half, value, channels);
                if degree < ASIDE {
                    (texel.variance, texel.bias) = (variance, bias);
                }
            });
        }
        std::mem::swap(&mut last, &mut fits[ASIDE - 1]);
    }
    // One texel's prediction is rough; neighbours pool theirs, as the plain values' do.
    variances.set_sums(|i| match mask.values[i] > 0.0 {
        true => texels[i].variances / texels[i].weights,
        false => 0.0,
    });
    moves.set_ring_sums(|i| match mask.values[i] > 0.0 && texels[i].weights > 0.0 {
        true => {
            texels[i]
                .squares(mean(data, i), half.values[i], channels)
                .seen_bias
        }
        false => 0.0,
    });
    let mut ring = new();
    ring.set_ring_sums(|i| mask.values[i]);
    each(mask, &mut texels, |i, texel| {
        texel.variances = variances.values[i] / near.values[i];
        texel.near_bias = moves.values[i] / ring.values[i].max(1.0);
    });
    Some(texels)
}

/// Updates the texels of the chart.
fn each(mask: &Plane, texels: &mut [Texel], update: impl Fn(usize, &mut Texel) + Sync) {
    let tasks = texels.par_chunks_mut(TASK).enumerate();
    tasks.for_each(|(task, chunk)| {
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for (k, texel) in chunk.iter_mut().enumerate() {
                    let i = task * TASK + k;
                    if mask.values[i] > 0.0 {
                        update(i, texel);
                    }
                }
            },
        );
    });
}

/// The sum of the squares over some rows, in a fixed order.
fn squares(plane: &Plane, rows: &Range<usize>) -> f64 {
    let of = |part: &[f32]| part.iter().map(|v| f64::from(v * v)).sum::<f64>();
    let values = &plane.values[rows.start * plane.width..rows.end * plane.width];
    let parts: Vec<f64> = values.par_chunks(TASK).map(of).collect();
    parts.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_weigh_by_the_sixth_power_of_their_error() {
        // Errors are squared already as risks: 2 against 1 is a sixty-fourth.
        let mut texel = Texel::default();
        texel.count([1.0; 2], 1.0, 0.25, |_| 3.0, 1);
        texel.count([2.0; 2], 1.0, 0.5, |_| 7.0, 1);
        let share = 1.0 / 64.0;
        let expected = (3.0 + 7.0 * share) / (1.0 + share);
        assert!(
            (texel.value(0) - expected).abs() < 1e-6,
            "{}",
            texel.value(0)
        );
        // The unit does not matter; errors that are hardly any weigh alike.
        let mut other = Texel::default();
        other.count([100.0; 2], 100.0, 0.25, |_| 3.0, 1);
        other.count([200.0; 2], 100.0, 0.5, |_| 7.0, 1);
        assert!(
            (other.value(0) - expected).abs() < 1e-6,
            "{}",
            other.value(0)
        );
        let mut alike = Texel::default();
        alike.count([0.0; 2], 1.0, 0.0, |_| 3.0, 1);
        alike.count([1e-6; 2], 1.0, 0.0, |_| 7.0, 1);
        assert_eq!(alike.value(0), 5.0);
    }
}
