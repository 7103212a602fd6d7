//! A chart, or a band of one, as fits take it: planes of numbers.

use super::plane::Sheet;

/// Features of a texel on a bent surface, which are functions beside those of the place.
pub(super) const FEATURES: usize = 4;

/// A chart, or a band of one, ready to be fitted.
#[derive(Debug)]
pub(super) struct Surface {
    /// 1 where it has texels; of those that something seals in part, what is left.
    pub mask: Sheet,
    /// What fits may follow beside the place: [`FEATURES`] planes or none.
    pub features: Option<Sheet>,
    /// The channels of the mean of two halves of the rays, then the mean channel of half their difference.
    pub data: Sheet,
    /// So many channels decide how all are smoothed.
    pub leading: usize,
    /// Standard errors of the plain values.
    pub errors: Sheet,
}

impl Surface {
    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.mask.width, self.mask.height()]
    }
}
