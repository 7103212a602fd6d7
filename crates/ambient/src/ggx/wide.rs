//! Sixteen GGX lobes at once, in f32: directions drawn from them, and what each weighs a direction with.
//! [`Ggx`](super::Ggx) is the same in f64.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use crate::lanes::{LANES, Wide, turn_sin_cos};
use std::f32::consts::PI;

/// What sixteen lobes say of a direction each.
#[derive(Debug, Clone, Copy)]
pub struct Lobes {
    /// Density per steradian of [`Ggx::sample`](super::Ggx::sample).
    pub density: Wide,
    /// G2/G1, 0..=1; 0 below the surface.
    pub weight: Wide,
    /// (1 - V·H)^5.
    pub fresnel: Wide,
}

/// The lobes of these α about unit normals, seen from unit views that stand above their surfaces, for one unit
/// direction each.
///
/// The part of the half vector along the surface is taken by itself, so that narrow lobes lose no digits at their peak.
/// What is left is the rounding of the direction: it moves the half vector by 2^-24 over |L + V|, and a density by as
/// many times 4/α.
#[inline(always)]
pub fn lobes16(alpha: &Wide, normal: &[Wide; 3], view: &[Wide; 3], direction: &[Wide; 3]) -> Lobes {
    let mut lobes = Lobes {
        density: [0.0; LANES],
        weight: [0.0; LANES],
        fresnel: [0.0; LANES],
    };
    for k in 0..LANES {
        let alpha2 = alpha[k] * alpha[k];
        let n = [normal[0][k], normal[1][k], normal[2][k]];
        let v = [view[0][k], view[1][k], view[2][k]];
        let l = [direction[0][k], direction[1][k], direction[2][k]];
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (eye, light) = (dot(n, v), dot(n, l));
        // L + V: along the normal, and the rest.
        let up = eye + light;
        let half = [0, 1, 2].map(|a: usize| l[a] + v[a] - up * n[a]);
        let along = dot(half, half);
        let square = up * up + along;
        let spread = (alpha2 * up * up + along).max(f32::MIN_POSITIVE);
        let ratio = square / spread;
        let d = alpha2 * ratio * ratio / PI;
        let shadow = |cos: f32| (alpha2 + (1.0 - alpha2) * cos * cos).sqrt();
        let (by_eye, by_light) = (shadow(eye), shadow(light));
        let is_above = if light > 0.0 { 1.0 } else { 0.0 };
        let masked = (light * by_eye + eye * by_light).max(f32::MIN_POSITIVE);
        // V·H = |L + V|/2.
        let miss = (1.0 - 0.5 * square.sqrt()).max(0.0);
        let miss2 = miss * miss;
        let slant = [0, 1, 2].map(|a: usize| v[a] - eye * n[a]);
        let far = 1.0 + dot(slant, slant).sqrt();
        let bound = (1.0 - alpha2) * far * far / (far * far + alpha2 * eye * eye);
        let seen = bound * eye + by_eye;
        lobes.density[k] = d / (2.0 * seen);
        lobes.weight[k] = is_above * light * seen / masked;
        lobes.fresnel[k] = miss2 * miss2 * miss;
    }
    lobes
}

