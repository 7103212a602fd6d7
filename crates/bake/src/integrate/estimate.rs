//! Values and standard errors of a tile's texels from their replicates.
//!
//! **Variance.** The replicates are independent randomisations, so `s²/R` is an unbiased estimate of the variance of their mean,
//! whatever the point set. From two values it is itself uncertain by 140 %, and an interval of ±1.96 of it would cover far less
//! than 95 %; texels of one surface therefore pool their variances over the 5 x 5 neighbourhood in their tile. A neighbour with other
//! numbers of points counts as if its variance fell like N^-3/2, the law for visibility boundaries (D. Mitchell,
//! "Consequences of Stratified Sampling in Graphics", 1996).
//!
//! **Floor.** Replicates that all agree have no spread, yet something smaller than the points may stand between them: by
//! the rule of three its share is below 3/N with 95 % confidence, which is two standard errors of 1.5/N, with N all points that
//! agree.
//!
//! **Mean.** Rays weigh unevenly, above all where they are guided. A share is no ratio of sums, whose mean is off where rays are few;
//! the weights of each replicate are corrected by what the other one found ([`Gathered::slopes`]).

use super::sums::{REPLICATES, Replicates, Sums, Technique, Weights, corrected, mean};
use super::terms::{Halves, Terms, uniform_light};
use crate::options::Sky;
use crate::survey::Texel;
use ambient::Estimate;
use atlas::TILE;
use glam::DVec3;

/// Neighbours pool where their normals are within acos of this, some 37 degrees.
const NORMAL_AGREEMENT: f64 = 0.8;

/// Texels this far away along an axis pool their variances.
const POOL_RADIUS: i32 = 2;

/// Texels this far away along an axis pool their slopes.
const SLOPE_RADIUS: i32 = 1;

/// What a technique estimates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Diffuse,
    Visibility,
    Specular,
    Irradiance,
    Reflection,
}

use Quantity::*;

impl Technique {
    /// Shares that it estimates; light comes on top where the sky is a map.
    fn shares(self) -> &'static [Quantity] {
        match self {
            Technique::Hemisphere => &[Diffuse, Visibility],
            Technique::Lobe => &[Specular],
            Technique::Sky => &[],
        }
    }

    /// Light that it estimates under a map.
    fn lights(self) -> &'static [Quantity] {
        match self {
            Technique::Hemisphere => &[Irradiance],
            Technique::Lobe => &[Reflection],
            Technique::Sky => &[Irradiance, Reflection],
        }
    }
}

/// A tile's texels with the sums of their replicates under one technique, of which `points[i]` have been spent on each; `guided[i]` says
/// whether these were sent by a guide.
pub(crate) struct Gathered<'a> {
    sky: &'a Sky,
    pub technique: Technique,
    pub texels: &'a [Texel],
    pub sums: &'a [Replicates],
    points: &'a [u32],
    guided: &'a [bool],
    /// Texel of each place in the tile; none where nothing was spent.
    at: [usize; (TILE * TILE) as usize],
    /// Each quantity's share by each replicate, by texel; 0 for what the technique does not estimate.
    shares: Vec<[[f64; 2]; 3]>,
    /// Variance of each quantity's mean, by texel; 0 for what the technique does not estimate.
    own: Vec<[f64; 5]>,
}

impl<'a> Gathered<'a> {
    /// All texels as they stand.
    pub fn new(
        sky: &'a Sky,
        technique: Technique,
        texels: &'a [Texel],
        sums: &'a [Replicates],
        points: &'a [u32],
        guided: &'a [bool],
    ) -> Self {
        let mut at = [usize::MAX; (TILE * TILE) as usize];
        for (i, texel) in texels.iter().enumerate() {
            if points[i] > 0 {
                at[(texel.y % TILE * TILE + texel.x % TILE) as usize] = i;
            }
        }
        let mut gathered = Self {
            sky,
            technique,
            texels,
            sums,
            points,
            guided,
            at,
            shares: vec![Default::default(); texels.len()],
            own: vec![Default::default(); texels.len()],
        };
        for i in (0..texels.len()).filter(|&i| points[i] > 0) {
            for &quantity in technique.shares() {
                let slopes = gathered.slopes(i, quantity);
                gathered.shares[i][quantity as usize] = [0, 1].map(|k: usize| match sums[i][k] {
                    // What has no points takes what the other says.
                    own if own.points == 0 => slopes[k],
                    own => corrected(weights(&own, quantity), own.points, slopes[k]),
                });
            }
            for &quantity in technique.shares().iter().chain(gathered.lights()) {
                gathered.own[i][quantity as usize] = gathered.own_variance(i, quantity);
            }
        }
        gathered
    }

