//! Exact ambient integrals over spherical polygons, by sums over their edges, in f64.
//!
//! A region of directions is given by loops of points seen from the origin; every loop is cut to half-spaces first.
//! Green's theorem turns each integral into one over the loop: n = 0 gives the solid angle, n = 1 Lambert's sum,
//! other exponents a smooth one-dimensional integral. Cut ends that run back and forth on a plane cancel, so loops
//! need not be convex.

use crate::support::{table, tables};
use glam::DVec3;

/// Integrals over a region: solid angle over 2 pi, cosine over pi, lobe times (n+1)/2 pi.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shares {
    pub visibility: f64,
    pub diffuse: f64,
    pub specular: f64,
}

impl std::ops::AddAssign for Shares {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl std::ops::Add for Shares {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            visibility: self.visibility + other.visibility,
            diffuse: self.diffuse + other.diffuse,
            specular: self.specular + other.specular,
        }
    }
}

impl std::ops::Mul<f64> for Shares {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self {
            visibility: self.visibility * factor,
            diffuse: self.diffuse * factor,
            specular: self.specular * factor,
        }
    }
}

/// Where the integrals are taken: a surface point's two normals, the lobe axis and its exponent.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    pub normal: DVec3,
    pub geometric: DVec3,
    pub mirror: DVec3,
    pub exponent: i32,
}

/// Shares of the region inside `loop_`, cut to the hemispheres of both normals (and of the lobe for specular).
///
/// The loop turns either way; the shares of one loop are counted positive.
pub fn shares(loop_: &[DVec3], at: &Setting) -> Shares {
    let hemisphere = cut(&cut(loop_, at.normal), at.geometric);
    let lobe = cut(&hemisphere, at.mirror);
    let visibility = edge_sum(&hemisphere, at.normal, 0) / std::f64::consts::TAU;
    let diffuse = edge_sum(&hemisphere, at.normal, 1) / std::f64::consts::PI;
    let n = at.exponent;
    let specular = edge_sum(&lobe, at.mirror, n) * f64::from(n + 1) / std::f64::consts::TAU;
    Shares {
        visibility,
        diffuse,
        specular,
    } * visibility.signum()
}

/// Shares of everything above both normals' planes: what a point without any occluder sees.
pub fn open_shares(at: &Setting) -> Shares {
    let x = at.geometric.any_orthonormal_vector();
    let y = at.geometric.cross(x);
    let corners = [x, y, -x, -y];
    let mut sum = Shares::default();
    for k in 0..4 {
        sum += shares(&[at.geometric, corners[k], corners[(k + 1) % 4]], at);
    }
    sum
}

/// The part of a loop in the half-space `direction . plane >= 0`.
fn cut(loop_: &[DVec3], plane: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(loop_.len() + 4);
    for (k, &a) in loop_.iter().enumerate() {
        let b = loop_[(k + 1) % loop_.len()];
        let (above_a, above_b) = (a.dot(plane), b.dot(plane));
        if above_a >= 0.0 {
            kept.push(a);
        }
        if (above_a >= 0.0) != (above_b >= 0.0) {
            kept.push(a + (b - a) * (above_a / (above_a - above_b)));
        }
    }
    kept
}

/// The integral of max(0, axis . w)^n over the inside of a loop that lies in the hemisphere of `axis`; its sign is
/// that of the turn.
fn edge_sum(loop_: &[DVec3], axis: DVec3, n: i32) -> f64 {
    let mut sum = 0.0;
    for (k, &a) in loop_.iter().enumerate() {
        let b = loop_[(k + 1) % loop_.len()];
        let across = a.cross(b);
        let length = across.length();
        if length <= 1e-15 * a.length() * b.length() {
            continue;
        }
        let side = axis.dot(across) / length;
        let angle = length.atan2(a.dot(b));
        if side != 0.0 {
            sum += side
                * arc(
                    axis.dot(a.normalize()),
                    axis.dot((across / length).cross(a.normalize())),
                    angle,
                    n,
                );
        }
    }
    sum / f64::from(n + 1)
}

/// The integral over t in 0..angle of (1 - x^(n+1)) / (1 - x^2), with x = a cos t + b sin t.
fn arc(a: f64, b: f64, angle: f64, n: i32) -> f64 {
    if n == 1 {
        return angle;
    }
    // A lobe is about 1 / sqrt(n + 1) wide.
    let pieces = (0.5 * angle * f64::from(n + 1).sqrt()).ceil().max(1.0);
    let half = 0.5 * angle / pieces;
    let mut sum = 0.0;
    for piece in 0..pieces as usize {
        let middle = (2 * piece + 1) as f64 * half;
        for (node, weight) in GAUSS_12 {
            for t in [middle - node * half, middle + node * half] {
                let (sin, cos) = t.sin_cos();
                sum += weight * half * slope(a * cos + b * sin, n);
            }
        }
    }
    sum
}

