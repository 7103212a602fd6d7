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

#[cfg(test)]
mod tests;

use super::Solids;
use super::placed::{ABOUT, Placed, PlacedTree, Sheet, box_corners, sheets_of};
use super::topology::{Surface, corners};
use super::tree::Slab;
use super::weld::Face;
use crate::boxes::Boxes;
use crate::solid::NUDGE;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use scene::{Scene, around};
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
        let all = self.within((low, high), self.layers.above, Slab::EVERYWHERE);
        all.map(|(_, corners)| corners)
    }

    fn within(
        &self,
        (low, high): (DVec3, DVec3),
        above: f64,
        slab: Slab,
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
                &slab,
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
        // What has a corner above the plane and one so near to it is in there, with room for rounding.
        let slab = Slab {
            normal,
            at: normal.dot(place) + 0.5 * above,
            within: 0.5 * above + Self::least(reach),
        };
        let all = self.within((low, high), above, slab);
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
        self.find_covers(&PlacedTree::of(placed.iter().collect()), above)
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
        let (low, high) = around(corners);
        let mut near = covers.within((low, high), within().min(layers.above), Slab::EVERYWHERE);
        near.next().is_some().then_some(covers)
    }

    /// As [`Self::covering`].
    pub(super) fn find_covers(&self, all: &PlacedTree, least: f64) -> Covering {
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
            let about = (low - slack, high + slack);
            self.faces_about(key, &of.transform, &of.inverse, about, &Slab::EVERYWHERE)
        };
        let side = Side::of(layer.surface);
        let near = faces(layer, other.low, other.high);
        let step = near.len().div_ceil(ASKED).max(1);
        near.iter().step_by(step).any(|&face| {
            let (normal, (low, high)) = (front(&side.seen(face)), around(face));
            let least = side.least(low.abs().max(high.abs()).max_element());
            let is_behind =
                |corner: DVec3| (least..=slack).contains(&(face[0] - corner).dot(normal));
            faces(other, low, high).into_iter().any(|behind| {
                front(&behind).dot(normal) > ALONG && behind.into_iter().any(is_behind)
            })
        })
    }

    /// The triangles of a placed surface that may meet a box and a slab, corners in the order in which they are seen
    /// from their front.
    fn faces_about(
        &self,
        (shape, surface): (u32, u32),
        transform: &DAffine3,
        inverse: &DAffine3,
        (low, high): (DVec3, DVec3),
        slab: &Slab,
    ) -> Vec<[DVec3; 3]> {
        let (low, high) = around(box_corners(low, high).map(|p| inverse.transform_point3(p)));
        let mirrors = transform.matrix3.determinant() < 0.0;
        let tree = self.tree_of(shape, surface);
        let mut found = Vec::new();
        tree.any_in(&self.scene, [low, high], &slab.before(transform), |face| {
            let [a, b, c] = face.map(|p| transform.transform_point3(DVec3::from(p.map(f64::from))));
            found.push(if mirrors { [a, c, b] } else { [a, b, c] });
            false
        });
        found
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
