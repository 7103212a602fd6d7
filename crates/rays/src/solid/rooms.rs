//! Surfaces whose faces look inward: cavities of solids, rooms, and what stands through the floors and walls of rooms.
//!
//! Nobody is to see the outside of a room that is modelled as one surface and seen from within. So what crosses its
//! surface is *rooted* in it, and buried outside of it and of every other room. A room may have openings with flat
//! borders, such as windows: what lies beyond the plane of one of them may be seen through it, and is not buried unless
//! one would look all but along the plane. A straight line that has left through an opening stays beyond its plane, so
//! nothing else can be seen from within.
//!
//! A room buries nothing where something may look at it from outside, or was made to be looked at there:
//!
//! * a surface at least half as large as the room, by the largest sides of their boxes, lies for the most part outside
//!   of all rooms: a street, a facade, another building. It does not look at a part outside that lies wholly behind it,
//!   such as the hill over a cave, nor at one from which it is parted by the plane of an opening, as the ground before
//!   the mouth of a cave: from there one looks into the room;
//! * what does not cross its surface, and is not in a room, comes near the part outside.
//!
//! A dome around a scene is a room, and all of the scene is within it. What looks inward and has more standing on it
//! than in it is none, nor is what is full.

use super::opening::Opening;
use super::placed::{CROSSES, NEAR, Placed, PlacedTree, SMALL, box_corners};
use super::topology::{Surface, corners};
use super::wound::LOOKS;
use super::{Inside, NUDGE, Solids};
use glam::DVec3;
use rayon::prelude::*;
use scene::{Scene, around};
use std::collections::{BTreeMap, HashMap, HashSet};

/// What encloses more than this of a room, by volume, leaves no room to be in.
const FULL: f64 = 0.5;

/// Placement and number of a surface.
type Key = (u32, u32);

impl Solids {
    /// Tells cavities and rooms from solids.
    pub(super) fn classify(&mut self) {
        let volume = |body: u32| self.surface(&self.bodies[body as usize]).volume;
        let inward: Vec<u32> = (0..self.bodies())
            .filter(|&body| volume(body) < 0.0)
            .collect();
        if inward.is_empty() {
            return;
        }
        let placed = self.placed_surfaces();
        let body_of = |placed: &Placed| self.placements.get(&placed.key).copied();
        let surface_of: HashMap<u32, &Placed> = (placed.iter())
            .filter_map(|placed| Some((body_of(placed)?, placed)))
            .collect();
        let within = |body: u32, placed: &Placed| {
            let outer = surface_of.get(&body);
            outer.is_some_and(|outer| outer.key != placed.key && self.is_within(outer, placed))
        };
        let outward = (0..self.bodies()).filter(|&body| volume(body) > 0.0);
        let outward = self.boxes_of(outward);
        let all = PlacedTree::of(placed.iter().collect());
        let found: Vec<(u32, Inside)> = inward
            .into_par_iter()
            .map(|body| {
                let is_cavity = surface_of.get(&body).is_some_and(|own| {
                    // What holds its box holds a corner of it.
                    outward.any(own.low, own.low, |outer| {
                        let outer = surface_of.get(&outer);
                        outer.is_some_and(|outer| self.is_deep_within(outer, own))
                    })
                });
                let (low, high) = (
                    self.bodies[body as usize].low,
                    self.bodies[body as usize].high,
                );
                let inside = match is_cavity {
                    true => Inside::Cavity,
                    false if all.any(low, high, |other| within(body, other)) => Inside::Room,
                    false => Inside::Solid,
                };
                (body, inside)
            })
            .collect();
        for (body, inside) in found {
            self.bodies[body as usize].inside = inside;
        }
        for body in self.lived_in() {
            self.bodies[body as usize].inside = Inside::Room;
        }
        for body in self.built_on() {
            self.bodies[body as usize].inside = Inside::Solid;
        }
    }

