//! Whether points of a triangle are buried in bodies.

use crate::solid::{NUDGE, Near};
use crate::world::World;
use glam::DVec3;
use scene::around;

/// Bodies about a triangle that are kept for all of its points; with more, each point looks for its own.
const FEW: usize = 8;

/// Where a triangle is buried.
#[derive(Debug)]
pub struct Burial<'a> {
    world: &'a World,
    instance: u32,
    triangle: u32,
    /// Its corners, off the surface.
    corners: [DVec3; 3],
    own: Option<u32>,
    /// What bodies that count the same all over it count together.
    depth: i32,
    /// Bodies of which a surface comes near; `None` where they are many.
    close: Option<Vec<Near<'a>>>,
}

impl Burial<'_> {
    /// As [`World::is_buried`].
    pub fn is_buried(&mut self, weights: [f64; 3]) -> bool {
        let Some(close) = &mut self.close else {
            return (self.world).is_buried(self.instance, self.triangle, weights);
        };
        let point = blend(self.corners, weights);
        let depth = |body: &mut Near| body.depth(point, self.own);
        self.depth + close.iter_mut().map(depth).sum::<i32>() > 0
    }
}

fn blend(corners: [DVec3; 3], [a, b, c]: [f64; 3]) -> DVec3 {
    corners[0] * a + corners[1] * b + corners[2] * c
}

impl World {
    /// True where a point of a triangle lies in more solids than cavities. `weights`: its barycentric coordinates.
    pub fn is_buried(&self, instance: u32, triangle: u32, weights: [f64; 3]) -> bool {
        let solids = self.solids();
        let position = blend(self.corners(instance, triangle), weights);
        let own = solids.own(instance, triangle);
        if solids.swallow(position, position, own) {
            return true;
        }
        let near = solids.about(position, position);
        let reach = self.reach(&near, position.abs().max_element());
        let point = position + NUDGE * reach * self.face(instance, triangle).normalize_or_zero();
        solids.outweigh(&near, |body| solids.depth(body, point, own))
    }

    /// The same for many points of a triangle.
    pub fn burial(&self, instance: u32, triangle: u32) -> Burial<'_> {
        let solids = self.solids();
        let own = solids.own(instance, triangle);
        let corners = self.corners(instance, triangle);
        let (low, high) = around(corners);
        if solids.swallow(low, high, own) {
            return Burial {
                world: self,
                instance,
                triangle,
                corners,
                own,
                depth: 1,
                close: Some(Vec::new()),
            };
        }
        let mut near = solids.about(low, high);
        let reach = self.reach(&near, low.abs().max(high.abs()).max_element());
        let above = NUDGE * reach * self.face(instance, triangle).normalize_or_zero();
        let corners = corners.map(|corner| corner + above);
        near.retain(|&body| !solids.spares(body, own));
        let is_close = |&body: &u32| own != Some(body) && solids.meets(body, corners.into_iter());
        let (close, far): (Vec<u32>, Vec<u32>) = near.into_iter().partition(is_close);
        let middle = blend(corners, [1.0 / 3.0; 3]);
        let depth = |body: u32| solids.depth(body, middle, own);
        let kept = |body| solids.near(body, corners.into_iter());
        Burial {
            world: self,
            instance,
            triangle,
            corners,
            own,
            depth: far.into_iter().map(depth).sum(),
            close: (close.len() <= FEW).then(|| close.into_iter().map(kept).collect()),
        }
    }

    /// The largest coordinate of a place and of the bodies about it.
    fn reach(&self, near: &[u32], place: f64) -> f64 {
        let extent = near.iter().map(|&body| self.solids().extent(body));
        extent.fold(place, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use crate::fixture::{block, placed_scene, world};
    use glam::{DAffine3, DQuat, DVec3, Vec3};

    #[test]
    fn many_points_of_a_triangle_are_buried_as_each_is() {
        let turned = |angle, at| {
            let turn = DQuat::from_rotation_z(angle) * DQuat::from_rotation_x(0.7 * angle);
            DAffine3::from_rotation_translation(turn, at)
        };
        let unit = block(Vec3::ZERO, Vec3::ONE, false);
        let hollow = block(Vec3::ZERO, Vec3::splat(0.8), true);
        let places: Vec<(u32, DAffine3)> = vec![
            (0, DAffine3::IDENTITY),
            (1, DAffine3::IDENTITY),
            (0, turned(0.4, DVec3::new(1.2, 0.3, -0.4))),
            (0, turned(1.1, DVec3::new(0.2, 1.4, 0.6))),
            (0, turned(0.0, DVec3::new(0.0, -2.0, 0.0))),
        ];
        let world = world(placed_scene(vec![unit, hollow], &places));
        let mut counts = [0; 2];
        for (instance, triangle) in (0..5).flat_map(|i| (0..12).map(move |t| (i, t))) {
            let mut burial = world.burial(instance, triangle);
            for k in 0..50 {
                let [u, v] = [0.754_877_67, 0.569_840_29].map(|a: f64| (a * f64::from(k)).fract());
                let weights = [1.0 - u.max(v), (u - v).abs(), u.min(v)];
                let expected = world.is_buried(instance, triangle, weights);
                assert_eq!(
                    burial.is_buried(weights),
                    expected,
                    "{instance} {triangle} {weights:?}"
                );
                counts[usize::from(expected)] += 1;
            }
        }
        assert!(counts.into_iter().all(|count| count > 300), "{counts:?}");
    }

    #[test]
    fn a_face_on_which_a_body_rests_is_buried_though_rounding_leaves_a_gap() {
        let top = 0.9f32;
        for low in [top.next_down(), top, top.next_up()] {
            let floor = block(Vec3::new(0.0, top - 1.0, 0.0), Vec3::splat(1.0), false);
            let mut crate_on_it = block(Vec3::ZERO, Vec3::splat(2.0), false);
            for position in &mut crate_on_it.positions {
                position.y = if position.y < 0.0 { low } else { 3.0 };
            }
            let mut floor = floor;
            for position in &mut floor.positions {
                position.y = if position.y < 0.0 { 0.0 } else { top };
            }
            let places = [(0, DAffine3::IDENTITY), (1, DAffine3::IDENTITY)];
            let world = world(placed_scene(vec![floor, crate_on_it], &places));
            let is_top = |&t: &u32| world.corners(0, t).iter().all(|p| p.y > 0.8);
            let found: Vec<bool> = (0..12)
                .filter(is_top)
                .map(|t| world.is_buried(0, t, [0.5, 0.25, 0.25]))
                .collect();
            assert_eq!(found, [true; 2], "from {low}");
        }
    }
}