    /// By what the weights of each replicate of a texel are corrected ([`corrected`]): the open share that the other replicate found. A few
    /// guided rays may all be open by chance although they are few of those that could be drawn; so where rays are guided it is that of
    /// the texels about it, if that is less. Where a replicate has no points, both slopes are what the other found.
    pub fn slopes(&self, i: usize, quantity: Quantity) -> [f64; 2] {
        let own = self.sums[i].each_ref();
        let [a, b] = own.map(|sums| weights(sums, quantity).share());
        let [a, b] = match own.map(|sums| sums.points > 0) {
            [true, true] => [b, a],
            [true, false] => [a, a],
            _ => [b, b],
        };
        if !self.guided[i] {
            return [a, b];
        }
        let mut pooled = [Weights::default(); 2];
        for j in neighbours(self.texels, &self.at, i, SLOPE_RADIUS) {
            for (sum, sums) in pooled.iter_mut().zip(&self.sums[j]) {
                *sum += weights(sums, quantity);
            }
        }
        [a.min(pooled[1].share()), b.min(pooled[0].share())]
    }

    /// Light that the technique estimates.
    fn lights(&self) -> &'static [Quantity] {
        match self.sky.map() {
            None => &[],
            Some(_) => self.technique.lights(),
        }
    }

    /// The terms of one texel as far as the technique estimates them; zeros where nothing was spent.
    pub fn terms(&self, i: usize) -> Terms {
        if self.points[i] == 0 {
            return Terms::default();
        }
        let sums = Sums::of(&self.sums[i]);
        let pool = self.pool(i, POOL_RADIUS);
        let share = |quantity| Estimate {
            value: self.value(i, quantity),
            std_err: self.std_err(&pool, quantity),
        };
        let light = |quantity, term| match self.sky.map() {
            None => uniform_light(self.sky.floor(), term),
            Some(_) => Estimate {
                value: self.light(i, quantity),
                std_err: self.std_err(&pool, quantity),
            },
        };
        let mut terms = Terms {
            halves: self.halves(i),
            rays: sums.rays,
            ..Terms::default()
        };
        match self.technique {
            Technique::Hemisphere => {
                terms.diffuse = share(Diffuse);
                terms.visibility = share(Visibility);
                terms.irradiance = light(Irradiance, terms.diffuse);
            }
            Technique::Lobe => {
                terms.specular = share(Specular);
                terms.reflection = light(Reflection, terms.specular);
            }
            Technique::Sky => {
                terms.irradiance = light(Irradiance, Estimate::default());
                terms.reflection = light(Reflection, Estimate::default());
            }
        }
        terms
    }

    /// Half of what the two halves of a texel's replicates differ by, in all that the technique estimates.
    fn halves(&self, i: usize) -> Halves {
        let [a, b] = &self.sums[i];
        let share = |quantity| {
            let [a, b] = self.shares[i][quantity as usize];
            0.5 * (a - b)
        };
        let (diffuse, specular) = (share(Diffuse), share(Specular));
        let light = |quantity, share: f64| {
            let even = self.sky.floor() * share;
            match self.technique.lights().contains(&quantity) {
                true => even + 0.5 * (above(self.sky, a, quantity) - above(self.sky, b, quantity)),
                false => even,
            }
        };
        Halves {
            diffuse,
            visibility: share(Visibility),
            specular,
            irradiance: light(Irradiance, diffuse),
            reflection: light(Reflection, specular),
            ..Halves::default()
        }
    }

    /// What decides when there are rays enough: the first share, and light.
    pub fn watched(&self) -> impl Iterator<Item = Quantity> {
        let shares = self.technique.shares().iter().take(1);
        shares.chain(self.lights()).copied()
    }

    /// Half of what the two halves of a texel's replicates differ by, light as the mean of its channels.
    pub fn half(&self, i: usize, quantity: Quantity) -> f64 {
        let halves = self.halves(i);
        match quantity {
            Diffuse => halves.diffuse,
            Visibility => halves.visibility,
            Specular => halves.specular,
            Irradiance => halves.irradiance.element_sum() / 3.0,
            Reflection => halves.reflection.element_sum() / 3.0,
        }
    }

    /// Standard error of a texel's quantity.
    pub fn std_err_of(&self, i: usize, quantity: Quantity) -> f64 {
        self.std_err_within(i, POOL_RADIUS, quantity)
    }

    /// The same, of the variances of the texels that are no more than `radius` away along an axis.
    pub fn std_err_within(&self, i: usize, radius: i32, quantity: Quantity) -> f64 {
        self.std_err(&self.pool(i, radius), quantity)
    }

    /// A quantity of all replicates: a share, or the mean of the channels of light.
    pub fn value(&self, i: usize, quantity: Quantity) -> f64 {
        match quantity {
            Diffuse | Visibility | Specular => {
                mean(&self.sums[i], self.shares[i][quantity as usize]).clamp(0.0, 1.0)
            }
            Irradiance | Reflection => self.light(i, quantity).element_sum() / 3.0,
        }
    }

    /// Light of all replicates: the sky's floor by the share that is open, and what stands out of it.
    fn light(&self, i: usize, quantity: Quantity) -> DVec3 {
        let total = Sums::of(&self.sums[i]);
        self.sky.floor() * self.value(i, share_of(quantity)) + above(self.sky, &total, quantity)
    }

    /// Variance of a quantity's mean, by the replicates that have points.
    fn own_variance(&self, i: usize, quantity: Quantity) -> f64 {
        let used = self.points[i].min(REPLICATES) as usize;
        let mut values = self.shares[i][share_of(quantity) as usize];
        if let Irradiance | Reflection = quantity {
            let floor = self.sky.floor().element_sum() / 3.0;
            for (value, sums) in values.iter_mut().zip(&self.sums[i]) {
                *value = floor * *value + above(self.sky, sums, quantity).element_sum() / 3.0;
            }
        }
        variance_of_mean(&values[..used])
    }

    /// The value of a quantity that all points would see.
    pub fn unit(&self, quantity: Quantity) -> f64 {
        match quantity {
            Diffuse | Visibility | Specular => 1.0,
            Irradiance | Reflection => self.sky.mean().element_sum() / 3.0,
        }
    }

    /// The variances of the texels about one, no more than `radius` away along an axis.
    fn pool(&self, i: usize, radius: i32) -> Pool {
        let mut pool = Pool::default();
        for j in neighbours(self.texels, &self.at, i, radius) {
            let (ratio, root) = match self.points[j] == self.points[i] {
                true => (1.0, 1.0),
                false => {
                    let ratio = f64::from(self.points[j]) / f64::from(self.points[i]);
                    (ratio, ratio.sqrt())
                }
            };
            for (sum, own) in pool.variances.iter_mut().zip(&self.own[j]) {
                *sum += own * ratio * root;
            }
            pool.texels += 1.0;
            pool.points += f64::from(self.points[j]);
        }
        pool
    }

    /// Standard error of one of a texel's quantities.
    fn std_err(&self, pool: &Pool, quantity: Quantity) -> f64 {
        let variance = pool.variances[quantity as usize];
        if variance > 0.0 {
            f64::sqrt(variance / pool.texels)
        } else {
            1.5 / pool.points * self.unit(quantity)
        }
    }
}

