//! From replicates of rays to coefficients with their errors.
//!
//! The sum of radiance times a harmonic over even directions is off even where radiance is a harmonic itself. So each
//! replicate sums only what the others' least-squares fit leaves, and takes the fit as it is: its points had no part in
//! that, so nothing is biased, and light that the harmonics hold, such as that of an open sky, comes out exactly.

use ambient::convention::SPHERE;
use ambient::harmonics::MOST;
use ambient::solve::cholesky;
use glam::DVec3;

/// Independent sets of the rays of a probe.
pub(crate) const REPLICATES: usize = 16;

/// Degrees of freedom over those less two: the variance of Student's distribution, by which so few sets spread wider
/// than they tell.
const STUDENT: f64 = (REPLICATES as f64 - 1.0) / (REPLICATES as f64 - 3.0);

/// The parts of the light that are kept apart.
pub(crate) const PARTS: usize = 3;

/// Coefficients of each part.
pub(crate) type Sums = [[DVec3; MOST]; PARTS];

/// What one replicate has seen.
#[derive(Debug, Clone)]
pub(crate) struct Replicate {
    /// Products of harmonics, summed over the even directions; row by row, from the diagonal on.
    products: [[f64; MOST]; MOST],
    /// Radiance of even directions times harmonics, summed.
    even: Sums,
    /// What was aimed, in coefficients.
    pub aimed: Sums,
    rays: u32,
}

impl Replicate {
    pub fn new() -> Self {
        Self {
            products: [[0.0; MOST]; MOST],
            even: [[DVec3::ZERO; MOST]; PARTS],
            aimed: [[DVec3::ZERO; MOST]; PARTS],
            rays: 0,
        }
    }

    /// Takes in an even direction, of which the first harmonics are `basis`; radiance follows by [`Self::light`].
    pub fn direction(&mut self, basis: &[f64]) {
        self.rays += 1;
        for (i, row) in self.products[..basis.len()].iter_mut().enumerate() {
            for j in i..basis.len() {
                row[j] += basis[i] * basis[j];
            }
        }
    }

    /// Adds radiance of a part from that direction.
    pub fn light(&mut self, part: usize, basis: &[f64], radiance: DVec3) {
        add(&mut self.even[part], basis, radiance);
    }

    /// Adds radiance over its density times the number of rays that were aimed.
    pub fn aim(&mut self, part: usize, basis: &[f64], radiance: DVec3) {
        add(&mut self.aimed[part], basis, radiance);
    }
}

/// Adds a value times harmonics.
pub(crate) fn add(sums: &mut [DVec3; MOST], basis: &[f64], value: DVec3) {
    for (sum, basis) in sums.iter_mut().zip(basis) {
        *sum += value * *basis;
    }
}

/// Coefficients of each part, and the standard errors of their sum.
pub(crate) fn coefficients(replicates: &[Replicate], terms: usize) -> (Sums, [DVec3; MOST]) {
    let mut all = Replicate::new();
    for one in replicates {
        for i in 0..terms {
            for j in i..terms {
                all.products[i][j] += one.products[i][j];
            }
            for part in 0..PARTS {
                all.even[part][i] += one.even[part][i];
            }
        }
    }
    let each: Vec<Sums> = replicates
        .iter()
        .map(|one| corrected(one, &all, terms))
        .collect();
    let count = replicates.len() as f64;
    let mut mean = [[DVec3::ZERO; MOST]; PARTS];
    let mut error = [DVec3::ZERO; MOST];
    for k in 0..terms {
        for part in 0..PARTS {
            mean[part][k] = each.iter().map(|of| of[part][k]).sum::<DVec3>() / count;
        }
        let whole = |of: &Sums| of.iter().map(|part| part[k]).sum::<DVec3>();
        let middle = whole(&mean);
        let spread = |of: &Sums| (whole(of) - middle) * (whole(of) - middle);
        let spread = each.iter().map(spread).sum::<DVec3>() / (count * (count - 1.0));
        error[k] = (STUDENT * spread).map(f64::sqrt);
    }
    (mean, error)
}

/// The coefficients that one replicate finds beside the fit of all others.
fn corrected(one: &Replicate, all: &Replicate, terms: usize) -> Sums {
    let weight = SPHERE / f64::from(one.rays);
    let product = |of: &Replicate, i: usize, j: usize| of.products[i.min(j)][i.max(j)];
    let mut found = one.aimed;
    for ((found, own), whole) in found.iter_mut().zip(&one.even).zip(&all.even) {
        if whole[..terms].iter().all(|sum| *sum == DVec3::ZERO) {
            continue;
        }
        let mut fit = [DVec3::ZERO; MOST];
        for channel in 0..3 {
            let mut matrix: Vec<f64> = (0..terms * terms)
                .map(|at| (at / terms, at % terms))
                .map(|(i, j)| product(all, i, j) - product(one, i, j))
                .collect();
            let mut right: Vec<f64> = (0..terms)
                .map(|k| whole[k][channel] - own[k][channel])
                .collect();
            if cholesky(&mut matrix, &mut right) {
                (0..terms).for_each(|k| fit[k][channel] = right[k]);
            }
        }
        for k in 0..terms {
            let told: DVec3 = (0..terms).map(|j| fit[j] * product(one, k, j)).sum();
            found[k] += fit[k] + weight * (own[k] - told);
        }
    }
    found
}
