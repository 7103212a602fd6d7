//! The judge of one ray on which backends disagree: every triangle in f64, and how far each decision is from its edge.
//!
//! A margin is a signed number: at or beyond 1 the triangle surely meets the ray, at or below -1 it surely does not,
//! and between them the decision lies within the rounding of single precision. It is the least of
//!
//! * the distance to the nearest edge, in units of 1e-5 of the barycentric range, or of the rounding of an f32 edge
//!   function where that is more: `8 u |d| |e| (|p| + |q|)` for the edge e between the corners p and q as seen from
//!   the origin, u = 2^-24 (and the f32 transform of the ray for an instance);
//! * the distance along the ray to the nearer end of its interval, in units of 2e-6 of the scene's diagonal, or of the
//!   rounding of an f32 plane test where that is more ([`t_rounding`]);
//! * whether the alpha test gives one answer all over the neighbourhood of the point: infinite, or 0 where it does not.

use glam::DVec3;
use rays::{Ray, World};

/// Unit roundoff of f32.
const UNIT_ROUNDOFF: f64 = 1.0 / 16_777_216.0;
/// Barycentric distance to an edge that rounding explains.
const EDGE: f64 = 1e-5;
/// Distance to an end of the interval, relative to the scene's diagonal, that rounding explains.
const LIMIT: f64 = 2e-6;

/// What is true of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ruling {
    /// It meets a surface.
    Met,
    /// It meets none.
    Open,
    /// Single precision may say either.
    Rounding,
}

/// How surely a triangle meets a ray; see the head of the module's file for the units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// Index of the scene's instance.
    pub instance: u32,
    /// Index into the instance's triangles.
    pub triangle: u32,
    /// Where the ray meets the triangle's plane, in lengths of its direction.
    pub t: f64,
    /// Signed barycentric distance to the nearest edge, positive inside.
    pub edge: f64,
    /// Signed distance to the nearer end of the interval over the scene's diagonal, positive inside.
    pub limit: f64,
    /// The signed margin.
    pub margin: f64,
}

impl Margin {
    /// What the margin says.
    pub fn ruling(&self) -> Ruling {
        if self.margin >= 1.0 {
            Ruling::Met
        } else if self.margin <= -1.0 {
            Ruling::Open
        } else {
            Ruling::Rounding
        }
    }
}

/// The margin of the triangle that meets the ray most surely; `None` in a world without triangles. It decides whether
/// the ray is occluded. Takes time in proportion to the triangles.
pub fn judge(world: &World, ray: &Ray) -> Option<Margin> {
    let all = (0..world.parts.len() as u32).flat_map(|instance| {
        let count = world.part(instance).1.triangles().len() as u32;
        (0..count).map(move |triangle| (instance, triangle))
    });
    all.map(|(instance, triangle)| judge_triangle(world, ray, instance, triangle))
        .max_by(|a, b| a.margin.total_cmp(&b.margin))
}

/// How surely one triangle meets the ray.
pub fn judge_triangle(world: &World, ray: &Ray, instance: u32, triangle: u32) -> Margin {
    let view = View::of(world, ray, instance, triangle);
    let (edge, edge_margin) = view.edge();
    let length = view.direction.length();
    let inside = (view.t - f64::from(ray.t_min)).min(f64::from(ray.t_max) - view.t) * length;
    let diagonal = world.bounds().diagonal();
    let unit = (LIMIT * diagonal).max(view.t_rounding() * length);
    // A ray in the triangle's plane has no t: nothing is sure about its interval.
    let limit_margin = if view.t.is_finite() && unit.is_finite() {
        inside / unit
    } else {
        0.0
    };
    let mut margin = edge_margin.min(limit_margin);
    if margin > -1.0 {
        margin = margin.min(view.alpha(world, ray, instance, triangle));
    }
    Margin {
        instance,
        triangle,
        t: view.t,
        edge,
        limit: inside / diagonal,
        margin,
    }
}

