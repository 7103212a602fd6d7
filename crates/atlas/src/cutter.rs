//! Cuts triangles into their parts in the texels of a tile.

use crate::clip::{Polygon, share};
use crate::types::TILE;
use crate::uv::twice_area;
use glam::{DVec2, DVec3};
use std::cell::Cell;
use std::ops::Range;

/// Cuts triangles along the borders of a tile's texels.
pub(crate) struct Cutter {
    /// Column and row of the tile's first texel.
    pub x0: u32,
    pub y0: u32,
    /// Texels beyond the page's edge are left out.
    width: u32,
    height: u32,
    /// What is left of a triangle and of a row of it, the part that is cut off, and where what is left is put.
    scratch: [Polygon; 4],
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

/// A texel counts as lying in a triangle that leaves less than this of it uncovered, in texels: far above the rounding
/// of its corners.
const SLACK: f64 = 1e-10;

/// Twice the area from which on a triangle within one texel is told from the texel itself beyond any rounding.
const PLAIN: f64 = 1e-6;

impl Cutter {
    pub fn new(x0: u32, y0: u32, page_size: u32) -> Self {
        Self {
            x0,
            y0,
            width: TILE.min(page_size - x0),
            height: TILE.min(page_size - y0),
            scratch: [const { Polygon::EMPTY }; 4],
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
        let (low, high) = (p[0].min(p[1]).min(p[2]), p[0].max(p[1]).max(p[2]));
        let first = low.floor();
        if low.cmpge(DVec2::ZERO).all()
            && high.cmpgt(first).all()
            && high.cmple(first + 1.0).all()
            && signed.abs() > PLAIN
        {
            // Nothing is cut off.
            let [x, y] = [first.x as u32, first.y as u32];
            let texel = (y * TILE + x) as u16;
            if x < self.width && y < self.height && wanted(texel) {
                found(Part {
                    texel,
                    centre: (p[0].x + p[1].x + p[2].x) / 3.0,
                    square: false,
                    corners: [DVec3::X, DVec3::Y, DVec3::Z],
                    area,
                });
            }
            return;
        }
        let [mut left, mut row, part, mut next] = self.scratch.each_mut();
        *left = Polygon::triangle(p);
        let plane = Weights::new(p, signed);
        let columns = cells(low.x, high.x, self.width);
        for y in cells(low.y, high.y, self.height) {
            let texel = |x: u32| (y * TILE + x) as u16;
            if !columns.clone().any(|x| wanted(texel(x))) {
                continue;
            }
            slice::<1>(&mut left, y, row, &mut next);
            let (start, end) = row.range(0);
            let whole = plane.squares(y);
            for x in cells(start, end, self.width) {
                let texel = texel(x);
                if !wanted(texel) {
                    continue;
                }
                if whole.contains(&x) {
                    let corner = DVec2::new(f64::from(x), f64::from(y));
                    found(Part {
                        texel,
                        centre: corner.x + 0.5,
                        square: true,
                        corners: plane.square(corner),
                        area: 1.0,
                    });
                    continue;
                }
                slice::<0>(&mut row, x, part, &mut next);
                let c = part.corners();
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

/// Takes the part of a polygon between a whole number and the next off it, and what lies before; the rest is left.
fn slice<'p, const AXIS: usize>(
    polygon: &mut &'p mut Polygon,
    at: u32,
    part: &mut Polygon,
    next: &mut &'p mut Polygon,
) {
    let low = f64::from(at);
    if polygon.range(AXIS).0 < low {
        polygon.split(AXIS, low, part, next);
        std::mem::swap(polygon, next);
    }
    polygon.split(AXIS, low + 1.0, part, next);
    std::mem::swap(polygon, next);
}

/// How many texels of a tile triangles cover, without their pieces: a texel that is covered once, or is `known` to be,
/// is not cut again.
pub(crate) fn covered(
    mut cutter: Cutter,
    known: impl Fn(u16) -> bool,
    triangles: impl Iterator<Item = [DVec2; 3]>,
) -> u64 {
    let seen: [Cell<bool>; (TILE * TILE) as usize] =
        std::array::from_fn(|texel| Cell::new(known(texel as u16)));
    let origin = DVec2::new(f64::from(cutter.x0), f64::from(cutter.y0));
    let size = DVec2::new(f64::from(cutter.width), f64::from(cutter.height));
    for corners in triangles {
        let wanted = |texel: u16| !seen[usize::from(texel)].get();
        let [a, b, c] = corners.map(|c| c - origin);
        let low = a.min(b).min(c).clamp(DVec2::ZERO, size);
        let high = a.max(b).max(c).clamp(DVec2::ZERO, size);
        let columns = cells(low.x, high.x, cutter.width);
        let mut rows = cells(low.y, high.y, cutter.height);
        if rows.any(|y| columns.clone().any(|x| wanted((y * TILE + x) as u16))) {
            cutter.cut(corners, wanted, |part| {
                seen[usize::from(part.texel)].set(true)
            });
        }
    }
    seen.iter().filter(|seen| seen.get()).count() as u64
}

/// Cells of a row of `count` that an interval meets; none for the range of an empty polygon.
fn cells(low: f64, high: f64, count: u32) -> Range<u32> {
    if low <= high {
        // A needle may have rounded to no width.
        let first = low.floor() as u32;
        first..(high.ceil() as u32).max(first + 1).min(count)
    } else {
        0..0
    }
}

/// Barycentric weights as affine functions of the position, in texels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    origin: DVec2,
    du: DVec3,
    dv: DVec3,
}

impl Weights {
    pub(crate) fn new([a, b, c]: [DVec2; 3], twice_area: f64) -> Weights {
        let scale = 1.0 / twice_area;
        let slope = |from: DVec2, to: DVec2| (to - from).perp() * scale;
        let (w0, w1, w2) = (slope(b, c), slope(c, a), slope(a, b));
        Weights {
            origin: a,
            du: DVec3::new(w0.x, w1.x, w2.x),
            dv: DVec3::new(w0.y, w1.y, w2.y),
        }
    }

    /// At a place.
    pub fn at(&self, p: DVec2) -> DVec3 {
        let d = p - self.origin;
        DVec3::X + self.du * d.x + self.dv * d.y
    }

    /// Weights at the upper left, upper right and lower left corner of the unit square at `p`.
    fn square(&self, p: DVec2) -> [DVec3; 3] {
        [self.at(p), self.at(p + DVec2::X), self.at(p + DVec2::Y)]
    }

    /// The columns of a row of unit squares that lie in the triangle but for [`SLACK`].
    fn squares(&self, row: u32) -> Range<u32> {
        let (mut first, mut last) = (0.0f64, f64::from(TILE));
        for k in 0..3 {
            let (du, dv) = (self.du[k], self.dv[k]);
            // The weight where it is least in the square of column 0.
            let corner = DVec2::new(f64::from(du < 0.0), f64::from(row) + f64::from(dv < 0.0));
            let least = self.at(corner)[k];
            let border = -least / du;
            if du > 0.0 {
                first = first.max(border - SLACK);
            } else if du < 0.0 {
                last = last.min(border + SLACK + 1.0);
            } else if least < 0.0 {
                return 0..0;
            }
        }
        first.ceil() as u32..last.max(0.0).floor() as u32
    }
}
