//! Faces of bodies that are level with one another but for rounding.
//!
//! A point is tested [`NUDGE`] off its surface, so the tops of two boxes that overlap bury nothing of each other where
//! they are level. Rounding may put one an ulp below the other. It is in the open all the same, and so rays have to
//! begin where it was tested, or the other top would take all light.

use super::tree::Slab;
use super::{Inside, NUDGE, Solids};
use glam::DVec3;
use scene::around;

/// The cosine of the angle between faces that are level, at least.
const ALONG: f64 = 0.999;

/// Room for rounding where faces are left out that cannot be level.
const ROOM: f64 = 1.01;

impl Solids {
    /// How far off a triangle rays begin that are to see what it sees were it not for rounding, in scene units: 0 where
    /// no solid but the own has a face that is level with it.
    ///
    /// * `normal`: of unit length, to the side that the triangle shows.
    pub fn level(&self, triangle: [DVec3; 3], normal: DVec3, own: Option<u32>) -> f64 {
        let (low, high) = around(triangle);
        // What is nested in many bodies is asked of one.
        if self.is_crowded(low, high) && self.swallow(low, high, own) {
            return 0.0;
        }
        let far = |body| {
            self.extent(body)
                .max(low.abs().max(high.abs()).max_element())
        };
        let [a, b, c] = triangle;
        let longest = [b - a, c - b, a - c].map(DVec3::length);
        let longest = longest.into_iter().fold(0.0, f64::max);
        // How far apart the triangle's corners lie along any direction in its plane, at least.
        let narrowest = (b - a).cross(c - a).length() / longest;
        let is_level = |&body: &u32| {
            let of = &self.bodies[body as usize];
            if of.inside != Inside::Solid || own == Some(body) {
                return false;
            }
            let slack = NUDGE * far(body);
            let (least, most) = (low - slack, high + slack);
            // The plane of a face that is level with the triangle passes all three corners within the slack, or the
            // face's corners do so with the triangle's plane. So the normals differ by no more than the slack lets
            // them over what is narrowest, and by no more than `ALONG` does; and in the box, the face stays so near.
            let lean = (2.0 * slack / narrowest).min(f64::sqrt(2.0 - 2.0 * ALONG));
            let slab = Slab {
                normal,
                at: normal.dot(a),
                within: ROOM * (slack + lean * (most - least).length()),
            };
            if !slab.meets(of.low, of.high) {
                return false;
            }
            let transform = of.inverse.inverse();
            let ends = super::box_corners(least, most);
            let ends = ends.map(|p| of.inverse.transform_point3(p));
            let (low, high) = around(ends);
            let side =
                self.surface(of).content().signum() * transform.matrix3.determinant().signum();
            let slab = slab.before(&transform);
            (self.tree(of)).any_in(&self.scene, [low, high], &slab, |face| {
                let [a, b, c] =
                    face.map(|p| transform.transform_point3(DVec3::from(p.map(f64::from))));
                let front = side * (b - a).cross(c - a).normalize_or_zero();
                let off = |p: &DVec3| (*p - a).dot(front).abs() <= slack;
                let stands = |p: DVec3| (p - triangle[0]).dot(normal).abs() <= slack;
                let is_one = || triangle.iter().all(off) || [a, b, c].into_iter().all(stands);
                front.dot(normal) > ALONG && is_one()
            })
        };
        let near = self.about(low, high);
        let level = near.iter().filter(|body| is_level(body));
        level.map(|&body| NUDGE * far(body)).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{block, placed_scene, world};
    use glam::{DAffine3, DQuat, Vec3};

    #[test]
    fn tops_of_boxes_are_level_where_only_rounding_parts_them() {
        let top = 29.6f32;
        let boxed = |low: [f32; 3], high: [f32; 3], inward| {
            let [low, high] = [low, high].map(Vec3::from_array);
            let mut block = block(0.5 * (low + high), 0.5 * (high - low), inward);
            // The very height.
            let is_top = |p: &&mut Vec3| p.y > 0.5 * (low.y + high.y);
            (block.positions.iter_mut().filter(is_top)).for_each(|p| p.y = high.y);
            block
        };
        let ulp = top - f32::from_bits(top.to_bits() - 1);
        for (below, inward, expected) in [
            (0.0, false, true),
            (ulp, false, true),
            (ulp, true, true),
            (-ulp, false, true),
            (1e-3, false, false),
        ] {
            let turned = DQuat::from_rotation_x(2.0);
            for place in [DAffine3::IDENTITY, DAffine3::from_quat(turned)] {
                let meshes = vec![
                    boxed([0.0, 29.0, 0.0], [4.0, top, 4.0], inward),
                    boxed([2.0, 28.9, 1.0], [6.0, top - below, 5.0], false),
                ];
                let scene = placed_scene(meshes, &[(0, place), (1, place)]);
                let world = world(scene);
                for triangle in 0..12 {
                    let corners = world.corners(1, triangle);
                    let normal = world.face(1, triangle).normalize();
                    let own = world.solids().own(1, triangle);
                    let found = world.solids().level(corners, normal, own);
                    let is_top = normal.dot(place.transform_vector3(DVec3::Y)) > 0.9;
                    let case = format!("{below} {inward} {triangle}: {found}");
                    assert_eq!(found > f64::from(below.abs()), is_top && expected, "{case}");
                    assert!(found < 1e-4, "{case}");
                }
            }
        }
    }
}
