//! Surfaces of meshes: which triangles hang together, and whether they close.
//!
//! Corners are one where their positions are equal, so seams of normals or lightmap coordinates do not cut a surface.
//! Triangles hang together over edges. A surface is closed where each edge is run through as often one way as the
//! other: then it has no border, and around any point it winds a whole number of times. Where some
//! triangles of a body run through their edges the wrong way, these are taken as turned, and the body as the one that
//! was meant.

use super::opening::{Opening, caps, openings};
use super::weld::{Face, Quick, weld};
use glam::{DVec3, Vec3};
use scene::{Scene, Sets};
use std::collections::{HashMap, HashSet};

/// Volumes below this share of the box's are those of a folded sheet, which has no inside.
const LEAST_VOLUME: f64 = 1e-6;

/// A surface has at least so many faces for each edge at a border, to count as a body with holes.
const HOLED: usize = 1;

/// And no more than so many of those edges for all faces: each face is asked about each hole.
const MOST_RIMS: usize = 1 << 22;

/// Triangles that hang together, in the space of their meshes.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    pub faces: Vec<Face>,
    pub low: Vec3,
    pub high: Vec3,
    /// What a closed surface of opaque triangles encloses: above 0 where its front faces look outward, below 0 where
    /// they look inward. 0 for any other.
    pub volume: f64,
    /// Where an open surface of opaque triangles looks, if to one side.
    pub front: Option<DVec3>,
    /// The border edges of such a surface. What lies beyond is to the left of each, seen from the front.
    pub border: Vec<[Vec3; 2]>,
    /// The same as `front`, of a surface that is cut out or see-through.
    pub veil: Option<DVec3>,
    /// What an opaque surface would enclose whose openings were filled, where it has some, does not look to one side,
    /// and each of them has a flat border: above 0 where its front faces look outward, below 0 where they look inward.
    /// 0 for any other.
    pub hollow: f64,
    /// Those openings.
    pub openings: Vec<Opening>,
    /// The triangles that fill each hole of an opaque surface that does not look to one side, flat or not. None where
    /// it has many edges at holes, or looks outward for the most part.
    pub caps: Vec<Vec<[[f32; 3]; 3]>>,
    /// Some of it is cut out or lets light through.
    pub masked: bool,
    /// A closed, opaque surface may be several bodies that touch, for more than two faces meet at some edge, or it
    /// crosses itself.
    pub tangled: bool,
}

/// Corners of a face.
pub(super) fn corners(scene: &Scene, face: Face) -> [Vec3; 3] {
    let mesh = &scene.meshes[face.mesh as usize];
    let vertices = face.order(mesh.triangles[face.triangle as usize]);
    vertices.map(|vertex| mesh.positions[vertex as usize])
}

impl Surface {
    /// What is enclosed, with openings filled.
    pub fn content(&self) -> f64 {
        self.volume + self.hollow
    }
}

/// The edge between two corners, the lesser first; the face, and whether it runs through it from the greater.
pub(super) type Edge = (u64, u32);

/// All edges of faces whose corners have these numbers, sorted.
pub(super) fn edges_of(welded: &[[u32; 3]]) -> Vec<Edge> {
    let mut edges: Vec<Edge> = Vec::with_capacity(3 * welded.len());
    for (index, [a, b, c]) in welded.iter().copied().enumerate() {
        if a == b || b == c || c == a {
            continue;
        }
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let key = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
            edges.push((key, (index as u32) << 1 | u32::from(from > to)));
        }
    }
    edges.sort_unstable();
    edges
}

