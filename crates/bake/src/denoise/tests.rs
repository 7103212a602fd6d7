//! The denoiser on made charts: a square of texels with noise of a known size over a known truth.

mod limits;

use super::{Denoiser, Field, Term};
use crate::seams::SeamPoint;
use glam::{DVec2, Vec2};
use rays::Mix;

const SIZE: usize = 96;

/// Texels of the void on the right.
const VOID: usize = 4;

/// A flat square seen from above: what is true, and a mean and half difference of two independent halves.
struct Made {
    coverage: Vec<f32>,
    position: [Vec<f32>; 3],
    normal: [Vec<f32>; 3],
    object: Vec<f32>,
    truth: Vec<f64>,
    mean: Vec<f32>,
    half: Vec<f32>,
    std_err: Vec<f32>,
    /// What something seals; empty for nothing.
    sealed: Vec<f32>,
}

/// `sigma` is the noise of the mean; `truth` and `sigma` are functions of the column and row, 0..1.
fn made(
    seed: u64,
    truth: impl Fn(f64, f64) -> f64,
    sigma: impl Fn(f64, f64) -> f64,
    object: impl Fn(usize, usize) -> f32,
) -> Made {
    let mut mix = Mix(seed);
    let mut gauss = || (0..12).map(|_| mix.unit()).sum::<f64>() - 6.0;
    let mut made = Made {
        coverage: Vec::new(),
        position: Default::default(),
        normal: Default::default(),
        object: Vec::new(),
        truth: Vec::new(),
        mean: Vec::new(),
        half: Vec::new(),
        std_err: Vec::new(),
        sealed: Vec::new(),
    };
    for i in 0..SIZE * SIZE {
        let (x, y) = (i % SIZE, i / SIZE);
        // What lies in the void is poison: nothing may read it.
        let void = if x >= SIZE - VOID { f32::NAN } else { 0.0 };
        let at = [x, y].map(|place| place as f64 / SIZE as f64);
        let (truth, sigma) = (truth(at[0], at[1]), sigma(at[0], at[1]));
        let halves = [gauss(), gauss()].map(|g| truth + sigma * g * 2.0_f64.sqrt());
        made.coverage.push(if void.is_nan() { 0.0 } else { 1.0 });
        made.position[0].push(x as f32 + void);
        made.position[1].push(void);
        made.position[2].push(y as f32 + void);
        made.normal[0].push(void);
        made.normal[1].push(1.0 + void);
        made.normal[2].push(void);
        made.object.push(object(x, y) + void);
        made.truth.push(truth);
        made.mean
            .push((0.5 * (halves[0] + halves[1])) as f32 + void);
        made.half
            .push((0.5 * (halves[0] - halves[1])) as f32 + void);
        made.std_err.push(sigma as f32 + void);
    }
    made
}

impl Made {
    fn denoiser(&self) -> Denoiser<'static> {
        self.denoiser_across(&[])
    }

    fn denoiser_across<'a>(&self, seams: &'a [SeamPoint]) -> Denoiser<'a> {
        let field = Field {
            size: SIZE,
            coverage: &self.coverage,
            validity: None,
            position: [&self.position[0], &self.position[1], &self.position[2]],
            normal: [&self.normal[0], &self.normal[1], &self.normal[2]],
            object: &self.object,
        };
        Denoiser::new(&field, seams)
    }

    /// Values and standard errors after denoising.
    fn denoised(&self) -> (Vec<f32>, Vec<f32>) {
        self.denoised_by(&self.denoiser())
    }

    fn denoised_by(&self, denoiser: &Denoiser) -> (Vec<f32>, Vec<f32>) {
        self.denoised_as(denoiser, true)
    }

    /// `crosses`: the term does not depend on materials.
    fn denoised_as(&self, denoiser: &Denoiser, crosses: bool) -> (Vec<f32>, Vec<f32>) {
        let (mut values, mut std_errs) = (self.mean.clone(), self.std_err.clone());
        let term = Term {
            values: vec![&self.mean],
            halves: vec![&self.half],
            std_err: &self.std_err,
            sealed: (!self.sealed.is_empty()).then_some(&self.sealed[..]),
            largest: 1.0,
            is_smooth: true,
            crosses,
        };
        for part in denoiser.denoise(&term) {
            part.set_values(0, &mut values);
            part.set_errors(&mut std_errs);
        }
        (values, std_errs)
    }

    fn covered(&self) -> impl Iterator<Item = usize> {
        (0..SIZE * SIZE).filter(|&i| self.coverage[i] > 0.0)
    }

    /// Root mean square over the covered texels.
    fn rms(&self, of: impl Fn(usize) -> f64) -> f64 {
        let count = self.covered().count() as f64;
        (self.covered().map(|i| of(i) * of(i)).sum::<f64>() / count).sqrt()
    }

    /// RMSE plain, RMSE denoised, stated RMSE, share of the texels within 1.96 stated errors.
    fn judged(&self) -> [f64; 4] {
        let (values, std_errs) = self.denoised();
        let error = |i: usize| f64::from(values[i]) - self.truth[i];
        let inside = |&i: &usize| error(i).abs() <= 1.96 * f64::from(std_errs[i]);
        [
            self.rms(|i| f64::from(self.mean[i]) - self.truth[i]),
            self.rms(error),
            self.rms(|i| f64::from(std_errs[i])),
            self.covered().filter(inside).count() as f64 / self.covered().count() as f64,
        ]
    }
}

