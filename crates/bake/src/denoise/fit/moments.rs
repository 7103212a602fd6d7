//! Moments of the texels of cells: how rows of them are laid out, and how those of a cell follow from its quarters.

use crate::denoise::lanes::{LANES, Lanes};
use crate::denoise::surface::Surface;

/// Powers across and down of which a cell has the moments: of the mask, of a plane, and of the product of two.
pub(super) const MASK: usize = 6;
pub(super) const PLANE: usize = 4;
pub(super) const PRODUCT: usize = 2;

pub(super) const BINOMIAL: [[f32; MASK]; MASK] = [
    [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 2.0, 1.0, 0.0, 0.0, 0.0],
    [1.0, 3.0, 3.0, 1.0, 0.0, 0.0],
    [1.0, 4.0, 6.0, 4.0, 1.0, 0.0],
    [1.0, 5.0, 10.0, 10.0, 5.0, 1.0],
];

/// Powers of the middles of two halves of a cell.
const NEAR: [f32; MASK] = powers(0.25);
const FAR: [f32; MASK] = powers(0.75);
const HALF: [f32; MASK] = powers(0.5);

const fn powers(of: f32) -> [f32; MASK] {
    let mut powers = [1.0; MASK];
    let mut i = 1;
    while i < MASK {
        powers[i] = powers[i - 1] * of;
        i += 1;
    }
    powers
}

/// How a row of cells is laid out: moment by moment, each with a cell without texels at both ends.
#[derive(Clone, Copy)]
pub(super) struct MomentRows {
    pub features: usize,
    pub planes: usize,
    pub cells: usize,
    /// Numbers of a moment's row.
    pub room: usize,
}

impl MomentRows {
    pub fn of(surface: &Surface, stride: usize) -> Self {
        let cells = surface.mask.width.div_ceil(stride);
        Self {
            features: surface.features.as_ref().map_or(0, |sheet| sheet.planes),
            planes: surface.data.planes,
            cells,
            room: (cells + 2).next_multiple_of(LANES) + LANES,
        }
    }

    /// The first moment of a feature's or a plane's.
    #[inline(always)]
    pub fn line(&self, line: usize) -> usize {
        MASK * MASK + line * PLANE * PLANE
    }

    /// The first moment of the product of a line with a feature not after it.
    #[inline(always)]
    pub fn product(&self, line: usize, feature: usize) -> usize {
        let before = match line.checked_sub(self.features) {
            None => line * (line + 1) / 2,
            Some(plane) => self.features * (self.features + 1) / 2 + plane * self.features,
        };
        self.line(self.features + self.planes) + (before + feature) * PRODUCT * PRODUCT
    }

    pub fn moments(&self) -> usize {
        self.product(self.features + self.planes, 0)
    }

    /// Numbers of a row of cells.
    pub fn row(&self) -> usize {
        self.moments() * self.room
    }

    /// Lanes of a moment from the cell before cell `at` on.
    #[inline(always)]
    pub fn load(&self, row: &[f32], moment: usize, at: usize) -> Lanes {
        Lanes::load(row, moment * self.room + at)
    }

    #[inline(always)]
    fn store(&self, row: &mut [f32], moment: usize, cell: usize, lanes: Lanes) {
        lanes.store(row, moment * self.room + 1 + cell);
    }
}

/// Numbers of the four quarters of cells: down, then across.
pub(super) type Quarters = [[Lanes; 2]; 2];

#[inline(always)]
pub(super) fn times(mut a: Quarters, b: Quarters) -> Quarters {
    for j in 0..2 {
        for i in 0..2 {
            a[j][i] = a[j][i] * b[j][i];
        }
    }
    a
}

/// The moments of N powers of cells whose quarters are single texels.
#[inline(always)]
pub(super) fn sum<const N: usize>(
    layout: &MomentRows,
    of: Quarters,
    moment: usize,
    at: usize,
    out: &mut [f32],
) {
    for j in 0..N {
        let left = of[0][0] * NEAR[j] + of[1][0] * FAR[j];
        let right = of[0][1] * NEAR[j] + of[1][1] * FAR[j];
        for i in 0..N {
            let sum = left * NEAR[i] + right * FAR[i];
            layout.store(out, moment + j * N + i, at, sum);
        }
    }
}

/// The moments of a row of cells from those of two rows of their quarters.
#[inline(always)]
pub(super) fn merge(
    fine: &MomentRows,
    layout: &MomentRows,
    quarters: [&[f32]; 2],
    out: &mut [f32],
) {
    let lines = layout.features + layout.planes;
    for at in (0..layout.cells).step_by(LANES) {
        merge_line::<MASK>(fine, layout, quarters, 0, at, out);
        for line in 0..lines {
            merge_line::<PLANE>(fine, layout, quarters, layout.line(line), at, out);
        }
        let products = layout.product(0, 0)..layout.moments();
        for moment in products.step_by(PRODUCT * PRODUCT) {
            merge_line::<PRODUCT>(fine, layout, quarters, moment, at, out);
        }
    }
}

#[inline(always)]
fn merge_line<const N: usize>(
    fine: &MomentRows,
    layout: &MomentRows,
    quarters: [&[f32]; 2],
    moment: usize,
    at: usize,
    out: &mut [f32],
) {
    // A place of a quarter is half as far from its beginning, and the second begins in the middle.
    let mut halves = [[[Lanes::ZERO; N]; N]; 2];
    for (quarters, halves) in quarters.into_iter().zip(&mut halves) {
        for (j, half) in halves.iter_mut().enumerate() {
            let mut pairs = [[Lanes::ZERO; N]; 2];
            for i in 0..N {
                let row = &quarters[(moment + j * N + i) * fine.room..][..fine.room];
                let [left, right] = Lanes::load_pairs(row, 1 + 2 * at);
                (pairs[0][i], pairs[1][i]) = (left, right);
            }
            for (i, half) in half.iter_mut().enumerate() {
                *half = joined(i, pairs[0][i], &pairs[1]);
            }
        }
    }
    for i in 0..N {
        let mut below = [Lanes::ZERO; N];
        for (below, half) in below.iter_mut().zip(&halves[1]) {
            *below = half[i];
        }
        for j in 0..N {
            let sum = joined(j, halves[0][j][i], &below);
            layout.store(out, moment + j * N + i, at, sum);
        }
    }
}

#[inline(always)]
fn joined(power: usize, first: Lanes, second: &[Lanes]) -> Lanes {
    let mut sum = first;
    for (second, times) in second.iter().zip(BINOMIAL[power]).take(power + 1) {
        sum += *second * times;
    }
    sum * HALF[power]
}
