//! What a denoised page states: the errors that its texels predict, held against what the halves of the rays show of
//! them all.
//!
//! A texel's error has a part of noise and a part of bias. What few texels tell of either is rough, and fits were
//! chosen for the least of such numbers, so it is also too hopeful. But every texel bears witness of its own. Its value
//! moved by dm, and half the difference of its halves by dh, to h: dm² - dh² has the mean of the squared bias, and h²
//! that of the variance that is left (C. Stein, "Estimation of the Mean of a Multivariate Normal Distribution", 1981,
//! with halves in place of a known variance). One such number says nothing, thousands do. Texels are therefore sorted
//! by what their neighbours lead one to expect of them, and all texels of a bin state what they show together.
//!
//! Both are means over some hundred texels about each, and errors change faster than that: they are largest where light
//! changes from one texel to the next, as at a contact, and hardly any beside it. So texels are sorted once more, by
//! how steep what was chosen is ([`super::steep`]), and what all texels that are as steep show shares out among them
//! what the page states as a whole. Without that, flat texels state twice their error and steep ones three quarters:
//! true in the mean, but 98 of 100 lie within 1.96 of it.
//!
//! What all show together is still too hopeful of the bias where few rays were cast, because the fits were chosen for
//! small moves of the very same rays. So no bin states less bias than the best width of a linear fit has in two
//! dimensions ([`BALANCE`]), where fits have less variance than plain values, which have no bias.

/// What is expected of a texel's error, in squares.
#[derive(Debug, Clone, Copy)]
pub(super) struct Predicted {
    /// Variance of the plain value; 0 where the error is known.
    pub plain: f32,
    /// Variance that the fits predict, or the known one.
    pub variance: f32,
    /// Squared bias that neighbours show whose fits share none of the texel's noise; of either sign.
    pub near_bias: f32,
}

/// What is known of a texel's error, in squares.
#[derive(Debug, Clone, Copy)]
pub(super) struct Squares {
    pub predicted: Predicted,
    /// What the texel shows itself, the bias of either sign.
    pub seen_variance: f32,
    pub seen_bias: f32,
    /// What its value differs by from those beside it.
    pub steep: f32,
}

impl Squares {
    /// Of a texel whose squared error is known.
    pub fn known(variance: f32) -> Self {
        Self {
            predicted: Predicted {
                plain: 0.0,
                variance,
                near_bias: 0.0,
            },
            seen_variance: 0.0,
            seen_bias: 0.0,
            steep: 0.0,
        }
    }
}

/// Standard deviation of what one texel shows of its squared bias, in plain variances: the product of two halves of
/// twice the variance each.
const NOISE_OF_BIAS: f64 = 2.0;

/// The same of its variance, in that variance: the square of a normal number.
const NOISE_OF_VARIANCE: f64 = std::f64::consts::SQRT_2;

/// Squared bias over variance of a local linear fit in two dimensions, of the width that makes their sum least: with a
/// variance like 1/w² and a squared bias like w⁴ both derivatives cancel at a half.
const BALANCE: f64 = 0.5;

/// What texels show of their errors, by what is expected of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Seen {
    variance: [Bin; BINS],
    bias: [Bin; BINS],
}

impl Seen {
    /// Counts a texel.
    pub fn count(&mut self, texel: &Squares) {
        let Predicted {
            variance,
            near_bias,
            ..
        } = texel.predicted;
        count(&mut self.variance, variance, texel.seen_variance, texel);
        count(&mut self.bias, near_bias, texel.seen_bias, texel);
    }
}

/// What the texels of a page show of their errors, as shares of the plain variance.
pub(super) struct Stated {
    variance: [f32; BINS],
    bias: [f32; BINS],
    /// The root mean square of what both say.
    unit: f32,
    /// By steepness, what is stated over what both say.
    steep: [f32; BINS],
}

