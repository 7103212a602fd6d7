//! Faces that look inward, of surfaces that are all but closed or are several bodies in one.
//!
//! A body of a file often lacks a triangle, or has a sliver of a hole where an edge of one side runs past a corner of
//! another. Or two bodies touch along a face and are one surface by their edges there, one of them wound the wrong way.
//! So what counts is not how a surface is put together but what is on either side of its faces. Its holes are filled.
//! A face *looks inward* where the surface winds less than 0 times around a point just in front of it, and does not
//! behind it.
//!
//! A hole is little where it cannot be meant to be looked through: a triangle that a side lacks, or what is next to
//! nothing of the surface and of its shadow on the hole's plane. The mouth of a tunnel is all of that shadow. But
//! what is long and narrow, with nothing in it, no hill about it and no wall about a mouth of it (`portal.rs`), is a
//! post.

use super::placed::{Placed, PlacedTree};
use super::portal::{Mouth, STOP};
use super::spread::{MIDDLE, corners_too, parts};
use super::topology::{Surface, corners};
use super::tree::SurfaceTree;
use super::weld::Face;
use super::{Covers, NUDGE, Solids};
use glam::DVec3;
use rayon::prelude::*;
use scene::Scene;

/// A missing triangle is no larger than this share of the surface's shadow on it: it is not all of a side. All of them
/// together are no larger than this share of what looks inward.
const TRIANGLE: f64 = 0.75;
const TRIANGLES: f64 = 0.3;
/// The same of another hole, how large it looks against what looks inward, and how large all of them are together.
const HOLE: f64 = 0.125;
const WINDOW: f64 = 1.0 / 128.0;
const HOLES: f64 = 1.0 / 32.0;
/// How large the mouth of a bore is against its surface, and all of them together: what is twelve times as long as it
/// is wide gets next to no light. It is most of the surface's shadow on its plane, as the door of a room is not.
const MOUTH: f64 = 1.0 / 48.0;
const MOUTHS: f64 = 2.0 * MOUTH;
/// The share of looks outward that may meet a back where a post stands free: around a tunnel is the inside of its hill.
const BACKS: f64 = 0.125;
/// The share of a surface with holes that looks inward, at least.
const MOST: f64 = 0.5;
/// The share of a surface with holes that may have the same on either side.
const ODD: f64 = 0.1;
/// What stands in a room has this share of the room's side, together: else it is stuck in a wall.
const STANDS: f64 = 1.0 / 1024.0;
/// Faces that are asked first.
pub(super) const FIRST: usize = 1024;
/// Faces that are asked whether a surface lies for the most part in another.
pub(super) const LOOKS: usize = 64;

/// A triangle's area, and how often its surface winds around points just in front of it and behind.
pub(super) struct Sides {
    pub area: f64,
    front: i32,
    back: i32,
}

impl Sides {
    /// Of a triangle of a surface, or of a pane of one of its holes, at a point by its weights.
    pub fn of(
        (scene, surface, tree): (&Scene, &Surface, &SurfaceTree),
        [a, b, c]: [DVec3; 3],
        [u, v, w]: [f64; 3],
    ) -> Self {
        let reach = surface.low.abs().max(surface.high.abs()).max_element();
        let (middle, normal) = (u * a + v * b + w * c, (b - a).cross(c - a));
        let off = normal.normalize_or_zero() * (4.0 * NUDGE * f64::from(reach));
        let winding = |at| tree.winding(scene, surface.caps.iter().flatten(), at);
        Self {
            area: 0.5 * normal.length(),
            front: winding(middle + off),
            back: winding(middle - off),
        }
    }

    pub fn is_inward(&self) -> bool {
        self.area > 0.0 && self.front < 0 && self.back >= 0
    }

    pub fn is_outward(&self) -> bool {
        self.area > 0.0 && self.front >= 0 && self.back > 0
    }
}

