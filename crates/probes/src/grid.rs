//! Even grids of probes in a box.

use glam::{DVec3, UVec3};

/// A box cut into cells that are alike; a probe stands in the middle of each, as texels do in a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// The corner with the least coordinates.
    pub low: DVec3,
    /// Edges of a cell.
    pub cell: DVec3,
    /// Cells along x, y and z, at least 1 each.
    pub counts: UVec3,
}

impl Grid {
    /// As many cells as cover a box, each `spacing` wide; what they stand out they share on both sides.
    pub fn of_spacing(low: DVec3, high: DVec3, spacing: f64) -> Grid {
        let counts = ((high - low) / spacing * (1.0 - 1e-9)).ceil();
        let counts = counts
            .max(DVec3::ONE)
            .min(DVec3::splat(f64::from(u32::MAX)));
        let size = counts * spacing;
        Grid {
            low: 0.5 * (low + high - size),
            cell: DVec3::splat(spacing),
            counts: counts.as_uvec3(),
        }
    }

    /// So many cells that fill a box.
    pub fn of_counts(low: DVec3, high: DVec3, counts: [u32; 3]) -> Grid {
        let counts = UVec3::from(counts);
        Grid {
            low,
            cell: (high - low) / counts.as_dvec3(),
            counts,
        }
    }

    /// How many cells there are.
    pub fn len(&self) -> u64 {
        let [x, y, z] = self.counts.to_array().map(u64::from);
        x.saturating_mul(y).saturating_mul(z)
    }

    /// True without cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Its edges.
    pub fn size(&self) -> DVec3 {
        self.cell * self.counts.as_dvec3()
    }

    /// The column, row and slice of a cell; x grows first, then y, then z.
    pub(crate) fn at(&self, index: usize) -> [usize; 3] {
        let [x, y, _] = self.counts.to_array().map(|n| n as usize);
        [index % x, index / x % y, index / x / y]
    }

    /// The middle of a cell.
    pub fn place(&self, index: usize) -> DVec3 {
        self.low + self.cell * DVec3::from(self.at(index).map(|n| n as f64 + 0.5))
    }

    /// The eight cells about a place with their weights, which add up to 1. Beyond the outermost probes the nearest
    /// count.
    pub fn taps(&self, place: DVec3) -> [(usize, f64); 8] {
        let last = (self.counts - UVec3::ONE).as_dvec3();
        let at = ((place - self.low) / self.cell.max(DVec3::splat(f64::MIN_POSITIVE)) - 0.5)
            .clamp(DVec3::ZERO, last);
        let (low, part) = (at.floor(), at - at.floor());
        let [x, y, _] = self.counts.to_array().map(|n| n as usize);
        std::array::from_fn(|corner| {
            let mut weight = 1.0;
            let cell: [usize; 3] = std::array::from_fn(|axis| {
                let step = f64::from((corner >> axis & 1) as u32);
                weight *= if step == 1.0 {
                    part[axis]
                } else {
                    1.0 - part[axis]
                };
                (low[axis] + step).min(last[axis]) as usize
            });
            (cell[0] + x * (cell[1] + y * cell[2]), weight)
        })
    }

    /// The cells that share a face with a cell.
    pub fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let counts = self.counts.to_array().map(|n| n as usize);
        let steps = [1, counts[0], counts[0] * counts[1]];
        let at = self.at(index);
        (0..6).filter_map(move |side| {
            let axis = side / 2;
            match side % 2 {
                0 => (at[axis] > 0).then(|| index - steps[axis]),
                _ => (at[axis] + 1 < counts[axis]).then(|| index + steps[axis]),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_cover_the_box_and_stand_out_evenly() {
        let grid = Grid::of_spacing(DVec3::ZERO, DVec3::new(4.0, 2.5, 0.0), 1.0);
        assert_eq!(grid.counts, UVec3::new(4, 3, 1));
        assert_eq!(grid.place(0), DVec3::new(0.5, 0.25, 0.0));
        assert_eq!(grid.place(11), DVec3::new(3.5, 2.25, 0.0));
        assert_eq!((grid.len(), grid.size()), (12, DVec3::new(4.0, 3.0, 1.0)));
    }

    #[test]
    fn taps_take_up_what_is_linear_and_neighbours_share_faces() {
        let grid = Grid::of_counts(DVec3::NEG_ONE, DVec3::new(3.0, 2.0, 4.0), [4, 3, 5]);
        let value = |place: DVec3| 1.0 + place.x - 2.0 * place.y + 0.5 * place.z;
        let place = DVec3::new(1.3, 0.4, 2.2);
        let taps = grid.taps(place);
        let found: f64 = taps.iter().map(|&(k, w)| w * value(grid.place(k))).sum();
        assert!((found - value(place)).abs() < 1e-12, "{found}");
        // Beyond the outermost probe, that one.
        let edge = grid.taps(DVec3::splat(-1.0));
        assert_eq!((edge[0], edge[7].1), ((0, 1.0), 0.0));
        let near = |k| grid.neighbours(k).collect::<Vec<_>>();
        assert_eq!(near(0), [1, 4, 12]);
        assert_eq!(near(17), [16, 18, 13, 21, 5, 29]);
    }
}
