//! The microfacet term under a uniform sky: GGX with height-correlated masking, α = roughness².
//!
//! ```text
//! J = ∫ L V F D G2 / (4 N·V) dω,   F = F0 + (1 - F0) Fc,  Fc = (1 - V·H)^5,   so  J = F0 A + B
//! ```
//!
//! Half vectors H are drawn from the normals that the view sees, density `D G1 V·H / N·V`, and L is V mirrored about H.
//! Those of which no L rises above the surface are left out: with k, the share of N·V that `bound` leaves, `G1 = 2 N·V
//! / (k N·V + sqrt(α² + (1 - α²) (N·V)²))` takes the place of Smith's in that density, and in `G1` below. Each
//! direction then weighs `F w` with `w = G2/G1`, which is at most 1. A sums `(1 - Fc) w` and B sums `Fc w`.
//!
//! What light loses between facets that shadow each other is given back with the directional albedo E = A + B of a
//! white mirror: times `1 + F0 (1/E - 1)`, which is 1/E for F0 = 1, so that a white metal returns all that it receives.
//!
//! Sources: B. Walter, S. Marschner, H. Li, K. Torrance, "Microfacet Models for Refraction through Rough Surfaces",
//! EGSR 2007 (D); E. Heitz, "Understanding the Masking-Shadowing Function", JCGT 2014 (G2); C. Schlick 1994 (F); J.
//! Dupuy, A. Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG 2023; K. Eto, Y. Tokuyoshi, "Bounded VNDF
//! Sampling for Smith-GGX Reflections", SIGGRAPH Asia 2023 technical communications; R. Fdez-Agüera, "A
//! Multiple-Scattering Microfacet Model for Real-Time Image-based Lighting", JCGT 2019, and Turquin, "Practical
//! Multiple Scattering Compensation for Microfacet Models", 2018 (the factor).

#[cfg(test)]
mod both;
mod open;
mod wide;

pub use wide::{Lobes, lobes16, sample16};

use crate::Frame;
use crate::sampling::turn_sin_cos;
use glam::DVec3;
use std::f64::consts::PI;

/// Least α: a mirror for all that a texel can show.
pub const LEAST_ALPHA: f64 = 1e-4;
/// Least N·V: an eye at or below the horizon of a shading normal sees what it sees just above.
pub const LEAST_COS: f64 = 1e-3;

/// A GGX surface seen from one direction, in a frame whose z axis is the normal and whose xz plane holds the view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ggx {
    pub(crate) alpha: f64,
    view: DVec3,
}

/// A direction drawn from the visible normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// Local unit direction of the light.
    pub direction: DVec3,
    /// G2/G1, 0..=1; 0 below the surface.
    pub weight: f64,
    /// (1 - V·H)^5.
    pub fresnel: f64,
}

/// A and B of an open surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Albedos {
    /// What F0 multiplies.
    pub tinted: f64,
    /// What is added whatever F0.
    pub white: f64,
}

/// α of the Phong exponent n as materials are mapped, `n = (1/α² - 1)/2`.
///
/// ```
/// // Roughness 0.5 is α = 0.25 and n = 7.5.
/// assert_eq!(ambake_ambient::ggx::alpha_of(7.5), 0.25);
/// ```
pub fn alpha_of(exponent: f64) -> f64 {
    (2.0 * exponent + 1.0).sqrt().recip()
}

impl Ggx {
    /// A surface of `alpha`, 0..=1, seen at the cosine `cos` of the angle to the normal. Both are kept a little above
    /// 0.
    pub fn new(alpha: f64, cos: f64) -> Self {
        let cos = cos.clamp(LEAST_COS, 1.0);
        Self {
            alpha: alpha.clamp(LEAST_ALPHA, 1.0),
            view: DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos),
        }
    }

    /// The local unit vector to the eye.
    pub fn view(&self) -> DVec3 {
        self.view
    }

    /// The direction of a point of the unit square.
    pub fn sample(&self, [u0, u1]: [f64; 2]) -> Drawn {
        let (alpha, v) = (self.alpha, self.view);
        let stretched = DVec3::new(alpha * v.x, 0.0, v.z).normalize();
        let (sin, cos) = turn_sin_cos(u1);
        // The cap of the sphere that the stretched view sees reaches down to -z of the view, and the part of it that
        // mirrors some light from above the surface less far; u0 = 1 is its top.
        let down = bound(alpha, v.z) * stretched.z;
        let z = u0 * (1.0 + down) - down;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let h = DVec3::new(r * cos, r * sin, z) + stretched;
        let h = DVec3::new(alpha * h.x, alpha * h.y, h.z.max(0.0));
        let h = h.try_normalize().unwrap_or(DVec3::Z);
        let along = v.dot(h).max(0.0);
        let direction = 2.0 * along * h - v;
        Drawn {
            direction,
            weight: self.weight(direction),
            fresnel: fresnel(along),
        }
    }

    /// Density per steradian of [`Ggx::sample`] at a local unit direction above the surface: D G1 / (4 N·V).
    pub fn pdf(&self, direction: DVec3) -> f64 {
        let Some(h) = (direction + self.view).try_normalize() else {
            return 0.0;
        };
        if h.z <= 0.0 {
            return 0.0;
        }
        let alpha2 = self.alpha * self.alpha;
        let spread = alpha2 * h.z * h.z + h.x * h.x + h.y * h.y;
        let d = alpha2 / (PI * spread * spread);
        d / (2.0 * self.seen())
    }

    /// G2/G1 of a local unit direction, 0..=1; 0 below the surface.
    pub fn weight(&self, direction: DVec3) -> f64 {
        let (l, v) = (direction.z, self.view.z);
        if l <= 0.0 {
            return 0.0;
        }
        l * self.seen() / (l * self.shadow(v) + v * self.shadow(l))
    }

    /// Fc = (1 - V·H)^5 of a local unit direction.
    pub fn fresnel(&self, direction: DVec3) -> f64 {
        let h = (direction + self.view).try_normalize().unwrap_or(DVec3::Z);
        fresnel(h.dot(self.view).max(0.0))
    }

    /// 2 N·V / G1 of the normals that are drawn.
    fn seen(&self) -> f64 {
        let cos = self.view.z;
        bound(self.alpha, cos) * cos + self.shadow(cos)
    }

    /// sqrt(α² + (1 - α²) cos²).
    fn shadow(&self, cos: f64) -> f64 {
        let alpha2 = self.alpha * self.alpha;
        (alpha2 + (1.0 - alpha2) * cos * cos).sqrt()
    }
}

