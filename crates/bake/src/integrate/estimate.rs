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
//! the weights of each replicate are corrected by what the other one found ([`Known::slopes`]).

use super::lobe::Lobe;
use super::sums::{REPLICATES, Replicates, Sums, Technique, Weights, corrected, mean};
use super::terms::{Halves, Terms};
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

    /// Light that it estimates.
    fn lights(self) -> &'static [Quantity] {
        match self {
            Technique::Hemisphere => &[Irradiance],
            Technique::Lobe => &[Reflection],
            Technique::Sky => &[Irradiance, Reflection],
        }
    }
}

/// What one replicate says of a texel; 0 for what the technique does not estimate.
#[derive(Debug, Clone, Copy, Default)]
struct Said {
    shares: [f64; 3],
    lights: [DVec3; 2],
}

/// A tile's texels with the sums of their replicates under one technique, of which `points[i]` have been spent on each.
pub(crate) struct Gathered<'a> {
    pub sky: &'a Sky,
    pub technique: Technique,
    pub texels: &'a [Texel],
    pub sums: &'a [Replicates],
    pub points: &'a [u32],
    /// Whether a guide sent them.
    pub guided: &'a [bool],
    pub lobes: &'a [Option<Lobe>],
    /// What the hemisphere's rays found, where they count for lobes; of all texels or of none.
    pub beside: &'a [Replicates],
}

/// What is known of a tile's texels from their replicates under one technique.
pub(crate) struct Known<'a> {
    pub from: Gathered<'a>,
    /// Texel of each place in the tile; none where nothing was spent.
    at: [usize; (TILE * TILE) as usize],
    said: Vec<[Said; 2]>,
    /// Variance of each quantity's mean, by texel; 0 for what the technique does not estimate.
    own: Vec<[f64; 5]>,
}

impl<'a> Gathered<'a> {
    /// What the sums say.
    pub fn known(self) -> Known<'a> {
        let mut at = [usize::MAX; (TILE * TILE) as usize];
        for (i, texel) in self.texels.iter().enumerate() {
            if self.points[i] > 0 {
                at[(texel.y % TILE * TILE + texel.x % TILE) as usize] = i;
            }
        }
        let count = self.texels.len();
        let mut known = Known {
            from: self,
            at,
            said: vec![Default::default(); count],
            own: vec![Default::default(); count],
        };
        for i in (0..count).filter(|&i| known.from.points[i] > 0) {
            known.said[i] = known.says(i);
            let used = known.from.points[i].min(REPLICATES) as usize;
            let technique = known.from.technique;
            for &quantity in technique.shares().iter().chain(technique.lights()) {
                let values = known.said[i].map(|said| said.of(quantity));
                known.own[i][quantity as usize] = variance_of_mean(&values[..used]);
            }
        }
        known
    }
}

impl Said {
    /// A share, or the mean of the channels of light.
    fn of(&self, quantity: Quantity) -> f64 {
        match quantity {
            Diffuse | Visibility | Specular => self.shares[quantity as usize],
            Irradiance => self.lights[0].element_sum() / 3.0,
            Reflection => self.lights[1].element_sum() / 3.0,
        }
    }
}

