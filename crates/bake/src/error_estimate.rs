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

use crate::integrate::{REPLICATES, Replicates, Sums};
use crate::texel::Texel;
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
    pub rays: u64,
}

/// A tile's texels with the sums of their replicates, of which `points[i]` have been spent on each.
pub(crate) struct Gathered<'a> {
    texels: &'a [Texel],
    sums: &'a [Replicates],
    points: &'a [u32],
    /// Texel of each place in the tile; none where nothing was spent.
    at: [usize; (TILE * TILE) as usize],
    own: Vec<[f64; 2]>,
}

impl<'a> Gathered<'a> {
    /// All texels as they stand.
    pub fn new(texels: &'a [Texel], sums: &'a [Replicates], points: &'a [u32]) -> Self {
        let mut at = [usize::MAX; (TILE * TILE) as usize];
        for (i, texel) in texels.iter().enumerate() {
            if points[i] > 0 {
                at[(texel.y % TILE * TILE + texel.x % TILE) as usize] = i;
            }
        }
        let own = (0..texels.len())
            .map(|i| [first, second].map(|of| own_variance(&sums[i], points[i], of)))
            .collect();
        Self {
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
        let sums = &self.sums[i];
        Estimate {
            values: [mean(sums, first), mean(sums, second)],
            errors: [self.error(i, 0, 1), self.error(i, 1, 1)],
            bent: sums.iter().map(|s| s.bent).sum(),
            rays: sums.iter().map(|s| s.rays).sum(),
        }
    }

    /// Standard error of one of a texel's two sums. Variances pool over texels no more than `radius` away along an axis.
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
            1.5 / agreeing
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

fn first(sums: &Sums) -> (f64, f64) {
    sums.first
}

fn second(sums: &Sums) -> (f64, f64) {
    sums.second
}

fn ratio((open, all): (f64, f64)) -> f64 {
    if all > 0.0 { open / all } else { 0.0 }
}

fn mean(replicates: &Replicates, of: fn(&Sums) -> (f64, f64)) -> f64 {
    let sum = replicates
        .iter()
        .map(of)
        .fold((0.0, 0.0), |a, s| (a.0 + s.0, a.1 + s.1));
    ratio(sum)
}

fn own_variance(replicates: &Replicates, points: u32, of: fn(&Sums) -> (f64, f64)) -> f64 {
    let used = points.min(REPLICATES) as usize;
    let mut values = [0.0; REPLICATES as usize];
    for (value, sums) in values.iter_mut().zip(replicates) {
        *value = ratio(of(sums));
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
