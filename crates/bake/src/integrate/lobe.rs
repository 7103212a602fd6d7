//! The highlight of a texel: what its lobe is, and how many rays it is worth.
//!
//! What is asked for is a sum, of what the base reflects and what the coat does. A coat of 4 % adds 4 % of its lobe's
//! error to it, so a few rays are enough, or none: a rough lobe is told by the hemisphere's rays. With errors that fall
//! like N^-3/4 the error of a sum is least, at a given cost, where a term takes `(weight² variance / cost)^(2/5)` as
//! many as one that weighs 1. The hemisphere weighs what its base reflects, but not less than a quarter: its terms are
//! layers of their own too.

use super::task::Task;
use crate::options::{Model, View};
use crate::survey::Texel;
use ambient::ggx::{Albedos, Ggx, alpha_of, base};
use glam::DVec3;
use rays::PhongMaterial;

/// Least α of lobes that hemisphere rays count for: roughness 0.39. From there on they lower the error of most scenes,
/// by half at best; it rises, more so below, where the lobe's own points follow the border of what is open, as in a
/// corner seen along its normal (docs/microfacets.md).
const LEAST_ALPHA: f64 = 0.15;

/// Least weight of the hemisphere.
const LEAST_BASE: f64 = 0.25;

/// Fewest rays of a lobe for each ray of the hemisphere.
const LEAST_SHARE: f64 = 1.0 / 64.0;

/// Rays that a lobe of weight 1 is worth for each ray of the hemisphere: of the least error at a given cost it has
/// `(variance / cost)^(2/5)`, its variance is two thirds of the hemisphere's and a ray of it costs 1.75 times as much.
const WORTH: f64 = 0.67;

/// The same where hemisphere rays count for the lobe too. A quarter of their number leaves a metal an error as large as
/// that of the diffuse term.
const WORTH_BESIDE: f64 = 0.3;

/// Least α of lobes that have no rays of their own where they are worth no more than the share [`FAINT`]: roughness
/// 0.5. What hemisphere rays weigh for them is 4 at most along the normal, so that 64 of these tell more than a few
/// of their own, which would cost as much as all else of a texel.
const BROAD: f64 = 0.25;
const FAINT: f32 = 1.0 / 32.0;

/// The lobe of a texel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lobe {
    /// α of GGX; not used under Phong.
    pub alpha: f32,
    /// 1 / (n + 1) of Phong; not used under GGX.
    pub scale: f32,
    /// Its rays for each ray of the hemisphere: a power of two, 1 at most; 0 where those of the hemisphere serve alone.
    pub share: f32,
    /// Rays of the hemisphere count for it too.
    pub joins: bool,
    /// What all directions weigh together, without colour and times (1 - V·H)^5. 1 and 0 under Phong.
    pub whole: [f64; 2],
    /// Reflectance along the normal, which colours GGX; `None` under Phong, whose colour is a factor.
    pub f0: Option<DVec3>,
}

/// How many rays lobes have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LobeRays {
    /// As many as the hemisphere.
    Full,
    /// What they are worth by themselves.
    Alone,
    /// The same beside rays of the hemisphere, which count for broad lobes of GGX too.
    Beside,
}

impl LobeRays {
    fn of(task: &Task<'_>) -> Self {
        // For the light of a map none of the hemisphere's count.
        match task.hemisphere && task.sky.map().is_none() {
            _ if task.full_lobes => Self::Full,
            true => Self::Beside,
            false => Self::Alone,
        }
    }
}

/// What an open texel reflects.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coat {
    /// Diffuse reflectance: under GGX what the coat leaves of it.
    pub base: DVec3,
    /// Specular reflectance.
    pub specular: DVec3,
    /// Share of it that light of the coloured part of the lobe has; the rest is Fresnel's white.
    pub tint: DVec3,
    /// Rays of its lobe for each ray of the hemisphere.
    pub share: f32,
    /// Without colour, of GGX.
    open: Albedos,
}

impl Coat {
    /// Of a material whose view makes `cos` with its normal.
    pub fn of(model: Model, rays: LobeRays, material: &PhongMaterial, cos: f64) -> Self {
        let PhongMaterial {
            albedo,
            specular,
            exponent,
        } = *material;
        let none = Albedos {
            tinted: 1.0,
            white: 0.0,
        };
        let f0 = specular.min(DVec3::ONE);
        let is_broad = model == Model::Ggx && alpha_of(exponent) >= LEAST_ALPHA;
        let open = match model {
            Model::Phong => none,
            Model::Ggx => Ggx::new(alpha_of(exponent), cos).open(),
        };
        let [base, specular] = match model {
            Model::Ggx if f0 != DVec3::ZERO => {
                let specular = open.of(f0);
                [base(albedo, f0, specular), specular]
            }
            _ => [albedo, specular],
        };
        let mirror = f0 * open.tinted + open.white;
        let tinted = f0 * (open.tinted + open.white);
        Self {
            base,
            specular,
            tint: tinted / mirror.max(DVec3::splat(f64::MIN_POSITIVE)),
            share: match rays {
                LobeRays::Full => 1.0,
                LobeRays::Beside if is_broad => share(weight(base, specular), WORTH_BESIDE),
                _ => share(weight(base, specular), WORTH),
            },
            open,
        }
    }

