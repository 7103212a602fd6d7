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
        Self {
            variance: shares(&all.variance, |variance| NOISE_OF_VARIANCE * variance, 0.0),
            bias: shares(&all.bias, |_| NOISE_OF_BIAS, BALANCE),
        }
    }

    /// The standard error of a texel.
    pub fn std_err(&self, texel: &Predicted) -> f32 {
        if texel.plain == 0.0 {
            return texel.variance.sqrt();
        }
        let share = at(&self.variance, texel.variance / texel.plain)
            + at(&self.bias, texel.near_bias / texel.plain);
        (share * texel.plain).sqrt()
    }
}

/// Bins of what is expected, as a share of the plain variance; even in the binary logarithm of 1 + FINE x, from 0 to 4.
const BINS: usize = 12;
const FINE: f32 = 256.0;

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
    let (bin, part) = place(expected / plain);
    for (bin, part) in [(bin, 1.0 - part), (bin + 1, part)] {
        let (bin, part) = (&mut bins[bin], f64::from(part));
        bin.seen += part * f64::from(seen);
        bin.variance += part * f64::from(variance);
        bin.plain += part * f64::from(plain);
        bin.texels += part;
    }
}

/// The bin of a share, and how far it lies toward the next.
fn place(share: f32) -> (usize, f32) {
    // As floating-point numbers hold it: linear between powers of two.
    const ONE: u32 = 1.0_f32.to_bits();
    const OCTAVE: f32 = (1 << (f32::MANTISSA_DIGITS - 1)) as f32;
    let octaves = ((1.0 + FINE * share.max(0.0)).to_bits() - ONE) as f32 / OCTAVE;
    let at = octaves.min((BINS - 1) as f32 - 1e-3);
    (at as usize, at.fract())
}

/// What the bins hold between them.
fn at(bins: &[f32; BINS], share: f32) -> f32 {
    let (bin, part) = place(share);
    bins[bin] * (1.0 - part) + bins[bin + 1] * part
}
