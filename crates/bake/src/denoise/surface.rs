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
    /// Of each term the channels of the mean of two halves of the rays, then the mean channel of half their difference.
    pub data: Sheet,
    pub terms: Vec<SurfaceTerm>,
}

/// One of the terms of a surface. What fits need of its texels is known once for all.
#[derive(Debug)]
pub(super) struct SurfaceTerm {
    /// Which of those that are denoised together.
    pub number: usize,
    /// Its first plane and its channels, after which the plane of halves follows.
    pub first: usize,
    pub channels: usize,
    /// The largest value that there is.
    pub largest: f32,
    /// Standard errors of the plain values.
    pub errors: Sheet,
}

impl SurfaceTerm {
    /// The plane of halves.
    pub fn halves(&self) -> usize {
        self.first + self.channels
    }
}

impl Surface {
    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.mask.width, self.mask.height()]
    }

    /// Those with the same texels as one.
    pub fn joined(surfaces: Vec<Self>) -> Vec<Self> {
        let mut joined: Vec<(Self, Vec<Sheet>)> = Vec::new();
        for mut own in surfaces {
            let data = std::mem::take(&mut own.data);
            let alike = joined.iter_mut().find(|(other, _)| other.mask == own.mask);
            let Some((other, planes)) = alike else {
                joined.push((own, vec![data]));
                continue;
            };
            let first: usize = planes.iter().map(|data| data.planes).sum();
            own.terms.iter_mut().for_each(|term| term.first += first);
            other.terms.append(&mut own.terms);
            planes.push(data);
        }
        let whole = |(surface, planes)| Self {
            data: Sheet::beside(planes),
            ..surface
        };
        joined.into_iter().map(whole).collect()
    }
}
