//! The materials of a file as parameters of the Phong model.
//!
//! # Metallic-roughness to Phong
//!
//! glTF describes a GGX lobe; the model that is integrated here is Phong's, about the mirror direction. Colours follow
//! the metallic-roughness model of the glTF 2.0 specification, appendix B, at normal view. A metal has no diffuse part
//! and reflects its base colour. A dielectric is a coat over a diffuse base: the coat reflects `F0`, and only what it
//! leaves reaches the base. Where a tint makes `F0` a colour, the base gets `1 - max(F0)` in every channel, so that it
//! does not take on the complementary hue (`fresnel_mix` and `max_value` of KHR_materials_specular). `metallic` mixes
//! the two:
//!
//! ```text
//! albedo   = base (1 - metallic) (1 - max F0)
//! specular = F0 (1 - metallic) + base metallic
//! ```
//!
//! Their sum is `(1 - metallic) (base (1 - max F0) + F0) + metallic base`. With `base` and `F0` in 0..=1 the inner
//! bracket is at most `1 - max F0 + F0 <= 1`, so the sum is at most 1: exactly 1 for a white metal and for a white
//! dielectric of untinted `F0`. The terms that albedo and specular multiply are at most 1 under a uniform sky, so no
//! surface sends out more than it receives.
//!
//! The exponent comes in two steps.
//!
//! 1. Roughness to half-vector exponent: `alpha = roughness²`, and the Blinn lobe of a microfacet surface with that
//!    width is `n_h = 2/alpha² - 2` (Walter, Marschner, Li and Torrance, *Microfacet Models for Refraction through
//!    Rough Surfaces*, EGSR 2007, their match of the Phong to the Beckmann distribution).
//! 2. Half vector to mirror direction: with the light in the plane of view and normal, turning the light by an angle
//!    turns the mirror direction by the same angle and the half vector by half of it. Near the peak
//!    `cosⁿ x ≈ exp(-n x²/2)`, so `n_h (x/2)² = n x²` and `n = n_h/4` (Fisher and Woo, *R·E versus N·H Specular
//!    Highlights*, Graphics Gems IV, 1994, who show how close the match is away from the peak).
//!
//! Together `n = (1/alpha² - 1)/2`: 0 for roughness 1, 7.5 for roughness 0.5, and clamped to [`MAX_EXPONENT`] for a
//! mirror.
//!
//! # Diffuse and specular given apart
//!
//! OBJ files and scenes built in memory name both reflectances, and nothing keeps their sum below 1. Where it is not,
//! [`conserving`] scales both. To take the excess from one of them would turn many files black or matt: exporters leave
//! a `Ks` of 0.5 or 1 beside any `Kd`.

use crate::WarningKind;
use crate::input::Input;
use glam::Vec3;

/// Largest lobe exponent that a scene holds.
pub const MAX_EXPONENT: f64 = 1e6;

/// Albedo, specular reflectance and lobe exponent of a metallic-roughness surface; see the head of this module's file
/// for the formula and its sources.
///
/// Albedo and specular reflectance add up to at most 1 in every channel, within the rounding of f32.
///
/// * `base`: base colour, linear, 0..=1 a channel.
/// * `metallic`, `roughness`: 0..=1; values outside are clamped into the range, NaN counts as 0.
/// * `dielectric`: `F0`, the reflectance of the non-metal at normal view, linear, 0..=1 a channel; 0.04 for glass of
///   index 1.5.
///
/// ```
/// # use glam::Vec3;
/// let (albedo, specular, n) = ambake_scene::phong_from_metallic_roughness(Vec3::ONE, 0.0, 0.5, Vec3::splat(0.04));
/// assert_eq!((albedo, specular, n), (Vec3::splat(0.96), Vec3::splat(0.04), 7.5));
/// ```
pub fn phong_from_metallic_roughness(
    base: Vec3,
    metallic: f64,
    roughness: f64,
    dielectric: Vec3,
) -> (Vec3, Vec3, f64) {
    let unit = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    let metal = unit(metallic) as f32;
    let alpha = unit(roughness).powi(2);
    let exponent = (0.5 / (alpha * alpha) - 0.5).clamp(0.0, MAX_EXPONENT);
    (
        base * (1.0 - metal) * (1.0 - dielectric.max_element()),
        dielectric * (1.0 - metal) + base * metal,
        exponent,
    )
}

/// Albedo, specular reflectance and lobe exponent of a specular-glossiness surface: the coat reflects `specular`, what
/// it leaves of its largest channel reaches the base, and the roughness is `1 - glossiness`
/// (KHR_materials_pbrSpecularGlossiness, its appendix).
///
/// * `diffuse`, `specular`: linear, 0..=1 a channel.
/// * `glossiness`: 0..=1; values outside are clamped into the range, NaN counts as 1.
pub fn phong_from_specular_glossiness(
    diffuse: Vec3,
    specular: Vec3,
    glossiness: f64,
) -> (Vec3, Vec3, f64) {
    phong_from_metallic_roughness(diffuse, 0.0, 1.0 - glossiness, specular)
}

/// Albedo and specular reflectance, both in 0..=1: as given, or, where they add up to more than 1 in a channel, both
/// times the largest factor that leaves no such channel. One factor for all keeps hue and gloss. Counted as
/// [`WarningKind::ReflectanceScaled`].
pub(crate) fn conserving(
    input: &mut Input,
    place: &str,
    [albedo, specular]: [Vec3; 2],
) -> [Vec3; 2] {
    // The sum is rounded to f32 on purpose: decimals that add up to 1 in the file, such as 0.6 and 0.4, do so here.
    if (albedo + specular).max_element() <= 1.0 {
        return [albedo, specular];
    }
    let factor = 1.0 / (albedo.as_dvec3() + specular.as_dvec3()).max_element();
    // What it says is known once all are.
    input.warn(WarningKind::ReflectanceScaled, place, 1, "");
    input.scaled = (input.scaled.0.min(factor), input.scaled.1 + 1);
    [albedo, specular].map(|color| (color.as_dvec3() * factor).as_vec3())
}

/// Lets all warnings of scaled reflectances say the same, so that they are one line: the least factor.
pub(crate) fn tell_scaled(input: &mut Input) {
    let (least, materials) = input.scaled;
    let factor = match materials {
        1 => format!("{least:.4}"),
        _ => format!("what makes the sum 1, by {least:.4} where it is largest"),
    };
    let message = format!(
        "diffuse and specular reflectance add up to more than 1; both are multiplied by {factor}"
    );
    let mut all = input.warnings.iter_mut();
    while let Some(warning) = all.find(|warning| warning.kind == WarningKind::ReflectanceScaled) {
        warning.message.clone_from(&message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_metal_has_no_albedo_and_a_mirror_has_the_largest_exponent() {
        let base = Vec3::new(0.9, 0.5, 0.1);
        assert_eq!(
            phong_from_metallic_roughness(base, 1.0, 0.0, Vec3::splat(0.04)),
            (Vec3::ZERO, base, MAX_EXPONENT)
        );
        assert_eq!(
            phong_from_metallic_roughness(base, 0.0, 1.0, Vec3::splat(0.04)).2,
            0.0
        );
        assert_eq!(
            phong_from_metallic_roughness(base, f64::NAN, f64::NAN, Vec3::ZERO).2,
            MAX_EXPONENT
        );
    }
}
