//! Rays meet mathematics: the terms of one texel, from rays or in closed form.
//!
//! **Hemisphere terms.** Directions follow one mixture of cosine-weighted and uniform directions with solid-angle
//! density `(2 a mu + b) / 2 pi`, `mu = cos(theta)`, `a + b = 1`, by one analytic inverse, so that a single
//! low-discrepancy set serves the diffuse term (weight `2 mu / (2 a mu + b)`) and the visibility (weight
//! `1 / (2 a mu + b)`) with bounded weights. Both are divided by the sum of the weights drawn, which makes an open texel
//! exactly 1 and a closed one exactly 0; the ratio's bias is of the order of the weights' own integration error
//! squared and vanishes beside the variance (see the tests).
//!
//! **Specular term.** Its own directions from the lobe about the mirrored view R, density `(n+1)/2pi (R.L)^n`, so every
//! open ray counts 1. Directions below the shading or the geometric horizon count 0 and cost no ray.
//!
//! **Error.** The points of a texel come from [`REPLICATES`] independent randomisations; the standard error of their
//! mean is the spread of the replicates.

use crate::backend::RayBackend;
use crate::options::View;
use crate::surface::Sample;
use crate::texel::Survey;
use crate::world::World;
use ambient::Frame;
use ambient::closed_form;
use ambient::sampling::{BATCH, Lobe, Mixture, Stream};
use embree::{Coherence, RayPacket};
use glam::DVec3;

/// Independent randomisations of a texel's points.
pub const REPLICATES: u32 = 4;

/// Stream labels: which integral a texel's points serve.
pub(crate) mod term {
    pub const SURVEY: u32 = 0;
    pub const HEMISPHERE: u32 = 1;
    pub const LOBE: u32 = 2;
    pub const VALIDITY: u32 = 3;
}

/// Rays of the `validity` layer.
const VALIDITY_RAYS: u32 = 16;

/// Points of a texel whose terms have a closed form at every point: they only average over the footprint.
const CLOSED_FORM_POINTS: u32 = 64;

/// What a texel is integrated with.
pub(crate) struct Task<'a> {
    pub backend: &'a dyn RayBackend,
    pub rays: u32,
    pub view: View,
    pub t_max: f32,
    /// How hemisphere directions are drawn.
    pub mixture: Mixture,
    pub specular: bool,
    /// A layer needs the hemisphere.
    pub hemisphere: bool,
    /// The bent normal is asked for.
    pub bent: bool,
    /// Nothing stands above the texel: no ray is cast.
    pub open: bool,
}

/// The integrated terms of one texel, normalised as the contract says: 1 is open.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Terms {
    /// Open solid angle / 2 pi.
    pub visibility: f64,
    /// (1/pi) times the integral of V cos.
    pub diffuse: f64,
    /// ((n+1)/2pi) times the integral of V (R.V)^n.
    pub specular: f64,
    /// Cosine-weighted mean open direction, not normalised.
    pub bent: DVec3,
    /// Standard errors of diffuse, visibility and specular.
    pub errors: [f64; 3],
    /// Rays spent.
    pub rays: u64,
}

/// Integrates one texel.
pub(crate) fn integrate(
    task: &Task<'_>,
    survey: &Survey<'_>,
    stream: impl Fn(u32, u32) -> Stream,
) -> Terms {
    let tilted = || !survey.patches().iter().all(|p| p.is_flat());
    let sampled = matches!(task.view, View::Eye(_)) || task.bent;
    if task.open && !(sampled && tilted()) {
        return open_terms(task, survey, stream);
    }
    let mut hemisphere = Replicates::default();
    let mut lobe = Replicates::default();
    for (replicate, points) in shares(task.rays) {
        if task.hemisphere {
            let stream = stream(term::HEMISPHERE, replicate);
            hemisphere.push(hemisphere_sums(task, survey, &stream, points));
        }
        if task.specular {
            let stream = stream(term::LOBE, replicate);
            lobe.push(lobe_sums(task, survey, &stream, points));
        }
    }
    Terms {
        diffuse: hemisphere.ratio(|s| s.diffuse),
        visibility: hemisphere.ratio(|s| s.visibility),
        specular: lobe.ratio(|s| s.diffuse),
        bent: hemisphere.sums.iter().map(|s| s.bent).sum(),
        errors: [
            hemisphere.error(|s| s.diffuse),
            hemisphere.error(|s| s.visibility),
            lobe.error(|s| s.diffuse),
        ],
        rays: hemisphere.rays() + lobe.rays(),
    }
}

