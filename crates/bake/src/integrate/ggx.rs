//! The GGX lobe of a texel, by directions drawn from the normals that the eye sees.
//!
//! Each direction weighs `F G2/G1` in three channels. Sums of open directions are divided by those of all, as for the other terms: an open
//! texel is exactly 1, and the colour of an occluded highlight is right, because F stands inside of both sums. What an open texel reflects
//! is [`Ggx::open`], which [`colours`] gives. Under a map every direction counts its own radiance.

use super::estimate::variance_of_mean;
use super::gang::Beside;
use super::sums::GlossSums;
use super::task::Task;
use super::terms::Terms;
use crate::labels;
use crate::options::{Effort, Shading};
use crate::survey::Texel;
use ambient::ggx::{Ggx, alpha_of, base, frame};
use ambient::sampling::LANES;
use ambient::{Estimate, Frame};
use glam::DVec3;
use rays::{PhongMaterial, Ray};

/// Points of each replicate in the first round of a bake with a target.
const FIRST_ROUND: u32 = 16;

/// Least α of lobes that hemisphere rays count for: roughness 0.39. From there on they lower the error of most scenes, by half at best; it rises, more so
/// below, where the lobe's own points follow the border of what is open, as in a corner seen along its normal (docs/theory.md).
const LEAST_ALPHA: f64 = 0.15;

/// Independent sets of the lobe's own points: more than the hemisphere has, because no neighbour shares what their spread tells.
const REPLICATES: usize = 4;

/// Means over the points of one or more replicates: each technique's sums over its own points, added.
#[derive(Clone, Copy)]
struct Means {
    open: [f64; 2],
    all: [f64; 2],
    light: [DVec3; 2],
}

/// What the rays of a texel say of its lobe.
struct Gathered<'a> {
    drawn: [GlossSums; REPLICATES],
    beside: Option<&'a Beside>,
}

impl Means {
    /// Of techniques, each with the sums of some of its replicates.
    fn of<'s>(techniques: impl IntoIterator<Item = &'s [GlossSums]>) -> Self {
        let mut means = Self {
            open: [0.0; 2],
            all: [0.0; 2],
            light: [DVec3::ZERO; 2],
        };
        for replicates in techniques {
            let mut sums = GlossSums::default();
            replicates.iter().for_each(|&replicate| sums += replicate);
            let scale = 1.0 / f64::from(sums.points.max(1));
            for k in 0..2 {
                means.open[k] += scale * sums.open[k];
                means.all[k] += scale * sums.all[k];
                means.light[k] += scale * sums.light[k];
            }
        }
        means
    }

    /// The open share without colour.
    fn share(&self) -> f64 {
        if self.all[0] > 0.0 {
            self.open[0] / self.all[0]
        } else {
            0.0
        }
    }

    /// The light that arrives and what would under a sky of 1, both in the colour of F.
    fn light(&self, task: &Task<'_>, f0: DVec3) -> [DVec3; 2] {
        let tinted = |[plain, white]: [f64; 2]| f0 * (plain - white) + white;
        let [plain, white] = self.light;
        let above = task.sky.map().map_or(DVec3::ZERO, |map| {
            (f0 * (plain - white) + white) * map.scale()
        });
        [
            task.sky.floor() * tinted(self.open) + above,
            tinted(self.all),
        ]
    }

    fn reflection(&self, task: &Task<'_>, f0: DVec3) -> DVec3 {
        let [light, tint] = self.light(task, f0);
        let ratio = |light: f64, tint: f64| if tint > 0.0 { light / tint } else { 0.0 };
        DVec3::new(
            ratio(light.x, tint.x),
            ratio(light.y, tint.y),
            ratio(light.z, tint.z),
        )
    }
}

impl Gathered<'_> {
    /// The replicates of each technique.
    fn techniques(&self) -> impl Iterator<Item = &[GlossSums]> {
        let beside = self.beside.map(|beside| &beside.sums[..]);
        [&self.drawn[..]].into_iter().chain(beside)
    }

    /// Means over two independent halves of the rays.
    fn halves(&self) -> [Means; 2] {
        let halves = |half: usize| {
            self.techniques().map(move |replicates| {
                let (first, second) = replicates.split_at(replicates.len() / 2);
                [first, second][half]
            })
        };
        [Means::of(halves(0)), Means::of(halves(1))]
    }

    /// The variance of what the techniques add up to, from an error of each replicate's means.
    fn variance(&self, error: impl Fn(&Means) -> f64) -> f64 {
        self.techniques()
            .map(|replicates| {
                let of = |replicate| error(&Means::of([std::slice::from_ref(replicate)]));
                variance_of_mean(&replicates.iter().map(of).collect::<Vec<_>>())
            })
            .sum()
    }

    fn share(&self, known: bool) -> Estimate {
        let all = Means::of(self.techniques());
        let share = all.share();
        let error =
            |own: &Means| (own.open[0] - share * own.all[0]) / all.all[0].max(f64::MIN_POSITIVE);
        Estimate {
            value: share,
            std_err: self.variance(error).sqrt().max(self.floor(known)),
        }
    }

    /// The mean of the channels is what the error is stated of.
    fn reflection(&self, task: &Task<'_>, f0: DVec3, known: bool) -> Estimate<DVec3> {
        let all = Means::of(self.techniques());
        let value = all.reflection(task, f0);
        let [_, whole] = all.light(task, f0);
        let mean = |rgb: DVec3| rgb.element_sum() / 3.0;
        let error = |own: &Means| {
            let [light, tint] = own.light(task, f0);
            mean((light - value * tint) / whole.max(DVec3::splat(f64::MIN_POSITIVE)))
        };
        let least = mean(task.sky.mean()) * self.floor(known);
        Estimate {
            value,
            std_err: self.variance(error).sqrt().max(least),
        }
    }

    /// 1.5/N where all N rays agree: the rule of three. Only the rays that the lobe drew are counted; those of the hemisphere may have missed it.
    fn floor(&self, known: bool) -> f64 {
        let rays = || self.techniques().flatten();
        let agree = rays().all(|s| s.open[0] == s.all[0]) || rays().all(|s| s.open[0] == 0.0);
        let points: u32 = self.drawn.iter().map(|s| s.points).sum();
        match agree && !known {
            true => 1.5 / f64::from(points.max(1)),
            false => 0.0,
        }
    }
}

