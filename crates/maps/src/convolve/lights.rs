//! Lights smaller than a texel, summed in closed form.
//!
//! A texel a thousand times as bright as each of its neighbours is no area of constant radiance: what it holds is
//! smaller than itself, a sun or a lamp. Its excess over the neighbours counts as a point in its middle, with the
//! texel's flux. So the result depends on the flux, not on the size of the texel, and no series has to follow a peak.

use super::{Request, picture};
use environment::{Direction, IlluminationMap, Image};
use rayon::prelude::*;

/// A texel that outshines each neighbour by this factor is a light.
const CONTRAST: f32 = 1000.0;

/// Most lights; others, fainter than these, count as areas.
const MOST: usize = 1024;

/// Points with their flux, radiance times sr.
pub(super) struct Lights(Vec<(Direction, [f64; 3])>);

impl Lights {
    /// The lights of a map and the map without them; `None` where there are no lights.
    pub(super) fn of(map: &IlluminationMap) -> Option<(Lights, IlluminationMap)> {
        let pixels = &map.image().pixels;
        let sum = |at: usize| pixels[at].iter().sum::<f32>();
        let (size, projection) = (map.size(), map.projection());
        let around = |at: usize| projection.neighbours(size, at % size.0, at / size.0);
        // Next to each other in memory: at least one of the two is a neighbour.
        let beside = |at: usize| [at.saturating_sub(1), (at + 1).min(pixels.len() - 1)];
        let mut found: Vec<usize> = (0..pixels.len())
            .into_par_iter()
            .filter(|at| beside(*at).iter().any(|k| sum(*at) > CONTRAST * sum(*k)))
            .filter(|at| around(*at).iter().all(|k| sum(*at) > CONTRAST * sum(*k)))
            .collect();
        if found.is_empty() {
            return None;
        }
        let omega = |at: usize| projection.solid_angle(size, at % size.0, at / size.0);
        let flux = |at: &usize| f64::from(sum(*at)) * omega(*at);
        found.sort_by(|a, b| flux(b).total_cmp(&flux(a)).then(a.cmp(b)));
        found.truncate(MOST);
        let mut rest = map.image().clone();
        let mut lights = Vec::new();
        for at in found {
            let around = around(at);
            let mean: [f32; 3] = std::array::from_fn(|c| {
                let sum: f32 = around.iter().map(|k| pixels[*k][c]).sum();
                (sum / around.len() as f32).min(pixels[at][c])
            });
            let (x, y) = ((at % size.0) as f64 + 0.5, (at / size.0) as f64 + 0.5);
            let shown = projection.direction(size, x, y);
            let direction = shown.unwrap_or_else(|| projection.nearest_direction(size, x, y));
            let excess = |c: usize| f64::from(pixels[at][c]) - f64::from(mean[c]);
            lights.push((direction, std::array::from_fn(|c| excess(c) * omega(at))));
            rest.pixels[at] = mean;
        }
        let rest = IlluminationMap::new(rest, projection).ok()?;
        Some((Lights(lights), rest))
    }

    /// Adds Σ flux · lobe · scale to a picture.
    pub(super) fn add(&self, request: &Request, scale: f64, image: &mut Image) {
        let own = picture(request, |n| {
            let mut sum = [0.0; 3];
            for (l, flux) in &self.0 {
                let x = (0..3).map(|k| n[k] * l[k]).sum::<f64>();
                let value = scale * request.lobe.value(x.clamp(-1.0, 1.0));
                sum = std::array::from_fn(|c| sum[c] + value * flux[c]);
            }
            sum
        });
        for (sum, own) in image.pixels.iter_mut().zip(&own.pixels) {
            *sum = std::array::from_fn(|c| sum[c] + own[c]);
        }
    }
}
