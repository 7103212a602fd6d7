//! Which texels of a tile triangles cover wholly, found without cutting them.
//!
//! The area of a triangle in every texel of a row follows from its edges alone, as when glyphs are filled: each edge
//! adds what lies to its right.

use crate::types::TILE;
use crate::uv::twice_area;
use glam::DVec2;
use std::ops::Range;

const EDGE: usize = TILE as usize;

/// A texel counts as covered wholly where its area is off by no more than this, in texels: far above rounding.
const SLACK: f64 = 1e-9;

/// Less than this of a texel is the rounding of an edge that runs along its border.
const SLIVER: f64 = 1e-12;

/// Triangles that a whole texel holds at most. A point is looked for among all of them, and among pieces by halves: from
/// a few dozen on these take less time.
pub const MOST_HELD: usize = 24;

/// Triangles of a tile from which on its texels are not asked: most would hold too many.
const CROWD: usize = EDGE * EDGE * MOST_HELD / 3;

/// A triangle that a whole texel holds, uncut.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Held {
    /// Its place in [`Tile::triangles`](crate::Tile::triangles) and in [`Tile::weights`](crate::Tile::weights).
    pub number: u32,
    /// Its share of the texel, 0..=1.
    pub share: f32,
}

/// What the triangles of a tile cover.
pub(crate) struct Cover {
    origin: DVec2,
    width: usize,
    height: usize,
    /// Covered area of each texel, row-major.
    areas: [f64; EDGE * EDGE],
    /// Row by row by how much the area of one triangle grows from each texel to the next; 0 between two triangles.
    growth: [[f64; EDGE + 1]; EDGE],
    parts: Parts,
}

/// The texels that each triangle has a part of, row-major, with their areas.
#[derive(Default)]
struct Parts {
    all: Vec<(u8, f32)>,
    /// Where each triangle's end.
    ends: Vec<usize>,
}

/// Texels that are covered wholly, and the triangles of each.
pub(crate) struct Wholes {
    /// Where the triangles of each texel begin in one list of them all; of texels that are not whole, none.
    starts: [u32; EDGE * EDGE + 1],
    /// How many of each texel's have been placed.
    placed: [u32; EDGE * EDGE],
    parts: Parts,
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

impl Parts {
    /// Those of a triangle.
    fn of(&self, number: usize) -> &[(u8, f32)] {
        let start = number.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.all[start..self.ends[number]]
    }
}

impl Cover {
    /// Of the tile whose first texel is here, on a page of this edge.
    pub fn new(x0: u32, y0: u32, page_size: u32) -> Self {
        let left = |start: u32| TILE.min(page_size - start) as usize;
        Self {
            origin: DVec2::new(x0.into(), y0.into()),
            width: left(x0),
            height: left(y0),
            areas: [0.0; EDGE * EDGE],
            growth: [[0.0; EDGE + 1]; EDGE],
            parts: Parts::default(),
        }
    }

    /// Adds the next triangle, by its corners in texels of the page.
    pub fn add(&mut self, corners: [DVec2; 3]) {
        let p = corners.map(|corner| corner - self.origin);
        let low = p[0].min(p[1]).min(p[2]);
        let high = p[0].max(p[1]).max(p[2]);
        let rows = whole(low.y, high.y, self.height);
        let columns = whole(low.x, high.x, self.width);
        let turn = twice_area(p).signum();
        for (a, b) in [(p[0], p[1]), (p[1], p[2]), (p[2], p[0])] {
            let (sign, top, bottom) = if b.y > a.y {
                (-turn, a, b)
            } else {
                (turn, b, a)
            };
            let slope = (bottom.x - top.x) / (bottom.y - top.y);
            for row in rows.clone() {
                let from = top.y.max(row as f64);
                let to = bottom.y.min(row as f64 + 1.0);
                if to <= from {
                    continue;
                }
                let at = |y: f64| match y {
                    _ if y == top.y => top.x,
                    _ if y == bottom.y => bottom.x,
                    _ => top.x + slope * (y - top.y),
                };
                let [left, right] = [at(from), at(to)];
                let ends = (left.min(right), left.max(right));
                edge(&mut self.growth[row], ends, sign * (to - from));
            }
        }
        for row in rows {
            let mut area = 0.0;
            for column in columns.clone() {
                area += self.growth[row][column];
                if area > SLIVER {
                    let texel = row * EDGE + column;
                    self.areas[texel] += area;
                    self.parts.all.push((texel as u8, area as f32));
                }
            }
            self.growth[row][columns.start.min(columns.end)..=columns.end].fill(0.0);
        }
        self.parts.ends.push(self.parts.all.len());
    }

