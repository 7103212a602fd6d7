//! The three models that a bake sets side by side, per colour channel, from stored terms.
//!
//! X. Zhang, Y. Gao, "Generalised Ambient Reflection Models for Lambertian and Phong Surfaces", ICIP 2009; constants in
//! [`crate::convention`]. Sky and result are radiances; albedo and specular colour are `0..=1`. On an open point seen
//! along its normal no model exceeds the sky as long as albedo + specular colour is at most 1, and no term rises above
//! that.

use glam::DVec3;

/// The traditional model, equation (1) attenuated by ambient occlusion: sky × albedo × visibility.
///
/// ```
/// use ambake_ambient::models::{lambert, traditional};
/// use glam::DVec3;
/// // Under an overhang half of the solid angle is open, but three quarters of what counts by the cosine.
/// let (sky, albedo) = (DVec3::ONE, DVec3::splat(0.8));
/// assert_eq!(traditional(sky, albedo, 0.5).x, 0.4);
/// assert!((lambert(0.75 * sky, albedo).x - 0.6).abs() < 1e-15);
/// ```
pub fn traditional(sky: DVec3, albedo: DVec3, visibility: f64) -> DVec3 {
    sky * albedo * visibility
}

/// The Lambertian model, equation (5): albedo × irradiance, which is sky × diffuse under a uniform sky. Independent of
/// the view.
pub fn lambert(irradiance: DVec3, albedo: DVec3) -> DVec3 {
    albedo * irradiance
}

/// The Phong model, equation (9), (16) when open: albedo × irradiance + specular colour × reflection, which is sky ×
/// specular under a uniform sky.
pub fn phong(irradiance: DVec3, reflection: DVec3, albedo: DVec3, specular_colour: DVec3) -> DVec3 {
    albedo * irradiance + specular_colour * reflection
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_form::phong_open;
    use crate::convention::{albedo_of, specular_of};
    use std::f64::consts::PI;

    #[test]
    fn an_open_point_reflects_the_sky_by_its_albedo_in_every_model() {
        let (sky, albedo) = (DVec3::new(2.0, 1.0, 0.5), DVec3::new(0.25, 0.5, 1.0));
        let exact = DVec3::splat(0.5);
        assert_eq!(traditional(sky, albedo, 1.0), exact);
        assert_eq!(lambert(sky, albedo), exact);
        assert_eq!(phong(sky, 0.5 * sky, albedo, DVec3::ZERO), exact);
    }

    #[test]
    fn phong_is_equation_16_with_the_diffuse_factor_corrected() {
        // π i_a { k_d + k_s 2/(n+1) G }, i_a = 1, n = 2, view at 60 degrees.
        let (k_d, k_s, n): (f64, f64, f64) = (0.2, 0.1, 2.0);
        let g = phong_open(n, 0.5, 0.75_f64.sqrt());
        let exact = PI * (k_d + k_s * 2.0 / (n + 1.0) * g);
        let albedo = DVec3::splat(albedo_of(k_d));
        let colour = DVec3::splat(specular_of(k_s, n));
        let value = phong(DVec3::ONE, DVec3::splat(g), albedo, colour);
        assert!((value.x - exact).abs() < 4e-16, "{value} for {exact}");
    }
}
