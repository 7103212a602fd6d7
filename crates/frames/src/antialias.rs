//! Look-up methods: sections 7.1 and 8 of the 1984 text. The antialiased ones average a table over what a pixel
//! reflects, the quad of the directions at its four corners.

use crate::slices;
use crate::table::Table;

/// How a table is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lookup {
    /// The texel of the direction at the pixel's middle.
    Nearest,
    /// Bilinear interpolation there.
    Bilinear,
    /// Section 8.1: the mean over the corners where they show the same or adjacent texels, else the quad is halved.
    Recursive,
    /// Section 8.2: the mean over the area of the quad in the table, weighted by solid angle.
    Quad,
    /// Section 8.3: the mean over rectangles in the pre-integrated table, at constant cost. The quad is cut to at most
    /// 64 slices, each of which is a rectangle, so that quads of neighbours hold a small light neither twice nor not at
    /// all.
    Summed,
}

impl Lookup {
    /// The word for it on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Lookup::Nearest => "nearest",
            Lookup::Bilinear => "bilinear",
            Lookup::Recursive => "recursive",
            Lookup::Quad => "quad",
            Lookup::Summed => "summed",
        }
    }

    /// True where it averages over the quad of a pixel's corners.
    pub fn needs_corners(self) -> bool {
        !matches!(self, Lookup::Nearest | Lookup::Bilinear)
    }

    /// The value for a pixel whose corners, in a turn, have these directions of unit length.
    pub fn read(self, table: &Table, corners: [[f32; 3]; 4]) -> [f32; 3] {
        self.read_at(table, corners, corners.map(|d| table.place(d)))
    }

    /// The same with the directions' places in the table.
    pub(super) fn read_at(
        self,
        table: &Table,
        corners: [[f32; 3]; 4],
        places: [[f32; 2]; 4],
    ) -> [f32; 3] {
        match self {
            Lookup::Nearest => table.nearest(middle(&corners)),
            Lookup::Bilinear => table.bilinear(middle(&corners)),
            Lookup::Recursive => recursive(table, corners, places, HALVINGS),
            Lookup::Quad => quad(table, corners, places),
            Lookup::Summed => summed(table, places),
        }
    }
}

/// A pixel is halved at most this often; 1/4096 of it is inconsequentially small.
const HALVINGS: u32 = 12;

fn recursive(
    table: &Table,
    corners: [[f32; 3]; 4],
    places: [[f32; 2]; 4],
    halvings: u32,
) -> [f32; 3] {
    if halvings == 0 || adjacent(table, &places) {
        return mean4(corners.map(|d| table.bilinear(d)));
    }
    let [a, b, c, d] = corners;
    let gap = |p: [f32; 3], q: [f32; 3]| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f32>();
    let (first, second) = if gap(a, b) + gap(c, d) >= gap(b, c) + gap(d, a) {
        let (top, low) = (between(a, b), between(d, c));
        ([a, top, low, d], [top, b, c, low])
    } else {
        let (left, right) = (between(a, d), between(b, c));
        ([a, b, right, left], [left, right, c, d])
    };
    let [first, second] = [first, second]
        .map(|half| recursive(table, half, half.map(|d| table.place(d)), halvings - 1));
    std::array::from_fn(|c| 0.5 * (first[c] + second[c]))
}

/// The middle of two directions; of opposite ones the first.
fn between(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    unit(std::array::from_fn(|c| a[c] + b[c])).unwrap_or(a)
}

/// The middle of a quad; the first corner where there is none.
fn middle(corners: &[[f32; 3]; 4]) -> [f32; 3] {
    let sum = std::array::from_fn(|c| corners.iter().map(|d| d[c]).sum());
    unit(sum).unwrap_or(corners[0])
}

fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let length = v.iter().map(|v| v * v).sum::<f32>().sqrt();
    // Below this the sum of unit vectors is rounding.
    (length > 1e-6).then(|| v.map(|v| v / length))
}

fn mean4(values: [[f32; 3]; 4]) -> [f32; 3] {
    std::array::from_fn(|c| 0.25 * (values[0][c] + values[1][c] + values[2][c] + values[3][c]))
}

/// Same or adjacent texels, over the seam too. All texels of a row at a pole touch each other.
fn adjacent(table: &Table, places: &[[f32; 2]; 4]) -> bool {
    let (width, height) = table.size();
    let texels = places.map(|[x, y]| {
        let column = (x as usize).min(width - 1) as i64;
        (column, (y as usize).min(height - 1))
    });
    let pole = |row: usize| row == 0 || row == height - 1;
    texels.iter().enumerate().all(|(k, a)| {
        texels[k + 1..].iter().all(|b| {
            let columns = (a.0 - b.0).rem_euclid(width as i64);
            let columns = columns.min(width as i64 - columns);
            let rows = a.1.abs_diff(b.1);
            rows <= 1 && (columns <= 1 || (rows == 0 && pole(a.1)))
        })
    })
}

