//! The texels that a shape touches, row by row.

use glam::DVec2;

/// Whole texels in rows of half-open spans.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Mask {
    pub width: u32,
    pub height: u32,
    /// The span of every row of a full box.
    whole: [u32; 2],
    spans: Vec<[u32; 2]>,
    /// Where each row's spans begin, one more than rows; none of a full box.
    starts: Vec<u32>,
    /// Length of each row's longest span; none of a full box.
    longest: Vec<u32>,
    /// Steps of so many rows, around the end, come to every row once and spread evenly from the first few on.
    pub stride: u32,
}

/// Triangles are taken larger by this many texels, so that what 32 bits round off a coordinate stays inside the mask.
const SLACK: f64 = 1.0 / 256.0;

/// Words that are kept on the stack: rows of up to 64 texels.
const FEW: usize = 64;

/// A box with a longer edge fits no page: its mask is full, so that none is too large for memory.
const LARGEST: u32 = 16_384;

impl Mask {
    /// Every texel of a box of `width` x `height` that these triangles touch; they are in texels, inside the box.
    pub fn of(triangles: impl Iterator<Item = [DVec2; 3]>, width: u32, height: u32) -> Mask {
        if width.max(height) > LARGEST {
            return Mask::full(width, height);
        }
        let words = width.div_ceil(64) as usize;
        // Most charts are small: these need no memory of their own.
        let (mut few, mut many) = ([0u64; FEW], Vec::new());
        let bits = match words * height as usize {
            count @ ..=FEW => &mut few[..count],
            count => {
                many.resize(count, 0);
                &mut many[..]
            }
        };
        for corners in triangles {
            rows(corners, height, |y, low, high| {
                let first = (low.floor().max(0.0) as u32).min(width - 1);
                let end = (high.ceil().max(1.0) as u32).clamp(first + 1, width);
                let row = y as usize * words;
                fill(&mut bits[row..row + words], first, end);
            });
        }
        let is_full = |row: &[u64]| find(row, 0, false) >= width;
        if bits.chunks_exact(words.max(1)).all(is_full) {
            return Mask::full(width, height);
        }
        let mut mask = Mask::empty(width, height);
        for row in bits.chunks_exact(words.max(1)) {
            let (mut x, mut longest) = (0, 0);
            loop {
                let first = find(row, x, true);
                if first >= width {
                    break;
                }
                x = find(row, first, false).min(width);
                mask.spans.push([first, x]);
                longest = longest.max(x - first);
            }
            mask.starts.push(mask.spans.len() as u32);
            mask.longest.push(longest);
        }
        mask
    }

    /// A box without rows, for as many as it is high.
    fn empty(width: u32, height: u32) -> Mask {
        let mut starts = Vec::with_capacity(height as usize + 1);
        starts.push(0);
        Mask {
            width,
            height,
            whole: [0, width],
            spans: Vec::with_capacity(height as usize),
            starts,
            longest: Vec::with_capacity(height as usize),
            stride: stride(height),
        }
    }

    /// A full box.
    pub fn full(width: u32, height: u32) -> Mask {
        Mask {
            width,
            height,
            whole: [0, width],
            stride: 1,
            ..Mask::default()
        }
    }

    /// True where no texel of the box is missing.
    pub fn is_full(&self) -> bool {
        self.starts.is_empty()
    }

    /// The spans of a row, ascending.
    pub fn row(&self, y: u32) -> &[[u32; 2]] {
        match self.is_full() {
            true => std::slice::from_ref(&self.whole),
            false => {
                &self.spans[self.starts[y as usize] as usize..self.starts[y as usize + 1] as usize]
            }
        }
    }

    /// Length of the longest span of a row.
    pub fn longest(&self, y: u32) -> u32 {
        match self.is_full() {
            true => self.width,
            false => self.longest[y as usize],
        }
    }

    /// The same after half a turn.
    pub fn half_turn(&self) -> Mask {
        if self.is_full() {
            return self.clone();
        }
        let mut mask = Mask::empty(self.width, self.height);
        for y in (0..self.height).rev() {
            let turned = self
                .row(y)
                .iter()
                .rev()
                .map(|&[a, b]| [self.width - b, self.width - a]);
            mask.spans.extend(turned);
            mask.starts.push(mask.spans.len() as u32);
            mask.longest.push(self.longest[y as usize]);
        }
        mask
    }

