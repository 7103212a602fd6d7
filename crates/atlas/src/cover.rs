//! Which texels of a tile triangles cover wholly, found without cutting them.
//!
//! The area that triangles cover of every texel of a row follows from their edges alone, as when glyphs are filled: each
//! edge adds what lies to its right. Edges at which two triangles meet add nothing, so only the borders of charts are
//! looked at.

use crate::types::TILE;
use crate::uv::twice_area;
use glam::DVec2;
use std::ops::Range;

const EDGE: usize = TILE as usize;

/// A texel counts as covered wholly where its area is off by no more than this, in texels: far above rounding.
const SLACK: f64 = 1e-9;

/// Triangles that a whole texel holds at most. A point is looked for among all of them, and among pieces by halves: from
/// a few dozen on these take less time.
pub const MOST_HELD: usize = 24;

/// Triangles of a tile from which on its texels are not asked: most would hold too many.
const CROWD: usize = EDGE * EDGE * MOST_HELD / 3;

/// Texels of a tile: of each row a bit for each column.
type Mask = [u16; EDGE];

/// The texels that a triangle meets, and the rows that have any: the first, and the one after the last.
struct Texels {
    mask: Mask,
    rows: [u8; 2],
}

impl Texels {
    fn rows(&self) -> Range<usize> {
        self.rows[0].into()..self.rows[1].into()
    }