    /// Rooms that are drawn from both sides and have more standing on them, outside of all rooms, than in them: the
    /// ground below a house with a cellar wall in it, a roof that hides the end of a beam. What is larger than they
    /// are, such as the street before a room, does not stand on them. And those that are full, such as a collision body
    /// around what it stands for: nobody is in them.
    fn built_on(&self) -> Vec<u32> {
        let placed = self.placed_surfaces();
        let all = PlacedTree::of(placed.iter().collect());
        let rooms = placed.par_iter().filter(|of| self.is_closed_room(of));
        let is_built_on = |room: &&Placed| {
            let is_in = |at: DVec3| self.is_in(room, at);
            let [within, beside] = self.standing(room, &all, is_in);
            let others = all.meeting(room.low, room.high).into_iter();
            let others = others.map(|place| all.placed[place]);
            let fills = |of: &&Placed| {
                of.key != room.key && 2 * of.count(&self.scene, LOOKS, is_in) > LOOKS
            };
            let filled: f64 = others.filter(fills).map(Placed::volume).sum();
            beside > within || filled > FULL * room.volume()
        };
        let found = rooms
            .filter(|room| self.is_drawn_from_both_sides(room.surface))
            .filter(is_built_on);
        found.map(|room| self.placements[&room.key]).collect()
    }

    /// The sides of all others that lie for the most part in a surface, and of those near it that lie neither there nor
    /// in a closed room. What is larger is left out, and what looks inward itself: it may be a room too.
    pub(super) fn standing(
        &self,
        of: &Placed,
        all: &PlacedTree,
        is_in: impl Fn(DVec3) -> bool,
    ) -> [f64; 2] {
        let holds = |room: &Placed, at| self.is_closed_room(room) && self.is_in(room, at);
        let is_out = |at: DVec3| !is_in(at) && !all.any(at, at, |room| holds(room, at));
        let slack = NEAR * of.size();
        let near = all.meeting(of.low - slack, of.high + slack).into_iter();
        let near = near.map(|place| all.placed[place]);
        let others = near.filter(|other| other.key != of.key && other.side() <= of.side());
        let [mut within, mut beside] = [0.0, 0.0];
        let looks_inward = |other: &Placed| {
            self.is_closed_room(other) || !self.wound(other.shape, other.key.1).is_empty()
        };
        for other in others.filter(|other| !looks_inward(other)) {
            if 2 * other.count(&self.scene, LOOKS, &is_in) > LOOKS {
                within += other.side();
            } else if 2 * other.count(&self.scene, LOOKS, is_out) > LOOKS {
                beside += other.side();
            }
        }
        [within, beside]
    }

    /// Bodies that look inward, though nothing lies wholly in them, and are rooms all the same: some surface lies for
    /// the most part in one, and none that is not small lies for the most part outside of them and of rooms.
    fn lived_in(&self) -> Vec<u32> {
        let placed = self.placed_surfaces();
        let is_inward = |placed: &&Placed| {
            let body = self.placements.get(&placed.key);
            let is_solid = |&body: &u32| self.bodies[body as usize].inside == Inside::Solid;
            placed.surface.volume < 0.0 && body.is_some_and(is_solid)
        };
        let (inward, rest): (Vec<&Placed>, Vec<&Placed>) = placed.iter().partition(is_inward);
        let is_mostly = |placed: &Placed, holds: &(dyn Fn(DVec3) -> bool + Sync)| {
            2 * placed.count(&self.scene, LOOKS, holds) > LOOKS
        };
        let rest = PlacedTree::of(rest);
        let lived_in = |room: &&&Placed| {
            let is_in = |at| self.is_in(room, at);
            rest.any(room.low, room.high, |other| is_mostly(other, &is_in))
        };
        let lived_in: Vec<&Placed> = inward.par_iter().filter(lived_in).copied().collect();
        let least = lived_in.iter().map(|room| room.side());
        let least = SMALL * least.fold(f64::INFINITY, f64::min);
        let rooms = placed.iter().filter(|placed| self.is_room(placed));
        let rooms = PlacedTree::of(rooms.chain(lived_in.iter().copied()).collect());
        let outside = |at| !rooms.any(at, at, |room| self.is_in(room, at));
        let keys: HashSet<Key> = rooms.placed.iter().map(|room| room.key).collect();
        let is_room = |placed: &Placed| keys.contains(&placed.key);
        let around = (placed.par_iter())
            .filter(|placed| placed.side() >= least && !is_room(placed))
            .filter(|placed| is_mostly(placed, &outside))
            .map(|placed| placed.side())
            .reduce(|| 0.0, f64::max);
        let alone = lived_in.iter().filter(|room| around < SMALL * room.side());
        alone.map(|room| self.placements[&room.key]).collect()
    }

