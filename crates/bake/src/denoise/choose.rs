//! Which fit a texel takes: estimates of each fit's squared error, and the mean of the fits weighted by them.
//!
//! The rays of a texel come in two independent halves. Their mean M and half their difference H are fitted alike, so
//! H², averaged over neighbours, is the variance of a fit of M whatever the noise is like. From one candidate to the
//! next smoother one the fit moves by dM; the halves being independent, dM² - dH² is the square of what the truth moves
//! by, without a term of the noise. The error of each candidate follows from the one before: plus that square, minus
//! the variance that was saved. Estimated so, from fine to coarse, errors are far less noisy than if each fit were held
//! against the plain values. They only choose; what is stated is another matter ([`super::stated`]). After F.
//! Rousselle, C. Knaus, M. Zwicker, "Adaptive Rendering with Non-Local Means Filtering", 2012, who tell noise from
//! detail by two halves.

use super::fit::Fitter;
use super::lanes::{LANES, Lanes};
use super::plane::{About, Room, Sheet, rows};
use super::surface::Surface;

/// Fits that compete, from fine to coarse: a stride, and whether its quadratic and its linear fits do. A quadratic fit
/// has about the variance of the linear one of half the stride, and less bias.
const FITS: [(usize, [bool; 2]); 5] = [
    (2, [true, false]),
    (4, [true, true]),
    (8, [true, true]),
    (16, [true, false]),
    (32, [false, true]),
];

/// Rows on each side of a texel that its value depends on: fewer than a window of the widest stride, which is two
/// strides; 16 over which moves are averaged and 5 over which those of neighbours are pooled; and 5 from which strays
/// ([`super::strays`]) are known.
pub(super) const REACH: usize = 3 * ALIGNED;

/// Windows begin at multiples of this row, whatever their stride.
pub(super) const ALIGNED: usize = 32;

/// Stride from which on moves are averaged over 33 x 33 texels in place of 11 x 11: they change slowly by then, and
/// fewer are mere noise.
const WIDE: usize = 16;

/// Standard deviations of its own noise by which a move must stand out to count.
const STANDS_OUT: f32 = 0.5;

/// Variances of the plain value by which both halves of a single texel must leave a fit to refuse it: a contact of one
/// texel.
const REFUSES: f32 = 25.0;

/// Planes of what is known of texels while candidates are tried: sums over the candidates by their weights, of the
/// weights, of variances and of halves; variance and squared bias of the last candidate; and sums of the channels by
/// the weights.
const WEIGHTS: usize = 0;
const VARIANCES: usize = 1;
const HALVES: usize = 2;
const VARIANCE: usize = 3;
const VALUES: usize = 5;

/// What is chosen for the texels of a surface, plane by plane.
#[derive(Debug)]
pub(super) struct Chosen(pub Sheet);

impl Chosen {
    /// Variance of the plain mean; 0 where no ray of the neighbourhood disagrees, and off the surface.
    pub const PLAIN: usize = 0;
    /// What the fits predict of the variance.
    pub const VARIANCE: usize = 1;
    /// Squared bias that is seen of the texels about it.
    pub const NEAR_BIAS: usize = 2;
    /// Half the difference of the two halves.
    pub const HALF: usize = 3;
    /// The number of the surface's texels about it; 0 off the surface.
    pub const NEAR: usize = 4;
    /// From here on, the channels.
    pub const VALUES: usize = 5;
}

/// What is chosen for the texels of a surface; `None` where the halves agree everywhere.
///
/// * `largest`: the largest value that there is.
/// * `dark`: the standard error of a neighbourhood of so many texels without light, from that of its texel.
pub(super) fn choose(
    surface: &Surface,
    largest: f32,
    dark: impl Fn(f32, f32) -> f32 + Sync,
) -> Option<Chosen> {
    let mut choice = Choice::begin(surface, largest, dark)?;
    let mut fitter = Fitter::new(surface);
    let mut before = surface.data.clone();
    let mut fitted = [0; 2].map(|_| Sheet::new(surface.size(), before.planes));
    // Windows that reach beyond all of it are like those of half the stride.
    let extent = surface.size().into_iter().fold(0, usize::max);
    for (stride, mut degrees) in FITS.into_iter().filter(|(stride, _)| *stride < 2 * extent) {
        degrees[1] |= stride >= extent;
        let [quadratic, linear] = fitted.each_mut();
        fitter.fit(stride, [(degrees[0], quadratic), (degrees[1], linear)]);
        for (now, _) in fitted
            .iter_mut()
            .zip(degrees)
            .filter(|(_, is_tried)| *is_tried)
        {
            choice.try_fit(stride, &before, now);
            std::mem::swap(&mut before, now);
        }
    }
    drop((fitter, before, fitted));
    Some(choice.end())
}

