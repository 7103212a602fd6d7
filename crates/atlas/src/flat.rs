//! Flat faces: triangles of one plane that hang together along edges or parts of edges. No chart ends inside of one.
//!
//! Where the triangles of a face share whole edges, two at each, it is for what cuts the mesh into charts to keep them
//! together. Where they meet at T-junctions, or at edges that others share too, the face is loose: it becomes a chart
//! as it lies. Some junctions stay borders: where the chart would be mostly empty, as a ring of skirting boards is, and
//! where it would be torn out of a curved surface along more edges than it mends.

use crate::flatten::{NONE, Surface, overlap};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use scene::Sets;
use std::collections::{HashMap, HashSet};

/// Cosine of the largest angle between normals of one plane: a quarter of a degree.
const ONE_PLANE: f64 = 1.0 - 1e-5;
/// Cosine of the largest angle between the planes of a loose face, and its mean: a degree.
const ONE_FACE: f64 = 0.999_848;
/// Corners lie in a plane or on a line that is nearer than this share of the mesh. Files round by less.
const NEAR: f64 = 1e-6;
/// Cells of normals and of planes' places in which borders are looked for together.
const NORMALS: f64 = 1e3;
const PLACES: f64 = 1e4;
/// The box about planes that are joined is at most so many times as large as their own boxes together, and that about a
/// plane as the plane.
const SPARSE: f64 = 8.0;
/// A face is torn out of a curved surface along at most so many times the length of its junctions.
const TORN: f64 = 2.0;
/// Overlaps that are looked at together.
const MOST_OVERLAPS: usize = 1000;

/// The flat faces of a mesh.
pub(crate) struct Faces {
    /// The face of each triangle: the number of one of its triangles.
    pub of: Vec<u32>,
    /// Those that become charts as they lie.
    pub loose: Vec<Face>,
}

/// A flat face as it lies.
pub(crate) struct Face {
    /// Of the surface.
    pub triangles: Vec<u32>,
    /// The corners of each triangle in the plane of the face. A triangle that would be turned over has all at one
    /// place.
    pub places: Vec<[DVec2; 3]>,
}

impl Faces {
    /// The faces of a surface about 1 in size.
    pub fn of(surface: &Surface) -> Self {
        let mut of = planes(surface);
        let junctions = junctions(surface, &of);
        let mut members: HashMap<u32, Vec<u32>> = HashMap::new();
        for junction in &junctions {
            for t in junction.triangles {
                members.entry(of[t as usize]).or_default();
            }
        }
        for (t, plane) in of.iter().enumerate() {
            if let Some(triangles) = members.get_mut(plane) {
                triangles.push(t as u32);
            }
        }
        let mut held: Vec<u32> = members.keys().copied().collect();
        held.sort_unstable();
        let planes = Planes {
            surface,
            of: &of,
            members,
        };
        let loose: Vec<Face> = together(&held, &of, junctions)
            .into_par_iter()
            .with_max_len(1)
            .flat_map_iter(|group| planes.faces(group))
            .collect();
        part_sparse(surface, &mut of);
        for face in &loose {
            let number = face.triangles[0];
            face.triangles.iter().for_each(|&t| of[t as usize] = number);
        }
        Self { of, loose }
    }
}

/// Makes a face of each triangle of a plane that leaves most of its box empty.
fn part_sparse(surface: &Surface, of: &mut [u32]) {
    let mut members: HashMap<u32, Vec<u32>> = HashMap::new();
    for (t, &face) in of.iter().enumerate() {
        members.entry(face).or_default().push(t as u32);
    }
    for (face, triangles) in members {
        let area: f64 = triangles.iter().map(|&t| surface.areas[t as usize]).sum();
        let corners = triangles
            .iter()
            .flat_map(|&t| surface.triangles[t as usize]);
        let places = corners.map(|c| surface.corners[c as usize]);
        if hull_in(surface, face, places.collect()).1 > SPARSE * area {
            triangles.iter().for_each(|&t| of[t as usize] = t);
        }
    }
}

/// The convex hull of points in the plane of a triangle, and the area of the narrowest box about it.
fn hull_in(surface: &Surface, plane: u32, points: Vec<DVec3>) -> (Vec<DVec3>, f64) {
    let normal = surface.normals[plane as usize];
    let (u, v) = normal.any_orthonormal_pair();
    let flat = points.iter().map(|p| DVec2::new(p.dot(u), p.dot(v)));
    let hull = hull(flat.collect());
    let area = narrowest(&hull).1;
    let height = points.first().map_or(0.0, |p| p.dot(normal));
    let solid = |p: &DVec2| u * p.x + v * p.y + normal * height;
    (hull.iter().map(solid).collect(), area)
}

