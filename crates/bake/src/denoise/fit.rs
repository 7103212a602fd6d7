//! Least squares over a window: the weights with which its texels make up the centre's value.
//!
//! The value is modelled as a polynomial of the position in the centre's tangent plane plus a linear function of the
//! normal. The estimate at the centre is the polynomial's constant, a linear combination `sum l_j y_j` of the texels'
//! values; `l` depends on the geometry alone, so its variance follows from the texels' own.

use super::field::Field;
use super::window::{TEXELS, Window};
use ambient::Frame;
use glam::DVec3;

/// Functions of a regression: constant, position (2), normal (2), squares of the position (3).
pub(super) const TERMS: usize = 8;

/// Functions of the linear regression.
pub(super) const LINEAR: usize = 5;

/// A function whose part that the ones before it do not explain is below this share of its sum of squares is left out.
const DEPENDENT: f64 = 1e-3;

/// A turn of the normals whose sine's root mean square is below this is left out: it is rounding or tessellation.
const FLAT: f64 = 0.01;

/// The regression functions at the texels of a window.
pub(super) struct Design {
    rows: [[f64; TERMS]; TEXELS],
}

impl Design {
    pub fn new() -> Self {
        Self {
            rows: [[0.0; TERMS]; TEXELS],
        }
    }

    /// Evaluates the functions at the texels of `window`.
    pub fn fill(&mut self, field: &Field<'_>, window: &Window) {
        let centre = window.texels[0];
        let (origin, normal) = (field.position(centre), field.normal(centre));
        let frame = Frame::from_normal(normal);
        let (t, b) = (frame.to_world(DVec3::X), frame.to_world(DVec3::Y));
        // Positions in units of the first step, so that a scene's scale does not matter.
        let step = window
            .texels
            .get(1)
            .map_or(1.0, |&next| field.position(next).distance(origin));
        let scale = if step > 0.0 { 1.0 / step } else { 1.0 };
        for (row, &texel) in self.rows.iter_mut().zip(&window.texels) {
            let p = (field.position(texel) - origin) * scale;
            let n = field.normal(texel);
            let (u, v) = (p.dot(t), p.dot(b));
            *row = [1.0, u, v, n.dot(t), n.dot(b), u * u, u * v, v * v];
        }
    }

    /// Sums of products of the functions over the texels `from..to`, added to `sums`.
    pub fn accumulate(&self, from: usize, to: usize, sums: &mut [[f64; TERMS]; TERMS]) {
        for row in &self.rows[from..to] {
            for (line, &r) in sums.iter_mut().zip(row) {
                for (sum, &c) in line.iter_mut().zip(row) {
                    *sum += r * c;
                }
            }
        }
    }

    /// The weight of texel `j` of the window for the constants `c` of [`constant`].
    pub fn weight(&self, j: usize, c: &[f64; TERMS]) -> f64 {
        self.rows[j].iter().zip(c).map(|(x, c)| x * c).sum()
    }
}

/// The first column of the inverse of the leading `terms` of `sums`, functions that the earlier ones explain left out.
pub(super) fn constant(sums: &[[f64; TERMS]; TERMS], terms: usize) -> [f64; TERMS] {
    // Cholesky L L^T in place of the kept functions.
    let mut lower = [[0.0; TERMS]; TERMS];
    let mut kept = [false; TERMS];
    let count = sums[0][0];
    for i in 0..terms {
        for j in 0..i {
            if kept[j] {
                let dot: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
                lower[i][j] = (sums[i][j] - dot) / lower[j][j];
            }
        }
        let left = sums[i][i] - lower[i][..i].iter().map(|l| l * l).sum::<f64>();
        let floor = if i == 3 || i == 4 {
            count * FLAT * FLAT
        } else {
            0.0
        };
        kept[i] = left > DEPENDENT * sums[i][i] && left > floor;
        if kept[i] {
            lower[i][i] = left.sqrt();
        }
    }
    // L z = e0, then L^T c = z.
    let mut z = [0.0; TERMS];
    for i in (0..terms).filter(|&i| kept[i]) {
        let dot: f64 = (0..i).map(|k| lower[i][k] * z[k]).sum();
        z[i] = (f64::from(i == 0) - dot) / lower[i][i];
    }
    let mut c = [0.0; TERMS];
    for i in (0..terms).rev().filter(|&i| kept[i]) {
        let dot: f64 = (i + 1..terms).map(|k| lower[k][i] * c[k]).sum();
        c[i] = (z[i] - dot) / lower[i][i];
    }
    c
}
