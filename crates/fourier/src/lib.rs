//! Fourier transforms of real rows of any length, in 64-bit numbers.
//!
//! A crate of its own because the planner of `realfft` is generic: whoever names its number type compiles all of its
//! transforms, which took a third of the time of `maps`, and twice as long with its tests.
#![forbid(unsafe_code)]

use realfft::RealFftPlanner;
use std::sync::Arc;

pub use realfft::num_complex::Complex;
pub use realfft::{ComplexToReal, RealToComplex};

/// From so many real numbers to the `length / 2 + 1` frequencies of e^(-i 2π k x / length), not scaled. Threads may
/// share the plan, not its scratch.
pub fn forward(length: usize) -> Arc<dyn RealToComplex<f64>> {
    RealFftPlanner::new().plan_fft_forward(length)
}

/// From frequencies back to so many real numbers, not scaled: after [`forward`] the row comes back `length` times.
pub fn inverse(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    RealFftPlanner::new().plan_fft_inverse(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_comes_back_so_many_times_itself() {
        for length in [1, 7, 36, 72] {
            let row: Vec<f64> = (0..length).map(|k| (k * k % 11) as f64 - 3.0).collect();
            let (to, from) = (forward(length), inverse(length));
            let (mut bins, mut back) = (to.make_output_vec(), from.make_output_vec());
            to.process(&mut row.clone(), &mut bins)
                .expect("lengths of the plan");
            assert!((bins[0].re - row.iter().sum::<f64>()).abs() < 1e-12);
            from.process(&mut bins, &mut back)
                .expect("lengths of the plan");
            for (a, b) in row.iter().zip(&back) {
                assert!((length as f64 * a - b).abs() < 1e-10, "{length}: {a} {b}");
            }
        }
    }
}
