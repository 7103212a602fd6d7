//! Large smooth surfaces laid flat: cut into pieces (`pieces.rs`), each seen from its own side and relaxed (`rigid.rs`,
//! by the solver of `cholesky.rs`), and checked (`overlap.rs`). Small pieces and what fails here are left to the
//! unwrapper.

mod cholesky;
pub(crate) mod overlap;
mod pieces;
mod rigid;

use crate::told::OfMesh;
use glam::{DVec2, DVec3};
pub(crate) use pieces::{NONE, Welded};
use rayon::prelude::*;
use std::collections::{HashMap, VecDeque};

/// Pieces of fewer triangles are left to the unwrapper, which then takes milliseconds.
const LEAST: usize = 100;
/// Pieces have about so many triangles at most: the solver takes more than linear time.
const SOLVABLE: f64 = 100_000.0;
/// A piece is cut in two where more than this share of its area is turned over, or larger or smaller than it should be
/// by more than [`STRETCH`].
const SPOILT: f64 = 0.02;
const STRETCH: f64 = 4.0;
/// Smaller triangles than this share of the piece have no area once coordinates are rounded to 32 bits.
const FLAT: f64 = 1e-11;

/// A piece in its plane.
pub(crate) struct Piece {
    /// Of the surface.
    pub triangles: Vec<u32>,
    /// Corners of the surface, and the triangles between them.
    pub corners: Vec<u32>,
    pub local: Vec<[u32; 3]>,
    /// Places of the corners, from 0 to 1 along the longer side.
    pub flat: Vec<[f32; 2]>,
}

/// True where triangles cover a place twice.
pub(crate) fn overlaps(triangles: &[[u32; 3]], flat: &[[f32; 2]]) -> bool {
    let at = |v: u32| glam::Vec2::from(flat[v as usize]).as_dvec2();
    let places: Vec<[DVec2; 3]> = triangles.iter().map(|t| t.map(at)).collect();
    !overlap::overlaps(&places, 1).is_empty()
}

/// The pieces that could be flattened; the other triangles of the surface are in none. Empty when cancelled.
///
/// * `faces`: the flat face of each triangle; no piece ends inside of one.
/// * `left`: the triangles that pieces may have.
pub(crate) fn flatten(
    surface: &Welded,
    faces: &[u32],
    left: &[bool],
    told: &OfMesh<'_>,
) -> Vec<Piece> {
    let count = surface.triangles.len() as f64;
    let most = match count > SOLVABLE {
        true => surface.areas.iter().sum::<f64>() * SOLVABLE / count,
        false => f64::INFINITY,
    };
    let pieces = surface.pieces(faces, left, LEAST, most);
    pieces
        .into_par_iter()
        .with_max_len(1)
        .flat_map_iter(|piece| {
            let mut done = Vec::new();
            let mut waiting = vec![piece];
            while let Some(piece) = waiting.pop() {
                if piece.len() < LEAST || told.cancelled() {
                    continue;
                }
                match Piece::new(surface, faces, piece) {
                    Ok(piece) => {
                        told.done(piece.triangles.len());
                        done.push(piece);
                    }
                    Err(halves) => waiting.extend(halves),
                }
            }
            done
        })
        .collect()
}

impl Piece {
    /// The piece laid flat without the few triangles that spoil it, or its halves where it cannot be.
    fn new(surface: &Welded, faces: &[u32], triangles: Vec<u32>) -> Result<Self, [Vec<u32>; 2]> {
        let mut piece = Self::seen_along_its_normal(surface, triangles);
        let areas = |piece: &Self, t: usize| {
            let [a, b, c] = piece.places(t);
            (
                0.5 * (b - a).perp_dot(c - a),
                surface.areas[piece.triangles[t] as usize],
            )
        };
        let all = || (0..piece.local.len()).map(|t| areas(&piece, t));
        let (flat, solid) = all().fold((0.0, 0.0), |(f, s), (a, b)| (f + a, s + b));
        let scale = solid / flat;
        let spoilt = |(a, b): &(f64, f64)| !(a * scale * STRETCH >= *b && a * scale <= STRETCH * b);
        let share = all().filter(spoilt).map(|(_, b)| b).sum::<f64>() / solid;
        if !(flat > 0.0 && share <= SPOILT) {
            return Err(halves(surface, faces, &piece.triangles, None));
        }
        let kept: Vec<bool> = all().map(|(a, _)| a > FLAT * flat).collect();
        piece.keep(&kept);
        let places: Vec<[DVec2; 3]> = (0..piece.local.len()).map(|t| piece.places(t)).collect();
        let pairs = overlap::overlaps(&places, places.len() / 4);
        let pair = |pair: &[usize; 2]| pair.map(|t| piece.triangles[t]);
        if let Some(apart) = pairs.iter().map(pair).find(|p| !surface.are_near(*p)) {
            return Err(halves(surface, faces, &piece.triangles, Some(apart)));
        }
        // Of two neighbours at one place the smaller goes, as long as that is little.
        let area = |t: usize| surface.areas[piece.triangles[t] as usize];
        let mut kept = vec![true; places.len()];
        let mut lost = 0.0;
        for &[a, b] in &pairs {
            if kept[a] && kept[b] {
                let smaller = if area(a) < area(b) { a } else { b };
                kept[smaller] = false;
                lost += area(smaller);
            }
        }
        if lost > SPOILT * solid {
            let middle = pair(&pairs[pairs.len() / 2]);
            return Err(halves(surface, faces, &piece.triangles, Some(middle)));
        }
        piece.keep(&kept);
        Ok(piece)
    }

