//! Finds borders that run along one another: a grid of cells for each power of two of their lengths.

use super::border::Border;
use super::pair::{Pair, common, reach};
use crate::options::Seams as Scope;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// A cell: the exponent of its edge length, and where it lies.
type Cell = (i32, [i64; 3]);

/// All pairs of borders that are seams, in the order of their numbers.
///
/// A border is entered in the cells, as large as it is long, that it meets. It looks for others in cells at least as large, of which it
/// meets eight at most; so a long one and many short ones find each other at the cost of the short ones.
pub(super) fn pairs(borders: &[Border], scope: Scope) -> Vec<Pair> {
    let levels: Vec<i32> = borders.iter().map(level).collect();
    let boxes: Vec<[DVec3; 2]> = borders.par_iter().map(space).collect();
    let mut entries: Vec<(Cell, u32)> = borders
        .par_iter()
        .enumerate()
        .flat_map_iter(|(number, border)| {
            cells(border, levels[number]).map(move |cell| (cell, number as u32))
        })
        .collect();
    entries.par_sort_unstable();
    let mut inside: FxHashMap<Cell, &[(Cell, u32)]> = FxHashMap::default();
    for cell in entries.chunk_by(|a, b| a.0 == b.0) {
        inside.insert(cell[0].0, cell);
    }
    let used: BTreeSet<i32> = levels.iter().copied().collect();
    let found = (0..borders.len()).into_par_iter().map(|number| {
        let (own, border) = (number as u32, &borders[number]);
        let [low, high] = boxes[number];
        let meets = |other: u32| {
            let [l, h] = boxes[other as usize];
            l.cmple(high).all() && h.cmpge(low).all()
        };
        let mut near: Vec<u32> = Vec::new();
        for &level in used.range(levels[number]..) {
            for cell in cells(border, level) {
                let inside = inside.get(&cell).copied().unwrap_or_default();
                // Of two in cells of one size, the first looks.
                let others = inside.iter().map(|entry| entry.1);
                let others = others.filter(|&other| level > levels[number] || other > own);
                near.extend(others.filter(|&other| meets(other)));
            }
        }
        near.sort_unstable();
        near.dedup();
        let pair = |other: u32| common([own, other], border, &borders[other as usize], scope);
        near.into_iter().filter_map(pair).collect::<Vec<_>>()
    });
    found.flatten_iter().collect()
}

/// The least power of two that is no shorter than the border nor than its reach to both sides.
fn level(border: &Border) -> i32 {
    border.length().max(2.0 * reach(border)).log2().ceil() as i32
}

/// The box about a border and what it reaches.
fn space(border: &Border) -> [DVec3; 2] {
    let [a, b] = border.ends;
    let reach = DVec3::splat(reach(border));
    [a.min(b) - reach, a.max(b) + reach]
}

/// The cells of a level that a border meets, with what it reaches.
fn cells(border: &Border, level: i32) -> impl Iterator<Item = Cell> {
    let edge = f64::from(level).exp2();
    let [low, high] = space(border).map(|p| (p / edge).floor().as_i64vec3());
    let [x, y, z] = [0, 1, 2].map(|axis| low[axis]..=high[axis]);
    x.flat_map(move |x| {
        let z = z.clone();
        let cell = move |y: i64| z.clone().map(move |z| (level, [x, y, z]));
        y.clone().flat_map(cell)
    })
}