/// Planes that hang together by junctions.
#[derive(Default)]
struct Group {
    planes: Vec<u32>,
    junctions: Vec<Junction>,
}

/// The groups of some planes, in order. Junctions with other planes are left out, and so are planes without junctions.
fn together(planes: &[u32], of: &[u32], junctions: Vec<Junction>) -> Vec<Group> {
    let number: HashMap<u32, u32> = planes.iter().copied().zip(0..).collect();
    let ends = |junction: &Junction| {
        let [a, b] = junction.triangles.map(|t| number.get(&of[t as usize]));
        a.copied().zip(b.copied())
    };
    let mut sets = Sets::new(planes.len());
    for (a, b) in junctions.iter().filter_map(ends) {
        sets.join(a, b);
    }
    let mut groups: Vec<Group> = Vec::new();
    let mut group_of = HashMap::new();
    for (at, &plane) in (0..).zip(planes) {
        let group = *group_of.entry(sets.root(at)).or_insert_with(|| {
            groups.push(Group::default());
            groups.len() - 1
        });
        groups[group].planes.push(plane);
    }
    for junction in junctions {
        if let Some((a, _)) = ends(&junction) {
            let group = group_of[&sets.root(a)];
            groups[group].junctions.push(junction);
        }
    }
    groups.retain(|group| !group.junctions.is_empty());
    groups
}

/// The planes of a surface that have junctions.
struct Planes<'a> {
    surface: &'a Surface,
    /// The plane of each triangle.
    of: &'a [u32],
    members: HashMap<u32, Vec<u32>>,
}

impl Planes<'_> {
    /// The faces that a group makes.
    fn faces(&self, group: Group) -> Vec<Face> {
        let mut faces = Vec::new();
        let mut waiting = self.compact(group);
        while let Some(group) = waiting.pop() {
            if self.is_torn(&group) {
                continue;
            }
            let triangles = group.planes.iter().flat_map(|plane| &self.members[plane]);
            let mut triangles: Vec<u32> = triangles.copied().collect();
            triangles.sort_unstable();
            match Face::new(self.surface, self.of, triangles, &group.junctions) {
                Ok(face) => faces.push(face),
                Err(back) => {
                    let (back, rest): (Vec<u32>, Vec<u32>) =
                        group.planes.iter().partition(|plane| back.contains(plane));
                    // A plane alone is for what cuts the mesh.
                    if !rest.is_empty() {
                        waiting.extend(together(&rest, self.of, group.junctions.clone()));
                        waiting.extend(together(&back, self.of, group.junctions));
                    }
                }
            }
        }
        faces.sort_unstable_by_key(|face| face.triangles[0]);
        faces
    }

    /// A group as it is, or where most of the box about it would be empty, in parts of which that is not so: those with
    /// the longest junctions first.
    fn compact(&self, group: Group) -> Vec<Group> {
        let hulls: Vec<(Vec<DVec3>, f64)> = group
            .planes
            .iter()
            .map(|plane| {
                let triangles = self.members[plane].iter();
                let corners = triangles.flat_map(|&t| self.surface.triangles[t as usize]);
                let places = corners.map(|c| self.surface.corners[c as usize]);
                hull_in(self.surface, *plane, places.collect())
            })
            .collect();
        let sum: f64 = hulls.iter().map(|(_, area)| area).sum();
        let all = hulls.iter().flat_map(|(hull, _)| hull).copied().collect();
        if hull_in(self.surface, group.planes[0], all).1 <= SPARSE * sum {
            return vec![group];
        }
        let number: HashMap<u32, u32> = group.planes.iter().copied().zip(0..).collect();
        let mut lengths: HashMap<[u32; 2], f64> = HashMap::new();
        for junction in &group.junctions {
            let [a, b] = junction.triangles.map(|t| number[&self.of[t as usize]]);
            *lengths.entry([a.min(b), a.max(b)]).or_default() += junction.length;
        }
        let mut pairs: Vec<([u32; 2], f64)> = lengths.into_iter().collect();
        pairs.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut sets = Sets::new(hulls.len());
        let mut whole = hulls.clone();
        // Areas of the boxes of the planes that are joined.
        let mut parts: Vec<f64> = hulls.into_iter().map(|(_, area)| area).collect();
        for ([a, b], _) in pairs {
            let [a, b] = [a, b].map(|plane| sets.root(plane));
            if a == b {
                continue;
            }
            let corners = [a, b].map(|k| whole[k as usize].0.as_slice()).concat();
            let joined = hull_in(self.surface, group.planes[a as usize], corners);
            let sum = parts[a as usize] + parts[b as usize];
            if joined.1 <= SPARSE * sum {
                sets.join(a, b);
                whole[a.min(b) as usize] = joined;
                parts[a.min(b) as usize] = sum;
            }
        }
        let mut by_root: HashMap<u32, Vec<u32>> = HashMap::new();
        for (at, &plane) in (0..).zip(&group.planes) {
            by_root.entry(sets.root(at)).or_default().push(plane);
        }
        let mut found: Vec<Vec<u32>> = by_root.into_values().collect();
        found.sort_unstable();
        let parts = found.iter();
        parts
            .flat_map(|planes| together(planes, self.of, group.junctions.clone()))
            .collect()
    }

    /// True where other planes go on without a fold along more of the borders of a group than it has junctions.
    fn is_torn(&self, group: &Group) -> bool {
        let mended: f64 = group.junctions.iter().map(|junction| junction.length).sum();
        let own: HashSet<u32> = group.planes.iter().copied().collect();
        let mut torn = 0.0;
        for &t in group.planes.iter().flat_map(|plane| &self.members[plane]) {
            for (k, beside) in self.surface.neighbours[t as usize].into_iter().enumerate() {
                if beside != NONE && !own.contains(&self.of[beside as usize]) {
                    torn += self.surface.length(t as usize, k);
                }
            }
        }
        torn > TORN * mended
    }
}

