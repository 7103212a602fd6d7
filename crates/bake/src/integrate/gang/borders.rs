//! Which cell of its texel a point chooses, sixteen lanes at once.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use ambient::sampling::{LANES, Wide};
use std::hint::black_box;

/// Ends of a lane at most that are looked through; more are searched by halves.
const MOST: usize = 24;

/// Where the cells under each lane end along the first coordinate of a point.
///
/// Looking through the few ends of sixteen texels in step takes a fraction of what sixteen searches take.
#[derive(Clone)]
pub(super) struct Borders {
    /// The ends of each lane's cells but the last, in their order. Lanes with fewer hold a number that no point reaches.
    rows: [Wide; MOST],
    /// Rows in use.
    used: usize,
    /// The ends of lanes with more.
    long: Vec<(usize, Vec<f32>)>,
}

impl Borders {
    /// One cell under each lane.
    pub fn none() -> Self {
        Self {
            rows: [[f32::INFINITY; LANES]; MOST],
            used: 0,
            long: Vec::new(),
        }
    }

    /// Goes back to one cell under each lane.
    pub fn clear(&mut self) {
        self.rows[..self.used].fill([f32::INFINITY; LANES]);
        self.used = 0;
        self.long.clear();
    }

    /// Takes the ends of the cells under a lane.
    pub fn set(&mut self, lane: usize, ends: impl ExactSizeIterator<Item = f32>) {
        if ends.len() > MOST {
            self.long.push((lane, ends.collect()));
            return;
        }
        self.used = self.used.max(ends.len());
        for (row, end) in self.rows.iter_mut().zip(ends) {
            row[lane] = end;
        }
    }

    /// True where a lane has several cells.
    pub fn any(&self) -> bool {
        self.used > 0 || !self.long.is_empty()
    }

    /// The cell of each lane that its point chooses.
    #[inline(always)]
    pub fn cells(&self, v0: &Wide) -> [u32; LANES] {
        let mut cells = [0; LANES];
        for k in 0..self.used {
            // Left alone, the compiler takes many rows of one lane at a time, number by number.
            let ends = &self.rows[black_box(k)];
            for l in 0..LANES {
                cells[l] += u32::from(v0[l] >= ends[l]);
            }
        }
        for (l, ends) in &self.long {
            cells[*l] = ends.partition_point(|end| v0[*l] >= *end) as u32;
        }
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_chooses_the_cell_before_whose_end_it_lies() {
        let few = [0.25, 0.25, 0.5];
        let many = (1..100).map(|k| k as f32 / 100.0);
        let mut borders = Borders::none();
        assert!(!borders.any());
        borders.set(3, few.into_iter());
        borders.set(9, many);
        assert!(borders.any());
        let chosen = |u: f32| {
            let cells = borders.cells(&[u; LANES]);
            (cells[0], cells[3], cells[9])
        };
        assert_eq!(chosen(0.2), (0, 0, 20));
        assert_eq!(chosen(0.25), (0, 2, 25));
        assert_eq!(chosen(0.999), (0, 3, 99));
        borders.clear();
        assert_eq!(borders.cells(&[0.999; LANES]), [0; LANES]);
    }
}
