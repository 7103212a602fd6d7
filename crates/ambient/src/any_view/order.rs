//! Which order of harmonics a bake is worth: the lowest that leaves less than its noise.

use super::bands::{BANDS, bands};
use super::{Lobe, ORDER};

/// The orders that layers hold.
pub const ORDERS: [usize; 2] = [4, ORDER];

/// Energy Σ c² of the open directions that each of [`ORDERS`] does not hold: the most of an endless wall as high as it
/// is far, below the edge of a square lid, and in a corridor twice as high as wide.
const MISSING: [f64; 2] = [0.0653, 0.0327];

/// Noise of coefficients at one ray: falls like N^-3/4. Measured on five scenes from 64 to 1,024 rays, where it is 0.4
/// to 1.2.
const NOISE: f64 = 0.8;

/// What missing energy above an order leaves in the term of a lobe, root mean square over all views. The border of
/// what is open spreads it over the bands as 1/l²; each counts as the lobe passes it on.
pub(super) fn left(missing: f64, order: usize, lobe: Lobe) -> f64 {
    let bands = bands(lobe, BANDS);
    let above = || (order + 1..BANDS).map(|l| (l, (l as f64).powi(-2)));
    let share: f64 = above().map(|(_, share)| share).sum();
    let passed: f64 = above().map(|(l, share)| bands[l] * bands[l] * share).sum();
    (missing * passed / share).sqrt()
}

/// What one of [`ORDERS`] leaves in the term of a lobe beside walls and under lids, root mean square over all views;
/// the larger order for others.
///
/// ```
/// use ambake_ambient::any_view::{Lobe, truncation};
/// let lobe = Lobe::Phong(20.0);
/// assert!(truncation(8, lobe) < 0.02 && truncation(4, lobe) > 0.04);
/// ```
pub fn truncation(order: usize, lobe: Lobe) -> f64 {
    let which = usize::from(order != ORDERS[0]);
    left(MISSING[which], ORDERS[which], lobe)
}

/// The noise to expect in the term at so many hemisphere rays, root mean square over all views.
pub fn expected_noise(order: usize, lobe: Lobe, rays: u32) -> f64 {
    let bands = bands(lobe, order + 1);
    // Of band l are l + 1 coefficients kept.
    let passed: f64 = (0..=order)
        .map(|l| (l + 1) as f64 * bands[l] * bands[l])
        .sum();
    NOISE * f64::from(rays.max(1)).powf(-0.75) * passed.sqrt()
}

/// The lowest of [`ORDERS`] that leaves less of the lobe than noise does at so many hemisphere rays; the highest where
/// none does.
///
/// ```
/// use ambake_ambient::any_view::{Lobe, order_for};
/// let order = |n, rays| order_for(Lobe::Phong(n), rays);
/// assert_eq!((order(5.0, 256), order(20.0, 256), order(20.0, 16)), (4, 8, 4));
/// ```
pub fn order_for(lobe: Lobe, rays: u32) -> usize {
    let holds = |order: &usize| truncation(*order, lobe) < expected_noise(*order, lobe, rays);
    ORDERS.into_iter().find(holds).unwrap_or(ORDER)
}
