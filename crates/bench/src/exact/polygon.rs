//! Solid angle and form factor of a polygon.

use super::clip::{HALVINGS, above, edges};
use glam::DVec3;
use std::f64::consts::TAU;

/// Solid angle in steradians, `0..=2π`, of the part of a polygon above the horizon of `normal`.
///
/// `visibility` falls by this over 2π. A polygon that lies in the horizon counts 0. A vertex may be a direction at
/// infinity (any vector that points there), as long as no corner is opposite to another: cut an endless strip in two.
///
/// Sum of the signed triangles from the centroid to each edge, each after A. van Oosterom, J. Strackee, "The Solid
/// Angle of a Plane Triangle", 1983, with the volume taken from edge vectors: small polygons keep their digits.
/// Triangles with an obtuse side are halved first, because their base cancels.
pub fn polygon_solid_angle(vertices: &[DVec3], normal: DVec3) -> f64 {
    let kept = above(vertices, normal);
    let apex = kept.iter().sum::<DVec3>() / kept.len().max(1) as f64;
    let sum: f64 = edges(&kept)
        .iter()
        .map(|&(b, c)| triangle([apex, b, c], HALVINGS))
        .sum();
    sum.abs()
}

fn triangle([a, b, c]: [DVec3; 3], depth: u32) -> f64 {
    // Turn the most obtuse side, as seen from the point, between b and c.
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let (ab, bc, ca) = (a.dot(b), b.dot(c), c.dot(a));
    let obtuse = [ab * lc, bc * la, ca * lb];
    let least = obtuse[0].min(obtuse[1]).min(obtuse[2]);
    if least < 0.0 && depth > 0 {
        let [a, b, c] = match obtuse.iter().position(|&x| x == least) {
            Some(0) => [c, a, b],
            Some(2) => [b, c, a],
            _ => [a, b, c],
        };
        let middle = 0.5 * (b + c);
        return triangle([a, b, middle], depth - 1) + triangle([a, middle, c], depth - 1);
    }
    let volume = a.dot((b - a).cross(c - a));
    2.0 * volume.atan2(la * lb * lc + obtuse[0] + obtuse[1] + obtuse[2])
}

/// Form factor, `0..=1`, from the point to the part of a polygon above its horizon: (1/π) ∫ N·L dω.
///
/// `diffuse` falls by this. Vertices as in [`polygon_solid_angle`].
///
/// J. H. Lambert, "Photometria", 1760: (1/2π) Σ γ N·m over the edges, γ the angle an edge fills and m its unit normal.
/// As it stands that sum loses 1/size² of its digits. With unit vertices a, b and γm = a×b + (γ/sin γ − 1) a×b the
/// first part adds up to the vector area of the unit vertices, and that is taken from their differences to one of them.
pub fn polygon_form_factor(vertices: &[DVec3], normal: DVec3) -> f64 {
    let mut kept = above(vertices, normal);
    kept.retain(|v| *v != DVec3::ZERO);
    let Some(&origin) = kept.first() else {
        return 0.0;
    };
    let mut sum = 0.0;
    for (a, b) in edges(&kept) {
        let (ua, ub) = (a.normalize_or_zero(), b.normalize_or_zero());
        let cross = ua.cross(ub);
        let area = unit_difference(a, origin).cross(unit_difference(b, origin));
        sum += normal.dot(area) + arc_excess(ua.dot(ub), cross.length()) * normal.dot(cross);
    }
    (sum / TAU).abs()
}

/// a/|a| − o/|o| to the relative accuracy of a − o.
fn unit_difference(a: DVec3, o: DVec3) -> DVec3 {
    let (la, lo) = (a.length(), o.length());
    if la == 0.0 {
        return -o / lo;
    }
    let difference = a - o;
    let longer = difference.dot(a + o) / (la + lo);
    (difference - o * (longer / lo)) / la
}

/// γ/sin γ − 1 of an angle given by its cosine and sine.
fn arc_excess(cosine: f64, sine: f64) -> f64 {
    if sine == 0.0 {
        0.0
    } else if sine < 0.05 && cosine > 0.0 {
        // Series of asin(s)/s; the next term is below 1e-16 of the first.
        let s = sine * sine;
        s * (1.0 / 6.0
            + s * (3.0 / 40.0
                + s * (5.0 / 112.0
                    + s * (35.0 / 1_152.0 + s * (63.0 / 2_816.0 + s * (231.0 / 13_312.0))))))
    } else {
        sine.atan2(cosine) / sine - 1.0
    }
}