/// What texels of one surface share.
#[derive(Default)]
struct Pool {
    /// Sums of the variances of each quantity's mean, as if all had the points of the texel that asks.
    variances: [f64; 5],
    texels: f64,
    points: f64,
}

/// The texel and those about it in the tile that are of the same surface and have points.
fn neighbours<'a>(
    texels: &'a [Texel],
    at: &'a [usize; (TILE * TILE) as usize],
    centre: usize,
    radius: i32,
) -> impl Iterator<Item = usize> + 'a {
    let texel = &texels[centre];
    let (x, y) = ((texel.x % TILE) as i32, (texel.y % TILE) as i32);
    let edge = TILE as i32;
    (-radius..=radius)
        .flat_map(move |dy| (-radius..=radius).map(move |dx| (x + dx, y + dy)))
        .filter(move |&(x, y)| (0..edge).contains(&x) && (0..edge).contains(&y))
        .map(move |(x, y)| at[(y * edge + x) as usize])
        .filter(move |&j| {
            j != usize::MAX
                && texels[j].object == texel.object
                && texels[j].normal.dot(texel.normal) > NORMAL_AGREEMENT
        })
}

/// The weights of a share, or of the share that light comes by.
fn weights(sums: &Sums, quantity: Quantity) -> Weights {
    match share_of(quantity) {
        Visibility => sums.visibility,
        Specular => sums.specular,
        _ => sums.diffuse,
    }
}

