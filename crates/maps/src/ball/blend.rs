//! What photographs show in one direction, and which of them counts.

use super::photo::{Photo, frame};
use crate::gains::Both;
use environment::Direction;

/// Photographs that resolve a direction at least this well, relative to the best of them, count beside it.
///
/// A mirror's rim shows nearly half of the sphere in few pixels: what it says of a direction is a mean over many
/// degrees. So no power of the resolution is small enough as a weight where a lamp is a thousand times as bright as
/// what it stands before; the weight must end. The resolution changes by a fifth over 5 degrees where two balls a
/// quarter turn apart both see badly, and over 30 where both see well, which hides the seam.
pub(super) const ENOUGH: f64 = 0.8;

/// Directions in which gains are looked for: two degrees apart.
const SHARED: usize = 10_000;

/// Share of the resolution of a ball's middle that tells gains.
const WELL: f64 = 0.3;

/// A photograph that is looked at.
struct View<'a> {
    photo: &'a Photo<'a>,
    frame: [Direction; 3],
    /// Pixels a radian in the middle of its ball, relative to the finest ball's.
    scale: f64,
}

/// Photographs that are looked at together.
pub(super) struct Views<'a> {
    views: Vec<View<'a>>,
    /// Pixels a radian in the middle of the finest ball.
    pub finest: f64,
}

impl<'a> Views<'a> {
    pub fn of(photos: &'a [Photo<'a>]) -> Self {
        let finest = photos.iter().map(Photo::density).fold(0.0, f64::max);
        let view = |photo: &'a Photo<'a>| View {
            photo,
            frame: frame(photo.from),
            scale: photo.density() / finest,
        };
        let views = photos.iter().map(view).collect();
        Self { views, finest }
    }

    /// What pairs of photographs show where both see well, in directions that are spread evenly (Á. González 2010).
    pub fn shared(&self) -> Vec<Both> {
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        let direction = |k: usize| {
            let z = 1.0 - (2 * k + 1) as f64 / SHARED as f64;
            let (sin, cos) = (golden * k as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            [r * cos, z, r * sin]
        };
        let mut shared = Vec::new();
        for direction in (0..SHARED).map(direction) {
            let seen = self.views.iter().enumerate().filter_map(|(number, view)| {
                let (place, resolution) = view.photo.place(&view.frame, direction)?;
                (resolution > WELL).then(|| (number, view.photo.at(place)))
            });
            let seen: Vec<_> = seen.collect();
            for (k, (first, a)) in seen.iter().enumerate() {
                shared.extend(seen[k + 1..].iter().map(|(second, b)| Both {
                    photos: [*first, *second],
                    values: [*a, *b],
                }));
            }
        }
        shared
    }

    /// What is seen in a direction, and how well: the resolution along the radius, relative to the middle of the finest
    /// ball. `None` where all photographs are blind.
    ///
    /// The best photograph counts fully, others less and less down to [`ENOUGH`] of its resolution.
    pub fn look(&self, direction: Direction) -> Option<([f64; 3], f64)> {
        let seen = self.views.iter().filter_map(|view| {
            let (place, resolution) = view.photo.place(&view.frame, direction)?;
            Some((view.photo, place, resolution * view.scale))
        });
        let seen: Vec<_> = seen.collect();
        let best = seen.iter().map(|view| view.2).fold(0.0, f64::max);
        if best == 0.0 {
            return None;
        }
        let (mut color, mut resolution, mut shares) = ([0.0; 3], 0.0, 0.0);
        for (photo, place, own) in seen {
            let t = ((own / best - ENOUGH) / (1.0 - ENOUGH)).max(0.0);
            let share = t * t * (3.0 - 2.0 * t);
            if share > 0.0 {
                let value = photo.at(place);
                color = std::array::from_fn(|c| color[c] + share * value[c]);
                resolution += share * own;
                shares += share;
            }
        }
        Some((color.map(|v| v / shares), resolution / shares))
    }
}
