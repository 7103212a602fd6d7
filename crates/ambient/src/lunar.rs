//! Surfaces of loose dust, as the Moon's: the law of Lommel and Seeliger.
//!
//! Light goes into a dark, porous ground, is scattered once, and comes out again. What comes back is `E ω/4π μ₀/(μ₀ +
//! μ)`, with μ₀ the cosine to the light, μ the cosine to the eye and ω what a grain scatters. There is no cosine to the
//! eye as with Lambert: ground that is seen at a glance shows more of itself. We write `albedo` for ω/8, so that a
//! surface that is lit and seen along its normal is as bright as Lambert's of the same albedo. Single scattering gives
//! up to 1/8 so, about what the Moon has.
//!
//! Sources: H. von Seeliger, "Zur Photometrie zerstreut reflectirender Substanzen", 1888; B. Hapke, "Theory of
//! Reflectance and Emittance Spectroscopy", 1993, of whose model it is the simplest case.

/// What Lambert's radiance is multiplied with: `2/(μ₀ + μ)`, which is 1 along the normal.
///
/// * `light`, `view`: cosines from the normal; below 0 they count as 0.
///
/// ```
/// use ambake_ambient::lunar::lommel_seeliger;
/// // At full phase light and eye are in one direction, and the disc is as bright everywhere: Lambert's cosine
/// // is taken back.
/// for cos in [0.1, 0.5, 1.0] {
///     assert!((cos * lommel_seeliger(cos, cos) - 1.0).abs() < 1e-15);
/// }
/// ```
pub fn lommel_seeliger(light: f64, view: f64) -> f64 {
    2.0 / (light.max(0.0) + view.max(LEAST))
}

/// Light under an open sky of 1 toward an eye at the cosine `view`, for an albedo of 1: `4 (1 - μ ln(1 + 1/μ))`, from
/// 1.227 along the normal to 4 at the horizon, so that no more than arrives comes back up to an albedo of 1/4.
pub fn lommel_seeliger_open(view: f64) -> f64 {
    let view = view.max(LEAST);
    4.0 * (1.0 - view * view.recip().ln_1p())
}

/// An eye at the horizon sees what it sees just above.
const LEAST: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss;

    #[test]
    fn open_sky_is_the_integral_over_directions_of_light() {
        for view in [1e-3, 0.05, 0.3, 0.7, 1.0] {
            // (1/π) ∫ μ₀ 2/(μ₀ + μ) dω with μ₀ = t², which takes more nodes to the horizon.
            let exact = gauss(
                &|t| 4.0 * t.powi(3) * lommel_seeliger(t * t, view),
                0.0,
                1.0,
            );
            let found = lommel_seeliger_open(view);
            assert!((found - exact).abs() < 1e-6, "{view}: {found} for {exact}");
        }
    }

    #[test]
    fn light_and_eye_may_be_exchanged() {
        // Helmholtz: radiance over irradiance, which has the cosine to the light in it, is symmetric but for that
        // cosine.
        assert_eq!(lommel_seeliger(0.2, 0.9), lommel_seeliger(0.9, 0.2));
    }

    #[test]
    fn dust_sends_back_no_more_than_arrives_up_to_a_quarter() {
        // By exchange, what leaves in all directions for light from one is the open sky seen in that one.
        for k in 0..=1000 {
            let all = 0.25 * lommel_seeliger_open(f64::from(k) / 1000.0);
            assert!((0.0..=1.0).contains(&all), "{k}: {all}");
        }
    }
}
