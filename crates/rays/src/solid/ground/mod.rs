//! Grounds: open surfaces that other bodies are sunk in, such as a terrain or the plane that a scene stands on.
//!
//! An open surface has no inside. But where all its faces look to one side, what stands in it is hidden behind it, and
//! sees under it what nobody is to see. Such sheets may go on in one another, as the tiles of a floor do, and are one
//! ground then. A surface is *rooted* in a ground where
//!
//! * it crosses the ground, and stands out in front of it farther than it reaches behind it (a closed body a quarter as
//!   far, and one that only stands on the ground is hidden where they touch), along the mean normals of its sheets, and
//!   reaches no farther along the ground than that does: a house stands around its ceiling, and not in it;
//! * or it is a sheet that looks as the ground does, as land and sea do, and stands out as little as it likes: who sees
//!   the front of one sees that of the other. But where the ground ends over it, as a bridge does over its valley, one
//!   looks in between, and where a large sheet beside them looks elsewhere one may look from there;
//! * and, but for such sheets, nothing comes near its part behind that does not cross the ground too or stand on it and
//!   is not small beside that part. So no column is buried by the floor of the next storey, and a fish lays no shore
//!   open.
//!
//! A sheet that is not rooted only since the ground ends over it is *cut*: one may look at its part behind, but a texel
//! through which the ground goes is of the part before it, or the sea had a dark rim along its shore.
//!
//! The part behind is buried, for this surface alone. But a ground that has something else behind it which does not
//! cross it, and is not small beside it, is none: people stand under an awning, and see what it is fastened to.

mod facing;
mod stand;

use super::placed::{CROSSES, NEAR, Placed, PlacedTree, SMALL, Sheet, sheets};
use super::topology::corners;
use super::{Inside, Solids};
use facing::{backward, behind, cosine, facing, is_near, looks_alike};
use glam::DVec3;
use rayon::prelude::*;
use scene::Sets;
use stand::Stand;
use std::collections::{BTreeMap, BTreeSet};

/// Faces of a sheet from which one looks for what is behind it.
const LOOKS: usize = 64;
/// The cosine of the angle at which one sheet may go on where another ends.
const ALONG: f64 = 0.999;

/// Pairs of a sheet and a surface near it that are looked at before what they say is taken together.
const AT_ONCE: usize = 1 << 14;

/// Places beyond the border of a sheet at which one looks whether it hangs over another.
const BORDER: usize = 256;

/// A closed body stands out in front of a ground at least this share of what it reaches behind it. A stone may be sunk
/// by four fifths; what only pokes through a wall belongs to the other side.
const CLOSED_OUT: f64 = 0.25;
/// An open one more than it reaches behind it: of two cards that cross in their middles neither is the ground.
const OPEN_OUT: f64 = 1.25;

/// Placement and number of a surface.
type Key = (u32, u32);

/// How a ground lies over a sheet.
#[derive(PartialEq, Eq)]
enum Alike {
    /// They look elsewhere, or one may look from beside them.
    No,
    /// It ends over it.
    Ends,
    Covers,
}

/// Sheets that go on in one another.
struct Ground {
    /// Their numbers, in order.
    sheets: Vec<usize>,
    /// The box about them.
    low: DVec3,
    high: DVec3,
    /// Its largest edge.
    size: f64,
}

impl Ground {
    /// True where a surface reaches farther along the ground than the ground itself: it stands around that, as a house
    /// around its ceiling.
    fn is_within(&self, sheet: &Placed, other: &Placed) -> bool {
        let front = facing(sheet).unwrap_or_default();
        let along = |low: DVec3, high: DVec3| {
            let turns = [
                DVec3::ONE,
                DVec3::new(-1.0, 1.0, 1.0),
                DVec3::new(1.0, -1.0, 1.0),
                DVec3::new(1.0, 1.0, -1.0),
            ];
            let diagonals =
                turns.map(|turn| ((high - low) * turn).reject_from_normalized(front).length());
            diagonals.into_iter().fold(0.0, f64::max)
        };
        along(other.low, other.high) > (1.0 + NEAR) * along(self.low, self.high)
    }
}