/// Candidates of a surface, tried one after the other.
struct Choice<'a> {
    surface: &'a Surface,
    channels: usize,
    /// Texels of the surface about each, in 11 x 11 and in 33 x 33.
    near: Sheet,
    far: Sheet,
    /// Variance of the plain mean, by what is seen near it and by what may reach it from farther away.
    plain: Sheet,
    state: Sheet,
    /// Squares of halves and of moves.
    pair: Sheet,
    /// What a unit is of the largest value.
    share: f32,
    /// The mean variance of plain values, and their sum.
    unit: f32,
    all_plain: f64,
}

impl<'a> Choice<'a> {
    /// Begins with the plain values.
    fn begin(
        surface: &'a Surface,
        largest: f32,
        dark: impl Fn(f32, f32) -> f32 + Sync,
    ) -> Option<Self> {
        let (mask, data) = (&surface.mask, &surface.data);
        let size @ [width, height] = surface.size();
        let (leading, channels) = (surface.leading, data.planes - 1);
        let mut pair = Sheet::new(size, 2);
        let all_plain = pair.fill(|y, [squares, texels]| {
            let halves = data.row(channels, y);
            for (square, half) in squares.iter_mut().zip(halves) {
                *square = half * half;
            }
            texels.copy_from_slice(mask.row(0, y));
        });
        let texels: f64 = (0..height).map(|y| f64::from(sum(mask.row(0, y)))).sum();
        let unit = (all_plain / texels) as f32;
        if unit < f32::MIN_POSITIVE {
            return None;
        }
        let [mut near, mut far] = [0; 2].map(|_| Sheet::new(size, 1));
        let mut plain = Sheet::new(size, 2);
        let mut state = Sheet::new(size, VALUES + channels);
        let sheets = [&mut state, &mut near, &mut far, &mut plain];
        rows(
            height,
            1,
            sheets.map(|sheet| &mut sheet.values[..]),
            #[inline(always)]
            |first, [state, near, far, plain]| {
                let mut room = Room::new(width);
                let mut mean = Mean(leading, Vec::new());
                let mut weights = vec![0.0; width];
                let states = state.chunks_exact_mut((VALUES + channels) * width);
                for (row, state) in states.enumerate() {
                    let (y, line) = (first + row, row * width..(row + 1) * width);
                    let (near, far) = (&mut near[line.clone()], &mut far[line]);
                    let plain = &mut plain[2 * row * width..2 * (row + 1) * width];
                    let (seen, plain) = plain.split_at_mut(width);
                    pair.sums(1, y, About::Eleven, &mut room, near);
                    pair.sums(1, y, About::Wide, &mut room, far);
                    pair.sums(0, y, About::Eleven, &mut room, seen);
                    let (values, errors) = (mean.row(data, y), surface.errors.row(0, y));
                    for x in 0..width {
                        seen[x] /= larger(near[x], 1.0);
                        plain[x] = seen[x];
                        if plain[x] == 0.0 && values[x] == 0.0 {
                            // What neighbours farther away met may reach here too.
                            plain[x] = dark(errors[x], near[x]).powi(2);
                        }
                    }
                    weights.copy_from_slice(plain);
                    let mut state = planes::<VALUES>(state, width);
                    state.0[VARIANCE].copy_from_slice(plain);
                    state.count(&mut weights, unit, plain, data, y);
                }
            },
        );
        Some(Self {
            surface,
            channels,
            near,
            far,
            plain,
            state,
            pair,
            share: largest.recip(),
            unit,
            all_plain,
        })
    }

