//! Places shapes on pages by the texels they touch: each at the lowest free place, the largest first.
//!
//! A page holds what no shape may touch any more: the texels of the shapes placed so far and those within two gutters
//! of them. A shape is tested as it is. So two shapes are two gutters apart, and shapes go into each other's hollows.

use crate::mask::{Mask, fill, find};
use std::cmp::Reverse;
use std::collections::HashMap;

/// Where a shape went: its box's first texel, and quarter turns from +u to +v.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Spot {
    pub page: u32,
    pub x: u32,
    pub y: u32,
    pub turn: u8,
}

/// A shape in the turns that it may take: the first quarter turns from 0 up, without those that look like one before.
pub(crate) type Shape = Vec<Mask>;

/// A page, or the sheet of a mesh that stands in several places.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub width: u32,
    pub height: u32,
    /// Empty texels around every shape; two shapes are twice as far apart.
    pub gutter: u32,
    /// Empty texels along the frame's edges.
    pub border: u32,
}

impl Frame {
    /// All of its texels.
    pub fn texels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// A frame that is being filled.
#[derive(Clone)]
pub(crate) struct Page {
    frame: Frame,
    words: usize,
    /// Texels that are taken.
    bits: Vec<u64>,
    /// Free runs of each row, and the length of its longest.
    free: Vec<Vec<[u32; 2]>>,
    longest: Vec<u32>,
    merged: Vec<[u32; 2]>,
}

impl Page {
    /// An empty frame.
    pub fn new(frame: Frame) -> Page {
        let words = frame.width.div_ceil(64) as usize;
        let inner = [frame.border, frame.width.saturating_sub(frame.border)];
        let mut page = Page {
            frame,
            words,
            bits: vec![0; words * frame.height as usize],
            free: vec![vec![inner]; frame.height as usize],
            longest: vec![inner[1].saturating_sub(inner[0]); frame.height as usize],
            merged: Vec::new(),
        };
        for y in 0..frame.height {
            let row = &mut page.bits[y as usize * words..][..words];
            fill(row, 0, frame.border.min(frame.width));
            fill(row, inner[1], words as u32 * 64);
        }
        page
    }

    /// What it was made of.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// Texels that shapes may still touch.
    pub fn free(&self) -> u64 {
        let runs = self.free.iter().flatten();
        runs.map(|&[first, end]| u64::from(end.saturating_sub(first)))
            .sum()
    }

    /// The lowest place at or above row `from` for a shape whose last row ends at or before `below`, leftmost first.
    fn place(&self, mask: &Mask, from: u32, below: u32) -> Option<[u32; 2]> {
        let Frame {
            width,
            height,
            border,
            ..
        } = self.frame;
        if mask.width + 2 * border > width || mask.height + 2 * border > height {
            return None;
        }
        // The row that is tried first: where the last place failed, the next one likely fails too.
        let rows = if mask.is_full() { 1 } else { mask.height };
        let widest = (0..rows).max_by_key(|&y| (mask.longest(y), Reverse(y)))?;
        let &[left, right] = mask
            .row(widest)
            .iter()
            .max_by_key(|&&[a, b]| (b - a, Reverse(a)))?;
        let (mut tight, mut hit) = (widest, widest);
        let end = (height - border).min(below);
        for y in from.max(border)..(end + 1).saturating_sub(mask.height) {
            let longest = &self.longest[y as usize..][..mask.height as usize];
            let narrow = |row: u32| longest[row as usize] < mask.longest(row);
            if narrow(tight) {
                continue;
            }
            if let Some(row) = (0..mask.height).find(|&row| narrow(row)) {
                tight = row;
                continue;
            }
            for &[first, last] in &self.free[(y + widest) as usize] {
                // The widest span lies inside this run, and the whole box inside the frame.
                let Some(most) = last.checked_sub(right) else {
                    continue;
                };
                let most = most.min(width - border - mask.width);
                let mut x = first.saturating_sub(left).max(border);
                while x <= most {
                    match self.next(mask, x, y, &mut hit) {
                        None => return Some([x, y]),
                        Some(next) => x = next,
                    }
                }
            }
        }
        None
    }

    /// `None` where the mask is free at a place, else the next column at which it may be.
    fn next(&self, mask: &Mask, x: u32, y: u32, hit: &mut u32) -> Option<u32> {
        let blocked = |row: u32| {
            let bits = &self.bits[(y + row) as usize * self.words..][..self.words];
            mask.row(row).iter().find_map(|&[a, b]| {
                let taken = find(bits, x + a, true);
                (taken < x + b).then(|| (find(bits, taken, false) - a).max(x + 1))
            })
        };
        let first = *hit;
        if let Some(next) = blocked(first) {
            return Some(next);
        }
        // Far rows after near ones: what meets anything is mostly found in the first few.
        let mut row = 0;
        for _ in 0..mask.height {
            row += mask.stride;
            row -= if row < mask.height { 0 } else { mask.height };
            if row != first
                && let Some(next) = blocked(row)
            {
                *hit = row;
                return Some(next);
            }
        }
        None
    }

