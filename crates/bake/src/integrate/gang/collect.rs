//! What lanes have gathered, added to their texels' replicates.

use super::Gang;
use super::directional::DirectionSums;
use super::moments::Moments;
use crate::integrate::sums::{REPLICATES, Replicates, Technique, Weights};

impl Gang<'_> {
    /// Adds what the lanes have gathered to their texels' replicates.
    pub fn collect(&self, technique: Technique, sums: &mut [Replicates]) {
        for (l, lane) in self.lanes.iter().enumerate() {
            let mut own = self.sums.of_lane(technique, l, self.points);
            let gloss = self
                .gloss
                .as_ref()
                .filter(|_| technique == Technique::Hemisphere);
            if let Some([open, all]) = gloss.and_then(|gloss| gloss.of_lane(l)) {
                own.lobe = [0, 1].map(|k: usize| Weights {
                    open: open[k],
                    all: all[k],
                });
            }
            sums[lane.texel][lane.replicate] += own;
        }
    }

    /// Adds the harmonics that the lanes have gathered to their texels' replicates.
    pub fn collect_moments(&self, replicates: &mut [[Moments; REPLICATES as usize]]) {
        let Some(moments) = &self.moments else {
            return;
        };
        for (l, lane) in self.lanes.iter().enumerate() {
            moments.collect(l, self.points, &mut replicates[lane.texel][lane.replicate]);
        }
    }

    /// Adds the directions that the lanes have gathered to their texels' replicates.
    pub fn collect_directions(&self, replicates: &mut [[DirectionSums; REPLICATES as usize]]) {
        let Some(directions) = &self.directions else {
            return;
        };
        for (l, lane) in self.lanes.iter().enumerate() {
            directions.collect(l, &mut replicates[lane.texel][lane.replicate]);
        }
    }
}
