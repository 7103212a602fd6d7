//! A tree of boxes over the triangles of one surface: how often it winds around a point, how far a point stands in
//! front of it, and whether it comes near a box.

use super::topology::corners;
use super::weld::Face;
use crate::triangle::{Crossing, ShearedRay};
use glam::{DAffine3, DVec3, Vec3};
use scene::Scene;

/// Triangles in a leaf.
const LEAF: usize = 4;

/// What a slab distance in f64 may be off by, relative (T. Ize, "Robust BVH Ray Traversal", 2013).
const SLACK: f64 = 1.0 + 8.0 * f64::EPSILON;

/// Lean of the rays against their axis: no edge of a model runs along them.
const LEAN: [f64; 2] = [0.025_731_7, 0.041_193_1];

/// The share of that lean of a line that looks for an open surface: where it ends is where it ends, seen from any
/// height.
const UPRIGHT: f64 = 1.0 / 8192.0;

/// A crossing nearer than this, by its weights or as a share of the way, to an edge or an end decides nothing.
pub(super) const CLEAR: f64 = 1e-9;

/// A surface in the space of its meshes.
#[derive(Debug)]
pub(super) struct SurfaceTree {
    nodes: Vec<Node>,
    faces: Vec<Face>,
}

/// What lies near a plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slab {
    /// Of any length.
    pub normal: DVec3,
    /// Where the plane is along it.
    pub at: f64,
    /// How far from there it ends on either side.
    pub within: f64,
}

impl Slab {
    /// What holds all.
    pub const EVERYWHERE: Self = Self {
        normal: DVec3::ZERO,
        at: 0.0,
        within: f64::INFINITY,
    };

    /// True where a box may meet it; false is certain.
    pub fn meets(&self, low: DVec3, high: DVec3) -> bool {
        let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let height = self.normal.dot(middle) - self.at;
        height.abs() <= self.within + self.normal.abs().dot(half)
    }