fn one_object(_: usize, _: usize) -> f32 {
    0.0
}

/// A wall of height `h` at the left edge of a floor: the diffuse term at the distance `d`.
fn wall(d: f64, h: f64) -> f64 {
    1.0 - 0.5 * (1.0 - d / (d * d + h * h).sqrt())
}

#[test]
fn a_slope_loses_five_sixths_of_its_noise() {
    let made = made(5, |x, y| 0.2 + 0.3 * x + 0.2 * y, |_, _| 0.02, one_object);
    let [plain, denoised, stated, covered] = made.judged();
    assert!(denoised < plain / 6.0, "{denoised} of {plain}");
    // A move is known from 121 texels to 0.18 of the variance that it saves; 0.2 of that, the mean of what stands out
    // by half of it, counts as bias although there is none: some 0.2 of the plain error is stated at least, and 0.3
    // beside the chart's borders.
    assert!(
        (denoised..0.3 * plain).contains(&stated) && covered > 0.93,
        "stated {stated}, true {denoised} of {plain}, {covered} covered"
    );
}

#[test]
fn contact_with_a_wall_keeps_its_slope_and_states_its_error() {
    for h in [0.02, 0.1, 0.5] {
        let made = made(7, |x, _| wall(x, h), |_, _| 0.02, one_object);
        let [plain, denoised, stated, covered] = made.judged();
        assert!(denoised < 0.5 * plain, "height {h}: {denoised} of {plain}");
        assert!(
            denoised / stated < 1.1 && stated < 0.6 * plain && covered > 0.93,
            "height {h}: true {denoised}, stated {stated} of {plain}, {covered} covered"
        );
        let (values, _) = made.denoised();
        let first = |of: &dyn Fn(usize) -> f64| (0..SIZE).map(|y| of(y * SIZE)).sum::<f64>() / 96.0;
        let lift = first(&|i| f64::from(values[i]) - made.truth[i]);
        assert!(lift.abs() < 0.01, "height {h}: the first column by {lift}");
    }
}

#[test]
fn an_isolated_contact_is_not_lifted() {
    let at = (40, 50);
    let spot = |x: f64, y: f64| {
        let is_spot = (x - 40.0 / 96.0).abs() < 1e-9 && (y - 50.0 / 96.0).abs() < 1e-9;
        if is_spot { 0.0 } else { 0.3 }
    };
    let noise = move |x: f64, y: f64| if spot(x, y) == 0.0 { 1e-6 } else { 0.02 };
    let made = made(3, spot, noise, one_object);
    let (values, _) = made.denoised();
    let value = values[at.1 * SIZE + at.0];
    assert!(value < 0.02, "{value} of 0 at the contact");
}

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
fn what_no_fit_can_smooth_states_the_plain_error() {
    // A chequerboard that stands out of its noise two hundredfold: every fit but the plain value is refused, and
    // that has no bias.
    let of = |place: f64| (place * SIZE as f64) as usize;
    let truth = |x: f64, y: f64| 0.3 + 0.4 * ((of(x) + of(y)) % 2) as f64;
    let made = made(9, truth, |_, _| 0.002, one_object);
    let [plain, denoised, stated, covered] = made.judged();
    assert!(
        (denoised / plain - 1.0).abs() < 0.01,
        "{denoised} of {plain}"
    );
    // 8,832 texels know a standard deviation to 1 %.
    assert!(
        (stated / plain - 1.0).abs() < 0.03 && (covered - 0.95).abs() < 0.01,
        "stated {stated} of {plain}, {covered} covered"
    );
}