    /// Takes the texels of a mask and those within two gutters.
    pub fn insert(&mut self, mask: &Mask, [x, y]: [u32; 2]) {
        let reach = 2 * self.frame.gutter;
        let mut merged = std::mem::take(&mut self.merged);
        for grown in 0..mask.height + 2 * reach {
            let Some(row) = (y + grown)
                .checked_sub(reach)
                .filter(|&r| r < self.frame.height)
            else {
                continue;
            };
            mask.grown_row(grown, reach, &mut merged);
            let bits = &mut self.bits[row as usize * self.words..][..self.words];
            for &[a, b] in &merged {
                let first = (x + a).saturating_sub(reach);
                fill(
                    bits,
                    first,
                    (x + b).saturating_sub(reach).min(self.frame.width),
                );
            }
            let runs = &mut self.free[row as usize];
            runs.clear();
            let mut at = 0;
            loop {
                let first = find(bits, at, false);
                if first >= self.frame.width {
                    break;
                }
                at = find(bits, first, true);
                runs.push([first, at]);
            }
            self.longest[row as usize] = runs.iter().map(|r| r[1] - r[0]).max().unwrap_or(0);
        }
        self.merged = merged;
    }
}

/// Sizes that look alike share what is known about full rows: to an eighth.
fn class(mask: &Mask, turn: usize) -> [u32; 3] {
    let round = |size: u32| size / (1 << size.ilog2().saturating_sub(3));
    let exponent = |size: u32| size.ilog2().saturating_sub(3);
    let key = |size: u32| exponent(size) * 16 + round(size);
    [key(mask.width), key(mask.height), turn as u32]
}

/// Places shapes in one frame. Spots of those named in `chosen`, in that order.
///
/// # Errors
///
/// How many shapes were placed before one did not fit.
pub(crate) fn pack(shapes: &[Shape], chosen: &[usize], frame: Frame) -> Result<Vec<Spot>, usize> {
    add(&mut Page::new(frame), shapes, chosen)
}

/// The same in what a page has left.
///
/// # Errors
///
/// As [`pack`]; what was placed stays taken.
pub(crate) fn add(page: &mut Page, shapes: &[Shape], chosen: &[usize]) -> Result<Vec<Spot>, usize> {
    let mut spots = vec![Spot::default(); chosen.len()];
    let mut begin = Begin::new();
    for (placed, k) in largest_first(shapes, chosen).into_iter().enumerate() {
        spots[k] = put(page, &shapes[chosen[k]], &mut begin).ok_or(placed)?;
    }
    Ok(spots)
}

/// Places as many shapes in one frame as find room, the largest first. Spots of those named in `chosen`, in that order.
pub(crate) fn pack_some(shapes: &[Shape], chosen: &[usize], frame: Frame) -> Vec<Option<Spot>> {
    let mut page = Page::new(frame);
    let mut spots = vec![None; chosen.len()];
    let mut begin = Begin::new();
    for k in largest_first(shapes, chosen) {
        spots[k] = put(&mut page, &shapes[chosen[k]], &mut begin);
    }
    spots
}

/// The numbers of `chosen` in the order in which they are placed.
fn largest_first(shapes: &[Shape], chosen: &[usize]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..chosen.len()).collect();
    order.sort_by_key(|&k| {
        let mask = &shapes[chosen[k]][0];
        (Reverse(mask.width + mask.height), k)
    });
    order
}

/// The row where the last shape of a class went: lower rows have no room for one like it.
type Begin = HashMap<[u32; 3], u32>;

/// Places a shape in the turn in which it ends lowest.
fn put(page: &mut Page, shape: &Shape, begin: &mut Begin) -> Option<Spot> {
    let mut best: Option<(u32, Spot)> = None;
    for (turn, mask) in shape.iter().enumerate() {
        let from = begin.entry(class(mask, turn)).or_default();
        let below = best.map_or(u32::MAX - 1, |(bottom, _)| bottom - 1);
        match page.place(mask, *from, below) {
            Some([x, y]) => {
                *from = y;
                let turn = turn as u8;
                best = Some((
                    y + mask.height,
                    Spot {
                        page: 0,
                        x,
                        y,
                        turn,
                    },
                ));
            }
            None if best.is_none() => *from = page.frame.height,
            None => {}
        }
    }
    let (_, spot) = best?;
    page.insert(&shape[spot.turn as usize], [spot.x, spot.y]);
    Some(spot)
}
