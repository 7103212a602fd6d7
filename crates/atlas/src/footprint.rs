//! The part of each texel's square that its charts cover, and uniform samples over it.
//!
//! Source of the square-to-triangle map: E. Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.

use crate::SurfacePoint;
use crate::cover::Wholes;
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
    /// Instance and triangle of all that covers something, in order.
    pub triangles: Vec<[u32; 2]>,
    /// Of triangles that footprints hold whole, their corner weights as functions of the place in the tile.
    pub weights: Vec<Weights>,
    /// What whole footprints hold, footprint by footprint, as places in `triangles` and in `weights`.
    pub held: Vec<u32>,
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
    /// Triangles cover all of it, and it holds them uncut: a point lies in the one whose least weight is the largest
    /// there.
    pub is_whole: bool,
    /// Its parts in [`Tile::pieces`], or if it is whole in [`Tile::held`]; never empty.
    pub parts: Range<u32>,
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
    /// The parts of a footprint; none of a whole one.
    ///
    /// # Panics
    ///
    /// If the footprint is not one of this tile's.
    pub fn pieces_of(&self, footprint: &Footprint) -> &[Piece] {
        match footprint.is_whole {
            true => &[],
            false => &self.pieces[footprint.parts.start as usize..footprint.parts.end as usize],
        }
    }

    /// The triangles that a whole footprint holds, as places in [`Tile::triangles`]; none of another.
    ///
    /// # Panics
    ///
    /// If the footprint is not one of this tile's.
    pub fn held_of(&self, footprint: &Footprint) -> &[u32] {
        match footprint.is_whole {
            true => &self.held[footprint.parts.start as usize..footprint.parts.end as usize],
            false => &[],
        }
    }

    /// The triangles of a footprint, as places in [`Tile::triangles`], each with its corner weights amid its part; of a
    /// whole footprint amid the texel, where they may be negative.
    pub(crate) fn middles(&self, footprint: &Footprint) -> impl Iterator<Item = (u32, DVec3)> {
        let amid = DVec2::new(
            f64::from(footprint.x - self.x0) + 0.5,
            f64::from(footprint.y - self.y0) + 0.5,
        );
        let held = self.held_of(footprint).iter();
        let held = held.map(move |&number| (number, self.weights[number as usize].at(amid)));
        let pieces = self.pieces_of(footprint).iter();
        let pieces = pieces.map(|piece| (piece.number, piece.corners.iter().sum::<DVec3>() / 3.0));
        held.chain(pieces)
    }

    /// The point of the footprint at `u` of the unit square: uniform over its area in UV for uniform `u`.
    ///
    /// A whole footprint takes `u` as the position in its square. Otherwise `u[0]` chooses a piece by area and is
    /// stretched over it, so that stratified numbers stay stratified.
    ///
    /// # Panics
    ///
    /// If the footprint is not one of this tile's.
    pub fn sample(&self, footprint: &Footprint, u: [f64; 2]) -> SurfacePoint {
        let ([instance, triangle], w) = match footprint.is_whole {
            true => self.holding(footprint, u),
            false => self.piece_at(footprint, u),
        };
        let w = w.max(DVec3::ZERO);
        SurfacePoint {
            instance,
            triangle,
            weights: (w / w.element_sum()).to_array(),
        }
    }

    /// The triangle of a whole footprint that holds a point of its square, and the weights there.
    fn holding(&self, footprint: &Footprint, u: [f64; 2]) -> ([u32; 2], DVec3) {
        let corner = [footprint.x - self.x0, footprint.y - self.y0].map(f64::from);
        let at = DVec2::from(corner) + DVec2::from(u);
        let weights = |&number: &u32| (number as usize, self.weights[number as usize].at(at));
        let all = self.held_of(footprint).iter().map(weights);
        let best = all.reduce(|a, b| match b.1.min_element() > a.1.min_element() {
            true => b,
            false => a,
        });
        let (number, weights) = best.unwrap_or_else(|| unreachable!("a footprint is never empty"));
        (self.triangles[number], weights)
    }

    /// The triangle of the piece that the first number chooses, and the weights at the place in it.
    fn piece_at(&self, footprint: &Footprint, u: [f64; 2]) -> ([u32; 2], DVec3) {
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
        let w = a + (b - a) * s + (c - a) * t;
        ([piece.instance, piece.triangle], w)
    }

    /// Covered area of a footprint in texels: [`Footprint::coverage`] before it was rounded and limited to 1.
    pub fn area(&self, footprint: &Footprint) -> f64 {
        self.pieces_of(footprint)
            .last()
            .map_or(1.0, |last| last.cumulative)
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
    tile: Tile,
    wholes: Wholes,
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
    /// Of a tile, by its first texel and the page's edge, some texels of which are held whole, for so many triangles.
    pub fn new([x0, y0, page_size]: [u32; 3], wholes: Wholes, triangles: usize) -> Collector {
        let held = if wholes.total() > 0 { triangles } else { 0 };
        let tile = Tile {
            x0,
            y0,
            footprints: Vec::with_capacity((TILE * TILE) as usize),
            pieces: Vec::new(),
            triangles: Vec::with_capacity(triangles),
            weights: Vec::with_capacity(held),
            held: vec![0; wholes.total()],
        };
        Collector {
            cutter: Cutter::new(x0, y0, page_size),
            found: Vec::new(),
            tile,
            wholes,
        }
    }

    /// Clips the next triangle (corners in texels of the page) to every texel of the tile that it meets and that is not
    /// whole.
    pub fn add(&mut self, [instance, triangle]: [u32; 2], corners: [DVec2; 3]) {
        let Collector {
            cutter,
            found,
            tile,
            wholes,
        } = self;
        let (before, number) = (found.len(), tile.triangles.len() as u32);
        let met = wholes.place(number, &mut tile.held);
        if met.is_cut {
            let wanted = |texel: u16| wholes.held(texel).is_none();
            cutter.cut(corners, wanted, |part| {
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
        }
        if !met.is_held && found.len() == before {
            return;
        }
        tile.triangles.push([instance, triangle]);
        if wholes.total() > 0 {
            let origin = DVec2::new(tile.x0.into(), tile.y0.into());
            let local = corners.map(|corner| corner - origin);
            tile.weights.push(Weights::new(local, twice_area(local)));
        }
    }

    /// The finished tile.
    pub fn finish(self) -> Tile {
        let Collector {
            found,
            mut tile,
            wholes,
            ..
        } = self;
        // Sorted by texel in one pass that keeps the order of instances and triangles, then each texel's few by their
        // centres.
        let mut ends = [0u32; (TILE * TILE) as usize + 1];
        for found in &found {
            ends[usize::from(found.texel) + 1] += 1;
        }
        for texel in 1..ends.len() {
            ends[texel] += ends[texel - 1];
        }
        let mut order = vec![0u32; found.len()];
        for (index, found) in found.iter().enumerate() {
            let place = &mut ends[usize::from(found.texel)];
            order[*place as usize] = index as u32;
            *place += 1;
        }
        tile.pieces.reserve(order.len());
        let mut start = 0;
        for (at, &end) in (0..TILE * TILE).zip(&ends) {
            let mut add = |is_whole, coverage, parts| {
                tile.footprints.push(Footprint {
                    x: tile.x0 + at % TILE,
                    y: tile.y0 + at / TILE,
                    coverage,
                    is_whole,
                    parts,
                });
            };
            if let Some(held) = wholes.held(at as u16) {
                add(true, 1.0, held);
                continue;
            }
            let texel = &mut order[start as usize..end as usize];
            if texel.is_empty() {
                continue;
            }
            let centre = |&index: &u32| found[index as usize].centre;
            // Stable: equal centres keep their order.
            texel.sort_by(|a, b| centre(a).total_cmp(&centre(b)));
            let mut cumulative = 0.0;
            for &index in texel.iter() {
                let piece = found[index as usize].piece;
                cumulative += piece.cumulative;
                tile.pieces.push(Piece {
                    cumulative,
                    ..piece
                });
            }
            let coverage = (cumulative as f32).clamp(f32::MIN_POSITIVE, 1.0);
            add(false, coverage, start..end);
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