    /// Tries a fit that follows the one `before`.
    fn try_fit(&mut self, stride: usize, before: &Sheet, now: &Sheet) {
        let [width, height] = self.surface.size();
        let &Surface {
            ref data, leading, ..
        } = self.surface;
        let channels = self.channels;
        let (unit, share) = (self.unit, self.share);
        let half = channels;
        let all_fitted = self.pair.fill(|y, [squares, moves]| {
            let mut means = [0; 2].map(|_| Mean(leading, Vec::new()));
            let [now_mean, before_mean] = means.each_mut();
            let (m, before_m) = (now_mean.row(now, y), before_mean.row(before, y));
            let (h, before_h) = (now.row(half, y), before.row(half, y));
            for x in 0..width {
                squares[x] = h[x] * h[x];
                moves[x] = moved([m[x], before_m[x]], [h[x], before_h[x]]);
            }
        });
        let reduced = (all_fitted / self.all_plain) as f32;
        let (about, counts) = match stride >= WIDE {
            true => (About::Wide, &self.far),
            false => (About::Eleven, &self.near),
        };
        // Texels that share one move.
        let shared = (stride * stride) as f32 / 4.0;
        let (pair, plain) = (&self.pair, &self.plain);
        rows(
            height,
            1,
            [&mut self.state.values],
            #[inline(always)]
            |first, [state]| {
                let mut room = Room::new(width);
                let mut means = [0; 2].map(|_| Mean(leading, Vec::new()));
                let mut lines = vec![0.0; 4 * width];
                let Planes([squares, moves, risks, own], _) = planes(&mut lines, width);
                let states = state.chunks_exact_mut((VALUES + channels) * width);
                for (row, state) in states.enumerate() {
                    let y = first + row;
                    pair.sums(0, y, about, &mut room, squares);
                    pair.sums(1, y, about, &mut room, moves);
                    let [now_mean, plain_mean] = means.each_mut();
                    let (m, plain_m) = (now_mean.row(now, y), plain_mean.row(data, y));
                    let (h, plain_h) = (now.row(half, y), data.row(half, y));
                    let (counts, plain, own_moves) =
                        (counts.row(0, y), plain.row(1, y), pair.row(1, y));
                    let mut state = planes::<VALUES>(state, width);
                    let [_, _, _, variances, biases] = &mut state.0;
                    for x in 0..width {
                        let count = larger(counts[x], 1.0);
                        let variance = 0.5 * (squares[x] / count + reduced * plain[x]);
                        let saved = larger(variances[x] - variance, 0.0);
                        let noise = 2.0 * saved * smaller(shared / count, 1.0).sqrt();
                        // Its own noise must not speak for or against a texel's choice.
                        let moves = (moves[x] - own_moves[x]) / larger(count - 1.0, 1.0);
                        let bias = biases[x] + larger(moves - STANDS_OUT * noise, 0.0);
                        // A texel of another value has another variance: two rays that meet in the dark are no detail,
                        // nor are two that miss in the light.
                        let other = spreads(plain_m[x], share) / spreads(m[x], share);
                        let alone = moved([m[x], plain_m[x]], [h[x], plain_h[x]])
                            - REFUSES * plain[x] * larger(other, 1.0);
                        risks[x] = larger(variance + bias, alone);
                        own[x] = variance;
                        variances[x] = variance;
                        biases[x] = bias;
                    }
                    state.count(risks, unit, own, now, y);
                }
            },
        );
    }

