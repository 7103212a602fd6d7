//! What the rays of a texel add up to, by replicate.

use glam::DVec3;
use std::ops::AddAssign;

/// Independent randomisations of a texel's points: two halves, from which errors are stated and by which denoising is chosen.
pub(crate) const REPLICATES: u32 = 2;

/// How directions are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Technique {
    /// Over the hemisphere: diffuse, visibility, irradiance.
    Hemisphere,
    /// From the specular lobe: specular, reflection.
    Lobe,
    /// From the light of the illumination map: irradiance, reflection.
    Sky,
}

/// Weights of open rays and of all rays.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Weights {
    pub open: f64,
    pub all: f64,
}

/// Sums over the rays of one replicate. A technique fills what it estimates; the rest stays 0.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sums {
    pub diffuse: Weights,
    pub visibility: Weights,
    pub specular: Weights,
    /// Light above the sky's floor divided by the sky's scale.
    pub irradiance: DVec3,
    /// The same of the lobe.
    pub reflection: DVec3,
    /// Points of the stream.
    pub points: u64,
    pub rays: u64,
}

/// Sums over the points of one replicate for a GGX lobe: what the lobe weighs each direction with over the density of all techniques that
/// may draw it, without colour and times Fresnel's (1 - V·H)^5.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GlossSums {
    /// Open directions.
    pub open: [f64; 2],
    /// All directions.
    pub all: [f64; 2],
    /// Open directions times the light above the sky's floor divided by the sky's scale.
    pub light: [DVec3; 2],
    pub points: u32,
}

/// One texel's replicates.
pub(crate) type Replicates = [Sums; REPLICATES as usize];

impl Weights {
    /// The open share; 0 where nothing was drawn.
    pub fn share(self) -> f64 {
        if self.all > 0.0 {
            self.open / self.all
        } else {
            0.0
        }
    }
}

impl AddAssign for Weights {
    fn add_assign(&mut self, other: Self) {
        self.open += other.open;
        self.all += other.all;
    }
}

impl AddAssign for Sums {
    fn add_assign(&mut self, other: Self) {
        self.diffuse += other.diffuse;
        self.visibility += other.visibility;
        self.specular += other.specular;
        self.irradiance += other.irradiance;
        self.reflection += other.reflection;
        self.points += other.points;
        self.rays += other.rays;
    }
}

impl AddAssign for GlossSums {
    fn add_assign(&mut self, other: Self) {
        for k in 0..2 {
            self.open[k] += other.open[k];
            self.all[k] += other.all[k];
            self.light[k] += other.light[k];
        }
        self.points += other.points;
    }
}

/// An open share by one replicate of so many points, with the slope β: `(Σ w V - β Σ (w - 1)) / n`. The mean of weights is 1, so no mean is
/// moved, however few the points are, if β is independent of them; the mean of a ratio would be. With β = V, as where all is
/// open or closed, weights that were drawn unevenly do not count.
pub(crate) fn corrected(own: Weights, points: u64, slope: f64) -> f64 {
    let points = points as f64;
    (own.open - slope * (own.all - points)) / points
}

/// The mean of what each replicate says, by its points.
pub(crate) fn mean<T>(replicates: &Replicates, [a, b]: [T; 2]) -> T
where
    T: std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
{
    let [of_a, of_b] = replicates.each_ref().map(|sums| sums.points as f64);
    let all = (of_a + of_b).max(1.0);
    a * (of_a / all) + b * (of_b / all)
}

impl Sums {
    /// The sums of all replicates.
    pub fn of(replicates: &Replicates) -> Self {
        let mut total = Self::default();
        for sums in replicates {
            total += *sums;
        }
        total
    }
}