/// What hemisphere rays may bring to the lobes of the texels that `reflects` names; nothing where it is of no use to any.
pub(super) fn beside(texels: &[Texel], reflects: &[bool]) -> Vec<Beside> {
    let shares = |(texel, reflects): (&Texel, &bool)| Beside {
        shares: *reflects && alpha_of(texel.material.exponent) >= LEAST_ALPHA,
        ..Beside::default()
    };
    let beside: Vec<Beside> = texels.iter().zip(reflects).map(shares).collect();
    match beside.iter().any(|beside| beside.shares) {
        true => beside,
        false => Vec::new(),
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
pub(super) fn terms(task: &Task<'_>, texel: &Texel, beside: Option<&Beside>) -> Terms {
    let sky = task.sky.floor();
    let known = texel.open && task.sky.map().is_none();
    if known && (task.shading == Shading::Production || !texel.tilted) {
        return Terms {
            specular: Estimate::exact(1.0),
            reflection: Estimate::exact(sky),
            ..Terms::default()
        };
    }
    // A replicate without hemisphere rays would have half of the integral.
    let beside = beside.filter(|beside| beside.sums.iter().all(|sums| sums.points > 0));
    let mut gathered = Gathered {
        drawn: Default::default(),
        beside,
    };
    let mut rays = 0;
    let mut cast = |sums: &mut [GlossSums], range: std::ops::Range<u32>| {
        for (replicate, sums) in sums.iter_mut().enumerate() {
            let stream = task.stream(texel.x, texel.y, labels::LOBE, replicate as u32);
            for point in range.clone() {
                rays += u64::from(add(task, texel, beside, stream.point(point), sums));
            }
        }
    };
    match task.effort {
        Effort::Rays(count) => cast(&mut gathered.drawn, 0..(count / REPLICATES as u32).max(1)),
        Effort::Target {
            error,
            relative,
            max_rays,
        } => {
            let most = (max_rays / REPLICATES as u32).max(1);
            let mut range = 0..FIRST_ROUND.min(most);
            while !range.is_empty() {
                cast(&mut gathered.drawn, range.clone());
                let share = gathered.share(known);
                if share.std_err <= error.max(relative * share.value) {
                    break;
                }
                range = range.end..(2 * range.end).min(most);
            }
        }
    }
    let f0 = texel.material.specular.min(DVec3::ONE);
    let halves = gathered.halves();
    let mut terms = Terms {
        specular: gathered.share(known),
        reflection: gathered.reflection(task, f0, known),
        rays,
        ..Terms::default()
    };
    terms.halves.specular = 0.5 * (halves[0].share() - halves[1].share());
    let [a, b] = halves.map(|half| half.reflection(task, f0));
    terms.halves.reflection = 0.5 * (a - b);
    terms
}

/// Adds one point; true where it took a ray.
fn add(
    task: &Task<'_>,
    texel: &Texel,
    beside: Option<&Beside>,
    [u0, u1, v0, v1]: [f64; 4],
    sums: &mut GlossSums,
) -> bool {
    let (surface, origin) = texel.start([v0, v1]);
    let view = task.view_from(surface.position, surface.normal);
    let ggx = Ggx::new(alpha_of(texel.material.exponent), surface.normal.dot(view));
    let drawn = ggx.sample([u0, u1]);
    sums.points += 1;
    if drawn.weight <= 0.0 {
        return false;
    }
    let direction = frame(surface.normal, view).to_world(drawn.direction);
    let weight = match beside {
        None => drawn.weight,
        Some(beside) => {
            let own = ggx.pdf(drawn.direction);
            let other = density(task, beside, surface.normal, direction);
            drawn.weight * own / (own + other)
        }
    };
    let weights = [weight, weight * drawn.fresnel];
    let add = |sums: &mut [f64; 2]| sums.iter_mut().zip(weights).for_each(|(s, w)| *s += w);
    add(&mut sums.all);
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
        add(&mut sums.open);
        let light = above(task, direction);
        for (sum, weight) in sums.light.iter_mut().zip(weights) {
            *sum += weight * light;
        }
    }
    !texel.open
}

/// Density per steradian of the hemisphere rays of a texel at a direction above its surface.
fn density(task: &Task<'_>, beside: &Beside, normal: DVec3, direction: DVec3) -> f64 {
    let local = Frame::from_normal(normal).to_local(direction);
    let even = task.mixture.pdf(local);
    match &beside.guide {
        None => even,
        Some(guide) => even * guide.density(task.mixture.invert(local)),
    }
}

/// Light of the sky's map above its floor from a direction, over its scale.
fn above(task: &Task<'_>, direction: DVec3) -> DVec3 {
    let Some(map) = task.sky.map() else {
        return DVec3::ZERO;
    };
    let lanes = direction.as_vec3().to_array().map(|axis| [axis; LANES]);
    DVec3::from(map.excess(map.texels16(&lanes)[0]).map(f64::from))
}
