//! Rims: what a thin wall cuts off from the end of a surface.
//!
//! A floor that reaches a little through a wall without thickness ends in a rim that sees the other side. On the page
//! it may be a hundredth of a texel, and still light the texel that it shares with the floor, or be all that a texel
//! holds. Whatever is thinner than a small part of a texel cannot be shown beside what is not. So who bakes may end the
//! surface at the wall, whichever side of it is seen. Of a flat sheet that ends behind a wall as long as its rim, such
//! as a floor below the walls of a room, look-ups before the wall read a rim of up to a whole texel.

use super::Solids;
use super::covers::Covering;
use super::placed::{CROSSES, Placed, PlacedTree, box_corners, most_meetings};
use super::topology::corners;
use super::weld::Face;
use crate::solid::NUDGE;
use glam::DVec3;
use rayon::prelude::*;
use scene::{Scene, around};
use std::collections::{BTreeMap, HashMap};

/// Faces of a surface of which each corner is looked at; of a larger one the box. And of one of which flat parts are.
const FEW: usize = 1000;

/// As long is this share of a rim.
const LONG: f64 = 0.75;

/// Normals and places of flat parts are rounded to these, in sizes of their surface.
const ALIKE: f64 = 1e-3;
const LEVEL: f64 = 1e-4;

/// Placement and number of a surface.
type Key = (u32, u32);

type Rims = HashMap<Key, Vec<Rim>>;

/// What a flat sheet cuts off from a surface, thinner than an eighth of what it leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rim {
    /// Unit normal of the sheet, away from the rim.
    pub inward: DVec3,
    /// Where the sheet is along it.
    pub at: f64,
    /// How far the surface reaches beyond, at most.
    pub depth: f64,
    /// The share of a texel that this may be where the surface ends at the sheet.
    pub most: f64,
}

/// A flat sheet, or a flat part of another surface, where it is placed.
struct Plate {
    /// The place of its surface in a list.
    place: usize,
    /// It is all of that.
    is_whole: bool,
    normal: DVec3,
    at: f64,
    low: DVec3,
    high: DVec3,
}

impl Plate {
    fn size(&self) -> f64 {
        (self.high - self.low).max_element()
    }

    fn meets(&self, low: DVec3, high: DVec3) -> bool {
        self.low.cmple(high).all() && self.high.cmpge(low).all()
    }

    /// True where it is about as long as a box, or longer.
    fn spans(&self, low: DVec3, high: DVec3) -> bool {
        let along = (high - low).max_position();
        let both = self.high[along].min(high[along]) - self.low[along].max(low[along]);
        both >= LONG * (high - low)[along]
    }
}

impl Rim {
    /// A rim is at most this share of what is on the other side of its sheet.
    pub const THIN: f64 = 0.125;

    /// Of a surface beside a plate's plane.
    fn of(scene: &Scene, plate: &Plate, other: &Placed) -> Option<Self> {
        let (normal, at) = (plate.normal, plate.at);
        let corners: Vec<DVec3> = match other.surface.faces.len() <= FEW {
            true => other.corners(scene).collect(),
            false => box_corners(other.low, other.high).to_vec(),
        };
        let heights = corners.iter().map(|corner| corner.dot(normal) - at);
        let limits = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = heights.fold(limits, |(low, high), h| (low.min(h), high.max(h)));
        let (depth, out) = (high.min(-low), high.max(-low));
        let reach = other.low.abs().max(other.high.abs()).max_element();
        let least = (CROSSES * other.size()).max(2.0 * NUDGE * reach);
        if depth <= least || depth > Self::THIN * out {
            return None;
        }
        let side = if high > -low { 1.0 } else { -1.0 };
        let mut rim = Self {
            inward: side * normal,
            at: side * at,
            depth,
            most: Self::THIN,
        };
        // The plate may end elsewhere.
        let beyond = corners
            .into_iter()
            .filter(|&corner| rim.height(corner) < 0.0);
        let (low, high) = around(beyond);
        let is_flat = other.surface.front.is_some();
        if is_flat && plate.spans(low, high) {
            rim.most = 1.0;
        }
        let is_wall = plate.is_whole || rim.most == 1.0;
        (is_wall && plate.meets(low - depth, high + depth)).then_some(rim)
    }

