//! How a picture of unknown brightness is shown so that it can be seen.

use glam::DVec3;
use maps::Image;

/// Medians that can be seen as they are.
const SEEN: std::ops::RangeInclusive<f32> = 0.08..=1.2;

/// What other medians are brought near.
const MIDDLE: f64 = 0.3;

/// Radiance above which lights are drawn together where some would burn.
const SHOULDER: f32 = 0.7;

/// Share of the surfaces whose lights may burn.
const BURNT: f64 = 0.01;

/// What nothing can be told from.
const BLACK: f32 = 1e-6;

/// Stops by which a picture is brightened, and the radiance that is then shown as white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Powers of two.
    pub stops: f64,
    /// 1 or more. What lies below is drawn together from 0.7 on, in a curve that starts straight and keeps colours
    /// apart.
    pub white: f32,
}

impl Exposure {
    /// So many stops, and nothing else.
    pub fn of_stops(stops: f64) -> Self {
        Self { stops, white: 1.0 }
    }

    /// Of what a picture shows of surfaces, `picture` being their light before black and `alpha` their share of each
    /// pixel: none where their median lies between 0.08 and 1.2, otherwise whole stops that bring it near 0.3. Where
    /// most is black, the median is that of the rest.
    pub fn of(picture: &Image, alpha: &[f32]) -> Self {
        let surfaces = picture.pixels.iter().zip(alpha);
        let surfaces = surfaces.filter(|(_, alpha)| **alpha >= 0.5);
        let bright = |(p, alpha): (&[f32; 3], &f32)| p[1].max(0.5 * (p[0] + p[2])) / alpha;
        let mut bright: Vec<f32> = surfaces.map(bright).collect();
        bright.sort_unstable_by(f32::total_cmp);
        let Some(&last) = bright.last() else {
            return Self::of_stops(0.0);
        };
        let at = |bright: &[f32], share: f64| bright[(share * (bright.len() - 1) as f64) as usize];
        let lit = bright.partition_point(|&value| value <= BLACK.max(1e-3 * last));
        let median = match at(&bright, 0.5) {
            median if median > BLACK => median,
            _ if lit < bright.len() => at(&bright[lit..], 0.5),
            _ => return Self::of_stops(0.0),
        };
        let stops = match SEEN.contains(&median) {
            true => 0.0,
            false => (MIDDLE / f64::from(median)).log2().round(),
        };
        let white = at(&bright, 1.0 - BURNT) * stops.exp2() as f32;
        Self {
            stops,
            white: white.max(1.0),
        }
    }

    /// The picture as it is shown.
    pub fn shown(&self, mut picture: Image) -> Image {
        let factor = self.stops.exp2() as f32;
        let [above, below] = [self.white - SHOULDER, 1.0 - SHOULDER];
        for value in picture.pixels.iter_mut().flatten() {
            *value *= factor;
            if self.white > 1.0 && *value > SHOULDER {
                // Slope 1 where it starts, and 1 where white is.
                let along = (*value - SHOULDER) / above;
                let bend = above / below;
                *value = SHOULDER + below * bend * along / (1.0 + (bend - 1.0) * along);
            }
        }
        picture
    }
}

/// What is shown behind the lit scene, whatever its exposure: a pale blue, so that white surfaces stand out; black
/// where there is no sky.
pub fn backdrop(sky: DVec3) -> DVec3 {
    match sky == DVec3::ZERO {
        true => DVec3::ZERO,
        false => DVec3::new(0.5, 0.65, 0.85),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(values: &[f32]) -> Image {
        Image {
            width: values.len(),
            height: 1,
            pixels: values.iter().map(|&value| [value; 3]).collect(),
        }
    }

    #[test]
    fn only_pictures_that_cannot_be_seen_are_exposed_otherwise() {
        for (value, stops) in [
            (0.3, 0.0),
            (0.09, 0.0),
            (0.02, 4.0),
            (9.0, -5.0),
            (0.0, 0.0),
        ] {
            // What lies beside surfaces does not count.
            let found = Exposure::of(&picture(&[value, 100.0]), &[1.0, 0.0]);
            assert_eq!(found.stops, stops, "{value}");
        }
        // Two thirds see nothing; the rest is shown.
        let found = Exposure::of(&picture(&[0.0, 0.0, 0.0, 0.0, 0.01, 0.01]), &[1.0; 6]);
        assert_eq!(found.stops, 5.0);
    }

    #[test]
    fn lights_beside_a_dark_room_keep_their_order_below_white() {
        let mut values = vec![0.02; 60];
        values.extend((1..=40).map(|k| 0.05 * k as f32));
        let picture = picture(&values);
        let exposure = Exposure::of(&picture, &[1.0; 100]);
        assert_eq!(exposure.stops, 4.0);
        let shown: Vec<f32> = exposure
            .shown(picture)
            .pixels
            .iter()
            .map(|p| p[0])
            .collect();
        assert!(shown.is_sorted(), "{shown:?}");
        let burnt = shown.iter().filter(|value| **value > 1.0).count();
        assert!(burnt <= 1 && (shown[0] - 0.32).abs() < 1e-6, "{shown:?}");
        assert!(shown[80] < shown[90] && shown[90] < shown[98]);
        // Nothing burns without: what is shown is what is there.
        let plain = self::picture(&[0.2, 0.5, 0.9]);
        let same = Exposure::of(&plain, &[1.0; 3]).shown(plain.clone());
        assert_eq!(same.pixels, plain.pixels);
    }
}