/// What looks inward of a mixed surface.
#[derive(Debug, Default)]
pub(super) struct Wound {
    pub faces: Vec<Face>,
    /// The holes through which one may look, by their places among the surface's caps.
    open: Vec<usize>,
    /// Next to no light gets in by them.
    is_bore: bool,
    /// Most of its faces lie at holes: a length of a pipe or of a corridor, which others go on from.
    is_frame: bool,
}

impl Surface {
    /// True where its faces need be asked one by one whether they look inward.
    pub fn is_mixed(&self) -> bool {
        self.tangled || !self.caps.is_empty()
    }

    /// True where some of its faces look the other way than most of them in the file.
    pub fn is_uneven(&self) -> bool {
        self.faces.iter().any(|face| face.turned)
    }
}

/// A pane in 64-bit numbers.
fn in_full(pane: &[[f32; 3]; 3]) -> [DVec3; 3] {
    pane.map(|corner| DVec3::from(corner.map(f64::from)))
}

impl Solids {
    /// The faces of a mixed surface that look inward, where one is not meant to look through any of its holes.
    pub(super) fn wound(&self, shape: u32, surface: u32) -> &[Face] {
        let wound = self.wound_but_for_holes(shape, surface);
        match wound.open.is_empty() && !wound.is_frame {
            true => &wound.faces,
            false => &[],
        }
    }

    /// The faces of a mixed surface that look inward, and the holes through which one may look.
    pub(super) fn wound_but_for_holes(&self, shape: u32, surface: u32) -> &Wound {
        let found = &self.shapes[shape as usize].wound[surface as usize];
        found.get_or_init(|| self.find_wound(shape, surface).unwrap_or_default())
    }

    /// True where faces of a mixed surface look inward and what stands around it stops each hole through which one
    /// would look, as snow lies on a branch; or where next to no light gets in, one looks from no room into it and the
    /// surface stands free, as a post.
    pub(super) fn is_wound(&self, of: &Placed, all: &PlacedTree) -> bool {
        let wound = self.wound_but_for_holes(of.shape, of.key.1);
        let mouth = |hole: &usize| Mouth::of(of, &of.surface.caps[*hole]);
        let is_stopped = |hole: &usize| self.is_stopped(of, &mouth(hole), all);
        let is_portal = |hole: &usize| self.is_portal(of, &mouth(hole), all);
        let is_post =
            || wound.is_bore && !wound.open.iter().any(is_portal) && self.stands_free(of, all);
        let stopped = || !wound.is_frame && wound.open.iter().all(is_stopped);
        !wound.faces.is_empty() && (stopped() || is_post())
    }

    /// True where one who looks out of a surface that looks inward, straight through its faces and as far as it is
    /// large, hardly ever sees a back of what does not look inward too.
    fn stands_free(&self, of: &Placed, all: &PlacedTree) -> bool {
        let clear = Covers::least(of.low.abs().max(of.high.abs()).max_element());
        let sense = of.transform.matrix3.determinant().signum();
        let faces: Vec<[DVec3; 3]> = of.faces(&self.scene).collect();
        // Parts of one body may be wound the wrong way together.
        let looks_inward = |of: &Placed| {
            let wound = || self.wound_but_for_holes(of.shape, of.key.1);
            of.surface.volume < 0.0 || !wound().faces.is_empty()
        };
        let sees_back = |[a, b, c]: &[DVec3; 3]| {
            let outward = -sense * (*b - *a).cross(*c - *a).normalize_or_zero();
            let at = (*a + *b + *c) / 3.0 + clear * outward;
            let met = self.nearest_met(of.key, all, at, at + of.size() * outward);
            met.is_some_and(|met| !met.is_front && !looks_inward(all.placed[met.place]))
        };
        let backs = faces.iter().filter(|face| sees_back(face)).count();
        backs as f64 <= BACKS * faces.len() as f64
    }