/// For each triangle the largest of those that lie in its plane and hang together with it by edges of two triangles.
fn planes(surface: &Surface) -> Vec<u32> {
    let mut seeds: Vec<u32> = (0..surface.triangles.len() as u32).collect();
    seeds.par_sort_unstable_by(|&a, &b| {
        let areas = surface.areas[b as usize].total_cmp(&surface.areas[a as usize]);
        areas.then(a.cmp(&b))
    });
    let mut of = vec![NONE; surface.triangles.len()];
    let mut waiting = Vec::new();
    for seed in seeds {
        if of[seed as usize] != NONE {
            continue;
        }
        let normal = surface.normals[seed as usize];
        let corner = |c: u32| surface.corners[c as usize];
        let origin = corner(surface.triangles[seed as usize][0]);
        let is_flat = |t: u32| {
            let turned = surface.normals[t as usize].dot(normal);
            let corners = surface.triangles[t as usize].map(corner);
            let lies = || {
                corners
                    .iter()
                    .all(|&p| (p - origin).dot(normal).abs() <= NEAR)
            };
            // The normal of a thin triangle says little.
            turned >= ONE_PLANE || (turned > 0.0 && lies())
        };
        of[seed as usize] = seed;
        waiting.push(seed);
        while let Some(t) = waiting.pop() {
            for beside in surface.neighbours[t as usize] {
                if beside != NONE && of[beside as usize] == NONE && is_flat(beside) {
                    of[beside as usize] = seed;
                    waiting.push(beside);
                }
            }
        }
    }
    of
}

/// Two borders of one plane that run along one another.
#[derive(Clone, Copy)]
struct Junction {
    triangles: [u32; 2],
    /// What they have in common.
    length: f64,
    /// Corners of one that lie on the edge of the other, and the ends of that edge.
    on: [Option<(u32, [u32; 2])>; 2],
}

/// An edge of a triangle, in its direction, beyond which its plane does not go on by a neighbour.
#[derive(Clone, Copy)]
struct Border {
    triangle: u32,
    ends: [u32; 2],
    low: DVec3,
    high: DVec3,
    normal: DVec3,
}