impl Stated {
    /// Of the parts of a page, in a fixed order.
    pub fn of<'a>(parts: impl Iterator<Item = &'a Seen>) -> Self {
        let add = |mut all: [Bin; BINS], part: &[Bin; BINS]| {
            all.iter_mut().zip(part).for_each(|(all, bin)| all.add(bin));
            all
        };
        let all = parts.fold(Seen::default(), |all, part| Seen {
            variance: add(all.variance, &part.variance),
            bias: add(all.bias, &part.bias),
        });
        let variance = shares(&all.variance, |variance| NOISE_OF_VARIANCE * variance, 0.0);
        let bias = shares(&all.bias, |_| NOISE_OF_BIAS, BALANCE);
        let said = |bins: &[Bin; BINS], shares: &[f32; BINS]| -> f64 {
            let said = bins.iter().zip(shares);
            said.map(|(bin, share)| bin.plain * f64::from(*share)).sum()
        };
        let squares = said(&all.variance, &variance) + said(&all.bias, &bias);
        let texels: f64 = all.variance.iter().map(|bin| bin.texels).sum();
        Self {
            unit: (squares / texels.max(1.0)).sqrt() as f32,
            variance,
            bias,
            steep: [1.0; BINS],
        }
    }

    /// What some texels show beside what is said of them, by how steep they are.
    pub fn shown(&self, texels: &[Squares]) -> [Shown; BINS] {
        let mut bins = [Shown::default(); BINS];
        for texel in texels.iter().filter(|texel| texel.predicted.plain > 0.0) {
            let Predicted { plain, .. } = texel.predicted;
            let [said, plain] = [self.said(&texel.predicted), plain].map(f64::from);
            let noise = (NOISE_OF_BIAS * plain).powi(2) + (NOISE_OF_VARIANCE * said).powi(2);
            let left = f64::from(texel.seen_variance);
            let shown = left + f64::from(texel.seen_bias);
            let (bin, part) = self.place_of(texel);
            for (bin, part) in [(bin, 1.0 - part), (bin + 1, part)] {
                let (bin, part) = (&mut bins[bin], f64::from(part));
                bin.said += part * said;
                bin.shown += part * shown;
                bin.left += part * left;
                bin.noise += part * noise;
            }
        }
        bins
    }

    /// Sorts texels by how steep they are from now on. The mean square of all stays.
    pub fn sort(&mut self, parts: &[[Shown; BINS]]) {
        let mut bins = [Shown::default(); BINS];
        for part in parts {
            bins.iter_mut()
                .zip(part)
                .for_each(|(bin, part)| bin.add(part));
        }
        let ratios = bins.map(|bin| bin.ratio());
        let said: f64 = bins.iter().map(|bin| bin.said).sum();
        let stated: f64 = bins
            .iter()
            .zip(ratios)
            .map(|(bin, ratio)| bin.said * ratio)
            .sum();
        if stated > 0.0 {
            self.steep = ratios.map(|ratio| (ratio * said / stated) as f32);
        }
    }

    /// The standard error of a texel.
    pub fn std_err(&self, texel: &Squares) -> f32 {
        if texel.predicted.plain == 0.0 {
            return texel.predicted.variance.sqrt();
        }
        let times = between(&self.steep, self.place_of(texel));
        (self.said(&texel.predicted) * times).sqrt()
    }

    /// The squared error that bins say of a texel, however steep it is.
    fn said(&self, texel: &Predicted) -> f32 {
        let share = between(&self.variance, place(FINE * texel.variance / texel.plain))
            + between(&self.bias, place(FINE * texel.near_bias / texel.plain));
        share * texel.plain
    }

    fn place_of(&self, texel: &Squares) -> (usize, f32) {
        place(STEEP * texel.steep.sqrt() / self.unit.max(f32::MIN_POSITIVE))
    }
}

/// Sums over the texels of a bin of steepness.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shown {
    said: f64,
    shown: f64,
    /// What of it is variance.
    left: f64,
    /// Variance of what is shown.
    noise: f64,
}

impl Shown {
    fn add(&mut self, other: &Self) {
        self.said += other.said;
        self.shown += other.shown;
        self.left += other.left;
        self.noise += other.noise;
    }

    /// What is shown over what is said, 1 before anything is shown, and held for as uncertain as that is large. No bias
    /// is less than 0.
    fn ratio(&self) -> f64 {
        let square = self.said * self.said + self.noise;
        match square > 0.0 {
            true => (self.said * self.shown.max(self.left) + self.noise) / square,
            false => 1.0,
        }
    }
}

/// Bins of what is expected, as a share of the plain variance; even in the binary logarithm of 1 + FINE x, from 0 to 8.
const BINS: usize = 12;
const FINE: f32 = 256.0;

/// The same of the step from texel to texel, in units of the page's error: from a quarter to 512.
const STEEP: f32 = 4.0;

/// Sums over the texels of a bin.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    seen: f64,
    variance: f64,
    plain: f64,
    texels: f64,
}

impl Bin {
    fn add(&mut self, other: &Self) {
        self.seen += other.seen;
        self.variance += other.variance;
        self.plain += other.plain;
        self.texels += other.texels;
    }

    /// The mean of what is seen, 0 at least. Before anything is seen, `prior` times as much is held true as the fits
    /// have of variance, and held for as uncertain as that variance is large; `noise` is the standard deviation of what
    /// one texel shows.
    fn share(&self, prior: f64, noise: impl Fn(f64) -> f64) -> f32 {
        if self.plain == 0.0 {
            return 0.0;
        }
        let (seen, expected) = (self.seen / self.plain, self.variance / self.plain);
        // Texels that it takes to know as much.
        let worth = (noise(expected) / expected.max(1e-6)).powi(2);
        let share = (self.texels * seen + worth * prior * expected) / (self.texels + worth);
        share.max(0.0) as f32
    }