#[test]
fn a_step_is_not_blurred() {
    let made = made(
        5,
        |x, _| if x < 0.5 { 0.2 } else { 0.8 },
        |_, _| 0.02,
        one_object,
    );
    let [plain, denoised, stated, covered] = made.judged();
    assert!(denoised < 0.5 * plain, "{denoised} of {plain}");
    assert!(
        (0.7..=1.6).contains(&(stated / denoised)) && covered > 0.93,
        "stated {stated}, true {denoised}, {covered} covered"
    );
}

#[test]
fn another_object_beside_is_never_mixed_in() {
    let side = |x: usize, _: usize| f32::from(u8::from(x >= SIZE / 2));
    let made = made(5, |x, _| if x < 0.5 { 0.2 } else { 0.8 }, |_, _| 0.02, side);
    let [plain, denoised, ..] = made.judged();
    assert!(denoised < 0.2 * plain, "{denoised} of {plain}");
}

#[test]
fn the_mean_of_a_chart_stays() {
    // Noise that grows with the value, as rays give it, on a curve: what a filter by inverse variances would darken.
    let truth = |x: f64, y: f64| 0.5 + 0.4 * (9.0 * x).sin() * (7.0 * y).cos();
    let mut bias = 0.0;
    let mut rmse = 0.0;
    for seed in 0..8 {
        let noise = |x: f64, y: f64| 0.1 * (truth(x, y) * (1.0 - truth(x, y))).sqrt();
        let made = made(seed, truth, noise, one_object);
        let (values, _) = made.denoised();
        let count = made.covered().count() as f64;
        let moved = |i: usize| f64::from(values[i] - made.mean[i]) / count;
        bias += made.covered().map(moved).sum::<f64>() / 8.0;
        rmse += made.judged()[1] / 8.0;
    }
    assert!(bias.abs() < 0.02 * rmse, "moved by {bias}, RMSE {rmse}");
}

#[test]
fn values_without_error_stay_as_they_are() {
    let made = made(
        1,
        |x, y| (3.0 * x).sin().abs() * 0.5 + 0.4 * y * y,
        |_, _| 0.0,
        one_object,
    );
    let (values, std_errs) = made.denoised();
    for i in made.covered() {
        assert_eq!((values[i], std_errs[i]), (made.mean[i], 0.0), "texel {i}");
    }
}

#[test]
fn exact_texels_stay_beside_noisy_ones() {
    let made = made(
        1,
        |x, _| if x < 0.5 { 1.0 } else { 0.6 },
        |x, _| if x < 0.5 { 0.0 } else { 0.05 },
        one_object,
    );
    let (values, std_errs) = made.denoised();
    for i in made.covered().filter(|i| i % SIZE < SIZE / 2) {
        assert_eq!((values[i], std_errs[i]), (1.0, 0.0), "texel {i}");
    }
}

#[test]
fn rays_that_all_agree_narrow_the_error_by_their_number() {
    let mut made = made(1, |_, _| 0.0, |_, _| 0.0, one_object);
    made.half[0] = 1e-3;
    made.std_err.fill(0.01);
    let (values, std_errs) = made.denoised();
    let middle = 50 * SIZE + 50;
    // 121 texels in place of 25.
    assert_eq!(values[middle], 0.0);
    assert!(
        (std_errs[middle] - 0.01 * 25.0 / 121.0).abs() < 1e-7,
        "{}",
        std_errs[middle]
    );
}

