//! Adaptive quadrature for exact answers without a closed form.

use ambient::quadrature::GAUSS_32;

/// Integral of `f` over `a..b`, halving the interval until the rule agrees with itself to rounding.
///
/// Place known peaks and kinks at `a` or `b`, where the nodes are dense. The error is absolute, relative to ∫|f|.
pub(super) fn adaptive(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let whole = sums(f, a, b);
    halve(f, [a, b], whole[0], whole[1], 24)
}

fn halve(f: &impl Fn(f64) -> f64, [a, b]: [f64; 2], whole: f64, scale: f64, depth: u32) -> f64 {
    let middle = 0.5 * (a + b);
    let (left, right) = (sums(f, a, middle), sums(f, middle, b));
    let sum = left[0] + right[0];
    let scale = scale.max(left[1] + right[1]);
    if depth == 0 || (sum - whole).abs() <= 8.0 * f64::EPSILON * scale {
        return sum;
    }
    halve(f, [a, middle], left[0], scale, depth - 1)
        + halve(f, [middle, b], right[0], scale, depth - 1)
}

/// The rule applied to `f` and to its magnitude.
fn sums(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> [f64; 2] {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let (mut sum, mut size) = (0.0, 0.0);
    for (x, w) in GAUSS_32 {
        let pair = [f(middle - half * x), f(middle + half * x)];
        sum += w * (pair[0] + pair[1]);
        size += w * (pair[0].abs() + pair[1].abs());
    }
    [half * sum, half.abs() * size]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_point_singularity_and_a_narrow_peak_are_resolved() {
        let root = adaptive(&f64::sqrt, 0.0, 1.0);
        assert!((root - 2.0 / 3.0).abs() < 1e-12, "{root}");
        let width = 1e-4;
        let peak = adaptive(&|x: f64| width / (width * width + x * x), 0.0, 1.0);
        assert!((peak - (1.0 / width).atan()).abs() < 1e-14, "{peak}");
    }
}