/// A share itself, or the share that light comes by.
fn share_of(quantity: Quantity) -> Quantity {
    match quantity {
        Irradiance => Diffuse,
        Reflection => Specular,
        share => share,
    }
}

/// Light that stands out of the sky's floor.
fn above(sky: &Sky, sums: &Sums, quantity: Quantity) -> DVec3 {
    let scale = sky.map().map_or(0.0, |map| map.scale());
    let sum = match quantity {
        Reflection => sums.reflection,
        _ => sums.irradiance,
    };
    sum * (scale / sums.points.max(1) as f64)
}

/// Unbiased variance of the mean of independent values of equal variance; 0 for fewer than two.
pub(crate) fn variance_of_mean(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    if n < 2.0 {
        return 0.0;
    }
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    squares / (n * (n - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variance_of_a_mean_is_that_of_its_values_by_their_number() {
        assert_eq!(variance_of_mean(&[1.0, 3.0, 2.0, 6.0]), 14.0 / 12.0);
        assert_eq!(variance_of_mean(&[1.0, 2.0]), 0.25);
        assert_eq!(variance_of_mean(&[5.0]), 0.0);
        assert_eq!(variance_of_mean(&[]), 0.0);
    }

    /// Points whose weights are uneven, and of which those count that weigh much: a ratio of few is too small.
    #[test]
    fn no_mean_is_moved_however_few_the_points_are() {
        let mut mix = rays::Mix(5);
        // Weights of 1/2 and 3/2 by halves: their mean is 1. Those of 3/2 count.
        let mut half = || {
            let drawn = [0, 1].map(|_| 0.5 + f64::from(u8::from(mix.unit() < 0.5)));
            let open = drawn.iter().filter(|w| **w > 1.0).sum();
            let all = drawn.iter().sum();
            Weights { open, all }
        };
        let tries = 40_000;
        let (mut means, mut ratios) = (0.0, 0.0);
        for _ in 0..tries {
            let [a, b] = [half(), half()];
            means += corrected(a, 2, b.share()) / f64::from(tries);
            ratios += a.share() / f64::from(tries);
        }
        assert!((means - 0.75).abs() < 0.01, "{means}");
        assert!((ratios - 0.75).abs() > 0.03, "{ratios}");
    }

    #[test]
    fn weights_that_are_drawn_unevenly_are_no_error_where_all_is_open_or_closed() {
        let of = |open, all, slope| corrected(Weights { open, all }, 2, slope);
        assert_eq!([of(1.5, 1.5, 1.0), of(4.0, 4.0, 1.0)], [1.0, 1.0]);
        assert_eq!([of(0.0, 1.5, 0.0), of(0.0, 4.0, 0.0)], [0.0, 0.0]);
        assert_eq!(of(1.0, 4.0, 0.25), 0.25);
    }
}
