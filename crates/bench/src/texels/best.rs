//! What a page of this density can hold at best: the texels whose bilinear reconstruction is closest to the truth.

use super::lit::taps;
use glam::DVec2;

/// Steps of the solver: many more than a page of a few thousand texels needs.
const STEPS: usize = 300;

/// The errors, value minus truth, that the least-squares page of `size`² texels leaves at (place, truth) pairs.
///
/// Conjugate gradients on the normal equations (M. R. Hestenes, E. Stiefel, "Methods of Conjugate Gradients for Solving
/// Linear Systems", 1952). Texels that no point reads stay 0 and do not matter.
pub(super) fn best_errors(size: u32, targets: &[(DVec2, f64)]) -> Vec<f64> {
    let size = size as usize;
    let rows: Vec<[(usize, f64); 4]> = targets.iter().map(|(p, _)| taps(size, *p)).collect();
    let forward = |x: &[f64]| -> Vec<f64> {
        let row = |taps: &[(usize, f64); 4]| taps.iter().map(|(t, w)| x[*t] * w).sum();
        rows.iter().map(row).collect()
    };
    let backward = |y: &[f64]| {
        let mut x = vec![0.0; size * size];
        for (taps, y) in rows.iter().zip(y) {
            for (texel, weight) in taps {
                x[*texel] += weight * y;
            }
        }
        x
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut left: Vec<f64> = targets.iter().map(|(_, truth)| *truth).collect();
    let mut gradient = backward(&left);
    let mut direction = gradient.clone();
    let mut power = dot(&gradient, &gradient);
    let enough = 1e-20 * power;
    for _ in 0..STEPS {
        if power <= enough {
            break;
        }
        let image = forward(&direction);
        let step = power / dot(&image, &image);
        for (left, image) in left.iter_mut().zip(&image) {
            *left -= step * image;
        }
        gradient = backward(&left);
        let next = dot(&gradient, &gradient);
        for (direction, gradient) in direction.iter_mut().zip(&gradient) {
            *direction = gradient + next / power * *direction;
        }
        power = next;
    }
    left.iter().map(|left| -left).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(f: impl Fn(DVec2) -> f64) -> Vec<(DVec2, f64)> {
        let at = |i: u32| 2.0 + 0.25 * (f64::from(i) + 0.5);
        let place = |i: u32| DVec2::new(at(i % 16), at(i / 16));
        (0..256).map(|i| (place(i), f(place(i)))).collect()
    }

    #[test]
    fn the_best_page_holds_planes_exactly_and_halves_the_error_of_parabolas() {
        let plane = best_errors(8, &grid(|p| 0.3 + 0.1 * p.x - 0.05 * p.y));
        let largest = |e: &[f64]| e.iter().fold(0.0f64, |m, e| m.max(e.abs()));
        assert!(largest(&plane) < 1e-8, "{}", largest(&plane));
        // Interpolation is off by up to 1/4 one way; the best page spreads that over both.
        let parabola = largest(&best_errors(8, &grid(|p| p.x * p.x)));
        assert!((0.05..0.17).contains(&parabola), "{parabola}");
    }
}