impl Known<'_> {
    /// What each replicate says of a texel.
    fn says(&self, i: usize) -> [Said; 2] {
        let mut said = [Said::default(); 2];
        let share = |k: usize, quantity, slopes: [f64; 2]| {
            let own = &self.from.sums[i][k];
            match own.points {
                // What has no points takes what the other says.
                0 => slopes[k],
                points => corrected(weights(own, quantity).over(points), slopes[k], 1.0),
            }
        };
        match self.from.technique {
            Technique::Hemisphere => {
                for quantity in [Diffuse, Visibility] {
                    let slopes = self.slopes(i, quantity);
                    for (k, said) in said.iter_mut().enumerate() {
                        said.shares[quantity as usize] = share(k, quantity, slopes);
                    }
                }
            }
            Technique::Lobe => {
                let Some(lobe) = &self.from.lobes[i] else {
                    return said;
                };
                let [plain, white] = [0, 1].map(|part| self.lobe_shares(i, part, lobe));
                for (k, said) in said.iter_mut().enumerate() {
                    said.shares[Specular as usize] = plain[k] / lobe.whole[0];
                    let open = [plain[k], white[k]].map(DVec3::splat);
                    said.lights[1] = self.from.sky.floor() * lobe.tinted(open);
                }
            }
            Technique::Sky => {}
        }
        for (k, said) in said.iter_mut().enumerate() {
            said.lights[0] = self.from.sky.floor() * said.shares[Diffuse as usize];
            self.add_map(i, k, said);
        }
        said
    }

    /// What the directions of a lobe that each replicate finds open weigh, without colour (`part` 0) or times (1 - V·H)^5 (1).
    fn lobe_shares(&self, i: usize, part: usize, lobe: &Lobe) -> [f64; 2] {
        let beside = self.from.beside.get(i).filter(|_| lobe.joins);
        let found = [0, 1].map(|k: usize| {
            let own = &self.from.sums[i][k];
            let mut weights = own.lobe[part].over(own.points);
            if let Some(other) = beside.map(|replicates| &replicates[k]) {
                weights += other.lobe[part].over(other.points);
            }
            (own.points > 0).then_some(weights)
        });
        let whole = lobe.whole[part];
        match found {
            [Some(a), Some(b)] => [
                corrected(a, b.share(), whole),
                corrected(b, a.share(), whole),
            ],
            [a, b] => [a.or(b).unwrap_or_default().share() * whole; 2],
        }
    }

    /// Adds the light that stands out of the sky's floor.
    fn add_map(&self, i: usize, k: usize, said: &mut Said) {
        let Some(map) = self.from.sky.map() else {
            return;
        };
        // What has no points takes what the other says.
        let [own, other] = [&self.from.sums[i][k], &self.from.sums[i][1 - k]];
        let own = if own.points > 0 { own } else { other };
        let scale = map.scale() / own.points.max(1) as f64;
        said.lights[0] += own.irradiance * scale;
        if let Some(lobe) = &self.from.lobes[i] {
            said.lights[1] += lobe.tinted(own.reflection) * scale;
        }
    }

    /// By what the weights of each replicate of a texel are corrected ([`corrected`]): the open share that the other replicate found. A few
    /// guided rays may all be open by chance although they are few of those that could be drawn; so where rays are guided it is that of
    /// the texels about it, if that is less. Where a replicate has no points, both slopes are what the other found.
    pub fn slopes(&self, i: usize, quantity: Quantity) -> [f64; 2] {
        let own = self.from.sums[i].each_ref();
        let [a, b] = own.map(|sums| weights(sums, quantity).share());
        let [a, b] = match own.map(|sums| sums.points > 0) {
            [true, true] => [b, a],
            [true, false] => [a, a],
            _ => [b, b],
        };
        if !self.from.guided[i] {
            return [a, b];
        }
        let mut pooled = [Weights::default(); 2];
        for j in neighbours(self.from.texels, &self.at, i, SLOPE_RADIUS) {
            for (sum, sums) in pooled.iter_mut().zip(&self.from.sums[j]) {
                *sum += weights(sums, quantity);
            }
        }
        [a.min(pooled[1].share()), b.min(pooled[0].share())]
    }

    /// The terms of one texel as far as the technique estimates them; zeros where nothing was spent.
    pub fn terms(&self, i: usize) -> Terms {
        if self.from.points[i] == 0 {
            return Terms::default();
        }
        let pool = self.pool(i, POOL_RADIUS);
        let technique = self.from.technique;
        let share = |quantity| match technique.shares().contains(&quantity) {
            false => Estimate::default(),
            true => Estimate {
                value: self.value(i, quantity),
                std_err: self.std_err(&pool, quantity),
            },
        };
        let light = |quantity| match technique.lights().contains(&quantity) {
            false => Estimate::default(),
            true => Estimate {
                value: self.light(i, quantity),
                std_err: self.std_err(&pool, quantity),
            },
        };
        Terms {
            diffuse: share(Diffuse),
            visibility: share(Visibility),
            specular: share(Specular),
            irradiance: light(Irradiance),
            reflection: light(Reflection),
            halves: self.halves(i),
            rays: Sums::of(&self.from.sums[i]).rays,
            ..Terms::default()
        }
    }

    /// Half of what the two halves of a texel's replicates differ by, in all that the technique estimates.
    fn halves(&self, i: usize) -> Halves {
        let [a, b] = &self.said[i];
        let share = |quantity: Quantity| 0.5 * (a.of(quantity) - b.of(quantity));
        Halves {
            diffuse: share(Diffuse),
            visibility: share(Visibility),
            specular: share(Specular),
            irradiance: 0.5 * (a.lights[0] - b.lights[0]),
            reflection: 0.5 * (a.lights[1] - b.lights[1]),
            ..Halves::default()
        }
    }

    /// A quantity of all replicates: a share, or the mean of the channels of light.
    pub fn value(&self, i: usize, quantity: Quantity) -> f64 {
        match quantity {
            Diffuse | Visibility | Specular => {
                let values = self.said[i].map(|said| said.of(quantity));
                mean(&self.from.sums[i], values).clamp(0.0, 1.0)
            }
            Irradiance | Reflection => self.light(i, quantity).element_sum() / 3.0,
        }
    }

    /// Light of all replicates. Means may be a little outside of what there is, as those of shares.
    fn light(&self, i: usize, quantity: Quantity) -> DVec3 {
        let which = usize::from(quantity == Reflection);
        let light = mean(
            &self.from.sums[i],
            self.said[i].map(|said| said.lights[which]),
        );
        match self.from.sky.map() {
            None => light.clamp(DVec3::ZERO, self.from.sky.floor()),
            Some(_) => light,
        }
    }

    /// The value of a quantity that all points would see.
    pub fn unit(&self, quantity: Quantity) -> f64 {
        match quantity {
            Diffuse | Visibility | Specular => 1.0,
            Irradiance | Reflection => self.from.sky.mean().element_sum() / 3.0,
        }
    }

    /// The variances of the texels about one, no more than `radius` away along an axis.
    fn pool(&self, i: usize, radius: i32) -> Pool {
        let mut pool = Pool::default();
        for j in neighbours(self.from.texels, &self.at, i, radius) {
            let (ratio, root) = match self.from.points[j] == self.from.points[i] {
                true => (1.0, 1.0),
                false => {
                    let ratio = f64::from(self.from.points[j]) / f64::from(self.from.points[i]);
                    (ratio, ratio.sqrt())
                }
            };
            for (sum, own) in pool.variances.iter_mut().zip(&self.own[j]) {
                *sum += own * ratio * root;
            }
            pool.texels += 1.0;
            pool.points += f64::from(self.from.points[j]);
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

/// The weights of a share of the hemisphere.
fn weights(sums: &Sums, quantity: Quantity) -> Weights {
    match quantity {
        Visibility => sums.visibility,
        _ => sums.diffuse,
    }
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
            means += corrected(a.over(2), b.share(), 1.0) / f64::from(tries);
            ratios += a.share() / f64::from(tries);
        }
        assert!((means - 0.75).abs() < 0.01, "{means}");
        assert!((ratios - 0.75).abs() > 0.03, "{ratios}");
    }

    #[test]
    fn weights_that_are_drawn_unevenly_are_no_error_where_all_is_open_or_closed() {
        let of = |open, all, slope| corrected(Weights { open, all }.over(2), slope, 1.0);
        assert_eq!([of(1.5, 1.5, 1.0), of(4.0, 4.0, 1.0)], [1.0, 1.0]);
        assert_eq!([of(0.0, 1.5, 0.0), of(0.0, 4.0, 0.0)], [0.0, 0.0]);
        assert_eq!(of(1.0, 4.0, 0.25), 0.25);
    }
}
