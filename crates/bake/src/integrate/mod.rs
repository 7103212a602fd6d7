//! Rays meet mathematics: the terms of a tile's texels, from rays or in closed form.
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
//! **Light of a map.** With an illumination map the radiance is a uniform floor, which the two terms above multiply, and what stands
//! out of it, which hemisphere rays and directions drawn from the map share by the power heuristic with exponent 2 (E. Veach, L. Guibas,
//! "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995), and lobe rays and the same directions likewise. Weights are those of equal
//! numbers, whatever the numbers are, so that each technique may stop by itself. These means are not divided by sums of weights.
//!
//! **Lanes.** A texel has [`REPLICATES`] independent randomisations of its points. Each is one lane of a
//! [`Gang`]; `error_estimate.rs` makes errors of their spread. With a target, texels whose error is not yet small enough take more points
//! of the same streams, round by round.

mod estimate;
mod gang;

use crate::options::{Effort, Pattern, Sky, View};
use crate::survey::Texel;
use ambient::Frame;
use ambient::closed_form;
use ambient::sampling::{LANES, Mixture, PointSet, Stream};
use estimate::{Estimate, Gathered};
use gang::{Gang, Lane};
use glam::DVec3;
use pulp::Arch;
use rays::{Ray, RayBackend, World};
use std::ops::Range;

/// Independent randomisations of a texel's points.
pub const REPLICATES: u32 = 4;

/// Stream labels: which integral a texel's points serve.
pub(crate) mod term {
    pub const SURVEY: u32 = 0;
    pub const HEMISPHERE: u32 = 1;
    pub const LOBE: u32 = 2;
    pub const VALIDITY: u32 = 3;
    pub const SKY: u32 = 4;
}

/// Rays of the `validity` layer.
const VALIDITY_RAYS: u32 = 16;

/// Points of a texel whose terms have a closed form at every point: they only average over the footprint.
const CLOSED_FORM_POINTS: u32 = 64;

/// Points of each replicate in the first round of a bake with a target.
const FIRST_ROUND: u32 = 4;

/// Texels this far away along an axis pool their variances when a texel decides to stop.
const STOP_RADIUS: i32 = 2;

/// Edge of the blocks of texels that share directions: one packet.
const SHARE: u32 = 4;

/// An integral over the directions of a texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Term {
    /// Diffuse and visibility.
    Hemisphere,
    /// The specular lobe.
    Lobe,
    /// Light of the illumination map, by directions drawn from it.
    Sky,
}

/// What the texels of a bake are integrated with.
pub(crate) struct Task<'a> {
    pub backend: &'a dyn RayBackend,
    pub arch: Arch,
    pub seed: u64,
    pub page: u32,
    /// Page edge in texels.
    pub size: u32,
    pub effort: Effort,
    pub pattern: Pattern,
    pub points: PointSet,
    pub view: View,
    pub t_max: f32,
    /// How hemisphere directions are drawn.
    pub mixture: Mixture,
    /// A layer needs the hemisphere.
    pub hemisphere: bool,
    /// The bent normal is asked for.
    pub bent: bool,
    pub sky: &'a Sky,
    /// See [`crate::Options::draw_sky`].
    pub draw_sky: bool,
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
    /// (1/pi) times the integral of L V cos, linear RGB.
    pub irradiance: DVec3,
    /// ((n+1)/2pi) times the integral of L V (R.V)^n, linear RGB.
    pub reflection: DVec3,
    /// Standard errors of the means of the channels of irradiance and reflection.
    pub light_errors: [f64; 2],
    /// Rays spent.
    pub rays: u64,
}

impl Terms {
    /// The terms with the light of a uniform sky.
    pub(crate) fn lit(self, sky: DVec3) -> Self {
        let mean = sky.element_sum() / 3.0;
        Self {
            irradiance: sky * self.diffuse,
            reflection: sky * self.specular,
            light_errors: [mean * self.errors[0], mean * self.errors[2]],
            ..self
        }
    }
}

/// Weighted open rays and all rays of one replicate.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sums {
    /// (open, all): the diffuse term, or the specular term of lobe rays.
    pub first: (f64, f64),
    /// (open, all) of the visibility.
    pub second: (f64, f64),
    pub bent: DVec3,
    /// Light above the sky's floor divided by the sky's scale: of the term itself; of diffuse and specular for [`Term::Sky`].
    pub light: [DVec3; 2],
    /// Points of the stream.
    pub points: u64,
    pub rays: u64,
}

impl std::ops::AddAssign for Sums {
    fn add_assign(&mut self, other: Self) {
        for (into, from) in [
            (&mut self.first, other.first),
            (&mut self.second, other.second),
        ] {
            into.0 += from.0;
            into.1 += from.1;
        }
        self.bent += other.bent;
        for (into, from) in self.light.iter_mut().zip(other.light) {
            *into += from;
        }
        self.points += other.points;
        self.rays += other.rays;
    }
}

/// One texel's replicates and the points that each has.
pub(crate) type Replicates = [Sums; REPLICATES as usize];