    /// The means of the candidates, and what is expected of their errors: one texel's prediction is rough, so
    /// neighbours pool theirs, as those of plain values are.
    fn end(mut self) -> Chosen {
        let size @ [width, height] = self.surface.size();
        let (surface, channels) = (self.surface, self.channels);
        let (mask, data, leading) = (&surface.mask, &surface.data, surface.leading);
        let state = &self.state;
        self.pair.fill(|y, [variances, biases]| {
            let mut mean = Mean(leading, Vec::new());
            let mean = mean.row(data, y);
            let (mask, weights) = (mask.row(0, y), state.row(WEIGHTS, y));
            let (own, halves) = (state.row(VARIANCES, y), state.row(HALVES, y));
            let halves_before = data.row(channels, y);
            let value = |x: usize| {
                let sum: f32 = (0..leading).map(|c| state.row(VALUES + c, y)[x]).sum();
                sum / leading as f32
            };
            for x in 0..width {
                let share = if mask[x] > 0.0 { 1.0 / weights[x] } else { 0.0 };
                variances[x] = own[x] * share;
                biases[x] = match mask[x] > 0.0 {
                    true => moved(
                        [value(x) * share, mean[x]],
                        [halves[x] * share, halves_before[x]],
                    ),
                    false => 0.0,
                };
            }
        });
        let mut chosen = Sheet::new(size, Chosen::VALUES + channels);
        let (pair, near, plain) = (&self.pair, &self.near, &self.plain);
        rows(
            height,
            1,
            [&mut chosen.values],
            #[inline(always)]
            |first, [chosen]| {
                let mut room = Room::new(width);
                let mut lines = vec![0.0; 2 * width];
                let (inner, texels) = lines.split_at_mut(width);
                let rows = chosen.chunks_exact_mut((Chosen::VALUES + channels) * width);
                for (row, chosen) in rows.enumerate() {
                    let y = first + row;
                    let Planes([seen, variances, biases, halves, counts], values) =
                        planes::<{ Chosen::VALUES }>(chosen, width);
                    seen.copy_from_slice(plain.row(0, y));
                    counts.copy_from_slice(near.row(0, y));
                    pair.sums(0, y, About::Eleven, &mut room, variances);
                    pair.sums(1, y, About::Eleven, &mut room, biases);
                    // Not those whose fits share much of its noise.
                    pair.sums(1, y, About::Seven, &mut room, inner);
                    mask.sums(0, y, About::Seven, &mut room, texels);
                    let weights = state.row(WEIGHTS, y);
                    let (sums, plain) = (state.row(HALVES, y), plain.row(1, y));
                    for x in 0..width {
                        variances[x] /= larger(counts[x], 1.0);
                        biases[x] = (biases[x] - inner[x]) / larger(counts[x] - texels[x], 1.0);
                        halves[x] = sums[x] / weights[x];
                    }
                    for (x, share) in mask.row(0, y).iter().enumerate() {
                        if *share == 0.0 {
                            (seen[x], counts[x]) = (0.0, 0.0);
                        }
                    }
                    for (channel, values) in values.chunks_exact_mut(width).enumerate() {
                        let (sums, before) = (state.row(VALUES + channel, y), data.row(channel, y));
                        for x in 0..width {
                            values[x] = match plain[x] > 0.0 {
                                true => sums[x] / weights[x],
                                false => before[x],
                            };
                        }
                    }
                }
            },
        );
        Chosen(chosen)
    }
}

/// A row of a sheet: its first planes, then the rest.
struct Planes<'a, const N: usize>([&'a mut [f32]; N], &'a mut [f32]);

#[inline(always)]
fn planes<const N: usize>(row: &mut [f32], width: usize) -> Planes<'_, N> {
    let (first, rest) = row.split_at_mut(N * width);
    let mut planes = [0; N].map(|_| <&mut [f32]>::default());
    for (plane, row) in planes.iter_mut().zip(first.chunks_exact_mut(width)) {
        *plane = row;
    }
    Planes(planes, rest)
}

impl Planes<'_, VALUES> {
    /// Counts a candidate by its errors, in units of `unit`; they become its weights. Errors below 1e-5 of it weigh
    /// alike, and so do those beyond 1e5.
    #[inline(always)]
    fn count(&mut self, errors: &mut [f32], unit: f32, variances: &[f32], of: &Sheet, y: usize) {
        let Self([weights, all_variances, halves, ..], values) = self;
        let channels = of.planes - 1;
        for error in &mut *errors {
            let inverse = 1.0 / smaller(larger(*error / unit, 1e-5), 1e5);
            let square = inverse * inverse;
            *error = square * square * square;
        }
        for (sum, weight) in weights.iter_mut().zip(&*errors) {
            *sum += weight;
        }
        add(all_variances, errors, variances);
        add(halves, errors, of.row(channels, y));
        for (channel, values) in values.chunks_exact_mut(of.width).enumerate() {
            add(values, errors, of.row(channel, y));
        }
    }
}

