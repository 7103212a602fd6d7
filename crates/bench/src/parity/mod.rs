//! Two backends on the same rays, answer by answer.
//!
//! **Rule.** Occlusion must be equal. Closest hits agree where both miss, where they name the same triangle, or where
//! their t differ by no more than the rounding of f32 plane tests on both triangles (coincident surfaces and shared
//! edges). On one triangle t must be equal within that rounding, too. Everything else is a disagreement, and the f64
//! referee rules on it: an occlusion on all triangles; a closest hit on the nearer of the two triangles, which one
//! backend met and the other passed by.

mod both;
mod referee;

pub use both::BothBackends;
pub use referee::{Margin, Ruling, judge, judge_triangle, t_rounding};

use glam::DVec3;
use rayon::prelude::*;
use rays::{Coherence, Mix, Ray, RayBackend, RayPacket, SurfaceHit, World};

/// Disagreements beyond this many are counted as unexplained without a ruling: something is broken.
const JUDGED: usize = 1000;
/// Packets a task.
const BLOCK: u64 = 256;

/// What two backends said about the same rays.
#[derive(Debug, Clone, PartialEq)]
pub struct ParityReport {
    /// Rays asked, each for occlusion and for the closest hit.
    pub rays: u64,
    /// Rays that the first backend found occluded.
    pub occluded: u64,
    /// Every difference in ray order, the first thousand with a ruling.
    pub disagreements: Vec<Disagreement>,
}

/// One ray with two answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Disagreement {
    /// The ray.
    pub ray: Ray,
    /// What the first backend said.
    pub a: Answer,
    /// What the second said.
    pub b: Answer,
    /// The decisive triangle; `None` where none was looked for.
    pub margin: Option<Margin>,
}

/// An answer of a backend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// To the question whether anything is met.
    Occluded(bool),
    /// To the question what is met first.
    Closest(Option<SurfaceHit>),
}

impl Disagreement {
    /// True where the referee finds the decision within the rounding of single precision.
    pub fn explained(&self) -> bool {
        self.margin
            .is_some_and(|margin| margin.ruling() == Ruling::Rounding)
    }
}

impl ParityReport {
    /// Disagreements that rounding does not explain.
    pub fn unexplained(&self) -> usize {
        self.disagreements
            .iter()
            .filter(|disagreement| !disagreement.explained())
            .count()
    }
}

/// Asks both backends about `count` rays (rounded up to whole packets) in the current rayon pool.
///
/// * `packets`: the packet of a number, and how alike its rays are. It is asked as a packet for occlusion and lane by
///   lane for closest hits.
pub fn parity(
    world: &World,
    a: &dyn RayBackend,
    b: &dyn RayBackend,
    packets: impl Fn(u64) -> (RayPacket<16>, Coherence) + Sync,
    count: u64,
) -> ParityReport {
    let total = count.div_ceil(16);
    let blocks: Vec<(u64, Vec<Disagreement>)> = (0..total.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let mut found = Vec::new();
            let mut occluded = 0;
            for number in block * BLOCK..((block + 1) * BLOCK).min(total) {
                let (packet, coherence) = packets(number);
                occluded +=
                    u64::from(compare(world, a, b, &packet, coherence, &mut found).count_ones());
            }
            (occluded, found)
        })
        .collect();
    let occluded = blocks.iter().map(|(occluded, _)| occluded).sum();
    let mut disagreements: Vec<Disagreement> =
        blocks.into_iter().flat_map(|(_, found)| found).collect();
    let judged = disagreements.len().min(JUDGED);
    disagreements[..judged]
        .par_iter_mut()
        .for_each(|disagreement| rule(world, disagreement));
    ParityReport {
        rays: total * 16,
        occluded,
        disagreements,
    }
}

/// The lanes that `a` finds occluded.
fn compare(
    world: &World,
    a: &dyn RayBackend,
    b: &dyn RayBackend,
    packet: &RayPacket<16>,
    coherence: Coherence,
    found: &mut Vec<Disagreement>,
) -> u32 {
    let masks = [a, b].map(|backend| backend.occluded16(packet, RayPacket::<16>::ALL, coherence));
    for lane in 0..16 {
        let ray = packet.get(lane);
        let [in_a, in_b] = masks.map(|mask| mask >> lane & 1 == 1);
        if in_a != in_b {
            let (a, b) = (Answer::Occluded(in_a), Answer::Occluded(in_b));
            found.push(Disagreement {
                ray,
                a,
                b,
                margin: None,
            });
        }
        let (hit_a, hit_b) = (a.closest(&ray), b.closest(&ray));
        if !agree(world, &ray, hit_a, hit_b) {
            let (a, b) = (Answer::Closest(hit_a), Answer::Closest(hit_b));
            found.push(Disagreement {
                ray,
                a,
                b,
                margin: None,
            });
        }
    }
    masks[0]
}

fn agree(world: &World, ray: &Ray, a: Option<SurfaceHit>, b: Option<SurfaceHit>) -> bool {
    let (a, b) = match (a, b) {
        (Some(a), Some(b)) => (a, b),
        (None, None) => return true,
        _ => return false,
    };
    if a.t == b.t {
        return true;
    }
    let rounding = |hit: SurfaceHit| t_rounding(world, ray, hit.instance, hit.triangle);
    (f64::from(a.t) - f64::from(b.t)).abs() <= rounding(a) + rounding(b)
}

