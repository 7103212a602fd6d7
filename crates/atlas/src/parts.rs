//! What of a mesh is a chart as it lies, what is handed to the unwrapper, and with which coordinates of ours.

use crate::doubled::layers;
use crate::flat::{Face, Faces};
use crate::flatten::{self, Piece, Welded};
use crate::told::OfMesh;
use glam::{DVec2, DVec3, Vec3};
use scene::{Mesh, around};
use std::collections::{BTreeMap, HashMap};
use std::hash::Hash;
use uvunwrap::MeshInput;

/// Height fields from so many triangles on are not flattened but seen from above.
const MANY: usize = 20_000;
/// Of other meshes from so many triangles on we flatten the large pieces. The unwrapper's solver takes ten times as
/// long.
const CURVED: usize = 500;
/// Cosine of the steepest slope of a height field: 60 degrees, where a texel is twice as long as wide.
const STEEPEST: f64 = 0.5;

/// Some triangles of a mesh, which share no chart with the others.
pub(crate) struct Part {
    /// Of the mesh.
    pub triangles: Vec<u32>,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    /// Flat coordinates that the unwrapper need not find itself.
    flat: Option<Vec<[f32; 2]>>,
    /// The flat face of each triangle, which the unwrapper leaves whole.
    faces: Vec<u32>,
}

impl Part {
    pub fn input(&self) -> MeshInput<'_> {
        MeshInput {
            existing_uvs: self.flat.as_deref(),
            polygons: Some(&self.faces),
            ..MeshInput::new(&self.positions, &self.indices)
        }
    }

    /// The corners of its triangle of this number.
    pub fn corners(&self, number: usize) -> [DVec3; 3] {
        let corner = |k: usize| Vec3::from(self.positions[self.indices[3 * number + k] as usize]);
        [0, 1, 2].map(|k| corner(k).as_dvec3())
    }

    pub fn area(&self) -> f64 {
        let areas = (0..self.triangles.len()).map(|number| {
            let [a, b, c] = self.corners(number);
            0.5 * (b - a).cross(c - a).length()
        });
        areas.sum()
    }

    /// Some of its triangles, by their numbers, as a part about 1 in size, and how large its unit is.
    pub fn some(&self, numbers: &[usize]) -> (Self, f64) {
        let corners = || numbers.iter().flat_map(|&number| self.corners(number));
        let (low, high) = around(corners());
        let size = (high - low).max_element();
        let mut places = HashMap::new();
        let mut positions = Vec::new();
        let mut indices = Vec::with_capacity(3 * numbers.len());
        for (k, at) in (numbers.iter().flat_map(|&n| 3 * n..3 * n + 3)).zip(corners()) {
            let place = *places
                .entry(self.indices[k])
                .or_insert(positions.len() as u32);
            if place as usize == positions.len() {
                positions.push(((at - low) / size - 0.5).as_vec3().to_array());
            }
            indices.push(place);
        }
        let part = Self {
            triangles: numbers.iter().map(|&n| self.triangles[n]).collect(),
            positions,
            indices,
            flat: None,
            faces: numbers.iter().map(|&n| self.faces[n]).collect(),
        };
        (part, size)
    }

    /// Its flat faces as they lie.
    pub fn faces(&self) -> Vec<Face> {
        let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (number, &face) in self.faces.iter().enumerate() {
            members.entry(face).or_default().push(number);
        }
        let face = |numbers: Vec<usize>| {
            let normals = numbers.iter().map(|&number| {
                let [a, b, c] = self.corners(number);
                (b - a).cross(c - a)
            });
            let normal = normals.sum::<DVec3>().try_normalize().unwrap_or(DVec3::Z);
            let (u, v) = normal.any_orthonormal_pair();
            let flat = |p: DVec3| DVec2::new(p.dot(u), p.dot(v));
            Face {
                triangles: numbers.iter().map(|&n| self.triangles[n]).collect(),
                places: numbers.iter().map(|&n| self.corners(n).map(flat)).collect(),
            }
        };
        members.into_values().map(face).collect()
    }

    fn of(piece: Piece, surface: &Welded, faces: &[u32]) -> Self {
        let corner = |&c: &u32| surface.corners[c as usize].as_vec3().to_array();
        Self {
            faces: piece.triangles.iter().map(|&t| faces[t as usize]).collect(),
            triangles: piece.triangles,
            positions: piece.corners.iter().map(corner).collect(),
            indices: piece.local.into_iter().flatten().collect(),
            flat: Some(piece.flat),
        }
    }
}

