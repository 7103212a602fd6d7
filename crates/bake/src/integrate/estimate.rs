//! Values and standard errors of a tile's texels from their replicates.
//!
//! **Variance.** The replicates are independent randomisations, so `s²/R` is an unbiased estimate of the variance of their mean,
//! whatever the point set. From four values it is itself uncertain by 80 %, and an interval of ±1.96 of it would cover far less
//! than 95 %; texels of one surface therefore pool their variances over the 3 x 3 neighbourhood in their tile. A neighbour with other
//! numbers of points counts as if its variance fell like N^-3/2, the law for visibility boundaries (D. Mitchell,
//! "Consequences of Stratified Sampling in Graphics", 1996).
//!
//! **Floor.** Replicates that all agree have no spread, yet something smaller than the points may stand between them: by
//! the rule of three its share is below 3/N with 95 % confidence, which is two standard errors of 1.5/N, with N all points that
//! agree.

use super::{REPLICATES, Replicates, Sums, Term};
use crate::options::Sky;
use crate::survey::Texel;
use atlas::TILE;
use glam::DVec3;

/// Neighbours pool where their normals are within acos of this, some 37 degrees.
const NORMAL_AGREEMENT: f64 = 0.8;

/// One texel's values of one term's two sums.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Estimate {
    pub values: [f64; 2],
    /// Standard errors.
    pub errors: [f64; 2],
    pub bent: DVec3,
    /// Light, linear RGB, and the standard error of the mean of its channels: of the term itself; of diffuse and specular for
    /// [`Term::Sky`].
    pub light: [DVec3; 2],
    pub light_errors: [f64; 2],
    pub rays: u64,
}

/// A tile's texels with the sums of their replicates, of which `points[i]` have been spent on each.
pub(crate) struct Gathered<'a> {
    sky: &'a Sky,
    texels: &'a [Texel],
    sums: &'a [Replicates],
    points: &'a [u32],
    /// Texel of each place in the tile; none where nothing was spent.
    at: [usize; (TILE * TILE) as usize],
    /// Variances of the two sums, and of the two lights where the sky is a map.
    own: Vec<[f64; 4]>,
}

impl<'a> Gathered<'a> {
    /// All texels as they stand.
    pub fn new(
        sky: &'a Sky,
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
        let own = (0..texels.len())
            .map(|i| {
                let own = |of: &dyn Fn(&Sums) -> f64| own_variance(&sums[i], points[i], of);
                let [a, b] = [own(&|s| ratio(s.first)), own(&|s| ratio(s.second))];
                let [c, d] = match sky.map() {
                    None => [0.0; 2],
                    Some(_) => [0, 1].map(|k| own(&|s| light(sky, s, k).element_sum() / 3.0)),
                };
                [a, b, c, d]
            })
            .collect();
        Self {
            sky,
            texels,
            sums,
            points,
            at,
            own,
        }
    }

    /// Values and errors of one texel; zeros where nothing was spent.
    pub fn estimate(&self, i: usize) -> Estimate {
        if self.points[i] == 0 {
            return Estimate::default();
        }
        let sums = total(&self.sums[i]);
        let errors = [self.error(i, 0, 1), self.error(i, 1, 1)];
        let mean = self.sky.floor().element_sum() / 3.0;
        Estimate {
            values: [ratio(sums.first), ratio(sums.second)],
            errors,
            bent: sums.bent,
            light: [0, 1].map(|k| light(self.sky, &sums, k)),
            light_errors: match self.sky.map() {
                None => errors.map(|error| mean * error),
                Some(_) => [self.error(i, 2, 1), self.error(i, 3, 1)],
            },
            rays: sums.rays,
        }
    }

    /// What a texel's stopping depends on: the standard error of its first sum, and of light in units of the sky's mean radiance.
    pub fn watched(&self, i: usize, term: Term, radius: i32) -> f64 {
        let sums: &[usize] = match (term, self.sky.map()) {
            (Term::Hemisphere | Term::Lobe, None) => &[0],
            (Term::Hemisphere | Term::Lobe, Some(_)) => &[0, 2],
            (Term::Sky, _) => &[2, 3],
        };
        let errors = sums
            .iter()
            .map(|&sum| self.error(i, sum, radius) / self.unit(sum));
        errors.fold(0.0, f64::max)
    }

    /// The value of a sum that all points would see.
    fn unit(&self, sum: usize) -> f64 {
        match sum {
            0 | 1 => 1.0,
            _ => self.sky.mean().element_sum() / 3.0,
        }
    }

    /// Standard error of one of a texel's sums. Variances pool over texels no more than `radius` away along an axis.
    pub fn error(&self, i: usize, sum: usize, radius: i32) -> f64 {
        let (mut variances, mut count, mut agreeing) = (0.0, 0.0, 0.0);
        for j in neighbours(self.texels, &self.at, i, radius) {
            let ratio = f64::from(self.points[j]) / f64::from(self.points[i]);
            variances += self.own[j][sum] * ratio * ratio.sqrt();
            count += 1.0;
            agreeing += f64::from(self.points[j]);
        }
        if variances > 0.0 {
            f64::sqrt(variances / count)
        } else {
            1.5 / agreeing * self.unit(sum)
        }
    }
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

fn ratio((open, all): (f64, f64)) -> f64 {
    if all > 0.0 { open / all } else { 0.0 }
}

/// Light of a term: the sky's floor by the share that is open, and what stands out of it. [`Term::Sky`] has the latter alone: its
/// share is 0.
fn light(sky: &Sky, sums: &Sums, which: usize) -> DVec3 {
    let share = [ratio(sums.first), 0.0][which];
    let scale = sky.map().map_or(0.0, |map| map.scale());
    sky.floor() * share + sums.light[which] * (scale / sums.points.max(1) as f64)
}

/// The sums of all replicates.
fn total(replicates: &Replicates) -> Sums {
    let mut total = Sums::default();
    for sums in replicates {
        total += *sums;
    }
    total
}

fn own_variance(replicates: &Replicates, points: u32, of: &dyn Fn(&Sums) -> f64) -> f64 {
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
