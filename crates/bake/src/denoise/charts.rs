//! Which texels of a page belong to one surface, side by side.
//!
//! Two texels side by side are *linked* when nothing suggests that their surfaces differ: both have data, they belong
//! to one object, their normals turn by less than a crease, and they are as near in space as their neighbours. Texels
//! that a chain of links joins are one chart, kept as runs of texels in rows. Charts are what the denoiser works on;
//! what goes on in other charts is [`super::beyond`]'s matter.

use super::choose::{ALIGNED, REACH};
use super::field::Field;
use super::lanes::LANES;
use super::plane::TASK;
use rayon::prelude::*;
use scene::Sets;
use std::ops::Range;

/// Cosine of the turn of the normal between neighbours that counts as a crease: 20 degrees.
const CREASE: f32 = 0.939_692_6;

/// Neighbours farther apart than this many times the steps beside theirs lie on different surfaces.
const JUMP: f32 = 3.0;

/// Texels side by side in a row of the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    /// The first of them.
    pub first: u32,
    pub count: u32,
}

impl Run {
    /// Its texels, by their number on the page.
    pub fn texels(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// A chart: its texels in the order of the page, and the rectangle about them.
#[derive(Debug)]
pub(super) struct Chart {
    pub runs: Vec<Run>,
    /// The number of its texels.
    pub texels: usize,
    pub area: Area,
}

/// The charts of a page.
#[derive(Debug)]
pub(super) struct Charts {
    /// In the order of their first texels.
    pub charts: Vec<Chart>,
    /// The number of the chart of each texel; [`NONE`] where there is no data.
    pub number: Vec<u32>,
}

/// No chart.
pub(super) const NONE: u32 = u32::MAX;

/// A rectangle of texels, which may reach beyond the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    /// First column and row.
    pub at: [i32; 2],
    /// Columns and rows.
    pub size: [usize; 2],
}

/// Rows of a chart that are fitted together.
#[derive(Debug, Clone)]
pub(super) struct Band {
    pub rows: Range<usize>,
    /// These and all that they are fitted to.
    pub about: Range<usize>,
}

impl Chart {
    /// The texels in some of the rows of an area, on a page of this size.
    pub fn runs_of(&self, area: &Area, rows: &Range<usize>, page: usize) -> &[Run] {
        let before = |row: usize| {
            let first = (i64::from(area.at[1]) + row as i64) * page as i64;
            self.runs
                .partition_point(|run| i64::from(run.first) < first)
        };
        &self.runs[before(rows.start)..before(rows.end)]
    }

    /// All its texels, by their number on the page.
    pub fn all(&self) -> impl Iterator<Item = usize> + '_ {
        self.runs.iter().flat_map(Run::texels)
    }
}

impl Area {
    /// The least one about these places, columns and rows; there is one at least.
    fn about(places: impl Iterator<Item = [i32; 2]>) -> Self {
        let (mut low, mut high) = ([i32::MAX; 2], [i32::MIN; 2]);
        for place in places {
            for k in 0..2 {
                low[k] = low[k].min(place[k]);
                high[k] = high[k].max(place[k]);
            }
        }
        let size = [0, 1].map(|k| (high[k] - low[k]) as usize + 1);
        Self { at: low, size }
    }

    /// The least one about it and these places.
    pub fn with(&self, places: impl Iterator<Item = [i32; 2]>) -> Self {
        let last = [0, 1].map(|k| self.at[k] + self.size[k] as i32 - 1);
        Self::about(places.chain([self.at, last]))
    }

    /// The same in columns that fill whole lanes.
    pub fn in_lanes(mut self) -> Self {
        self.size[0] = self.size[0].next_multiple_of(LANES);
        self
    }

    /// Bands of about so many texels from top to bottom. Where they begin changes no texel's fits.
    pub fn bands(&self, texels: usize) -> Vec<Band> {
        let [width, height] = self.size;
        let rows = match width * height <= texels {
            true => height,
            false => (texels / width).max(1).next_multiple_of(ALIGNED),
        };
        let starts = (0..height).step_by(rows);
        let band = |start: usize| Band {
            rows: start..(start + rows).min(height),
            about: start.saturating_sub(REACH)..(start + rows + REACH).min(height),
        };
        starts.map(band).collect()
    }

    /// The column and the row, counted from the first of some rows, of a texel of the page.
    pub fn local(&self, texel: u32, rows: &Range<usize>, page: usize) -> [usize; 2] {
        let page = page as u32;
        self.local_at([texel % page, texel / page].map(|place| place as i32), rows)
    }