impl Solids {
    /// Finds the grounds of a scene and what is rooted in them, and makes bodies of both.
    pub(super) fn root(&mut self) {
        let found = self.rooted_in_grounds();
        for (sheet, held) in found {
            let [members, cut] = held.map(|keys| {
                let mut bodies: Vec<u32> = keys.into_iter().map(|key| self.body_of(key)).collect();
                bodies.sort_unstable();
                bodies
            });
            let sheet = self.body_of(sheet);
            self.widen(sheet, &members);
            self.widen(sheet, &cut);
            let body = &mut self.bodies[sheet as usize];
            (body.inside, body.cut) = (Inside::Behind(members), cut);
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

    /// By sheet, what is rooted in it and what it cuts: placements and numbers of surfaces.
    fn rooted_in_grounds(&self) -> BTreeMap<Key, [Vec<Key>; 2]> {
        let placed = self.placed_surfaces();
        let all = PlacedTree::of(placed.iter().collect());
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
        let mut sets = Sets::new(sheets.len());
        let goes_on = |sheet: &Sheet| -> Vec<usize> {
            let of = &placed[sheet.place];
            let tree = self.tree_of(of.shape, of.key.1);
            let is_level = |other| Stand::of(&self.scene, of, tree, other).is_level();
            let is_one = |&(place, _): &(usize, usize)| {
                let other = &placed[place];
                is_near(of, other)
                    && cosine(of, other).is_some_and(|cosine| cosine > ALONG)
                    && (self.is_in_plane(of, other) || is_level(other))
            };
            let near = sheet.near.iter().map(|&other| other as usize);
            let known = near.filter_map(|other| Some((other, *number.get(&other)?)));
            known.filter(is_one).map(|(_, next)| next).collect()
        };
        let links: Vec<Vec<usize>> = sheets.par_iter().map(goes_on).collect();
        for (own, links) in links.into_iter().enumerate() {
            for next in links {
                sets.join(own as u32, next as u32);
            }
        }
        let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for own in 0..sheets.len() {
            groups.entry(sets.root(own as u32)).or_default().push(own);
        }
        let ground = |sheets_of: Vec<usize>| {
            let boxes = sheets_of.iter().map(|&n| &placed[sheets[n].place]);
            let (low, high) = boxes
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                    (low.min(p.low), high.max(p.high))
                });
            Ground {
                sheets: sheets_of,
                low,
                high,
                size: (high - low).max_element(),
            }
        };
        groups.into_values().map(ground).collect()
    }