/// Where planes meet in other ways than by edges of two triangles.
fn junctions(surface: &Surface, planes: &[u32]) -> Vec<Junction> {
    let mut sizes = vec![0u32; planes.len()];
    planes.iter().for_each(|&plane| sizes[plane as usize] += 1);
    let borders = |t: usize| {
        let beside = surface.neighbours[t];
        let plane = planes[t] as usize;
        // A facet of a curved surface has no junctions.
        let is_facet = sizes[plane] == 1 && !beside.contains(&NONE);
        let sides = if is_facet || surface.areas[t] == 0.0 {
            0
        } else {
            3
        };
        let border = move |k: usize| {
            let corners = surface.triangles[t];
            let ends = [corners[k], corners[(k + 1) % 3]];
            let goes_on = beside[k] != NONE && planes[beside[k] as usize] as usize == plane;
            let [a, b] = ends.map(|end| surface.corners[end as usize]);
            (!goes_on && ends[0] != ends[1]).then_some(Border {
                triangle: t as u32,
                ends,
                low: a.min(b),
                high: a.max(b),
                normal: surface.normals[plane],
            })
        };
        (0..sides).filter_map(border)
    };
    let all = (0..planes.len()).into_par_iter();
    let borders: Vec<Border> = all.flat_map_iter(borders).collect();
    let place = |corner: u32| surface.corners[corner as usize];
    // What lies on both sides of a cell's wall lies in one cell of a grid beside it.
    let found = [0.0, 0.5].map(|shift| {
        let cell = |k: u32| {
            let border = &borders[k as usize];
            let at = place(border.ends[0]).dot(border.normal) * PLACES;
            let [x, y, z] = (border.normal * NORMALS).to_array();
            ([x, y, z, at].map(|x| (x + shift).floor() as i32), k)
        };
        let mut cells: Vec<([i32; 4], u32)> = (0..borders.len() as u32)
            .into_par_iter()
            .map(cell)
            .collect();
        cells.par_sort_unstable();
        let cells: Vec<&[([i32; 4], u32)]> = cells.chunk_by(|a, b| a.0 == b.0).collect();
        let among = |cell: &[([i32; 4], u32)]| {
            let own = cell.iter().map(|&(_, k)| borders[k as usize]);
            meeting(surface, own.collect())
        };
        let found: Vec<Vec<Junction>> = cells.into_par_iter().map(among).collect();
        found.concat()
    });
    let mut found = found.concat();
    found.sort_unstable_by_key(|junction| (junction.triangles, junction.on));
    found.dedup_by_key(|junction| (junction.triangles, junction.on));
    found
}

/// The junctions of some borders.
fn meeting(surface: &Surface, mut borders: Vec<Border>) -> Vec<Junction> {
    let limits = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = (borders.iter()).fold(limits, |(l, h), b| (l.min(b.low), h.max(b.high)));
    let axis = (high - low).max_position();
    borders.sort_unstable_by(|a, b| {
        let order = a.low[axis].total_cmp(&b.low[axis]);
        order.then((a.triangle, a.ends).cmp(&(b.triangle, b.ends)))
    });
    let mut found = Vec::new();
    for (k, a) in borders.iter().enumerate() {
        let beside = borders[k + 1..].iter();
        for b in beside.take_while(|b| b.low[axis] <= a.high[axis] + NEAR) {
            let meet = a.low.cmple(b.high + NEAR) & b.low.cmple(a.high + NEAR);
            if meet.all() && a.triangle != b.triangle {
                found.extend(junction(surface, [a, b]));
            }
        }
    }
    found
}

fn junction(surface: &Surface, pair: [&Border; 2]) -> Option<Junction> {
    let place = |corner: u32| surface.corners[corner as usize];
    let length = |border: &Border| place(border.ends[0]).distance(place(border.ends[1]));
    let [long, short] = match length(pair[0]) < length(pair[1]) {
        true => [pair[1], pair[0]],
        false => pair,
    };
    let start = place(long.ends[0]);
    let along = (place(long.ends[1]) - start).try_normalize()?;
    let reach = length(long);
    let [from, to] = short.ends.map(|end| (place(end) - start).dot(along));
    let lies = |end: u32| (place(end) - start).reject_from_normalized(along).length() <= NEAR;
    let common = from.min(reach) - to.max(0.0);
    // Triangles that lie on both sides run along an edge in opposite directions.
    let is_one = from > to && common > NEAR && short.ends.into_iter().all(lies);
    if !is_one || long.normal.dot(short.normal) < ONE_PLANE {
        return None;
    }
    let on = [(short.ends[0], from), (short.ends[1], to)].map(|(end, at)| {
        let is_within = (0.0..=reach).contains(&at) && !long.ends.contains(&end);
        is_within.then_some((end, long.ends))
    });
    Some(Junction {
        triangles: [long.triangle, short.triangle],
        length: common,
        on,
    })
}

