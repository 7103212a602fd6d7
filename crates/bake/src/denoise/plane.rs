//! Numbers over the rectangle about a chart, row by row, and their local sums.

use pulp::Arch;
use rayon::join;
use std::mem::take;

/// Texels to each side over which local sums are taken.
const RADIUS: usize = 5;
/// In a row.
const ELEVEN: usize = 2 * RADIUS + 1;

/// Numbers that one task takes at least.
pub(super) const TASK: usize = 4096;

/// Some numbers for each texel of a rectangle, 0 outside the chart. Each row has the rows of all planes, one after the
/// other.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    pub width: usize,
    pub planes: usize,
    pub values: Vec<f32>,
}

impl Sheet {
    pub fn new([width, height]: [usize; 2], planes: usize) -> Self {
        Self {
            width,
            planes,
            values: vec![0.0; width * height * planes],
        }
    }

    pub fn height(&self) -> usize {
        self.values.len() / (self.width * self.planes)
    }

    /// A row of a plane.
    #[inline(always)]
    pub fn row(&self, plane: usize, y: usize) -> &[f32] {
        &self.values[(y * self.planes + plane) * self.width..][..self.width]
    }

    #[inline(always)]
    pub fn row_mut(&mut self, plane: usize, y: usize) -> &mut [f32] {
        &mut self.values[(y * self.planes + plane) * self.width..][..self.width]
    }

    /// A plane's number at a texel of the rectangle.
    #[inline(always)]
    pub fn at(&self, plane: usize, [x, y]: [usize; 2]) -> f32 {
        self.row(plane, y)[x]
    }

    /// Sums of a row of a plane over the squares of texels about each.
    #[inline(always)]
    pub fn sums(&self, plane: usize, y: usize, about: About, room: &mut Room, out: &mut [f32]) {
        let third = room.0.len() / 3;
        let (line, rest) = room.0.split_at_mut(third);
        let (part, zeros) = rest.split_at_mut(third);
        let (width, height) = (self.width, self.height());
        let radius = about.radius();
        let row = |k: usize| match (y + k).checked_sub(radius) {
            Some(y) if y < height => self.row(plane, y),
            _ => &zeros[..width],
        };
        // Columns first, between zeros.
        line[..radius].fill(0.0);
        line[radius + width..][..radius].fill(0.0);
        let inner = &mut line[radius..][..width];
        match about {
            About::Seven => add_rows::<7>(row, inner, false),
            About::Eleven => add_rows::<ELEVEN>(row, inner, false),
            About::Wide => {
                for third in 0..3 {
                    add_rows::<ELEVEN>(|k| row(third * ELEVEN + k), inner, third > 0);
                }
            }
        }
        let line = &line[..width + 2 * radius];
        match about {
            About::Seven => add_rows::<7>(|k| &line[k..][..width], out, false),
            About::Eleven => add_rows::<ELEVEN>(|k| &line[k..][..width], out, false),
            About::Wide => {
                let length = width + 2 * ELEVEN;
                let part = &mut part[..length];
                add_rows::<ELEVEN>(|k| &line[k..][..length], part, false);
                add_rows::<3>(|k| &part[k * ELEVEN..][..width], out, false);
            }
        }
    }
}

/// Squares of texels about one over which numbers are summed: 7 x 7, 11 x 11 or 33 x 33.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum About {
    Seven,
    Eleven,
    Wide,
}

impl About {
    const fn radius(self) -> usize {
        match self {
            Self::Seven => 3,
            Self::Eleven => RADIUS,
            Self::Wide => 3 * RADIUS + 1,
        }
    }
}

/// What sums over rows of a width need.
pub(super) struct Room(Vec<f32>);

impl Room {
    pub fn new(width: usize) -> Self {
        Self(vec![0.0; 3 * (width + 2 * About::Wide.radius())])
    }
}

