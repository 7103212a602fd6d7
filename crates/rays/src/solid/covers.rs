//! Covers: thin layers that lie just above a surface, such as paper on a desk, decals, rugs and road marks.
//!
//! What is between the two is dark, and nobody sees it as that: an opaque layer hides it, and through a see-through one
//! it is to look as the surface does beside it. Where the layer ends within a texel of the surface, that texel would
//! still hold some of the dark, as a line around every mark of a street. So who bakes may let rays of what is covered
//! begin above the layer.
//!
//! A layer is an open surface that looks to one side, bent or flat, or a closed one that is thin for its size. Of that
//! the side that looks at the surface tells how near it is. What it is near to counts as what it stands on: it is
//! buried. It covers what its faces lie straight above and look along, and no more: a wall covers no floor, for they
//! look elsewhere, and a sheet that looks at the surface hides nothing from who looks at it from its other side. What
//! lies in the surface itself covers nothing either, for it takes no light from it.

use super::Solids;
use super::placed::{ABOUT, Among, Placed, Sheet, box_corners, sheets_of};
use super::topology::{Face, Surface, corners};
use crate::boxes::Boxes;
use crate::solid::NUDGE;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use scene::Scene;
use std::collections::HashMap;

/// How far above a surface a layer may lie where nobody says how far, in sizes of the smaller of the two: between what
/// is farther apart people may stand. And how thick a layer may be, in its own sizes.
const ABOVE: f64 = ABOUT;
/// The cosine of the angle between a surface and what covers it, at least.
const ALONG: f64 = 0.95;
/// Faces of a layer that are asked what lies behind them; of more, so many, evenly.
const ASKED: usize = 256;

/// A triangle of a layer that lies over a surface.
#[derive(Debug, Clone, Copy)]
pub struct Cover {
    /// In the order in which they are seen from above the surface.
    pub corners: [DVec3; 3],
    /// How far above the surface it covers at least.
    pub least: f64,
    /// True for a closed layer, which buries what is under it.
    pub buries: bool,
}

/// A layer where it is placed.
#[derive(Debug, Clone)]
struct Layer {
    shape: u32,
    surface: u32,
    transform: DAffine3,
    inverse: DAffine3,
    side: Side,
    low: DVec3,
    high: DVec3,
}

/// Which side of a layer tells how near it is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    /// The front of a sheet, which looks as the surface does.
    Front,
    /// What looks at the surface: the fronts of a closed layer that looks outward, the backs of one that looks inward.
    Outer { inward: bool },
}

impl Side {
    fn of(surface: &Surface) -> Self {
        match surface.front.or(surface.veil) {
            Some(_) => Self::Front,
            None => Self::Outer {
                inward: surface.content() < 0.0,
            },
        }
    }

    /// The corners of a triangle, given as they are seen from its front, as they are seen from above the surface if
    /// it is of that side.
    fn seen(self, [a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
        match self {
            Self::Outer { inward: false } => [a, c, b],
            _ => [a, b, c],
        }
    }

    /// How far above a surface with coordinates up to `reach` it lies at least: nearer, a sheet lies in the surface,
    /// and on what a closed layer holds the surface is buried.
    fn least(self, reach: f64) -> f64 {
        match self {
            Self::Front => Covers::least(reach),
            Self::Outer { .. } => NUDGE * reach,
        }
    }
}

/// What may cover a surface.
#[derive(Debug, Default)]
struct Layers {
    layers: Vec<Layer>,
    /// How far above it they lie at most.
    above: f64,
    boxes: Boxes,
}

/// What covers what in a scene, see [`Solids::covering`].
#[derive(Debug, Default)]
pub struct Covering {
    /// By placement and number of what is covered.
    of: HashMap<(u32, u32), Layers>,
}

impl Covering {
    /// True where nothing covers anything.
    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }
}

/// What may cover the surface of a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Covers<'a> {
    solids: &'a Solids,
    layers: &'a Layers,
}

