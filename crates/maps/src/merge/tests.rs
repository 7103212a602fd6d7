//! Ramps whose radiance is known.

use super::*;

/// Uniform numbers in 0..1 (Steele, Lea, Flood 2014).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Sum of twelve: variance 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() - 6.0
    }
}

const ROWS: usize = 512;
const COLUMNS: usize = 64;

/// Rows from 1 to 1e9.
fn ramp(row: usize) -> f64 {
    10f64.powf(9.0 * row as f64 / (ROWS - 1) as f64)
}

/// A camera by the level 0..=255 of an exposure, of which 1 is full.
type Camera = (&'static str, fn(f64) -> f64);

const CAMERAS: [Camera; 5] = [
    ("linear", |e| e),
    ("gamma 2.2", |e| e.powf(1.0 / 2.2)),
    ("sRGB", |e| match e {
        e if e <= 0.003_130_8 => 12.92 * e,
        e => 1.055 * e.powf(1.0 / 2.4) - 0.055,
    }),
    ("film", |e| {
        ((1.0 + 9.0 * e).powf(0.4) - 1.0) / (10f64.powf(0.4) - 1.0)
    }),
    // Toe and shoulder: 3 s² - 2 s³ of the gamma curve, halfway.
    ("S-curve", |e| {
        let s = e.powf(1.0 / 2.2);
        0.5 * s + 0.5 * s * s * (3.0 - 2.0 * s)
    }),
];

/// Fifteen 8-bit photographs of the ramp, with noise of half a level.
fn nine_decades(camera: Camera, seed: u64) -> Vec<Bracket> {
    let mut numbers = Numbers(seed);
    let photograph = |k: usize| {
        let time = 0.9 * 10f64.powf(-9.0 * k as f64 / 14.0);
        let mut shot = |i: usize| {
            [0; 3].map(|_: u16| {
                let exposure = (ramp(i / COLUMNS) * time).min(1.0);
                let level = 255.0 * camera.1(exposure) + 0.5 * numbers.normal();
                257 * level.round().clamp(0.0, 255.0) as u16
            })
        };
        Bracket {
            width: COLUMNS,
            height: ROWS,
            values: (0..ROWS * COLUMNS).map(&mut shot).collect(),
            time,
            shift: [0, 0],
        }
    };
    (0..15).map(photograph).collect()
}

/// Largest relative error of the means of rows, with the common factor taken out.
fn worst(merged: &Merged, channel: usize) -> f64 {
    let ratios: Vec<f64> = (0..ROWS)
        .map(|row| {
            let pixels = &merged.image.pixels[row * COLUMNS..(row + 1) * COLUMNS];
            let sum: f64 = pixels.iter().map(|p| f64::from(p[channel])).sum();
            sum / COLUMNS as f64 / ramp(row)
        })
        .collect();
    let mut sorted = ratios.clone();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted[ROWS / 2];
    ratios
        .iter()
        .map(|r| (r / middle - 1.0).abs())
        .fold(0.0, f64::max)
}

#[test]
fn a_noisy_ramp_of_nine_decades_is_within_half_a_percent_for_five_cameras() {
    for camera in CAMERAS {
        let brackets = nine_decades(camera, 7);
        let known = match camera.0 {
            "linear" => Some(Model::Linear),
            "sRGB" => Some(Model::Srgb),
            _ => None,
        };
        for model in [Model::Debevec, Model::Robertson].into_iter().chain(known) {
            let merged = merge(&brackets, model).unwrap();
            let errors = [0, 1, 2].map(|channel| worst(&merged, channel));
            println!("{}, {model:?}: worst row {errors:.5?}", camera.0);
            assert!(
                errors.iter().all(|e| *e <= 0.005),
                "{}: {errors:?}",
                camera.0
            );
            assert!(merged.saturated.iter().all(|s| !s));
        }
    }
}

/// One row whose values are exact at times of powers of 4.
fn exact(count: usize) -> (Vec<f64>, Vec<Bracket>) {
    let truth: Vec<f64> = (1..64).map(|i| (i * 1024) as f64 / 65535.0).collect();
    let photograph = |k: usize| {
        let time = 4f64.powi(-(k as i32));
        let value = |x: &f64| [(x * time * 65535.0).round().min(65535.0) as u16; 3];
        Bracket {
            width: truth.len(),
            height: 1,
            values: truth.iter().map(value).collect(),
            time,
            shift: [0, 0],
        }
    };
    let brackets = (0..count).map(photograph).collect();
    (truth, brackets)
}

#[test]
fn noise_free_brackets_return_the_ramp_by_the_linear_response() {
    let (truth, brackets) = exact(4);
    let merged = merge(&brackets, Model::Linear).unwrap();
    for (x, pixel) in truth.iter().zip(&merged.image.pixels) {
        let error = (f64::from(pixel[0]) / x - 1.0).abs();
        assert!(error <= 1e-5, "{x}: {pixel:?}");
    }
    assert!(merged.saturated.iter().all(|s| !s));
}

#[test]
fn a_known_curve_is_undone_to_a_hundred_thousandth() {
    let values: Vec<[u16; 3]> = (0..63_000).map(|v| [v; 3]).collect();
    let bracket = |values: Vec<[u16; 3]>, time: f64| Bracket {
        width: values.len(),
        height: 1,
        values,
        time,
        shift: [0, 0],
    };
    let black = vec![[0; 3]; values.len()];
    let brackets = [bracket(values, 0.5), bracket(black, 1e-12)];
    let merged = merge(&brackets, Model::Srgb).unwrap();
    for (v, pixel) in merged.image.pixels.iter().enumerate() {
        let encoded = v as f64 / 65535.0;
        let truth = 2.0
            * if encoded <= 0.04045 {
                encoded / 12.92
            } else {
                ((encoded + 0.055) / 1.055).powf(2.4)
            };
        let error = (f64::from(pixel[1]) - truth).abs();
        assert!(error <= 1e-5 * truth, "{v}: {pixel:?} for {truth}");
    }
}

#[test]
fn one_series_gives_the_same_bits_at_any_thread_count() {
    let brackets = nine_decades(CAMERAS[1], 3);
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build()
            .unwrap()
            .install(|| merge(&brackets, Model::Robertson).unwrap())
    };
    assert_eq!(by(1), by(3));
}

