//! Covers: flat sheets that lie just above a surface, such as paper on a desk, decals, rugs and road marks.
//!
//! What is between the two is dark, and nobody sees it as that: an opaque sheet hides it, and through a see-through one
//! it is to look as the surface does beside it. Where the sheet ends within a texel of the surface, that texel would
//! still hold some of the dark, as a line around every mark of a street. So who bakes may let rays of what is covered
//! begin above the sheet. A sheet that looks at the surface hides nothing from who looks at it from its other side, so
//! it covers nothing; nor does what lies in the surface itself, which takes no light from it.

use super::Solids;
use super::placed::{ABOUT, Placed, Sheet};
use super::rims::{box_corners, plane};
use crate::boxes::Boxes;
use crate::solid::NUDGE;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// How far above a surface a sheet may lie to be asked for, in sizes of the sheet.
const ABOVE: f64 = ABOUT;
/// The cosine of the angle between a surface and what covers it, at least.
const ALONG: f64 = 0.999;

/// Triangles of the sheets that may cover a surface.
#[derive(Debug, Default)]
pub struct Covers {
    triangles: Vec<[DVec3; 3]>,
    /// How far above it they lie at most.
    above: f64,
    boxes: Boxes,
}

impl Covers {
    /// The triangles that may cover something in a box.
    pub fn about(&self, low: DVec3, high: DVec3) -> impl Iterator<Item = &[DVec3; 3]> {
        self.within(low, high, self.above)
    }

    fn within(&self, low: DVec3, high: DVec3, above: f64) -> impl Iterator<Item = &[DVec3; 3]> {
        let numbers = self.boxes.meeting(low - above, high + above).into_iter();
        numbers.map(|number| &self.triangles[number as usize])
    }

    /// The triangles over a box no higher than `above` over a plane, of which a point and the unit normal are given;
    /// those that lie along it and look as it does alone.
    pub fn over(
        &self,
        (low, high): (DVec3, DVec3),
        (place, normal): (DVec3, DVec3),
        above: f64,
    ) -> impl Iterator<Item = &[DVec3; 3]> {
        let reach = low.abs().max(high.abs()).max_element();
        let least = 2.0 * NUDGE * reach;
        self.within(low, high, above).filter(move |[a, b, c]| {
            let front = (*b - *a).cross(*c - *a).normalize_or_zero();
            let height = |corner: &DVec3| (*corner - place).dot(normal);
            let is_near = |corner| (least..=above).contains(&height(corner));
            front.dot(normal) > ALONG && [a, b, c].into_iter().all(is_near)
        })
    }
}

impl Solids {
    /// What may cover the surface of a triangle.
    pub fn covers(&self, instance: u32, triangle: u32) -> Option<&Covers> {
        if self.covers.is_empty() {
            return None;
        }
        self.covers.get(&self.surface_key(instance, triangle))
    }

    pub(super) fn find_covers(
        &self,
        placed: &[Placed],
        sheets: &[Sheet],
    ) -> HashMap<(u32, u32), Covers> {
        let of = |sheet: &Sheet| {
            let near = sheet.near.iter().map(|&other| &placed[other as usize]);
            let sheet = &placed[sheet.place];
            let mut covered = Vec::new();
            if let Some((normal, at)) = plane(&self.scene, sheet) {
                let is_covered = |other: &&Placed| self.lies_under((normal, at), sheet, other);
                covered.extend(near.filter(is_covered).map(|other| other.key));
            }
            let mut triangles = Vec::new();
            if !covered.is_empty() {
                let corners: Vec<DVec3> = sheet.corners(&self.scene).collect();
                let mirrors = sheet.transform.matrix3.determinant() < 0.0;
                let turned = |&[a, b, c]: &[DVec3; 3]| if mirrors { [a, c, b] } else { [a, b, c] };
                triangles.extend(corners.as_chunks::<3>().0.iter().map(turned));
            }
            let above = ABOVE * sheet.size();
            covered
                .into_iter()
                .map(move |key| (key, triangles.clone(), above))
        };
        let found: Vec<_> = sheets.par_iter().flat_map_iter(of).collect();
        let mut covers: HashMap<(u32, u32), Covers> = HashMap::new();
        for (key, triangles, above) in found {
            let of = covers.entry(key).or_default();
            of.above = of.above.max(above);
            of.triangles.extend(triangles);
        }
        for of in covers.values_mut() {
            let boxes =
                (of.triangles.iter()).map(|[a, b, c]| (a.min(*b).min(*c), a.max(*b).max(*c)));
            of.boxes = Boxes::of(
                (0..)
                    .zip(boxes)
                    .map(|(number, (low, high))| (number, low, high)),
            );
        }
        covers
    }

    /// True where a face of a surface lies closely behind a flat sheet, and looks as it does.
    fn lies_under(&self, (normal, at): (DVec3, f64), sheet: &Placed, other: &Placed) -> bool {
        let slack = ABOVE * sheet.size();
        let corners = box_corners(sheet.low - slack, sheet.high + slack);
        let limits = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let local = corners
            .map(|corner| other.inverse.transform_point3(corner))
            .into_iter();
        let (low, high) = local.fold(limits, |(low, high), p| (low.min(p), high.max(p)));
        let reach = sheet.low.abs().max(sheet.high.abs()).max_element();
        let least = 2.0 * NUDGE * reach;
        let mirrors = other.transform.matrix3.determinant() < 0.0;
        let sense = if mirrors { -1.0 } else { 1.0 };
        let tree = self.tree_of(other.shape, other.key.1);
        tree.about(&self.scene, low, high).into_iter().any(|face| {
            let place = |p: [f32; 3]| {
                other
                    .transform
                    .transform_point3(DVec3::from(p.map(f64::from)))
            };
            let [a, b, c] = face.map(place);
            let front = sense * (b - a).cross(c - a).normalize_or_zero();
            let is_near = |corner: DVec3| (least..=slack).contains(&(at - corner.dot(normal)));
            front.dot(normal) > ALONG && [a, b, c].into_iter().any(is_near)
        })
    }
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
            let covers = world.solids().covers(0, triangle);
            let over = covers.map(|covers| covers.over((at, at), (at, up), above).count());
            over.unwrap_or(0)
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
}