impl Covers<'_> {
    /// How far above the surface they lie at most, in scene units.
    pub fn above(&self) -> f64 {
        self.layers.above
    }

    /// The triangles that may cover something in a box.
    pub fn about(&self, low: DVec3, high: DVec3) -> impl Iterator<Item = [DVec3; 3]> {
        let all = self.within(low, high, self.layers.above);
        all.map(|(_, corners)| corners)
    }

    fn within(
        &self,
        low: DVec3,
        high: DVec3,
        above: f64,
    ) -> impl Iterator<Item = (Side, [DVec3; 3])> {
        let (low, high) = (low - above, high + above);
        let numbers = self.layers.boxes.meeting(low, high).into_iter();
        numbers.flat_map(move |number| {
            let layer = &self.layers.layers[number as usize];
            let faces = self.solids.faces_about(
                (layer.shape, layer.surface),
                &layer.transform,
                &layer.inverse,
                (low, high),
            );
            let seen = |face| (layer.side, layer.side.seen(face));
            faces.into_iter().map(seen)
        })
    }

    /// The triangles about a box of which some may lie no higher than `above` over a plane, of which a point and the
    /// unit normal are given; those of the sides that tell how near layers are alone.
    pub fn over(
        &self,
        (low, high): (DVec3, DVec3),
        (place, normal): (DVec3, DVec3),
        above: f64,
    ) -> impl Iterator<Item = Cover> {
        let reach = low.abs().max(high.abs()).max_element();
        let all = self.within(low, high, above);
        let is_over = move |&(side, face): &(Side, [DVec3; 3])| {
            let heights = face.map(|corner| (corner - place).dot(normal));
            let is_near = heights.iter().any(|h| *h >= side.least(reach))
                && heights.iter().any(|h| *h <= above);
            is_near && front(&face).dot(normal) > ALONG
        };
        all.filter(is_over).map(move |(side, corners)| Cover {
            corners,
            least: side.least(reach),
            buries: side != Side::Front,
        })
    }

    /// How far above a surface with coordinates up to `reach` a sheet lies at least: nearer, it lies in it.
    pub(super) fn least(reach: f64) -> f64 {
        2.0 * NUDGE * reach
    }
}

impl Solids {
    /// What covers what where layers lie at most so far above a surface, in scene units, or a 32nd of the smaller of
    /// the two.
    pub fn covering(&self, above: f64) -> Covering {
        let placed = self.placed_surfaces();
        self.find_covers(&Among::of(placed.iter().collect()), above)
    }

    /// What may cover a triangle of all that does in `asked`, or, where that is `None`, of what lies at most a 32nd of
    /// the smaller of the two above a surface; `None` where nothing that does is `within` so far of it, in scene units.
    pub fn covers<'a>(
        &'a self,
        asked: Option<&'a Covering>,
        (instance, triangle): (u32, u32),
        within: impl FnOnce() -> f64,
    ) -> Option<Covers<'a>> {
        let covering = asked.unwrap_or(&self.covers);
        if covering.is_empty() {
            return None;
        }
        let layers = covering.of.get(&self.surface_key(instance, triangle))?;
        let covers = Covers {
            solids: self,
            layers,
        };
        let of = &self.scene.instances[instance as usize];
        let corners = corners(&self.scene, Face::of(of.mesh, triangle))
            .map(|p| of.transform.transform_point3(p.as_dvec3()));
        let (low, high) = box_of(corners);
        let mut near = covers.within(low, high, within().min(layers.above));
        near.next().is_some().then_some(covers)
    }

    /// As [`Self::covering`].
    pub(super) fn find_covers(&self, all: &Among, least: f64) -> Covering {
        let placed = &all.placed;
        let is_layer = |surface: &Surface| surface.is_layer(&self.scene);
        let sheets = sheets_of(all, is_layer, least);
        let above = |layer: &Placed, other: &Placed| above(layer, other).max(least);
        let of = |sheet: &Sheet| {
            let near = sheet.near.iter().map(|&other| placed[other as usize]);
            let sheet = placed[sheet.place];
            let found = near.map(|other| (other, above(sheet, other)));
            let covered = found.filter(|&(other, above)| self.lies_under(sheet, other, above));
            let covered: Vec<_> = covered
                .map(|(other, above)| (other.key, sheet, above))
                .collect();
            covered
        };
        let found: Vec<_> = sheets.par_iter().flat_map_iter(of).collect();
        let mut covers: HashMap<(u32, u32), Layers> = HashMap::new();
        for (key, sheet, above) in found {
            let of = covers.entry(key).or_default();
            of.above = of.above.max(above);
            of.layers.push(Layer {
                shape: sheet.shape,
                surface: sheet.key.1,
                transform: sheet.transform,
                inverse: sheet.inverse,
                side: Side::of(sheet.surface),
                low: sheet.low,
                high: sheet.high,
            });
        }
        for of in covers.values_mut() {
            let boxes = of.layers.iter().map(|layer| (layer.low, layer.high));
            let numbered = (0..).zip(boxes);
            of.boxes = Boxes::of(numbered.map(|(number, (low, high))| (number, low, high)));
        }
        Covering { of: covers }
    }

    /// True where a face of a surface lies at most `slack` behind one of a layer, and looks along it.
    fn lies_under(&self, layer: &Placed, other: &Placed, slack: f64) -> bool {
        let faces = |of: &Placed, low: DVec3, high: DVec3| {
            let key = (of.shape, of.key.1);
            self.faces_about(key, &of.transform, &of.inverse, (low - slack, high + slack))
        };
        let side = Side::of(layer.surface);
        let near = faces(layer, other.low, other.high);
        let step = near.len().div_ceil(ASKED).max(1);
        near.iter().step_by(step).any(|&face| {
            let (normal, (low, high)) = (front(&side.seen(face)), box_of(face));
            let least = side.least(low.abs().max(high.abs()).max_element());
            let is_behind =
                |corner: DVec3| (least..=slack).contains(&(face[0] - corner).dot(normal));
            faces(other, low, high).into_iter().any(|behind| {
                front(&behind).dot(normal) > ALONG && behind.into_iter().any(is_behind)
            })
        })
    }

    /// The triangles of a placed surface that may meet a box, corners in the order in which they are seen from their
    /// front.
    fn faces_about(
        &self,
        (shape, surface): (u32, u32),
        transform: &DAffine3,
        inverse: &DAffine3,
        (low, high): (DVec3, DVec3),
    ) -> Vec<[DVec3; 3]> {
        let (low, high) = box_of(box_corners(low, high).map(|p| inverse.transform_point3(p)));
        let mirrors = transform.matrix3.determinant() < 0.0;
        let tree = self.tree_of(shape, surface);
        let found = tree.about(&self.scene, low, high).into_iter();
        let placed = found.map(|face| {
            let [a, b, c] = face.map(|p| transform.transform_point3(DVec3::from(p.map(f64::from))));
            if mirrors { [a, c, b] } else { [a, b, c] }
        });
        placed.collect()
    }
}

