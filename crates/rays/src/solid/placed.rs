//! Surfaces where they are placed: which of them meet, and which are bodies.

use super::topology::{Surface, corners};
use super::{Body, Inside, NUDGE, Solids};
use crate::boxes::Boxes;
use glam::{DAffine3, DVec3};
use scene::Scene;

/// Faces of a surface that are asked where it stands; of a larger one so many, evenly.
const ASKED: usize = 1000;
/// What comes this near counts as near, in sizes of the part that is hidden.
pub(super) const NEAR: f64 = 1e-3;
/// Smaller than this share of a sheet or a room, a surface on its hidden side does not matter: a footing, a pipe.
pub(super) const SMALL: f64 = 0.5;
/// How far a crossing surface stands at least on either side, in sizes of its box: what only touches does not cross.
pub(super) const CROSSES: f64 = 1e-5;

/// How far about a sheet surfaces are near it, in its sizes: as far as anything is asked below.
pub(super) const ABOUT: f64 = 1.0 / 32.0;
/// Surfaces near sheets, for each surface of the scene, that are looked at; and so many in any scene.
const MEETINGS: usize = 64;
const FEW_MEETINGS: usize = 1 << 17;

/// A surface where it is placed.
pub(super) struct Placed<'a> {
    /// Placement and number of the surface.
    pub key: (u32, u32),
    pub shape: u32,
    pub surface: &'a Surface,
    pub transform: DAffine3,
    pub inverse: DAffine3,
    pub low: DVec3,
    pub high: DVec3,
}

impl Placed<'_> {
    /// Some of its faces, in the world.
    pub fn faces<'b>(&'b self, scene: &'b Scene) -> impl Iterator<Item = [DVec3; 3]> + 'b {
        let step = self.surface.faces.len().div_ceil(ASKED);
        let faces = self.surface.faces.iter().step_by(step);
        faces.map(move |&face| {
            corners(scene, face).map(|corner| self.transform.transform_point3(corner.as_dvec3()))
        })
    }

    /// The corners of all its faces, in the world.
    pub fn corners<'b>(&'b self, scene: &'b Scene) -> impl Iterator<Item = DVec3> + 'b {
        let corners = self
            .surface
            .faces
            .iter()
            .flat_map(|&face| corners(scene, face));
        corners.map(|corner| self.transform.transform_point3(corner.as_dvec3()))
    }

    /// How many of the middles of `of` faces, spread over it, something holds for.
    pub fn count(&self, scene: &Scene, of: usize, holds: impl Fn(DVec3) -> bool) -> usize {
        let faces = &self.surface.faces;
        let middle = |k: usize| {
            let face = faces[k * (faces.len() - 1) / (of - 1)];
            let [a, b, c] = corners(scene, face).map(|corner| corner.as_dvec3());
            self.transform.transform_point3((a + b + c) / 3.0)
        };
        (0..of).filter(|&k| holds(middle(k))).count()
    }

    pub fn meets(&self, low: DVec3, high: DVec3) -> bool {
        self.low.cmple(high).all() && self.high.cmpge(low).all()
    }

    /// The largest side of its box.
    pub fn side(&self) -> f64 {
        let [x, y, z] = (self.high - self.low).to_array();
        (x * y).max(y * z).max(z * x)
    }

    /// What it encloses in the world, in cubic units; 0 where it is not closed.
    pub fn volume(&self) -> f64 {
        (self.surface.volume * self.transform.matrix3.determinant()).abs()
    }

    pub fn size(&self) -> f64 {
        (self.high - self.low).max_element()
    }
}

/// Some placed surfaces, with a tree over their boxes.
pub(super) struct PlacedTree<'a> {
    pub placed: Vec<&'a Placed<'a>>,
    boxes: Boxes,
}

impl<'a> PlacedTree<'a> {
    pub fn of(placed: Vec<&'a Placed<'a>>) -> Self {
        let numbered = (0..).zip(&placed);
        let boxes = Boxes::of(numbered.map(|(number, placed)| (number, placed.low, placed.high)));
        Self { placed, boxes }
    }

    /// The places in the list of those that meet a box, ascending.
    pub fn meeting(&self, low: DVec3, high: DVec3) -> Vec<usize> {
        let found = self.boxes.meeting(low, high).into_iter();
        found.map(|number| number as usize).collect()
    }

    /// True where something holds for one of those that meet a box.
    pub fn any(&self, low: DVec3, high: DVec3, holds: impl Fn(&Placed) -> bool) -> bool {
        self.any_place(low, high, |place| holds(self.placed[place]))
    }

    /// The same by the place in the list.
    pub fn any_place(&self, low: DVec3, high: DVec3, holds: impl Fn(usize) -> bool) -> bool {
        self.boxes.any(low, high, |number| holds(number as usize))
    }
}

/// A sheet, and what its box or the air just about it meets, by their places in a list.
pub(super) struct Sheet {
    pub place: usize,
    pub near: Vec<u32>,
}

