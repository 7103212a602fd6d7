//! Finds out whether a scene is an interior: there the sky reaches little, and a limit of distance shows more.

use crate::options::Options;
use ::bake::Bounces;
use report::WarningReport;

/// Bins of the diffuse term, over 0..=1.
const BINS: usize = 100;
/// At this median of the diffuse term or below, half of the scene hardly sees the sky.
const DARK: f64 = 0.1;
/// Where no more of the texels than this share see a hundredth of the sky, next to no light gets in.
const LEAKS: f64 = 0.001;
/// So many of the outsides of rooms may be texels that the share of the surface does not tell: borders of charts.
const BORDERS: f64 = 1.0 / 64.0;

/// How many texels have which diffuse term, over all pages.
#[derive(Debug, Clone)]
pub(crate) struct Brightness([u64; BINS]);

impl Default for Brightness {
    fn default() -> Self {
        Self([0; BINS])
    }
}

impl Brightness {
    /// Adds the covered texels of a page.
    pub fn add(&mut self, diffuse: &[f32], coverage: &[f32]) {
        for (value, _) in diffuse.iter().zip(coverage).filter(|(_, c)| **c > 0.0) {
            self.0[((value * BINS as f32) as usize).min(BINS - 1)] += 1;
        }
    }

    /// The warning that names `--bounces` and `--max-distance`, where the median is dark and neither was given; bounces
    /// help only where some light gets in. None where there are lamps. So many of the brightest texels are those of
    /// `outsides` of rooms, which nobody within sees.
    pub fn interior(
        &self,
        options: &Options,
        has_lamps: bool,
        outsides: u64,
    ) -> Option<WarningReport> {
        let dark: u64 = self.0[..(DARK * BINS as f64) as usize].iter().sum();
        let all = self.0.iter().sum::<u64>().saturating_sub(outsides);
        let lit = all.saturating_sub(self.0[0]);
        let is_closed = lit as f64 <= LEAKS * all as f64 + BORDERS * outsides as f64;
        let bounces = options.bounces != Bounces::Off && !is_closed;
        let helped = options.max_distance.is_some() || has_lamps || bounces;
        let message = match is_closed {
            true => {
                "next to no light of the sky gets in: all is closed, and between surfaces there is nothing to \
                 send on; `--max-distance D` shows corners and contacts, with D about a third of a room's height, \
                 and `--point` or `--sphere` puts a lamp inside"
                    .into()
            }
            false => format!(
                "most texels see less than {:.0} % of the sky, as in a room or inside of a machine; `--bounces auto` \
                 lets light go on from surface to surface there, and `--max-distance D` shows corners and contacts, \
                 with D about a third of a room's height",
                100.0 * DARK
            ),
        };
        (!helped && all > 0 && 2 * dark > all).then(|| WarningReport {
            kind: "interior".into(),
            place: "scene".into(),
            count: dark,
            message,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dark_median_is_an_interior_unless_a_distance_or_bounces_were_given() {
        let mut pages = Brightness::default();
        pages.add(
            &[0.02, 0.05, 0.7, 0.0, 0.0, 0.0],
            &[1.0, 0.3, 1.0, 0.0, 0.0, 0.0],
        );
        let warning = pages
            .interior(&Options::default(), false, 0)
            .expect("two of three covered texels are dark");
        assert!(warning.message.contains("--max-distance"));
        assert!(warning.message.contains("--bounces"));
        let (mut limited, mut bounced) = (Options::default(), Options::default());
        (limited.max_distance, bounced.bounces) = (Some(1.0), Bounces::Auto);
        assert!(pages.interior(&limited, false, 0).is_none());
        assert!(pages.interior(&bounced, false, 0).is_none());
        pages.add(&[0.9], &[1.0]);
        assert!(
            pages.interior(&Options::default(), false, 0).is_none(),
            "half is not most"
        );
        assert!(
            pages.interior(&Options::default(), false, 2).is_some(),
            "two of three, but for what lies outside"
        );
    }

    #[test]
    fn where_no_light_gets_in_nothing_is_said_of_bounces() {
        let mut pages = Brightness::default();
        pages.add(&[0.0004; 5000], &[1.0; 5000]);
        let closed = pages
            .interior(&Options::default(), false, 0)
            .expect("all is dark");
        assert!(closed.message.contains("--max-distance") && !closed.message.contains("bounces"));
        let bounced = Options {
            bounces: Bounces::Auto,
            ..Options::default()
        };
        let still = pages
            .interior(&bounced, false, 0)
            .map(|warning| warning.message);
        assert_eq!(still, Some(closed.message), "there is nothing to send on");
        assert!(
            pages.interior(&bounced, true, 0).is_none(),
            "a lamp is in it"
        );
        pages.add(&[0.05; 50], &[1.0; 50]);
        let lit = pages
            .interior(&Options::default(), false, 0)
            .expect("most is dark");
        assert!(lit.message.contains("--bounces"));
    }
}