    /// Texels within `reach` columns and rows of the mask's, itself included.
    pub fn grown_area(&self, reach: u32) -> u64 {
        if self.is_full() {
            let [width, height] =
                [self.width, self.height].map(|edge| u64::from(edge) + 2 * u64::from(reach));
            return width.saturating_mul(height);
        }
        if self.width + 2 * reach <= 64 && self.height as usize <= FEW {
            return self.grown_bits(reach);
        }
        let mut area = 0;
        let mut merged = Vec::new();
        for y in 0..self.height + 2 * reach {
            self.grown_row(y, reach, &mut merged);
            area += merged.iter().map(|&[a, b]| u64::from(b - a)).sum::<u64>();
        }
        area
    }

    /// [`Mask::grown_area`] of a mask that with what it grows by is 64 texels wide and [`FEW`] rows high at most.
    fn grown_bits(&self, reach: u32) -> u64 {
        let mut rows = [0u64; FEW];
        for (y, row) in (0..self.height).zip(&mut rows) {
            for &[a, b] in self.row(y) {
                fill(std::slice::from_mut(row), a, b + 2 * reach);
            }
        }
        let rows = &rows[..self.height as usize];
        let grown = 0..rows.len() + 2 * reach as usize;
        let texels = grown.map(|y| {
            let near = y.saturating_sub(2 * reach as usize)..(y + 1).min(rows.len());
            rows[near].iter().fold(0, |all, row| all | row).count_ones()
        });
        texels.map(u64::from).sum()
    }

    /// Row `y` of the mask grown by `reach` on every side; rows and columns count from the grown box's corner.
    pub fn grown_row(&self, y: u32, reach: u32, merged: &mut Vec<[u32; 2]>) {
        merged.clear();
        for row in y.saturating_sub(2 * reach)..(y + 1).min(self.height) {
            merged.extend(self.row(row).iter().map(|&[a, b]| [a, b + 2 * reach]));
        }
        merged.sort_unstable();
        let mut last = 0;
        for i in 1..merged.len() {
            if merged[i][0] <= merged[last][1] {
                merged[last][1] = merged[last][1].max(merged[i][1]);
            } else {
                last += 1;
                merged[last] = merged[i];
            }
        }
        merged.truncate(last + 1);
    }
}

/// The number next to the golden section of `height` that has no divisor in common with it, 1 at least.
fn stride(height: u32) -> u32 {
    let divisor = |mut a: u32, mut b: u32| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let golden = (f64::from(height) * 0.618) as u32;
    (1..=golden)
        .rev()
        .find(|&s| divisor(s, height) == 1)
        .unwrap_or(1)
}

/// Calls `found` with every row of a triangle below `height` and the columns between which it meets the row.
fn rows(corners: [DVec2; 3], height: u32, mut found: impl FnMut(u32, f64, f64)) {
    let [a, b, c] = corners;
    let low = a.y.min(b.y).min(c.y) - SLACK;
    let high = a.y.max(b.y).max(c.y) + SLACK;
    let first = (low.floor().max(0.0) as u32).min(height - 1);
    let last = (high.ceil().max(1.0) as u32).clamp(first + 1, height);
    for y in first..last {
        let (top, bottom) = (f64::from(y) - SLACK, f64::from(y) + 1.0 + SLACK);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            if p.y.max(q.y) < top || p.y.min(q.y) > bottom {
                continue;
            }
            let at = |y: f64| match q.y - p.y {
                0.0 => [p.x, q.x],
                rise => [p.x + (q.x - p.x) * ((y - p.y) / rise).clamp(0.0, 1.0); 2],
            };
            for x in [at(top), at(bottom)].as_flattened() {
                (left, right) = (left.min(*x), right.max(*x));
            }
        }
        if left <= right {
            found(y, left - SLACK, right + SLACK);
        }
    }
}

