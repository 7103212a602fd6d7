//! How a picture shows the sphere of directions, with the exact solid angle of every texel.
//!
//! Directions are unit vectors with +y up; +z is the middle of every one-piece picture, +x lies to its right. A place
//! in a picture is `(x, y)` in pixels from the top left corner: texel `(i, j)` has its centre at `(i + 0.5, j + 0.5)`.

mod area;
pub mod cube;
mod disc;
mod nodes;
mod octahedral;
#[cfg(test)]
mod tests;

pub(crate) use cube::taps as cube_taps;

use crate::Error;
use std::f64::consts::{PI, TAU};

/// A direction of unit length.
pub type Direction = [f64; 3];

/// How directions are laid out in a picture.
///
/// ```
/// use ambake_environment::Projection;
/// let size = Projection::Cube.size(64);
/// assert_eq!((size, Projection::Cube.texels(size)), ((16, 96), 64));
/// // The middle of the first face looks along +x, and back.
/// assert_eq!(Projection::Cube.direction(size, 8.0, 8.0), Some([1.0, 0.0, 0.0]));
/// assert_eq!(Projection::Cube.place(size, [1.0, 0.0, 0.0]), (8.0, 8.0));
/// let sphere: f64 = Projection::Cube.solid_angles(size).iter().sum();
/// assert!((sphere / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-13);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Projection {
    /// Longitude and latitude, twice as wide as high: u = atan2(x, z) with 0 in the middle, v = arccos y from the top.
    Polar,
    /// Six square faces below each other, +x -x +y -y +z -z, each as OpenGL's cube maps hold them. In files: six
    /// pictures.
    Cube,
    /// Six faces unfolded: 4 x 3 faces with +z in column 2, or 3 x 4 with -z at the bottom, turned by 180 degrees.
    Cross,
    /// Six faces in one row, or in one column, in the order of `Cube`.
    Strip,
    /// Two orthographic discs, x to the right and y up: z >= 0 at the left, z < 0 at the right.
    Ortho,
    /// A mirrored sphere seen from far away at +z: the middle shows +z, the rim -z. Equal areas.
    Ball,
    /// The angle from +z is proportional to the distance from the middle; the rim shows -z.
    Angular,
    /// The octahedron |x| + |y| + |z| = 1 unfolded into a square of even size with +z in the middle.
    Octahedral,
}

impl Projection {
    /// Every projection with its name.
    pub(crate) const NAMES: [(Projection, &str); 8] = [
        (Projection::Polar, "polar"),
        (Projection::Cube, "cube"),
        (Projection::Cross, "cross"),
        (Projection::Strip, "strip"),
        (Projection::Ortho, "ortho"),
        (Projection::Ball, "ball"),
        (Projection::Angular, "angular"),
        (Projection::Octahedral, "octahedral"),
    ];

    /// Every projection.
    pub fn all() -> impl Iterator<Item = Projection> {
        Self::NAMES.into_iter().map(|(projection, _)| projection)
    }

