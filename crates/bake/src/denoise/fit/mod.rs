//! Smooth surfaces through the texels of a chart: polynomials over overlapping windows, blended.
//!
//! Corners stand `stride` texels apart. About each of them a polynomial is fitted to the texels of a window of `2 *
//! stride` x `2 * stride`, by least squares with the weights of a tent, (1 - |u|)(1 - |v|). A texel's value is the mean
//! of its four corners' polynomials with the same weights. These add up to 1 at every texel, so there are no seams
//! between windows; and since the residuals of each fit add up to 0 under its weights, those of the blend add up to 0
//! over the chart: smoothing moves no chart's mean.
//!
//! Where a chart bends, the functions of a fit are those of the place and the *features* of its texels
//! ([`super::features`]), linearly.
//!
//! All that a fit needs are *moments*: sums over the cells between corners of t^i q^j, by the place in the cell, 0..1
//! across and down. Those of a cell follow from those of its four quarters, so texels are summed once for all strides
//! ([`moments`]). They make the normal equations of the windows, which [`equations`] solves; [`blend`] makes texels of
//! the solutions.

// Indices are those of the mathematics.
#![allow(clippy::needless_range_loop)]

mod blend;
mod equations;
mod moments;
#[cfg(test)]
mod tests;

use super::lanes::{LANES, Lanes};
use super::plane::{Sheet, rows};
use super::surface::{FEATURES, Surface};
use blend::Line;
use equations::{PLACES, solve_row};
use moments::{MASK, MomentRows, PLANE, PRODUCT, Quarters, merge, sum, times};

/// The least stride.
const LEAST: usize = 2;

/// Fits over a surface, from the least stride to wider ones.
pub(super) struct Fitter<'a> {
    surface: &'a Surface,
    stride: usize,
    /// The moments of all cells of the last stride; none of the least, whose cells are summed when they are needed.
    cells: Vec<f32>,
}

impl<'a> Fitter<'a> {
    pub fn new(surface: &'a Surface) -> Self {
        Self {
            surface,
            stride: LEAST,
            cells: Vec::new(),
        }
    }

    /// Fits windows of `stride`, which is at least the last one, by quadratic and linear polynomials, where each is
    /// wanted.
    pub fn fit(&mut self, stride: usize, out: [(bool, &mut Sheet); 2]) {
        while self.stride < stride {
            self.widen();
        }
        match self.surface.features {
            None => self.fit_by::<PLACES>(out),
            Some(_) => self.fit_by::<{ PLACES + FEATURES }>(out),
        }
    }

    /// Goes on to cells of twice the size.
    fn widen(&mut self) {
        let [_, height] = self.surface.size();
        let stride = 2 * self.stride;
        let [fine, layout] =
            [self.stride, stride].map(|stride| MomentRows::of(self.surface, stride));
        let count = height.div_ceil(stride);
        let mut cells = vec![0.0; count * layout.row()];
        rows(
            count,
            1,
            [&mut cells],
            #[inline(always)]
            |first, [cells]| {
                let mut room = [0; 2].map(|_| vec![0.0; fine.row()]);
                for (row, out) in cells.chunks_exact_mut(layout.row()).enumerate() {
                    for (k, room) in room.iter_mut().enumerate() {
                        self.sum_texels(&fine, 2 * (first + row) + k, room);
                    }
                    let quarters = self.cells([0, 1].map(|k| Some(2 * (first + row) + k)), &room);
                    merge(&fine, &layout, quarters, out);
                }
            },
        );
        (self.stride, self.cells) = (stride, cells);
    }

