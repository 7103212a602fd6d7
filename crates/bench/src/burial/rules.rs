//! The rules that are compared.

use super::made::Made;
use glam::DVec3;
use rays::{NUDGE, Ray, RayBackend, World};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// A point of a body's surface.
#[derive(Clone, Copy)]
pub(super) struct Point {
    pub body: usize,
    pub triangle: u32,
    pub weights: [f64; 3],
    pub position: DVec3,
    pub normal: DVec3,
}

/// A scene ready to be asked.
pub(super) struct Scene<'a> {
    pub made: &'a Made,
    pub world: &'a World,
    pub backend: &'a dyn RayBackend,
    closed: Vec<Closed>,
    skies: Vec<(DVec3, bool)>,
}

#[derive(Clone, Copy, PartialEq)]
enum Closed {
    Open,
    Outward,
    Inward,
}

/// A rule: true where a point is buried.
pub(super) type Rule = (&'static str, fn(&Scene, &Point) -> bool);

pub(super) const ALL: &[Rule] = &[
    ("ambake", ambake),
    ("backs by votes", votes),
    ("winding numbers, summed", winding),
    ("sight of fronts or a sky", sight),
];

/// An edge of a texel, where a rule asks for one.
const TEXEL: f64 = 0.05;

/// The rule of a bake.
fn ambake(scene: &Scene, point: &Point) -> bool {
    let instance = point.body as u32;
    let solids = scene.world.solids();
    let is_cut = |rim: &rays::Rim| {
        let is_upright = rim.inward.dot(point.normal).abs() < 0.1;
        is_upright && rim.depth < TEXEL / 8.0 && rim.height(point.position) < 0.0
    };
    let at = point.position;
    let covered = || {
        let covers = solids.covers(None, (instance, point.triangle), || f64::INFINITY)?;
        let mut over = covers.over((at, at), (at, point.normal), TEXEL / 8.0);
        let holds = |cover: rays::Cover| {
            let ([a, b, c], least) = (cover.corners, cover.least);
            let front = (b - a).cross(c - a);
            let height = (a - at).dot(front) / point.normal.dot(front);
            let sides = [(a, b), (b, c), (c, a)];
            let is_in = |(p, q): (DVec3, DVec3)| point.normal.cross(q - p).dot(at - p) > 0.0;
            (least..=TEXEL / 8.0).contains(&height) && sides.into_iter().all(is_in)
        };
        over.any(holds).then_some(())
    };
    scene
        .world
        .is_buried(instance, point.triangle, point.weights)
        || solids.rims(instance, point.triangle).iter().any(is_cut)
        || covered().is_some()
}

impl<'a> Scene<'a> {
    pub fn new(made: &'a Made, world: &'a World, backend: &'a dyn RayBackend) -> Self {
        let closed = made.meshes.iter().map(|mesh| {
            let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
            for t in &mesh.triangles {
                for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                    *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
                }
            }
            if edges.values().any(|&count| count != 0) {
                return Closed::Open;
            }
            let corner = |k: u32| DVec3::from(mesh.positions[k as usize].map(f64::from));
            let volume: f64 = mesh
                .triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(corner);
                    a.dot(b.cross(c))
                })
                .sum();
            if volume > 0.0 {
                Closed::Outward
            } else {
                Closed::Inward
            }
        });
        let mut scene = Self {
            made,
            world,
            backend,
            closed: closed.collect(),
            skies: Vec::new(),
        };
        // Closed and inward, with nothing in it: wound the wrong way.
        for body in 0..scene.closed.len() {
            if scene.closed[body] != Closed::Inward {
                continue;
            }
            let lived = made.meshes.iter().enumerate().any(|(other, mesh)| {
                let within = mesh.positions.iter().filter(|p| {
                    let p = DVec3::from(p.map(f64::from));
                    scene.winding_of(body, p + DVec3::new(1e-4, 2e-4, 3e-4)) < -0.5
                });
                other != body && 2 * within.count() > mesh.positions.len()
            });
            if lived {
                scene.closed[body] = Closed::Open;
            }
        }
        let skies = (0..SKIES).map(|k| {
            let d = on_sphere(k, SKIES);
            (d, scene.is_legit(d))
        });
        scene.skies = skies.collect();
        scene
    }

    fn winding_of(&self, body: usize, point: DVec3) -> f64 {
        let mesh = &self.made.meshes[body];
        let corner = |k: u32| DVec3::from(mesh.positions[k as usize].map(f64::from)) - point;
        let solid = mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.map(corner);
            let (x, y, z) = (a.length(), b.length(), c.length());
            let up = a.dot(b.cross(c));
            let down = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
            2.0 * up.atan2(down)
        });
        solid.sum::<f64>() / (2.0 * TAU)
    }

    /// Whether a hit shows a front.
    fn is_front(&self, hit: &rays::SurfaceHit) -> bool {
        hit.front != (self.closed[hit.instance as usize] == Closed::Inward)
    }

    /// Seen from far away along `d`, the scene shows no more backs than fronts.
    fn is_legit(&self, d: DVec3) -> bool {
        let bounds = self.world.bounds();
        let (middle, radius) = (
            0.5 * (bounds.min + bounds.max),
            0.5 * (bounds.max - bounds.min).length(),
        );
        let (x, y) = d.any_orthonormal_pair();
        let (mut fronts, mut backs) = (0, 0);
        for k in 0..400 {
            let [u, v] =
                [0.754_877_67, 0.569_840_29].map(|a: f64| 2.0 * (a * f64::from(k)).fract() - 1.0);
            let from = middle + 2.0 * radius * d + radius * (u * x + v * y);
            if let Some(hit) = self.cast(from, -d) {
                if self.is_front(&hit) {
                    fronts += 1
                } else {
                    backs += 1
                }
            }
        }
        backs <= fronts
    }

    fn cast(&self, from: DVec3, d: DVec3) -> Option<rays::SurfaceHit> {
        self.backend.closest(&Ray {
            origin: from.as_vec3().to_array(),
            direction: d.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        })
    }

    fn is_legit_sky(&self, d: DVec3) -> bool {
        let nearest = self
            .skies
            .iter()
            .max_by(|a, b| a.0.dot(d).total_cmp(&b.0.dot(d)));
        nearest.is_none_or(|sky| sky.1)
    }
}

