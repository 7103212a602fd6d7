//! Numbers over the rectangle about a chart, and their local means.

use rayon::prelude::*;

/// Texels that one task takes at least.
pub(super) const TASK: usize = 4096;

/// A number for each texel of a rectangle, row by row; 0 outside the chart.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    pub width: usize,
    pub values: Vec<f32>,
}

impl Plane {
    pub fn new([width, height]: [usize; 2]) -> Self {
        Self {
            width,
            values: vec![0.0; width * height],
        }
    }

    /// Zeros over the same rectangle.
    pub fn like(other: &Self) -> Self {
        Self::new([other.width, other.height()])
    }

    pub fn height(&self) -> usize {
        self.values.len() / self.width
    }

    /// Sums of `of(index)` over the squares of `2 * radius + 1` texels about each texel, into `self`.
    pub fn set_sums(&mut self, radius: usize, of: impl Fn(usize) -> f32 + Sync) {
        let (width, height) = (self.width, self.height());
        let rows = TASK.div_ceil(width);
        self.values
            .par_chunks_mut(width * rows)
            .enumerate()
            .for_each(|(task, out)| {
                let first = task * rows;
                let last = first + out.len() / width;
                let from = first.saturating_sub(radius);
                let to = (last + radius).min(height);
                let source: Vec<f32> = (from * width..to * width).map(&of).collect();
                let mut column = vec![0.0; width + 2 * radius];
                for (y, out) in (first..last).zip(out.chunks_mut(width)) {
                    let column = &mut column;
                    column.fill(0.0);
                    let near = y.saturating_sub(radius)..(y + radius + 1).min(height);
                    for row in near {
                        let row = &source[(row - from) * width..][..width];
                        for (sum, value) in column[radius..].iter_mut().zip(row) {
                            *sum += value;
                        }
                    }
                    out.fill(0.0);
                    for shift in 0..2 * radius + 1 {
                        for (sum, value) in out.iter_mut().zip(&column[shift..]) {
                            *sum += value;
                        }
                    }
                }
            });
    }
}