/// Where some faces stand more than once in a file: the first of those that have the corners of each and run the same
/// way round, itself mostly. Two bodies that share a face are closed by both, so copies that hang together and without
/// which an edge would be at a border stand for themselves.
fn originals(welded: &[[u32; 3]], edges: &[Edge]) -> Option<Vec<u32>> {
    let runs = || edges.chunk_by(|a, b| a.0 == b.0);
    let sum = |ways: &mut dyn Iterator<Item = &Edge>| -> i32 {
        ways.map(|edge| if edge.1 & 1 == 1 { 1 } else { -1 }).sum()
    };
    // Two of which run the same way.
    let is_alike = |run: &[Edge]| run.len() > 2 || run.len() == 2 && sum(&mut run.iter()) != 0;
    if !runs().any(is_alike) {
        return None;
    }
    let mut known: HashMap<[u32; 3], u32, Quick> = HashMap::default();
    let of = |(&[a, b, c], index): (&[u32; 3], u32)| {
        let least = [[b, c, a], [c, a, b]].into_iter().fold([a, b, c], Ord::min);
        *known.entry(least).or_insert(index)
    };
    let mut originals: Vec<u32> = welded.iter().zip(0..).map(of).collect();
    let face = |edge: &Edge| edge.1 >> 1;
    let is_copy = |edge: &&Edge| originals[face(edge) as usize] != face(edge);
    let mut groups = Sets::new(welded.len());
    let mut needed = Vec::new();
    for run in runs() {
        let mut copies = run.iter().filter(is_copy).map(face);
        let Some(first) = copies.next() else {
            continue;
        };
        copies.for_each(|copy| groups.join(first, copy));
        let left = sum(&mut run.iter().filter(|edge| !is_copy(edge)));
        if sum(&mut run.iter()) == 0 && left != 0 {
            needed.push(first);
        }
    }
    let needed: HashSet<u32> = needed.into_iter().map(|face| groups.root(face)).collect();
    let mut has_copies = false;
    for (original, face) in originals.iter_mut().zip(0..) {
        if needed.contains(&groups.root(face)) {
            *original = face;
        }
        has_copies |= *original != face;
    }
    has_copies.then_some(originals)
}

/// Which faces run the other way round than most of the area of their closed body; those of others do not. A body here
/// is what hangs together over edges of two faces, where it runs through each of its edges as often either way once
/// these are turned.
fn against(scene: &Scene, faces: &[Face], edges: &[Edge]) -> Vec<bool> {
    let runs = || edges.chunk_by(|a, b| a.0 == b.0);
    let clashes = |run: &[Edge]| run.len() == 2 && (run[0].1 ^ run[1].1) & 1 == 0;
    let mut against = vec![false; faces.len()];
    if !runs().any(clashes) {
        return against;
    }
    // Three at most of each face, and whether both run the same way.
    let mut beside: Vec<[Option<(u32, bool)>; 3]> = vec![[None; 3]; faces.len()];
    for run in runs().filter(|run| run.len() == 2) {
        let [a, b] = [0, 1].map(|k| run[k].1 >> 1);
        for (face, other) in [(a, b), (b, a)] {
            let mut free = beside[face as usize].iter_mut();
            let free = free.find(|of| of.is_none());
            free.into_iter()
                .for_each(|of| *of = Some((other, clashes(run))));
        }
    }
    let mut body_of = vec![u32::MAX; faces.len()];
    let mut bodies: Vec<(Vec<u32>, bool)> = Vec::new();
    for first in 0..faces.len() as u32 {
        if body_of[first as usize] != u32::MAX {
            continue;
        }
        let number = bodies.len() as u32;
        body_of[first as usize] = number;
        let (mut body, mut next, mut is_closed) = (vec![first], 0, true);
        while let Some(&face) = body.get(next) {
            next += 1;
            for &(other, clashes) in beside[face as usize].iter().flatten() {
                let way = against[face as usize] != clashes;
                if body_of[other as usize] == number {
                    is_closed &= against[other as usize] == way;
                } else {
                    (body_of[other as usize], against[other as usize]) = (number, way);
                    body.push(other);
                }
            }
        }
        bodies.push((body, is_closed));
    }
    for run in runs().filter(|run| run.len() != 2) {
        for edge in run {
            let body = body_of[(edge.1 >> 1) as usize];
            let way = |edge: &Edge| (edge.1 & 1 == 1) != against[(edge.1 >> 1) as usize];
            let of_body = run
                .iter()
                .filter(|of| body_of[(of.1 >> 1) as usize] == body);
            let ways: i32 = of_body.map(|of| if way(of) { 1 } else { -1 }).sum();
            bodies[body as usize].1 &= ways == 0;
        }
    }
    let area = |face: u32| {
        let [a, b, c] = corners(scene, faces[face as usize]);
        f64::from((b - a).cross(c - a).length())
    };
    for (body, is_closed) in bodies {
        let sum = |way: bool| -> f64 {
            let of_way = body.iter().filter(|&&face| against[face as usize] == way);
            of_way.map(|&face| area(face)).sum()
        };
        let is_first_less = is_closed && sum(true) > sum(false);
        for face in body {
            let is_against = &mut against[face as usize];
            *is_against = is_closed && *is_against != is_first_less;
        }
    }
    against
}

