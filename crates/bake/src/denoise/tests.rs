//! The denoiser on made charts: a square of texels with noise of a known size over a known truth.

mod joined;
mod limits;
mod strays;

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
            riders: Vec::new(),
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
fn three_channels_of_one_light_are_denoised_alike() {
    let made = made(2, |x, y| 0.3 + 0.2 * x * y, |_, _| 0.02, one_object);
    let scaled = |planes: &[f32], by: f32| planes.iter().map(|v| by * v).collect::<Vec<_>>();
    let values = [2.0, 4.0, 6.0].map(|by| scaled(&made.mean, by));
    let halves = [2.0, 4.0, 6.0].map(|by| scaled(&made.half, by));
    let denoiser = made.denoiser();
    let light = denoiser.denoise(&Term {
        values: values.iter().map(Vec::as_slice).collect(),
        riders: Vec::new(),
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