impl Albedos {
    /// Directional albedo of a surface of the reflectance `f0` at normal view, light between facets included; at most
    /// 1.
    pub fn of(&self, f0: DVec3) -> DVec3 {
        (f0 * self.tinted + self.white) * self.gain(f0)
    }

    /// What light that meets several facets adds: a factor, at least 1.
    pub fn gain(&self, f0: DVec3) -> DVec3 {
        let mirror = self.tinted + self.white;
        1.0 + f0 * (1.0 / mirror - 1.0)
    }
}

/// The frame of a surface: z is its normal, the view lies in the xz plane.
pub fn frame(normal: DVec3, view: DVec3) -> Frame {
    let along = view - normal * normal.dot(view);
    match along.try_normalize() {
        Some(tangent) if along.length_squared() > 1e-24 => Frame {
            tangent,
            bitangent: normal.cross(tangent),
            normal,
        },
        _ => Frame::from_normal(normal),
    }
}

/// Diffuse reflectance under a coat that reflects `coat` toward the eye: what the coat takes, the base lacks, so that a
/// white material returns all that it receives.
///
/// * `albedo`: diffuse reflectance of the material seen along its normal, where the coat reflects `f0`.
pub fn base(albedo: DVec3, f0: DVec3, coat: DVec3) -> DVec3 {
    if f0 == DVec3::ZERO {
        return albedo;
    }
    let left = albedo * (DVec3::ONE - coat).max(DVec3::ZERO) / (DVec3::ONE - f0);
    DVec3::select(f0.cmplt(DVec3::ONE), left, DVec3::ZERO)
}

/// Share of the part of the visible cap below its middle that can mirror light from above the surface (Eto and
/// Tokuyoshi).
fn bound(alpha: f64, cos: f64) -> f64 {
    let alpha2 = alpha * alpha;
    let s2 = (1.0 + (1.0 - cos * cos).max(0.0).sqrt()).powi(2);
    (1.0 - alpha2) * s2 / (s2 + alpha2 * cos * cos)
}

fn fresnel(along: f64) -> f64 {
    (1.0 - along).max(0.0).powi(5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_furnace_returns_one_and_nothing_more() {
        for roughness in 0..=20 {
            for cos in [1e-3, 0.05, 0.3, 0.7, 1.0] {
                let alpha = (f64::from(roughness) / 20.0).powi(2);
                let albedos = Ggx::new(alpha, cos).open();
                for f0 in [0.0, 0.04, 0.5, 1.0] {
                    let found = albedos.of(DVec3::splat(f0)).x;
                    assert!(
                        (0.0..=1.0 + 1e-12).contains(&found),
                        "{roughness} {cos} {f0}: {found}"
                    );
                    assert!(
                        f0 < 1.0 || (found - 1.0).abs() < 1e-12,
                        "{roughness} {cos}: {found}"
                    );
                }
            }
        }
    }

    #[test]
    fn rough_surfaces_waste_no_points_below_themselves() {
        // Of all visible normals, those of α = 1 along the normal mirror half of the points down.
        for (alpha, cos, most) in [(1.0, 1.0, 0.0), (1.0, 0.2, 0.35), (0.5, 1.0, 0.0)] {
            let ggx = Ggx::new(alpha, cos);
            let points =
                (0..10_000).map(|k| [k / 100, k % 100].map(|k| (f64::from(k) + 0.5) / 100.0));
            let below = points.filter(|&u| ggx.sample(u).direction.z <= 0.0).count();
            assert!(below as f64 <= most * 1e4, "{alpha} {cos}: {below}");
        }
    }

    #[test]
    fn sampler_draws_what_its_density_says() {
        // The mean of a smooth function under both.
        for (alpha, cos) in [(0.3, 0.8), (0.8, 0.3), (1.0, 1.0)] {
            let ggx = Ggx::new(alpha, cos);
            let of = |l: DVec3| (2.0 + l.x) * l.z.max(0.0);
            let count = 400;
            let (mut drawn, mut summed) = (0.0, 0.0);
            for row in 0..count {
                for column in 0..count {
                    let u = [row, column].map(|k| (f64::from(k) + 0.5) / f64::from(count));
                    drawn += of(ggx.sample(u).direction);
                    let z = u[0];
                    let (s, c) = turn_sin_cos(u[1]);
                    let r = (1.0 - z * z).sqrt();
                    let l = DVec3::new(r * c, r * s, z);
                    summed += of(l) * ggx.pdf(l) * 2.0 * PI;
                }
            }
            let whole = f64::from(count * count);
            let (drawn, summed) = (drawn / whole, summed / whole);
            assert!(
                (drawn - summed).abs() < 1e-3,
                "{alpha} {cos}: {drawn} {summed}"
            );
        }
    }
}