    /// The moments of two rows of cells, where they are not in `room`; there is none beyond the last.
    #[inline(always)]
    fn cells<'b>(&'b self, rows: [Option<usize>; 2], room: &'b [Vec<f32>; 2]) -> [&'b [f32]; 2] {
        let [mut above, mut below] = [&room[0][..], &room[1][..]];
        if self.stride > LEAST {
            let length = above.len();
            let stored = |row: usize| self.cells.get(row * length..(row + 1) * length);
            (above, below) = (
                rows[0].and_then(stored).unwrap_or(above),
                rows[1].and_then(stored).unwrap_or(below),
            );
        }
        [above, below]
    }

    /// Sums the texels of a row of cells of the least stride; nothing of wider ones, which are stored.
    #[inline(always)]
    fn sum_texels(&self, layout: &MomentRows, row: usize, out: &mut [f32]) {
        if self.stride > LEAST {
            return;
        }
        let height = self.surface.mask.height();
        let texels = |sheet: &Sheet, plane: usize, at: usize| -> Quarters {
            let below = match LEAST * row + 1 {
                y if y < height => sheet.row(plane, y),
                _ => &[],
            };
            let above = match LEAST * row {
                y if y < height => sheet.row(plane, y),
                _ => &[],
            };
            [
                Lanes::load_pairs(above, LEAST * at),
                Lanes::load_pairs(below, LEAST * at),
            ]
        };
        for at in (0..layout.cells).step_by(LANES) {
            let mask = texels(&self.surface.mask, 0, at);
            sum::<MASK>(layout, mask, 0, at, out);
            let mut features = [mask; FEATURES];
            for line in 0..layout.features + layout.planes {
                let (own, known) = match (&self.surface.features, line.checked_sub(layout.features))
                {
                    (Some(sheet), None) => {
                        features[line] = texels(sheet, line, at);
                        (times(features[line], mask), line + 1)
                    }
                    (_, plane) => {
                        let plane = texels(&self.surface.data, plane.unwrap_or(0), at);
                        (plane, layout.features)
                    }
                };
                sum::<PLANE>(layout, own, layout.line(line), at, out);
                for (number, feature) in features.iter().enumerate().take(known) {
                    let product = times(own, *feature);
                    sum::<PRODUCT>(layout, product, layout.product(line, number), at, out);
                }
            }
        }
    }

    fn fit_by<const N: usize>(&self, out: [(bool, &mut Sheet); 2]) {
        let [width, height] = self.surface.size();
        let stride = self.stride;
        let layout = MomentRows::of(self.surface, stride);
        let planes = layout.planes;
        let wanted = out.each_ref().map(|(is_wanted, _)| *is_wanted);
        let out = out.map(|(is_wanted, sheet)| match is_wanted {
            true => &mut sheet.values[..],
            false => &mut [],
        });
        rows(
            height,
            stride,
            out,
            #[inline(always)]
            |first, mut out| {
                let of_row = planes * width;
                let count = out.iter().map(|out| out.len()).max().unwrap_or(0) / of_row;
                let mut room = [0; 2].map(|_| vec![0.0; layout.row()]);
                let corners = 2 * planes * N * layout.room;
                let [mut upper, mut lower] = [0, 1].map(|_| vec![0.0; corners]);
                let mut line = Line::<N>::new(&layout, width);
                // The cells above the first row, those of it, and so on; from the second on the corners above them,
                // then texels.
                for step in 0..count.div_ceil(stride) + 2 {
                    let row = first / stride + step;
                    room.swap(0, 1);
                    match row.checked_sub(1) {
                        Some(row) => self.sum_texels(&layout, row, &mut room[1]),
                        None => room[1].fill(0.0),
                    }
                    if step == 0 {
                        continue;
                    }
                    std::mem::swap(&mut upper, &mut lower);
                    let cells = self.cells([row.checked_sub(2), Some(row - 1)], &room);
                    solve_row::<N>(&layout, cells, wanted, &mut lower);
                    let Some(start) = step.checked_sub(2).map(|cell| cell * stride) else {
                        continue;
                    };
                    for y in start..(start + stride).min(count) {
                        let q = (y - start) as f32 + 0.5;
                        for (degree, out) in out.iter_mut().enumerate() {
                            let out = out.get_mut(y * of_row..(y + 1) * of_row);
                            let lines = out.into_iter().flat_map(|out| out.chunks_mut(width));
                            for (plane, values) in lines.enumerate() {
                                let at = (degree * planes + plane) * N * layout.room;
                                let corners =
                                    [&upper, &lower].map(|row| &row[at..at + N * layout.room]);
                                line.blend(&layout, degree, corners, q / stride as f32);
                                line.write(self.surface, first + y, stride, values);
                            }
                        }
                    }
                }
            },
        );
    }
}
