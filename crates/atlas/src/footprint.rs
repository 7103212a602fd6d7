//! The part of each texel's square that its charts cover, and uniform samples over it.
//!
//! Source of the square-to-triangle map: E. Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.

use crate::SurfacePoint;
use crate::cutter::{Cutter, Weights};
use crate::types::TILE;
use crate::uv::twice_area;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// The footprints of one tile of a page.
#[derive(Debug, Clone)]
pub struct Tile {
    /// Column of its first texel.
    pub x0: u32,
    /// Row of its first texel.
    pub y0: u32,
    /// One entry for each texel that a triangle covers, in row-major order.
    pub footprints: Vec<Footprint>,
    /// The parts that footprints are made of.
    pub pieces: Vec<Piece>,
    /// Instance and triangle of all that has a piece, in order.
    pub triangles: Vec<[u32; 2]>,
}

/// What is covered of one texel.
#[derive(Debug, Clone, PartialEq)]
pub struct Footprint {
    /// Column on the page.
    pub x: u32,
    /// Row on the page.
    pub y: u32,
    /// Covered share of the texel's area, above 0 and at most 1.
    pub coverage: f32,
    /// Its parts in [`Tile::pieces`]; never empty.
    pub pieces: Range<u32>,
}

/// A triangle, or the whole square of a texel, inside one triangle of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Triangle of the instance's mesh.
    pub triangle: u32,
    /// Its place in [`Tile::triangles`].
    pub number: u32,
    /// The piece is the parallelogram over `corners[0]`, `corners[1]`, `corners[2]`, not their triangle.
    pub square: bool,
    /// Barycentric weights in the object's triangle of the piece's three corners.
    pub corners: [DVec3; 3],
    /// Area in texels of this piece and those before it in the footprint.
    pub cumulative: f64,
}

impl Tile {
    /// The parts of a footprint.
    ///
    /// # Panics
    ///
    /// If the footprint is not one of this tile's.
    pub fn pieces_of(&self, footprint: &Footprint) -> &[Piece] {
        &self.pieces[footprint.pieces.start as usize..footprint.pieces.end as usize]
    }

    /// The point of the footprint at `u` of the unit square: uniform over its area in UV for uniform `u`.
    ///
    /// A texel wholly inside one triangle takes `u` as the position in its square. Otherwise `u[0]` chooses a piece
    /// by area and is stretched over it, so that stratified numbers stay stratified.
    ///
    /// # Panics
    ///
    /// If the footprint is not one of this tile's.
    pub fn sample(&self, footprint: &Footprint, u: [f64; 2]) -> SurfacePoint {
        let pieces = self.pieces_of(footprint);
        let (piece, s) = if let [piece] = pieces {
            (piece, u[0])
        } else {
            let target = u[0] * pieces[pieces.len() - 1].cumulative;
            let k = pieces
                .partition_point(|p| p.cumulative <= target)
                .min(pieces.len() - 1);
            let before = if k == 0 {
                0.0
            } else {
                pieces[k - 1].cumulative
            };
            let s = (target - before) / (pieces[k].cumulative - before);
            (&pieces[k], s.clamp(0.0, 1.0))
        };
        let [a, b, c] = piece.corners;
        let [s, t] = if piece.square {
            [s, u[1]]
        } else {
            square_to_triangle([s, u[1]])
        };
        let w = (a + (b - a) * s + (c - a) * t).max(DVec3::ZERO);
        SurfacePoint {
            instance: piece.instance,
            triangle: piece.triangle,
            weights: (w / w.element_sum()).to_array(),
        }
    }

    /// Covered area of a footprint in texels: [`Footprint::coverage`] before it was rounded and limited to 1.
    pub fn area(&self, footprint: &Footprint) -> f64 {
        self.pieces[footprint.pieces.end as usize - 1].cumulative
    }
}

/// Area-preserving map of the unit square to the triangle (0,0), (1,0), (0,1).
fn square_to_triangle([s, t]: [f64; 2]) -> [f64; 2] {
    if t > s {
        [0.5 * s, t - 0.5 * s]
    } else {
        [s - 0.5 * t, 0.5 * t]
    }
}

/// Collects the pieces of one tile, triangle by triangle.
pub(crate) struct Collector {
    cutter: Cutter,
    found: Vec<Found>,
    triangles: Vec<[u32; 2]>,
}

/// A piece not yet sorted to its texel.
struct Found {
    /// Texel of the tile, row-major.
    texel: u16,
    /// Column of the piece's centre: neighbouring `u[0]` choose neighbouring pieces.
    centre: f64,
    /// The piece; `cumulative` holds its own area.
    piece: Piece,
}

impl Collector {
    pub fn new(x0: u32, y0: u32, page_size: u32) -> Collector {
        Collector {
            cutter: Cutter::new(x0, y0, page_size),
            found: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// Clips a triangle (corners in texels of the page) to every texel of the tile that it meets.
    pub fn add(&mut self, instance: u32, triangle: u32, corners: [DVec2; 3]) {
        let found = &mut self.found;
        let (before, number) = (found.len(), self.triangles.len() as u32);
        let everywhere = |_| true;
        self.cutter.cut(corners, everywhere, |part| {
            found.push(Found {
                texel: part.texel,
                centre: part.centre,
                piece: Piece {
                    instance,
                    triangle,
                    number,
                    square: part.square,
                    corners: part.corners,
                    cumulative: part.area,
                },
            });
        });
        if found.len() > before {
            self.triangles.push([instance, triangle]);
        }
    }

    /// The finished tile.
    pub fn finish(self) -> Tile {
        // Sorted by texel in one pass that keeps the order of instances and triangles, then each texel's few by their centres.
        let mut ends = [0u32; (TILE * TILE) as usize + 1];
        for found in &self.found {
            ends[usize::from(found.texel) + 1] += 1;
        }
        for texel in 1..ends.len() {
            ends[texel] += ends[texel - 1];
        }
        let mut order = vec![0u32; self.found.len()];
        for (index, found) in self.found.iter().enumerate() {
            let place = &mut ends[usize::from(found.texel)];
            order[*place as usize] = index as u32;
            *place += 1;
        }
        let mut tile = Tile {
            x0: self.cutter.x0,
            y0: self.cutter.y0,
            footprints: Vec::with_capacity(order.len().min((TILE * TILE) as usize)),
            pieces: Vec::with_capacity(order.len()),
            triangles: self.triangles,
        };
        let mut start = 0;
        for (at, &end) in (0..TILE * TILE).zip(&ends) {
            let texel = &mut order[start as usize..end as usize];
            if texel.is_empty() {
                continue;
            }
            let centre = |&index: &u32| self.found[index as usize].centre;
            // Stable: equal centres keep their order.
            texel.sort_by(|a, b| centre(a).total_cmp(&centre(b)));
            let mut cumulative = 0.0;
            for &index in texel.iter() {
                let piece = self.found[index as usize].piece;
                cumulative += piece.cumulative;
                tile.pieces.push(Piece {
                    cumulative,
                    ..piece
                });
            }
            tile.footprints.push(Footprint {
                x: self.cutter.x0 + at % TILE,
                y: self.cutter.y0 + at / TILE,
                coverage: (cumulative as f32).clamp(f32::MIN_POSITIVE, 1.0),
                pieces: start..end,
            });
            start = end;
        }
        tile
    }
}

/// Weights of a triangle's corners at `p`; `None` where it has no area.
pub(crate) fn barycentric(corners: [DVec2; 3], p: DVec2) -> Option<DVec3> {
    let signed = twice_area(corners);
    (signed != 0.0).then(|| Weights::new(corners, signed).at(p))
}