    /// Those of texels; many have the material and the view of the one before.
    pub fn of_all(task: &Task<'_>, texels: &[Texel]) -> Vec<Self> {
        let mut last: Option<(PhongMaterial, f64, Self)> = None;
        let mut of = |texel: &Texel| {
            let cos = match task.view {
                View::Normal => 1.0,
                View::Eye(_) => {
                    let view = task.view_from(texel.position, texel.normal);
                    texel.normal.dot(view)
                }
            };
            match last {
                Some((material, seen, coat)) if material == texel.material && seen == cos => coat,
                _ => {
                    let coat = Self::of(task.model, LobeRays::of(task), &texel.material, cos);
                    last = Some((texel.material, cos, coat));
                    coat
                }
            }
        };
        texels.iter().map(&mut of).collect()
    }
}

impl Lobe {
    /// The lobe of a texel that reflects; `closed` where its hemisphere is known without rays.
    pub fn of(task: &Task<'_>, material: &PhongMaterial, coat: &Coat, closed: bool) -> Self {
        let Albedos { tinted, white } = coat.open;
        let plain = Self {
            alpha: 1.0,
            scale: (1.0 / (material.exponent + 1.0)) as f32,
            share: coat.share,
            joins: false,
            whole: [tinted + white, white],
            f0: None,
        };
        if task.model == Model::Phong {
            return plain;
        }
        let alpha = alpha_of(material.exponent);
        // There are no rays over the hemisphere where it is known, and none count for the light of a map.
        let joins = alpha >= LEAST_ALPHA && task.hemisphere && !closed;
        let is_served = joins && alpha >= BROAD && coat.share <= FAINT && task.sky.map().is_none();
        Self {
            alpha: alpha.max(ambient::ggx::LEAST_ALPHA) as f32,
            joins,
            share: if is_served { 0.0 } else { coat.share },
            f0: Some(material.specular.min(DVec3::ONE)),
            ..plain
        }
    }

    /// The share of its rays among `rays`: an even number, 1 of 1, or none.
    pub fn rays(&self, rays: u32) -> u32 {
        if self.share == 0.0 {
            return 0;
        }
        let own = (f64::from(rays) * f64::from(self.share)) as u32;
        own.next_multiple_of(2).clamp(2.min(rays), rays)
    }

    /// Light, in units of what an open texel of this colour would reflect of a sky of 1: `sums` are light without
    /// colour and times (1 - V·H)^5.
    pub fn tinted(&self, [plain, white]: [DVec3; 2]) -> DVec3 {
        let Some(f0) = self.f0 else {
            return plain / self.whole[0];
        };
        let [all, all_white] = self.whole;
        let mirror = f0 * (all - all_white) + all_white;
        (f0 * (plain - white) + white) / mirror.max(DVec3::splat(f64::MIN_POSITIVE))
    }
}

/// How much of a lobe comes through, beside a base.
fn weight(base: DVec3, lobe: DVec3) -> f64 {
    let beside = base.max_element().clamp(LEAST_BASE, 1.0);
    (lobe.max_element() / beside).clamp(0.0, 1.0)
}

/// Rays for each ray of the hemisphere, of a lobe that comes through with a weight and is worth so many: down to a
/// power of two.
fn share(weight: f64, worth: f64) -> f32 {
    (worth * weight.powf(0.8))
        .log2()
        .floor()
        .exp2()
        .clamp(LEAST_SHARE, 1.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_of_a_lobe_is_the_mean_of_its_two_shares_by_its_tint() {
        for (f0, roughness, cos) in [
            (DVec3::new(0.9, 0.5, 0.0), 0.2, 1.0),
            (DVec3::splat(0.04), 0.9, 0.3),
        ] {
            let exponent = (1.0 / f64::powi(roughness, 4) - 1.0) / 2.0;
            let material = PhongMaterial {
                albedo: DVec3::splat(0.5),
                specular: f0,
                exponent,
            };
            let Coat { tint, open, .. } = Coat::of(Model::Ggx, LobeRays::Full, &material, cos);
            let lobe = Lobe {
                alpha: 0.0,
                scale: 0.0,
                share: 1.0,
                joins: false,
                whole: [open.tinted + open.white, open.white],
                f0: Some(f0),
            };
            let (open, white) = (0.7, 0.2);
            let light =
                lobe.tinted([open * lobe.whole[0], white * lobe.whole[1]].map(DVec3::splat));
            let mean = tint * open + (DVec3::ONE - tint) * white;
            assert!(
                (light - mean).abs().max_element() < 1e-12,
                "{light} for {mean}"
            );
        }
    }
}
