//! Sine and cosine of an angle in turns.

/// `(sin 2πu, cos 2πu)` for `u` in `0..=1`, each within 3e-16 of the exact value.
///
/// Free of branches and of the platform's library: loops over it vectorise and every machine gets the same bits.
/// Quadrants are exact: `u = 0.25` gives `(1, 0)`.
#[inline(always)]
pub fn turn_sin_cos(u: f64) -> (f64, f64) {
    // Nearest quarter turn, then Taylor's series on the eighth turn to either side (x at most π/4).
    let quarter = (4.0 * u + 0.5) as i32;
    let x = (u - 0.25 * f64::from(quarter)) * std::f64::consts::TAU;
    let y = x * x;
    let sine = x - x
        * y
        * (1.0 / 6.0
            - y * (1.0 / 120.0
                - y * (1.0 / 5_040.0
                    - y * (1.0 / 362_880.0
                        - y * (1.0 / 39_916_800.0
                            - y * (1.0 / 6_227_020_800.0 - y / 1_307_674_368_000.0))))));
    let cosine = 1.0
        - y * (0.5
            - y * (1.0 / 24.0
                - y * (1.0 / 720.0
                    - y * (1.0 / 40_320.0
                        - y * (1.0 / 3_628_800.0
                            - y * (1.0 / 479_001_600.0
                                - y * (1.0 / 87_178_291_200.0 - y / 20_922_789_888_000.0)))))));
    let odd = quarter & 1 == 1;
    let (s, c) = if odd { (cosine, sine) } else { (sine, cosine) };
    let s = if quarter & 2 == 2 { -s } else { s };
    let c = if (quarter + 1) & 2 == 2 { -c } else { c };
    (s, c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_library_and_hits_the_axes_exactly() {
        for i in 0..=100_000 {
            let u = f64::from(i) / 100_000.0;
            let (s, c) = turn_sin_cos(u);
            let (sl, cl) = (u * std::f64::consts::TAU).sin_cos();
            // The library sees 2πu rounded, half an ulp of 2π: 4.5e-16.
            assert!((s - sl).abs() < 8e-16 && (c - cl).abs() < 8e-16, "u = {u}");
            assert!((s * s + c * c - 1.0).abs() < 5e-16, "u = {u}");
        }
        assert_eq!(turn_sin_cos(0.0), (0.0, 1.0));
        assert_eq!(turn_sin_cos(0.25), (1.0, 0.0));
        assert_eq!(turn_sin_cos(0.5), (0.0, -1.0));
        assert_eq!(turn_sin_cos(0.75), (-1.0, 0.0));
        assert_eq!(turn_sin_cos(1.0), (0.0, 1.0));
    }
}
