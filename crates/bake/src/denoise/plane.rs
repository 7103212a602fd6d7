//! Numbers over the rectangle about a chart, and their local means.

use pulp::Arch;
use rayon::prelude::*;

/// Texels to each side over which local means are taken.
const RADIUS: usize = 5;

/// And over which wide ones are: three times as many in a row.
const WIDE_RADIUS: usize = 3 * RADIUS + 1;

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
        self.set_sums_by(of, RADIUS, eleven);
    }

    /// The same over 33 x 33 texels.
    pub fn set_wide_sums(&mut self, of: impl Fn(usize) -> f32 + Sync) {
        self.set_sums_by(of, WIDE_RADIUS, thirty_three);
    }

    /// The same as [`Self::set_sums`] without the 7 x 7 texels in the middle.
    pub fn set_ring_sums(&mut self, of: impl Fn(usize) -> f32 + Sync) {
        let mut middle = Self::like(self);
        middle.set_sums_by(&of, RADIUS, seven);
        self.set_sums_by(of, RADIUS, eleven);
        for (sum, middle) in self.values.iter_mut().zip(&middle.values) {
            *sum -= middle;
        }
    }

    fn set_sums_by(
        &mut self,
        of: impl Fn(usize) -> f32 + Sync,
        radius: usize,
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
                    let wide = width + 2 * radius;
                    let count = out.len() / width;
                    let mut source = vec![0.0; (count + 2 * radius) * wide];
                    for (k, line) in source.chunks_mut(wide).enumerate() {
                        let y = (task * rows + k).wrapping_sub(radius);
                        if y < height {
                            for (x, value) in line[radius..][..width].iter_mut().enumerate() {
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

/// Replaces each number by the sum of it and the 32 that follow `step` apart.
#[inline(always)]
fn thirty_three(values: &mut [f32], step: usize, spare: &mut [Vec<f32>; 2]) {
    eleven(values, step, spare);
    let part = &mut spare[0];
    part.copy_from_slice(values);
    for i in 0..values.len().saturating_sub(32 * step) {
        values[i] = part[i] + part[i + 11 * step] + part[i + 22 * step];
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_over_squares_about_each_texel() {
        let mut plane = Plane::new([50, 41]);
        // Whole numbers, whose sums are exact in any order.
        let of = |i: usize| ((i * i + 7 * i) % 23) as f32;
        let square = |[x, y]: [usize; 2], radius: usize| {
            let range =
                |at: usize, end: usize| at.saturating_sub(radius)..(at + radius + 1).min(end);
            let row = |y: usize| range(x, 50).map(|x| of(y * 50 + x)).sum::<f32>();
            range(y, 41).map(row).sum::<f32>()
        };
        let expect = |plane: &Plane, sum: &dyn Fn([usize; 2]) -> f32| {
            for (i, value) in plane.values.iter().enumerate() {
                assert_eq!(*value, sum([i % 50, i / 50]), "texel {i}");
            }
        };
        plane.set_sums(of);
        expect(&plane, &|at| square(at, 5));
        plane.set_wide_sums(of);
        expect(&plane, &|at| square(at, 16));
        plane.set_ring_sums(of);
        expect(&plane, &|at| square(at, 5) - square(at, 3));
    }
}
