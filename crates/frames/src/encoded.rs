//! Normals as codes of a frame buffer: section 2.4 of the 1984 text, and the octahedral codes of today.
//!
//! 256 normals: a square of 16 by 16 cells, laid on the disc without distortion of areas (P. Shirley, K. Chiu, "A Low
//! Distortion Map Between Disk and Square", 1997) and on the hemisphere toward the viewer by J. Lambert's equal-area
//! projection. Octahedral: Z. Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors"
//! (2014).

use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_PI_4;

/// How a normal is stored.
///
/// Angles between normals and what is stored, in degrees, mean and largest: 3.78 and 8.83 for the 256 normals; 0.334
/// and 0.942 for octahedral codes of 8 + 8 bits, 0.0836 and 0.232 of 10 + 10, 0.0209 and 0.0590 of 12 + 12, 0.00131 and
/// 0.00368 of 16 + 16.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NormalCode {
    /// One of 256 normals of equal areas on the hemisphere toward the camera; others become the nearest of its rim.
    Visible256,
    /// Two numbers of this many bits each, 2..=16, on an octahedron.
    Octahedral(u32),
}

/// Cells on a side of the square of 256 normals.
const SIDE: u32 = 16;

impl NormalCode {
    /// The word for it, as on the command line: `256`, or `oct8+8` and its kin.
    pub fn name(self) -> String {
        match self {
            NormalCode::Visible256 => "256".into(),
            NormalCode::Octahedral(bits) => format!("oct{bits}+{bits}"),
        }
    }

    /// The code of that name.
    pub fn from_name(name: &str) -> Option<NormalCode> {
        let codes = (2..=16).map(NormalCode::Octahedral);
        let mut codes = codes.chain([NormalCode::Visible256]);
        codes.find(|code| code.name() == name)
    }

    /// How many cells a code has along each of its two axes.
    pub fn side(self) -> u32 {
        match self {
            NormalCode::Visible256 => SIDE,
            NormalCode::Octahedral(bits) => 1 << bits,
        }
    }

    /// A code's cells along its two axes.
    pub fn cells(self, code: u32) -> [u32; 2] {
        [code % self.side(), code / self.side()]
    }

    /// The code of a unit normal. `axes`: right, up and toward the viewer.
    pub fn encode(self, normal: DVec3, axes: [DVec3; 3]) -> u32 {
        let cell = |v: f64, count: u32| {
            ((0.5 * (v + 1.0) * f64::from(count)).max(0.0) as u32).min(count - 1)
        };
        let place = match self {
            NormalCode::Visible256 => square(DVec3::from_array(axes.map(|a| a.dot(normal)))),
            NormalCode::Octahedral(_) => octahedron(normal),
        };
        let count = self.side();
        // At 16 bits the last code is u32::MAX.
        cell(place.y, count) * count + cell(place.x, count)
    }

    /// The unit normal in the middle of a code's cell.
    pub fn decode(self, code: u32, axes: [DVec3; 3]) -> DVec3 {
        let middle = |cell: u32| (2.0 * f64::from(cell) + 1.0) / f64::from(self.side()) - 1.0;
        let place = DVec2::from(self.cells(code).map(middle));
        match self {
            NormalCode::Visible256 => {
                let n = hemisphere(place);
                axes[0] * n.x + axes[1] * n.y + axes[2] * n.z
            }
            NormalCode::Octahedral(_) => unfold(place),
        }
    }
}

/// The place in -1..=1 of a direction whose z points to the viewer.
fn square(n: DVec3) -> DVec2 {
    // Radius √2 sin(θ/2) of the equal-area disc; 1 at the rim.
    let radius = (1.0 - n.z).max(0.0).sqrt().min(1.0);
    let angle = n.y.atan2(n.x);
    // Quarters about +x, +y, -x, -y.
    let quarter = (angle / (2.0 * FRAC_PI_4)).round();
    let across = radius * (angle - quarter * 2.0 * FRAC_PI_4) / FRAC_PI_4;
    match quarter.rem_euclid(4.0) as u32 {
        0 => DVec2::new(radius, across),
        1 => DVec2::new(-across, radius),
        2 => DVec2::new(-radius, -across),
        _ => DVec2::new(across, -radius),
    }
}

fn hemisphere(place: DVec2) -> DVec3 {
    let DVec2 { x, y } = place;
    let (radius, angle) = if x.abs() > y.abs() {
        (x, FRAC_PI_4 * y / x)
    } else if y != 0.0 {
        (y, FRAC_PI_4 * (2.0 - x / y))
    } else {
        (0.0, 0.0)
    };
    let z = 1.0 - radius * radius;
    let across = (1.0 - z * z).max(0.0).sqrt() * radius.signum();
    DVec3::new(across * angle.cos(), across * angle.sin(), z)
}

/// The place in -1..=1 on the unfolded octahedron, +z in the middle.
fn octahedron(n: DVec3) -> DVec2 {
    let p = n.truncate() / (n.x.abs() + n.y.abs() + n.z.abs());
    if n.z >= 0.0 { p } else { folded(p) }
}

fn unfold(place: DVec2) -> DVec3 {
    let z = 1.0 - place.x.abs() - place.y.abs();
    let p = if z >= 0.0 { place } else { folded(place) };
    p.extend(z).normalize()
}

fn folded(p: DVec2) -> DVec2 {
    let sign = |v: f64| if v < 0.0 { -1.0 } else { 1.0 };
    DVec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and largest angle in degrees between normals and what their codes hold.
    fn error(code: NormalCode) -> (f64, f64) {
        let (mut sum, mut largest, mut count) = (0.0f64, 0.0f64, 0u32);
        let steps = 400_000u32;
        for k in 0..steps {
            // A spiral of equal areas.
            let z = 1.0 - (f64::from(k) + 0.5) / f64::from(steps) * 2.0;
            if code == NormalCode::Visible256 && z < 0.0 {
                break;
            }
            let (sin, cos) = (f64::from(k) * 2.399_963_229_728_653).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let normal = DVec3::new(r * cos, r * sin, z);
            let stored = code.decode(code.encode(normal, DVec3::AXES), DVec3::AXES);
            assert!((stored.length() - 1.0).abs() < 1e-12);
            let angle = normal.cross(stored).length().atan2(normal.dot(stored));
            (sum, largest, count) = (sum + angle, largest.max(angle), count + 1);
        }
        ((sum / f64::from(count)).to_degrees(), largest.to_degrees())
    }

    #[test]
    fn a_code_is_the_code_of_what_it_holds() {
        for code in [NormalCode::Visible256, NormalCode::Octahedral(4)] {
            for number in 0..256 {
                let normal = code.decode(number, DVec3::AXES);
                assert_eq!(
                    code.encode(normal, DVec3::AXES),
                    number,
                    "{code:?} {normal}"
                );
            }
        }
    }

    #[test]
    fn codes_err_by_the_angles_their_documentation_states() {
        let stated = [
            (NormalCode::Visible256, 3.78, 8.83),
            (NormalCode::Octahedral(8), 0.334, 0.942),
            (NormalCode::Octahedral(10), 0.0836, 0.232),
            (NormalCode::Octahedral(12), 0.0209, 0.0590),
            (NormalCode::Octahedral(16), 0.00131, 0.00368),
        ];
        for (code, mean, largest) in stated {
            let found = error(code);
            // Three digits are stated.
            let same = |a: f64, b: f64| (a - b).abs() < 0.005 * b;
            assert!(
                same(found.0, mean) && same(found.1, largest),
                "{code:?}: {found:?}"
            );
        }
    }
}
