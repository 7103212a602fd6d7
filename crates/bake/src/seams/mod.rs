//! Seams: where one surface goes on in another chart, a bilinear look-up must find the same light on both sides.
//!
//! Charts end at borders. Along a border a look-up mixes texels of the chart with texels of its gutter, and the chart
//! on the other side does the same with other texels, so the two sides show a step even where both are right on the
//! mean. Three things make it: noise, the gutter, and texels that the border cuts, whose mean is not the value at their
//! centre.
//!
//! [`Seams::find`] pairs borders in space, whether of one object or of two that abut, and puts points on them, each
//! with its place on both charts. `solve` then moves the texels that are looked up there, gutters too, to the least
//! squares of
//!
//! * the difference of the two bilinear look-ups at every point,
//! * the difference between the look-up at the middle of a texel's footprint and the texel's mean, in units of what is
//!   known about it,
//! * the departure of a gutter texel from its neighbours' mean, weakly.
//!
//! The first use in a game: M. Iwanicki, "Lighting Technology of The Last of Us", SIGGRAPH 2013.

mod across;
mod border;
mod owner;
mod pair;
mod solve;
mod system;
mod walls;

pub(crate) use solve::Known;
#[cfg(test)]
mod tests;

use crate::options::Seams as Scope;
pub(crate) use across::Across;
use across::Outer;
use atlas::{Atlas, PageRaster};
use border::Chart;
use glam::{DVec2, Vec2};
use owner::Page;
use rayon::prelude::*;
use rays::World;
use serde::{Deserialize, Serialize};
pub(crate) use solve::System;

/// A point on a seam, in texels of the page on both of its charts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SeamPoint {
    pub sides: [DVec2; 2],
    /// The ways of one scene unit away from the seam into both charts.
    pub inward: [Vec2; 2],
    /// The charts of both sides.
    pub charts: [Chart; 2],
    /// Texels of seam that it stands for.
    pub length: f64,
}

/// The seams of one page.
#[derive(Debug, Default)]
pub(crate) struct Seams {
    points: Vec<SeamPoint>,
    /// Where its charts go on on other pages.
    outer: Vec<Outer>,
    /// The chart of each triangle, mesh by mesh.
    charts: Vec<Vec<u32>>,
}

/// How far the two sides of seams differ, over all points, for the diffuse term.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SeamStats {
    /// Points at which both sides were looked up.
    pub points: u64,
    /// Sum of squared differences before seams were solved, with gutters filled.
    pub squares_before: f64,
    /// The same after.
    pub squares_after: f64,
    /// The largest difference before.
    pub max_before: f64,
    /// The largest difference after.
    pub max_after: f64,
    /// Sum over the texels of charts of the squares of what they moved by.
    pub squares_moved: f64,
}

impl SeamStats {
    /// Counts those of another page.
    pub fn append(&mut self, other: &Self) {
        self.points += other.points;
        self.squares_before += other.squares_before;
        self.squares_after += other.squares_after;
        self.max_before = self.max_before.max(other.max_before);
        self.max_after = self.max_after.max(other.max_after);
        self.squares_moved += other.squares_moved;
    }
}

/// On each page the points at which seams are solved: the memory and time of that grow with them.
pub fn seam_points(world: &World, atlas: &Atlas, scope: Scope) -> Vec<u64> {
    let across = Across::default();
    let points = |page| {
        let seams = Seams::find(world, atlas, page, scope, &across);
        (seams.points.len() + seams.outer.len()) as u64
    };
    (0..atlas.page_count).map(points).collect()
}

impl Seams {
    /// The seams of the charts of a page, with each other and with those of other pages. Two borders belong together
    /// where they run along one another within a tenth of a texel, both surfaces' shading normals agree within 3
    /// degrees, and each surface lies on its own side. Where a wall stands on both, they do not: light may end there.
    pub fn find(world: &World, atlas: &Atlas, page: u32, scope: Scope, across: &Across) -> Self {
        if scope == Scope::Off {
            return Self::default();
        }
        let charts: Vec<_> = atlas.meshes.par_iter().map(atlas::charts).collect();
        let borders = border::borders(world, atlas, Some(page), &charts);
        let pairs = pair::pairs(&borders, scope);
        let walls = walls::walls(world, &charts, &borders, &pairs);
        let points = pairs.iter().zip(&walls);
        let points = points.flat_map(|(pair, walls)| pair.points(&borders, walls));
        let outer = across.of_page((world, atlas), page, scope, &charts);
        Self {
            points: points.collect(),
            outer,
            charts,
        }
    }

    /// Points where charts of the page go on in each other.
    pub fn points(&self) -> &[SeamPoint] {
        &self.points
    }

    /// True where no chart of the page goes on in another.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty() && self.outer.is_empty()
    }

    /// A system that solves planes of the page. Points at which a look-up reads texels of other charts are left out:
    /// there are none where gutters are as wide as they should be. So are points of which one side is buried: nobody
    /// sees the step, and what is seen of the other side must not give way to it. `validity` has the share of each
    /// texel that can be seen.
    pub fn system(
        &self,
        world: &World,
        raster: &PageRaster<'_>,
        size: u32,
        validity: Option<&[f32]>,
    ) -> System {
        let page = Page {
            scene: world.scene(),
            charts: &self.charts,
            raster,
            size,
            validity,
        };
        System::new(&self.points, &self.outer, &page)
    }
}