    /// Those among some, row-major.
    #[inline(always)]
    fn among(&self, some: &Mask, mut each: impl FnMut(usize)) {
        for row in self.rows() {
            let mut left = self.mask[row] & some[row];
            while left != 0 {
                each(row * EDGE + left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
    }
}

/// Texels that are covered wholly, and the triangles of each.
pub(crate) struct Wholes {
    /// Where the triangles of each texel begin in one list of them all; of texels that are not whole, none.
    starts: [u32; EDGE * EDGE + 1],
    /// How many of each texel's have been placed.
    placed: [u8; EDGE * EDGE],
    whole: Mask,
    /// The texels that each triangle meets; none where no texel is whole.
    met: Vec<Texels>,
    /// The triangle that is placed next.
    next: usize,
}

/// What a triangle has of a tile.
pub(crate) struct Met {
    /// Whole texels hold it.
    pub is_held: bool,
    /// It may have parts of other texels.
    pub is_cut: bool,
}

/// A tile of a page, by its first texel and by how many columns and rows of it lie on the page.
#[derive(Clone, Copy)]
struct Place {
    origin: DVec2,
    width: usize,
    height: usize,
}

impl Place {
    fn new(x0: u32, y0: u32, page_size: u32) -> Self {
        let left = |start: u32| TILE.min(page_size - start) as usize;
        Self {
            origin: DVec2::new(x0.into(), y0.into()),
            width: left(x0),
            height: left(y0),
        }
    }

    /// Corners from the tile's first texel on, wound so that their area is positive.
    fn local(&self, corners: [DVec2; 3]) -> [DVec2; 3] {
        let [a, b, c] = corners.map(|corner| corner - self.origin);
        match twice_area([a, b, c]) < 0.0 {
            true => [a, c, b],
            false => [a, b, c],
        }
    }

    /// The texels of which a triangle has more than an edge or a corner.
    fn met(&self, p: [DVec2; 3]) -> Texels {
        let least = |a: f64, b: f64| if a < b { a } else { b };
        let most = |a: f64, b: f64| if a > b { a } else { b };
        let [x, y] = [0, 1].map(|axis: usize| p.map(|p| p[axis]));
        let [left, top] = [x, y].map(|[a, b, c]| least(least(a, b), c));
        let [right, bottom] = [x, y].map(|[a, b, c]| most(most(a, b), c));
        let (columns, rows) = (
            whole(left, right, self.width),
            whole(top, bottom, self.height),
        );
        // A texel lies outside of an edge where even its innermost corner does: before a column, or after one. Both
        // change evenly from row to row.
        let (mut after, mut before) = ([(f64::NEG_INFINITY, 0.0); 3], [(f64::INFINITY, 0.0); 3]);
        for (k, [a, b]) in [[p[0], p[1]], [p[1], p[2]], [p[2], p[0]]]
            .into_iter()
            .enumerate()
        {
            let n = (b - a).perp();
            let rest = n.dot(a) - most(n.x, 0.0) - most(n.y, 0.0);
            let inverse = 1.0 / n.x;
            let line = (rest * inverse, n.y * inverse);
            if n.x > 0.0 {
                after[k] = line;
            } else if n.x < 0.0 {
                before[k] = line;
            }
        }
        let mut texels = Texels {
            mask: [0; EDGE],
            rows: [rows.start as u8, rows.end as u8],
        };
        for row in rows {
            let at = |(start, step): (f64, f64)| start - step * row as f64;
            let first = most(most(at(after[0]), at(after[1])), at(after[2]));
            let last = least(least(at(before[0]), at(before[1])), at(before[2]));
            let first = most(first + 1.0, columns.start as f64) as i32;
            let last = most(least(last, columns.end as f64), 0.0);
            let end = last as i32 + i32::from(last > f64::from(last as i32));
            let ones = |count: i32| (1_u32 << count) - 1;
            texels.mask[row] = (ones(end) & !ones(first.min(end))) as u16;
        }
        texels
    }
}

impl Wholes {
    /// True where so many triangles are in a tile that hardly a texel of it is whole.
    pub fn are_rare(triangles: usize) -> bool {
        triangles > CROWD
    }

    /// None of a tile's texels.
    pub fn none() -> Self {
        Self {
            starts: [0; EDGE * EDGE + 1],
            placed: [0; EDGE * EDGE],
            whole: [0; EDGE],
            met: Vec::new(),
            next: 0,
        }
    }

    /// Of a tile, by its first texel and the page's edge: the texels that are covered wholly and once, by [`MOST_HELD`]
    /// triangles of one object at most that may all be held uncut. Of each triangle by its number its instance, and
    /// whether it may; corners are in texels of the page.
    pub fn of(
        [x0, y0, page_size]: [u32; 3],
        corners: impl ExactSizeIterator<Item = [DVec2; 3]>,
        triangle: impl Fn(usize) -> (u32, bool),
    ) -> Self {
        let place = Place::new(x0, y0, page_size);
        let local: Vec<[DVec2; 3]> = corners.map(|corners| place.local(corners)).collect();
        let mut wholes = Self {
            whole: Covered::by(&local).whole(place.width, place.height),
            ..Self::none()
        };
        if wholes.whole == [0; EDGE] {
            return wholes;
        }
        wholes.met = local.iter().map(|&corners| place.met(corners)).collect();
        let mut counts = [0; EDGE * EDGE];
        let mut objects = [0; EDGE * EDGE];
        let mut refused = [0; EDGE];
        for (number, met) in wholes.met.iter().enumerate() {
            let (object, is_kept) = triangle(number);
            if !is_kept {
                (met.rows()).for_each(|row| refused[row] |= met.mask[row]);
                continue;
            }
            met.among(&wholes.whole, |texel| {
                let is_one = counts[texel] == 0 || objects[texel] == object;
                if counts[texel] == MOST_HELD as u32 || !is_one {
                    refused[texel / EDGE] |= 1 << (texel % EDGE);
                } else {
                    counts[texel] += 1;
                }
                objects[texel] = object;
            });
        }
        for (texel, &count) in counts.iter().enumerate() {
            let (row, bit) = (texel / EDGE, 1 << (texel % EDGE));
            let own = match refused[row] & bit {
                0 => count,
                _ => 0,
            };
            if own == 0 {
                wholes.whole[row] &= !bit;
            }
            wholes.starts[texel + 1] = wholes.starts[texel] + own;
        }
        wholes
    }

    /// How many triangles all of them hold, one by one.
    pub fn total(&self) -> usize {
        self.starts[EDGE * EDGE] as usize
    }

    /// The place of a texel's triangles in the list of all; `None` where it is not whole.
    pub fn held(&self, texel: u16) -> Option<Range<u32>> {
        let texel = usize::from(texel);
        let own = self.starts[texel]..self.starts[texel + 1];
        (!own.is_empty()).then_some(own)
    }

    /// Writes the next triangle under this number where the texels that hold it have their lists.
    pub fn place(&mut self, number: u32, list: &mut [u32]) -> Met {
        let Some(met) = self.met.get(self.next) else {
            return Met {
                is_held: false,
                is_cut: true,
            };
        };
        self.next += 1;
        let mut is_held = false;
        met.among(&self.whole, |texel| {
            let placed = &mut self.placed[texel];
            list[self.starts[texel] as usize + usize::from(*placed)] = number;
            *placed += 1;
            is_held = true;
        });
        let is_cut = (met.rows()).any(|row| met.mask[row] & !self.whole[row] != 0);
        Met { is_held, is_cut }
    }
}

/// How much of the texels of a tile is covered.
struct Covered {
    /// Row by row, by how much the area grows from each texel to the next.
    growth: [[f64; EDGE + 1]; EDGE],
}

impl Covered {
    /// By triangles of positive area.
    fn by(triangles: &[[DVec2; 3]]) -> Self {
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
    fn whole(&self, width: usize, height: usize) -> Mask {
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
fn whole(low: f64, high: f64, count: usize) -> Range<usize> {
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

    /// Texels of a tile of 16 x 16 at (32, 16) that triangles of object 7 cover wholly, and how many each has.
    fn wholes(triangles: &[[[f64; 2]; 3]]) -> Vec<(u16, u32)> {
        let corners = triangles.iter();
        let corners = corners.map(|p| p.map(|[x, y]| DVec2::new(32.0 + x, 16.0 + y)));
        let wholes = Wholes::of([32, 16, 1024], corners, |_| (7, true));
        let own = |texel| Some((texel, wholes.held(texel)?.len() as u32));
        (0..256).filter_map(own).collect()
    }

    #[test]
    fn texels_amid_triangles_are_whole_and_those_at_their_border_are_not() {
        let [a, b, c, d] = [[-3.5, -2.0], [40.0, -2.25], [40.0, 30.0], [-3.5, 29.0]];
        // One triangle, then two that meet along a diagonal, wound either way.
        let all = wholes(&[[[-60.0, -60.0], [100.0, -60.0], [-60.0, 100.0]]]);
        assert_eq!(all.len(), 256);
        assert!(all.iter().all(|(_, count)| *count == 1));
        let two = wholes(&[[a, b, c], [a, d, c]]);
        assert_eq!(two.len(), 256);
        let both = two.iter().filter(|(_, count)| *count == 2).count();
        assert!((16..48).contains(&both), "{both}");
        // A fan about a point amid a texel, to a square from 2.5 to 6.25: whole are the texels from 3 to 6.
        let square = [[2.5, 2.5], [6.25, 2.5], [6.25, 6.25], [2.5, 6.25]];
        let fan: Vec<[[f64; 2]; 3]> = (0..4)
            .map(|k| [[4.3, 4.7], square[k], square[(k + 1) % 4]])
            .collect();
        let found = wholes(&fan);
        let expected: Vec<u16> = (3..6)
            .flat_map(|y| (3..6).map(move |x| y * 16 + x))
            .collect();
        assert_eq!(
            found.iter().map(|(texel, _)| *texel).collect::<Vec<_>>(),
            expected
        );
        assert_eq!(
            found.iter().find(|(texel, _)| *texel == 4 * 16 + 4),
            Some(&(68, 4))
        );
        // Without one of them only what the others cover is.
        assert!(wholes(&fan[1..]).len() < expected.len());
    }

    #[test]
    fn texels_of_too_many_triangles_are_not_whole() {
        let fan = |count: usize| -> Vec<[[f64; 2]; 3]> {
            let at = |k: usize| {
                let (sin, cos) = f64::sin_cos(k as f64 / count as f64 * std::f64::consts::TAU);
                [4.5 + 2.0 * cos, 4.5 + 2.0 * sin]
            };
            (0..count).map(|k| [[4.5, 4.5], at(k), at(k + 1)]).collect()
        };
        let held = |count| {
            wholes(&fan(count))
                .iter()
                .find(|(texel, _)| *texel == 68)
                .copied()
        };
        assert_eq!(held(MOST_HELD), Some((68, MOST_HELD as u32)));
        assert_eq!(held(MOST_HELD + 1), None);
    }

    #[test]
    fn a_gap_an_overlap_and_another_object_are_not_whole() {
        let square = |x: f64| {
            let [a, b, c, d] = [[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]];
            [[a, b, c], [a, c, d]]
        };
        assert_eq!(wholes(&square(0.0)), [(0, 2)]);
        assert_eq!(wholes(&square(1e-6)), []);
        let twice: Vec<_> = square(0.0).into_iter().chain(square(0.0)).collect();
        assert_eq!(wholes(&twice), []);
        let halves = square(3.0).map(|corners| corners.map(DVec2::from));
        let of_two = Wholes::of([0, 0, 16], halves.into_iter(), |number| {
            (number as u32, true)
        });
        assert_eq!(of_two.held(3), None);
    }

    #[test]
    fn areas_are_those_of_random_triangles() {
        let mut state = 9u32;
        let mut roll = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        let place = Place::new(0, 0, 16);
        for _ in 0..200 {
            let p = place.local([0, 1, 2].map(|_| DVec2::new(roll(), roll()) * 14.0 + 1.0));
            let covered = Covered::by(&[p]);
            let (mut sum, mut met) = (0.0, [0; EDGE]);
            for (row, growth) in covered.growth.iter().enumerate() {
                let mut area = 0.0;
                for (column, growth) in growth.iter().enumerate().take(EDGE) {
                    area += growth;
                    sum += area;
                    met[row] |= u16::from(area > 1e-12) << column;
                }
            }
            let off = sum - 0.5 * twice_area(p);
            assert!(off.abs() < 1e-12, "{p:?}: {off}");
            assert_eq!(place.met(p).mask, met, "{p:?}");
        }
    }

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
        let place = Place::new(0, 0, 16);
        let folded = [[a, b, c], place.local([a, b, c - DVec2::new(0.5, 0.0)])];
        let twice = borders(&folded).into_iter().filter(|edge| edge.1 == 2.0);
        assert_eq!(twice.count(), 1);
    }
}
