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

use super::sums::{REPLICATES, Replicates, Sums, Technique, Weights};
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

/// What a technique estimates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
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

/// A tile's texels with the sums of their replicates under one technique, of which `points[i]` have been spent on each.
pub(crate) struct Gathered<'a> {
    sky: &'a Sky,
    technique: Technique,
    texels: &'a [Texel],
    sums: &'a [Replicates],
    points: &'a [u32],
    /// Texel of each place in the tile; none where nothing was spent.
    at: [usize; (TILE * TILE) as usize],
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
    ) -> Self {
        let mut at = [usize::MAX; (TILE * TILE) as usize];
        for (i, texel) in texels.iter().enumerate() {
            if points[i] > 0 {
                at[(texel.y % TILE * TILE + texel.x % TILE) as usize] = i;
            }
        }
        let lights = match sky.map() {
            None => &[],
            Some(_) => technique.lights(),
        };
        let own = (0..texels.len())
            .map(|i| {
                let mut own = [0.0; 5];
                for &quantity in technique.shares().iter().chain(lights) {
                    own[quantity as usize] = own_variance(sky, &sums[i], points[i], quantity);
                }
                own
            })
            .collect();
        Self {
            sky,
            technique,
            texels,
            sums,
            points,
            at,
            own,
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
            value: value(self.sky, &sums, quantity),
            std_err: self.std_err(&pool, quantity),
        };
        let light = |quantity, term| match self.sky.map() {
            None => uniform_light(self.sky.floor(), term),
            Some(_) => Estimate {
                value: light(self.sky, &sums, quantity),
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
        let [a, b] = self.sums[i];
        let share = |quantity| match self.technique.shares().contains(&quantity) {
            true => 0.5 * (value(self.sky, &a, quantity) - value(self.sky, &b, quantity)),
            false => 0.0,
        };
        let (diffuse, specular) = (share(Diffuse), share(Specular));
        let light = |quantity, share: f64| match self.sky.map() {
            None => self.sky.floor() * share,
            Some(_) if self.technique.lights().contains(&quantity) => {
                0.5 * (light(self.sky, &a, quantity) - light(self.sky, &b, quantity))
            }
            Some(_) => DVec3::ZERO,
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

    /// True where the standard errors of a texel's first share, and of light in units of the sky's mean radiance, are at most
    /// `error`, or at most `relative` times the value where that is larger.
    pub fn is_met(&self, i: usize, radius: i32, error: f64, relative: f64) -> bool {
        let lights = match self.sky.map() {
            None => &[],
            Some(_) => self.technique.lights(),
        };
        let sums = Sums::of(&self.sums[i]);
        let pool = self.pool(i, radius);
        let mut watched = self.technique.shares().iter().take(1).chain(lights);
        watched.all(|&quantity| {
            let most = (error * self.unit(quantity)).max(match relative {
                0.0 => 0.0,
                _ => relative * value(self.sky, &sums, quantity),
            });
            self.std_err(&pool, quantity) <= most
        })
    }

    /// The value of a quantity that all points would see.
    fn unit(&self, quantity: Quantity) -> f64 {
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

/// A quantity from sums: a share, or the mean of the channels of light.
fn value(sky: &Sky, sums: &Sums, quantity: Quantity) -> f64 {
    match quantity {
        Diffuse => sums.diffuse.share(),
        Visibility => sums.visibility.share(),
        Specular => sums.specular.share(),
        Irradiance | Reflection => light(sky, sums, quantity).element_sum() / 3.0,
    }
}

/// Light from sums: the sky's floor by the share that is open, and what stands out of it.
fn light(sky: &Sky, sums: &Sums, quantity: Quantity) -> DVec3 {
    let (share, above) = match quantity {
        Reflection => (sums.specular.share(), sums.reflection),
        _ => (sums.diffuse.share(), sums.irradiance),
    };
    let scale = sky.map().map_or(0.0, |map| map.scale());
    sky.floor() * share + above * (scale / sums.points.max(1) as f64)
}

/// Variance of a quantity's mean. A share is a ratio of sums, whose error is, to first order, that of its numerator less the share times
/// its denominator; ratios of single replicates would spread by more.
fn own_variance(sky: &Sky, replicates: &Replicates, points: u32, quantity: Quantity) -> f64 {
    let total = Sums::of(replicates);
    let weights = |sums: &Sums| match quantity {
        Diffuse => sums.diffuse,
        Visibility => sums.visibility,
        Specular => sums.specular,
        Irradiance | Reflection => Weights::default(),
    };
    let all = weights(&total).all;
    if all == 0.0 {
        return spread(replicates, points, |sums| value(sky, sums, quantity));
    }
    let share = weights(&total).share();
    let each = all / total.points as f64;
    spread(replicates, points, |sums| {
        let own = weights(sums);
        (own.open - share * own.all) / (each * sums.points as f64)
    })
}

/// Variance of the mean of the replicates that have points.
fn spread(replicates: &Replicates, points: u32, of: impl Fn(&Sums) -> f64) -> f64 {
    let used = points.min(REPLICATES) as usize;
    let mut values = [0.0; REPLICATES as usize];
    for (value, sums) in values.iter_mut().zip(replicates) {
        *value = of(sums);
    }
    variance_of_mean(&values[..used])
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

    /// Replicates of two points each, with these weights of open rays and of all.
    fn replicates(weights: [[f64; 2]; 2]) -> Replicates {
        let mut replicates = Replicates::default();
        for (sums, [open, all]) in replicates.iter_mut().zip(weights) {
            sums.diffuse = Weights { open, all };
            sums.points = 2;
        }
        replicates
    }

    #[test]
    fn a_ratio_of_sums_states_what_its_numerator_leaves() {
        let sky = Sky::Uniform([1.0; 3]);
        let variance = |weights| own_variance(&sky, &replicates(weights), 2, Diffuse);
        // The share of both is 1/2, whatever their weights.
        assert_eq!(variance([[1.0, 2.0], [2.0, 4.0]]), 0.0);
        // 2 - 1/2 2 = 1 and 1 - 1/2 4 = -1 are left, by 3/2 a point and two points each: 1/3 and -1/3.
        let two = variance([[2.0, 2.0], [1.0, 4.0]]);
        assert!((two - 1.0 / 9.0).abs() < 1e-15, "{two}");
    }
}
