//! Eight numbers that are computed with alike. Loops over them become vectors, whose lanes hold the same bits on every
//! processor. They are written out as loops, since closures over arrays are not always inlined where vectors are wide.

use std::ops::{Add, AddAssign, Mul, Sub};

/// How many there are.
pub(super) const LANES: usize = 8;

#[derive(Debug, Clone, Copy)]
pub(super) struct Lanes(pub [f32; LANES]);

impl Lanes {
    pub const ZERO: Self = Self([0.0; LANES]);

    /// Those of a row from `at` on.
    #[inline(always)]
    pub fn load(row: &[f32], at: usize) -> Self {
        let mut lanes = Self::ZERO;
        lanes.0.copy_from_slice(&row[at..at + LANES]);
        lanes
    }

    /// Those of a row from `at` on at even and at odd places; 0 beyond its end.
    #[inline(always)]
    pub fn load_pairs(row: &[f32], at: usize) -> [Self; 2] {
        let mut both = [0.0; 2 * LANES];
        match row.get(at..at + 2 * LANES) {
            Some(row) => both.copy_from_slice(row),
            None => {
                let rest = row.get(at..).unwrap_or_default();
                both[..rest.len()].copy_from_slice(rest);
            }
        }
        let mut pairs = [Self::ZERO; 2];
        for lane in 0..LANES {
            pairs[0].0[lane] = both[2 * lane];
            pairs[1].0[lane] = both[2 * lane + 1];
        }
        pairs
    }

    #[inline(always)]
    pub fn store(self, row: &mut [f32], at: usize) {
        row[at..at + LANES].copy_from_slice(&self.0);
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        for lane in 0..LANES {
            self.0[lane] += other.0[lane];
        }
        self
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        for lane in 0..LANES {
            self.0[lane] -= other.0[lane];
        }
        self
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for lane in 0..LANES {
            self.0[lane] *= other.0[lane];
        }
        self
    }
}

impl Mul<f32> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, by: f32) -> Self {
        for lane in 0..LANES {
            self.0[lane] *= by;
        }
        self
    }
}