/// The faces of a mesh that are charts as they lie, and the parts of the rest. Its corners are at `positions`, about 1
/// in size.
pub(crate) fn parts(
    mesh: &Mesh,
    positions: &[[f32; 3]],
    told: &OfMesh<'_>,
) -> (Vec<Face>, Vec<Part>) {
    let place = firsts(positions.iter().map(|p| bits(*p)));
    let triangles: Vec<[u32; 3]> = by(mesh, &place);
    let layers = layers(&triangles);
    if let [_] = layers[..] {
        return parts_of(mesh, positions, told);
    }
    let (mut faces, mut parts) = (Vec::new(), Vec::new());
    for layer in layers {
        let own = layer.iter().map(|&t| mesh.triangles[t as usize]);
        let alone = Mesh {
            triangles: own.collect(),
            ..mesh.clone()
        };
        let (mut of_faces, mut of_parts) = parts_of(&alone, positions, told);
        let lists = of_faces.iter_mut().map(|face| &mut face.triangles);
        let lists = lists.chain(of_parts.iter_mut().map(|part| &mut part.triangles));
        lists.for_each(|list| list.iter_mut().for_each(|t| *t = layer[*t as usize]));
        faces.extend(of_faces);
        parts.extend(of_parts);
    }
    (faces, parts)
}

/// The same of a mesh of which no triangle lies on another.
fn parts_of(mesh: &Mesh, positions: &[[f32; 3]], told: &OfMesh<'_>) -> (Vec<Face>, Vec<Part>) {
    let welded = weld(mesh, positions);
    let part = |triangles: Vec<u32>, faces: &[u32]| {
        let corners = triangles.iter().flat_map(|&t| mesh.triangles[t as usize]);
        Part {
            indices: corners.map(|v| welded[v as usize]).collect(),
            positions: positions.to_vec(),
            faces: triangles.iter().map(|&t| faces[t as usize]).collect(),
            triangles,
            flat: None,
        }
    };
    let all = 0..mesh.triangles.len() as u32;
    let alone = |flat: &Vec<[f32; 2]>| !flatten::overlaps(&mesh.triangles, flat);
    if let Some(flat) = projection(&mesh.triangles, positions).filter(alone) {
        let each: Vec<u32> = all.clone().collect();
        let part = Part {
            flat: Some(flat),
            ..part(each.clone(), &each)
        };
        return (Vec::new(), vec![part]);
    }
    let surface = surface(mesh, positions, &welded);
    let faces = Faces::of(&surface);
    let mut left: Vec<bool> = vec![true; mesh.triangles.len()];
    for &t in faces.loose.iter().flat_map(|face| &face.triangles) {
        left[t as usize] = false;
    }
    let mut parts = Vec::new();
    if left.iter().filter(|left| **left).count() >= CURVED {
        let pieces = flatten::flatten(&surface, &faces.of, &left, told);
        for &t in pieces.iter().flat_map(|piece| &piece.triangles) {
            left[t as usize] = false;
        }
        let part = |piece| Part::of(piece, &surface, &faces.of);
        parts = pieces.into_iter().map(part).collect();
    }
    let rest: Vec<u32> = all.filter(|&t| left[t as usize]).collect();
    if !rest.is_empty() {
        parts.push(part(rest, &faces.of));
    }
    (faces.loose, parts)
}

fn surface(mesh: &Mesh, positions: &[[f32; 3]], welded: &[u32]) -> Welded {
    let place = firsts(positions.iter().map(|p| bits(*p)));
    let corners = positions.iter().map(|p| Vec3::from(*p).as_dvec3());
    Welded::new(corners.collect(), by(mesh, &place), &by(mesh, welded))
}

