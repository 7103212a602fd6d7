//! How a picture of unknown brightness is shown so that it can be seen.

use environment::Image;
use glam::{DVec3, Vec3};

/// Keys that are shown as they are. A key is the mean of the logarithm of what surfaces send out.
const SEEN: std::ops::RangeInclusive<f64> = 0.18..=1.2;

/// Share of the surfaces whose lights may burn.
const BURNT: f64 = 0.01;

/// What nothing can be told from: darker than this, and than this share of the lights that may not burn.
const BLACK: f32 = 1e-6;
const DARK: f32 = 1e-3;

/// Stops by which a picture is brightened, and the lights that it is then to show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Powers of two.
    pub stops: f64,
    /// The radiance of the brightest surfaces, 1 or more.
    pub lights: f32,
}

impl Exposure {
    /// So many stops, and nothing else.
    pub fn of_stops(stops: f64) -> Self {
        Self { stops, lights: 1.0 }
    }

    /// Of what a picture shows of surfaces, `picture` being their light before black and `alpha` their share of each
    /// pixel: no stops where their key lies between 0.18 and 1.2, otherwise those that bring it there. What is black
    /// beside the rest has no part in the key. Its lights are what a hundredth of the surfaces is brighter than.
    pub fn of(picture: &Image, alpha: &[f32]) -> Self {
        let surfaces = picture.pixels.iter().zip(alpha);
        let surfaces = surfaces.filter(|(_, alpha)| **alpha >= 0.5);
        let bright = |(p, alpha): (&[f32; 3], &f32)| bright(Vec3::from(*p)) / alpha;
        let mut bright: Vec<f32> = surfaces.map(bright).collect();
        bright.sort_unstable_by(f32::total_cmp);
        let last = bright.len().saturating_sub(1);
        let Some(&lights) = bright.get(((1.0 - BURNT) * last as f64) as usize) else {
            return Self::of_stops(0.0);
        };
        let lit = &bright[bright.partition_point(|&value| value <= BLACK.max(DARK * lights))..];
        if lit.is_empty() {
            return Self::of_stops(0.0);
        }
        let logs = lit.iter().map(|&value| f64::from(value).log2());
        let key = logs.sum::<f64>() / lit.len() as f64;
        let stops = key.clamp(SEEN.start().log2(), SEEN.end().log2()) - key;
        Self {
            stops,
            lights: (lights * stops.exp2() as f32).max(1.0),
        }
    }

    /// How a radiance is shown. Where lights are brighter than 1, all is drawn together below white, dark the least,
    /// and keeps its hue: E. Reinhard, M. Stark, P. Shirley, J. Ferwerda, "Photographic Tone Reproduction for Digital
    /// Images" (2002), equation 4. Their white is the lights' power of 3/2, so that these come close to it and do not
    /// burn.
    pub fn tone(&self, radiance: Vec3) -> Vec3 {
        let light = radiance * self.stops.exp2() as f32;
        if self.lights == 1.0 {
            return light;
        }
        let bright = bright(light);
        light * ((1.0 + bright / self.lights.powi(3)) / (1.0 + bright))
    }

    /// The picture as it is shown.
    pub fn shown(&self, mut picture: Image) -> Image {
        for pixel in &mut picture.pixels {
            *pixel = self.tone(Vec3::from(*pixel)).to_array();
        }
        picture
    }
}

/// How bright a radiance is.
fn bright(radiance: Vec3) -> f32 {
    radiance.y.max(0.5 * (radiance.x + radiance.z))
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
        for (value, factor) in [
            (0.3, 1.0),
            (0.19, 1.0),
            (0.02, 9.0),
            (9.0, 1.2 / 9.0),
            (0.0, 1.0),
        ] {
            // What lies beside surfaces does not count.
            let found = Exposure::of(&picture(&[value, 100.0]), &[1.0, 0.0]);
            assert!((found.stops.exp2() - factor).abs() < 1e-6, "{value}");
        }
        // Two thirds see nothing; the rest is shown.
        let found = Exposure::of(&picture(&[0.0, 0.0, 0.0, 0.0, 0.01, 0.01]), &[1.0; 6]);
        assert!((found.stops.exp2() - 18.0).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn lights_beside_a_dark_room_keep_their_order_below_white() {
        let mut values = vec![0.02; 60];
        values.extend((1..=40).map(|k| 0.05 * k as f32));
        let picture = picture(&values);
        let exposure = Exposure::of(&picture, &[1.0; 100]);
        let logs = values.iter().map(|value| value.log2());
        let key = (logs.sum::<f32>() / 100.0).exp2();
        assert!((exposure.stops.exp2() as f32 - 0.18 / key).abs() < 1e-5);
        let shown = exposure.shown(picture).pixels;
        let shown: Vec<f32> = shown.iter().map(|p| p[0]).collect();
        assert!(shown.windows(2).skip(60).all(|pair| pair[0] < pair[1]));
        assert!((0.7..1.0).contains(&shown[98]), "{shown:?}");
        let dark = 0.02 * 0.18 / key;
        assert!(
            (0.9 * dark..dark).contains(&shown[0]),
            "{dark} is {}",
            shown[0]
        );
    }

    #[test]
    fn a_pale_head_over_a_dark_coat_keeps_its_hue_and_does_not_burn() {
        let mut pixels = vec![[0.02; 3]; 80];
        pixels.extend([[0.8, 0.7, 0.6]; 20]);
        let picture = Image {
            width: 100,
            height: 1,
            pixels,
        };
        let exposure = Exposure::of(&picture, &[1.0; 100]);
        let shown = exposure.shown(picture).pixels;
        let [coat, head] = [shown[0], shown[99]];
        assert!(coat[0] > 0.05 && head[0] < 1.0, "{coat:?} {head:?}");
        assert!((head[2] / head[0] - 0.75).abs() < 1e-6, "{head:?}");
    }

    #[test]
    fn what_does_not_burn_is_shown_as_it_is() {
        let plain = picture(&[0.2, 0.5, 0.9]);
        let same = Exposure::of(&plain, &[1.0; 3]).shown(plain.clone());
        assert_eq!(same.pixels, plain.pixels);
    }
}
