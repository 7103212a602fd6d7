//! The GGX lobe of a texel, by directions drawn from the normals that the eye sees.
//!
//! Each direction weighs `F G2/G1` in three channels. Sums of open directions are divided by those of all, as for the other terms: an open
//! texel is exactly 1, and the colour of an occluded highlight is right, because F stands inside of both sums. What an open texel reflects
//! is [`Ggx::open`], which [`colours`] gives. Under a map every direction counts its own radiance.

use super::sums::REPLICATES;
use super::task::Task;
use super::terms::Terms;
use crate::labels;
use crate::options::{Effort, Shading};
use crate::survey::Texel;
use ambient::Estimate;
use ambient::ggx::{Ggx, alpha_of, base, frame};
use ambient::sampling::LANES;
use glam::DVec3;
use rays::{PhongMaterial, Ray};

/// Points of each replicate in the first round of a bake with a target.
const FIRST_ROUND: u32 = 16;

/// Sums over the points of one replicate.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Weights without colour.
    open: f64,
    all: f64,
    /// Weights with Fresnel's colour; of open directions times the light.
    light: DVec3,
    tint: DVec3,
    points: u32,
}

impl Sums {
    fn plus(mut self, other: &Self) -> Self {
        self.open += other.open;
        self.all += other.all;
        self.light += other.light;
        self.tint += other.tint;
        self.points += other.points;
        self
    }

    fn share(&self) -> f64 {
        if self.all > 0.0 {
            self.open / self.all
        } else {
            0.0
        }
    }

    fn reflection(&self) -> DVec3 {
        let ratio = |light: f64, tint: f64| if tint > 0.0 { light / tint } else { 0.0 };
        DVec3::new(
            ratio(self.light.x, self.tint.x),
            ratio(self.light.y, self.tint.y),
            ratio(self.light.z, self.tint.z),
        )
    }
}

/// Diffuse and specular reflectance of an open texel with this material, whose view makes `cos` with its normal.
pub(crate) fn colours(material: &PhongMaterial, cos: f64) -> [DVec3; 2] {
    let f0 = material.specular.min(DVec3::ONE);
    if f0 == DVec3::ZERO {
        return [material.albedo, DVec3::ZERO];
    }
    let coat = Ggx::new(alpha_of(material.exponent), cos).open().of(f0);
    [base(material.albedo, f0, coat), coat]
}

/// The specular terms of a texel; the others are 0.
pub(crate) fn terms(task: &Task<'_>, texel: &Texel) -> Terms {
    let sky = task.sky.floor();
    let known = texel.open && task.sky.map().is_none();
    if known && (task.shading == Shading::Production || !texel.tilted) {
        return Terms {
            specular: Estimate::exact(1.0),
            reflection: Estimate::exact(sky),
            ..Terms::default()
        };
    }
    let mut sums = [Sums::default(); REPLICATES as usize];
    let mut rays = 0;
    let mut cast = |sums: &mut [Sums], range: std::ops::Range<u32>| {
        for (replicate, sums) in sums.iter_mut().enumerate() {
            let stream = task.stream(texel.x, texel.y, labels::LOBE, replicate as u32);
            for point in range.clone() {
                rays += u64::from(add(task, texel, stream.point(point), sums));
            }
        }
    };
    match task.effort {
        Effort::Rays(count) => cast(&mut sums, 0..(count / REPLICATES).max(1)),
        Effort::Target {
            error,
            relative,
            max_rays,
        } => {
            let most = (max_rays / REPLICATES).max(1);
            let mut range = 0..FIRST_ROUND.min(most);
            while !range.is_empty() {
                cast(&mut sums, range.clone());
                let share = share_of(&sums, known);
                if share.std_err <= error.max(relative * share.value) {
                    break;
                }
                range = range.end..(2 * range.end).min(most);
            }
        }
    }
    let light = |sums: &Sums| sums.reflection();
    let all = sums.iter().fold(Sums::default(), |a, b| a.plus(b));
    let halves = [sums[0].plus(&sums[2]), sums[1].plus(&sums[3])];
    let share = share_of(&sums, known);
    let mean = |rgb: DVec3| rgb.element_sum() / 3.0;
    let least = mean(task.sky.mean()) * floor(&sums, known);
    let mut terms = Terms {
        specular: share,
        reflection: Estimate {
            value: light(&all),
            std_err: spread(&sums.map(|s| mean(light(&s)))).max(least),
        },
        rays,
        ..Terms::default()
    };
    terms.halves.specular = 0.5 * (halves[0].share() - halves[1].share());
    terms.halves.reflection = 0.5 * (light(&halves[0]) - light(&halves[1]));
    terms
}

fn share_of(sums: &[Sums; REPLICATES as usize], known: bool) -> Estimate {
    let all = sums.iter().fold(Sums::default(), |a, b| a.plus(b));
    Estimate {
        value: all.share(),
        std_err: spread(&sums.map(|s| s.share())).max(floor(sums, known)),
    }
}

/// The standard error of the mean of independent values.
fn spread(values: &[f64; REPLICATES as usize]) -> f64 {
    let count = f64::from(REPLICATES);
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (squares / (count * (count - 1.0))).sqrt()
}

/// 1.5/N where all N rays agree: the rule of three.
fn floor(sums: &[Sums; REPLICATES as usize], known: bool) -> f64 {
    let agree = sums.iter().all(|s| s.open == s.all) || sums.iter().all(|s| s.open == 0.0);
    let points: u32 = sums.iter().map(|s| s.points).sum();
    match agree && !known {
        true => 1.5 / f64::from(points.max(1)),
        false => 0.0,
    }
}

/// Adds one point; true where it took a ray.
fn add(task: &Task<'_>, texel: &Texel, [u0, u1, v0, v1]: [f64; 4], sums: &mut Sums) -> bool {
    let (surface, origin) = texel.start([v0, v1]);
    let view = task.view_from(surface.position, surface.normal);
    let ggx = Ggx::new(alpha_of(texel.material.exponent), surface.normal.dot(view));
    let drawn = ggx.sample([u0, u1]);
    sums.points += 1;
    if drawn.weight <= 0.0 {
        return false;
    }
    let f0 = texel.material.specular.min(DVec3::ONE);
    let tint = drawn.weight * (f0 * (1.0 - drawn.fresnel) + drawn.fresnel);
    sums.all += drawn.weight;
    sums.tint += tint;
    let direction = frame(surface.normal, view).to_world(drawn.direction);
    let Some(ray) = surface.leaving(task.shading, direction) else {
        return false;
    };
    let blocked = !texel.open
        && task.backend.occluded(&Ray {
            origin,
            direction: ray.as_vec3().to_array(),
            t_min: 0.0,
            t_max: task.t_max,
        });
    if !blocked {
        sums.open += drawn.weight;
        sums.light += tint * radiance(task, direction);
    }
    !texel.open
}

/// The sky's radiance from a direction.
fn radiance(task: &Task<'_>, direction: DVec3) -> DVec3 {
    let floor = task.sky.floor();
    let Some(map) = task.sky.map() else {
        return floor;
    };
    let lanes = direction.as_vec3().to_array().map(|axis| [axis; LANES]);
    let excess = map.excess(map.texels16(&lanes)[0]).map(f64::from);
    floor + DVec3::from(excess) * map.scale()
}
