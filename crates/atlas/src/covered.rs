//! How much of the texels of a tile triangles cover.
//!
//! The area that is covered of every texel of a row follows from edges alone, as when glyphs are filled: each edge adds
//! what lies to its right. Edges at which two triangles meet add nothing, so only the borders of charts are looked at.

use crate::types::TILE;
use glam::DVec2;
use std::ops::Range;

pub(crate) const EDGE: usize = TILE as usize;

/// Texels of a tile: of each row a bit for each column.
pub(crate) type Mask = [u16; EDGE];

/// A texel counts as covered wholly where its area is off by no more than this, in texels: far above rounding.
const SLACK: f64 = 1e-9;

/// How much of the texels of a tile is covered.
pub(crate) struct Covered {
    /// Row by row, by how much the area grows from each texel to the next.
    pub growth: [[f64; EDGE + 1]; EDGE],
}

impl Covered {
    /// By triangles of positive area.
    pub fn by(triangles: &[[DVec2; 3]]) -> Self {
        let mut covered = Self {
            growth: [[0.0; EDGE + 1]; EDGE],
        };
        for ([a, b], times) in borders(triangles) {
            covered.add(a, b, times);
        }
        covered
    }

    /// Adds what lies to the right of an edge, so many times.
    fn add(&mut self, a: DVec2, b: DVec2, times: f64) {
        let (sign, top, bottom) = match b.y > a.y {
            true => (-times, a, b),
            false => (times, b, a),
        };
        let slope = (bottom.x - top.x) / (bottom.y - top.y);
        let at = |y: f64| match y {
            _ if y == top.y => top.x,
            _ if y == bottom.y => bottom.x,
            _ => top.x + slope * (y - top.y),
        };
        for row in whole(top.y, bottom.y, EDGE) {
            let from = top.y.max(row as f64);
            let to = bottom.y.min(row as f64 + 1.0);
            let [left, right] = [at(from), at(to)];
            let ends = (left.min(right), left.max(right));
            grow(&mut self.growth[row], ends, sign * (to - from));
        }
    }

    /// The texels within so many columns and rows that are covered wholly and once.
    pub fn whole(&self, width: usize, height: usize) -> Mask {
        let mut whole = [0; EDGE];
        for (row, growth) in whole.iter_mut().zip(&self.growth).take(height) {
            let mut area = 0.0;
            for (column, growth) in growth.iter().enumerate().take(width) {
                area += growth;
                *row |= u16::from((area - 1.0).abs() <= SLACK) << column;
            }
        }
        whole
    }
}

/// The edges that triangles of positive area do not have in common, as ends and how many times more one way than the
/// other; perhaps more than once. Those that add nothing to a tile are left out.
fn borders(triangles: &[[DVec2; 3]]) -> Vec<([DVec2; 2], f64)> {
    let mut edges: Vec<([DVec2; 2], f64)> = Vec::with_capacity(3 * triangles.len());
    let bits = (6 * triangles.len()).next_power_of_two().ilog2();
    // One more than the edge's place in the list; 0 where there is none. At most half of the table is taken.
    let mut table = vec![0_u16; 1 << bits];
    let number = |p: DVec2| (p.x.to_bits() ^ p.y.to_bits().rotate_left(32)).wrapping_mul(MIX);
    for p in triangles {
        let hashes = p.map(number);
        for (k, next) in [(0, 1), (1, 2), (2, 0)] {
            let ends = [p[k], p[next]];
            let [low, high] = [p[k].y.min(p[next].y), p[k].y.max(p[next].y)];
            if low == high || high <= 0.0 || low >= EDGE as f64 {
                continue;
            }
            let hash = (hashes[k] ^ hashes[next]).wrapping_mul(MIX);
            let mut slot = (hash >> (64 - bits)) as usize;
            loop {
                match usize::from(table[slot]).checked_sub(1) {
                    None => {
                        edges.push((ends, 1.0));
                        table[slot] = edges.len() as u16;
                        break;
                    }
                    Some(at) if edges[at].0 == ends => {
                        edges[at].1 += 1.0;
                        break;
                    }
                    Some(at) if edges[at].0 == [ends[1], ends[0]] => {
                        edges[at].1 -= 1.0;
                        break;
                    }
                    Some(_) => slot = (slot + 1) & (table.len() - 1),
                }
            }
        }
    }
    edges.retain(|(_, times)| *times != 0.0);
    edges
}

/// An odd number whose bits are well mixed.
const MIX: u64 = 0x9e37_79b9_7f4a_7c15;

/// Whole numbers below `count` in whose unit intervals an interval has more than an end.
pub(crate) fn whole(low: f64, high: f64, count: usize) -> Range<usize> {
    if low < high {
        // Casts cut off, and to less than all whole numbers they take fewer steps.
        let high = if high < count as f64 {
            high
        } else {
            count as f64
        };
        let last = high as i32;
        let end = last + i32::from(high > f64::from(last));
        (low as i32).max(0) as usize..end.max(0) as usize
    } else {
        0..0
    }
}

/// The largest whole number that is not above a coordinate in texels. A call of the library's costs more than all else
/// of an edge.
fn floor(x: f64) -> f64 {
    let whole = x as i32 as f64;
    if whole > x { whole - 1.0 } else { whole }
}

/// Adds the area to the right of a part of an edge that is so high and reaches from `left` to `right`.
fn grow(row: &mut [f64; EDGE + 1], (left, right): (f64, f64), height: f64) {
    let mut add = |column: f64, middle: f64, height: f64| {
        if column < 0.0 {
            row[0] += height;
        } else if column < EDGE as f64 {
            let beyond = middle - column;
            row[column as usize] += height * (1.0 - beyond);
            row[column as usize + 1] += height * beyond;
        }
    };
    let (first, last) = (floor(left), floor(right));
    if first == last {
        add(first, 0.5 * (left + right), height);
        return;
    }
    let slope = height / (right - left);
    if left < 0.0 {
        add(-1.0, -1.0, slope * (right.min(0.0) - left));
    }
    let mut column = first.max(0.0);
    while column <= last && column < EDGE as f64 {
        let [from, to] = [left.max(column), right.min(column + 1.0)];
        add(column, 0.5 * (from + to), slope * (to - from));
        column += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_that_two_triangles_share_are_no_borders() {
        // A fan about a point: of its edges the outer ones are left. Folded over, the shared edge counts twice.
        let at = |turn: f64| DVec2::new(8.0 + 5.0 * turn.cos(), 8.0 + 5.0 * turn.sin());
        let fan: Vec<[DVec2; 3]> = (0..5)
            .map(|k| {
                [
                    DVec2::splat(8.0),
                    at(f64::from(k) + 0.3),
                    at(f64::from(k) + 1.3),
                ]
            })
            .collect();
        let outer = borders(&fan);
        assert_eq!(outer.len(), 7);
        assert!(outer.iter().all(|(_, times)| times.abs() == 1.0));
        let [a, b, c] = fan[0];
        let folded = [[a, b, c], [a, b, c - DVec2::new(0.5, 0.0)]];
        let twice = borders(&folded).into_iter().filter(|edge| edge.1 == 2.0);
        assert_eq!(twice.count(), 1);
    }
}