impl Face {
    /// Triangles laid flat; else the planes that have to stand back: those that bend too far from the whole, or the
    /// smaller of two that cover a place twice.
    fn new(
        surface: &Surface,
        planes: &[u32],
        triangles: Vec<u32>,
        junctions: &[Junction],
    ) -> Result<Self, HashSet<u32>> {
        let weighted = |&t: &u32| surface.normals[t as usize] * surface.areas[t as usize];
        let normal = triangles.iter().map(weighted).sum::<DVec3>();
        let normal = normal.normalize_or_zero();
        let plane = |&t: &u32| planes[t as usize];
        let is_bent = |plane: &u32| surface.normals[*plane as usize].dot(normal) < ONE_FACE;
        let bent: HashSet<u32> = triangles.iter().map(plane).filter(is_bent).collect();
        if !bent.is_empty() {
            return Err(bent);
        }
        let (u, v) = normal.any_orthonormal_pair();
        let mut places: HashMap<u32, DVec2> = HashMap::new();
        for corner in triangles
            .iter()
            .flat_map(|&t| surface.triangles[t as usize])
        {
            let p = surface.corners[corner as usize];
            places.insert(corner, DVec2::new(p.dot(u), p.dot(v)));
        }
        // What lies on an edge but for rounding lies on it here.
        for (corner, ends) in junctions.iter().flat_map(|junction| junction.on).flatten() {
            let [from, to] = ends.map(|end| places[&end]);
            let along = (to - from).normalize_or_zero();
            places.insert(corner, from + along * (places[&corner] - from).dot(along));
        }
        let turn = narrowest(&hull(places.values().copied().collect())).0;
        let placed = |&t: &u32| {
            let corners = surface.triangles[t as usize].map(|c| turn.rotate(places[&c]));
            let [a, b, c] = corners;
            match (b - a).perp_dot(c - a) > 0.0 {
                true => corners,
                false => [a; 3],
            }
        };
        let places: Vec<[DVec2; 3]> = triangles.iter().map(placed).collect();
        let solid: Vec<usize> = (0..places.len())
            .filter(|&t| places[t][0] != places[t][1])
            .collect();
        let lying: Vec<[DVec2; 3]> = solid.iter().map(|&t| places[t]).collect();
        let smaller = |pair: [usize; 2]| {
            let [a, b] = pair.map(|t| planes[triangles[solid[t]] as usize]);
            let areas = [a, b].map(|plane| surface.areas[plane as usize]);
            if areas[0] < areas[1] { a } else { b }
        };
        let twice = overlap::overlaps(&lying, MOST_OVERLAPS).into_iter();
        let back: HashSet<u32> = twice.map(smaller).collect();
        match back.is_empty() {
            true => Ok(Self { triangles, places }),
            false => Err(back),
        }
    }
}

/// The turn after which the box around a convex hull has the least area, which it has with a side along an edge, and
/// that area.
fn narrowest(hull: &[DVec2]) -> (DVec2, f64) {
    let turns = (0..hull.len()).map(|i| {
        let edge = (hull[(i + 1) % hull.len()] - hull[i]).normalize_or(DVec2::X);
        let turn = DVec2::new(edge.x, -edge.y);
        let turned = || hull.iter().map(|p| turn.rotate(*p));
        let low = turned().fold(DVec2::INFINITY, DVec2::min);
        let high = turned().fold(DVec2::NEG_INFINITY, DVec2::max);
        (turn, (high - low).element_product())
    });
    let least = turns.min_by(|a, b| a.1.total_cmp(&b.1));
    least.unwrap_or((DVec2::X, 0.0))
}