impl Surface {
    /// True where it may cover others: it looks to one side, or is closed, openings filled, and thin for its size.
    pub(super) fn is_layer(&self, scene: &Scene) -> bool {
        if self.front.or(self.veil).is_some() {
            return true;
        }
        // Of a thin body half of the area times the thickness is what it encloses.
        let content = self.content().abs();
        let size = f64::from((self.high - self.low).max_element());
        content > 0.0 && content <= 0.5 * ABOVE * size * self.area(scene)
    }

    fn area(&self, scene: &Scene) -> f64 {
        let corners = self.faces.iter().map(|&face| corners(scene, face));
        corners
            .map(|[a, b, c]| 0.5 * f64::from((b - a).cross(c - a).length()))
            .sum()
    }
}

/// How far above a surface a layer may lie where nobody says how far.
fn above(layer: &Placed, other: &Placed) -> f64 {
    ABOVE * layer.size().min(other.size())
}

/// The unit direction to which a triangle looks.
fn front([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*b - *a).cross(*c - *a).normalize_or_zero()
}

fn box_of(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let limits = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let points = points.into_iter();
    points.fold(limits, |(low, high), p| (low.min(p), high.max(p)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{block, mask_left_half, mesh, placed_scene, world};
    use glam::{DAffine3, DQuat, Vec3};
    use scene::Mesh;

    /// A level square of height `y`, `half` to each side, that looks up or down.
    fn level(y: f32, half: f32, up: bool) -> Mesh {
        let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
        let positions = corners.map(|(x, z)| Vec3::new(x, y, z)).to_vec();
        let faces = [[[0, 1, 2], [0, 2, 3]], [[0, 2, 1], [0, 3, 2]]];
        mesh(positions, faces[usize::from(up)].to_vec())
    }

    /// How many triangles lie at most `above` over the middle of the first mesh's triangle, on a surface that looks up;
    /// by placements that turn, mirror and move all of it.
    fn over(meshes: Vec<Mesh>, masked: bool, triangle: u32, above: f64) -> Vec<usize> {
        let turn = DQuat::from_axis_angle(DVec3::new(0.2, 0.3, 1.0).normalize(), 0.31);
        let moved = DAffine3::from_rotation_translation(turn, DVec3::new(3.0, 1.0, 2.0));
        let mirrored = moved * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let count = |place: DAffine3| {
            let placed: Vec<_> = (0..meshes.len() as u32).map(|k| (k, place)).collect();
            let mut scene = placed_scene(meshes.clone(), &placed);
            if masked {
                mask_left_half(&mut scene);
            }
            let world = world(scene);
            let at = place.transform_point3(DVec3::new(0.01, 0.0, 0.02));
            let up = place.transform_vector3(DVec3::Y);
            let covers = world.solids().covers(None, (0, triangle), || f64::INFINITY);
            let is_over = |of: &Cover| (of.least..=above).contains(&(of.corners[0] - at).dot(up));
            let over = |covers: Covers| {
                covers
                    .over((at, at), (at, up), above)
                    .filter(is_over)
                    .count()
            };
            covers.map_or(0, over)
        };
        [DAffine3::IDENTITY, moved, mirrored].map(count).to_vec()
    }

    #[test]
    fn a_sheet_just_above_a_surface_that_looks_as_it_does_covers_it() {
        let floor = || level(0.0, 4.0, true);
        let mark = |y: f32| level(y, 0.5, true);
        assert_eq!(over(vec![floor(), mark(0.001)], false, 0, 0.01), [2; 3]);
        // Too high for this texel; in the floor, below it, and looking at it.
        assert_eq!(over(vec![floor(), mark(0.001)], false, 0, 0.0009), [0; 3]);
        for y in [0.0, -0.001] {
            assert_eq!(over(vec![floor(), mark(y)], false, 0, 0.01), [0; 3], "{y}");
        }
        let plate = level(0.001, 0.5, false);
        assert_eq!(over(vec![floor(), plate], false, 0, 0.01), [0; 3]);
        // A mark that is cut out is one too.
        assert_eq!(over(vec![floor(), mark(0.001)], true, 0, 0.01), [2; 3]);
    }

    #[test]
    fn a_layer_lies_as_far_above_as_it_is_asked_to() {
        // A sheet as long as 1, of which a 32nd is 0.03125.
        let meshes = || vec![level(0.0, 1.5, true), level(0.05, 0.5, true)];
        assert_eq!(over(meshes(), false, 0, 1.0), [0; 3]);
        let placed = [0, 1].map(|mesh| (mesh, DAffine3::IDENTITY));
        let world = world(placed_scene(meshes(), &placed));
        let solids = world.solids();
        for (asked, count) in [(0.0, 0), (0.049, 0), (0.051, 2), (10.0, 2)] {
            let covering = solids.covering(asked);
            let covers = solids.covers(Some(&covering), (0, 0), || f64::INFINITY);
            let found = covers.map_or(0, |covers| {
                let (at, up) = (DVec3::ZERO, DVec3::Y);
                covers.over((at, at), (at, up), asked).count()
            });
            assert_eq!(found, count, "{asked}");
        }
    }

    #[test]
    fn a_mark_on_a_closed_body_covers_the_side_that_it_lies_on() {
        let slab = block(Vec3::Y * -0.5, Vec3::new(3.0, 0.5, 3.0), false);
        let top = (0..12).find(|&t| {
            let corners = slab.triangles[t as usize].map(|k| slab.positions[k as usize]);
            corners.iter().all(|corner| corner.y == 0.0)
        });
        let top = top.expect("a block has a top");
        let meshes = || vec![slab.clone(), level(0.002, 0.5, true)];
        assert_eq!(over(meshes(), false, top, 0.01), [2; 3]);
    }

    /// Whether each of these points of the first mesh, which looks along `normal` there, has something straight above it
    /// within `above` that covers it.
    fn covered(meshes: Vec<Mesh>, points: &[(Vec3, Vec3)], above: f64) -> Vec<bool> {
        let placed: Vec<_> = (0..meshes.len() as u32)
            .map(|k| (k, DAffine3::IDENTITY))
            .collect();
        let triangles = meshes[0].triangles.len() as u32;
        let world = world(placed_scene(meshes, &placed));
        let is_covered = |&(at, normal): &(Vec3, Vec3)| {
            let (at, up) = (at.as_dvec3(), normal.as_dvec3().normalize());
            let is_over = |of: Cover| {
                let [a, b, c] = of.corners;
                let front = (b - a).cross(c - a);
                let height = (a - at).dot(front) / up.dot(front);
                let top = at + height * up;
                let sides = [(a, b), (b, c), (c, a)];
                let is_in =
                    |(from, to): (DVec3, DVec3)| front.cross(to - from).dot(top - from) >= 0.0;
                (of.least..=above).contains(&height) && sides.into_iter().all(is_in)
            };
            (0..triangles).any(|triangle| {
                let covers = world.solids().covers(None, (0, triangle), || f64::INFINITY);
                covers.is_some_and(|covers| covers.over((at, at), (at, up), above).any(is_over))
            })
        };
        points.iter().map(is_covered).collect()
    }

    /// So many squares across, from -`half` to `half` by x and z, of a height by x.
    fn bent(half: f32, across: u32, height: impl Fn(f32) -> f32) -> Mesh {
        let step = 2.0 * half / across as f32;
        let place = |k: u32| {
            let [x, z] = [k % (across + 1), k / (across + 1)].map(|k| k as f32 * step - half);
            Vec3::new(x, height(x), z)
        };
        let corner = |k: u32| k / across * (across + 1) + k % across;
        let faces = (0..across * across).map(corner).flat_map(|a| {
            let [b, c, d] = [a + 1, a + across + 2, a + across + 1];
            [[a, c, b], [a, d, c]]
        });
        mesh(
            (0..(across + 1).pow(2)).map(place).collect(),
            faces.collect(),
        )
    }

    #[test]
    fn a_layer_covers_what_it_follows_however_both_bend() {
        let road = |x: f32| 0.3 * x * x;
        // Faces of one do not end where those of the other do.
        let meshes = || vec![bent(2.0, 64, road), bent(0.5, 20, |x| road(x) + 0.004)];
        let at = |x: f32, z: f32| (Vec3::new(x, road(x), z), Vec3::new(-0.6 * x, 1.0, 0.0));
        let places = [-1.2, -0.53, -0.47, -0.21, 0.02, 0.33, 0.47, 0.53, 1.2];
        for z in [-0.56f32, -0.44, 0.07, 0.44, 0.56] {
            let points = places.map(|x| at(x, z));
            let expected = places.map(|x| x.abs() < 0.5 && z.abs() < 0.5);
            assert_eq!(covered(meshes(), &points, 0.01), expected, "{z}");
            assert_eq!(covered(meshes(), &points, 0.002), [false; 9], "{z}");
        }
    }

    #[test]
    fn a_thin_closed_body_covers_what_it_is_near_to_and_a_thick_one_nothing() {
        let floor = || level(0.0, 4.0, true);
        let body = |thick: f32, inward| {
            let middle = Vec3::Y * (0.001 + 0.5 * thick);
            block(middle, Vec3::new(0.4, 0.5 * thick, 0.4), inward)
        };
        let points = [0.0, 0.39, 0.41, 1.0].map(|x| (Vec3::new(x, 0.0, 0.1), Vec3::Y));
        for inward in [false, true] {
            let rug = |above| covered(vec![floor(), body(0.006, inward)], &points, above);
            for above in [0.008, 0.0011] {
                assert_eq!(rug(above), [true, true, false, false], "{above} {inward}");
            }
            assert_eq!(rug(0.0009), [false; 4], "{inward}");
            let block = || body(0.4, inward);
            assert_eq!(covered(vec![floor(), block()], &points, 0.5), [false; 4]);
        }
    }

    #[test]
    fn corners_steps_boards_and_slots_cover_nothing_that_is_seen() {
        let floor = || level(0.0, 4.0, true);
        let points = |places: &[[f32; 3]], normal: Vec3| -> Vec<_> {
            places.iter().map(|&p| (Vec3::from(p), normal)).collect()
        };
        // Beside a wall, a board on edge and a step of a hair.
        let floor_points = points(
            &[[0.011, 0.0, 0.0], [-0.2, 0.0, 0.0], [0.5, 0.0, 0.5]],
            Vec3::Y,
        );
        let wall = block(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.01, 1.0, 1.0), false);
        let board = block(
            Vec3::new(0.005, 0.05, 0.0),
            Vec3::new(0.005, 0.05, 1.0),
            false,
        );
        let step = block(
            Vec3::new(-0.1, 0.001, 0.0),
            Vec3::new(0.1, 0.001, 1.0),
            false,
        );
        for (name, other, labels) in [
            ("wall", wall, [false; 3]),
            ("board", board, [false; 3]),
            ("step", step, [false; 3]),
        ] {
            let found = covered(vec![floor(), other], &floor_points, 0.02);
            assert_eq!(found, labels, "{name}");
        }
        // The walls of a slot look at each other, and are as good as touching where it is narrow.
        let side = |x: f32| block(Vec3::new(x, 0.5, 0.0), Vec3::new(0.01, 0.5, 1.0), false);
        let within = points(&[[0.01, 0.5, 0.0]], Vec3::X);
        let slot = |above| covered(vec![side(0.0), side(0.025)], &within, above);
        assert_eq!([slot(0.004), slot(0.006)], [[false], [true]]);
    }
}