#[test]
fn shifts_over_two_to_the_twentieth_in_exposure_are_found_and_undone() {
    // A scene of blocks from 1 to 2^20, seen by a hand that moves.
    let scene = |x: i64, y: i64| {
        let mut numbers = Numbers(((x.div_euclid(13) as u64) << 32) ^ y.div_euclid(11) as u64);
        2f64.powf(20.0 * numbers.next())
    };
    let shifts = [[0, 0], [3, -2], [-9, 5], [14, 11], [1, -20], [-31, 8]];
    let (width, height) = (301, 203);
    let photograph = |(k, [dx, dy]): (usize, &[i32; 2])| {
        let time = 2f64.powi(-4 - 4 * k as i32);
        let mut numbers = Numbers(k as u64);
        let mut shot = |i: usize| {
            let (x, y) = ((i % width) as i64, (i / width) as i64);
            let exposure = scene(x - i64::from(*dx), y - i64::from(*dy)) * time;
            let level = 255.0 * exposure.min(1.0).powf(1.0 / 2.2) + numbers.normal();
            [257 * level.round().clamp(0.0, 255.0) as u16; 3]
        };
        Bracket {
            width,
            height,
            values: (0..width * height).map(&mut shot).collect(),
            time,
            shift: [0, 0],
        }
    };
    let mut brackets: Vec<Bracket> = shifts.iter().enumerate().map(photograph).collect();
    assert_eq!(align(&mut brackets), [true; 6]);
    let [x, y] = shifts[2]; // the middle exposure by time
    let found: Vec<[i32; 2]> = brackets.iter().map(|b| b.shift).collect();
    let truth = shifts.map(|[a, b]| [a - x, b - y]);
    assert_eq!(found, truth);
    let merged = merge(&brackets, Model::Debevec).unwrap();
    let ratio = |i: usize| {
        let (i, j) = ((i % width) as i64, (i / width) as i64);
        f64::from(merged.image.pixels[j as usize * width + i as usize][0])
            / scene(i - i64::from(x), j - i64::from(y))
    };
    // Every bracket shows these pixels. An exposure is sixteen times the next, so the lowest level that counts is 72;
    // one of noise is 3 % of it, and of so many pixels one lies 5 deviations off.
    let inner = |i: &usize| (60..240).contains(&(i % width)) && (50..150).contains(&(i / width));
    let ratios: Vec<f64> = (0..width * height).filter(inner).map(ratio).collect();
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    let worst = ratios
        .iter()
        .map(|r| (r / mean - 1.0).abs())
        .fold(0.0, f64::max);
    println!("worst pixel {worst}");
    assert!(worst < 0.15, "{worst}");
}

#[test]
fn a_pixel_saturated_everywhere_keeps_the_bound_of_the_shortest_exposure() {
    let photograph = |time: f64, third: u16| Bracket {
        width: 3,
        height: 1,
        values: vec![[65535; 3], [0, 0, 65535], [third; 3]],
        time,
        shift: [0, 0],
    };
    // Black beside saturated, by a gap between the exposures, is a bound too.
    let brackets = [photograph(1.0, 65535), photograph(0.25, 0)];
    let merged = merge(&brackets, Model::Linear).unwrap();
    assert_eq!(merged.saturated, [true; 3]);
    assert_eq!(merged.image.pixels, [[4.0; 3], [0.0, 0.0, 4.0], [1.0; 3]]);
}

#[test]
fn unusable_series_are_refused_with_a_cure() {
    let (_, good) = exact(2);
    let narrow = Bracket {
        width: 1,
        values: vec![[9; 3]],
        ..good[0].clone()
    };
    let still = Bracket {
        time: 0.0,
        ..good[0].clone()
    };
    let cases = [
        (vec![good[0].clone()], "1 brackets are no series"),
        (vec![], "0 brackets"),
        (vec![good[0].clone(), narrow], "bracket 2 is 1 x 1 pixels"),
        (vec![good[0].clone(), still], "above 0"),
        (
            vec![good[0].clone(), good[0].clone()],
            "two brackets have the time 1 s",
        ),
    ];
    for (brackets, words) in cases {
        let message = merge(&brackets, Model::Debevec).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}