    /// True where other surfaces stand in nearly all of a hole: close to it, or on both sides of it, as the skin of
    /// what is stuck in it.
    fn is_stopped(&self, of: &Placed, mouth: &Mouth, all: &PlacedTree) -> bool {
        let Mouth { outward, width, .. } = *mouth;
        let is_met = |at: DVec3, from: f64, to: f64| {
            let ends = [from, to].map(|step| at + step * width * outward);
            self.nearest_met(of.key, all, ends[0], ends[1]).is_some()
        };
        // What lies behind its own faces stops no hole: a sheet that is hardly bent is next to all of its hole.
        let tree = self.tree_of(of.shape, of.key.1);
        let deep = |at: DVec3, most: f64| {
            let ends = [at, at - most * width * outward].map(|at| of.inverse.transform_point3(at));
            let own = tree.nearest(&self.scene, ends[0], ends[1]);
            own.map_or(most, |(share, _)| share * most)
        };
        let is_stopped = |at: DVec3| {
            let within = || is_met(at, 0.0, -deep(at, 1.0));
            is_met(at, -deep(at, STOP), STOP) || is_met(at, 0.0, 1.0) && within()
        };
        mouth.share(is_stopped) >= 1.0 - HOLE
    }

    fn find_wound(&self, shape: u32, number: u32) -> Option<Wound> {
        let surface = &self.shapes[shape as usize].surfaces[number as usize];
        if !surface.is_mixed() || !self.is_drawn_from_both_sides(surface) {
            return None;
        }
        let place = |face: Face| corners(&self.scene, face).map(|corner| corner.as_dvec3());
        let sides = |face: Face| self.sides(shape, number, place(face));
        let faces = &surface.faces;
        let step = faces.len().div_ceil(FIRST);
        if step > 1 {
            let mut first = faces.iter().step_by(step);
            first.find(|&&face| sides(face).is_inward())?;
        }
        let asked: Vec<Sides> = faces.par_iter().map(|&face| sides(face)).collect();
        let area = |of: &dyn Fn(&Sides) -> bool| -> f64 {
            let found = asked.iter().filter(|sides| of(sides));
            found.map(|sides| sides.area).sum()
        };
        let [inward, outward] = [area(&Sides::is_inward), area(&Sides::is_outward)];
        let all = area(&|_| true);
        if inward == 0.0 {
            return None;
        }
        let is_whole = all - inward - outward <= ODD * all && inward >= MOST * all;
        if !surface.caps.is_empty() && !is_whole {
            return None;
        }
        // A face may run on from where it looks inward to where it does not.
        let parts = parts(faces.len());
        let tree = (&*self.scene, surface, self.tree_of(shape, number));
        let is_outward = |face: Face| {
            let at = |weights| Sides::of(tree, place(face), weights);
            corners_too(parts).any(|weights| at(weights).is_outward())
        };
        let found = faces.iter().zip(&asked);
        let found = found.filter(|(face, sides)| sides.is_inward() && !is_outward(**face));
        let (open, is_bore) = self.open_holes(shape, number, [inward, all]);
        let edges = |cap: &Vec<_>| if cap.len() == 1 { 3 } else { cap.len() };
        let edges: usize = surface.caps.iter().map(edges).sum();
        Some(Wound {
            faces: found.map(|(&face, _)| face).collect(),
            is_frame: 2 * edges > faces.len(),
            is_bore,
            open,
        })
    }