/// (1 - x^(n+1)) / (1 - x^2) for x in 0..=1, the limit (n+1)/2 at 1.
fn slope(x: f64, n: i32) -> f64 {
    let rest = 1.0 - x;
    if rest < 1e-9 {
        return 0.5 * f64::from(n + 1);
    }
    (1.0 - x.powi(n + 1)) / (rest * (1.0 + x))
}

/// Positive nodes and weights of the 12-point Gauss-Legendre rule on -1..1.
const GAUSS_12: [(f64, f64); 6] = [
    (0.125_233_408_511_468_9, 0.249_147_045_813_402_8),
    (0.367_831_498_998_180_2, 0.233_492_536_538_354_8),
    (0.587_317_954_286_617_4, 0.203_167_426_723_065_9),
    (0.769_902_674_194_304_7, 0.160_078_328_543_346_2),
    (0.904_117_256_370_474_9, 0.106_939_325_995_318_4),
    (0.981_560_634_246_719_3, 0.047_175_336_386_511_8),
];

#[test]
fn edge_sums_agree_with_the_table_of_meshes() {
    let mut compared = 0;
    for row in table("meshes.csv") {
        let cells: Vec<&str> = row.split(',').collect();
        // Bodies hide some of their own faces: only sets of faces that do not overlap as seen from the point count.
        if ["sphere.obj", "box.obj"].contains(&cells[1]) {
            continue;
        }
        let number = |column: usize| cells[column].parse::<f64>().expect("a number");
        let (scale, shift) = (number(2), DVec3::new(number(3), number(4), number(5)));
        let file = tables().join("meshes").join(cells[1]);
        let mut faces = crate::exact::mesh::Mesh::read(&file).faces;
        // A face seen edge-on hides nothing: the floor of the room, on which the point lies.
        faces.retain(|face| face.normal().dot(face.points[0] * scale + shift) != 0.0);
        for (column, zenith, azimuth, exponent) in [
            (8, 0.0, 0.0, 5),
            (9, 30.0, 0.0, 5),
            (10, 60.0, 90.0, 5),
            (11, 0.0, 0.0, 50),
            (12, 30.0, 0.0, 50),
            (13, 60.0, 90.0, 50),
        ] {
            let (zenith, azimuth) = (f64::to_radians(zenith), f64::to_radians(azimuth));
            let mirror = DVec3::new(
                zenith.sin() * azimuth.cos(),
                zenith.sin() * azimuth.sin(),
                zenith.cos(),
            );
            let at = Setting {
                normal: DVec3::Z,
                geometric: DVec3::Z,
                mirror,
                exponent,
            };
            let mut blocked = Shares::default();
            for face in &faces {
                let seen: Vec<DVec3> = face.points.iter().map(|p| *p * scale + shift).collect();
                let one = shares(&seen, &at);
                let theirs =
                    bench::exact::polygon_specular(&seen, at.normal, mirror, f64::from(exponent));
                assert!(
                    (one.specular - theirs).abs() < 1e-9,
                    "{}: {one:?}, the library has {theirs}",
                    cells[0]
                );
                blocked += one;
            }
            let open = open_shares(&at);
            let values = [
                (open.visibility - blocked.visibility, number(6)),
                (open.diffuse - blocked.diffuse, number(7)),
                (open.specular - blocked.specular, number(column)),
            ];
            for (ours, table) in values {
                // The reader rounds coordinates to f32, the table does not: half an ulp, steepened by the lobe.
                assert!(
                    (ours - table).abs() < 3e-7,
                    "{}: {ours} against {table} at {at:?}",
                    cells[0]
                );
                compared += 1;
            }
        }
    }
    // 27 of the 42 meshes, from six views, in three terms.
    assert_eq!(compared, 27 * 6 * 3);
}

#[test]
fn open_shares_agree_with_the_closed_form() {
    for degrees in [0.0_f64, 20.0, 60.0, 85.0] {
        for exponent in [0, 1, 5, 50] {
            let angle = degrees.to_radians();
            let mirror = DVec3::new(angle.sin(), angle.cos(), 0.0);
            let at = Setting {
                normal: DVec3::Y,
                geometric: DVec3::Y,
                mirror,
                exponent,
            };
            let open = open_shares(&at);
            let closed =
                ambient::closed_form::phong_open(f64::from(exponent), angle.cos(), angle.sin());
            assert!(
                (open.specular - closed).abs() < 1e-9,
                "n = {exponent}, {degrees} degrees: {open:?}, {closed}"
            );
            assert!(
                (open.visibility - 1.0).abs() < 1e-12 && (open.diffuse - 1.0).abs() < 1e-12,
                "{open:?}"
            );
        }
    }
}