    /// Finds what is rooted in rooms, and makes bodies of both.
    pub(super) fn root_in_rooms(&mut self) {
        let (rooms, found) = self.rooted_in_rooms();
        for (room, rooted) in found {
            let mut rooted: Vec<u32> = rooted.into_iter().map(|key| self.body_of(key)).collect();
            rooted.sort_unstable();
            let room = self.body_of(room);
            self.widen(room, &rooted);
            self.bodies[room as usize].inside = Inside::Around(rooted);
        }
        self.rooms = rooms.into_iter().map(|key| self.body_of(key)).collect();
        for &room in &self.rooms {
            let inside = &mut self.bodies[room as usize].inside;
            if *inside == Inside::Nothing {
                *inside = Inside::Room;
            }
        }
    }

    /// All rooms, and by room what is rooted in it; no rooms where nothing is.
    fn rooted_in_rooms(&self) -> (Vec<Key>, BTreeMap<Key, Vec<Key>>) {
        let placed = self.placed_surfaces();
        let (rooms, rest): (Vec<&Placed>, Vec<&Placed>) =
            placed.iter().partition(|placed| self.is_room(placed));
        let [rooms, rest] = [rooms, rest].map(PlacedTree::of);
        let outside = |point: DVec3| !rooms.any(point, point, |room| self.is_in(room, point));
        if rooms.placed.is_empty() {
            return Default::default();
        }
        // What is large and outside.
        let least = rooms.placed.iter().map(|room| room.side());
        let least = SMALL * least.fold(f64::INFINITY, f64::min);
        let around: Vec<&Placed> = (rest.placed.par_iter())
            .filter(|placed| placed.side() >= least)
            .filter(|placed| 2 * placed.count(&self.scene, LOOKS, outside) > LOOKS)
            .copied()
            .collect();
        let views: Vec<Vec<View>> = (rooms.placed.par_iter())
            .map(|room| self.views(room, &around))
            .collect();
        let buries = |views: &[View]| views.iter().all(View::may_be_parted);
        let may_bury = (0..rooms.placed.len()).filter(|&room| buries(&views[room]));
        let may_bury = PlacedTree::of(may_bury.map(|room| rooms.placed[room]).collect());
        // How each surface that comes near stands to the rooms.
        let stands: BTreeMap<Key, Stand> = (rest.placed.par_iter())
            .filter(|placed| may_bury.any(placed.low, placed.high, |_| true))
            .map(|placed| (placed.key, self.stand(placed, &rooms, &views)))
            .collect();
        let mut found: BTreeMap<Key, Vec<Key>> = BTreeMap::new();
        for (key, stand) in &stands {
            let Some(room) = stand.room else {
                continue;
            };
            let slack = NEAR * (stand.high - stand.low).max_element();
            let (low, high) = (stand.low - slack, stand.high + slack);
            let lays_open = |other: &Placed| {
                let lies_out = |stand: &Stand| stand.is_out && !stand.is_in;
                let is_asked = || views[room].iter().any(|view| view.around.key == other.key);
                other.key != *key && stands.get(&other.key).is_none_or(lies_out) && !is_asked()
            };
            if !rest.any(low, high, lays_open) {
                let of = found.entry(rooms.placed[room].key);
                of.or_default().push(*key);
            }
        }
        let keys = rooms.placed.iter().map(|room| room.key);
        let rooms = keys.filter(|_| !found.is_empty()).collect();
        (rooms, found)
    }