/// The convex hull of points, turning left.
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull: Vec<DVec2> = Vec::new();
    let back: Vec<DVec2> = points.iter().rev().copied().collect();
    for way in [points, back] {
        let first = hull.len();
        for p in way {
            let bends_right = |hull: &[DVec2]| {
                let [a, b] = [hull[hull.len() - 2], hull[hull.len() - 1]];
                (b - a).perp_dot(p - b) <= 0.0
            };
            while hull.len() >= first + 2 && bends_right(&hull) {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Upright quads of a wall over z = 0 from their lowest to their highest corners, turned in space and about 1 in
    /// size.
    fn wall(quads: &[[f64; 4]]) -> Surface {
        let turn = glam::DQuat::from_axis_angle(DVec3::new(0.2, 0.3, 1.0).normalize(), 0.31);
        let mut corners: Vec<DVec3> = Vec::new();
        let mut number = |x: f64, y: f64| {
            let at = turn * DVec3::new(x, y, 0.0) / 8.0;
            let known = corners.iter().position(|p| *p == at);
            let number = known.unwrap_or(corners.len());
            if known.is_none() {
                corners.push(at);
            }
            number as u32
        };
        let mut triangles = Vec::new();
        for &[x0, y0, x1, y1] in quads {
            let [a, b] = [number(x0, y0), number(x1, y0)];
            let [c, d] = [number(x1, y1), number(x0, y1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        Surface::new(corners, triangles.clone(), &triangles)
    }

    /// Triangles of each loose face, after a look at the lengths of their edges.
    fn loose(surface: &Surface) -> Vec<Vec<u32>> {
        let faces = Faces::of(surface);
        for face in &faces.loose {
            for (&t, places) in face.triangles.iter().zip(&face.places) {
                for k in 0..3 {
                    let length = places[k].distance(places[(k + 1) % 3]);
                    let solid = surface.length(t as usize, k);
                    assert!((length - solid).abs() < 1e-6, "{length} {solid}");
                }
                assert_eq!(faces.of[t as usize], face.triangles[0]);
            }
        }
        let triangles = faces.loose.into_iter().map(|face| face.triangles);
        triangles.collect()
    }

    #[test]
    fn a_wall_with_t_junctions_is_one_face_as_it_lies() {
        // Above one quad three, and bricks that share no corner with what they lie on.
        let parts = [
            [0.0, 0.0, 6.0, 2.0],
            [0.0, 2.0, 1.5, 3.0],
            [1.5, 2.0, 4.0, 3.0],
            [4.0, 2.0, 6.0, 3.0],
            [0.5, 3.0, 3.0, 4.0],
        ];
        assert_eq!(loose(&wall(&parts)), [Vec::from_iter(0..10)]);
        // What shares whole edges is left to the unwrapper.
        let grid = [[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 2.0, 1.0]];
        assert!(loose(&wall(&grid)).is_empty());
        let faces = Faces::of(&wall(&grid)).of;
        assert!(faces.iter().all(|&face| face == faces[0]), "{faces:?}");
    }

    #[test]
    fn quads_that_share_an_edge_with_two_more_are_one_face() {
        // The tops of two boxes side by side: their inner sides end at the same edge.
        let mut surface = wall(&[[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 2.0, 1.0]]);
        let normal = surface.normals[0];
        let ends = [1, 2].map(|k| surface.triangles[0][k]);
        let below = ends.map(|end| surface.corners[end as usize] - normal / 8.0);
        let first = surface.corners.len() as u32;
        surface.corners.extend(below);
        let mut triangles = surface.triangles;
        triangles.extend([[ends[1], ends[0], first], [ends[0], ends[1], first + 1]]);
        let surface = Surface::new(surface.corners, triangles.clone(), &triangles);
        assert_eq!(loose(&surface), [Vec::from_iter(0..4)]);
    }

    #[test]
    fn what_lies_over_a_face_is_no_part_of_it() {
        let quads = [
            [0.0, 0.0, 6.0, 2.0],
            [0.0, 2.0, 3.0, 3.0],
            [3.0, 2.0, 6.0, 3.0],
            // Over the second one, from the middle of the first's edge on.
            [1.0, 2.0, 2.0, 2.5],
        ];
        assert_eq!(loose(&wall(&quads)), [Vec::from_iter(0..6)]);
    }

    #[test]
    fn a_frame_that_is_mostly_empty_stays_in_parts() {
        let frame = |wide: f64| {
            [
                [0.0, 0.0, 8.0, wide],
                [0.0, wide, wide, 8.0],
                [8.0 - wide, wide, 8.0, 8.0],
                [2.0 * wide, 8.0 - wide, 8.0 - wide, 8.0],
            ]
        };
        assert_eq!(loose(&wall(&frame(1.0)))[0].len(), 8);
        assert!(loose(&wall(&frame(0.1))).is_empty());
    }

    #[test]
    fn the_narrowest_box_has_a_side_along_the_hull() {
        let turn = DVec2::from_angle(0.4);
        let points = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (0.0, 1.0), (1.0, 0.5)];
        let points = points.map(|(x, y)| turn.rotate(DVec2::new(x, y)));
        let hull = hull(points.to_vec());
        assert_eq!(hull.len(), 4);
        assert!((narrowest(&hull).1 - 3.0).abs() < 1e-12);
    }
}
