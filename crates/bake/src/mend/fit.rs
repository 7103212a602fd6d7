//! Planes through values at places, by weighted least squares, as weights of the values.

use glam::{DMat2, DVec2, DVec3};

/// The least ratio of the spreads across and along for which a slope across is told.
const FLAT: f64 = 0.02;

/// Where a value stands, and what it counts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub at: DVec2,
    /// Above 0.
    pub weight: f64,
}

/// Mean place and the inverse of the spread; `None` where the places do not tell a plane.
struct Spread {
    mean: DVec2,
    inverse: DMat2,
}

impl Spread {
    fn of(places: &[Place]) -> Option<Self> {
        let total: f64 = places.iter().map(|place| place.weight).sum();
        let sum: DVec2 = places.iter().map(|place| place.weight * place.at).sum();
        if total <= 0.0 {
            return None;
        }
        let mean = sum / total;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for place in places {
            let d = place.at - mean;
            xx += place.weight * d.x * d.x;
            xy += place.weight * d.x * d.y;
            yy += place.weight * d.y * d.y;
        }
        // The eigenvalues are those of a spread along and across.
        let (half, det) = (0.5 * (xx + yy), xx * yy - xy * xy);
        if det <= FLAT * FLAT * half * half {
            return None;
        }
        let inverse = DMat2::from_cols(DVec2::new(yy, -xy), DVec2::new(-xy, xx)) * (1.0 / det);
        Some(Self { mean, inverse })
    }

    /// Weights of the values in the fitted plane's rise over a step.
    fn slope(&self, places: &[Place], step: DVec2) -> Vec<f64> {
        let along = self.inverse * step;
        let weight = |place: &Place| place.weight * along.dot(place.at - self.mean);
        places.iter().map(weight).collect()
    }
}

/// Weights of the values in the fitted value at 0; where no plane is told, those of their mean. `None` where nothing is
/// near.
pub(super) fn value(places: &[Place]) -> Option<Vec<f64>> {
    let total: f64 = places.iter().map(|place| place.weight).sum();
    if total <= 0.0 {
        return None;
    }
    let mut weights: Vec<f64> = places.iter().map(|place| place.weight / total).collect();
    if let Some(spread) = Spread::of(places) {
        let slopes = slope(places, -spread.mean)?;
        for (weight, slope) in weights.iter_mut().zip(slopes) {
            *weight += slope;
        }
    }
    Some(weights)
}

/// Weights of the values in the fitted plane's rise over a step.
pub(super) fn slope(places: &[Place], step: DVec2) -> Option<Vec<f64>> {
    Some(Spread::of(places)?.slope(places, step))
}

/// The position that a plane through positions has at 0.
pub(super) fn middle(places: &[(Place, DVec3)]) -> Option<DVec3> {
    let at: Vec<Place> = places.iter().map(|(place, _)| *place).collect();
    Spread::of(&at)?;
    let weights = value(&at)?;
    let positions = places.iter().zip(weights);
    Some(
        positions
            .map(|((_, position), weight)| weight * *position)
            .sum(),
    )
}

/// Where on a chart a position of its surface is: the plane of positions over places, turned round.
pub(super) struct Chart {
    origin: DVec3,
    steps: [DVec3; 2],
    inverse: DMat2,
}

impl Chart {
    /// From places with their positions; `None` where they do not tell a plane.
    pub fn of(places: &[(Place, DVec3)]) -> Option<Self> {
        let at: Vec<Place> = places.iter().map(|(place, _)| *place).collect();
        let spread = Spread::of(&at)?;
        let sum = |weights: Vec<f64>| -> DVec3 {
            let terms = places.iter().zip(weights);
            terms
                .map(|((_, position), weight)| weight * *position)
                .sum()
        };
        let origin = sum(value(&at)?);
        let step = |axis| spread.slope(&at, axis);
        let steps = [sum(step(DVec2::X)), sum(step(DVec2::Y))];
        let [x, y] = steps;
        let squares = DMat2::from_cols_array(&[x.dot(x), x.dot(y), x.dot(y), y.dot(y)]);
        (squares.determinant() > 0.0).then(|| Self {
            origin,
            steps,
            inverse: squares.inverse(),
        })
    }

    /// The place of a position, in texels.
    pub fn place(&self, position: DVec3) -> DVec2 {
        let way = position - self.origin;
        self.inverse * DVec2::from(self.steps.map(|step| step.dot(way)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Vec<Place> {
        (0..12)
            .map(|i| Place {
                at: DVec2::new(f64::from(i % 4) + 1.0, f64::from(i / 4) - 0.7),
                weight: 1.0 + f64::from(i % 5),
            })
            .collect()
    }

    #[test]
    fn a_plane_is_met_exactly() {
        let places = grid();
        let plane = |at: DVec2| 0.3 + 0.2 * at.x - 0.7 * at.y;
        let sum = |weights: Vec<f64>| -> f64 {
            let terms = places.iter().zip(weights);
            terms.map(|(place, weight)| weight * plane(place.at)).sum()
        };
        let found = sum(value(&places).expect("a value"));
        assert!((found - 0.3).abs() < 1e-12, "{found}");
        let rise = sum(slope(&places, DVec2::new(2.0, 1.0)).expect("a slope"));
        assert!((rise - (0.4 - 0.7)).abs() < 1e-12, "{rise}");
    }

    #[test]
    fn places_in_a_row_tell_no_slope_and_their_mean() {
        let row: Vec<Place> = (0..5)
            .map(|i| Place {
                at: DVec2::new(f64::from(i), 0.0),
                weight: 1.0,
            })
            .collect();
        assert!(slope(&row, DVec2::X).is_none());
        assert_eq!(value(&row).expect("a mean"), vec![0.2; 5]);
    }
}
