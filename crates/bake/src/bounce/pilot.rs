//! What gathers will take, from that of the lights and the first of surfaces on a few tiles in light that is even
//! everywhere.

use super::REPLICATES;
use super::light::{BounceStats, TexelLight};
use super::radiosity::PageLight;
use super::spots::Spots;
use super::{Gather, mean};
use crate::choice::Choice;
use crate::clock::ThreadClock;
use crate::options::Bounces;
use crate::page::{Baker, remade};
use atlas::PageRaster;
use glam::DVec3;
use rays::{Lamps, Light};
use std::iter::Sum;

/// The first gathers as a pilot runs them.
pub(crate) struct GatherPilot<'a> {
    baker: &'a Baker<'a>,
    bounces: bool,
    lamps: Lamps,
    lights: Vec<Light>,
    spots: Spots,
    sent: Vec<PageLight>,
}

/// What tiles took in the pilot.
#[derive(Default)]
pub(crate) struct Taken {
    rays: f64,
    /// Processor seconds before a ray is cast, and those of the rays.
    survey: f64,
    light: f64,
    /// What the texels received, and its squares.
    received: [f64; 2],
    /// Rays to lights, and the processor seconds of their gather.
    direct: [f64; 2],
}

impl<'a> GatherPilot<'a> {
    /// `None` where no light is added to finished pages.
    pub fn of(baker: &'a Baker<'a>) -> Option<Self> {
        let texels = (baker.atlas.page_size as usize).pow(2);
        let even = || PageLight {
            irradiance: vec![[1.0; 3]; texels],
            holds: vec![true; texels],
        };
        let bounces = baker.plan.models(Choice::Bounces);
        (bounces || baker.plan.models(Choice::Lights)).then(|| Self {
            baker,
            bounces,
            lamps: Lamps::of(baker.world),
            lights: baker.lights(),
            spots: Spots::default(),
            sent: (0..baker.atlas.page_count).map(|_| even()).collect(),
        })
    }

    /// Runs a tile.
    pub fn tile(&self, raster: &PageRaster<'_>, page: u32, index: usize) -> Taken {
        let of_surfaces = || self.baker.gather(&self.sent, true, &self.spots);
        let clock = ThreadClock::now();
        let texels = self.baker.survey(raster, page, index);
        let survey = clock.seconds();
        let rays = |light: &[TexelLight]| light.iter().map(|texel| texel.rays as f64).sum();
        let mut direct = [0.0; 2];
        if !self.lights.is_empty() {
            let gather = Gather {
                lights: &self.lights,
                ..of_surfaces()
            };
            let light = self.baker.tile_light(&gather, 0, page as usize, &texels);
            direct = [rays(&light), clock.seconds()];
        }
        if !self.bounces {
            return Taken {
                direct,
                ..Taken::default()
            };
        }
        let gather = Gather {
            lamps: (!self.lamps.is_empty()).then_some(&self.lamps),
            ..of_surfaces()
        };
        let clock = ThreadClock::now();
        let light = self.baker.tile_light(&gather, 0, page as usize, &texels);
        let received = |rgb: &[DVec3]| mean(rgb.iter().sum::<DVec3>()) / f64::from(REPLICATES);
        let received: Vec<f64> = light
            .iter()
            .map(|texel| received(&texel.irradiance))
            .collect();
        Taken {
            rays: rays(&light),
            survey,
            light: clock.seconds(),
            direct,
            received: [received.iter().sum(), received.iter().map(|r| r * r).sum()],
        }
    }

    /// Rays and seconds of all gathers over the tiles of the pilot.
    pub fn all(&self, taken: &Taken) -> (u64, f64) {
        let [rays, seconds] = taken.direct;
        if !self.bounces {
            return (rays as u64, seconds);
        }
        // A step of the power iteration: light gathers where most of it comes back.
        let [sum, squares] = taken.received;
        let ratio = if sum > 0.0 { squares / sum } else { 0.0 };
        let bounces = self.baker.options.bounces.before_last();
        let before = f64::from(gathers(bounces, ratio, self.baker.enough()));
        // In units of the last.
        let points = |last| f64::from(self.baker.gather(&self.sent, last, &self.spots).points);
        let work = 1.0 + before * points(false) / points(true);
        let survey = (1.0 + before) * remade(self.baker.atlas.audit.texels) * taken.survey;
        let seconds = seconds + survey + work * taken.light;
        ((rays + taken.rays * work) as u64, seconds)
    }
}

/// How many gathers there are if each brings `ratio` times the light of the one before.
fn gathers(bounces: Bounces, ratio: f64, enough: f64) -> u32 {
    let mut stats = BounceStats::default();
    let (mut last, mut added) = (1.0, 0.0);
    while stats.goes_on(bounces, enough) {
        last *= ratio;
        added += last;
        stats.end(1.0, added);
    }
    stats.gathers
}

impl Sum for Taken {
    fn sum<I: Iterator<Item = Self>>(tiles: I) -> Self {
        tiles.fold(Self::default(), |a, b| Self {
            rays: a.rays + b.rays,
            survey: a.survey + b.survey,
            light: a.light + b.light,
            received: [0, 1].map(|k| a.received[k] + b.received[k]),
            direct: [0, 1].map(|k| a.direct[k] + b.direct[k]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gathers_go_on_until_the_rest_of_the_series_is_small() {
        assert_eq!(gathers(Bounces::Off, 0.5, 1e-2), 0);
        assert_eq!(gathers(Bounces::Most(3), 0.5, 1e-2), 3);
        // 1 + 1/2 + 1/4 + ...: after k gathers 2^-k of 2 - 2^-k is the last, and as much is missing, of which a
        // fiftieth is in doubt.
        assert_eq!(gathers(Bounces::Auto, 0.5, 1.0 / 512.0), 3);
        assert_eq!(gathers(Bounces::Auto, 0.5, 1e-4), 7);
        assert_eq!(gathers(Bounces::Auto, 0.0, 1.0 / 512.0), 1);
    }
}