/// The corners' places with columns that go on beyond the seam, and what is left at the end of a turn: a width where
/// the quad holds a pole.
fn unwrapped(table: &Table, mut places: [[f32; 2]; 4]) -> ([[f32; 2]; 4], f32) {
    let width = table.size().0 as f32;
    let step = |from: f32, to: f32| {
        let gap = to - from;
        if gap > 0.5 * width {
            gap - width
        } else if gap < -0.5 * width {
            gap + width
        } else {
            gap
        }
    };
    let columns = places.map(|p| p[0]);
    for k in 1..4 {
        places[k][0] = places[k - 1][0] + step(columns[k - 1], columns[k]);
    }
    let rest = places[3][0] + step(columns[3], columns[0]) - columns[0];
    (places, rest)
}

fn summed(table: &Table, places: [[f32; 2]; 4]) -> [f32; 3] {
    let (width, height) = table.size();
    let (width, height) = (width as f32, height as f32);
    let (places, rest) = unwrapped(table, places);
    let rows = places.map(|p| p[1]);
    if rest.abs() > 0.5 * width {
        // The cap about the pole down to the lowest corner.
        let [low, high] = [
            rows.into_iter().fold(height, f32::min),
            rows.into_iter().fold(0.0, f32::max),
        ];
        let down = if low + high < height {
            [0.0, high.max(1.0)]
        } else {
            [low.min(height - 1.0), height]
        };
        return table.summed().mean([0.0, width], down);
    }
    slices::mean(table.summed(), places)
}

fn quad(table: &Table, corners: [[f32; 3]; 4], places: [[f32; 2]; 4]) -> [f32; 3] {
    let width = table.size().0 as f32;
    if adjacent(table, &places) {
        return mean4(corners.map(|d| table.bilinear(d)));
    }
    let (places, rest) = unwrapped(table, places);
    let mut sum = [0.0f64; 4];
    let [a, b, c, d] = places;
    if rest.abs() > 0.5 * width {
        let lowest: f32 = places.iter().map(|p| p[1]).sum();
        let height = table.size().1 as f32;
        let pole = if lowest < 2.0 * height { 0.0 } else { height };
        for [from, to] in [[a, b], [b, c], [c, d], [d, [a[0] + rest, a[1]]]] {
            let ends = [[to[0], pole], [from[0], pole]];
            add_triangle(table, [from, to, ends[0]], &mut sum);
            add_triangle(table, [from, ends[0], ends[1]], &mut sum);
        }
    } else {
        add_triangle(table, [a, b, c], &mut sum);
        add_triangle(table, [a, c, d], &mut sum);
    }
    if sum[3] > 0.0 {
        [0, 1, 2].map(|c: usize| (sum[c] / sum[3]) as f32)
    } else {
        // Corners on one line.
        mean4(corners.map(|d| table.bilinear(d)))
    }
}

/// Adds radiance times solid angle, and solid angle, over a triangle in the table; columns go on beyond the seam.
fn add_triangle(table: &Table, corners: [[f32; 2]; 3], sum: &mut [f64; 4]) {
    let (width, height) = table.size();
    let triangle: Vec<[f64; 2]> = corners.iter().map(|p| p.map(f64::from)).collect();
    let range = |polygon: &[[f64; 2]], axis: usize| {
        let values = polygon.iter().map(|p| p[axis]);
        let low = values.clone().fold(f64::INFINITY, f64::min).floor();
        let high = values.fold(f64::NEG_INFINITY, f64::max).ceil();
        low as i64..high as i64
    };
    for row in range(&triangle, 1) {
        if !(0..height as i64).contains(&row) {
            continue;
        }
        let strip = clipped(&triangle, 1, row as f64);
        // Proportional to the solid angle of the row's texels.
        let weight = ((row as f64 + 0.5) / height as f64 * std::f64::consts::PI).sin();
        for column in range(&strip, 0) {
            let omega = weight * area(&clipped(&strip, 0, column as f64));
            let texel = table.texel(column.rem_euclid(width as i64) as usize, row as usize);
            (0..3).for_each(|c| sum[c] += omega * f64::from(texel[c]));
            sum[3] += omega;
        }
    }
}

/// The part of a convex polygon between `from` and `from + 1` along an axis (I. Sutherland, G. Hodgman 1974).
fn clipped(polygon: &[[f64; 2]], axis: usize, from: f64) -> Vec<[f64; 2]> {
    let cut = |polygon: &[[f64; 2]], inside: &dyn Fn([f64; 2]) -> f64| {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (k, &p) in polygon.iter().enumerate() {
            let q = polygon[(k + 1) % polygon.len()];
            let (a, b) = (inside(p), inside(q));
            if a >= 0.0 {
                kept.push(p);
            }
            if (a < 0.0) != (b < 0.0) {
                let t = a / (a - b);
                kept.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
            }
        }
        kept
    };
    let above = cut(polygon, &|p| p[axis] - from);
    cut(&above, &|p| from + 1.0 - p[axis])
}

fn area(polygon: &[[f64; 2]]) -> f64 {
    let mut twice = 0.0;
    for (k, p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        twice += p[0] * q[1] - p[1] * q[0];
    }
    0.5 * twice.abs()
}
