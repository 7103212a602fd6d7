//! When texels have enough rays.
//!
//! Where pages are not denoised each texel decides by itself, from the errors of the texels about it ([`Target::is_met`]). Where they are, it
//! is the denoised error that has to be small, which neighbours have in common; and fits tell noise from detail best where all texels
//! have as many rays. So the texels of a tile decide together, by what the denoiser would leave of the tile alone ([`Target::excess`]).

use super::estimate::{Gathered, Quantity};
use crate::denoise::{Denoiser, Field, Term};
use crate::survey::Texel;
use atlas::TILE;

/// Texels this far away along an axis pool their variances when a texel decides to stop.
const STOP_RADIUS: i32 = 3;

/// Share of a tile's texels whose denoised errors may stay above the target.
const LEFT: f64 = 0.05;

/// How the denoised error falls with the number of points, at least: like its power of minus this.
const FALLS: f64 = 0.6;

/// A standard error that is small enough, of a share or of light in units of the sky's mean radiance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    pub error: f64,
    /// Or so much of the value, where that is larger.
    pub relative: f64,
    pub max_rays: u32,
}

impl Target {
    /// True where the standard errors of what the technique is watched for are small enough at a texel.
    pub fn is_met(&self, gathered: &Gathered<'_>, i: usize) -> bool {
        let mut watched = gathered.watched();
        watched.all(|quantity| {
            let std_err = gathered.std_err_within(i, STOP_RADIUS, quantity);
            std_err <= self.allowed(gathered, i, quantity)
        })
    }

    /// How many times as large as it may be the error of texels is after denoising, but for the worst of them.
    pub fn excess(&self, gathered: &Gathered<'_>, together: &Together<'_>) -> f64 {
        let which = together.which;
        let mut excess = vec![0.0; which.len()];
        for quantity in gathered.watched() {
            let std_errs = together.std_errs(gathered, quantity);
            for ((excess, &i), std_err) in excess.iter_mut().zip(which).zip(std_errs) {
                *excess = f64::max(*excess, std_err / self.allowed(gathered, i, quantity));
            }
        }
        let all_but = ((1.0 - LEFT) * which.len() as f64) as usize;
        let (_, excess, _) =
            excess.select_nth_unstable_by(all_but.min(which.len() - 1), f64::total_cmp);
        *excess
    }

    /// The points that it takes to be met, of texels that exceed it so many times with `points`.
    pub fn points(&self, points: u32, excess: f64) -> u32 {
        (f64::from(points) * excess.powf(1.0 / FALLS)) as u32
    }

    /// The largest standard error that a texel may have.
    fn allowed(&self, gathered: &Gathered<'_>, i: usize, quantity: Quantity) -> f64 {
        let relative = match self.relative {
            0.0 => 0.0,
            relative => relative * gathered.value(i, quantity),
        };
        relative.max(self.error * gathered.unit(quantity))
    }
}

/// Texels of a tile that have enough together.
pub(super) struct Together<'a> {
    which: &'a [usize],
    /// Where each of them stands in the tile.
    places: Vec<usize>,
    denoiser: Denoiser<'static>,
}

impl<'a> Together<'a> {
    /// The texels `which`, one at least.
    pub fn new(texels: &[Texel], which: &'a [usize]) -> Self {
        let place = |&i: &usize| (texels[i].y % TILE * TILE + texels[i].x % TILE) as usize;
        let places: Vec<usize> = which.iter().map(place).collect();
        let plane =
            |of: &dyn Fn(&Texel) -> f64| plane(&places, which.iter().map(|&i| of(&texels[i])));
        let home = texels[which[0]].position;
        let position = [0, 1, 2].map(|k: usize| plane(&|texel| texel.position[k] - home[k]));
        let normal = [0, 1, 2].map(|k: usize| plane(&|texel| texel.normal[k]));
        let denoiser = Denoiser::of_tile(&Field {
            size: TILE as usize,
            coverage: &plane(&|_| 1.0),
            validity: None,
            position: position.each_ref().map(Vec::as_slice),
            normal: normal.each_ref().map(Vec::as_slice),
            object: &plane(&|texel| f64::from(texel.object)),
        });
        Self {
            which,
            places,
            denoiser,
        }
    }

    /// The standard errors that the denoiser would state of each, of the tile alone.
    fn std_errs(&self, gathered: &Gathered<'_>, quantity: Quantity) -> impl Iterator<Item = f64> {
        let plane =
            |of: &dyn Fn(usize) -> f64| plane(&self.places, self.which.iter().map(|&i| of(i)));
        let values = plane(&|i| gathered.value(i, quantity));
        let halves = plane(&|i| gathered.half(i, quantity));
        let mut std_errs = plane(&|i| gathered.std_err_of(i, quantity));
        let found = self.denoiser.denoise(&Term {
            values: vec![&values],
            halves: vec![&halves],
            std_err: &std_errs,
            largest: f32::INFINITY,
            is_smooth: quantity == Quantity::Diffuse,
            crosses: false,
        });
        found.iter().for_each(|part| part.set_errors(&mut std_errs));
        self.places
            .iter()
            .map(move |&place| f64::from(std_errs[place]))
    }
}

/// A plane of a tile with these values at these places, 0 elsewhere.
fn plane(places: &[usize], values: impl Iterator<Item = f64>) -> Vec<f32> {
    let mut plane = vec![0.0; (TILE * TILE) as usize];
    places
        .iter()
        .zip(values)
        .for_each(|(&place, value)| plane[place] = value as f32);
    plane
}
