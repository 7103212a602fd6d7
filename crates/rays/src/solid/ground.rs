//! Grounds: open surfaces that other bodies are sunk in, such as a terrain or the plane that a scene stands on.
//!
//! An open surface has no inside. But where all its faces look to one side, what stands in it is hidden behind it, and
//! sees under it what nobody is to see. Such sheets may go on in one another, as the tiles of a floor do, and are one
//! ground then. A surface is *rooted* in a ground where
//!
//! * it crosses the ground, and stands out in front of it at least as far as it reaches behind it (a closed body a
//!   quarter as far), along the mean normals of its sheets;
//! * nothing comes near its part behind that does not cross the ground too or stand on it. So no column is buried by
//!   the floor of the next storey.
//!
//! The part behind is buried, for this surface alone. But a ground that has something else behind it which does not
//! cross it, and is not small beside it, is none: people stand under an awning, and see what it is fastened to.

use super::placed::{Among, CROSSES, NEAR, Placed, SMALL, Sheet, sheets};
use super::topology::corners;
use super::tree::SurfaceTree;
use super::{Inside, Solids};
use glam::DVec3;
use rayon::prelude::*;
use scene::Scene;
use std::collections::{BTreeMap, BTreeSet};

/// Faces of a sheet from which one looks for what is behind it.
const LOOKS: usize = 64;
/// Where along an edge points are asked how they stand to a sheet.
const ALONG_EDGES: [f64; 3] = [0.23, 0.5, 0.77];
/// The cosine of the angle at which one sheet may go on where another ends.
const ALONG: f64 = 0.999;

/// Pairs of a sheet and a surface near it that are looked at before what they say is taken together.
const AT_ONCE: usize = 1 << 14;

/// A closed body stands out in front of a ground at least this share of what it reaches behind it. A stone may be sunk
/// by four fifths; what only pokes through a wall belongs to the other side.
const CLOSED_OUT: f64 = 0.25;

/// Placement and number of a surface.
type Key = (u32, u32);

/// Where a surface stands to a sheet.
struct Stand {
    /// How far it goes in front and behind, in lengths of the mesh's space; what is less than `least` only touches.
    front: f64,
    behind: f64,
    least: f64,
    /// Some of it is before or behind the sheet, not beside it.
    meets: bool,
    /// The box of its points behind, in the world.
    low: DVec3,
    high: DVec3,
}