/// Sets the bits `first..end` of a row.
pub(crate) fn fill(row: &mut [u64], first: u32, end: u32) {
    if first >= end {
        return;
    }
    let (from, to) = (first as usize / 64, (end as usize - 1) / 64);
    let (low, high) = (!0u64 << (first % 64), !0u64 >> (63 - (end - 1) % 64));
    if from == to {
        row[from] |= low & high;
    } else {
        row[from] |= low;
        row[from + 1..to].fill(!0);
        row[to] |= high;
    }
}

/// The first bit from `x` on that equals `set`; past the row's end if there is none.
pub(crate) fn find(row: &[u64], x: u32, set: bool) -> u32 {
    let turn = if set { 0 } else { !0 };
    let mut at = x as usize / 64;
    let mut keep = !0u64 << (x % 64);
    while let Some(word) = row.get(at) {
        let word = (word ^ turn) & keep;
        if word != 0 {
            return at as u32 * 64 + word.trailing_zeros();
        }
        (at, keep) = (at + 1, !0);
    }
    row.len() as u32 * 64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_hold_every_place_of_a_triangle_and_little_more() {
        let mut state = 5u32;
        let mut roll = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        for number in 0..200 {
            let wide = if number % 2 == 0 { 16.0 } else { 1.5 };
            let corners = [(); 3].map(|()| DVec2::new(1.0 + wide * roll(), 1.0 + wide * roll()));
            let mut found = [(f64::INFINITY, f64::NEG_INFINITY); 20];
            rows(corners, 20, |y, left, right| {
                found[y as usize] = (left, right)
            });
            let mut seen = [(f64::INFINITY, f64::NEG_INFINITY); 20];
            for i in 0..=200 {
                for j in 0..=200 - i {
                    let [s, t] = [i, j].map(|k| f64::from(k) / 200.0);
                    let [a, b, c] = corners;
                    let p = a + (b - a) * s + (c - a) * t;
                    let row = &mut seen[p.y as usize];
                    *row = (row.0.min(p.x), row.1.max(p.x));
                }
            }
            for (y, (found, seen)) in found.iter().zip(seen).enumerate() {
                let holds = seen.0 > seen.1 || found.0 <= seen.0 && seen.1 <= found.1;
                assert!(holds, "{corners:?}, row {y}: {found:?} {seen:?}");
                let is_close = seen.0 > seen.1 || found.0 > seen.0 - 0.7 && found.1 < seen.1 + 0.7;
                assert!(is_close, "{corners:?}, row {y}: {found:?} {seen:?}");
            }
        }
    }

    #[test]
    fn small_masks_grow_by_what_their_rows_grow_by() {
        let corners = |k: f64| [[0.2, 0.1], [7.9 + k, 3.0], [2.0, 9.5]].map(DVec2::from);
        for (k, reach) in [(0.0, 0), (1.0, 1), (20.0, 2), (40.0, 5), (70.0, 3)] {
            let far = corners(k).map(|p| p + DVec2::new(0.0, 4.0));
            let mask = Mask::of([corners(0.0), far].into_iter(), 80, 14);
            let mut row = Vec::new();
            let area = (0..14 + 2 * reach).map(|y| {
                mask.grown_row(y, reach, &mut row);
                row.iter().map(|&[a, b]| u64::from(b - a)).sum::<u64>()
            });
            let area: u64 = area.sum();
            let narrow = Mask {
                width: 50,
                ..mask.clone()
            };
            let is_narrow = mask.spans.iter().all(|span| span[1] <= 50);
            assert_eq!(is_narrow, k < 41.0);
            assert_eq!(mask.grown_area(reach), area);
            assert!(!is_narrow || narrow.grown_area(reach) == area, "{k}");
        }
    }

    #[test]
    fn a_box_too_long_for_any_page_keeps_its_size_and_takes_no_memory() {
        let mask = Mask::of(std::iter::empty(), LARGEST + 1, 3);
        assert_eq!((mask.width, mask.height), (LARGEST + 1, 3));
        assert!(mask.is_full() && mask.spans.is_empty() && mask.starts.is_empty());
    }
}
