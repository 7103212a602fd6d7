//! Which texels of a tile triangles cover wholly, found without cutting them.
//!
//! [`Covered`] tells which are covered; the triangles of each follow from three lines a row.

use crate::covered::{Covered, EDGE, Mask, whole};
use crate::types::TILE;
use crate::uv::twice_area;
use glam::DVec2;
use std::ops::Range;

/// Triangles that a whole texel holds at most. A point is looked for among all of them, and among pieces by halves:
/// from a few dozen on these take less time.
pub const MOST_HELD: usize = 24;

/// Triangles of a tile from which on its texels are not asked: most would hold too many.
const CROWD: usize = EDGE * EDGE * MOST_HELD / 3;

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
}