    /// The sheets of a ground with what is rooted in each and what it cuts; none where it is no ground, or nothing is.
    ///
    /// * `sizes`: by the place in the list, the size of what a surface is part of.
    fn rooted_in(
        &self,
        ground: &Ground,
        placed: &[Placed],
        all: &PlacedTree,
        sheets: &[Sheet],
        sizes: &[f64],
    ) -> Vec<(Key, [Vec<Key>; 2])> {
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
            let of = &placed[other];
            let mut stand = Stand::of(&self.scene, sheet, tree, of);
            if of.surface.front.is_some() {
                let tree = self.tree_of(of.shape, of.key.1);
                stand.look_from(&self.scene, sheet, of, tree);
            }
            stand.meets.then_some((other, stand))
        };
        // Sheets in a heap have others right behind them, and are no grounds whatever stands in them: that is sooner
        // known than how all that is near stands.
        let lays_bare = |pair: &(&Placed, usize)| {
            let (sheet, other) = (pair.0, &placed[pair.1]);
            let (low, high) = behind(sheet);
            sizes[pair.1] >= SMALL * ground.size
                && other.meets(low, high)
                && self.is_behind(sheet, other)
                && stand(pair).is_none_or(|(_, stand)| !stand.crosses())
        };
        if ground.sheets.len() == 1 && pairs.iter().any(lays_bare) {
            return Vec::new();
        }
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
            let (meets, out) = match other.surface.volume != 0.0 {
                true => (stand.touches(), CLOSED_OUT),
                false => (stand.crosses(), OPEN_OUT),
            };
            // Who sees the front of both sees nothing that is behind either.
            if meets && self.covers_alike(ground, (sheets, all), other) == Alike::Covers {
                return true;
            }
            let stands_out = stand.front >= out * stand.behind
                && !members().any(|sheet| ground.is_within(&placed[sheet.place], other));
            if !meets || !stands_out {
                return false;
            }
            let size = (stand.high - stand.low).max_element();
            let (low, high) = (stand.low - NEAR * size, stand.high + NEAR * size);
            let lays_open = |place: usize| {
                let near = &placed[place].key;
                let is_other = *near != other.key && !own.contains(near);
                let is_behind = !crossing.contains(near) && !before.contains(near);
                is_other && is_behind && sizes[place] >= SMALL * size
            };
            !all.any_place(low, high, lays_open)
        };
        let rooted: BTreeSet<usize> = (stands.iter())
            .filter(|(other, stand)| is_rooted(&placed[**other], stand))
            .map(|(&other, _)| other)
            .collect();
        let is_cut = |other: &usize, stand: &Stand| {
            let covers = || self.covers_alike(ground, (sheets, all), &placed[*other]);
            !rooted.contains(other) && stand.crosses() && covers() == Alike::Ends
        };
        let cut: BTreeSet<usize> = (stands.iter())
            .filter(|(other, stand)| is_cut(other, stand))
            .map(|(&other, _)| other)
            .collect();
        if rooted.is_empty() && cut.is_empty() {
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
            let near = || sheet.near.iter().map(|&other| other as usize);
            let held = [&rooted, &cut].map(|held| {
                let near = near().filter(|other| held.contains(other));
                let near = near.filter(|other| is_near(of, &placed[*other]));
                let mut keys: Vec<Key> = near.map(|other| placed[other].key).collect();
                keys.sort_unstable();
                keys
            });
            (of.key, held)
        };
        let each = members().map(of);
        let holds_any = |(_, held): &(Key, [Vec<Key>; 2])| held.iter().any(|keys| !keys.is_empty());
        each.filter(holds_any).collect()
    }

    /// Whether a sheet looks as a ground does, and whether that ends over it somewhere, where one looks in between.
    fn covers_alike(
        &self,
        ground: &Ground,
        (sheets, all): (&[Sheet], &PlacedTree),
        other: &Placed,
    ) -> Alike {
        let members = || {
            ground
                .sheets
                .iter()
                .map(|&number| all.placed[sheets[number].place])
        };
        let own: BTreeSet<Key> = members().map(|sheet| sheet.key).collect();
        let slack = NEAR * ground.size;
        // How far in front of a sheet a place stands, along a direction.
        let height = |sheet: &Placed, at: DVec3, front: DVec3, inner| {
            let front = sheet.inverse.transform_vector3(front).normalize_or_zero();
            let local = sheet.inverse.transform_point3(at);
            let tree = self.tree_of(sheet.shape, sheet.key.1);
            tree.height_over(&self.scene, local, front, inner)
        };
        let hangs = |sheet: &Placed| {
            let (Some(front), Some(other_front)) = (facing(sheet), facing(other)) else {
                return true;
            };
            // A place just beyond the border of one sheet may be on the next.
            let goes_on = |at: DVec3| {
                all.any(at - slack, at + slack, |next| {
                    let above = || height(next, at, front, false);
                    own.contains(&next.key) && above().is_some_and(|h| h.abs() <= slack)
                })
            };
            // By the fronts of both: a sheet that leans is over what is beside it too.
            let is_over = |at| {
                let above = |front| height(other, at, front, true).is_some_and(|h| h > slack);
                above(front) && above(other_front)
            };
            let border = &sheet.surface.border;
            let some = border.iter().step_by(border.len().div_ceil(BORDER).max(1));
            let mut beyond = some.map(|edge| {
                let [a, b] = edge.map(|p| sheet.transform.transform_point3(p.as_dvec3()));
                0.5 * (a + b) + slack * front.cross(b - a).normalize_or_zero()
            });
            beyond.any(|at| is_over(at) && !goes_on(at))
        };
        // What stands on a large sheet that looks elsewhere is no ground: cards on a floor.
        let stands_up = |sheet: &Placed| {
            all.any(sheet.low, sheet.high, |next| {
                let is_large = next.size() >= SMALL * ground.size;
                is_large && next.surface.front.is_some() && !looks_alike(sheet, next)
            })
        };
        if !members().all(|sheet| looks_alike(sheet, other) && !stands_up(sheet)) {
            return Alike::No;
        }
        match members().any(hangs) {
            true => Alike::Ends,
            false => Alike::Covers,
        }
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