/// `(replicate, points)`: `total` points dealt out as evenly as whole numbers allow.
fn shares(total: u32) -> impl Iterator<Item = (u32, u32)> {
    let replicates = REPLICATES.min(total);
    (0..replicates).map(move |r| (r, total / replicates + u32::from(r < total % replicates)))
}

/// Weighted hits and weights of one replicate.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    /// (open, all) weights of the diffuse term; of the lobe for the specular term.
    diffuse: (f64, f64),
    visibility: (f64, f64),
    bent: DVec3,
    rays: u64,
}

#[derive(Default)]
struct Replicates {
    sums: Vec<Sums>,
}

impl Replicates {
    fn push(&mut self, sums: Sums) {
        self.sums.push(sums);
    }

    fn rays(&self) -> u64 {
        self.sums.iter().map(|s| s.rays).sum()
    }

    fn ratio(&self, of: impl Fn(&Sums) -> (f64, f64)) -> f64 {
        let (open, all) = self
            .sums
            .iter()
            .map(of)
            .fold((0.0, 0.0), |a, s| (a.0 + s.0, a.1 + s.1));
        if all > 0.0 { open / all } else { 0.0 }
    }

    /// Standard error of the mean over replicates; 0 where there is only one.
    fn error(&self, of: impl Fn(&Sums) -> (f64, f64)) -> f64 {
        let values: Vec<f64> = self
            .sums
            .iter()
            .map(|s| {
                let (open, all) = of(s);
                if all > 0.0 { open / all } else { 0.0 }
            })
            .collect();
        standard_error(&values)
    }
}

/// Standard error of the mean of independent values of equal variance; 0 for fewer than two.
fn standard_error(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    if n < 2.0 {
        return 0.0;
    }
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (squares / (n * (n - 1.0))).sqrt()
}

/// Casts `points` mixture directions over the hemisphere of the shading normal.
fn hemisphere_sums(task: &Task<'_>, survey: &Survey<'_>, stream: &Stream, points: u32) -> Sums {
    let mut sums = Sums::default();
    let mut caster = Caster::new(task);
    for first in (0..points).step_by(BATCH) {
        let lanes = BATCH.min((points - first) as usize);
        let [u0, u1, p0, p1] = stream.points16(first);
        let mut cosines = [0.0; BATCH];
        let mut directions = [DVec3::ZERO; BATCH];
        for lane in 0..lanes {
            let sample = survey.sample([p0[lane], p1[lane]]);
            let local = task.mixture.sample([u0[lane], u1[lane]]);
            cosines[lane] = local.z;
            directions[lane] = Frame::from_normal(sample.normal).to_world(local);
            caster.add(lane, &sample, directions[lane]);
        }
        let open = caster.cast();
        for lane in 0..lanes {
            let diffuse = task.mixture.diffuse_weight(cosines[lane]);
            let visibility = task.mixture.visibility_weight(cosines[lane]);
            sums.diffuse.1 += diffuse;
            sums.visibility.1 += visibility;
            if open >> lane & 1 == 1 {
                sums.diffuse.0 += diffuse;
                sums.visibility.0 += visibility;
                sums.bent += directions[lane] * diffuse;
            }
        }
    }
    sums.rays = caster.rays;
    sums
}

/// Casts `points` lobe directions about the mirrored view.
fn lobe_sums(task: &Task<'_>, survey: &Survey<'_>, stream: &Stream, points: u32) -> Sums {
    let mut sums = Sums::default();
    let mut caster = Caster::new(task);
    let lobe = Lobe::new(survey.material.exponent);
    for first in (0..points).step_by(BATCH) {
        let lanes = BATCH.min((points - first) as usize);
        let [u0, u1, p0, p1] = stream.points16(first);
        for lane in 0..lanes {
            let sample = survey.sample([p0[lane], p1[lane]]);
            let axis = mirrored_view(task.view, &sample);
            let direction = Frame::from_normal(axis).to_world(lobe.sample([u0[lane], u1[lane]]));
            if direction.dot(sample.normal) > 0.0 {
                caster.add(lane, &sample, direction);
            }
        }
        sums.diffuse.0 += f64::from(caster.cast().count_ones());
        sums.diffuse.1 += lanes as f64;
    }
    sums.rays = caster.rays;
    sums
}

