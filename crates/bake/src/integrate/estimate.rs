//! Values and standard errors of a tile's texels from their replicates.
//!
//! **Variance.** The replicates are independent randomisations, so `s²/R` is an unbiased estimate of the variance of
//! their mean, whatever the point set. From two values it is itself uncertain by 140 %, and an interval of ±1.96 of it
//! would cover far less than 95 %; texels of one surface therefore pool their variances over the 5 x 5 neighbourhood in
//! their tile. A neighbour with other numbers of points counts as if its variance fell like N^-3/2, the law for
//! visibility boundaries (D. Mitchell, "Consequences of Stratified Sampling in Graphics", 1996).
//!
//! **Floor.** Replicates that all agree have no spread, yet something smaller than the points may stand between them:
//! by the rule of three its share is below 3/N with 95 % confidence, which is two standard errors of 1.5/N, with N all
//! points that agree.
//!
//! **Mean.** Rays weigh unevenly, above all where they are guided. A share is no ratio of sums, whose mean is off where
//! rays are few; the weights of each replicate are corrected by what the other one found ([`Known::slopes`]).

use super::lobe::Lobe;
use super::pool::Pool;
use super::sums::{REPLICATES, Replicates, Sums, Technique, Weights, corrected, mean, rays};
use super::task::Task;
use super::terms::{Halves, Terms, uniform_light};
use crate::survey::Texel;
use ambient::Estimate;
use environment::SkyMap;
use glam::DVec3;

/// Texels this far away along an axis pool their variances.
const POOL_RADIUS: usize = 2;

/// Texels this far away along an axis pool their slopes.
const SLOPE_RADIUS: usize = 1;

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
    /// What it estimates: shares, and light. Under a sky without a map irradiance follows from the diffuse share.
    fn quantities(self, has_map: bool) -> &'static [Quantity] {
        match self {
            Technique::Hemisphere if has_map => &[Diffuse, Visibility, Irradiance],
            Technique::Hemisphere => &[Diffuse, Visibility],
            Technique::Lobe => &[Specular, Reflection],
            Technique::Sky => &[Irradiance, Reflection],
        }
    }
}

/// What one replicate says of a texel; 0 for what the technique does not estimate.
#[derive(Debug, Clone, Copy, Default)]
struct Said {
    shares: [f64; 3],
    /// The open share of the lobe's white part.
    white: f64,
    lights: [DVec3; 2],
}

/// A tile's texels with the sums of their replicates under one technique, of which `points[i]` have been spent on each.
pub(crate) struct Gathered<'a> {
    pub task: &'a Task<'a>,
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
    said: Vec<[Said; 2]>,
    pool: Pool,
    /// Open and all weights of both shares, of both replicates, of each texel and those about it; none where no
    /// texel is guided.
    about: Vec<[f64; 8]>,
}