#[test]
fn halves_that_agree_by_chance_do_not_narrow_the_error() {
    // The first chart's light is that of one texel, of which both halves met it once: the others are filled from it.
    // The second is a common one.
    let chart = |x: usize, _: usize| if x < 5 { 1.0 } else { 0.0 };
    let mut made = made(1, |_, _| 0.3, |_, _| 0.02, chart);
    for i in (0..SIZE * SIZE).filter(|i| i % SIZE < 5) {
        (made.mean[i], made.half[i], made.std_err[i]) = (0.0, 0.0, 0.009);
    }
    for (i, share) in [(0, 0.5), (1, 0.7), (SIZE, 1.0), (SIZE + 1, 0.3)] {
        (made.mean[i], made.half[i]) = (0.038 * share, 0.0004 * share);
    }
    let (values, std_errs) = made.denoised();
    for i in [0, 1, SIZE, SIZE + 1, 2 * SIZE] {
        assert_eq!((values[i], std_errs[i]), (made.mean[i], 0.009), "texel {i}");
    }
    let common = 50 * SIZE + 50;
    assert!(std_errs[common] < 0.01, "{}", std_errs[common]);
}

#[test]
fn charts_of_few_texels_keep_their_values() {
    let made = made(1, |x, _| x, |_, _| 0.05, |x, y| (y * SIZE + x / 3) as f32);
    let (values, _) = made.denoised();
    assert!(made.covered().all(|i| values[i] == made.mean[i]));
}

/// The line between two halves of the square, where its two objects abut.
fn seam(objects: [u32; 2]) -> Vec<SeamPoint> {
    let points = (0..2 * SIZE).map(|k| SeamPoint {
        sides: [DVec2::new((SIZE / 2) as f64, 0.5 * k as f64 + 0.25); 2],
        inward: [-Vec2::X, Vec2::X],
        charts: objects.map(|object| [object, 0]),
        length: 0.5,
    });
    points.collect()
}

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

#[test]
fn three_channels_of_one_light_are_denoised_alike() {
    let made = made(2, |x, y| 0.3 + 0.2 * x * y, |_, _| 0.02, one_object);
    let scaled = |planes: &[f32], by: f32| planes.iter().map(|v| by * v).collect::<Vec<_>>();
    let values = [2.0, 4.0, 6.0].map(|by| scaled(&made.mean, by));
    let halves = [2.0, 4.0, 6.0].map(|by| scaled(&made.half, by));
    let denoiser = made.denoiser();
    let light = denoiser.denoise(&Term {
        values: values.iter().map(Vec::as_slice).collect(),
        halves: halves.iter().map(Vec::as_slice).collect(),
        std_err: &made.std_err,
        sealed: None,
        largest: f32::INFINITY,
        is_smooth: false,
        crosses: true,
    });
    let (alone, std_errs) = made.denoised();
    for (channel, by) in [2.0, 4.0, 6.0].into_iter().enumerate() {
        let (mut own, mut own_errs) = (values[channel].clone(), made.std_err.clone());
        for part in &light {
            part.set_values(channel, &mut own);
            part.set_errors(&mut own_errs);
        }
        for i in made.covered() {
            assert!((own[i] - by * alone[i]).abs() < 1e-4, "texel {i}");
            assert!((own_errs[i] - 4.0 * std_errs[i]).abs() < 1e-4, "texel {i}");
        }
    }
}

#[test]
fn a_step_at_a_seal_is_no_detail() {
    // Under a disk the light is 0, about it it falls off; a texel on its rim has its share.
    let sealed = |x: f64, y: f64| {
        let from = DVec2::new(x - 0.5, y - 0.5).length() * SIZE as f64 - 20.0;
        (0.5 - from).clamp(0.0, 1.0)
    };
    let truth = |x: f64, y: f64| (0.4 + 0.3 * x + 0.2 * y * y) * (1.0 - sealed(x, y));
    let mut made = made(7, truth, |x, y| 0.1 * (1.0 - sealed(x, y)), |_, _| 0.0);
    let [plain, without, ..] = made.judged();
    made.sealed = (0..SIZE * SIZE)
        .map(|i| {
            sealed(
                (i % SIZE) as f64 / SIZE as f64,
                (i / SIZE) as f64 / SIZE as f64,
            ) as f32
        })
        .collect();
    let [_, with, _, inside] = made.judged();
    assert!(
        with < 0.6 * without && with < 0.2 * plain,
        "{plain}, {without}, {with}"
    );
    assert!(inside > 0.93, "{inside}");
    let (values, _) = made.denoised();
    let dark = made.covered().filter(|&i| made.sealed[i] == 1.0);
    assert!(dark.map(|i| values[i]).all(|value| value == 0.0));
}