/// The surfaces that faces make, in the order of their first faces.
pub(super) fn surfaces(scene: &Scene, faces: &[Face]) -> Vec<Surface> {
    let mut faces = faces.to_vec();
    let mut welded = weld(scene, &faces);
    let mut edges = edges_of(&welded);
    let originals = originals(&welded, &edges);
    // Copies bound nothing that their originals do not.
    let drop_copies = |edges: &mut Vec<Edge>| {
        if let Some(originals) = &originals {
            edges.retain(|edge| originals[(edge.1 >> 1) as usize] == edge.1 >> 1);
        }
    };
    drop_copies(&mut edges);
    let against = against(scene, &faces, &edges);
    if against.contains(&true) {
        let original = |face: usize| originals.as_ref().map_or(face, |of| of[face] as usize);
        for (index, (face, corners)) in faces.iter_mut().zip(&mut welded).enumerate() {
            if against[original(index)] {
                face.turned ^= true;
                corners.swap(1, 2);
            }
        }
        edges = edges_of(&welded);
        drop_copies(&mut edges);
    }
    let faces = &faces[..];
    let mut sets = Sets::new(faces.len());
    let mut borders = Vec::new();
    let mut branching = Vec::new();
    let mut rims: Vec<(u32, [u32; 2])> = Vec::new();
    for run in edges.chunk_by(|a, b| a.0 == b.0) {
        let first = run[0].1 >> 1;
        let turned = run.iter().filter(|edge| edge.1 & 1 == 1).count();
        if 2 * turned != run.len() {
            borders.push(first);
            // What fills the opening runs along it the other way.
            let (lesser, greater) = ((run[0].0 >> 32) as u32, run[0].0 as u32);
            let rim = match 2 * turned > run.len() {
                true => [lesser, greater],
                false => [greater, lesser],
            };
            let missing = (2 * turned).abs_diff(run.len());
            rims.extend(std::iter::repeat_n((first, rim), missing));
        }
        if run.len() > 2 {
            branching.push(first);
        }
        for edge in &run[1..] {
            sets.join(first, edge.1 >> 1);
        }
    }
    for (original, copy) in originals.into_iter().flatten().zip(0..) {
        sets.join(original, copy);
    }
    let mut open = vec![false; faces.len()];
    for face in borders {
        let root = sets.root(face);
        open[root as usize] = true;
    }
    let mut place = vec![u32::MAX; faces.len()];
    let mut found: Vec<(Surface, bool)> = Vec::new();
    for (index, face) in faces.iter().enumerate() {
        let root = sets.root(index as u32) as usize;
        if place[root] == u32::MAX {
            place[root] = found.len() as u32;
            found.push((Surface::empty(), open[root]));
        }
        found[place[root] as usize].0.add(scene, *face);
    }
    for face in branching {
        let root = sets.root(face) as usize;
        found[place[root] as usize].0.tangled = true;
    }
    let mut rims_of: Vec<Vec<[u32; 2]>> = vec![Vec::new(); found.len()];
    for (face, rim) in rims {
        let root = sets.root(face) as usize;
        rims_of[place[root] as usize].push(rim);
    }
    let positions = || -> HashMap<u32, Vec3, Quick> {
        let corners = faces.iter().map(|&face| corners(scene, face));
        let known = welded.iter().flatten().zip(corners.flatten());
        known.map(|(&number, at)| (number, at)).collect()
    };
    let positions = std::cell::LazyCell::new(positions);
    let finish = |((surface, open), rims): ((Surface, bool), Vec<[u32; 2]>)| {
        if surface.is_masked(scene) {
            let veil = front(scene, &surface.faces);
            let tangled = false;
            return Surface {
                veil,
                masked: true,
                tangled,
                ..surface
            };
        }
        if !open {
            let volume = surface.enclosed(scene);
            return Surface { volume, ..surface };
        }
        let front = front(scene, &surface.faces);
        let (openings, border) = match front {
            Some(_) => {
                let border = rims.iter().map(|rim| rim.map(|corner| positions[&corner]));
                (None, border.collect())
            }
            None => (openings(&rims, |corner| positions[&corner]), Vec::new()),
        };
        let openings = openings.unwrap_or_default();
        let is_holed = front.is_none()
            && HOLED * rims.len() <= surface.faces.len()
            && rims.len() * surface.faces.len() <= MOST_RIMS;
        let caps = match is_holed {
            true => caps(&rims, |corner| positions[&corner]),
            false => Vec::new(),
        };
        let mut surface = Surface {
            tangled: false,
            front,
            border,
            openings,
            ..surface
        };
        if surface.enclosed_by(scene, caps.iter().flatten()) < 0.0 {
            surface.caps = caps;
        }
        match surface.openings.is_empty() {
            true => surface,
            false => Surface {
                hollow: surface.enclosed(scene),
                ..surface
            },
        }
    };
    found.into_iter().zip(rims_of).map(finish).collect()
}