impl Stand {
    fn of(scene: &Scene, sheet: &Placed, tree: &SurfaceTree, other: &Placed) -> Self {
        let inverse = sheet.inverse;
        let size = inverse.transform_vector3(other.high - other.low).length();
        let mut stand = Self {
            front: 0.0,
            behind: 0.0,
            least: CROSSES * size,
            meets: false,
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        let Some(front) = sheet.surface.front else {
            return stand;
        };
        // Edges of panels may run along one another, where corners are beside a sheet or over its border, and so may
        // middles be where panels join: so other points on the edges too.
        let points = other.faces(scene).flat_map(|[a, b, c]| {
            let edges = [(a, b), (b, c), (c, a)].into_iter();
            let along = edges.flat_map(|(from, to)| ALONG_EDGES.map(|share| from.lerp(to, share)));
            [a, b, c, (a + b + c) / 3.0].into_iter().chain(along)
        });
        for point in points {
            let local = inverse.transform_point3(point);
            // A wall that only stands on a floor does not cross it: what ends at the sheet is beside it.
            let Some(height) = tree.height_over(scene, local, front, true) else {
                continue;
            };
            stand.meets = true;
            stand.front = stand.front.max(height);
            stand.behind = stand.behind.max(-height);
            if height < 0.0 {
                (stand.low, stand.high) = (stand.low.min(point), stand.high.max(point));
            }
        }
        stand
    }

    fn crosses(&self) -> bool {
        self.front > self.least && self.behind > self.least
    }

    /// True for a surface that lies in the sheet.
    fn is_level(&self) -> bool {
        self.meets && self.front <= self.least && self.behind <= self.least
    }

    /// What both say of one surface before two sheets.
    fn with(&self, other: &Self) -> Self {
        Self {
            front: self.front.max(other.front),
            behind: self.behind.max(other.behind),
            least: self.least.max(other.least),
            meets: self.meets || other.meets,
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }
}

/// Sheets that go on in one another.
struct Ground {
    /// Their numbers, in order.
    sheets: Vec<usize>,
    /// The largest edge of the box about them.
    size: f64,
}

impl Solids {
    /// Finds the grounds of a scene and what is rooted in them, and makes bodies of both.
    pub(super) fn root(&mut self) {
        let found = self.rooted_in_grounds();
        for (sheet, rooted) in found {
            let mut members: Vec<u32> = rooted.into_iter().map(|key| self.body_of(key)).collect();
            members.sort_unstable();
            let sheet = self.body_of(sheet);
            self.widen(sheet, &members);
            self.bodies[sheet as usize].inside = Inside::Behind(members);
        }
    }

    /// True where some of a surface stands in front of a sheet.
    pub(super) fn stands_before(&self, sheet: &Placed, other: &Placed) -> bool {
        if sheet.surface.front.is_none() {
            return false;
        }
        let tree = self.tree_of(sheet.shape, sheet.key.1);
        let stand = Stand::of(&self.scene, sheet, tree, other);
        stand.front > stand.least
    }

    /// By sheet, what is rooted in it: placements and numbers of surfaces.
    fn rooted_in_grounds(&self) -> BTreeMap<Key, Vec<Key>> {
        let placed = self.placed_surfaces();
        let all = Among::of(placed.iter().collect());
        let sheets = sheets(&all);
        let grounds = self.grounds(&placed, &sheets);
        // The size of what a surface is part of.
        let mut sizes: Vec<f64> = placed.iter().map(Placed::size).collect();
        for ground in &grounds {
            let members = ground.sheets.iter();
            members.for_each(|&sheet| sizes[sheets[sheet].place] = ground.size);
        }
        let rooted = |ground: &Ground| self.rooted_in(ground, &placed, &all, &sheets, &sizes);
        let found = grounds.par_iter().flat_map_iter(rooted);
        found.collect::<Vec<_>>().into_iter().collect()
    }

    /// The sheets by grounds.
    fn grounds(&self, placed: &[Placed], sheets: &[Sheet]) -> Vec<Ground> {
        let number: BTreeMap<usize, usize> = (0..).zip(sheets).map(|(n, s)| (s.place, n)).collect();
        let mut parent: Vec<usize> = (0..sheets.len()).collect();
        fn root(parent: &mut [usize], mut at: usize) -> usize {
            while parent[at] != at {
                parent[at] = parent[parent[at]];
                at = parent[at];
            }
            at
        }
        let goes_on = |sheet: &Sheet| -> Vec<usize> {
            let of = &placed[sheet.place];
            let tree = self.tree_of(of.shape, of.key.1);
            let is_level = |other| Stand::of(&self.scene, of, tree, other).is_level();
            let is_one = |&(place, _): &(usize, usize)| {
                let other = &placed[place];
                is_near(of, other)
                    && looks_alike(of, other)
                    && (self.is_in_plane(of, other) || is_level(other))
            };
            let near = sheet.near.iter().map(|&other| other as usize);
            let known = near.filter_map(|other| Some((other, *number.get(&other)?)));
            known.filter(is_one).map(|(_, next)| next).collect()
        };
        let links: Vec<Vec<usize>> = sheets.par_iter().map(goes_on).collect();
        for (own, links) in links.into_iter().enumerate() {
            for next in links {
                let (a, b) = (root(&mut parent, own), root(&mut parent, next));
                parent[a.max(b)] = a.min(b);
            }
        }
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for own in 0..sheets.len() {
            groups.entry(root(&mut parent, own)).or_default().push(own);
        }
        let ground = |sheets_of: Vec<usize>| {
            let boxes = sheets_of.iter().map(|&n| &placed[sheets[n].place]);
            let (low, high) = boxes
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                    (low.min(p.low), high.max(p.high))
                });
            Ground {
                sheets: sheets_of,
                size: (high - low).max_element(),
            }
        };
        groups.into_values().map(ground).collect()
    }

