//! Which way sheets face, and what lies near them or behind them.

use crate::solid::placed::{NEAR, Placed};
use glam::DVec3;

/// The cosine of the angle between sheets up to which who looks at the front of one looks at that of the other.
const ALIKE: f64 = 0.707;

/// True where a surface's box meets that of a sheet, or nearly does.
pub(super) fn is_near(sheet: &Placed, other: &Placed) -> bool {
    let slack = NEAR * sheet.size();
    other.meets(sheet.low - slack, sheet.high + slack)
}

/// Where the front of a sheet looks.
pub(super) fn facing(sheet: &Placed) -> Option<DVec3> {
    let normal = sheet.inverse.matrix3.transpose() * sheet.surface.front?;
    normal.try_normalize()
}

/// True where who sees the front of one sheet sees that of the other.
pub(super) fn looks_alike(a: &Placed, b: &Placed) -> bool {
    cosine(a, b).is_some_and(|cosine| cosine > ALIKE)
}

/// The cosine of the angle between the fronts of two sheets.
pub(super) fn cosine(a: &Placed, b: &Placed) -> Option<f64> {
    Some(facing(a)?.dot(facing(b)?))
}

/// The direction to which the back of a sheet looks.
pub(super) fn backward(sheet: &Placed) -> Option<DVec3> {
    let front = sheet.surface.front?;
    Some(-sheet.transform.transform_vector3(front))
}

/// The box, without an end to some sides, of all that lies behind a sheet.
pub(super) fn behind(sheet: &Placed) -> (DVec3, DVec3) {
    let (mut low, mut high) = (sheet.low, sheet.high);
    let back = backward(sheet).unwrap_or_default();
    for axis in 0..3 {
        if back[axis] > 0.0 {
            high[axis] = f64::INFINITY;
        }
        if back[axis] < 0.0 {
            low[axis] = f64::NEG_INFINITY;
        }
    }
    (low, high)
}
