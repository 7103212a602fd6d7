//! What lies under a texel, and which part of it a point of the unit square chooses.
//!
//! Pieces that were cut to a texel stand side by side along the first coordinate, each as wide as its area. A texel
//! that triangles cover wholly holds them as they are, and the unit square is its own: a point lies in the triangle
//! whose least corner weight is the largest there, so that no crack between two of them is seen.

use super::cell::{Cell, Sample, Weights, place_in};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// Where points of a whole texel lie along either edge whose mean stands for that of its triangles: means of what lies
/// in one plane are exact by any number, and a mesh hardly bends within a texel.
const POINTS: [[f32; 4]; 2] = [[0.25, 0.75, 0.25, 0.75], [0.25, 0.25, 0.75, 0.75]];

/// All that lies under the texels of a tile.
#[derive(Debug, Default)]
pub(crate) struct Ground {
    pub cells: Vec<Cell>,
    /// The cells of triangles that texels hold whole, texel by texel.
    pub wholes: Vec<u32>,
}

/// The cells of a texel, never none: a part of those of its tile.
#[derive(Debug)]
pub(crate) struct Cells {
    of: Arc<Ground>,
    /// Into the cells of the tile, or of a whole texel into the list of those that it holds.
    own: Range<u32>,
    /// Column and row of a whole texel in its tile.
    whole: Option<[f32; 2]>,
}

/// Means over a texel.
pub(crate) struct Means {
    pub position: DVec3,
    pub normal: DVec3,
    pub geometric: DVec3,
    /// Squared scene units.
    pub area: f64,
}

/// Weights at a point of the square, perhaps outside of the triangle.
#[inline(always)]
fn at([a, b, c]: &Weights, u: [f32; 2]) -> [f32; 2] {
    [0, 1].map(|k: usize| a[k] + b[k] * u[0] + c[k] * u[1])
}

/// The least corner weight of a point with these weights of the second and third corner.
#[inline(always)]
fn least([s, t]: [f32; 2]) -> f32 {
    // The library's `min` minds what is no number, which takes several steps more.
    let lesser = if t < s { t } else { s };
    let first = 1.0 - s - t;
    if first < lesser { first } else { lesser }
}

impl Cells {
    /// Of a tile's cells; or of the list of those that whole texels hold, where the texel is such a one at this column
    /// and row of its tile.
    pub fn new(of: Arc<Ground>, own: Range<u32>, whole: Option<[f32; 2]>) -> Self {
        Self { of, own, whole }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.own.len()
    }

    /// True where the texel holds triangles whole.
    #[inline(always)]
    pub fn are_whole(&self) -> bool {
        self.whole.is_some()
    }

    fn all(&self) -> Range<usize> {
        self.own.start as usize..self.own.end as usize
    }

    /// The cell of a number.
    #[inline(always)]
    pub fn cell(&self, number: usize) -> &Cell {
        let at = self.own.start as usize + number;
        match self.whole {
            Some(_) => &self.of.cells[self.of.wholes[at] as usize],
            None => &self.of.cells[at],
        }
    }