/// The unit direction to which all faces of an open, opaque surface look; `None` where there is none. In the space of
/// its mesh.
fn front(scene: &Scene, faces: &[Face]) -> Option<DVec3> {
    let normal = |face: &Face| {
        let [a, b, c] = corners(scene, *face).map(|corner| corner.as_dvec3());
        (b - a).cross(c - a)
    };
    let front = faces.iter().map(normal).sum::<DVec3>().try_normalize()?;
    let looks = |face| {
        let normal = normal(face);
        normal == DVec3::ZERO || normal.dot(front) > 0.0
    };
    faces.iter().all(looks).then_some(front)
}

impl Surface {
    fn empty() -> Self {
        Self {
            faces: Vec::new(),
            low: Vec3::INFINITY,
            high: Vec3::NEG_INFINITY,
            volume: 0.0,
            front: None,
            border: Vec::new(),
            veil: None,
            hollow: 0.0,
            openings: Vec::new(),
            caps: Vec::new(),
            masked: false,
            tangled: false,
        }
    }

    fn add(&mut self, scene: &Scene, face: Face) {
        for corner in corners(scene, face) {
            self.low = self.low.min(corner);
            self.high = self.high.max(corner);
        }
        self.faces.push(face);
    }

    /// A cut-out surface lets light in somewhere.
    fn is_masked(&self, scene: &Scene) -> bool {
        let mut meshes: Vec<u32> = self.faces.iter().map(|face| face.mesh).collect();
        meshes.dedup();
        meshes.iter().any(|&mesh| {
            let material = scene.meshes[mesh as usize].material;
            !scene.materials[material as usize].is_opaque()
        })
    }

    /// The signed volume, openings filled; 0 where there is next to none.
    fn enclosed(&self, scene: &Scene) -> f64 {
        let panes = self.openings.iter().flat_map(|opening| &opening.panes);
        self.enclosed_by(scene, panes)
    }

    /// The signed volume of a surface and of triangles that close it, by the divergence theorem from the middle of the
    /// box; 0 where there is next to none.
    fn enclosed_by<'a>(
        &self,
        scene: &Scene,
        panes: impl Iterator<Item = &'a [[f32; 3]; 3]>,
    ) -> f64 {
        let (low, high) = (self.low.as_dvec3(), self.high.as_dvec3());
        let middle: DVec3 = (low + high) * 0.5;
        let panes = panes.map(|pane| pane.map(Vec3::from_array));
        let faces = self.faces.iter().map(|&face| corners(scene, face));
        let six: f64 = faces
            .chain(panes)
            .map(|face| {
                let [a, b, c] = face.map(|corner| corner.as_dvec3() - middle);
                a.dot(b.cross(c))
            })
            .sum();
        let [x, y, z] = (high - low).to_array();
        match six.abs() > 6.0 * LEAST_VOLUME * x * y * z {
            true => six / 6.0,
            false => 0.0,
        }
    }
}