    /// The same of a column and row.
    pub fn local_at(&self, place: [i32; 2], rows: &Range<usize>) -> [usize; 2] {
        let [x, y] = [0, 1].map(|k| (place[k] - self.at[k]) as usize);
        [x, y - rows.start]
    }
}

/// The charts of a page.
pub(super) fn charts(field: &Field<'_>) -> Charts {
    let size = field.size;
    let each = |of: &(dyn Fn(usize, usize) -> [f32; 2] + Sync)| {
        let mut numbers = vec![[0.0; 2]; size * size];
        let rows = numbers
            .par_chunks_mut(size)
            .with_min_len(TASK.div_ceil(size));
        rows.enumerate().for_each(|(y, row)| {
            row.iter_mut()
                .enumerate()
                .for_each(|(x, numbers)| *numbers = of(x, y));
        });
        numbers
    };
    let ways = [1, size];
    let beside = |x: usize, y: usize| [x + 1 < size, y + 1 < size];
    // To the texel on the right, and to that below.
    let steps = each(&|x, y| {
        let (a, has_next) = (y * size + x, beside(x, y));
        [0, 1].map(|k| match has_next[k] {
            true => step(field, a, a + ways[k]),
            false => f32::INFINITY,
        })
    });
    let is_linked = |x: usize, y: usize, k: usize| {
        let a = y * size + x;
        let own = steps[a][k];
        let b = if own < f32::INFINITY {
            a + ways[k]
        } else {
            return false;
        };
        let before = |texel: usize, at: usize, k: usize| match at {
            0 => f32::INFINITY,
            _ => steps[texel - ways[k]][k],
        };
        // The shorter of the steps that go on with it on either side; where both lead into void, the shortest across.
        let [along, across] = if k == 0 { [x, y] } else { [y, x] };
        let mut usual = before(a, along, k).min(steps[b][k]);
        if usual == f32::INFINITY {
            let k = 1 - k;
            let sides = [a, b].map(|texel| before(texel, across, k).min(steps[texel][k]));
            usual = sides[0].min(sides[1]);
        }
        own <= JUMP * JUMP * usual && field.normal(a).dot(field.normal(b)) >= CREASE
    };
    // Runs first, then runs of neighbouring rows joined: the lower number is the root.
    let mut runs: Vec<Run> = Vec::new();
    let mut number = vec![NONE; size * size];
    let mut sets = Sets::default();
    for texel in (0..size * size).filter(|&texel| field.has_data(texel)) {
        let (x, y) = (texel % size, texel / size);
        match runs.last_mut().filter(|_| x > 0 && is_linked(x - 1, y, 0)) {
            Some(run) => run.count += 1,
            None => {
                sets.push();
                runs.push(Run {
                    first: texel as u32,
                    count: 1,
                });
            }
        }
        number[texel] = runs.len() as u32 - 1;
        if y > 0 && is_linked(x, y - 1, 1) {
            sets.join(number[texel - size], number[texel]);
        }
    }
    let mut charts: Vec<Vec<Run>> = Vec::new();
    let mut of_run = vec![NONE; runs.len()];
    for (k, run) in runs.into_iter().enumerate() {
        let root = sets.root(k as u32) as usize;
        if root == k {
            of_run[k] = charts.len() as u32;
            charts.push(Vec::new());
        }
        of_run[k] = of_run[root];
        charts[of_run[k] as usize].push(run);
    }
    number.par_iter_mut().with_min_len(TASK).for_each(|number| {
        if *number != NONE {
            *number = of_run[*number as usize];
        }
    });
    let chart = |mut runs: Vec<Run>| {
        runs.shrink_to_fit();
        let place =
            |texel: u32| [texel % size as u32, texel / size as u32].map(|place| place as i32);
        let ends = runs
            .iter()
            .flat_map(|run| [run.first, run.first + run.count - 1]);
        let area = Area::about(ends.map(place));
        let texels = runs.iter().map(|run| run.count as usize).sum();
        Chart { runs, texels, area }
    };
    Charts {
        charts: charts.into_iter().map(chart).collect(),
        number,
    }
}

/// The squared distance of two texels with data of one object; infinite for others.
fn step(field: &Field<'_>, a: usize, b: usize) -> f32 {
    match field.has_data(a) && field.has_data(b) && field.object[a] == field.object[b] {
        true => field.position(a).distance_squared(field.position(b)),
        false => f32::INFINITY,
    }
}
