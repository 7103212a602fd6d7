//! Seams between charts of different pages.
//!
//! Pages are finished one after another, in their order, and only one of them need be in memory. So the two sides of
//! such a seam are not solved together. The page that is finished first keeps what look-ups find on its side; the later
//! one is solved to agree with that.

use super::border::{Chart, borders};
use super::pair::pairs;
use super::walls::walls;
use crate::options::Seams as Scope;
use atlas::Atlas;
use glam::DVec2;
use layers::Layer;
use rays::World;
use std::collections::BTreeMap;
use std::sync::{Mutex, OnceLock, PoisonError};

/// A point on a seam between two pages, in texels of each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AcrossPoint {
    /// The lower number first.
    pub pages: [u32; 2],
    pub sides: [DVec2; 2],
    pub charts: [Chart; 2],
    /// Texels of seam that it stands for.
    pub length: f64,
}

/// A point of [`AcrossPoint`] as one of its pages sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outer {
    /// Its number among all.
    pub number: usize,
    pub side: DVec2,
    pub chart: Chart,
    pub length: f64,
    /// The other page is finished before.
    pub later: bool,
}

/// The light of bounces or not, a term by its name, a channel.
type Plane = (bool, &'static str, usize);

/// The seams between the pages of a bake, and what was found on them.
#[derive(Debug, Default)]
pub(crate) struct Across {
    points: OnceLock<Vec<AcrossPoint>>,
    /// By term and channel, for each point what the finished page holds there; NaN before, and where a look-up would
    /// mix charts. The light of bounces is kept apart from terms.
    found: Mutex<BTreeMap<Plane, Vec<f32>>>,
}

impl Across {
    /// The points on a page.
    pub(super) fn of_page(
        &self,
        (world, atlas): (&World, &Atlas),
        page: u32,
        scope: Scope,
        charts: &[Vec<u32>],
    ) -> Vec<Outer> {
        if atlas.page_count < 2 || scope == Scope::Off {
            return Vec::new();
        }
        let points = self
            .points
            .get_or_init(|| find(world, atlas, scope, charts));
        let numbered = points.iter().enumerate();
        let outer = numbered.filter_map(|(number, point)| {
            let own = point.pages.iter().position(|&of| of == page)?;
            Some(Outer {
                number,
                side: point.sides[own],
                chart: point.charts[own],
                length: point.length,
                later: own == 1,
            })
        });
        outer.collect()
    }

    /// What finished pages hold at points, NaN where nothing is known.
    pub fn found(&self, light: bool, term: Layer, channel: usize, numbers: &[usize]) -> Vec<f64> {
        let found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        let known = found.get(&(light, term.name(), channel));
        let at = |&number: &usize| known.map_or(f64::NAN, |values| f64::from(values[number]));
        numbers.iter().map(at).collect()
    }

    /// Keeps what a finished page holds at points.
    pub fn keep(&self, light: bool, term: Layer, channel: usize, values: &[(usize, f32)]) {
        let all = self.points.get().map_or(0, Vec::len);
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        let known = found.entry((light, term.name(), channel));
        let known = known.or_insert_with(|| vec![f32::NAN; all]);
        for &(number, value) in values {
            known[number] = value;
        }
    }
}

/// All points between pages, in the order of borders.
fn find(world: &World, atlas: &Atlas, scope: Scope, charts: &[Vec<u32>]) -> Vec<AcrossPoint> {
    let borders = borders(world, atlas, None, charts);
    let mut pairs = pairs(&borders, scope);
    let page = |border: u32| borders[border as usize].page;
    pairs.retain(|pair| page(pair.borders[0]) != page(pair.borders[1]));
    let walls = walls(world, charts, &borders, &pairs);
    let mut points = Vec::new();
    for (pair, walls) in pairs.iter().zip(&walls) {
        let mut order = [0, 1];
        let pages = pair.borders.map(page);
        order.sort_by_key(|&side| pages[side]);
        points.extend(pair.points(&borders, walls).map(|point| AcrossPoint {
            pages: order.map(|side| pages[side]),
            sides: order.map(|side| point.sides[side]),
            charts: order.map(|side| point.charts[side]),
            length: point.length,
        }));
    }
    points
}
