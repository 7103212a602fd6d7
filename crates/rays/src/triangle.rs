//! One ray against one triangle, in f64.
//!
//! Corners are sheared along the ray into a plane, where the ray is the point 0; each of the three edges then has the
//! point on one side of it. A corner is sheared alike for all triangles that share it, and the side of an edge is
//! exact, so no ray passes between neighbours, be it aimed at their edge or at their common corner. The distance comes
//! from the triangle's plane: an origin in the plane of an axis-aligned triangle is at t = 0 exactly. The inputs are
//! f32 values, so differences are all but exact and no scale fails: the third power of any f32 fits f64.
//!
//! Source: Woop, Benthin and Wald, *Watertight ray/triangle intersection*, 2013; the exact side by Kahan's difference
//! of products (Jeannerod, Louvet and Muller, *Further analysis of Kahan's algorithm*, 2013).

use glam::DVec3;

/// A ray's origin, direction and shear.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShearedRay {
    pub origin: DVec3,
    pub direction: DVec3,
    /// Axes across and along; the last is the direction's largest.
    axes: [usize; 3],
    shear: [f64; 2],
}

/// Where a line meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Crossing {
    /// Distance in lengths of the direction.
    pub t: f64,
    /// Weights of the second and third corners.
    pub barycentric: [f64; 2],
    /// The corners turn counter-clockwise as seen from the ray's origin.
    pub front: bool,
}

impl ShearedRay {
    /// The line from `origin` along `direction`; one without a direction meets nothing.
    #[inline]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let along = direction.abs().max_position();
        let axes = [(along + 1) % 3, (along + 2) % 3, along];
        let shear = [
            direction[axes[0]] / direction[along],
            direction[axes[1]] / direction[along],
        ];
        Self {
            origin,
            direction,
            axes,
            shear,
        }
    }

    /// Where the line meets the triangle, its edges included. `None` where it misses or lies in the plane.
    #[inline]
    pub fn cross(&self, corners: &[[f32; 3]; 3]) -> Option<Crossing> {
        let [a, b, c] =
            corners.map(|corner| DVec3::from_array(corner.map(f64::from)) - self.origin);
        let [flat_a, flat_b, flat_c] = [a, b, c].map(|corner| self.flatten(corner));
        let of_a = side(flat_b, flat_c);
        let of_b = side(flat_c, flat_a);
        let of_c = side(flat_a, flat_b);
        if of_a.min(of_b).min(of_c) < 0.0 && of_a.max(of_b).max(of_c) > 0.0 {
            return None;
        }
        let area = of_a + of_b + of_c;
        let normal = (b - a).cross(c - a);
        let slope = normal.dot(self.direction);
        if area == 0.0 || slope == 0.0 {
            return None;
        }
        Some(Crossing {
            t: normal.dot(a) / slope,
            barycentric: [of_b / area, of_c / area],
            front: slope < 0.0,
        })
    }

    #[inline]
    fn flatten(&self, corner: DVec3) -> [f64; 2] {
        let depth = corner[self.axes[2]];
        [
            corner[self.axes[0]] - self.shear[0] * depth,
            corner[self.axes[1]] - self.shear[1] * depth,
        ]
    }
}

/// Twice the area of the triangle 0, p, q, with its exact sign: positive where they turn counter-clockwise.
#[inline]
fn side(p: [f64; 2], q: [f64; 2]) -> f64 {
    let (forth, back) = (p[0] * q[1], p[1] * q[0]);
    let area = forth - back;
    // Each product and the difference round by 2^-53 at most; beyond that the sign is certain.
    if area.abs() > (forth.abs() + back.abs()) * (4.0 * f64::EPSILON) {
        return area;
    }
    p[0].mul_add(q[1], -back) - p[1].mul_add(q[0], -back)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];

    #[test]
    fn crossing_reports_distance_weights_and_side_exactly() {
        let up =
            ShearedRay::new(DVec3::new(0.25, 0.5, 0.0), DVec3::new(0.0, 0.0, 0.5)).cross(&CORNERS);
        assert_eq!(
            up,
            Some(Crossing {
                t: 2.0,
                barycentric: [0.25, 0.5],
                front: false
            })
        );
        let down = ShearedRay::new(DVec3::new(0.25, 0.5, 3.0), DVec3::NEG_Z).cross(&CORNERS);
        assert_eq!(
            down,
            Some(Crossing {
                t: 2.0,
                barycentric: [0.25, 0.5],
                front: true
            })
        );
    }

    #[test]
    fn corners_and_edges_belong_to_the_triangle() {
        for (x, y) in [
            (0.0, 0.0),
            (1.0, 0.0),
            (0.0, 1.0),
            (0.5, 0.5),
            (0.5, 0.0),
            (0.0, 0.5),
        ] {
            for z in [0.0, 2.0] {
                let hit = ShearedRay::new(DVec3::new(x, y, z), DVec3::new(0.0, 0.0, 1.0 - z))
                    .cross(&CORNERS);
                assert_eq!(hit.map(|hit| hit.t), Some(1.0), "at {x} {y} from {z}");
            }
        }
    }

    #[test]
    fn a_ray_in_the_plane_and_a_triangle_without_area_are_missed() {
        assert_eq!(
            ShearedRay::new(DVec3::new(-1.0, 0.25, 1.0), DVec3::X).cross(&CORNERS),
            None
        );
        let line = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]];
        assert_eq!(
            ShearedRay::new(DVec3::new(0.5, 0.0, 0.0), DVec3::Z).cross(&line),
            None
        );
        assert_eq!(
            ShearedRay::new(DVec3::ZERO, DVec3::ZERO).cross(&CORNERS),
            None
        );
    }

    #[test]
    fn results_do_not_depend_on_the_scale() {
        let base = ShearedRay::new(DVec3::new(0.25, 0.125, 0.0), DVec3::new(0.125, 0.0, 1.0))
            .cross(&CORNERS);
        for scale in [
            f32::MIN_POSITIVE,
            2.0f32.powi(-60),
            2.0f32.powi(60),
            2.0f32.powi(126),
        ] {
            let corners = CORNERS.map(|corner| corner.map(|x| x * scale));
            let wide = f64::from(scale);
            let hit = ShearedRay::new(
                DVec3::new(0.25, 0.125, 0.0) * wide,
                DVec3::new(0.125, 0.0, 1.0) * wide,
            )
            .cross(&corners);
            assert_eq!(hit, base, "at scale {scale:e}");
        }
    }

    #[test]
    fn sides_are_exact_where_products_round() {
        // (1 + e)(1 - e) - 1 = -e^2, which a difference of rounded products takes for 0.
        let e = 2.0f64.powi(-30);
        assert_eq!(side([1.0 + e, 1.0], [1.0, 1.0 - e]), -e * e);
        assert_eq!(side([1.0, 1.0 - e], [1.0 + e, 1.0]), e * e);
        assert_eq!(side([1.0 + e, 1.0 + e], [1.0 - e, 1.0 - e]), 0.0);
    }
}