/// The sheets of a scene with what is near them. Where sheets lie in a heap, all of them meet all others, and a heap of
/// sheets tells nothing about what is hidden behind which. So sheets are asked from the largest down, as long as the
/// surfaces near them are no more than so many for each surface of the scene: a time and a memory that grow with the
/// scene, not with its square.
pub(super) fn sheets(all: &PlacedTree) -> Vec<Sheet> {
    sheets_of(all, |surface| surface.front.is_some(), 0.0)
}

/// The same with what else is taken for a sheet, and all that comes `within` so far of it, if that is more.
pub(super) fn sheets_of(
    all: &PlacedTree,
    is_sheet: impl Fn(&Surface) -> bool,
    within: f64,
) -> Vec<Sheet> {
    let placed = &all.placed;
    let is_sheet = |&place: &usize| is_sheet(placed[place].surface);
    let mut places: Vec<usize> = (0..placed.len()).filter(is_sheet).collect();
    places.sort_by(|&a, &b| {
        placed[b]
            .size()
            .total_cmp(&placed[a].size())
            .then(a.cmp(&b))
    });
    let mut left = most_meetings(placed.len());
    let mut found = Vec::new();
    for place in places {
        let sheet = placed[place];
        let slack = within.max(ABOUT * sheet.size());
        let mut near = Vec::new();
        let is_too_much = all
            .boxes
            .any(sheet.low - slack, sheet.high + slack, |other| {
                near.extend((other as usize != place).then_some(other));
                near.len() > left
            });
        if is_too_much {
            break;
        }
        left -= near.len();
        near.sort_unstable();
        found.push(Sheet { place, near });
    }
    found.sort_unstable_by_key(|sheet| sheet.place);
    found
}

/// How many surfaces near sheets are looked at in a scene of so many.
pub(super) fn most_meetings(surfaces: usize) -> usize {
    FEW_MEETINGS.max(MEETINGS * surfaces)
}

impl Solids {
    /// Every surface of every placement that blocks light.
    pub(super) fn placed_surfaces(&self) -> Vec<Placed<'_>> {
        let mut known = std::collections::HashSet::new();
        let mut placed = Vec::new();
        for (index, &(shape, _, placement)) in self.instances.iter().enumerate() {
            if !known.insert(placement) || !self.scene.instances[index].casts {
                continue;
            }
            let transform = self.scene.instances[index].transform;
            for (number, surface) in self.shapes[shape as usize].surfaces.iter().enumerate() {
                let (low, high) = placed_box(surface, &transform);
                placed.push(Placed {
                    key: (placement, number as u32),
                    shape,
                    surface,
                    transform,
                    inverse: transform.inverse(),
                    low,
                    high,
                });
            }
        }
        placed
    }

    /// Makes a body's box hold those of others too, and what is tested off their surfaces.
    pub(super) fn widen(&mut self, body: u32, others: &[u32]) {
        for &other in others {
            let (low, high) = (
                self.bodies[other as usize].low,
                self.bodies[other as usize].high,
            );
            let body = &mut self.bodies[body as usize];
            (body.low, body.high) = (body.low.min(low), body.high.max(high));
        }
        let body = &mut self.bodies[body as usize];
        let reach = body
            .low
            .abs()
            .max(body.high.abs())
            .max(body.high - body.low);
        let slack = 2.0 * NUDGE * reach.max_element();
        (body.low, body.high) = (body.low - slack, body.high + slack);
    }

    /// The body of a placed surface, made if it has none.
    pub(super) fn body_of(&mut self, key: (u32, u32)) -> u32 {
        if let Some(&body) = self.placements.get(&key) {
            return body;
        }
        let instance = self.firsts[key.0 as usize] as usize;
        let (shape, ..) = self.instances[instance];
        let transform = self.scene.instances[instance].transform;
        let surface = &self.shapes[shape as usize].surfaces[key.1 as usize];
        let (low, high) = placed_box(surface, &transform);
        let body = self.bodies.len() as u32;
        self.bodies.push(Body {
            shape,
            surface: key.1,
            inverse: transform.inverse(),
            low,
            high,
            inside: Inside::Nothing,
            cut: Vec::new(),
        });
        self.placements.insert(key, body);
        body
    }
}

/// The box around a placed surface's box.
pub(super) fn placed_box(surface: &Surface, transform: &DAffine3) -> (DVec3, DVec3) {
    let (low, high) = (surface.low.as_dvec3(), surface.high.as_dvec3());
    let middle = transform.transform_point3((low + high) * 0.5);
    let half = (high - low) * 0.5;
    let m = transform.matrix3;
    let reach = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
    (middle - reach, middle + reach)
}

/// The corners of a box.
pub(super) fn box_corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|k| {
        let side = |axis: usize| if k >> axis & 1 == 0 { low } else { high };
        DVec3::new(side(0).x, side(1).y, side(2).z)
    })
}
