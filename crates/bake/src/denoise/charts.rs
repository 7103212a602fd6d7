//! Which texels of a page belong to one surface, side by side.
//!
//! Two texels side by side are *linked* when nothing suggests that their surfaces differ: both have data, they belong to one
//! object, their normals turn by less than a crease, and they are as near in space as their neighbours. Texels that a chain of
//! links joins are one chart. Charts are what the denoiser works on; what goes on in other charts is [`super::beyond`]'s matter.

use super::choose::{ALIGNED, REACH};
use super::field::Field;
use super::plane::TASK;
use rayon::prelude::*;
use std::ops::Range;

/// Cosine of the turn of the normal between neighbours that counts as a crease: 20 degrees.
const CREASE: f64 = 0.939_692_620_785_908_4;

/// Neighbours farther apart than this many times the steps beside theirs lie on different surfaces.
const JUMP: f64 = 3.0;

/// A chart: its texels in the order of the page, and the rectangle about them.
#[derive(Debug)]
pub(super) struct Chart {
    pub texels: Vec<u32>,
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

impl Band {
    /// Its rows, counted from the first of those about them.
    pub fn inner(&self) -> Range<usize> {
        self.rows.start - self.about.start..self.rows.end - self.about.start
    }
}

impl Chart {
    /// The texels of some of the rows of an area, on a page of this size.
    pub fn texels_of(&self, area: &Area, rows: &Range<usize>, page: usize) -> &[u32] {
        let before = |row: usize| {
            let first = (i64::from(area.at[1]) + row as i64) * page as i64;
            self.texels
                .partition_point(|&texel| i64::from(texel) < first)
        };
        &self.texels[before(rows.start)..before(rows.end)]
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

    /// The place of a texel of the page in a plane over some of the rows.
    pub fn local(&self, texel: u32, rows: &Range<usize>, page: usize) -> usize {
        let place = [texel as usize % page, texel as usize / page];
        self.local_at(place.map(|place| place as i32), rows)
    }

    /// The same of a column and row.
    pub fn local_at(&self, place: [i32; 2], rows: &Range<usize>) -> usize {
        let [x, y] = [0, 1].map(|k| (place[k] - self.at[k]) as usize);
        (y - rows.start) * self.size[0] + x
    }
}

/// The charts of a page.
pub(super) fn charts(field: &Field<'_>) -> Charts {
    const RIGHT: u8 = 1;
    const DOWN: u8 = 2;
    let size = field.size;
    let mut bits = vec![0u8; size * size];
    let rows = bits.par_chunks_mut(size).with_min_len(TASK.div_ceil(size));
    rows.enumerate().for_each(|(y, row)| {
        for (x, bits) in row.iter_mut().enumerate() {
            let texel = y * size + x;
            if x + 1 < size && linked(field, texel, texel + 1) {
                *bits |= RIGHT;
            }
            if y + 1 < size && linked(field, texel, texel + size) {
                *bits |= DOWN;
            }
        }
    });
    // Union-find; the lower index is the root, so a root comes before its texels.
    let mut parent: Vec<u32> = (0..size as u32 * size as u32).collect();
    for (texel, &bits) in bits.iter().enumerate() {
        if bits & RIGHT != 0 {
            join(&mut parent, texel, texel + 1);
        }
        if bits & DOWN != 0 {
            join(&mut parent, texel, texel + size);
        }
    }
    let mut texels: Vec<Vec<u32>> = Vec::new();
    let mut number = vec![NONE; size * size];
    for texel in (0..size * size).filter(|&texel| field.has_data(texel)) {
        let root = root(&mut parent, texel);
        if root == texel {
            number[texel] = texels.len() as u32;
            texels.push(Vec::new());
        }
        number[texel] = number[root];
        texels[number[root] as usize].push(texel as u32);
    }
    let chart = |mut texels: Vec<u32>| {
        texels.shrink_to_fit();
        let place = |&texel: &u32| [texel % size as u32, texel / size as u32];
        let area = Area::about(texels.iter().map(|t| place(t).map(|place| place as i32)));
        Chart { texels, area }
    };
    Charts {
        charts: texels.into_iter().map(chart).collect(),
        number,
    }
}

fn root(parent: &mut [u32], texel: usize) -> usize {
    let mut at = texel;
    while parent[at] as usize != at {
        parent[at] = parent[parent[at] as usize];
        at = parent[at] as usize;
    }
    at
}

fn join(parent: &mut [u32], a: usize, b: usize) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b)] = a.min(b) as u32;
}

fn linked(field: &Field<'_>, a: usize, b: usize) -> bool {
    if !(field.has_data(a) && field.has_data(b)) || field.object[a] != field.object[b] {
        return false;
    }
    if field.normal(a).dot(field.normal(b)) < CREASE {
        return false;
    }
    let step = field.position(a).distance(field.position(b));
    step <= JUMP * usual_step(field, a, b)
}

/// The shorter of the steps that continue the step from `a` to `b` on either side; where both lead into void, the
/// shortest step across it.
fn usual_step(field: &Field<'_>, a: usize, b: usize) -> f64 {
    let size = field.size;
    let (along, across) = if b - a == 1 { (1, size) } else { (size, 1) };
    let step = |from: usize, stride: usize, forward: bool| -> f64 {
        let room = if stride == 1 {
            from % size
        } else {
            from / size
        };
        let to = match forward {
            true if room + 1 < size => from + stride,
            false if room > 0 => from - stride,
            _ => return f64::INFINITY,
        };
        if field.has_data(to) && field.object[to] == field.object[from] {
            field.position(from).distance(field.position(to))
        } else {
            f64::INFINITY
        }
    };
    let usual = step(a, along, false).min(step(b, along, true));
    if usual.is_finite() {
        return usual;
    }
    [(a, false), (a, true), (b, false), (b, true)]
        .into_iter()
        .map(|(from, forward)| step(from, across, forward))
        .fold(f64::INFINITY, f64::min)
}
