//! Fits of what they can follow exactly, and what they leave as it is.

use super::*;

const EDGE: usize = 96;
const STRIDES: [usize; 5] = [2, 4, 8, 16, 32];

/// A surface with these numbers by column and row, and features where they are asked for.
fn surface(
    is_bent: bool,
    mask: impl Fn([usize; 2]) -> f32,
    value: impl Fn([usize; 2]) -> f32,
) -> Surface {
    let sheet = |planes: usize, of: &dyn Fn(usize, [usize; 2]) -> f32| {
        let mut sheet = Sheet::new([EDGE; 2], planes);
        for y in 0..EDGE {
            for plane in 0..planes {
                let row = sheet.row_mut(plane, y).iter_mut().enumerate();
                row.for_each(|(x, value)| *value = mask([x, y]) * of(plane, [x, y]));
            }
        }
        sheet
    };
    Surface {
        mask: sheet(1, &|_, _| 1.0),
        features: is_bent.then(|| sheet(FEATURES, &|plane, at| feature(plane, at))),
        data: sheet(2, &|plane, at| value(at) * (1 - 3 * plane as i32) as f32),
        leading: 1,
        errors: sheet(1, &|_, _| 0.0),
    }
}

fn feature(plane: usize, [x, y]: [usize; 2]) -> f32 {
    let (x, y) = (x as f32, y as f32);
    [
        (0.7 * x).sin(),
        (0.9 * y).cos(),
        (0.4 * x + 0.8 * y).sin(),
        (1.1 * x - y).cos(),
    ][plane]
}

/// Fits of one degree for each stride, with the largest difference from the data one stride or more inside of
/// the square.
fn fits(surface: &Surface, degree: usize) -> Vec<(usize, Sheet, f32)> {
    let mut fitter = Fitter::new(surface);
    let fit = |stride: usize| {
        let mut out = [0; 2].map(|_| Sheet::new([EDGE; 2], 2));
        let [quadratic, linear] = out.each_mut();
        fitter.fit(stride, [(degree == 0, quadratic), (degree == 1, linear)]);
        let [quadratic, linear] = out;
        let out = if degree == 0 { quadratic } else { linear };
        let inside = stride..EDGE - stride;
        let all = inside
            .clone()
            .flat_map(|y| inside.clone().map(move |x| [x, y]));
        let off = all.flat_map(|at| [0, 1].map(|k| (out.at(k, at) - surface.data.at(k, at)).abs()));
        let off = off.fold(0.0, f32::max);
        (stride, out, off)
    };
    STRIDES.map(fit).into()
}

#[test]
fn polynomials_and_features_are_their_own_fits_at_every_stride() {
    let place = |[x, y]: [usize; 2]| [x, y].map(|v| v as f32 / EDGE as f32);
    let plane = move |at: [usize; 2]| {
        let [u, v] = place(at);
        0.2 + 0.5 * u - 0.3 * v
    };
    let curved = move |at: [usize; 2]| {
        let [u, v] = place(at);
        plane(at) + 0.4 * u * u - 0.6 * u * v + 0.3 * v * v
    };
    let bent = move |at: [usize; 2]| {
        let features: f32 = (0..FEATURES)
            .map(|k| 0.1 * (k + 1) as f32 * feature(k, at))
            .sum();
        plane(at) + features
    };
    for (name, degree, surface) in [
        ("a quadratic", 0, surface(false, |_| 1.0, curved)),
        ("a plane", 1, surface(false, |_| 1.0, plane)),
        ("features", 1, surface(true, |_| 1.0, bent)),
    ] {
        for (stride, _, off) in fits(&surface, degree) {
            // Four texels, or sixteen, are fewer than what features need.
            let is_known = name != "features" || stride > 4;
            assert!(
                !is_known || off < 2e-4,
                "{name} by {off} at stride {stride}"
            );
        }
    }
}

#[test]
fn no_fit_moves_the_sum_of_what_it_is_fitted_to() {
    // A chart with a hole and a ragged border, and numbers without any order.
    let mask = |[x, y]: [usize; 2]| {
        let [a, b] = [x, y].map(|v| v as f32 - 40.0);
        let is_in = a.hypot(b) < 38.0 + 4.0 * (0.3 * b).sin() && (a - 9.0).hypot(b - 5.0) > 7.0;
        f32::from(u8::from(is_in))
    };
    let value = |[x, y]: [usize; 2]| ((x * 7919 + y * 104_729) % 1009) as f32 / 1009.0;
    for is_bent in [false, true] {
        let surface = surface(is_bent, mask, value);
        let sum = |sheet: &Sheet| -> f64 {
            let rows = (0..EDGE).flat_map(|y| sheet.row(0, y));
            rows.map(|value| f64::from(*value)).sum()
        };
        let truth = sum(&surface.data);
        for degree in [0, 1] {
            for (stride, out, _) in fits(&surface, degree) {
                // Rounding of some thousand numbers, in equations whose pivots are a thousandth of their
                // diagonal at least.
                let moved = sum(&out) / truth - 1.0;
                assert!(
                    moved.abs() < 2e-4,
                    "by {moved}, stride {stride}, degree {degree}"
                );
            }
        }
    }
}
