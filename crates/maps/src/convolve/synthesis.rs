//! From spherical harmonics to pictures.

use super::grid::Grid;
use super::legendre::{Legendre, diagonal};
use super::rings::Series;
use environment::{Image, Projection};
use fourier::Complex;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Σ zonal_l I_lm Y_lm at the centres of texels.
///
/// The result of a non-negative map and lobe is not negative but for the rounding of the sum, which is set to 0.
pub(super) fn synthesise(
    series: &Series,
    zonal: &[f64],
    projection: Projection,
    size: (usize, usize),
) -> Image {
    if projection != Projection::Polar {
        let order = zonal.len() - 1;
        let (width, height) = Grid::size(order);
        let grid = Grid {
            width,
            height,
            values: polar(series, zonal, (width, height)),
        };
        return grid.gather(projection, size);
    }
    let values = polar(series, zonal, size);
    Image {
        width: size.0,
        height: size.1,
        pixels: values
            .into_iter()
            .map(|v| v.map(|v| v.max(0.0) as f32))
            .collect(),
    }
}

/// Values at the centres of a polar picture's texels.
fn polar(series: &Series, zonal: &[f64], (width, height): (usize, usize)) -> Vec<[f64; 3]> {
    let order = zonal.len() - 1;
    assert!(order <= series.order, "{order} {}", series.order);
    let half = height.div_ceil(2);
    let angles = (0..half).map(|j| ((j as f64 + 0.5) * PI / height as f64).sin_cos());
    let (sin, cos): (Vec<f64>, Vec<f64>) = angles.unzip();
    let first = diagonal(order);
    // `[m][row]`: sums of even and of odd l - m.
    let columns: Vec<Vec<[[f64; 6]; 2]>> = (0..=order)
        .into_par_iter()
        .map(|m| {
            let mut p = Legendre::new(m, first[m], &cos, &sin);
            let mut rows = vec![[[0.0; 6]; 2]; half];
            for (l, coefficients) in (m..=order).zip(&series.values[m]) {
                let scaled = coefficients.map(|v| v * zonal[l]);
                for (row, p) in rows.iter_mut().zip(&p.current) {
                    for (sum, v) in row[(l - m) % 2].iter_mut().zip(&scaled) {
                        *sum += p * v;
                    }
                }
                p.step();
            }
            rows
        })
        .collect();
    let mut values = vec![[0.0; 3]; width * height];
    let fft = fourier::inverse(width);
    // e^{imφ} at the middle of the first texel.
    let turn = |m: usize| {
        let (sin, cos) = (m as f64 * (PI / width as f64 - PI)).sin_cos();
        Complex::new(cos, sin)
    };
    let turns: Vec<Complex<f64>> = (0..=order).map(turn).collect();
    values
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(j, row)| {
            let below = j >= half;
            let pair = if below { height - 1 - j } else { j };
            let mut bins = fft.make_input_vec();
            let mut channel = fft.make_output_vec();
            for c in 0..3 {
                bins.fill(Complex::default());
                for (m, turn) in turns.iter().enumerate() {
                    let [even, odd] = columns[m][pair];
                    let part = |k: usize| {
                        if below {
                            even[k] - odd[k]
                        } else {
                            even[k] + odd[k]
                        }
                    };
                    let value = Complex::new(part(2 * c), part(2 * c + 1)) * turn;
                    // A frequency beyond the row's highest shows up at a lower one.
                    let k = m % width;
                    if m == 0 {
                        bins[0] += value.re;
                    } else if k == 0 || 2 * k == width {
                        bins[k] += 2.0 * value.re;
                    } else if k < bins.len() {
                        bins[k] += value;
                    } else {
                        bins[width - k] += value.conj();
                    }
                }
                fft.process(&mut bins, &mut channel)
                    .expect("the lengths are the plan's own");
                for (value, v) in row.iter_mut().zip(&channel) {
                    value[c] = *v;
                }
            }
        });
    values
}