/// The local directions that [`Ggx::sample`](super::Ggx::sample) gives points of the unit square, for lobes of these α:
/// z is the normal, and unit views are `[sin, 0, cos]`. Within 2e-6 of it.
#[inline(always)]
pub fn sample16(alpha: &Wide, [sin, cos]: [&Wide; 2], u0: &Wide, u1: &Wide) -> [Wide; 3] {
    let mut out = [[0.0; LANES]; 3];
    for k in 0..LANES {
        let (a, x, z) = (alpha[k], sin[k], cos[k]);
        let scale = 1.0 / (a * a * x * x + z * z).sqrt();
        let (leaning, up) = (a * x * scale, z * scale);
        let far = 1.0 + x;
        let whole = far * far + a * a * z * z;
        // The share of the cap below its middle that is used, and the rest.
        let (bound, rest) = (
            (1.0 - a * a) * far * far / whole,
            a * a * (z * z + far * far) / whole,
        );
        // How far the point of the cap is from the top, and how far the half vector rises, both without a difference of
        // like numbers.
        let drop = (1.0 - u0[k]) * (1.0 + bound * up);
        let rise = u0[k] * (1.0 + bound * up) + rest * up;
        let r = (drop * (rise + leaning * leaning / (1.0 + up))).sqrt();
        let (s, c) = turn_sin_cos(u1[k]);
        let h = [a * (r * c + leaning), a * r * s, rise];
        let square = h[0] * h[0] + h[1] * h[1] + h[2] * h[2];
        let along = (x * h[0] + z * h[2]).max(0.0);
        let twice = 2.0 * along / square.max(f32::MIN_POSITIVE);
        out[0][k] = twice * h[0] - x;
        out[1][k] = twice * h[1];
        out[2][k] = twice * h[2] - z;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ggx::{Ggx, frame};
    use crate::sampling::{Mixture, Stream};
    use glam::DVec3;

    #[test]
    fn sixteen_lobes_are_those_of_64_bits() {
        let stream = Stream::new(2, 0, 0, 0, 0);
        let mut tried = 0;
        for i in 0..20_000 {
            let [u0, u1, v0, v1] = stream.point(i);
            let normal = (Mixture::UNIFORM.sample([v0, u1]) - 0.5 * DVec3::Y).normalize();
            let alpha = 0.01 + 0.99 * v1 * v1;
            let cos = [0.01, 0.3, 0.9, 1.0][i as usize % 4];
            let ggx = Ggx::new(alpha, cos);
            let tangent = normal.any_orthonormal_vector();
            let view = (normal * cos + tangent * (1.0 - cos * cos).sqrt()).normalize();
            // In and about the lobe, and anywhere.
            let local = match i % 3 {
                0 => Mixture::BALANCED.sample([u0, u1]),
                _ => ggx.sample([u0, u1]).direction,
            };
            let direction = frame(normal, view).to_world(local);
            let wide = |v: DVec3| v.to_array().map(|a| [a as f32; LANES]);
            let alphas = [alpha as f32; LANES];
            let found = lobes16(&alphas, &wide(normal), &wide(view), &wide(direction));
            // Rounding the direction moves a height above the horizon by up to 1e-7.
            if local.z.abs() < 1e-2 {
                continue;
            }
            let moved = 0.5_f64.powi(24) / (local + ggx.view()).length();
            let near = |found: f32, exact: f64, slope: f64, what: &str| {
                let error = (f64::from(found) - exact).abs();
                // Several roundings: of L, V, N and their products.
                assert!(
                    error <= exact * (1e-5 + 4.0 * slope * moved) + 1e-6,
                    "{what} of {alpha} at {local}, N.V {cos}: {found} for {exact}"
                );
            };
            near(found.density[5], ggx.pdf(local), 4.0 / alpha, "density");
            near(found.weight[5], ggx.weight(local), 1.0, "weight");
            near(found.fresnel[5], ggx.fresnel(local), 5.0, "Fc");
            tried += 1;
        }
        assert!(tried > 10_000, "{tried}");
    }

    #[test]
    fn sixteen_lobes_draw_the_directions_of_the_scalar_sampler() {
        for (number, (alpha, cos)) in [
            (1e-4, 0.3),
            (0.0025, 1.0),
            (0.04, 0.7),
            (0.25, 1.0),
            (0.25, 0.05),
            (1.0, 0.4),
        ]
        .into_iter()
        .enumerate()
        {
            let ggx = Ggx::new(alpha, cos);
            let [sin, cos] = [ggx.view().x, ggx.view().z].map(|of| [of as f32; LANES]);
            let stream = Stream::new(11, 0, number as u32, 0, 0);
            for i in 0..2048 {
                let u = stream.point(i);
                // A point that both have to the last bit.
                let [u0, u1] = [u[0], u[1]].map(|u| u as f32);
                let found = sample16(
                    &[alpha as f32; LANES],
                    [&sin, &cos],
                    &[u0; LANES],
                    &[u1; LANES],
                );
                let exact = ggx.sample([u0.into(), u1.into()]).direction;
                let found = DVec3::from(found.map(|axis| f64::from(axis[7])));
                let off = (found - exact).length();
                assert!(
                    off < 2e-6,
                    "alpha {alpha}, {u0} {u1}: {found} for {exact}, {off:e}"
                );
            }
        }
    }
}
