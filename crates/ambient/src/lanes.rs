//! Elementary functions of `f32` for loops over lanes: no branches, no library calls, no fused operations.
//!
//! The compiler turns loops over them into vector code of whatever width it may use, and every width and every machine
//! gets the same bits, which the platform's mathematical library does not promise.

/// Lanes of one batch: one packet of rays.
pub const LANES: usize = 16;

/// One number a lane.
pub type Wide = [f32; LANES];

/// Adding and subtracting this rounds a small f32 to the nearest whole number; its low bits are then that number.
const ROUNDER: f32 = 12_582_912.0;

/// `(sin 2πu, cos 2πu)` for `u` in `-1/8..=1`, within 2e-7.
#[inline(always)]
pub fn turn_sin_cos(u: f32) -> (f32, f32) {
    let shifted = 4.0 * u + ROUNDER;
    let quarter = shifted.to_bits();
    let x = (u - 0.25 * (shifted - ROUNDER)) * std::f32::consts::TAU;
    let y = x * x;
    let sine =
        x - x * y * (1.0 / 6.0 - y * (1.0 / 120.0 - y * (1.0 / 5_040.0 - y * (1.0 / 362_880.0))));
    let cosine = 1.0
        - y * (0.5
            - y * (1.0 / 24.0
                - y * (1.0 / 720.0 - y * (1.0 / 40_320.0 - y * (1.0 / 3_628_800.0)))));
    let odd = quarter & 1 == 1;
    let (s, c) = if odd { (cosine, sine) } else { (sine, cosine) };
    let s = f32::from_bits(s.to_bits() ^ ((quarter & 2) << 30));
    let c = f32::from_bits(c.to_bits() ^ ((quarter.wrapping_add(1) & 2) << 30));
    (s, c)
}

/// Natural logarithm for normal `x` in (0, 1], relative error below 3e-7.
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    // x = 2^e m with m in √½..√2, so that e = 0 near 1 and the logarithm keeps its digits there.
    let bits = x.to_bits().wrapping_sub(0x3f35_04f3);
    let exponent = (bits as i32) >> 23;
    let m = f32::from_bits((bits & 0x007f_ffff).wrapping_add(0x3f35_04f3));
    let f = (m - 1.0) / (m + 1.0);
    let y = f * f;
    let tail = y * (1.0 / 3.0 + y * (1.0 / 5.0 + y * (1.0 / 7.0 + y * (1.0 / 9.0))));
    exponent as f32 * std::f32::consts::LN_2 + 2.0 * (f + f * tail)
}

/// `e^x - 1` for `x` in -87..=0, relative error below 3e-7.
#[inline(always)]
pub fn exp_m1(x: f32) -> f32 {
    let shifted = x * std::f32::consts::LOG2_E + ROUNDER;
    let whole = shifted - ROUNDER;
    // ln 2 in two parts: the first has few digits, so its product with a small whole number is exact.
    let f = (x - whole * 0.693_359_4) + whole * 2.121_944_4e-4;
    let p = f + f
        * f
        * (0.5
            + f * (1.0 / 6.0
                + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f * (1.0 / 720.0 + f * (1.0 / 5_040.0))))));
    let scale = f32::from_bits((shifted.to_bits().wrapping_add(127)) << 23);
    scale * p + (scale - 1.0)
}

/// The angle of `(x, y)` in radians, within 3e-7: M. Abramowitz, I. Stegun, "Handbook of Mathematical Functions",
/// 4.4.49. Free of the platform's library, so that every machine gets the same bits.
#[inline(always)]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (a, b) = (x.abs(), y.abs());
    let ratio = a.min(b) / a.max(b).max(f32::MIN_POSITIVE);
    let square = ratio * ratio;
    let mut sum = 0.002_866_226;
    for coefficient in [
        -0.016_165_737,
        0.042_909_61,
        -0.075_289_64,
        0.106_562_64,
        -0.142_089,
        0.199_935_51,
        -0.333_331_46,
        1.0,
    ] {
        sum = sum * square + coefficient;
    }
    let angle = sum * ratio;
    let angle = if b > a {
        std::f32::consts::FRAC_PI_2 - angle
    } else {
        angle
    };
    let angle = if x < 0.0 {
        std::f32::consts::PI - angle
    } else {
        angle
    };
    angle.copysign(y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn elementary_functions_keep_their_relative_error() {
        for k in 1..=200_000_u32 {
            let x = k as f32 / 200_000.0;
            let exact = f64::from(x).ln();
            assert!(
                (f64::from(ln(x)) - exact).abs() <= 3e-7 * exact.abs(),
                "ln {x}"
            );
            let y = -87.0 * x * x * x;
            let exact = f64::from(y).exp_m1();
            assert!(
                (f64::from(exp_m1(y)) / exact - 1.0).abs() < 3e-7,
                "expm1 {y}"
            );
            let (s, c) = turn_sin_cos(x);
            let (sl, cl) = (f64::from(x) * TAU).sin_cos();
            assert!(
                (f64::from(s) - sl).abs() < 3e-7 && (f64::from(c) - cl).abs() < 3e-7,
                "turn {x}"
            );
        }
        assert!(ln(1.0 - 0.5 / 8_388_608.0) < 0.0);
    }

    #[test]
    fn angles_are_those_of_the_library() {
        for i in 0..10_000 {
            let exact = f64::from(i) / 10_000.0 * TAU - PI;
            let (y, x) = exact.sin_cos();
            let (y, x) = (y as f32, x as f32);
            let library = f64::from(y).atan2(f64::from(x));
            assert!((f64::from(atan2(y, x)) - library).abs() < 3e-7, "{exact}");
        }
        assert_eq!(atan2(0.0, 1.0), 0.0);
        assert_eq!(atan2(0.0, 0.0), 0.0);
    }
}