    /// Its name on the command line and in file headers.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].1
    }

    /// The projection of this name.
    pub fn from_name(name: &str) -> Option<Projection> {
        let found = Self::NAMES.into_iter().find(|(_, other)| *other == name);
        found.map(|(projection, _)| projection)
    }

    /// # Errors
    /// [`Error::Shape`] where a picture of `width` x `height` pixels cannot have this projection.
    pub fn check(self, width: usize, height: usize) -> Result<(), Error> {
        let (fits, rule) = match self {
            Self::Polar => (width == 2 * height, "is twice as wide as high"),
            Self::Cube => (height == 6 * width, "has six square faces below each other"),
            Self::Cross => (
                (3 * width == 4 * height && width.is_multiple_of(4))
                    || (4 * width == 3 * height && width.is_multiple_of(3)),
                "is 4 x 3 or 3 x 4 square faces",
            ),
            Self::Strip => (
                width == 6 * height || height == 6 * width,
                "is a row or a column of six square faces",
            ),
            Self::Ortho => (width == 2 * height, "is two squares side by side"),
            Self::Ball | Self::Angular => (width == height, "is square"),
            Self::Octahedral => (
                width == height && width.is_multiple_of(2),
                "is square with an even side",
            ),
        };
        if fits && width > 0 {
            return Ok(());
        }
        let name = self.name();
        Err(Error::Shape(format!(
            "{width} x {height} pixels are no {name} map: it {rule}; crop it or name its projection"
        )))
    }

    /// The width and height of a picture with about `texels` texels on the equator.
    pub fn size(self, texels: usize) -> (usize, usize) {
        let quarter = texels.div_ceil(4).max(1);
        match self {
            Self::Polar => (4 * quarter, 2 * quarter),
            Self::Cube => (quarter, 6 * quarter),
            Self::Cross => (4 * quarter, 3 * quarter),
            Self::Strip => (6 * quarter, quarter),
            Self::Ortho => (4 * quarter, 2 * quarter),
            Self::Ball | Self::Angular | Self::Octahedral => (2 * quarter, 2 * quarter),
        }
    }

    /// Texels on the equator of a picture of this size: what [`Projection::size`] takes.
    pub fn texels(self, (width, height): (usize, usize)) -> usize {
        match self {
            Self::Polar | Self::Ortho => width,
            Self::Cross => width.max(height),
            Self::Cube | Self::Strip => 4 * width.min(height),
            Self::Ball | Self::Angular | Self::Octahedral => 2 * width,
        }
    }

    /// The direction shown at a place; `None` where the picture shows none (beside a cross, outside a disc).
    pub fn direction(self, size: (usize, usize), x: f64, y: f64) -> Option<Direction> {
        let (w, h) = (size.0 as f64, size.1 as f64);
        match self {
            Self::Polar => {
                let (sin, cos) = (y / h * PI).sin_cos();
                let (across, along) = ((x / w - 0.5) * TAU).sin_cos();
                Some([sin * across, cos, sin * along])
            }
            Self::Cube | Self::Cross | Self::Strip => cube::direction(self, size, x, y),
            Self::Ortho if x < h => disc::ortho(2.0 * x / h - 1.0, 1.0 - 2.0 * y / h, 1.0),
            Self::Ortho => disc::ortho(2.0 * (x - h) / h - 1.0, 1.0 - 2.0 * y / h, -1.0),
            Self::Ball => disc::ball(2.0 * x / w - 1.0, 1.0 - 2.0 * y / h),
            Self::Angular => disc::angular(2.0 * x / w - 1.0, 1.0 - 2.0 * y / h),
            Self::Octahedral => Some(octahedral::direction(2.0 * x / w - 1.0, 1.0 - 2.0 * y / h)),
        }
    }

    /// The place where a direction is shown. A direction on a border has one of its places.
    pub fn place(self, size: (usize, usize), direction: Direction) -> (f64, f64) {
        let (w, h) = (size.0 as f64, size.1 as f64);
        let [x, y, z] = direction;
        let square = |(right, up): (f64, f64)| ((right + 1.0) * 0.5 * h, (1.0 - up) * 0.5 * h);
        match self {
            Self::Polar => {
                let polar = x.hypot(z).atan2(y);
                ((x.atan2(z) / TAU + 0.5) * w, polar / PI * h)
            }
            Self::Cube | Self::Cross | Self::Strip => cube::place(self, size, direction),
            Self::Ortho => {
                let (across, down) = square((x, y));
                (if z >= 0.0 { across } else { across + h }, down)
            }
            Self::Ball => square(disc::ball_place(direction)),
            Self::Angular => square(disc::angular_place(direction)),
            Self::Octahedral => square(octahedral::place(direction)),
        }
    }

    /// Solid angle of a texel, sr: exact up to rounding, 0 where it shows nothing. Together they are 4π.
    pub fn solid_angle(self, size: (usize, usize), i: usize, j: usize) -> f64 {
        let (w, h) = (size.0 as f64, size.1 as f64);
        // Corners in -1..1 of a square picture or disc.
        let square = |i: usize| {
            let edge = |k: usize| 2.0 * k as f64 / h - 1.0;
            ([edge(i), edge(i + 1)], [edge(j), edge(j + 1)])
        };
        match self {
            Self::Polar => {
                let middle = (j as f64 + 0.5) / h * PI;
                TAU / w * 2.0 * middle.sin() * (0.5 * PI / h).sin()
            }
            Self::Cube | Self::Cross | Self::Strip => cube::solid_angle(self, size, i, j),
            Self::Ortho => {
                let (x, y) = square(i % size.1);
                area::ortho(x, y)
            }
            Self::Ball => {
                let (x, y) = square(i);
                area::radial(x, y, |_| 2.0, 2.0)
            }
            Self::Angular => {
                let (x, y) = square(i);
                area::radial(x, y, disc::angular_flux, 2.0)
            }
            Self::Octahedral => octahedral::solid_angle(size.0, i, j),
        }
    }

    /// [`Projection::solid_angle`] of all texels, row by row, sr.
    pub fn solid_angles(self, size: (usize, usize)) -> Vec<f64> {
        let texels = (0..size.1).flat_map(|j| (0..size.0).map(move |i| (i, j)));
        texels.map(|(i, j)| self.solid_angle(size, i, j)).collect()
    }

    /// Side of the squares from the top left on, in texels, whose borders may be seams.
    pub fn piece(self, size: (usize, usize)) -> usize {
        match self {
            Self::Cube | Self::Cross | Self::Strip => cube::side(self, size),
            Self::Ortho => size.1,
            Self::Octahedral => size.0 / 2,
            Self::Polar | Self::Ball | Self::Angular => size.0,
        }
    }

    /// Whether directions are a smooth function over a rectangle within a piece: no rim or fold cuts it, or is nearer
    /// to it than its own size where their derivatives grow without bound.
    pub fn smooth(self, size: (usize, usize), corner: [f64; 2], sides: [f64; 2]) -> bool {
        let h = size.1 as f64;
        let corners = (0..4).map(|k| {
            let (x, y) = ((k % 2) as f64, (k / 2) as f64);
            let (x, y) = (corner[0] + x * sides[0], corner[1] + y * sides[1]);
            let middle = ((corner[0] / h).floor() + 0.5) * h;
            (2.0 * (x - middle) / h, 2.0 * y / h - 1.0)
        });
        match self {
            Self::Polar | Self::Cube | Self::Cross | Self::Strip => true,
            Self::Angular => corners.map(|(x, y)| x.hypot(y)).all(|r| r < 1.0),
            Self::Ortho | Self::Ball => {
                let most = 1.0 - 2.0 * sides[0].max(sides[1]) / h;
                corners.map(|(x, y)| x.hypot(y)).all(|r| r < most)
            }
            Self::Octahedral => {
                let heights: Vec<f64> = corners.map(|(x, y)| 1.0 - x.abs() - y.abs()).collect();
                heights.iter().all(|z| *z > -1e-9) || heights.iter().all(|z| *z < 1e-9)
            }
        }
    }

    /// The texels around `(i, j)` that show something, over seams, poles and edges, without itself.
    pub fn neighbours(self, size: (usize, usize), i: usize, j: usize) -> Vec<usize> {
        let own = j * size.0 + i;
        let around = (0..9).filter(|k| *k != 4).filter_map(|k| {
            let (di, dj) = (k % 3 - 1, k / 3 - 1);
            match self {
                Self::Cube | Self::Cross | Self::Strip => {
                    cube::neighbour(self, size, (i, j), (di, dj))
                }
                _ => self.wrap(size, i as isize + di, j as isize + dj),
            }
        });
        around.filter(|texel| *texel != own).collect()
    }

    /// The direction shown at a place, or at the nearest place of a disc's rim.
    pub fn nearest_direction(self, size: (usize, usize), x: f64, y: f64) -> Direction {
        let h = size.1 as f64;
        let middle = |v: f64| ((v / h).floor() + 0.5) * h;
        let (dx, dy) = (x - middle(x), y - 0.5 * h);
        let scale = (0.5 * h / dx.hypot(dy)).min(1.0) * (1.0 - 1e-12);
        let shown = self.direction(size, middle(x) + dx * scale, 0.5 * h + dy * scale);
        shown.unwrap_or([0.0, 0.0, -1.0])
    }

    /// Solid angle by area of the picture at a place, up to a constant factor; 0 where nothing is shown.
    pub fn density(self, size: (usize, usize), x: f64, y: f64) -> f64 {
        let (w, h) = (size.0 as f64, size.1 as f64);
        match self {
            Self::Polar => (y / h * PI).sin(),
            Self::Cube | Self::Cross | Self::Strip => cube::density(self, size, x, y),
            Self::Ortho => {
                let d = self.direction(size, x, y);
                d.map_or(0.0, |d| 1.0 / d[2].abs().max(0.5 / h))
            }
            Self::Ball => f64::from(u8::from(self.direction(size, x, y).is_some())),
            Self::Angular => disc::angular_density(2.0 * x / w - 1.0, 1.0 - 2.0 * y / h),
            Self::Octahedral => octahedral::density(2.0 * x / w - 1.0, 1.0 - 2.0 * y / h),
        }
    }

    /// The texel `(i, j)`, which may lie outside by a texel or two, as a texel of the picture: over a seam, a pole or
    /// an edge to its neighbour. `None` only beside all directions.
    pub(crate) fn wrap(self, size: (usize, usize), i: isize, j: isize) -> Option<usize> {
        let (w, h) = (size.0 as isize, size.1 as isize);
        let index = |i: isize, j: isize| Some((j * w + i) as usize);
        match self {
            Self::Polar => {
                let over = j < 0 || j >= h;
                let row = if j < 0 {
                    -1 - j
                } else if over {
                    2 * h - 1 - j
                } else {
                    j
                };
                index(
                    (i + if over { w / 2 } else { 0 }).rem_euclid(w),
                    row.clamp(0, h - 1),
                )
            }
            Self::Octahedral => {
                let (mut i, mut j) = (i, j);
                if i < 0 || i >= w {
                    i = if i < 0 { -1 - i } else { 2 * w - 1 - i };
                    j = h - 1 - j;
                }
                if j < 0 || j >= h {
                    j = if j < 0 { -1 - j } else { 2 * h - 1 - j };
                    i = w - 1 - i;
                }
                index(i.clamp(0, w - 1), j.clamp(0, h - 1))
            }
            Self::Cube | Self::Cross | Self::Strip => None,
            Self::Ortho | Self::Ball | Self::Angular => {
                let inside = (0..w).contains(&i) && (0..h).contains(&j);
                let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
                (inside && self.direction(size, x, y).is_some()).then(|| (j * w + i) as usize)
            }
        }
    }
}