    /// The sheets of a ground with what is rooted in each; none where it is no ground, or nothing is.
    ///
    /// * `sizes`: by the place in the list, the size of what a surface is part of.
    fn rooted_in(
        &self,
        ground: &Ground,
        placed: &[Placed],
        all: &Among,
        sheets: &[Sheet],
        sizes: &[f64],
    ) -> Vec<(Key, Vec<Key>)> {
        let members = || ground.sheets.iter().map(|&sheet| &sheets[sheet]);
        let own: BTreeSet<Key> = members().map(|sheet| placed[sheet.place].key).collect();
        let pairs = members().flat_map(|sheet| {
            let near = sheet.near.iter().map(|&other| other as usize);
            near.map(|other| (&placed[sheet.place], other))
        });
        let pairs: Vec<(&Placed, usize)> = pairs
            .filter(|(sheet, other)| {
                let other = &placed[*other];
                !own.contains(&other.key) && is_near(sheet, other)
            })
            .collect();
        let stand = |&(sheet, other): &(&Placed, usize)| {
            let tree = self.tree_of(sheet.shape, sheet.key.1);
            let stand = Stand::of(&self.scene, sheet, tree, &placed[other]);
            stand.meets.then_some((other, stand))
        };
        let mut stands: BTreeMap<usize, Stand> = BTreeMap::new();
        for some in pairs.chunks(AT_ONCE) {
            let found: Vec<(usize, Stand)> = some.par_iter().filter_map(stand).collect();
            for (other, stand) in found {
                let merged = match stands.get(&other) {
                    Some(known) => known.with(&stand),
                    None => stand,
                };
                stands.insert(other, merged);
            }
        }
        let crossing: BTreeSet<Key> = (stands.iter())
            .filter(|(_, stand)| stand.crosses())
            .map(|(&other, _)| placed[other].key)
            .collect();
        // What stands on the ground does not look at what is behind it.
        let before: BTreeSet<Key> = (stands.iter())
            .filter(|(_, stand)| stand.front > stand.least && stand.behind <= stand.least)
            .map(|(&other, _)| placed[other].key)
            .collect();
        let is_rooted = |other: &Placed, stand: &Stand| {
            let is_closed = other.surface.volume != 0.0;
            let out = if is_closed { CLOSED_OUT } else { 1.0 };
            if !stand.crosses() || stand.front < out * stand.behind {
                return false;
            }
            let slack = NEAR * (stand.high - stand.low).max_element();
            let (low, high) = (stand.low - slack, stand.high + slack);
            let lays_open = |near: &Placed| {
                let is_other = near.key != other.key && !own.contains(&near.key);
                is_other && !crossing.contains(&near.key) && !before.contains(&near.key)
            };
            !all.any(low, high, lays_open)
        };
        let rooted: BTreeSet<usize> = (stands.iter())
            .filter(|(other, stand)| is_rooted(&placed[**other], stand))
            .map(|(&other, _)| other)
            .collect();
        if rooted.is_empty() {
            return Vec::new();
        }
        let is_bare = |sheet: &Sheet| {
            let sheet = &placed[sheet.place];
            let (low, high) = behind(sheet);
            all.any_place(low, high, |place| {
                let other = &placed[place];
                !own.contains(&other.key)
                    && !crossing.contains(&other.key)
                    && sizes[place] >= SMALL * ground.size
                    && self.is_behind(sheet, other)
            })
        };
        if members().any(is_bare) {
            return Vec::new();
        }
        let of = |sheet: &Sheet| {
            let of = &placed[sheet.place];
            let near = sheet.near.iter().map(|&other| other as usize);
            let near = near.filter(|other| rooted.contains(other) && is_near(of, &placed[*other]));
            let mut keys: Vec<Key> = near.map(|other| placed[other].key).collect();
            keys.sort_unstable();
            (of.key, keys)
        };
        let each = members().map(of);
        each.filter(|(_, rooted)| !rooted.is_empty()).collect()
    }

    /// True where all of a surface lies in the plane of a flat sheet.
    fn is_in_plane(&self, sheet: &Placed, other: &Placed) -> bool {
        let least = CROSSES * (sheet.size() + other.size());
        let Some(normal) = facing(sheet) else {
            return false;
        };
        let Some(home) = sheet.corners(&self.scene).next() else {
            return false;
        };
        let mut corners = sheet.corners(&self.scene).chain(other.corners(&self.scene));
        corners.all(|corner| (corner - home).dot(normal).abs() <= least)
    }

    /// True where one looks from a sheet's faces, against their mean normal, at another surface.
    fn is_behind(&self, sheet: &Placed, other: &Placed) -> bool {
        let Some(back) = backward(sheet) else {
            return false;
        };
        let inverse = other.transform.inverse();
        let direction = inverse.transform_vector3(back);
        let tree = self.tree_of(other.shape, other.key.1);
        let step = sheet.surface.faces.len().div_ceil(LOOKS);
        let mut faces = sheet.surface.faces.iter().step_by(step);
        faces.any(|&face| {
            let [a, b, c] = corners(&self.scene, face).map(|corner| corner.as_dvec3());
            let middle = sheet.transform.transform_point3((a + b + c) / 3.0);
            tree.is_ahead(&self.scene, inverse.transform_point3(middle), direction)
        })
    }
}

/// True where a surface's box meets that of a sheet, or nearly does.
fn is_near(sheet: &Placed, other: &Placed) -> bool {
    let slack = NEAR * sheet.size();
    other.meets(sheet.low - slack, sheet.high + slack)
}

/// Where the front of a sheet looks.
fn facing(sheet: &Placed) -> Option<DVec3> {
    let normal = sheet.inverse.matrix3.transpose() * sheet.surface.front?;
    normal.try_normalize()
}

fn looks_alike(a: &Placed, b: &Placed) -> bool {
    facing(a).is_some_and(|a| facing(b).is_some_and(|b| a.dot(b) > ALONG))
}

/// The direction to which the back of a sheet looks.
fn backward(sheet: &Placed) -> Option<DVec3> {
    let front = sheet.surface.front?;
    Some(-sheet.transform.transform_vector3(front))
}

/// The box, without an end to some sides, of all that lies behind a sheet.
fn behind(sheet: &Placed) -> (DVec3, DVec3) {
    let (mut low, mut high) = (sheet.low, sheet.high);
    let back = backward(sheet).unwrap_or_default();
    for axis in 0..3 {
        if back[axis] > 0.0 {
            high[axis] = f64::INFINITY;
        }
        if back[axis] < 0.0 {
            low[axis] = f64::NEG_INFINITY;
        }
    }
    (low, high)
}
