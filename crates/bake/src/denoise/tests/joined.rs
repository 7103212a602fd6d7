//! Charts that abut, those that bend, and those that are fitted in bands.

use super::*;

#[test]
fn charts_that_abut_are_fitted_as_one() {
    let side = |x: usize, _: usize| f32::from(u8::from(x >= SIZE / 2));
    let truth = |x: f64, y: f64| 0.5 + 0.3 * (5.0 * x).sin() * (4.0 * y).cos();
    let (mut apart, mut joined, mut alone, mut whole) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..4 {
        let made_of = |object: &dyn Fn(usize, usize) -> f32| made(seed, truth, |_, _| 0.05, object);
        let made = made_of(&side);
        let seam = seam([0, 1]);
        // The squared error of the two columns beside the seam, and how far they differ there beyond the truth.
        let beside = |values: &[f32]| {
            let error = |i: usize| f64::from(values[i]) - made.truth[i];
            let rows = (0..SIZE).map(|y| y * SIZE + SIZE / 2);
            rows.fold([0.0, 0.0], |[squares, steps], i| {
                let (a, b) = (error(i - 1), error(i));
                [squares + a * a + b * b, steps + (a - b) * (a - b)]
            })
        };
        let [squares, steps] = beside(&made.denoised().0);
        (alone, apart) = (alone + squares, apart + steps);
        let [squares, steps] = beside(&made.denoised_by(&made.denoiser_across(&seam)).0);
        (whole, joined) = (whole + squares, joined + steps);
        // What one chart shows of both is nearly what charts show of each other.
        let one = beside(&made_of(&one_object).denoised().0)[0];
        assert!((0.8..1.25).contains(&(squares / one)), "{squares} of {one}");
    }
    assert!(whole < 0.7 * alone, "squares {whole} of {alone}");
    assert!(joined < 0.1 * apart, "steps {joined} of {apart}");
}

#[test]
fn what_depends_on_materials_stays_within_its_object() {
    let side = |x: usize, _: usize| f32::from(u8::from(x >= SIZE / 2));
    let made = made(5, |x, _| 0.2 + 0.3 * x, |_, _| 0.05, side);
    let (of_two, of_one) = (seam([0, 1]), seam([0, 0]));
    let alone = made.denoised().0;
    let differs = |seam: &[SeamPoint], crosses: bool| {
        let values = made.denoised_as(&made.denoiser_across(seam), crosses).0;
        made.covered().any(|i| values[i] != alone[i])
    };
    assert!(differs(&of_two, true) && differs(&of_one, false));
    assert!(!differs(&of_two, false));
}

#[test]
fn nothing_is_carried_beyond_a_border_that_no_seam_has() {
    // The second chart is the left part of the page's void side: the walk from the seam's end must not leave the page
    // or read the void.
    let side = |x: usize, _: usize| f32::from(u8::from(x >= SIZE - 2 * VOID));
    let made = made(6, |x, y| 0.2 + 0.3 * x * y, |_, _| 0.05, side);
    let mut seam = seam([0, 1]);
    for point in &mut seam {
        point.sides = [DVec2::new((SIZE - 2 * VOID) as f64, point.sides[0].y); 2];
    }
    let (values, std_errs) = made.denoised_by(&made.denoiser_across(&seam));
    let finite = |i: usize| values[i].is_finite() && std_errs[i].is_finite();
    assert!(made.covered().all(finite));
}

/// Bends the square into waves of 8 texels from left to right, which turn by 20 degrees to either side and are as high
/// as such waves are.
fn bend(made: &mut Made) {
    for i in made.covered().collect::<Vec<_>>() {
        let phase = std::f32::consts::TAU * (i % SIZE) as f32 / 8.0;
        let (sin, cos) = (0.35 * phase.sin()).sin_cos();
        made.normal[0][i] = sin;
        made.normal[1][i] = cos;
        made.position[1][i] = 0.35 * 8.0 / std::f32::consts::TAU * phase.cos();
    }
}

#[test]
fn light_that_follows_the_normals_or_the_height_of_a_bent_chart_keeps_little_noise() {
    // What changes within 8 texels, no window of 4 can follow that has less noise than a third.
    let wave = |x: f64| std::f64::consts::TAU * x * SIZE as f64 / 8.0;
    let facing = |x: f64, y: f64| 0.4 + 0.2 * y + (0.35 * wave(x).sin()).sin();
    let standing_out = |x: f64, y: f64| 0.4 + 0.2 * y + 0.3 * wave(x).cos();
    for (name, truth) in [
        ("normals", &facing as &dyn Fn(f64, f64) -> f64),
        ("height", &standing_out),
    ] {
        let mut made = made(3, truth, |_, _| 0.05, one_object);
        let [plain, flat, ..] = made.judged();
        bend(&mut made);
        let [_, bent, stated, covered] = made.judged();
        assert!(
            flat > 0.4 * plain && bent < 0.15 * plain,
            "{name}: {bent}, {flat} of {plain}"
        );
        // 8,832 texels tell squared biases of 2 % of the plain variance from chance; those here are as large as that.
        assert!(
            (0.7 * bent..2.0 * bent).contains(&stated) && covered > 0.9,
            "{name}: stated {stated}, true {bent}, {covered} covered"
        );
        let (values, _) = made.denoised();
        let count = made.covered().count() as f64;
        let moved = |i: usize| f64::from(values[i] - made.mean[i]) / count;
        let moved = made.covered().map(moved).sum::<f64>();
        let of_mean = plain / count.sqrt();
        assert!(
            moved.abs() < of_mean / 3.0,
            "{name}: the mean by {moved}, known to {of_mean}"
        );
    }
}

#[test]
fn light_that_does_not_follow_the_normals_of_a_bent_chart_is_no_worse_for_them() {
    // A shadow's edge across the waves.
    let truth = |x: f64, y: f64| if x + 0.3 * y > 0.6 { 0.7 } else { 0.2 };
    let mut made = made(8, truth, |_, _| 0.05, one_object);
    let flat = made.judged()[1];
    bend(&mut made);
    let bent = made.judged()[1];
    assert!(bent < 1.1 * flat, "{bent}, {flat} where it is flat");
}

/// A chart too large to be fitted at once is fitted in bands of 32 rows here, of which the middle one ends in the
/// chart.
#[test]
fn a_chart_in_bands_is_denoised_as_a_whole_one() {
    let mut made = made(
        7,
        |x, y| wall(x * y, 0.3),
        |x, _| 0.02 + 0.1 * x,
        one_object,
    );
    for is_bent in [false, true] {
        if is_bent {
            bend(&mut made);
        }
        bands_change_nothing(&made);
    }
}

fn bands_change_nothing(made: &Made) {
    let (values, std_errs) = made.denoised();
    let mut denoiser = made.denoiser();
    denoiser.at_a_time = 32 * (SIZE - VOID);
    let bands = denoiser.charts.charts[0].area.bands(denoiser.at_a_time);
    assert_eq!(bands.len(), 3);
    let (in_bands, errs_in_bands) = made.denoised_by(&denoiser);
    // But for how much less noise the fits of a band have than all that it is fitted to.
    let rms = |of: &dyn Fn(usize) -> f32| made.rms(|i| f64::from(of(i)));
    let moved = rms(&|i| values[i] - in_bands[i]) / rms(&|i| values[i] - made.truth[i] as f32);
    let stated = rms(&|i| std_errs[i] - errs_in_bands[i]) / rms(&|i| std_errs[i]);
    assert!(
        moved < 0.1 && stated < 0.1,
        "{moved} of the error, {stated} of the stated one"
    );
}