    /// The texels that are covered wholly and once, by [`MOST_HELD`] triangles of one object at most that may all be held
    /// uncut: of each triangle its instance, and whether it may.
    pub fn wholes(self, triangle: impl Fn(usize) -> (u32, bool)) -> Wholes {
        let is_whole = |area: f64| (area - 1.0).abs() <= SLACK;
        let mut counts = self
            .areas
            .map(|area| if is_whole(area) { 0 } else { u32::MAX });
        let mut objects = [0; EDGE * EDGE];
        for number in 0..self.parts.ends.len() {
            let (object, is_kept) = triangle(number);
            for &(texel, _) in self.parts.of(number) {
                let texel = usize::from(texel);
                let count = &mut counts[texel];
                let is_one = *count == 0 || objects[texel] == object;
                *count = match *count {
                    count if count < MOST_HELD as u32 && is_one && is_kept => count + 1,
                    _ => u32::MAX,
                };
                objects[texel] = object;
            }
        }
        let mut wholes = Wholes {
            parts: self.parts,
            ..Wholes::none()
        };
        for (texel, &count) in counts.iter().enumerate() {
            let own = if count == u32::MAX { 0 } else { count };
            wholes.starts[texel + 1] = wholes.starts[texel] + own;
        }
        wholes
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
            parts: Parts::default(),
            next: 0,
        }
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
    pub fn place(&mut self, number: u32, list: &mut [Held]) -> Met {
        let mut met = Met {
            is_held: false,
            is_cut: self.parts.ends.is_empty(),
        };
        if met.is_cut {
            return met;
        }
        for &(texel, share) in self.parts.of(self.next) {
            let texel = usize::from(texel);
            if self.starts[texel] == self.starts[texel + 1] {
                met.is_cut = true;
                continue;
            }
            list[(self.starts[texel] + self.placed[texel]) as usize] = Held { number, share };
            self.placed[texel] += 1;
            met.is_held = true;
        }
        self.next += 1;
        met
    }
}

/// Whole numbers below `count` in whose unit intervals an interval has more than an end.
fn whole(low: f64, high: f64, count: usize) -> Range<usize> {
    if low < high {
        // Casts cut off, and leave out what lies below 0.
        let high = high.min(count as f64);
        let last = high as usize;
        (low as usize)..last + usize::from(high > last as f64)
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
fn edge(row: &mut [f64; EDGE + 1], (left, right): (f64, f64), height: f64) {
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
        let mut cover = Cover::new(32, 16, 1024);
        for corners in triangles {
            cover.add(corners.map(|[x, y]| DVec2::new(32.0 + x, 16.0 + y)));
        }
        let wholes = cover.wholes(|_| (7, true));
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
        let mut cover = Cover::new(0, 0, 16);
        let halves = square(3.0).map(|corners| corners.map(DVec2::from));
        halves.iter().for_each(|&corners| cover.add(corners));
        let of_two = cover.wholes(|number| (number as u32, true));
        assert_eq!(of_two.held(3), None);
    }

    #[test]
    fn areas_are_those_of_random_triangles() {
        let mut state = 9u32;
        let mut roll = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        for _ in 0..200 {
            let mut cover = Cover::new(0, 0, 16);
            let p = [0, 1, 2].map(|_| DVec2::new(roll(), roll()) * 14.0 + 1.0);
            cover.add(p);
            let sum: f64 = cover.areas.iter().sum();
            assert!(cover.growth.iter().flatten().all(|growth| *growth == 0.0));
            assert!(
                (sum - 0.5 * twice_area(p).abs()).abs() < 1e-12,
                "{p:?}: {sum}"
            );
        }
    }
}
