//! One lightmap for every view: the open directions of a texel as a few numbers, and the specular term that they give
//! for any eye.
//!
//! The open directions of a texel are a function V of the hemisphere. Mirrored about the surface it becomes a function
//! of the sphere without a step at the horizon, and only spherical harmonics with l + m even are left of it: 15 up to
//! order 4, 45 up to order 8. On the hemisphere they are polynomials of the two tangential coordinates. With y(l, m)
//! scaled to a mean square of 1,
//!
//! ```text
//! c(l, m) = 1/2π ∫ V y(l, m) dω             what a texel stores; c(0, 0) is its visibility
//! k(l, m; θ) = ∫ K(R·L) y(l, m) dω          over the upper hemisphere, a table for each lobe K
//! S(R) = Σ k(l, m; θ) (c(l, m) cos mφ + c(l, -m) sin mφ),   clamped to 0..=k(0, 0; θ)
//! ```
//!
//! θ is the angle from the normal to the view, φ the azimuth of the mirrored view R in the texel's frame. k(0, 0; θ) is
//! the term of an open texel, whatever θ: an open texel has c = (1, 0, 0, …), so that it is exact at every angle, and
//! no correction is needed as in the full basis. Orders end where V has detail: [`stated`] says what that costs.
//!
//! Sources: R. Ramamoorthi, P. Hanrahan, "A Signal-Processing Framework for Inverse Rendering", SIGGRAPH 2001 (products
//! of lobes and light in harmonics); P.-P. Sloan, J. Kautz, J. Snyder, "Precomputed Radiance Transfer", SIGGRAPH 2002
//! (visibility in harmonics); R. Habel, M. Wimmer, "Efficient Irradiance Normal Mapping", I3D 2010 (harmonics over the
//! hemisphere).

mod bands;
mod basis;
mod kernel;
mod order;
mod table;

pub use bands::bands;
pub use basis::{Basis, COUNT, ORDER, PAIRS, count, index, pair, pairs};
pub use kernel::{Kernel, Lobe, kernel};
pub use order::{ORDERS, expected_noise, order_for, truncation};
pub use table::{COLUMNS, KernelTable, ROWS, row_of};

use crate::Frame;
use glam::DVec3;

/// The axis that [`frame`] turns onto the normal, and the tangent that it takes along; the opposite of the axis is the
/// only direction without a frame. No wall, floor or ceiling of a model stands that way.
const AXIS: DVec3 = DVec3::new(2.0 / 7.0, 6.0 / 7.0, 3.0 / 7.0);
const TANGENT: DVec3 = DVec3::new(6.0 / 7.0, -3.0 / 7.0, 2.0 / 7.0);

/// The frame of a texel's coefficients from its normal: the shortest turn from a fixed axis to the normal. It moves
/// smoothly with the normal but at one direction, so that coefficients of neighbours can be mixed by a filter, and it
/// has no branch.
///
/// ```
/// let frame = ambake_ambient::any_view::frame(glam::DVec3::X);
/// assert!((frame.to_world(glam::DVec3::Z) - glam::DVec3::X).length() < 1e-15);
/// assert!(frame.tangent.cross(frame.bitangent).dot(glam::DVec3::X) > 0.999);
/// ```
pub fn frame(normal: DVec3) -> Frame {
    let along = 1.0 + AXIS.dot(normal);
    let turned = TANGENT - (AXIS + normal) * (normal.dot(TANGENT) / along.max(1e-6));
    // Unit but for rounding, and but for the axis' opposite.
    let tangent = turned - normal * normal.dot(turned);
    match tangent.try_normalize() {
        None => Frame::from_normal(normal),
        Some(tangent) => Frame {
            tangent,
            bitangent: normal.cross(tangent),
            normal,
        },
    }
}

/// The harmonics of a texel's open directions, by [`index`]; those above its order are 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients(pub [f64; COUNT]);

impl Coefficients {
    /// Those of an open texel.
    pub const OPEN: Self = {
        let mut values = [0.0; COUNT];
        values[0] = 1.0;
        Self(values)
    };

    /// The specular term for a mirrored view of this azimuth in the texel's frame, given as cosine and sine, by the
    /// kernel for its angle. Only harmonics up to `order` count.
    pub fn term(&self, order: usize, kernel: &Kernel, azimuth: [f64; 2]) -> f64 {
        let mut turns = [[1.0, 0.0]; ORDER + 1];
        for m in 1..=ORDER {
            let [c, s] = turns[m - 1];
            turns[m] = [
                c * azimuth[0] - s * azimuth[1],
                c * azimuth[1] + s * azimuth[0],
            ];
        }
        let mut sum = 0.0;
        for (l, m) in pairs(order) {
            let [cos, sin] = turns[m];
            let (even, odd) = (index(l, m as isize), index(l, -(m as isize)));
            let odd = if m == 0 { 0.0 } else { sin * self.0[odd] };
            sum += kernel[pair(l, m)] * (cos * self.0[even] + odd);
        }
        sum.clamp(0.0, kernel[0].max(0.0))
    }

    /// The specular term of a texel with this normal for a unit vector to the eye. An eye below the surface sees what
    /// it sees at the horizon.
    pub fn specular(&self, order: usize, lobe: Lobe, normal: DVec3, view: DVec3) -> f64 {
        let mirrored = 2.0 * normal.dot(view) * normal - view;
        let local = frame(normal).to_local(mirrored);
        let length = local.x.hypot(local.y);
        let azimuth = match length > 1e-12 {
            true => [local.x / length, local.y / length],
            false => [1.0, 0.0],
        };
        let theta = length.atan2(local.z.max(0.0));
        self.term(order, &kernel(&Basis::new(), lobe, theta), azimuth)
    }
}

impl Default for Coefficients {
    fn default() -> Self {
        Self([0.0; COUNT])
    }
}

/// What the term of a texel is off by, root mean square over all views: detail that the order does not hold, and noise.
///
/// V is 0 or 1, so that all its harmonics together have the energy Σ c² = c(0, 0). What is missing of that lies in
/// bands above the order; the border of V spreads it over them as 1/l². Each band counts as the lobe passes it on.
/// `variances` are those of the coefficients.
///
/// ```
/// use ambake_ambient::any_view::{Coefficients, Lobe, stated};
/// assert_eq!(stated(&Coefficients::OPEN, &[0.0; 45], 4, Lobe::Phong(20.0)), 0.0);
/// ```
pub fn stated(
    coefficients: &Coefficients,
    variances: &[f64; COUNT],
    order: usize,
    lobe: Lobe,
) -> f64 {
    let bands = bands(lobe, order + 1);
    let (mut noise, mut held) = (0.0, 0.0);
    for (l, m) in pairs(order) {
        let places = [index(l, m as isize), index(l, -(m as isize))];
        for &at in &places[..if m == 0 { 1 } else { 2 }] {
            noise += bands[l] * bands[l] * variances[at];
            held += coefficients.0[at].powi(2) - variances[at];
        }
    }
    let missing = (coefficients.0[0] - held).max(0.0);
    noise.sqrt().hypot(order::left(missing, order, lobe))
}

#[cfg(test)]
mod tests;
