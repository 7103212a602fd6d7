//! Which cell of its texel a point chooses, sixteen lanes at once.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use crate::survey::Cells;
use ambient::sampling::{LANES, Wide};
use std::hint::black_box;

/// Pieces of a lane at most that are looked through beside those of others; among more one is found by halves.
const MOST: usize = 24;

/// Weights of the second and third corner of a triangle at the origin of the unit square, and their change along its
/// edges.
type Weights = [[Wide; 2]; 3];

/// What a triangle has everywhere that holds no point.
const NOWHERE: Weights = [
    [[f32::NEG_INFINITY; LANES]; 2],
    [[0.0; LANES]; 2],
    [[0.0; LANES]; 2],
];

/// Where the cells under each lane lie in the unit square.
///
/// Looking through the few cells of sixteen texels in step takes a fraction of what sixteen searches take.
#[derive(Clone)]
pub(super) struct Borders<'a> {
    /// The ends of each lane's cells but the last along the first coordinate of a point, in their order. Lanes with
    /// fewer hold a number that no point reaches.
    ends: Vec<Wide>,
    /// Of lanes whose texels several triangles cover wholly, these triangles.
    spans: Vec<Weights>,
    /// Such lanes.
    spanned: u32,
    /// Lanes with more pieces.
    long: Vec<(usize, &'a Cells)>,
}

impl<'a> Borders<'a> {
    /// One cell under each lane.
    pub fn none() -> Self {
        Self {
            ends: Vec::new(),
            spans: Vec::new(),
            spanned: 0,
            long: Vec::new(),
        }
    }

    /// Goes back to one cell under each lane.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.spans.clear();
        self.spanned = 0;
        self.long.clear();
    }

    /// Takes the cells under a lane.
    pub fn set(&mut self, lane: usize, cells: &'a Cells) {
        match cells.len() {
            0 | 1 => {}
            count if cells.are_whole() => {
                self.spanned |= 1 << lane;
                self.spans.resize(self.spans.len().max(count), NOWHERE);
                for (number, row) in self.spans.iter_mut().enumerate().take(count) {
                    for (row, weights) in row.iter_mut().zip(cells.weights(number)) {
                        (row[0][lane], row[1][lane]) = (weights[0], weights[1]);
                    }
                }
            }
            count if count > MOST => self.long.push((lane, cells)),
            _ => {
                let ends = cells.ends();
                let rows = self.ends.len().max(ends.len());
                self.ends.resize(rows, [f32::INFINITY; LANES]);
                for (row, end) in self.ends.iter_mut().zip(ends) {
                    row[lane] = end;
                }
            }
        }
    }

    /// True where a lane has several cells.
    pub fn any(&self) -> bool {
        !(self.ends.is_empty() && self.spans.is_empty() && self.long.is_empty())
    }

    /// The cell of each lane that its point chooses.
    #[inline(always)]
    pub fn cells(&self, v0: &Wide, v1: &Wide) -> [u32; LANES] {
        let mut cells = [0; LANES];
        for k in 0..self.ends.len() {
            // Left alone, the compiler takes many rows of one lane at a time, number by number.
            let ends = &self.ends[black_box(k)];
            for l in 0..LANES {
                cells[l] += u32::from(v0[l] >= ends[l]);
            }
        }
        if !self.spans.is_empty() {
            let spanned = self.holding(v0, v1);
            for l in 0..LANES {
                let is_spanned = self.spanned >> l & 1 == 1;
                cells[l] = if is_spanned { spanned[l] } else { cells[l] };
            }
        }
        for (l, of) in &self.long {
            cells[*l] = of.place([v0[*l], v1[*l]]).0 as u32;
        }
        cells
    }

    /// The triangle of each lane whose least weight is the largest.
    #[inline(always)]
    fn holding(&self, v0: &Wide, v1: &Wide) -> [u32; LANES] {
        let (mut best, mut chosen) = ([f32::NEG_INFINITY; LANES], [0; LANES]);
        for k in 0..self.spans.len() {
            let [a, b, c] = &self.spans[black_box(k)];
            for l in 0..LANES {
                let s = a[0][l] + b[0][l] * v0[l] + c[0][l] * v1[l];
                let t = a[1][l] + b[1][l] * v0[l] + c[1][l] * v1[l];
                let lesser = if t < s { t } else { s };
                let first = 1.0 - s - t;
                let least = if first < lesser { first } else { lesser };
                let is_better = least > best[l];
                best[l] = if is_better { least } else { best[l] };
                chosen[l] = if is_better { k as u32 } else { chosen[l] };
            }
        }
        chosen
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::survey::fixture;
    use atlas::MOST_HELD;
    use glam::DVec2;

    #[test]
    fn a_point_chooses_the_cell_before_whose_end_it_lies() {
        let (few, many) = (fixture::slices(4), fixture::slices(100));
        let mut borders = Borders::none();
        assert!(!borders.any());
        borders.set(3, &few);
        borders.set(9, &many);
        assert!(borders.any());
        let chosen = |u: f32| {
            let cells = borders.cells(&[u; LANES], &[0.5; LANES]);
            (cells[0], cells[3], cells[9])
        };
        assert_eq!(chosen(0.201), (0, 0, 20));
        assert_eq!(chosen(0.2501), (0, 1, 25));
        assert_eq!(chosen(0.999), (0, 3, 99));
        borders.clear();
        assert_eq!(borders.cells(&[0.999; LANES], &[0.5; LANES]), [0; LANES]);
    }

    #[test]
    fn lanes_of_whole_texels_choose_as_their_cells_do() {
        // Fans of triangles about a point amid a texel, each of which is the fixture's triangle elsewhere on the page.
        let fan = |count: u32| {
            let corner = move |k: u32| {
                let turn = f64::from(k) / f64::from(count) * std::f64::consts::TAU;
                DVec2::new(0.53 + 0.9 * turn.cos(), 0.46 + 0.9 * turn.sin())
            };
            let place = |k: u32| {
                let o = DVec2::new(0.53, 0.46);
                let (a, b) = (corner(k) - o, corner(k + 1) - o);
                move |x: f64, y: f64| {
                    let p = DVec2::new(x, y) - o;
                    [p.perp_dot(b), a.perp_dot(p)].map(|area| area / a.perp_dot(b))
                }
            };
            let places: Vec<_> = (0..count).map(place).collect();
            let patch = || fixture::patch([[0.0, 0.0, 1.0]; 3]);
            let triangles: Vec<fixture::Placed> =
                places.iter().map(|place| (patch(), place as _)).collect();
            fixture::whole(&triangles, ([0.0; 2], 1.0))
        };
        let (few, many) = (fan(5), fan(MOST_HELD as u32));
        let mut borders = Borders::none();
        borders.set(2, &few);
        borders.set(7, &many);
        borders.set(8, &few);
        for k in 0..400 {
            let [u, v] = [k % 20, k / 20].map(|k| (k as f32 + 0.37) / 20.0);
            let cells = borders.cells(&[u; LANES], &[v; LANES]);
            let expected = [&few, &many].map(|cells| cells.place([u, v]).0 as u32);
            assert_eq!(
                [cells[2], cells[7], cells[8], cells[0]],
                [expected[0], expected[1], expected[0], 0]
            );
        }
    }
}