    fn is_room(&self, placed: &Placed) -> bool {
        placed.surface.hollow < 0.0 || self.is_closed_room(placed)
    }

    fn is_closed_room(&self, placed: &Placed) -> bool {
        let body = self.placements.get(&placed.key);
        body.is_some_and(|&body| self.bodies[body as usize].inside == Inside::Room)
    }

    /// True where a point of the world lies in a room.
    fn is_in(&self, room: &Placed, point: DVec3) -> bool {
        room.meets(point, point) && self.winding_of(room, point) < 0
    }

    /// True where a surface lies wholly in one that is closed or whose openings are filled.
    pub(super) fn is_within(&self, outer: &Placed, inner: &Placed) -> bool {
        let content = outer.surface.content();
        let holds = |at: &DVec3| {
            let winding = self.winding_of(outer, inner.transform.transform_point3(*at));
            f64::from(winding) * content > 0.0
        };
        let in_box = outer.low.cmple(inner.low).all() && outer.high.cmpge(inner.high).all();
        in_box
            && probes(&self.scene, inner.surface)
                .iter()
                .filter(|at| holds(at))
                .count()
                >= 3
    }

    fn winding_of(&self, room: &Placed, point: DVec3) -> i32 {
        let panes = room.surface.openings.iter().flat_map(|o| &o.panes);
        let tree = self.tree_of(room.shape, room.key.1);
        tree.winding(&self.scene, panes, room.inverse.transform_point3(point))
    }