/// A bound on the rounding of t in an f32 plane test of this triangle, with the normal from two edges e and f:
/// `16 u |e| |f| (|a| + t |d|) / |n.d|`, first order in u. Infinite for a ray in the triangle's plane.
pub fn t_rounding(world: &World, ray: &Ray, instance: u32, triangle: u32) -> f64 {
    View::of(world, ray, instance, triangle).t_rounding()
}

/// A triangle seen from a ray's origin.
struct View {
    direction: DVec3,
    corners: [DVec3; 3],
    /// Edge functions of the sides opposite the corners; their sum is `n.d`.
    sides: [f64; 3],
    slope: f64,
    t: f64,
    /// What the f32 transform of a ray into mesh space may move it, in world units.
    moved: f64,
}

impl View {
    fn of(world: &World, ray: &Ray, instance: u32, triangle: u32) -> Self {
        let origin = DVec3::from_array(ray.origin.map(f64::from));
        let direction = DVec3::from_array(ray.direction.map(f64::from));
        let placed = world.corners(instance, triangle);
        let corners = placed.map(|corner| corner - origin);
        let [a, b, c] = corners;
        let sides = [b.cross(c), c.cross(a), a.cross(b)].map(|moment| direction.dot(moment));
        let normal = (b - a).cross(c - a);
        let slope = normal.dot(direction);
        let reach = placed
            .iter()
            .fold(origin.abs(), |reach, corner| reach.max(corner.abs()));
        let rounding = |axis| world.part(instance).0.rounding(axis, &[reach; 3]);
        let moved = DVec3::new(rounding(DVec3::X), rounding(DVec3::Y), rounding(DVec3::Z)).length();
        Self {
            direction,
            corners,
            sides,
            slope,
            t: normal.dot(a) / slope,
            moved,
        }
    }

    /// Barycentric distance to the nearest edge, and as a margin.
    fn edge(&self) -> (f64, f64) {
        let [a, b, c] = self.corners;
        let length = self.direction.length();
        let volume: f64 = self.sides.iter().sum();
        let rounding = [(b, c), (c, a), (a, b)].map(|(p, q)| {
            let edge = (q - p).length();
            length * edge * (8.0 * UNIT_ROUNDOFF * (p.length() + q.length()) + 2.0 * self.moved)
        });
        let margin = |sign: f64| {
            let of =
                |side: usize| sign * self.sides[side] / rounding[side].max(EDGE * volume.abs());
            of(0).min(of(1)).min(of(2))
        };
        let sign = if volume < 0.0 { -1.0 } else { 1.0 };
        let least = self
            .sides
            .iter()
            .map(|side| sign * side)
            .fold(f64::INFINITY, f64::min);
        // A triangle seen edge on may face either way.
        let unsure = volume.abs() <= rounding.iter().sum();
        let margin = if unsure {
            margin(1.0).max(margin(-1.0)).min(0.0)
        } else {
            margin(sign)
        };
        (least / volume.abs(), margin)
    }

    fn t_rounding(&self) -> f64 {
        let [a, b, c] = self.corners;
        let edges = (b - a).length() * (c - a).length();
        let reach = a.length() + self.t.abs() * self.direction.length();
        edges * (16.0 * UNIT_ROUNDOFF * reach + 2.0 * self.moved) / self.slope.abs()
    }