    /// The holes through which one may look, of a surface of which so much looks inward, of so much in all; and whether
    /// it is a bore by them, into which next to no light gets.
    fn open_holes(&self, shape: u32, number: u32, [inward, all]: [f64; 2]) -> (Vec<usize>, bool) {
        let surface = &self.shapes[shape as usize].surfaces[number as usize];
        let (mut missing, mut holes, mut mouths) = (0.0, 0.0, 0.0);
        let mut is_bore = true;
        let mut large = Vec::new();
        for (hole_number, cap) in surface.caps.iter().enumerate() {
            let open = |pane: &[[f32; 3]; 3]| {
                let pane = in_full(pane);
                let sides = self.sides(shape, number, pane);
                let [a, b, c] = pane;
                let normal = 0.5 * (b - a).cross(c - a);
                sides.is_inward().then_some(normal)
            };
            let normals: Vec<DVec3> = cap.iter().filter_map(open).collect();
            let area: f64 = normals.iter().map(|normal| normal.length()).sum();
            let hole: DVec3 = normals.iter().sum();
            let along = hole.normalize_or_zero();
            let shadow = |face: &Face| {
                let [a, b, c] = corners(&self.scene, *face).map(|corner| corner.as_dvec3());
                0.25 * (b - a).cross(c - a).dot(along).abs()
            };
            // Only a hole through which one looks is asked for its shadow.
            let shadow: f64 = match area == 0.0 {
                true => continue,
                false => surface.faces.iter().map(shadow).sum(),
            };
            let is_little = match cap.len() {
                1 => hole.length() <= TRIANGLE * shadow,
                _ => hole.length() <= (HOLE * shadow).min(WINDOW * inward),
            };
            if !is_little {
                is_bore &= area <= MOUTH * all && hole.length() >= MOST * shadow;
                mouths += area;
            }
            match cap.len() {
                _ if !is_little => large.push(hole_number),
                1 => missing += area,
                _ => holes += area,
            }
        }
        // Together they are not little.
        if missing > TRIANGLES * inward || holes > HOLES * inward {
            return ((0..surface.caps.len()).collect(), false);
        }
        (large, is_bore && mouths <= MOUTHS * all)
    }

    fn sides(&self, shape: u32, number: u32, triangle: [DVec3; 3]) -> Sides {
        let surface = &self.shapes[shape as usize].surfaces[number as usize];
        let tree = self.tree_of(shape, number);
        Sides::of((&self.scene, surface, tree), triangle, MIDDLE)
    }

    /// How often a mixed surface winds around a point of the world.
    pub(super) fn winding_about(&self, placed: &Placed, point: DVec3) -> i32 {
        let tree = self.tree_of(placed.shape, placed.key.1);
        let caps = placed.surface.caps.iter().flatten();
        tree.winding(&self.scene, caps, placed.inverse.transform_point3(point))
    }

    /// True where a surface that looks inward, or is to do so, is a room or a cavity: something lies for the most part
    /// in its air, and no more than that stands on it outside of all rooms, or it lies in a solid. `winding`: the sign
    /// of its winding number in its air.
    pub(super) fn is_lived_in(&self, of: &Placed, winding: i32, all: &PlacedTree) -> bool {
        let is_cavity = |other: &Placed| {
            let is_solid = other.key != of.key && other.surface.volume > 0.0;
            is_solid && self.is_deep_within(other, of)
        };
        if all.any(of.low, of.high, is_cavity) {
            return true;
        }
        let is_in = |at| winding * self.winding_about(of, at) > 0;
        let [within, beside] = self.standing(of, all, is_in);
        within > STANDS * of.side() && within >= beside
    }

    /// True where a closed body holds another surface, and not only some of it.
    pub(super) fn is_deep_within(&self, outer: &Placed, inner: &Placed) -> bool {
        let in_outer = |at: DVec3| {
            let tree = self.tree_of(outer.shape, outer.key.1);
            let local = outer.inverse.transform_point3(at);
            let winding = tree.winding(&self.scene, std::iter::empty(), local);
            f64::from(winding) * outer.surface.volume > 0.0
        };
        let in_box = outer.low.cmple(inner.low).all() && outer.high.cmpge(inner.high).all();
        in_box && 8 * inner.count(&self.scene, LOOKS, in_outer) >= 7 * LOOKS
    }

    /// True where all faces are drawn from both sides and none shines.
    pub(super) fn is_drawn_from_both_sides(&self, surface: &Surface) -> bool {
        surface.faces.iter().all(|face| {
            let mesh = &self.scene.meshes[face.mesh as usize];
            let material = &self.scene.materials[mesh.material as usize];
            material.double_sided && material.emission == glam::Vec3::ZERO
        })
    }
}