    /// How far before the sheet a point is; below 0 on the rim.
    pub fn height(&self, point: DVec3) -> f64 {
        point.dot(self.inward) - self.at
    }
}

impl Solids {
    /// What opaque flat sheets cut off from the surface of a triangle.
    pub fn rims(&self, instance: u32, triangle: u32) -> &[Rim] {
        if self.rims.is_empty() {
            return &[];
        }
        let key = self.surface_key(instance, triangle);
        self.rims.get(&key).map_or(&[], Vec::as_slice)
    }

    pub(super) fn rims_and_covers(&self) -> (Rims, Covering) {
        let placed = self.placed_surfaces();
        let all = PlacedTree::of(placed.iter().collect());
        let rims = self.find_rims(&all);
        (rims, self.find_covers(&all, 0.0))
    }

    fn find_rims(&self, all: &PlacedTree) -> Rims {
        let mut left = most_meetings(all.placed.len());
        let mut rims = Rims::new();
        // From the largest down, as sheets are asked: see `sheets_of`.
        for plate in self.plates(all) {
            let near = all.meeting(plate.low, plate.high);
            if near.len() > left {
                break;
            }
            left -= near.len();
            for other in near.into_iter().filter(|&other| other != plate.place) {
                let other = all.placed[other];
                if let Some(rim) = Rim::of(&self.scene, &plate, other) {
                    rims.entry(other.key).or_default().push(rim);
                }
            }
        }
        rims
    }

    /// Flat opaque sheets and flat parts of other opaque surfaces, from the largest down.
    fn plates(&self, all: &PlacedTree) -> Vec<Plate> {
        let of = |(place, of): (usize, &&Placed)| -> Vec<Plate> {
            if of.surface.masked {
                return Vec::new();
            }
            if let Some((normal, at)) = plane(&self.scene, of) {
                let (low, high) = (of.low, of.high);
                return vec![Plate {
                    place,
                    is_whole: true,
                    normal,
                    at,
                    low,
                    high,
                }];
            }
            match of.surface.faces.len() <= FEW {
                true => self.flat_parts(place, of),
                false => Vec::new(),
            }
        };
        let found = all.placed.par_iter().enumerate();
        let mut plates: Vec<Plate> = found.flat_map_iter(of).collect();
        plates.sort_by(|a, b| b.size().total_cmp(&a.size()).then(a.place.cmp(&b.place)));
        plates
    }

    fn flat_parts(&self, place: usize, of: &Placed) -> Vec<Plate> {
        let mut parts: BTreeMap<[i64; 4], Plate> = BTreeMap::new();
        let world = |face: &Face| {
            corners(&self.scene, *face).map(|p| of.transform.transform_point3(p.as_dvec3()))
        };
        for [a, b, c] in of.surface.faces.iter().map(world) {
            let Some(normal) = (b - a).cross(c - a).try_normalize() else {
                continue;
            };
            // Either side is that of the plane.
            let normal = normal * normal[normal.abs().max_position()].signum();
            let at = a.dot(normal);
            let place_of = (at - of.low.dot(normal)) / (LEVEL * of.size());
            let [x, y, z] = (normal / ALIKE).round().as_i64vec3().to_array();
            let part = parts.entry([x, y, z, place_of.round() as i64]);
            let part = part.or_insert(Plate {
                place,
                is_whole: false,
                normal,
                at,
                low: a,
                high: a,
            });
            for corner in [a, b, c] {
                (part.low, part.high) = (part.low.min(corner), part.high.max(corner));
            }
        }
        parts.into_values().collect()
    }
}

