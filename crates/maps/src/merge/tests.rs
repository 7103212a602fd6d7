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

/// Fifteen 8-bit photographs of the ramp through a film-like curve, with noise of half a level.
fn nine_decades() -> Vec<Bracket> {
    let curve =
        |e: f64| 255.0 * ((1.0 + 9.0 * e.min(1.0)).powf(0.4) - 1.0) / (10f64.powf(0.4) - 1.0);
    let mut numbers = Numbers(7);
    let photograph = |k: usize| {
        let time = 0.9 * 10f64.powf(-9.0 * k as f64 / 14.0);
        let mut shot = |i: usize| {
            [0; 3].map(|_: u16| {
                let level = curve(ramp(i / COLUMNS) * time) + 0.5 * numbers.normal();
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
fn a_noisy_ramp_of_nine_decades_is_within_half_a_percent() {
    let brackets = nine_decades();
    for (model, errors) in [Model::Debevec, Model::Robertson].map(|model| {
        let merged = merge(&brackets, model).unwrap();
        (model, [0, 1, 2].map(|c| worst(&merged, c)))
    }) {
        println!("{model:?}: worst row {errors:?}");
        assert!(errors.iter().all(|e| *e <= 0.005), "{model:?}: {errors:?}");
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
fn a_pixel_saturated_everywhere_keeps_the_bound_of_the_shortest_exposure() {
    let photograph = |time: f64| Bracket {
        width: 2,
        height: 1,
        values: vec![[65535; 3], [0, 0, 65535]],
        time,
        shift: [0, 0],
    };
    let merged = merge(&[photograph(1.0), photograph(0.25)], Model::Linear).unwrap();
    assert_eq!(merged.saturated, [true, true]);
    assert_eq!(merged.image.pixels, [[4.0; 3], [0.0, 0.0, 4.0]]);
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