impl<'a> Gathered<'a> {
    /// What the sums say.
    pub fn known(self) -> Known<'a> {
        let pool = Pool::of(self.task.arch, self.texels);
        let about = match self.guided.contains(&true) {
            true => pool.sums(SLOPE_RADIUS, self.texels, |i| {
                let [a, b] = &self.sums[i];
                let all = [a.diffuse, b.diffuse, a.visibility, b.visibility];
                std::array::from_fn(|k| [all[k / 2].open, all[k / 2].all][k % 2])
            }),
            false => Vec::new(),
        };
        let count = self.texels.len();
        let mut known = Known {
            from: self,
            said: vec![Default::default(); count],
            pool,
            about,
        };
        for i in (0..count).filter(|&i| known.from.points[i] > 0) {
            known.said[i] = known.says(i);
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
                    said.white = match lobe.whole[1] > 0.0 {
                        true => white[k] / lobe.whole[1],
                        false => said.shares[Specular as usize],
                    };
                    let open = [plain[k], white[k]].map(DVec3::splat);
                    said.lights[1] = DVec3::from(self.from.task.sky.floor()) * lobe.tinted(open);
                }
            }
            Technique::Sky => {}
        }
        if let Some(map) = self.from.task.sky.map() {
            for (k, said) in said.iter_mut().enumerate() {
                said.lights[0] =
                    DVec3::from(self.from.task.sky.floor()) * said.shares[Diffuse as usize];
                self.add_map(map, (i, k), said);
            }
        }
        said
    }

    /// What the directions of a lobe that each replicate finds open weigh, without colour (`part` 0) or times (1 -
    /// V·H)^5 (1).
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
    fn add_map(&self, map: &SkyMap, (i, k): (usize, usize), said: &mut Said) {
        // What has no points takes what the other says.
        let [own, other] = [&self.from.sums[i][k], &self.from.sums[i][1 - k]];
        let own = if own.points > 0 { own } else { other };
        let scale = map.scale() / own.points.max(1) as f64;
        said.lights[0] += own.irradiance * scale;
        if let Some(lobe) = &self.from.lobes[i] {
            said.lights[1] += lobe.tinted(own.reflection) * scale;
        }
    }

    /// By what the weights of each replicate of a texel are corrected ([`corrected`]): the open share that the other
    /// replicate found. A few guided rays may all be open by chance although they are few of those that could be drawn;
    /// so where rays are guided it is that of the texels about it, if that is less. Where a replicate has no points,
    /// both slopes are what the other found.
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
        let first = if quantity == Visibility { 4 } else { 0 };
        let share = |replicate: usize| {
            let [open, all] = [0, 1].map(|k| self.about[i][first + 2 * replicate + k]);
            Weights { open, all }.share()
        };
        [a.min(share(1)), b.min(share(0))]
    }

    /// Adds what the technique says to the terms of the texels on which points were spent.
    pub fn add_to(&self, terms: &mut [Terms]) {
        let sky = self.from.task.sky;
        let quantities = self.from.technique.quantities(sky.map().is_some());
        let follows = self.from.technique == Technique::Hemisphere && sky.map().is_none();
        let pools = self.pools(quantities);
        for (i, terms) in terms.iter_mut().enumerate() {
            let points = f64::from(self.from.points[i]);
            if points == 0.0 {
                continue;
            }
            let [texels, all, variances @ ..] = pools[i];
            for (&quantity, sum) in quantities.iter().zip(variances) {
                let std_err = match sum > 0.0 {
                    true => (sum / (texels * points * points.sqrt())).sqrt(),
                    false => 1.5 / all * self.unit(quantity),
                };
                let share = || Estimate {
                    value: self.value(i, quantity),
                    std_err,
                };
                let light = || Estimate {
                    value: self.light(i, quantity),
                    std_err,
                };
                match quantity {
                    Diffuse => terms.diffuse = share(),
                    Visibility => terms.visibility = share(),
                    Specular => {
                        terms.specular = share();
                        let white = self.said[i].map(|said| said.white);
                        terms.white = mean(&self.from.sums[i], white).clamp(0.0, 1.0);
                    }
                    Irradiance if self.from.task.hemisphere => add(&mut terms.irradiance, light()),
                    Reflection if self.from.lobes[i].is_some() => {
                        add(&mut terms.reflection, light());
                    }
                    Irradiance | Reflection => {}
                }
            }
            self.add_halves(i, quantities, &mut terms.halves);
            if follows {
                let floor = DVec3::from(sky.floor());
                terms.irradiance = uniform_light(floor, terms.diffuse);
                terms.halves.irradiance = floor * terms.halves.diffuse;
            }
            terms.rays += rays(&self.from.sums[i]);
        }
    }

    /// Of each texel and those of its surface about it: how many have points, these points, and the sum of the
    /// variances of the mean of each quantity, as if all had a point.
    fn pools(&self, quantities: &[Quantity]) -> Vec<[f64; 5]> {
        self.pool.sums(POOL_RADIUS, self.from.texels, |i| {
            let points = self.from.points[i];
            let weight = f64::from(points);
            let used = points.min(REPLICATES) as usize;
            let mut values = [f64::from(u8::from(points > 0)), weight, 0.0, 0.0, 0.0];
            for (variance, &quantity) in values[2..].iter_mut().zip(quantities) {
                let said = self.said[i].map(|said| said.of(quantity));
                *variance = variance_of_mean(&said[..used]) * weight * weight.sqrt();
            }
            values
        })
    }

    /// Adds half of what the two halves of a texel's replicates differ by, in all that the technique estimates.
    fn add_halves(&self, i: usize, quantities: &[Quantity], halves: &mut Halves) {
        let [a, b] = &self.said[i];
        for &quantity in quantities {
            let share = || 0.5 * (a.of(quantity) - b.of(quantity));
            match quantity {
                Diffuse => halves.diffuse += share(),
                Visibility => halves.visibility += share(),
                Specular => halves.specular += share(),
                Irradiance => halves.irradiance += 0.5 * (a.lights[0] - b.lights[0]),
                Reflection => halves.reflection += 0.5 * (a.lights[1] - b.lights[1]),
            }
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
        match self.from.task.sky.map() {
            None => light.clamp(DVec3::ZERO, DVec3::from(self.from.task.sky.floor())),
            Some(_) => light,
        }
    }

    /// The value of a quantity that all points would see.
    pub fn unit(&self, quantity: Quantity) -> f64 {
        match quantity {
            Diffuse | Visibility | Specular => 1.0,
            Irradiance | Reflection => self.from.task.sky.brightness(),
        }
    }
}

/// Adds independent light.
fn add(light: &mut Estimate<DVec3>, other: Estimate<DVec3>) {
    light.value += other.value;
    light.std_err = light.std_err.hypot(other.std_err);
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
