//! What is checked before Embree sees it: the library drops bad triangles without a word.
#![cfg_attr(not(embree), allow(dead_code))]

use crate::Error;

/// Embree's FLT_LARGE: primitives that reach it are left out of the hierarchy, rays that pass it fail an assertion.
pub(crate) const LARGE: f32 = 1.844e18;

/// A number of items as Embree counts them; the last value marks "no such item".
pub(crate) fn count(what: &'static str, count: usize) -> Result<u32, Error> {
    match u32::try_from(count) {
        Ok(n) if n != u32::MAX => Ok(n),
        _ => Err(Error::TooMany { what, count }),
    }
}

/// A mesh that Embree keeps whole: at least one triangle, finite vertices, indices in range.
pub(crate) fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<(), Error> {
    if triangles.is_empty() {
        return Err(Error::EmptyMesh);
    }
    count("triangles", triangles.len())?;
    let vertices = count("vertices", positions.len())?;
    if let Some(vertex) = positions
        .iter()
        .position(|p| !p.iter().all(|x| x.abs() < LARGE))
    {
        let position = positions[vertex];
        return Err(Error::VertexOutOfRange { vertex, position });
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v >= vertices) {
            return Err(Error::IndexOutOfRange {
                triangle,
                vertex,
                vertices: positions.len(),
            });
        }
    }
    Ok(())
}

/// Inverse of the linear part, as rows, of a transform that Embree can invert as well.
///
/// Embree inverts in single precision. Where the determinant is below one rounding step of the product of the column
/// lengths, or leaves the range of normal floats, no digit of that inverse is right.
pub(crate) fn inverse(transform: &[[f32; 3]; 4]) -> Result<[[f64; 3]; 3], Error> {
    if !transform.iter().flatten().all(|x| x.is_finite()) {
        return Err(Error::TransformNotFinite(*transform));
    }
    let [a, b, c, _] = transform.map(|column| column.map(f64::from));
    let rows = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = dot(a, rows[0]);
    let lengths = [a, b, c].map(|v| dot(v, v).sqrt());
    let relative = determinant.abs() / lengths.iter().product::<f64>();
    // Products of two and of three lengths then stay within single precision.
    let usable = lengths.iter().all(|length| (1e-12..=1e12).contains(length))
        && determinant.abs() >= f64::from(f32::MIN_POSITIVE);
    // The comparison is false for 0 / 0 too.
    if usable && relative > f64::from(f32::EPSILON) {
        Ok(rows.map(|row| row.map(|x| x / determinant)))
    } else {
        Err(Error::SingularTransform { determinant })
    }
}

/// Checks that a box stays in Embree's range under a transform.
pub(crate) fn placed(transform: &[[f32; 3]; 4], bounds: [[f32; 3]; 2]) -> Result<(), Error> {
    let extent: [f32; 3] =
        std::array::from_fn(|axis| bounds[0][axis].abs().max(bounds[1][axis].abs()));
    let [a, b, c, translation] = transform.map(|column| column.map(|x| f64::from(x).abs()));
    let reach = (0..3)
        .map(|row| dot([a[row], b[row], c[row]], extent.map(f64::from)) + translation[row])
        .fold(0.0, f64::max);
    if reach < f64::from(LARGE) {
        Ok(())
    } else {
        Err(Error::InstanceOutOfRange(reach))
    }
}

/// How large a ray's coordinates may be so that they stay below half of [`LARGE`] in the space of an instance; the
/// other half is room for Embree's rounding.
pub(crate) fn reach(inverse: &[[f64; 3]; 3], translation: [f32; 3]) -> f32 {
    let half = f64::from(LARGE) / 2.0;
    let reach = inverse.iter().map(|row| {
        let row = row.map(f64::abs);
        let shift = dot(row, translation.map(|x| f64::from(x.abs())));
        (half - shift).max(0.0) / (row[0] + row[1] + row[2])
    });
    reach.fold(half, f64::min) as f32
}

/// True where Embree serves an instance with this transform, columns first and the translation last, to rays whose
/// origins and directions have no coordinate above `extent` in magnitude.
///
/// One instance that does not would cost every ray of the scene its hits: see `reach`.
/// [`crate::SceneBuilder::instance`] refuses what serves no ray of unit direction; whoever knows the scene's size asks
/// here first and places the vertices instead.
pub fn serves(transform: &[[f32; 3]; 4], extent: f64) -> bool {
    inverse(transform).is_ok_and(|inverse| f64::from(reach(&inverse, transform[3])) > extent)
}

/// `m` times `v`, rows first.
pub(crate) fn apply(m: &[[f64; 3]; 3], v: [f32; 3]) -> [f64; 3] {
    m.map(|row| dot(row, v.map(f64::from)))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_stop_before_the_invalid_id() {
        assert_eq!(count("triangles", 4_294_967_294), Ok(u32::MAX - 1));
        for n in [u32::MAX as usize, 1 << 32, usize::MAX] {
            let error = count("triangles", n);
            assert_eq!(
                error,
                Err(Error::TooMany {
                    what: "triangles",
                    count: n
                })
            );
        }
    }

    #[test]
    fn inverse_undoes_a_dyadic_transform_exactly() {
        let transform = [
            [0.0, 2.0, 0.0],
            [-0.5, 0.0, 0.0],
            [0.0, 0.0, 4.0],
            [7.0, 8.0, 9.0],
        ];
        let inverse = inverse(&transform).expect("determinant 4");
        assert_eq!(apply(&inverse, [0.0, 2.0, 0.0]), [1.0, 0.0, 0.0]);
        assert_eq!(apply(&inverse, [-0.5, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        assert_eq!(apply(&inverse, [0.0, 0.0, 4.0]), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn far_and_tiny_instances_serve_no_ray() {
        let place = |scale: f32, at: f32| {
            let mut columns = [[0.0; 3]; 4];
            (0..3).for_each(|axis| columns[axis][axis] = scale);
            columns[3] = [at, 0.0, 0.0];
            columns
        };
        for (scale, at) in [(1e-9, 1e9), (1e-6, 1e12), (1e-11, 1e7), (1.0, 9.5e17)] {
            assert!(!serves(&place(scale, at), 1.0), "{scale:e} at {at:e}");
        }
        assert!(serves(&place(1e-6, 1e6), 1e6));
        assert!(serves(&place(1e-9, 1e3), 1e8) && !serves(&place(1e-9, 1e3), 1e9));
    }

    #[test]
    fn transforms_without_an_inverse_are_refused() {
        let scale = |x, y, z| [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z], [0.0; 3]];
        for singular in [
            scale(1.0, 1.0, 0.0),
            scale(0.0, 0.0, 0.0),
            scale(1e-13, 1e-13, 1e-13),
            scale(1e13, 1e13, 1e13),
            // Each column is in range, the determinant is not a normal float.
            [
                [1e-12, 0.0, 0.0],
                [0.0, 1e-12, 0.0],
                [0.0, 1e-12, 1e-15],
                [0.0; 3],
            ],
            [[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.1, 0.7, 0.3], [0.0; 3]],
        ] {
            assert!(
                matches!(inverse(&singular), Err(Error::SingularTransform { .. })),
                "{singular:?}"
            );
        }
        assert!(inverse(&scale(1.0, -1.0, 1e-6)).is_ok());
        assert!(matches!(
            inverse(&scale(f32::NAN, 1.0, 1.0)),
            Err(Error::TransformNotFinite(_))
        ));
    }
}
