//! Single bright texels, patches of them and lines: which are detail, and which grain.

use super::{SIZE, made, one_object};
use rays::Mix;

#[test]
fn a_lonely_bright_ray_in_the_dark_is_no_detail() {
    // One half of one texel saw light: its mean and half difference are as large.
    let mut made = made(3, |_, _| 0.01, |_, _| 0.004, one_object);
    let spot = 50 * SIZE + 40;
    (made.mean[spot], made.half[spot]) = (0.07, 0.06);
    let (values, _) = made.denoised();
    assert!(values[spot] < 0.03, "{}", values[spot]);
}

#[test]
fn two_rays_that_both_halves_have_by_chance_leave_no_patch_of_grain() {
    let noise = 0.0011;
    let mut made = made(15, |x, _| 0.005 + 0.001 * x, |_, _| noise, one_object);
    let (at, before) = (48 * SIZE + 40, made.rms(|i| f64::from(made.mean[i])));
    assert!(before < 0.006, "{before}");
    // Each texel chooses its own fit, so a little is always moved.
    let sum = |values: &[f32]| {
        values
            .iter()
            .map(|&v| f64::from(v))
            .filter(|v| v.is_finite())
            .sum::<f64>()
    };
    let anyway = sum(&made.denoised().0) - sum(&made.mean);
    made.mean[at] = 0.036;
    made.half[at] = 0.0002;
    let (values, _) = made.denoised();
    let about =
        || (-5..=5).flat_map(|y| (-5..=5).map(move |x| (at as i32 + y * SIZE as i32 + x) as usize));
    let shared = 0.0305 / 121.0;
    let error = |i: usize| (f64::from(values[i]) - made.truth[i] - shared).abs();
    let worst = about().map(error).fold(0.0, f64::max);
    assert!(worst < 0.5 * noise, "{worst}");
    let moved = sum(&values) - sum(&made.mean) - anyway;
    assert!(moved.abs() < 0.0305 / 3.0, "no light is lost: {moved}");
}

#[test]
fn a_stray_beside_what_is_bright_becomes_as_dark_as_those_about_it() {
    let step = |x: f64, _: f64| if x < 40.0 / 96.0 { 0.4 } else { 0.0005 };
    let mut made = made(18, step, |x, y| 0.02 * step(x, y), one_object);
    let at = 48 * SIZE + 42;
    made.mean[at] = 0.05;
    made.half[at] = 0.0002;
    let value = made.denoised().0[at];
    assert!(value < 0.005, "{value}");
}

#[test]
fn bright_texels_that_others_are_like_stay() {
    // Two side by side, one of less than twice the light, and one that leads a row.
    for also in [1, SIZE] {
        let mut made = made(16, |_, _| 0.2, |_, _| 0.001, one_object);
        let at = 48 * SIZE + 40;
        (made.mean[at], made.mean[at + also]) = (0.7, 0.5);
        let (values, _) = made.denoised();
        assert!(values[at] > 0.68 && values[at + also] > 0.48);
    }
    let mut made = made(17, |_, _| 0.2, |_, _| 0.001, one_object);
    made.mean[48 * SIZE + 40] = 0.38;
    assert!(made.denoised().0[48 * SIZE + 40] > 0.36);
}

#[test]
fn a_line_of_light_leaves_no_band_of_grain_and_keeps_its_light() {
    // Two rows at the edge of a chart, and one that ends in it.
    let (noise, bright) = (0.002, 0.24);
    let lies = |x: usize, y: usize| y < 2 || (x == 30 && y > 20);
    let of = |place: f64| (place * SIZE as f64).round() as usize;
    let line = |x: f64, y: f64| f64::from(u8::from(lies(of(x), of(y))));
    let made = made(
        21,
        |x, y| 0.01 + 0.005 * x * y + bright * line(x, y),
        |x, y| noise * (1.0 + line(x, y)),
        one_object,
    );
    let (values, std_errs) = made.denoised();
    let on_line = |i: &usize| lies(i % SIZE, i / SIZE);
    for i in made.covered().filter(on_line) {
        assert_eq!((values[i], std_errs[i]), (made.mean[i], made.std_err[i]));
    }
    let beside = |i: &usize| !on_line(i) && ((i % SIZE).abs_diff(30) < 8 || i / SIZE < 10);
    let beside: Vec<usize> = made.covered().filter(beside).collect();
    let squares = beside
        .iter()
        .map(|&i| (f64::from(values[i]) - made.truth[i]).powi(2));
    let rms = (squares.sum::<f64>() / beside.len() as f64).sqrt();
    assert!(rms < 0.3 * noise, "{rms}");
}

#[test]
fn two_rays_that_are_stopped_by_chance_leave_no_dark_texel() {
    // Eight rays each of a bright wall, of which one in eighty is stopped: some texels lose one in either half.
    let (rays, stopped) = (4, 0.013);
    let mut made = made(21, |_, _| 1.0 - 0.013, |_, _| 0.04, one_object);
    let mut mix = Mix(22);
    let mut half = || (0..rays).filter(|_| mix.unit() >= stopped).count() as f32 / rays as f32;
    for texel in 0..SIZE * SIZE {
        let halves = [half(), half()];
        made.mean[texel] = 0.5 * (halves[0] + halves[1]);
        made.half[texel] = 0.5 * (halves[0] - halves[1]);
    }
    let darkest = |values: &[f32]| made.covered().map(|i| values[i]).fold(1.0, f32::min);
    let both = made
        .covered()
        .filter(|&i| made.mean[i] < 0.8 && made.half[i] == 0.0);
    assert!(both.count() > 5 && darkest(&made.mean) <= 0.75);
    let (values, _) = made.denoised();
    assert!(darkest(&values) > 0.9, "{}", darkest(&values));
}