/// The corners of a mesh's triangles by the numbers of its vertices.
fn by(mesh: &Mesh, numbers: &[u32]) -> Vec<[u32; 3]> {
    let triangles = mesh.triangles.iter();
    triangles.map(|t| t.map(|v| numbers[v as usize])).collect()
}

fn bits(v: [f32; 3]) -> [u32; 3] {
    v.map(|x| (x + 0.0).to_bits())
}

/// For each vertex the first one at its place with its normal: the seams of textures are no borders of charts, hard
/// edges are.
pub(crate) fn weld(mesh: &Mesh, positions: &[[f32; 3]]) -> Vec<u32> {
    firsts((0..positions.len()).map(|v| {
        let normal = mesh.normals.get(v).map_or([0.0; 3], |n| n.to_array());
        (bits(positions[v]), bits(normal))
    }))
}

/// For each key the number of the first that equals it.
fn firsts<K: Eq + Hash>(keys: impl Iterator<Item = K>) -> Vec<u32> {
    let mut first = HashMap::with_capacity(keys.size_hint().0);
    keys.zip(0..)
        .map(|(key, number)| *first.entry(key).or_insert(number))
        .collect()
}

/// The view along its mean normal of a mesh that is all seen from there: a height field needs no flattening, which
/// takes seconds from some ten thousand triangles on.
///
/// Lengths along a slope shrink by its cosine, at least [`STEEPEST`], as in every lightmap of a terrain. `None` for a
/// smaller mesh and for one of another shape.
fn projection(triangles: &[[u32; 3]], positions: &[[f32; 3]]) -> Option<Vec<[f32; 2]>> {
    if triangles.len() < MANY {
        return None;
    }
    let at = |v: u32| Vec3::from(positions[v as usize]).as_dvec3();
    let cross = |t: &[u32; 3]| {
        let [a, b, c] = t.map(at);
        (b - a).cross(c - a)
    };
    let axis = triangles
        .iter()
        .map(cross)
        .sum::<DVec3>()
        .normalize_or_zero();
    let steep = |t: &[u32; 3]| {
        let normal = cross(t);
        normal.dot(axis) < STEEPEST * normal.length()
    };
    if axis == DVec3::ZERO || triangles.iter().any(steep) {
        return None;
    }
    let (u, v) = axis.any_orthonormal_pair();
    let flat = |p: &[f32; 3]| {
        let p = Vec3::from(*p).as_dvec3();
        [p.dot(u) as f32, p.dot(v) as f32]
    };
    Some(positions.iter().map(flat).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_height_field_is_seen_along_its_mean_normal() {
        const EDGE: u32 = 101;
        let point = |i: u32| {
            let (x, y) = ((i % EDGE) as f32 / 100.0, (i / EDGE) as f32 / 100.0);
            [x, 0.2 * (3.0 * x).sin() * y, -y]
        };
        let positions: Vec<[f32; 3]> = (0..EDGE * EDGE).map(point).collect();
        let cells = (0..EDGE - 1).flat_map(|y| (0..EDGE - 1).map(move |x| y * EDGE + x));
        let quad = |i: u32| {
            let next = i + EDGE;
            [[i, i + 1, next], [i + 1, next + 1, next]]
        };
        let triangles: Vec<[u32; 3]> = cells.flat_map(quad).collect();
        assert_eq!(triangles.len(), MANY);
        let flat = projection(&triangles, &positions).expect("a height field");
        // Lengths across the view are kept, so none is longer than on the surface.
        for t in &triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2])] {
                let [p, q] = [a, b].map(|v| Vec3::from(positions[v as usize]));
                let [from, to] = [a, b].map(|v| glam::Vec2::from(flat[v as usize]));
                assert!(from.distance(to) <= 1.001 * p.distance(q));
            }
        }
        assert!(
            projection(&triangles[1..], &positions).is_none(),
            "too small"
        );
        let mut fold = positions;
        fold[EDGE as usize + 1][0] += 0.05;
        assert!(
            projection(&triangles, &fold).is_none(),
            "a triangle overhangs"
        );
    }
}
