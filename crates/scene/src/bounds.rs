//! Boxes around points.

use glam::DVec3;

/// The box around points: its lowest and its highest corner, infinite and the wrong way round where there are none.
pub fn around(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let limits = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let wider = |(low, high): (DVec3, DVec3), p| (low.min(p), high.max(p));
    points.into_iter().fold(limits, wider)
}
