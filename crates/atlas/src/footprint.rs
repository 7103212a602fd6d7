//! The part of each texel's square that its charts cover, and uniform samples over it.
//!
//! Source of the square-to-triangle map: E. Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.

use crate::SurfacePoint;
use crate::clip::{Polygon, share};
use crate::uv::twice_area;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// Texels on the edge of a tile.
pub const TILE: u32 = 16;

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
    /// The piece is the parallelogram over `corners[0]`, `corners[1]`, `corners[2]`, not their triangle.
    pub square: bool,
    /// Barycentric weights in the object's triangle of the piece's three corners.
    pub corners: [DVec3; 3],
    /// Area in texels of this piece and those before it in the footprint.
    pub cumulative: f64,
}

impl Tile {
    /// The point of the footprint at `u` of the unit square: uniform over its area in UV for uniform `u`.
    ///
    /// A texel wholly inside one triangle takes `u` as the position in its square. Otherwise `u[0]` chooses a piece
    /// by area and is stretched over it, so that stratified numbers stay stratified.
    ///
    /// # Panics
    ///
    /// If the footprint is not one of this tile's.
    pub fn sample(&self, footprint: &Footprint, u: [f64; 2]) -> SurfacePoint {
        let pieces = &self.pieces[footprint.pieces.start as usize..footprint.pieces.end as usize];
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
    x0: u32,
    y0: u32,
    /// Texels beyond the page's edge are left out.
    width: u32,
    height: u32,
    found: Vec<Found>,
}

/// A part below this share of its triangle is the rounding of a clip along a texel's border, not a part: without it an
/// edge that runs on the border would leave texels beyond it that see only the edge. The rest of the triangle stands.
const SLIVER: f64 = 1e-14;

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
            x0,
            y0,
            width: TILE.min(page_size - x0),
            height: TILE.min(page_size - y0),
            found: Vec::new(),
        }
    }

    /// Clips a triangle (corners in texels of the page) to every texel of the tile that it meets.
    pub fn add(&mut self, instance: u32, triangle: u32, corners: [DVec2; 3]) {
        let signed = twice_area(corners);
        if signed == 0.0 {
            return;
        }
        let area = 0.5 * signed.abs();
        let origin = DVec2::new(f64::from(self.x0), f64::from(self.y0));
        let p = corners.map(|c| c - origin);
        let part = Polygon::triangle(p)
            .between(1, 0.0, f64::from(self.height))
            .between(0, 0.0, f64::from(self.width));
        let plane = Weights::new(p, signed);
        let (top, bottom) = part.range(1);
        for y in cells(top, bottom, self.height) {
            let row = part.between(1, f64::from(y), f64::from(y + 1));
            let (left, right) = row.range(0);
            for x in cells(left, right, self.width) {
                let texel = (y * TILE + x) as u16;
                let corner = DVec2::new(f64::from(x), f64::from(y));
                let mut piece = Piece {
                    instance,
                    triangle,
                    square: true,
                    corners: plane.square(corner),
                    cumulative: 1.0,
                };
                if plane.holds_square(piece.corners) {
                    self.found.push(Found {
                        texel,
                        centre: corner.x + 0.5,
                        piece,
                    });
                    continue;
                }
                piece.square = false;
                let cell = row.between(0, f64::from(x), f64::from(x + 1));
                let c = cell.corners();
                for k in 2..c.len() {
                    piece.corners = [c[0].w, c[k - 1].w, c[k].w];
                    let part = share(c[0].w, c[k - 1].w, c[k].w);
                    piece.cumulative = area * part;
                    if part > SLIVER && piece.cumulative > 0.0 {
                        let centre = (c[0].p.x + c[k - 1].p.x + c[k].p.x) / 3.0;
                        self.found.push(Found {
                            texel,
                            centre,
                            piece,
                        });
                    }
                }
            }
        }
    }

    /// The finished tile.
    pub fn finish(mut self) -> Tile {
        // Stable: equal centres keep the order of instances and triangles.
        self.found.sort_by(|a, b| {
            a.texel
                .cmp(&b.texel)
                .then_with(|| a.centre.total_cmp(&b.centre))
        });
        let mut tile = Tile {
            x0: self.x0,
            y0: self.y0,
            footprints: Vec::new(),
            pieces: Vec::with_capacity(self.found.len()),
        };
        for texel in self.found.chunk_by(|a, b| a.texel == b.texel) {
            let start = tile.pieces.len() as u32;
            let mut cumulative = 0.0;
            for found in texel {
                cumulative += found.piece.cumulative;
                tile.pieces.push(Piece {
                    cumulative,
                    ..found.piece
                });
            }
            let at = u32::from(texel[0].texel);
            tile.footprints.push(Footprint {
                x: self.x0 + at % TILE,
                y: self.y0 + at / TILE,
                coverage: (cumulative as f32).clamp(f32::MIN_POSITIVE, 1.0),
                pieces: start..tile.pieces.len() as u32,
            });
        }
        tile
    }
}

/// Cells of a row of `count` that an interval meets; none for the range of an empty polygon.
fn cells(low: f64, high: f64, count: u32) -> Range<u32> {
    if low <= high {
        // Both ends lie in 0..=count: the polygon was cut to the tile. A needle may have rounded to no width.
        let first = low.floor() as u32;
        first..(high.ceil() as u32).max(first + 1).min(count)
    } else {
        0..0
    }
}

/// Weights of a triangle's corners at `p`; `None` where it has no area.
pub(crate) fn barycentric(corners: [DVec2; 3], p: DVec2) -> Option<DVec3> {
    let signed = twice_area(corners);
    (signed != 0.0).then(|| Weights::new(corners, signed).at(p))
}

/// Barycentric weights as affine functions of the position.
struct Weights {
    origin: DVec2,
    du: DVec3,
    dv: DVec3,
}

impl Weights {
    fn new([a, b, c]: [DVec2; 3], twice_area: f64) -> Weights {
        let slope =
            |from: DVec2, to: DVec2| DVec2::new(-(to.y - from.y), to.x - from.x) / twice_area;
        let (w0, w1, w2) = (slope(b, c), slope(c, a), slope(a, b));
        Weights {
            origin: a,
            du: DVec3::new(w0.x, w1.x, w2.x),
            dv: DVec3::new(w0.y, w1.y, w2.y),
        }
    }

    fn at(&self, p: DVec2) -> DVec3 {
        let d = p - self.origin;
        DVec3::X + self.du * d.x + self.dv * d.y
    }

    /// Weights at the upper left, upper right and lower left corner of the unit square at `p`.
    fn square(&self, p: DVec2) -> [DVec3; 3] {
        [self.at(p), self.at(p + DVec2::X), self.at(p + DVec2::Y)]
    }

    /// All four corners of the square lie in the triangle.
    fn holds_square(&self, [a, b, c]: [DVec3; 3]) -> bool {
        let d = b + c - a;
        a.min(b).min(c).min(d).min_element() >= 0.0
    }
}