    /// Infinite where the alpha test is sure of itself around the point.
    fn alpha(&self, world: &World, ray: &Ray, instance: u32, triangle: u32) -> f64 {
        let Some(alpha) = &world.part(instance).1.alpha else {
            return f64::INFINITY;
        };
        let volume: f64 = self.sides.iter().sum();
        let (u, v) = (self.sides[1] / volume, self.sides[2] / volume);
        let spread = |i: usize| [-EDGE, 0.0, EDGE][i];
        let keep = |i: usize| {
            alpha.keep(
                triangle,
                [(u + spread(i % 3)) as f32, (v + spread(i / 3)) as f32],
                ray.id(),
            )
        };
        let kept = (0..9).filter(|&i| keep(i)).count();
        match kept {
            9 => f64::INFINITY,
            0 => f64::NEG_INFINITY,
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, Vec2};
    use rays::WorldOptions;
    use scene::{Alpha, Image, Instance, Material, Mesh, Scene, TextureRef, Wrap};
    use std::sync::Arc;

    /// The square -1..=1 in x and y at z = 0 with UVs 0..=1; where it is `masked` its left half is a hole.
    fn square(masked: bool) -> World {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(Vec2::from);
        let mut material = Material::untinted("matt");
        if masked {
            let map = TextureRef {
                wrap: [Wrap::Clamp; 2],
                linear: false,
                ..TextureRef::new(0)
            };
            material.alpha = Alpha::Mask {
                cutoff: 0.5,
                factor: 1.0,
                map: Some(map),
            };
        }
        let scene = Scene {
            meshes: vec![Mesh {
                positions: corners.map(|c| c.extend(0.0)).to_vec(),
                uv_sets: vec![corners.map(|c| (c + 1.0) * 0.5).to_vec()],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                ..Mesh::default()
            }],
            instances: vec![Instance::new("square", 0, DAffine3::IDENTITY)],
            materials: vec![material],
            images: vec![Image {
                name: "mask".into(),
                width: 2,
                height: 1,
                pixels: vec![[255, 255, 255, 0], [255; 4]],
            }],
            ..Scene::default()
        };
        let options = WorldOptions::default();
        World::new(Arc::new(scene), options).expect("the square fits single precision")
    }

    fn down(x: f32, y: f32, t_max: f32) -> Ray {
        Ray {
            origin: [x, y, 1.0],
            direction: [0.0, 0.0, -1.0],
            t_min: 0.0,
            t_max,
        }
    }

    fn ruling(world: &World, ray: &Ray) -> Ruling {
        judge(world, ray)
            .expect("the fixture has triangles")
            .ruling()
    }

    #[test]
    fn clear_cases_are_ruled_and_rounding_is_told_from_them() {
        let world = square(false);
        assert_eq!(ruling(&world, &down(0.5, 0.2, 2.0)), Ruling::Met);
        assert_eq!(ruling(&world, &down(1.5, 0.2, 2.0)), Ruling::Open);
        assert_eq!(ruling(&world, &down(0.5, 0.2, 0.9)), Ruling::Open);
        assert_eq!(ruling(&world, &down(0.5, 0.2, 1.0)), Ruling::Rounding);
        assert_eq!(ruling(&world, &down(1.0, 0.2, 2.0)), Ruling::Rounding);
        assert_eq!(ruling(&world, &down(1.0 - 1e-3, 0.2, 2.0)), Ruling::Met);
        assert_eq!(ruling(&world, &down(1.0 + 1e-3, 0.2, 2.0)), Ruling::Open);
    }

    #[test]
    fn margins_name_the_triangle_and_its_distances() {
        let world = square(false);
        let margin = judge(&world, &down(0.5, 0.0, 3.0)).expect("the fixture has triangles");
        // Triangle (-1,-1), (1,-1), (1,1): the weight of the first corner is (1 - x)/2, of the third (1 + y)/2.
        assert_eq!(
            (margin.instance, margin.triangle, margin.t, margin.edge),
            (0, 0, 1.0, 0.25)
        );
        assert_eq!(margin.limit, 1.0 / 8.0f64.sqrt());
    }

    #[test]
    fn a_triangle_seen_edge_on_is_never_sure() {
        let world = square(false);
        let along = Ray {
            origin: [-3.0, 0.2, 0.0],
            direction: [1.0, 0.0, 0.0],
            t_min: 0.0,
            t_max: 9.0,
        };
        assert_eq!(ruling(&world, &along), Ruling::Rounding);
        let beside = Ray {
            origin: [-3.0, 0.2, 0.1],
            ..along
        };
        assert_eq!(ruling(&world, &beside), Ruling::Open);
    }

    #[test]
    fn the_rim_of_a_mask_is_within_rounding() {
        let world = square(true);
        assert_eq!(ruling(&world, &down(0.5, 0.2, 2.0)), Ruling::Met);
        assert_eq!(ruling(&world, &down(-0.5, 0.2, 2.0)), Ruling::Open);
        assert_eq!(ruling(&world, &down(0.0, 0.2, 2.0)), Ruling::Rounding);
    }
}