    /// The same in the space from which a transform leads here.
    pub fn before(&self, transform: &DAffine3) -> Self {
        Self {
            normal: transform.matrix3.transpose() * self.normal,
            at: self.at - self.normal.dot(transform.translation),
            within: self.within,
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// First face of a leaf; the first of two children of another.
    first: u32,
    /// Faces of a leaf; 0 of another.
    count: u32,
}

impl SurfaceTree {
    pub fn build(scene: &Scene, faces: &[Face]) -> Self {
        let mut items: Vec<(Face, [Vec3; 2])> = faces
            .iter()
            .map(|&face| {
                let [a, b, c] = corners(scene, face);
                (face, [a.min(b).min(c), a.max(b).max(c)])
            })
            .collect();
        let mut nodes = vec![Node::around(&items, 0)];
        let mut pending = vec![(0, 0, items.len())];
        while let Some((node, start, end)) = pending.pop() {
            let part = &mut items[start..end];
            if part.len() <= LEAF {
                continue;
            }
            let middle = |item: &(Face, [Vec3; 2])| item.1[0] + item.1[1];
            let first = middle(&part[0]);
            let (low, high) = part.iter().fold((first, first), |(low, high), item| {
                (low.min(middle(item)), high.max(middle(item)))
            });
            let axis = (high - low).max_position();
            let half = part.len() / 2;
            part.select_nth_unstable_by(half, |a, b| {
                let order = middle(a)[axis].total_cmp(&middle(b)[axis]);
                order.then((a.0.mesh, a.0.triangle).cmp(&(b.0.mesh, b.0.triangle)))
            });
            let children = nodes.len() as u32;
            nodes.push(Node::around(&part[..half], start));
            nodes.push(Node::around(&part[half..], start + half));
            (nodes[node].first, nodes[node].count) = (children, 0);
            pending.push((children as usize, start, start + half));
            pending.push((children as usize + 1, start + half, end));
        }
        Self {
            nodes,
            faces: items.into_iter().map(|(face, _)| face).collect(),
        }
    }

    /// How often the surface winds around a point: above 0 inside of faces that look outward, below 0 inside of faces
    /// that look inward, 0 outside. A point on the surface may count either way.
    ///
    /// Counted along one ray: faces met from behind less those met from their front. It goes to the nearest side of the
    /// box. `panes` are triangles in the box that count as well.
    pub fn winding<'a>(
        &self,
        scene: &Scene,
        panes: impl Iterator<Item = &'a [[f32; 3]; 3]>,
        point: DVec3,
    ) -> i32 {
        let root = &self.nodes[0];
        let (low, high) = (root.low.as_dvec3(), root.high.as_dvec3());
        if point.cmplt(low).any() || point.cmpgt(high).any() {
            return 0;
        }
        let (below, above) = (point - low, high - point);
        let nearest = below.min(above).min_position();
        let mut direction = DVec3::ZERO;
        let sign = if below[nearest] < above[nearest] {
            -1.0
        } else {
            1.0
        };
        direction[nearest] = sign;
        direction[(nearest + 1) % 3] = LEAN[0];
        direction[(nearest + 2) % 3] = LEAN[1];
        let mut winding = 0;
        self.cross(scene, point, direction, 0.0, |crossing| {
            winding += if crossing.front { -1 } else { 1 };
        });
        let sight = ShearedRay::new(point, direction);
        for pane in panes {
            if let Some(crossing) = sight.cross(pane).filter(|crossing| crossing.t > 0.0) {
                winding += if crossing.front { -1 } else { 1 };
            }
        }
        winding
    }

    /// How far in front of an open surface a point stands along a unit direction to which its faces look, below 0
    /// behind it; `None` beside it. A point over its border may be either.
    pub fn height(&self, scene: &Scene, point: DVec3, front: DVec3) -> Option<f64> {
        self.height_to(scene, point, front, [1.0, 1.0])
    }

    /// The same, where a point over the border is beside the surface if `inner`, and else is not.
    pub fn height_over(
        &self,
        scene: &Scene,
        point: DVec3,
        front: DVec3,
        inner: bool,
    ) -> Option<f64> {
        let sides = [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
        let mut heights = (sides.into_iter()).map(|side| self.height_to(scene, point, front, side));
        match inner {
            true => heights.try_fold(0.0, |_, height| height),
            false => heights.find_map(|height| height),
        }
    }

    /// The same along a line that leans to one of four sides.
    fn height_to(&self, scene: &Scene, point: DVec3, front: DVec3, side: [f64; 2]) -> Option<f64> {
        let mut nearest = Nearest::default();
        let direction = upright(front, side);
        self.cross(scene, point, direction, f64::NEG_INFINITY, |crossing| {
            nearest.take(&crossing);
        });
        nearest.height()
    }

    /// The triangles that decide the [`SurfaceTree::height`] of points in a box.
    pub fn over(&self, scene: &Scene, [low, high]: [DVec3; 2], front: DVec3) -> Vec<[[f32; 3]; 3]> {
        let [least, most] = [self.nodes[0].low, self.nodes[0].high].map(|end| end.as_dvec3());
        let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let farthest = (low - most).abs().max((high - least).abs()).length();
        let slack = UPRIGHT * farthest + 1e-9 * low.abs().max(high.abs()).length();
        let across = front.any_orthonormal_vector();
        let may = |least: DVec3, most: DVec3| {
            let (off, reach) = ((least + most) * 0.5 - middle, (most - least) * 0.5 + half);
            let meets = |axis: DVec3| off.dot(axis).abs() <= reach.dot(axis.abs()) + slack;
            meets(across) && meets(front.cross(across))
        };
        let mut found = Vec::new();
        self.any_of(scene, least, most, may, |corners| {
            found.push(corners);
            false
        });
        found
    }

    /// Where a straight way meets the surface, as shares of it.
    pub fn crossings(&self, scene: &Scene, from: DVec3, to: DVec3, take: &mut Vec<f64>) {
        self.cross(scene, from, to - from, 0.0, |crossing| {
            if crossing.t < 1.0 {
                take.push(crossing.t);
            }
        });
    }

    /// Where a straight way meets the surface first, as a share of it, and whether it meets its front there.
    pub fn nearest(&self, scene: &Scene, from: DVec3, to: DVec3) -> Option<(f64, bool)> {
        let mut nearest: Option<(f64, bool)> = None;
        self.cross(scene, from, to - from, 0.0, |crossing| {
            if crossing.t < nearest.map_or(1.0, |(t, _)| t) {
                nearest = Some((crossing.t, crossing.front));
            }
        });
        nearest
    }

    /// True where a ray meets the surface off its origin.
    pub fn is_ahead(&self, scene: &Scene, origin: DVec3, direction: DVec3) -> bool {
        let mut is_ahead = false;
        self.cross(scene, origin, direction, CLEAR, |_| is_ahead = true);
        is_ahead
    }

    /// Hands over where a line meets triangles beyond a distance, in lengths of its direction.
    fn cross(
        &self,
        scene: &Scene,
        point: DVec3,
        direction: DVec3,
        beyond: f64,
        mut take: impl FnMut(Crossing),
    ) {
        let sight = ShearedRay::new(point, direction);
        let inverse = direction.recip();
        let mut pending = [0u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[pending[depth] as usize];
            let a = (node.low.as_dvec3() - point) * inverse;
            let b = (node.high.as_dvec3() - point) * inverse;
            let (enters, leaves) = (a.min(b).max_element(), a.max(b).min_element());
            // Rounding must not hide a box; half of it is below 0 for a whole line.
            let slack = (SLACK - 1.0) * enters.abs().max(leaves.abs());
            if leaves + slack < beyond || enters > leaves + slack {
                continue;
            }
            if node.count == 0 {
                (pending[depth], pending[depth + 1]) = (node.first, node.first + 1);
                depth += 2;
                continue;
            }
            for &face in self.faces_of(node) {
                let corners = corners(scene, face).map(|corner| corner.to_array());
                if let Some(crossing) = sight.cross(&corners).filter(|c| c.t > beyond) {
                    take(crossing);
                }
            }
        }
    }

    /// True where a triangle of the surface may meet the box; false is certain.
    pub fn meets(&self, scene: &Scene, low: DVec3, high: DVec3) -> bool {
        self.any_about(scene, low, high, |_| true)
    }

    /// The corners of all triangles that may meet the box.
    pub fn about(&self, scene: &Scene, low: DVec3, high: DVec3) -> Vec<[[f32; 3]; 3]> {
        let mut found = Vec::new();
        self.any_about(scene, low, high, |corners| {
            found.push(corners);
            false
        });
        found
    }

    /// True where something holds for the corners of one of the triangles that may meet the box and a slab.
    pub fn any_in(
        &self,
        scene: &Scene,
        [low, high]: [DVec3; 2],
        slab: &Slab,
        holds: impl FnMut([[f32; 3]; 3]) -> bool,
    ) -> bool {
        self.any_of(scene, low, high, |low, high| slab.meets(low, high), holds)
    }

    /// Hands over the corners of triangles that may meet the box until one is taken; false where none is.
    fn any_about(
        &self,
        scene: &Scene,
        low: DVec3,
        high: DVec3,
        take: impl FnMut([[f32; 3]; 3]) -> bool,
    ) -> bool {
        self.any_of(scene, low, high, |_, _| true, take)
    }

    /// The same of those whose own boxes something holds for, as it then does for boxes about them.
    fn any_of(
        &self,
        scene: &Scene,
        low: DVec3,
        high: DVec3,
        may: impl Fn(DVec3, DVec3) -> bool,
        mut take: impl FnMut([[f32; 3]; 3]) -> bool,
    ) -> bool {
        let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let mut pending = [0u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[pending[depth] as usize];
            let [least, most] = [node.low, node.high].map(|end| end.as_dvec3());
            let apart = least.cmpgt(high) | most.cmplt(low);
            if apart.any() || !may(least, most) {
                continue;
            }
            if node.count == 0 {
                (pending[depth], pending[depth + 1]) = (node.first, node.first + 1);
                depth += 2;
                continue;
            }
            for &face in self.faces_of(node) {
                let exact = corners(scene, face);
                let [a, b, c] = exact.map(|corner| corner.as_dvec3());
                let (least, most) = (a.min(b).min(c), a.max(b).max(c));
                let apart = least.cmpgt(high) | most.cmplt(low);
                if apart.any() || !may(least, most) {
                    continue;
                }
                let normal = (b - a).cross(c - a);
                let meets = normal.dot(middle - a).abs() <= normal.abs().dot(half);
                if meets && take(exact.map(|corner| corner.to_array())) {
                    return true;
                }
            }
        }
        false
    }

    fn faces_of(&self, node: &Node) -> &[Face] {
        &self.faces[node.first as usize..(node.first + node.count) as usize]
    }
}

/// How far in front of some triangles a point stands, as [`SurfaceTree::height`] tells it of a surface.
pub(super) fn height_over(triangles: &[[[f32; 3]; 3]], point: DVec3, front: DVec3) -> Option<f64> {
    let mut nearest = Nearest::default();
    let sight = ShearedRay::new(point, upright(front, [1.0, 1.0]));
    let crossings = triangles.iter().filter_map(|corners| sight.cross(corners));
    crossings.for_each(|crossing| nearest.take(&crossing));
    nearest.height()
}

/// A line along a direction that leans to one of four sides.
fn upright(front: DVec3, side: [f64; 2]) -> DVec3 {
    let across = front.any_orthonormal_vector();
    let [a, b] = [0, 1].map(|k| UPRIGHT * LEAN[k] * side[k]);
    front + across * a + front.cross(across) * b
}

/// The crossing nearest to the start of a line, on either side.
#[derive(Default)]
struct Nearest(Option<f64>);

impl Nearest {
    fn take(&mut self, crossing: &Crossing) {
        if self.0.is_none_or(|t| crossing.t.abs() < t.abs()) {
            self.0 = Some(crossing.t);
        }
    }

    /// How far its start stands in front of it.
    fn height(&self) -> Option<f64> {
        self.0.map(|t| -t)
    }
}

impl Node {
    /// A leaf of items of which the first is number `first` of all.
    fn around(items: &[(Face, [Vec3; 2])], first: usize) -> Self {
        let whole = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let [low, high] = items.iter().fold(whole, |[low, high], (_, [a, b])| {
            [low.min(*a), high.max(*b)]
        });
        Self {
            low,
            high,
            first: first as u32,
            count: items.len() as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{scene, sphere};
    use glam::DQuat;

    #[test]
    fn a_slab_leaves_out_faces_that_do_not_reach_into_it_alone() {
        let scene = scene(vec![sphere(3)]);
        let count = scene.meshes[0].triangles.len() as u32;
        let faces: Vec<Face> = (0..count).map(|triangle| Face::of(0, triangle)).collect();
        let tree = SurfaceTree::build(&scene, &faces);
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::new(2.0, -0.5, 1.0),
            DQuat::from_rotation_z(0.4) * DQuat::from_rotation_x(1.1),
            DVec3::new(3.0, 1.0, -2.0),
        );
        let all = [DVec3::splat(-2.0), DVec3::splat(2.0)];
        for (normal, at) in [(DVec3::X, 3.5), (DVec3::new(0.48, -0.6, 0.64), -0.5)] {
            let slab = Slab {
                normal,
                at,
                within: 0.1,
            };
            let mut found = Vec::new();
            tree.any_in(&scene, all, &slab.before(&place), |face| {
                found.push(face);
                false
            });
            let reaches = |face: &[[f32; 3]; 3]| {
                let heights = face.map(|p| {
                    let corner = place.transform_point3(DVec3::from(p.map(f64::from)));
                    corner.dot(normal) - at
                });
                heights.iter().any(|h| *h >= -0.1) && heights.iter().any(|h| *h <= 0.1)
            };
            let own = |face: &Face| corners(&scene, *face).map(|p| p.to_array());
            let expected = faces.iter().map(own).filter(reaches).count();
            assert_eq!(found.iter().filter(|face| reaches(face)).count(), expected);
            // Boxes of faces reach a little farther than these do.
            assert!(
                expected > 20 && found.len() < 2 * expected,
                "{expected}, {}",
                found.len()
            );
            assert!(found.len() < faces.len() / 2, "{}", found.len());
        }
    }
}