impl Task<'_> {
    /// A texel's own stream.
    pub fn stream(&self, x: u32, y: u32, term: u32, replicate: u32) -> Stream {
        Stream::new(self.seed, self.page, y * self.size + x, term, replicate)
    }

    /// A texel's stream under the pattern: tiled texels share directions, never places.
    fn pattern_stream(&self, texel: &Texel, term: u32, replicate: u32) -> Stream {
        let own = self.stream(texel.x, texel.y, term, replicate);
        match self.pattern {
            Pattern::Independent => own,
            Pattern::Tiled => {
                let across = self.size.div_ceil(SHARE);
                let label = 1 << 31 | (texel.y / SHARE * across + texel.x / SHARE);
                own.with_directions(&Stream::new(self.seed, self.page, label, term, replicate))
            }
        }
    }
}

/// Integrates the texels of one tile. `reflects` says which of them need the lobe.
pub(crate) fn integrate(task: &Task<'_>, texels: &[Texel], reflects: &[bool]) -> Vec<Terms> {
    let lit = task.sky.map().is_some();
    let sampled = matches!(task.view, View::Eye(_)) || task.bent;
    let closed: Vec<bool> = texels
        .iter()
        .map(|texel| texel.open && !lit && !(sampled && texel.tilted))
        .collect();
    let needing = |wanted: &dyn Fn(usize) -> bool| -> Vec<usize> {
        (0..texels.len())
            .filter(|&i| !closed[i] && wanted(i))
            .collect()
    };
    let hemisphere = needing(&|_| task.hemisphere);
    let lobe = needing(&|i| reflects[i]);
    let sky = needing(&|_| lit && task.draw_sky);
    let cast = |term, which| rounds(task, texels, reflects, term, which);
    let hemisphere = cast(Term::Hemisphere, hemisphere);
    let lobe = cast(Term::Lobe, lobe);
    let sky = cast(Term::Sky, sky);
    (0..texels.len())
        .map(|i| {
            if closed[i] {
                return closed_form_terms(task, &texels[i], reflects[i]).lit(task.sky.floor());
            }
            let ([diffuse, visibility], [specular, _]) = (hemisphere[i].values, lobe[i].values);
            let [irradiance, reflection] = [0, 1].map(|k| {
                if ![task.hemisphere, reflects[i]][k] {
                    return (DVec3::ZERO, 0.0);
                }
                let own = [&hemisphere, &lobe][k][i];
                let error = own.light_errors[0].hypot(sky[i].light_errors[k]);
                (own.light[0] + sky[i].light[k], error)
            });
            Terms {
                diffuse,
                visibility,
                specular,
                bent: hemisphere[i].bent,
                errors: [
                    hemisphere[i].errors[0],
                    hemisphere[i].errors[1],
                    lobe[i].errors[0],
                ],
                irradiance: irradiance.0,
                reflection: reflection.0,
                light_errors: [irradiance.1, reflection.1],
                rays: hemisphere[i].rays + lobe[i].rays + sky[i].rays,
            }
        })
        .collect()
}

/// Casts the rays of one term for the texels `which`, in rounds where a target is set.
fn rounds(
    task: &Task<'_>,
    texels: &[Texel],
    reflects: &[bool],
    term: Term,
    mut which: Vec<usize>,
) -> Vec<Estimate> {
    let cast = |lanes: &[Lane], range, sums: &mut [Replicates]| {
        cast(task, texels, reflects, term, lanes, range, sums);
    };
    let mut sums = vec![Replicates::default(); texels.len()];
    let mut points = vec![0; texels.len()];
    match task.effort {
        Effort::Rays(rays) => {
            let (each, rest) = (rays / REPLICATES, (rays % REPLICATES) as usize);
            let all = lanes(task, texels, &which, 0..REPLICATES as usize);
            cast(&all, 0..each, &mut sums);
            let more = lanes(task, texels, &which, 0..rest);
            cast(&more, each..each + 1, &mut sums);
            for &i in &which {
                points[i] = rays;
            }
        }
        Effort::Target { error, max_rays } => {
            let most = max_rays / REPLICATES;
            let mut range = 0..FIRST_ROUND.min(most);
            while !range.is_empty() && !which.is_empty() {
                let lanes = lanes(task, texels, &which, 0..REPLICATES as usize);
                cast(&lanes, range.clone(), &mut sums);
                for &i in &which {
                    points[i] = range.end * REPLICATES;
                }
                let gathered = Gathered::new(task.sky, texels, &sums, &points);
                which.retain(|&i| gathered.watched(i, term, STOP_RADIUS) > error);
                range = range.end..next_round(range.end).min(most);
            }
        }
    }
    let gathered = Gathered::new(task.sky, texels, &sums, &points);
    (0..texels.len()).map(|i| gathered.estimate(i)).collect()
}