#[inline(always)]
fn add(sums: &mut [f32], weights: &[f32], numbers: &[f32]) {
    for ((sum, weight), number) in sums.iter_mut().zip(weights).zip(numbers) {
        *sum += weight * number;
    }
}

/// The mean of the leading channels along a row; it needs no room where there is one.
struct Mean(usize, Vec<f32>);

impl Mean {
    #[inline(always)]
    fn row<'b>(&'b mut self, sheet: &'b Sheet, y: usize) -> &'b [f32] {
        let Self(leading, room) = self;
        if *leading == 1 {
            return sheet.row(0, y);
        }
        room.clear();
        room.extend((0..sheet.width).map(|x| {
            let sum: f32 = (0..*leading).map(|channel| sheet.row(channel, y)[x]).sum();
            sum / *leading as f32
        }));
        room
    }
}

/// The square of what the truth moves by, from the means and the halves after and before.
#[inline(always)]
fn moved([m, before_m]: [f32; 2], [h, before_h]: [f32; 2]) -> f32 {
    let (dm, dh) = (m - before_m, h - before_h);
    dm * dm - dh * dh
}

/// The variance of single rays of this mean, each of which brings all of the largest value or nothing. `share`: what a
/// unit is of that; 0 where there is none. Something always misses, a thousandth at least.
#[inline(always)]
fn spreads(mean: f32, share: f32) -> f32 {
    larger(mean, f32::MIN_POSITIVE) * (1.0 - smaller(mean * share, 0.999))
}

/// The larger of two numbers, in one instruction.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The sum of a row of whole lanes.
#[inline(always)]
fn sum(row: &[f32]) -> f32 {
    let lanes = row.chunks_exact(LANES);
    let sums = lanes.fold(Lanes::ZERO, |sums, row| sums + Lanes::load(row, 0));
    sums.0.iter().sum()
}

impl Sheet {
    /// Sets a sheet of two planes row by row; the sum of the first, in a fixed order.
    fn fill(&mut self, of: impl Fn(usize, [&mut [f32]; 2]) + Sync) -> f64 {
        let (width, height) = (self.width, self.height());
        let mut sums = vec![0.0; height];
        rows(
            height,
            1,
            [&mut self.values, &mut sums],
            #[inline(always)]
            |first, [values, sums]| {
                let rows = values.chunks_exact_mut(2 * width).zip(sums);
                for (row, (values, own)) in rows.enumerate() {
                    let (a, b) = values.split_at_mut(width);
                    of(first + row, [&mut *a, b]);
                    *own = sum(a);
                }
            },
        );
        sums.iter().copied().map(f64::from).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_weigh_by_the_sixth_power_of_their_error() {
        // Errors are squared already as risks: 2 against 1 is a sixty-fourth. The unit does not matter; errors that are
        // hardly any weigh alike.
        let share = 1.0 / 64.0;
        let expected = (3.0 + 7.0 * share) / (1.0 + share);
        for (errors, unit, expected) in [
            ([1.0, 2.0], 1.0, expected),
            ([100.0, 200.0], 100.0, expected),
            ([0.0, 1e-6], 1.0, 5.0),
        ] {
            let mut state = Sheet::new([LANES, 1], VALUES + 1);
            for (error, value) in errors.into_iter().zip([3.0, 7.0]) {
                let mut fit = Sheet::new([LANES, 1], 2);
                fit.row_mut(0, 0).fill(value);
                let mut state = planes::<VALUES>(&mut state.values, LANES);
                let (mut errors, variances) = ([error; LANES], [0.0; LANES]);
                state.count(&mut errors, unit, &variances, &fit, 0);
            }
            for x in 0..LANES {
                let value = state.row(VALUES, 0)[x] / state.row(WEIGHTS, 0)[x];
                assert!((value - expected).abs() < 1e-6, "{value} of {expected}");
            }
        }
    }
}