pub(crate) fn rule(world: &World, disagreement: &mut Disagreement) {
    let ray = &disagreement.ray;
    let (a, b) = match (disagreement.a, disagreement.b) {
        (Answer::Closest(a), Answer::Closest(b)) => (a, b),
        _ => {
            disagreement.margin = judge(world, ray);
            return;
        }
    };
    let place = |hit: SurfaceHit| (hit.instance, hit.triangle);
    if a.map(place) == b.map(place) {
        return; // One triangle at two distances: nothing explains that.
    }
    let nearer = [a, b]
        .into_iter()
        .flatten()
        .min_by(|a, b| a.t.total_cmp(&b.t));
    disagreement.margin = nearer.map(|hit| judge_triangle(world, ray, hit.instance, hit.triangle));
}

/// Generic rays for [`parity`], a function of the seed and the packet's number. In turn a packet holds cosine rays from
/// random surface points, chords of the sphere around the scene, cosine rays cut at a random distance, and one
/// direction from neighbouring points, asked as coherent.
pub struct TestRays<'a> {
    world: &'a World,
    seed: u64,
    /// Running sums of the triangles' areas.
    areas: Vec<f64>,
    triangles: Vec<(u32, u32)>,
}

impl<'a> TestRays<'a> {
    /// Rays over a world with at least one triangle that has an area; over any other, rays that meet nothing.
    pub fn new(world: &'a World, seed: u64) -> Self {
        let mut areas = Vec::new();
        let mut triangles = Vec::new();
        let mut sum = 0.0;
        for instance in 0..world.parts.len() as u32 {
            for triangle in 0..world.part(instance).1.triangles().len() as u32 {
                let [a, b, c] = world.corners(instance, triangle);
                sum += (b - a).cross(c - a).length();
                areas.push(sum);
                triangles.push((instance, triangle));
            }
        }
        Self {
            world,
            seed,
            areas,
            triangles,
        }
    }

    /// The packet of a number.
    pub fn packet(&self, number: u64) -> (RayPacket<16>, Coherence) {
        let mut packet = RayPacket::new();
        let mut mix = Mix(Mix(self.seed ^ number).bits());
        let Some(&whole) = self.areas.last() else {
            return (packet, Coherence::Incoherent);
        };
        let kind = number % 4;
        let mut patch = self.pick(&mut mix, whole);
        let shared = cosine(&mut mix);
        for lane in 0..16 {
            if kind != 3 {
                patch = self.pick(&mut mix, whole);
            }
            let (origin, direction) = match kind {
                1 => self.chord(&mut mix),
                3 => self.leave(patch, shared, &mut mix),
                _ => {
                    let local = cosine(&mut mix);
                    self.leave(patch, local, &mut mix)
                }
            };
            let reach = if kind == 2 {
                mix.unit() * 0.1 * self.world.bounds().diagonal()
            } else {
                f64::INFINITY
            };
            packet.set(
                lane,
                &Ray {
                    origin: origin.as_vec3().to_array(),
                    direction: direction.as_vec3().to_array(),
                    t_min: 0.0,
                    t_max: reach as f32,
                },
            );
        }
        let coherence = if kind == 3 {
            Coherence::Coherent
        } else {
            Coherence::Incoherent
        };
        (packet, coherence)
    }

    /// A triangle with a probability in proportion to its area.
    fn pick(&self, mix: &mut Mix, whole: f64) -> (u32, u32) {
        let at = mix.unit() * whole;
        let index = self.areas.partition_point(|&sum| sum <= at);
        self.triangles[index.min(self.triangles.len() - 1)]
    }

    /// A ray from a random point of a triangle, in a direction given about its normal. The origin stands off by 2^-19
    /// of the scene's reach, which is past any rounding.
    fn leave(
        &self,
        (instance, triangle): (u32, u32),
        local: DVec3,
        mix: &mut Mix,
    ) -> (DVec3, DVec3) {
        let [a, b, c] = self.world.corners(instance, triangle);
        let root = mix.unit().sqrt();
        let second = mix.unit();
        let point = a * (1.0 - root) + (b * (1.0 - second) + c * second) * root;
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Z);
        let tangent = normal.any_orthonormal_vector();
        let direction = tangent * local.x + normal.cross(tangent) * local.y + normal * local.z;
        let reach = self.world.scale_bound() + self.world.bounds().diagonal();
        (
            point + normal * (reach / 524_288.0).copysign(local.z),
            direction,
        )
    }

    /// Through two random points of the sphere around the scene.
    fn chord(&self, mix: &mut Mix) -> (DVec3, DVec3) {
        let bounds = self.world.bounds();
        let radius = bounds.diagonal() * 0.5;
        let mut point = || bounds.center() + on_sphere(mix) * radius;
        let (from, to) = (point(), point());
        (from, (to - from).normalize_or(DVec3::Z))
    }
}

/// A direction with a probability in proportion to the cosine, about z or, as often, about -z.
fn cosine(mix: &mut Mix) -> DVec3 {
    let square = mix.unit();
    let angle = mix.unit() * std::f64::consts::TAU;
    let z = if mix.bits() & 1 == 0 { 1.0 } else { -1.0 };
    DVec3::new(
        square.sqrt() * angle.cos(),
        square.sqrt() * angle.sin(),
        (1.0 - square).sqrt() * z,
    )
}

/// A point of the unit sphere, uniform.
fn on_sphere(mix: &mut Mix) -> DVec3 {
    let z = mix.unit() * 2.0 - 1.0;
    let angle = mix.unit() * std::f64::consts::TAU;
    let across = (1.0 - z * z).sqrt();
    DVec3::new(across * angle.cos(), across * angle.sin(), z)
}