/// How many points a replicate has after the round that follows `points`: 4, 8, 16, 24, 32, 48 ... so that the rounds of easy
/// texels are few and hard ones overshoot by half at most.
fn next_round(points: u32) -> u32 {
    let whole = 1 << points.ilog2();
    match points {
        0..16 => 2 * points,
        _ => points + whole / 2,
    }
}

/// The lanes of the texels `which`, neighbours side by side.
///
/// A packet holds four replicates of 2 x 2 texels, which are independent, or one replicate of 4 x 4 texels, which share it.
fn lanes(
    task: &Task<'_>,
    texels: &[Texel],
    which: &[usize],
    replicates: Range<usize>,
) -> Vec<Lane> {
    let edge = match task.pattern {
        Pattern::Independent => 2,
        Pattern::Tiled => SHARE,
    };
    let group = |i: usize| (texels[i].y / edge, texels[i].x / edge);
    let mut order = which.to_vec();
    order.sort_by_key(|&i| (group(i), i));
    order
        .chunk_by(|&a, &b| group(a) == group(b))
        .flat_map(|group| {
            replicates.clone().flat_map(move |replicate| {
                group.iter().map(move |&texel| Lane { texel, replicate })
            })
        })
        .collect()
}

/// Casts the points `range` of every lane.
fn cast(
    task: &Task<'_>,
    texels: &[Texel],
    reflects: &[bool],
    term: Term,
    lanes: &[Lane],
    range: Range<u32>,
    sums: &mut [Replicates],
) {
    let label = match term {
        Term::Hemisphere => term::HEMISPHERE,
        Term::Lobe => term::LOBE,
        Term::Sky => term::SKY,
    };
    let mut gang = Gang::new(task, texels, reflects);
    for lanes in lanes.chunks(LANES) {
        gang.load(lanes, |texel, replicate| {
            task.pattern_stream(texel, label, replicate)
        });
        gang.cast(task, term, range.clone());
        gang.collect(sums);
    }
}

/// R = 2 (N.V) N - V, the axis of the specular lobe.
fn mirrored_view(view: View, position: DVec3, normal: DVec3) -> DVec3 {
    match view {
        View::Normal => normal,
        View::Eye(eye) => {
            let v = (eye - position).try_normalize().unwrap_or(normal);
            2.0 * normal.dot(v) * normal - v
        }
    }
}

/// Closed forms at points of the footprint, for texels that nothing stands above. The horizon is the geometric plane; a
/// shading normal may be tilted against it where V = N, so that the lobe axis is the shading normal itself.
fn closed_form_terms(task: &Task<'_>, texel: &Texel, specular: bool) -> Terms {
    if !texel.tilted && task.view == View::Normal {
        return Terms {
            visibility: 1.0,
            diffuse: 1.0,
            specular: f64::from(u8::from(specular)),
            bent: texel.normal,
            ..Terms::default()
        };
    }
    let mut means = [[0.0; REPLICATES as usize]; 3];
    let mut bent = DVec3::ZERO;
    let points = CLOSED_FORM_POINTS / REPLICATES;
    for replicate in 0..REPLICATES {
        let stream = task.stream(texel.x, texel.y, term::HEMISPHERE, replicate);
        for index in 0..points {
            let [_, _, p0, p1] = stream.point(index);
            let sample = texel.sample([p0, p1]);
            let tilt = sample
                .geometric
                .cross(sample.normal)
                .length()
                .atan2(sample.geometric.dot(sample.normal));
            let axis = mirrored_view(task.view, sample.position, sample.normal);
            let (cos, sin) = (
                sample.geometric.dot(axis),
                sample.geometric.cross(axis).length(),
            );
            let values = [
                closed_form::tilted_diffuse(tilt),
                closed_form::tilted_visibility(tilt),
                closed_form::phong_open(texel.material.exponent, cos, sin),
            ];
            for (mean, value) in means.iter_mut().zip(values) {
                mean[replicate as usize] += value / f64::from(points);
            }
            bent += sample.normal;
        }
    }
    let [diffuse, visibility, lobe] = means.map(|m| m.iter().sum::<f64>() / m.len() as f64);
    let mut errors = means.map(|m| estimate::variance_of_mean(&m).sqrt());
    if !specular {
        errors[2] = 0.0;
    }
    Terms {
        diffuse,
        visibility,
        specular: if specular { lobe } else { 0.0 },
        bent,
        errors,
        ..Terms::default()
    }
}

/// Share of the footprint's upper hemisphere that does not see a back face first: 1 for a texel in the open or in a
/// room, near 0 inside a closed body. Double-sided surfaces have no back.
pub(crate) fn validity(task: &Task<'_>, texel: &Texel, world: &World) -> f64 {
    if texel.open {
        return 1.0;
    }
    let stream = task.stream(texel.x, texel.y, term::VALIDITY, 0);
    let valid = (0..VALIDITY_RAYS).filter(|&index| {
        let [u0, u1, p0, p1] = stream.point(index);
        let sample = texel.sample([p0, p1]);
        let direction =
            Frame::from_normal(sample.geometric).to_world(Mixture::UNIFORM.sample([u0, u1]));
        let ray = Ray {
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
