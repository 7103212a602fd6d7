//! Kernels as a picture that shaders look up.

use super::basis::{Basis, pair, pairs};
use super::kernel::{Lobe, angle, kernel};

/// Columns: equal steps of the angle from 0 to 90 degrees.
pub const COLUMNS: usize = 49;

/// Rows of one harmonic: quarter octaves of n + 1 from 1 to 256, or steps of 1/32 of the roughness from 0 to 1.
pub const ROWS: usize = 33;

/// The kernels of one family of lobes up to an order: blocks of [`ROWS`] rows, one for each [`pair`], of [`COLUMNS`]
/// values each.
#[derive(Debug, Clone, PartialEq)]
pub struct KernelTable {
    /// The order.
    pub order: usize,
    /// Row after row from the top.
    pub values: Vec<f32>,
}

/// The row of a block that holds a lobe, `0.0..=32.0`, to be met between rows: 4 log2(n + 1), or 32 times the roughness
/// √α.
pub fn row_of(lobe: Lobe) -> f64 {
    let row = match lobe {
        Lobe::Phong(exponent) => 4.0 * (exponent + 1.0).log2(),
        Lobe::Ggx(alpha) => 32.0 * alpha.sqrt(),
    };
    row.clamp(0.0, (ROWS - 1) as f64)
}

impl KernelTable {
    /// The table of Phong lobes, or of GGX where `microfacets`.
    pub fn new(order: usize, microfacets: bool) -> Self {
        let basis = Basis::new();
        let blocks = pairs(order).count();
        let mut values = vec![0.0; blocks * ROWS * COLUMNS];
        for row in 0..ROWS {
            let lobe = match microfacets {
                false => Lobe::Phong((0.25 * row as f64).exp2() - 1.0),
                true => Lobe::Ggx((row as f64 / 32.0).powi(2)),
            };
            for column in 0..COLUMNS {
                let kernel = kernel(&basis, lobe, angle(column, COLUMNS));
                for block in 0..blocks {
                    values[(block * ROWS + row) * COLUMNS + column] = kernel[block] as f32;
                }
            }
        }
        Self { order, values }
    }

    /// Columns of the picture.
    pub fn columns(&self) -> usize {
        COLUMNS
    }

    /// What a bilinear look-up finds for a pair (l, m) at an angle in radians and a row.
    pub fn look_up(&self, l: usize, m: usize, theta: f64, row: f64) -> f64 {
        let x = (theta / angle(1, COLUMNS)).clamp(0.0, (COLUMNS - 1) as f64);
        let (column, u) = (x.floor().min((COLUMNS - 2) as f64), x);
        let (u, first) = (u - column, row.floor().min((ROWS - 2) as f64));
        let v = row - first;
        let at = |row: f64, column: f64| {
            let row = pair(l, m) * ROWS + row as usize;
            f64::from(self.values[row * COLUMNS + column as usize])
        };
        let along = |row| (1.0 - u) * at(row, column) + u * at(row, column + 1.0);
        (1.0 - v) * along(first) + v * along(first + 1.0)
    }
}