const SKIES: usize = 128;

fn on_sphere(k: usize, of: usize) -> DVec3 {
    let z = 1.0 - (2.0 * k as f64 + 1.0) / of as f64;
    let angle = k as f64 * PI * (3.0 - 5f64.sqrt());
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * angle.cos(), r * angle.sin(), z)
}

const PROBES: usize = 64;

fn probes(point: &Point) -> impl Iterator<Item = DVec3> + use<> {
    let normal = point.normal;
    (0..2 * PROBES)
        .map(|k| on_sphere(k, 2 * PROBES))
        .filter(move |d| d.dot(normal) > 0.01)
}

fn lifted(scene: &Scene, point: &Point) -> DVec3 {
    point.position + 2.0 * NUDGE * scene.world.scale_bound() * point.normal
}

/// As other bakers do: buried is where more than half of the probes meet a back.
fn votes(scene: &Scene, point: &Point) -> bool {
    let from = lifted(scene, point);
    let (mut backs, mut all) = (0, 0);
    for d in probes(point) {
        all += 1;
        if scene.cast(from, d).is_some_and(|hit| !hit.front) {
            backs += 1;
        }
    }
    2 * backs > all
}

fn in_closed(scene: &Scene, point: &Point) -> bool {
    let from = lifted(scene, point);
    (0..scene.closed.len()).any(|body| {
        body != point.body
            && match scene.closed[body] {
                Closed::Open => false,
                Closed::Outward => scene.winding_of(body, from) > 0.5,
                Closed::Inward => scene.winding_of(body, from) < -0.5,
            }
    })
}

/// Buried is what lies in a closed body, and where the winding numbers of all other, open bodies add up to more than
/// 0.3.
fn winding(scene: &Scene, point: &Point) -> bool {
    let from = lifted(scene, point);
    let of = |body| match scene.closed[body] {
        _ if body == point.body => 0.0,
        Closed::Open => scene.winding_of(body, from),
        _ => 0.0,
    };
    in_closed(scene, point) || (0..scene.closed.len()).map(of).sum::<f64>() > 0.3
}

/// Buried is what lies in a closed body, and where less than a sixteenth of the probes meets another body's front or
/// leaves to a sky from which the scene shows fronts rather than backs.
fn sight(scene: &Scene, point: &Point) -> bool {
    if in_closed(scene, point) {
        return true;
    }
    let from = lifted(scene, point);
    let (mut seen, mut all) = (0, 0);
    for d in probes(point) {
        all += 1;
        seen += usize::from(match scene.cast(from, d) {
            Some(hit) => scene.is_front(&hit) && hit.instance as usize != point.body,
            None => scene.is_legit_sky(d),
        });
    }
    16 * seen < all
}