/// R = 2 (N.V) N - V, the axis of the specular lobe.
fn mirrored_view(view: View, sample: &Sample) -> DVec3 {
    match view {
        View::Normal => sample.normal,
        View::Eye(eye) => {
            let v = (eye - sample.position)
                .try_normalize()
                .unwrap_or(sample.normal);
            2.0 * sample.normal.dot(v) * sample.normal - v
        }
    }
}

/// Closed forms at points of the footprint, for texels that nothing stands above. The horizon is the geometric plane; a
/// shading normal may be tilted against it where V = N, so that the lobe axis is the shading normal itself.
fn open_terms(task: &Task<'_>, survey: &Survey<'_>, stream: impl Fn(u32, u32) -> Stream) -> Terms {
    let mut means = [[0.0; REPLICATES as usize]; 3];
    let mut bent = DVec3::ZERO;
    for (replicate, points) in shares(CLOSED_FORM_POINTS) {
        let stream = stream(term::HEMISPHERE, replicate);
        for index in 0..points {
            let [_, _, p0, p1] = stream.point(index);
            let sample = survey.sample([p0, p1]);
            let tilt = sample
                .geometric
                .cross(sample.normal)
                .length()
                .atan2(sample.geometric.dot(sample.normal));
            let axis = mirrored_view(task.view, &sample);
            let (cos, sin) = (
                sample.geometric.dot(axis),
                sample.geometric.cross(axis).length(),
            );
            let values = [
                closed_form::tilted_diffuse(tilt),
                closed_form::tilted_visibility(tilt),
                closed_form::phong_open(survey.material.exponent, cos, sin),
            ];
            for (mean, value) in means.iter_mut().zip(values) {
                mean[replicate as usize] += value / f64::from(points);
            }
            bent += sample.normal;
        }
    }
    let [diffuse, visibility, specular] = means.map(|m| m.iter().sum::<f64>() / m.len() as f64);
    let errors = means.map(|m| standard_error(&m));
    Terms {
        diffuse,
        visibility,
        specular: if task.specular { specular } else { 0.0 },
        bent,
        errors: if task.specular {
            errors
        } else {
            [errors[0], errors[1], 0.0]
        },
        rays: 0,
    }
}

/// Gathers up to 16 rays of a texel and casts them as one packet.
struct Caster<'a> {
    task: &'a Task<'a>,
    packet: RayPacket<16>,
    active: u32,
    rays: u64,
}

impl<'a> Caster<'a> {
    fn new(task: &'a Task<'a>) -> Self {
        Self {
            task,
            packet: RayPacket::default(),
            active: 0,
            rays: 0,
        }
    }

    /// Puts a direction into a lane. Below the geometric horizon the surface itself blocks: no ray.
    fn add(&mut self, lane: usize, sample: &Sample, direction: DVec3) {
        let direction32 = direction.as_vec3();
        if sample.geometric.dot(direction32.as_dvec3()) <= 0.0 {
            return;
        }
        self.packet.set(
            lane,
            &embree::Ray {
                origin: sample.origin,
                direction: direction32.to_array(),
                t_min: 0.0,
                t_max: self.task.t_max,
            },
        );
        self.active |= 1 << lane;
    }

    /// Open lanes among those added since the last cast.
    fn cast(&mut self) -> u32 {
        let active = std::mem::take(&mut self.active);
        if active == 0 || self.task.open {
            return active;
        }
        self.rays += u64::from(active.count_ones());
        active
            & !self
                .task
                .backend
                .occluded16(&self.packet, active, Coherence::Incoherent)
    }
}

/// Share of the footprint's upper hemisphere that does not see a back face first: 1 for a texel in the open or in a
/// room, near 0 inside a closed body. Double-sided surfaces have no back.
pub(crate) fn validity(
    task: &Task<'_>,
    survey: &Survey<'_>,
    world: &World,
    stream: impl Fn(u32, u32) -> Stream,
) -> f64 {
    if task.open {
        return 1.0;
    }
    let stream = stream(term::VALIDITY, 0);
    let valid = (0..VALIDITY_RAYS).filter(|&index| {
        let [u0, u1, p0, p1] = stream.point(index);
        let sample = survey.sample([p0, p1]);
        let direction =
            Frame::from_normal(sample.geometric).to_world(Mixture::UNIFORM.sample([u0, u1]));
        let ray = embree::Ray {
            origin: sample.origin,
            direction: direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        task.backend
            .closest(&ray)
            .is_none_or(|hit| hit.front || world.is_double_sided(hit.instance))
    });
    valid.count() as f64 / f64::from(VALIDITY_RAYS)
}