    /// So many times the mean variance of the fits, and as much less as they have of the plain variance: a plain
    /// value has no bias.
    fn least(&self, times: f64) -> f32 {
        if self.plain == 0.0 {
            return 0.0;
        }
        let variance = self.variance / self.plain;
        (times * variance * (1.0 - variance).max(0.0)) as f32
    }
}

/// What the texels of each bin state, `least` times the variance of their fits at least. What the page shows as a whole
/// is held true of each bin before it has shown anything itself, and of the page, that bias and variance are in
/// balance.
fn shares(bins: &[Bin; BINS], noise: impl Fn(f64) -> f64, least: f64) -> [f32; BINS] {
    let mut all = Bin::default();
    bins.iter().for_each(|bin| all.add(bin));
    if all.variance == 0.0 {
        return [0.0; BINS];
    }
    let of_page = f64::from(all.share(1.0, &noise)) * all.plain / all.variance;
    bins.map(|bin| bin.share(of_page, &noise).max(bin.least(least)))
}

/// Counts a texel in the two bins beside what is expected of it.
fn count(bins: &mut [Bin; BINS], expected: f32, seen: f32, texel: &Squares) {
    let Predicted {
        plain, variance, ..
    } = texel.predicted;
    let (bin, part) = place(FINE * expected / plain);
    for (bin, part) in [(bin, 1.0 - part), (bin + 1, part)] {
        let (bin, part) = (&mut bins[bin], f64::from(part));
        bin.seen += part * f64::from(seen);
        bin.variance += part * f64::from(variance);
        bin.plain += part * f64::from(plain);
        bin.texels += part;
    }
}

/// The bin of a number, and how far it lies toward the next.
fn place(number: f32) -> (usize, f32) {
    // As floating-point numbers hold it: linear between powers of two.
    const ONE: u32 = 1.0_f32.to_bits();
    const OCTAVE: f32 = (1 << (f32::MANTISSA_DIGITS - 1)) as f32;
    let octaves = ((1.0 + number.max(0.0)).to_bits() - ONE) as f32 / OCTAVE;
    let at = octaves.min((BINS - 1) as f32 - 1e-3);
    (at as usize, at.fract())
}

/// What the bins hold between them.
fn between(bins: &[f32; BINS], (bin, part): (usize, f32)) -> f32 {
    bins[bin] * (1.0 - part) + bins[bin + 1] * part
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steep_texels_state_what_they_show_and_the_page_what_it_did() {
        // Alike in all that is expected of them. The flat ones show half as much as both together, the steep ones half
        // more, and of each kind there are so many that nothing else counts.
        let texel = |steep: f32, seen: f32| Squares {
            predicted: Predicted {
                plain: 1.0,
                variance: 0.25,
                near_bias: 0.0,
            },
            seen_variance: seen,
            seen_bias: 0.0,
            steep,
        };
        let kinds = [texel(0.0, 0.125), texel(1e6, 0.375)];
        let part: Vec<Squares> = (0..200_000).map(|k| kinds[k % 2]).collect();
        let mut seen = Seen::default();
        part.iter().for_each(|texel| seen.count(texel));
        let mut stated = Stated::of([&seen].into_iter());
        let squares = |stated: &Stated| kinds.map(|texel| stated.std_err(&texel).powi(2));
        let [flat, steep] = squares(&stated);
        assert_eq!(flat, steep);
        let before = flat + steep;
        stated.sort(&[stated.shown(&part)]);
        let [flat, steep] = squares(&stated);
        assert!(
            (flat + steep - before).abs() < 1e-5,
            "{flat}, {steep} of {before}"
        );
        // Variance .25, and the least bias, .5 of .25 of .75: shares of all that is said, 1 and 3.
        assert!((steep / flat - 3.0).abs() < 0.01, "{flat}, {steep}");
    }

    #[test]
    fn a_few_texels_do_not_change_what_is_said_of_them() {
        let texel = Squares {
            predicted: Predicted {
                plain: 1.0,
                variance: 0.25,
                near_bias: 0.0,
            },
            seen_variance: 0.0,
            seen_bias: 0.0,
            steep: 0.0,
        };
        let other = Squares {
            seen_variance: 1.0,
            steep: 1e6,
            ..texel
        };
        let part = [texel, other];
        let mut seen = Seen::default();
        part.iter().for_each(|texel| seen.count(texel));
        let mut stated = Stated::of([&seen].into_iter());
        let before = stated.std_err(&texel);
        stated.sort(&[stated.shown(&part)]);
        for texel in part {
            let after = stated.std_err(&texel);
            assert!((after / before - 1.0).abs() < 0.06, "{after} for {before}");
        }
    }
}
