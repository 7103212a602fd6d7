//! Flat faces: triangles of one plane that hang together along edges or parts of edges. No chart ends inside of one.
//!
//! Where the triangles of a face share whole edges, two at each, it is for what cuts the mesh into charts to keep them
//! together. Where they meet at T-junctions, or at edges that others share too, the face is loose: it becomes a chart
//! as it lies. Some junctions stay borders: where the chart would be mostly empty, as a ring of skirting boards is, and
//! where it would be torn out of a curved surface along more edges than it mends.

mod hull;
mod planes;
#[cfg(test)]
mod tests;

use crate::flatten::{NONE, Welded, overlap};
use glam::{DVec2, DVec3};
use hull::{hull, hull_in, narrowest};
use planes::{Junction, junctions, planes};
use rayon::prelude::*;
use scene::Sets;
use std::collections::{HashMap, HashSet};

/// Cosine of the largest angle between the planes of a loose face, and its mean: a degree.
const ONE_FACE: f64 = 0.999_848;
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
    pub fn of(surface: &Welded) -> Self {
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
fn part_sparse(surface: &Welded, of: &mut [u32]) {
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
    surface: &'a Welded,
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

impl Face {
    /// Triangles laid flat; else the planes that have to stand back: those that bend too far from the whole, or the
    /// smaller of two that cover a place twice.
    fn new(
        surface: &Welded,
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
