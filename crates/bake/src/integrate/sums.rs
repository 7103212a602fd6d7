//! What the rays of a texel add up to, by replicate.

use glam::DVec3;
use std::ops::AddAssign;

/// Independent randomisations of a texel's points: two halves, from which errors are stated and by which denoising is
/// chosen.
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
    /// Of the lobe: without colour, and under GGX times Fresnel's (1 - V·H)^5. Each direction weighs the lobe over the
    /// density of all techniques that may draw it.
    pub lobe: [Weights; 2],
    /// Light above the sky's floor divided by the sky's scale.
    pub irradiance: DVec3,
    /// The same of the lobe, likewise twice.
    pub reflection: [DVec3; 2],
    /// Points of the stream.
    pub points: u64,
    pub rays: u64,
}

/// One texel's replicates.
pub(crate) type Replicates = [Sums; REPLICATES as usize];

impl Weights {
    /// Means over so many points.
    pub fn over(self, points: u64) -> Self {
        let scale = 1.0 / points.max(1) as f64;
        Self {
            open: self.open * scale,
            all: self.all * scale,
        }
    }

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
        self.irradiance += other.irradiance;
        for k in 0..2 {
            self.lobe[k] += other.lobe[k];
            self.reflection[k] += other.reflection[k];
        }
        self.points += other.points;
        self.rays += other.rays;
    }
}

/// An open share by the mean weights of one replicate, with the slope β: `(Σ w V - β Σ (w - 1)) / n`, where all
/// directions weigh `whole` in the mean in place of 1. So no mean is moved, however few the points are, if β is
/// independent of them; the mean of a ratio would be. With β = V, as where all is open or closed, weights that were
/// drawn unevenly do not count.
pub(crate) fn corrected(own: Weights, slope: f64, whole: f64) -> f64 {
    own.open - slope * (own.all - whole)
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

/// The rays of all replicates.
pub(crate) fn rays(replicates: &Replicates) -> u64 {
    replicates.iter().map(|sums| sums.rays).sum()
}