    /// What of some surfaces is large beside a room.
    fn views<'a>(&self, room: &Placed<'a>, around: &[&'a Placed<'a>]) -> Vec<View<'a>> {
        let is_large = |of: &&&Placed| of.side() >= SMALL * room.side();
        let large = around.iter().filter(is_large).map(|&around| {
            let is_beyond = |opening: &&Opening| {
                let mut corners = around.corners(&self.scene);
                let at = |corner| room.inverse.transform_point3(corner);
                corners.all(|corner| opening.is_beyond(at(corner)) != Some(false))
            };
            let beyond = room.surface.openings.iter().filter(is_beyond).collect();
            View { around, beyond }
        });
        large.collect()
    }

    /// True where a surface may look at one of some points outside of a room.
    fn looks_at(&self, view: &View, room: &Placed, points: &[DVec3]) -> bool {
        let is_within = |opening: &&Opening| {
            let at = |point: &DVec3| room.inverse.transform_point3(*point);
            (points.iter()).all(|point| opening.is_beyond(at(point)) != Some(true))
        };
        let of = view.around;
        let is_behind = |front: DVec3| {
            let tree = self.tree_of(of.shape, of.key.1);
            let at = |point: &DVec3| of.inverse.transform_point3(*point);
            let height = |point| tree.height_over(&self.scene, at(point), front, true);
            (points.iter()).all(|point| height(point).is_some_and(|height| height < 0.0))
        };
        !view.beyond.iter().any(is_within) && !of.surface.front.is_some_and(is_behind)
    }

    fn stand(&self, placed: &Placed, rooms: &PlacedTree, views: &[Vec<View>]) -> Stand {
        let reach = placed.low.abs().max(placed.high.abs()).max_element();
        let least = (CROSSES * placed.size()).max(2.0 * NUDGE * reach);
        let near = rooms.meeting(placed.low, placed.high);
        let rooms = &rooms.placed;
        let room_at = |point| {
            near.iter()
                .copied()
                .find(|&room| self.is_in(rooms[room], point))
        };
        // A point may lie on a surface: what holds holds about it too.
        let about = |point: DVec3| {
            DVec3::AXES
                .into_iter()
                .flat_map(move |axis| [point - axis * least, point + axis * least])
        };
        let mut stand = Stand {
            room: None,
            is_in: false,
            is_out: false,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        let (mut within, mut out) = (Vec::new(), Vec::new());
        let mut hides = false;
        let is_closed = placed.surface.volume != 0.0;
        let mut touches = false;
        let is_at_wall = |point: DVec3| {
            near.iter().any(|&room| {
                let (of, inverse) = (rooms[room], rooms[room].inverse);
                let ends = about(point).map(|p| inverse.transform_point3(p));
                let (low, high) = around(ends);
                let tree = self.tree_of(of.shape, of.key.1);
                tree.meets(&self.scene, low, high)
            })
        };
        let mut stand_at = |point: DVec3| match room_at(point) {
            Some(room) if within.contains(&room) => (),
            Some(room) => {
                if about(point).all(|point| self.is_in(rooms[room], point)) {
                    within.push(room);
                }
            }
            None => {
                let is_clear = || about(point).all(|point| room_at(point).is_none());
                hides = hides || is_clear();
                (stand.low, stand.high) = (stand.low.min(point), stand.high.max(point));
                out.push(point);
            }
        };
        let mut ways = Vec::new();
        let mut points = Vec::new();
        for [a, b, c] in placed.faces(&self.scene) {
            points.clear();
            points.extend([a, b, c, (a + b + c) / 3.0]);
            // The surface of a room cuts edges into parts that lie in it and parts that do not.
            for (from, to) in [(a, b), (b, c), (c, a)] {
                ways.clear();
                ways.extend([0.0, 1.0]);
                for &room in &near {
                    let (of, inverse) = (rooms[room], rooms[room].inverse);
                    let [start, end] = [from, to].map(|p| inverse.transform_point3(p));
                    let tree = self.tree_of(of.shape, of.key.1);
                    tree.crossings(&self.scene, start, end, &mut ways);
                }
                ways.sort_unstable_by(f64::total_cmp);
                let middles = ways.windows(2).map(|way| 0.5 * (way[0] + way[1]));
                points.extend(middles.map(|middle| from.lerp(to, middle)));
            }
            points.iter().for_each(|&point| stand_at(point));
            touches = touches || is_closed && points.iter().any(|&point| is_at_wall(point));
        }
        within.sort_unstable();
        (stand.is_in, stand.is_out) = (!within.is_empty(), hides);
        // What is seen through the openings of several rooms hangs on all of them.
        let has_openings = |room: &&usize| !rooms[**room].surface.openings.is_empty();
        let open: Vec<usize> = within.iter().filter(has_openings).copied().collect();
        let room = match open[..] {
            [] => within.first().copied(),
            [room] => Some(room),
            _ => None,
        };
        // A body that only stands on a floor has a side there that nobody sees.
        if !hides {
            out.extend(box_corners(placed.low, placed.high));
        }
        stand.room = room.filter(|&room| {
            let looks_at = |view: &View| self.looks_at(view, rooms[room], &out);
            (hides || touches) && !views[room].iter().any(looks_at)
        });
        stand
    }
}

/// A large surface outside of a room.
struct View<'a> {
    around: &'a Placed<'a>,
    /// The openings of the room that all of it lies beyond.
    beyond: Vec<&'a Opening>,
}

impl View<'_> {
    /// True where something outside of the room may be hidden from it.
    fn may_be_parted(&self) -> bool {
        !self.beyond.is_empty() || self.around.surface.front.is_some()
    }
}

/// How a surface stands to the rooms of a scene.
struct Stand {
    /// The room that may bury what is outside.
    room: Option<usize>,
    /// Something of it lies in a room, and something outside of all.
    is_in: bool,
    is_out: bool,
    /// The box of what is outside.
    low: DVec3,
    high: DVec3,
}

/// Centres of five faces spread over a surface.
fn probes(scene: &Scene, surface: &Surface) -> [DVec3; 5] {
    [0, 1, 2, 3, 4].map(|k: usize| {
        let last = surface.faces.len() - 1;
        let [a, b, c] = corners(scene, surface.faces[k * last / 4]).map(|p| p.as_dvec3());
        (a + b + c) / 3.0
    })
}