/// Unit normal of a flat sheet and where it is along it; `None` for any other surface.
pub(super) fn plane(scene: &Scene, sheet: &Placed) -> Option<(DVec3, f64)> {
    let front = sheet.surface.front?;
    let normal = (sheet.inverse.matrix3.transpose() * front).try_normalize()?;
    let first = corners(scene, sheet.surface.faces[0])[0].as_dvec3();
    let at = sheet.transform.transform_point3(first).dot(normal);
    let slack = CROSSES * sheet.size();
    let is_flat = |corner: DVec3| (corner.dot(normal) - at).abs() <= slack;
    sheet.corners(scene).all(is_flat).then_some((normal, at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{block, mask_left_half, mesh, placed_scene, world};
    use glam::{DAffine3, DQuat, Vec3};
    use scene::Mesh;

    fn quad(corners: [[f32; 3]; 4]) -> Mesh {
        let corners = corners.map(Vec3::from_array).to_vec();
        mesh(corners, vec![[0, 1, 2], [0, 2, 3]])
    }

    /// From x = -2 to `end`, level, of height 0.
    fn floor(end: f32) -> Mesh {
        quad([
            [-2.0, 0.0, 2.0],
            [end, 0.0, 2.0],
            [end, 0.0, -2.0],
            [-2.0, 0.0, -2.0],
        ])
    }

    /// At x = 0, from z = `from` to 1; seen from the right where `turned`.
    fn wall(bottom: f32, from: f32, turned: bool) -> Mesh {
        let mut wall = quad([
            [0.0, bottom, from],
            [0.0, bottom, 1.0],
            [0.0, 2.0, 1.0],
            [0.0, 2.0, from],
        ]);
        if turned {
            wall.triangles.iter_mut().for_each(|t| t.reverse());
        }
        wall
    }

    /// Depths of the rims of the first mesh, turned in space, and whether each keeps what is left of the wall.
    fn rims(meshes: Vec<Mesh>, masked: bool) -> Vec<(f64, bool)> {
        let turn = DQuat::from_axis_angle(DVec3::new(0.2, 0.3, 1.0).normalize(), 0.31);
        let placed: Vec<_> = (0..meshes.len() as u32)
            .map(|k| {
                (
                    k,
                    DAffine3::from_rotation_translation(turn, DVec3::new(3.0, 1.0, 2.0)),
                )
            })
            .collect();
        let mut scene = placed_scene(meshes, &placed);
        if masked {
            mask_left_half(&mut scene);
        }
        let world = world(scene);
        let solids = Solids::of(world.scene());
        let left = placed[0].1.transform_point3(DVec3::NEG_X);
        let rims = solids.rims(0, 0).iter();
        rims.map(|rim| (rim.depth, rim.height(left) > 0.0))
            .collect()
    }

    #[test]
    fn a_floor_that_reaches_a_little_through_a_wall_has_a_rim_whichever_side_it_shows() {
        for turned in [false, true] {
            for bottom in [-0.1, 0.0] {
                let found = rims(vec![floor(0.01), wall(bottom, -1.0, turned)], false);
                assert_eq!(found.len(), 1, "turned {turned}, bottom {bottom}");
                assert!((found[0].0 - 0.01).abs() < 1e-6 && found[0].1, "{found:?}");
            }
        }
        let block = block(Vec3::new(-1.0, 0.5, 0.0), Vec3::new(1.01, 0.5, 0.5), false);
        assert_eq!(rims(vec![block, wall(0.0, -1.0, false)], false).len(), 1);
    }

    #[test]
    fn what_goes_on_beyond_a_wall_and_what_only_touches_it_has_no_rim() {
        for end in [-0.01, 0.0, 1e-6, 0.3, 2.0] {
            let found = rims(vec![floor(end), wall(-0.1, -1.0, false)], false);
            assert_eq!(found, [], "the floor ends at {end}");
        }
        // Open, closed and masked; beside the floor; a floor of two levels that a wall cuts elsewhere.
        let mut bent = wall(-0.1, -1.0, false);
        bent.positions[2].x = 0.2;
        let thick = block(Vec3::new(-0.05, 1.0, 0.0), Vec3::new(0.05, 1.0, 1.0), false);
        let mut beside = wall(-0.1, -1.0, false);
        beside.positions.iter_mut().for_each(|p| p.z += 3.5);
        for (name, other) in [("bent", bent), ("thick", thick), ("beside", beside)] {
            assert_eq!(rims(vec![floor(0.01), other], false), [], "{name}");
        }
        let masked = rims(vec![floor(0.01), wall(-0.1, -1.0, false)], true);
        assert_eq!(masked, [], "a wall with holes");
    }
}
