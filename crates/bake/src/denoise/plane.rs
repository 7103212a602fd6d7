//! Numbers over the rectangle about a chart, and their local means.

use pulp::Arch;
use rayon::prelude::*;

/// Texels to each side over which local means are taken.
const RADIUS: usize = 5;

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

    /// Sums of `of(index)` over the square of 11 x 11 texels about each texel, into `self`. Every sum has the same order, whatever the
    /// number of threads.
    pub fn set_sums(&mut self, of: impl Fn(usize) -> f32 + Sync) {
        self.set_sums_by(of, eleven);
    }

    /// The same without the 7 x 7 texels in the middle.
    pub fn set_ring_sums(&mut self, of: impl Fn(usize) -> f32 + Sync) {
        let mut middle = Self::like(self);
        middle.set_sums_by(&of, seven);
        self.set_sums_by(of, eleven);
        for (sum, middle) in self.values.iter_mut().zip(&middle.values) {
            *sum -= middle;
        }
    }

    fn set_sums_by(
        &mut self,
        of: impl Fn(usize) -> f32 + Sync,
        line: impl Fn(&mut [f32], usize, &mut [Vec<f32>; 2]) + Sync,
    ) {
        let (width, height) = (self.width, self.height());
        let rows = TASK.div_ceil(width);
        let tasks = self.values.par_chunks_mut(width * rows).enumerate();
        tasks.for_each(|(task, out)| {
            Arch::new().dispatch(
                #[inline(always)]
                || {
                    // With a border of zeros, or of what lies above and below.
                    let wide = width + 2 * RADIUS;
                    let count = out.len() / width;
                    let mut source = vec![0.0; (count + 2 * RADIUS) * wide];
                    for (k, line) in source.chunks_mut(wide).enumerate() {
                        let y = (task * rows + k).wrapping_sub(RADIUS);
                        if y < height {
                            for (x, value) in line[RADIUS..][..width].iter_mut().enumerate() {
                                *value = of(y * width + x);
                            }
                        }
                    }
                    let mut spare = [source.clone(), source.clone()];
                    line(&mut source, wide, &mut spare);
                    line(&mut source, 1, &mut spare);
                    for (out, line) in out.chunks_mut(width).zip(source.chunks(wide)) {
                        out.copy_from_slice(&line[..width]);
                    }
                },
            );
        });
    }
}

/// Replaces each number by the sum of it and the ten that follow `step` apart; those without ten followers are left undefined.
#[inline(always)]
fn eleven(values: &mut [f32], step: usize, [two, eight]: &mut [Vec<f32>; 2]) {
    #[inline(always)]
    fn add(out: &mut [f32], a: &[f32], b: &[f32]) {
        for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
            *out = a + b;
        }
    }
    add(two, values, &values[step..]);
    add(eight, two, &two[2 * step..]);
    for i in 0..eight.len().saturating_sub(4 * step) {
        eight[i] += eight[i + 4 * step];
    }
    for i in 0..values.len().saturating_sub(10 * step) {
        values[i] = eight[i] + (two[i + 8 * step] + values[i + 10 * step]);
    }
}

/// Replaces each number by the sum of the seven in the middle of it and the ten that follow `step` apart.
#[inline(always)]
fn seven(values: &mut [f32], step: usize, [two, _]: &mut [Vec<f32>; 2]) {
    for (out, (a, b)) in two.iter_mut().zip(values.iter().zip(&values[step..])) {
        *out = a + b;
    }
    for i in 0..values.len().saturating_sub(10 * step) {
        values[i] =
            (two[i + 2 * step] + two[i + 4 * step]) + (two[i + 6 * step] + values[i + 8 * step]);
    }
}
