//! The outsides of rooms, which nobody within sees.

use crate::eyes::is_seen;
use crate::points::PLASTIC;
use atlas::{Atlas, SurfacePoint};
use glam::{DVec2, DVec3, Vec2};
use rays::{Ray, RayBackend, SurfaceHit, World};
use scene::Scene;
use std::f64::consts::{PI, TAU};

/// Rays over the hemisphere of a point. It is outside where at least every fourth of them leaves the scene.
const RAYS: u32 = 32;
const LEAVING: u32 = RAYS / 4;

/// Points by which the texels of outsides are counted.
pub(crate) const POINTS: u32 = 1024;

/// [`RAYS`] directions over the hemisphere of a unit vector, even in solid angle.
pub(crate) fn over(normal: DVec3) -> impl Iterator<Item = DVec3> {
    let (u, v) = normal.any_orthonormal_pair();
    (0..RAYS).map(move |k| {
        let up = (f64::from(k) + 0.5) / f64::from(RAYS);
        let turn = (f64::from(k) * PI * (3.0 - 5.0f64.sqrt())).rem_euclid(TAU);
        let (y, x) = turn.sin_cos();
        normal * up + (u * x + v * y) * (1.0 - up * up).sqrt()
    })
}

/// A point of a surface as rays leave it.
pub(crate) struct Stand {
    pub place: DVec3,
    /// The unit normal on the lit side.
    pub normal: DVec3,
    /// How far off the surface rays in 32 bits begin.
    pub off: f64,
}

impl Stand {
    /// `None` on a triangle without an area.
    pub fn at(world: &World, point: &SurfacePoint) -> Option<Self> {
        let corners = world.corners(point.instance, point.triangle);
        let weighted = corners.iter().zip(point.weights);
        Some(Self {
            place: weighted.map(|(&corner, weight)| corner * weight).sum(),
            normal: world.face(point.instance, point.triangle).try_normalize()?,
            off: 1e-5 * world.bounds().diagonal(),
        })
    }

    /// A ray without an end that leaves to a side of the surface, that of its normal or the other.
    pub fn ray(&self, side: DVec3, direction: DVec3) -> Ray {
        Ray {
            origin: (self.place + self.off * side).as_vec3().to_array(),
            direction: direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    }
}

/// What a point of a surface sees on its lit side.
pub(crate) struct Look {
    pub point: SurfacePoint,
    pub stand: Stand,
    /// The ways over the hemisphere, and what is met on each.
    pub ways: Vec<(DVec3, Option<SurfaceHit>)>,
}

impl Look {
    /// `None` on a triangle without an area.
    pub fn at(world: &World, backend: &dyn RayBackend, point: SurfacePoint) -> Option<Self> {
        let stand = Stand::at(world, &point)?;
        let met = |way| (way, backend.closest(&stand.ray(stand.normal, way)));
        let ways = over(stand.normal).map(met).collect();
        Some(Self { point, stand, ways })
    }

    /// What is met on the ways on which something is.
    pub fn hits(&self) -> impl Iterator<Item = (DVec3, SurfaceHit)> {
        let ways = self.ways.iter();
        ways.filter_map(|&(way, hit)| Some((way, hit?)))
    }

    /// The ways from the other side of the surface.
    pub fn behind(&self) -> impl Iterator<Item = (DVec3, Ray)> {
        let side = -self.stand.normal;
        over(side).map(move |way| (way, self.stand.ray(side, way)))
    }
}

/// Looks from [`POINTS`] points that are spread over the texels of an atlas.
pub(crate) fn looks(world: &World, backend: &dyn RayBackend, atlas: &Atlas) -> Vec<Look> {
    let points = spread(world.scene(), atlas).into_iter();
    let look = |point| Look::at(world, backend, point);
    points.filter_map(look).collect()
}

/// True where a way meets the back of a face.
pub(crate) fn is_back(world: &World, way: DVec3, hit: &SurfaceHit) -> bool {
    world.face(hit.instance, hit.triangle).dot(way) > 0.0
}

/// The outsides of a scene of rooms.
pub(crate) struct Shell<'a> {
    world: &'a World,
    backend: &'a dyn RayBackend,
    /// Places within, in the file's coordinates.
    eyes: Vec<[f64; 3]>,
}

impl<'a> Shell<'a> {
    /// `None` where most of the free space among the scene's surfaces is open: there people look from anywhere.
    pub fn of(world: &'a World, backend: &'a dyn RayBackend) -> Option<Self> {
        let places = render::places_within(world, backend).into_iter();
        let eyes: Vec<[f64; 3]> = places.map(|p| (p + world.origin()).to_array()).collect();
        (!eyes.is_empty()).then_some(Self {
            world,
            backend,
            eyes,
        })
    }

    /// True where a point looks out of the scene and none of the places within sees it.
    pub fn hides(&self, point: &SurfacePoint) -> bool {
        let Some(stand) = Stand::at(self.world, point) else {
            return false;
        };
        let normal = stand.normal;
        let leaves = |way: &DVec3| !self.backend.occluded(&stand.ray(normal, *way));
        let leaving = over(normal).filter(leaves).take(LEAVING as usize).count();
        leaving as u32 == LEAVING && !is_seen(&self.eyes, point, self.world, self.backend)
    }

    /// The share of an atlas's texels that lie on outsides.
    pub fn share(&self, atlas: &Atlas) -> f64 {
        let points = spread(self.world.scene(), atlas).into_iter();
        let hidden = points.filter(|point| self.hides(point)).count();
        hidden as f64 / f64::from(POINTS)
    }
}

/// [`POINTS`] points that are spread over the texels of an atlas, each in a place of its own on its triangle.
fn spread(scene: &Scene, atlas: &Atlas) -> Vec<SurfacePoint> {
    let placed = scene.instances.iter().zip(&atlas.placements);
    let triangles: Vec<(u32, u32, f64)> = (0..)
        .zip(placed)
        .filter(|(_, (_, placement))| placement.is_somewhere())
        .flat_map(|(i, (instance, placement))| {
            let layout = &atlas.meshes[instance.mesh as usize];
            let scale = Vec2::from(placement.scale).as_dvec2();
            (0..).zip(&layout.triangles).map(move |(t, corners)| {
                let at = |k: usize| layout.uvs[corners[k] as usize].as_dvec2() * scale;
                let [a, b, c]: [DVec2; 3] = [at(0), at(1), at(2)];
                (i, t, (b - a).perp_dot(c - a).abs())
            })
        })
        .collect();
    let whole: f64 = triangles.iter().map(|triangle| triangle.2).sum();
    let step = whole / f64::from(POINTS);
    let (mut along, mut next, mut points) = (0.0, 0.5 * step, Vec::new());
    for (instance, triangle, area) in triangles {
        along += area;
        while next < along {
            let k = points.len() as f64;
            let [u, v] = PLASTIC.map(|by| (0.5 + k * by).fract());
            let root = u.sqrt();
            points.push(SurfacePoint {
                instance,
                triangle,
                weights: [1.0 - root, root * (1.0 - v), root * v],
            });
            next += step;
        }
    }
    points
}