    /// The weights of a triangle over a whole texel.
    #[inline(always)]
    pub fn weights(&self, number: usize) -> Weights {
        let [x, y] = self.whole.unwrap_or_default();
        let [a, b, c] = self.cell(number).weights;
        [[0, 1].map(|k: usize| a[k] + b[k] * x + c[k] * y), b, c]
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Cell> {
        (0..self.len()).map(|number| self.cell(number))
    }

    /// Corners about what the texel has of each.
    pub fn corners(&self) -> impl Iterator<Item = [DVec3; 4]> {
        (0..self.len()).map(|number| {
            let cell = self.cell(number);
            match self.whole {
                Some(_) => cell.corners_in(|u| at(&self.weights(number), u)),
                None => cell.corners(),
            }
        })
    }

    /// Where the cells end along the first coordinate of a point of the unit square, but for the last.
    pub fn ends(&self) -> impl ExactSizeIterator<Item = f32> {
        (1..self.len()).map(|number| self.cell(number).start)
    }

    /// The cell that a point of the unit square chooses, and where in it the point is.
    #[inline]
    pub fn place(&self, u: [f32; 2]) -> (usize, [f32; 2]) {
        if !self.are_whole() {
            let own = &self.of.cells[self.all()];
            let number = own[1..].partition_point(|cell| u[0] >= cell.start);
            return (number, place_in(own[number].placement(), u));
        }
        let (mut best, mut weights) = (0, at(&self.weights(0), u));
        for number in 1..self.len() {
            let others = at(&self.weights(number), u);
            if least(others) > least(weights) {
                (best, weights) = (number, others);
            }
        }
        (best, self.cell(best).kept(weights))
    }

    /// The surface at a point of the unit square.
    pub fn sample(&self, u: [f32; 2]) -> Sample {
        let (number, place) = self.place(u);
        self.cell(number).sample(place)
    }

    /// Means over the texel, by area. Where it holds several triangles, they are those of points that are spread evenly
    /// over it: where these triangles lie in one plane under one mapping, the mean position is exact.
    pub fn means(&self) -> Means {
        let mut means = Means {
            position: DVec3::ZERO,
            normal: DVec3::ZERO,
            geometric: DVec3::ZERO,
            area: 0.0,
        };
        let mut all = 0.0;
        let mut add = |sample: Sample, share: f64, area: f64| {
            means.position += sample.position * share;
            means.normal += sample.normal * share;
            means.geometric += sample.geometric * share;
            means.area += area;
            all += share;
        };
        if !self.are_whole() {
            for cell in self.iter() {
                add(cell.sample(cell.centre()), cell.area, cell.world_area());
            }
        } else if self.len() == 1 {
            let cell = self.cell(0);
            let middle = at(&self.weights(0), [0.5; 2]);
            add(cell.sample(middle), 1.0, cell.area);
        } else {
            for (number, place) in self.points() {
                let cell = self.cell(number as usize);
                add(cell.sample(place), 1.0, 0.25 * cell.area);
            }
        }
        means.position /= all;
        means
    }

    /// The triangles that hold the [`POINTS`], and the weights there.
    fn points(&self) -> [(u32, [f32; 2]); 4] {
        let (mut best, mut chosen, mut places) = ([f32::NEG_INFINITY; 4], [0; 4], [[0.0; 4]; 2]);
        for number in 0..self.len() {
            let [a, b, c] = self.weights(number);
            for k in 0..4 {
                let [s, t] =
                    [0, 1].map(|w: usize| a[w] + b[w] * POINTS[0][k] + c[w] * POINTS[1][k]);
                let inside = least([s, t]);
                let is_better = inside > best[k];
                best[k] = if is_better { inside } else { best[k] };
                chosen[k] = if is_better { number as u32 } else { chosen[k] };
                places[0][k] = if is_better { s } else { places[0][k] };
                places[1][k] = if is_better { t } else { places[1][k] };
            }
        }
        std::array::from_fn(|k| (chosen[k], [places[0][k], places[1][k]]))
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{self, patch, whole};
    use super::*;

    const UP: [f32; 3] = [0.0, 0.0, 1.0];

    /// A texel of an eighth of a unit whose diagonal parts the two triangles of a square.
    fn halves() -> Cells {
        let own = |x: f64, y: f64| [x, y];
        let other = |x: f64, y: f64| [1.0 - x, 1.0 - y];
        let across = fixture::patch_at([[1.0, 1.0], [0.0, 1.0], [1.0, 0.0]], [UP; 3]);
        whole(
            &[(patch([UP; 3]), &own), (across, &other)],
            ([0.4375; 2], 0.125),
        )
    }

    #[test]
    fn a_point_lies_in_the_triangle_that_holds_it_and_stays_off_its_edges() {
        let cells = halves();
        for (u, number) in [
            ([0.1, 0.2], 0),
            ([0.45, 0.5], 0),
            ([0.5, 0.55], 1),
            ([0.9, 0.8], 1),
        ] {
            let (found, [s, t]) = cells.place(u);
            assert_eq!(found, number, "{u:?}");
            let [x, y] = u.map(|u| 0.4375 + 0.125 * f64::from(u));
            let expected = if number == 0 {
                [x, y]
            } else {
                [1.0 - x, 1.0 - y]
            };
            let off = (f64::from(s) - expected[0]).hypot(f64::from(t) - expected[1]);
            assert!(off < 1e-5, "{u:?}: {s} {t} {expected:?}");
            let least = cells.cell(number).least;
            assert!(least[0] > 0.0 && 1.0 - s - t >= 0.999 * least[0], "{u:?}");
        }
    }

    #[test]
    fn means_of_a_whole_texel_are_those_of_its_square() {
        let own = |x: f64, y: f64| [x, y];
        let tilted = [UP, [0.6, 0.0, 0.8], UP];
        let means = whole(&[(patch(tilted), &own)], ([0.125, 0.25], 0.0625)).means();
        assert!((means.position - DVec3::new(0.15625, 0.28125, 0.0)).length() < 1e-7);
        assert!(
            (means.area - 0.0625 * 0.0625).abs() < 1e-9,
            "{}",
            means.area
        );
        let normal = (DVec3::Z + 0.15625 * (DVec3::new(0.6, 0.0, 0.8) - DVec3::Z)).normalize();
        assert!((means.normal - normal).length() < 1e-6);
        // Of the halves of one square the areas add up, and their mean place is its middle.
        let both = halves().means();
        assert!((both.area - 0.125 * 0.125).abs() < 1e-9, "{}", both.area);
        assert!((both.position - DVec3::new(0.5, 0.5, 0.0)).length() < 1e-6);
    }

    #[test]
    fn corners_are_about_what_the_texel_has_and_not_about_the_triangle() {
        let reach = |corner: [f64; 2]| {
            let own = |x: f64, y: f64| [x, y];
            let cells = whole(&[(patch([UP; 3]), &own)], (corner, 0.01));
            let corners = cells.corners().flatten();
            corners.fold(0.0, |reach: f64, corner| {
                reach.max(corner.abs().max_element())
            })
        };
        assert!((reach([0.0; 2]) - 0.01).abs() < 1e-7);
        assert!((reach([0.9, 0.0]) - 0.91).abs() < 1e-7);
    }
}
