//! Cuts triangles into their parts in the texels of a tile.

use crate::clip::{Polygon, share};
use crate::types::TILE;
use crate::uv::twice_area;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// Cuts triangles along the borders of a tile's texels.
pub(crate) struct Cutter {
    /// Column and row of the tile's first texel.
    pub x0: u32,
    pub y0: u32,
    /// Texels beyond the page's edge are left out.
    width: u32,
    height: u32,
    /// Where triangles are cut: to the tile along both axes, to a row, to a texel.
    scratch: [[Polygon; 2]; 4],
}

/// The part of a triangle in a texel, or one triangle of it.
pub(crate) struct Part {
    /// Texel of the tile, row-major.
    pub texel: u16,
    /// Column of the part's centre.
    pub centre: f64,
    /// The texel's whole square.
    pub square: bool,
    /// Weights of the triangle's corners at three corners of the part.
    pub corners: [DVec3; 3],
    /// In texels.
    pub area: f64,
}

/// A part below this share of its triangle is the rounding of a clip along a texel's border, not a part: without it an
/// edge that runs on the border would leave texels beyond it that see only the edge. The rest of the triangle stands.
const SLIVER: f64 = 1e-14;

impl Cutter {
    pub fn new(x0: u32, y0: u32, page_size: u32) -> Self {
        Self {
            x0,
            y0,
            width: TILE.min(page_size - x0),
            height: TILE.min(page_size - y0),
            scratch: [const { [Polygon::EMPTY; 2] }; 4],
        }
    }

    /// Cuts a triangle (corners in texels of the page) to the texels of the tile that it meets and that are `wanted`.
    pub fn cut(
        &mut self,
        corners: [DVec2; 3],
        wanted: impl Fn(u16) -> bool,
        mut found: impl FnMut(Part),
    ) {
        let signed = twice_area(corners);
        if signed == 0.0 {
            return;
        }
        let area = 0.5 * signed.abs();
        let origin = DVec2::new(f64::from(self.x0), f64::from(self.y0));
        let p = corners.map(|c| c - origin);
        let [tall, wide, strip, square] = &mut self.scratch;
        let whole = Polygon::triangle(p);
        let part = whole.between(1, 0.0, f64::from(self.height), tall).between(
            0,
            0.0,
            f64::from(self.width),
            wide,
        );
        let plane = Weights::new(p, signed);
        let (top, bottom) = part.range(1);
        for y in cells(top, bottom, self.height) {
            let row = part.between(1, f64::from(y), f64::from(y + 1), strip);
            let (left, right) = row.range(0);
            for x in cells(left, right, self.width) {
                let texel = (y * TILE + x) as u16;
                if !wanted(texel) {
                    continue;
                }
                let corner = DVec2::new(f64::from(x), f64::from(y));
                let corners = plane.square(corner);
                if plane.holds_square(corners) {
                    found(Part {
                        texel,
                        centre: corner.x + 0.5,
                        square: true,
                        corners,
                        area: 1.0,
                    });
                    continue;
                }
                let cell = row.between(0, f64::from(x), f64::from(x + 1), square);
                let c = cell.corners();
                for k in 2..c.len() {
                    let corners = [c[0].w, c[k - 1].w, c[k].w];
                    let part = share(c[0].w, c[k - 1].w, c[k].w);
                    if part > SLIVER && area * part > 0.0 {
                        found(Part {
                            texel,
                            centre: (c[0].p.x + c[k - 1].p.x + c[k].p.x) / 3.0,
                            square: false,
                            corners,
                            area: area * part,
                        });
                    }
                }
            }
        }
    }
}

/// How many texels of a tile triangles cover, without their pieces: a texel that is covered once is not cut again.
pub(crate) fn covered(mut cutter: Cutter, triangles: impl Iterator<Item = [DVec2; 3]>) -> u64 {
    let seen = [const { std::cell::Cell::new(false) }; (TILE * TILE) as usize];
    for corners in triangles {
        let wanted = |texel: u16| !seen[usize::from(texel)].get();
        cutter.cut(corners, wanted, |part| {
            seen[usize::from(part.texel)].set(true)
        });
    }
    seen.iter().filter(|seen| seen.get()).count() as u64
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

/// Barycentric weights as affine functions of the position.
pub(crate) struct Weights {
    origin: DVec2,
    du: DVec3,
    dv: DVec3,
}

impl Weights {
    pub fn new([a, b, c]: [DVec2; 3], twice_area: f64) -> Weights {
        let slope =
            |from: DVec2, to: DVec2| DVec2::new(-(to.y - from.y), to.x - from.x) / twice_area;
        let (w0, w1, w2) = (slope(b, c), slope(c, a), slope(a, b));
        Weights {
            origin: a,
            du: DVec3::new(w0.x, w1.x, w2.x),
            dv: DVec3::new(w0.y, w1.y, w2.y),
        }
    }

    pub fn at(&self, p: DVec2) -> DVec3 {
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