/// The sum of rows, added to what is there if `adds`. It has one order, whatever the vectors.
#[inline(always)]
fn add_rows<'a, const N: usize>(row: impl Fn(usize) -> &'a [f32], out: &mut [f32], adds: bool) {
    let mut rows = [&[][..]; N];
    for (k, own) in rows.iter_mut().enumerate() {
        *own = &row(k)[..out.len()];
    }
    for (x, out) in out.iter_mut().enumerate() {
        let mut sum = rows[0][x];
        for row in &rows[1..] {
            sum += row[x];
        }
        *out = if adds { *out + sum } else { sum };
    }
}

/// Calls `work` for runs of rows, with the first of them and what `sheets` have of them: at once where there is little
/// to do, else side by side. Runs begin at multiples of `step`.
pub(super) fn rows<const K: usize>(
    height: usize,
    step: usize,
    sheets: [&mut [f32]; K],
    work: impl Fn(usize, [&mut [f32]; K]) + Sync,
) {
    split(0, height, step, sheets, &work);
}

fn split<const K: usize>(
    first: usize,
    height: usize,
    step: usize,
    sheets: [&mut [f32]; K],
    work: &(impl Fn(usize, [&mut [f32]; K]) + Sync),
) {
    let numbers = sheets.iter().map(|sheet| sheet.len()).max().unwrap_or(0);
    let middle = (height / 2).max(1).next_multiple_of(step);
    if numbers <= 2 * TASK || middle >= height {
        Arch::new().dispatch(
            #[inline(always)]
            || work(first, sheets),
        );
        return;
    }
    let mut halves = sheets.map(|sheet| sheet.split_at_mut(sheet.len() / height * middle));
    let above = halves.each_mut().map(|(above, _)| take(above));
    let below = halves.each_mut().map(|(_, below)| take(below));
    join(
        || split(first, middle, step, above, work),
        || split(first + middle, height - middle, step, below, work),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_over_squares_about_each_texel() {
        let mut sheet = Sheet::new([48, 41], 2);
        // Whole numbers, whose sums are exact in any order.
        let of = |x: usize, y: usize| ((x * x + 7 * y * x + y) % 23) as f32;
        for y in 0..41 {
            for (x, value) in sheet.row_mut(1, y).iter_mut().enumerate() {
                *value = of(x, y);
            }
        }
        let square = |[x, y]: [usize; 2], radius: usize| {
            let range =
                |at: usize, end: usize| at.saturating_sub(radius)..(at + radius + 1).min(end);
            let row = |y: usize| range(x, 48).map(|x| of(x, y)).sum::<f32>();
            range(y, 41).map(row).sum::<f32>()
        };
        let mut room = Room::new(48);
        for (about, radius) in [(About::Seven, 3), (About::Eleven, 5), (About::Wide, 16)] {
            for y in 0..41 {
                let mut out = vec![1.0; 48];
                sheet.sums(1, y, about, &mut room, &mut out);
                for (x, sum) in out.iter().enumerate() {
                    assert_eq!(*sum, square([x, y], radius), "{about:?} at {x}, {y}");
                }
            }
        }
    }

    #[test]
    fn runs_of_rows_cover_each_row_once_and_begin_at_steps() {
        let height = 1003;
        let (mut wide, mut narrow) = (vec![0.0; 64 * height], vec![0.0; height]);
        rows(
            height,
            32,
            [&mut wide, &mut narrow],
            |first, [wide, narrow]| {
                assert!(first % 32 == 0 && wide.len() == 64 * narrow.len());
                wide.iter_mut().for_each(|value| *value += first as f32);
                for (row, value) in narrow.iter_mut().enumerate() {
                    *value += (first + row) as f32;
                }
            },
        );
        assert!(narrow.iter().enumerate().all(|(y, v)| *v == y as f32));
        let firsts = wide.chunks(64).zip(&narrow);
        assert!(firsts.clone().all(|(row, y)| row[0] <= *y));
        assert!(firsts.filter(|(row, y)| row[0] == **y).count() > 1);
    }
}