    fn seen_along_its_normal(surface: &Welded, triangles: Vec<u32>) -> Self {
        let weighted = |&t: &u32| surface.normals[t as usize] * surface.areas[t as usize];
        let axis = triangles.iter().map(weighted).sum::<DVec3>();
        let (u, v) = axis
            .try_normalize()
            .unwrap_or(DVec3::Z)
            .any_orthonormal_pair();
        let mut numbers = HashMap::with_capacity(triangles.len());
        let mut corners = Vec::with_capacity(triangles.len());
        let mut number = |corner: u32| {
            *numbers.entry(corner).or_insert_with(|| {
                corners.push(corner);
                corners.len() as u32 - 1
            })
        };
        let local: Vec<[u32; 3]> = triangles
            .iter()
            .map(|&t| surface.triangles[t as usize].map(&mut number))
            .collect();
        let at: Vec<DVec3> = corners
            .iter()
            .map(|&c| surface.corners[c as usize])
            .collect();
        let mut flat: Vec<DVec2> = at.iter().map(|p| DVec2::new(p.dot(u), p.dot(v))).collect();
        rigid::relax(&at, &local, &mut flat);
        let low = flat.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = flat.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let size = (high - low).max_element();
        let rounded = |p: &DVec2| ((*p - low) / size).as_vec2().to_array();
        Self {
            triangles,
            corners,
            local,
            flat: flat.iter().map(rounded).collect(),
        }
    }

    fn places(&self, t: usize) -> [DVec2; 3] {
        self.local[t].map(|v| glam::Vec2::from(self.flat[v as usize]).as_dvec2())
    }

    fn keep(&mut self, kept: &[bool]) {
        let mut keep = kept.iter();
        self.triangles
            .retain(|_| *keep.next().expect("one a triangle"));
        let mut keep = kept.iter();
        self.local.retain(|_| *keep.next().expect("one a triangle"));
    }
}

/// A piece cut in two: what is nearer to one of two triangles than to the other. Without a pair they are far apart. A
/// flat face goes where its first triangle goes, unless it is all that there is.
fn halves(
    surface: &Welded,
    faces: &[u32],
    triangles: &[u32],
    pair: Option<[u32; 2]>,
) -> [Vec<u32>; 2] {
    let index: HashMap<u32, usize> = triangles.iter().copied().zip(0..).collect();
    // Steps from triangle to triangle; what cannot be reached is as far as can be.
    let steps = |from: usize| {
        let mut steps = vec![NONE; triangles.len()];
        let mut waiting = VecDeque::from([from]);
        steps[from] = 0;
        while let Some(t) = waiting.pop_front() {
            for beside in surface.neighbours[triangles[t] as usize] {
                let Some(&beside) = index.get(&beside) else {
                    continue;
                };
                if steps[beside] == NONE {
                    steps[beside] = steps[t] + 1;
                    waiting.push_back(beside);
                }
            }
        }
        steps
    };
    let farthest = |steps: &[u32]| {
        let reached = (0..steps.len()).filter(|&t| steps[t] != NONE);
        reached.max_by_key(|&t| steps[t]).unwrap_or(0)
    };
    let [first, second] = match pair {
        Some(pair) => pair.map(|t| steps(index[&t])),
        None => {
            let first = steps(farthest(&steps(0)));
            let second = steps(farthest(&first));
            [first, second]
        }
    };
    let nearer = |t: usize| first[t] <= second[t];
    let mut sides = HashMap::new();
    let side = |&t: &usize| {
        *sides
            .entry(faces[triangles[t] as usize])
            .or_insert(nearer(t))
    };
    let mut parted: (Vec<usize>, Vec<usize>) = (0..triangles.len()).partition(side);
    if parted.0.is_empty() || parted.1.is_empty() {
        parted = (0..triangles.len()).partition(|&t| nearer(t));
    }
    let (one, other) = parted;
    if one.is_empty() || other.is_empty() {
        // Both triangles stand alone.
        let (one, other) = triangles.split_at(triangles.len() / 2);
        return [one.to_vec(), other.to_vec()];
    }
    [one, other].map(|half| half.into_iter().map(|t| triangles[t]).collect())
}

#[cfg(test)]
mod tests;
