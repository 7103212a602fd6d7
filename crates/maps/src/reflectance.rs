//! Reflectance by incidence, by angle from the mirror direction and by colour: the table that section 9 of the 1984
//! text asks for.
//!
//! How a surface without grain reflects is a function of three numbers: the incidence of the view, the direction of the
//! light about the mirror direction, which has two, and for each colour another. Blurred by all of it, a map would have
//! four dimensions: two of the normal and two of the eye. Where lobes are round about the mirror direction it has
//! three: R and the incidence. That is what J. Kautz and M. McCool keep ("Approximation of Glossy Reflection with
//! Prefiltered Environment Maps", Graphics Interface 2000).

use crate::columns::columns;
use crate::{Error, Lobe, Normalise, ReflectionMap, Request, convolve};
use environment::{IlluminationMap, Image, Projection};

/// A reflectance table.
#[derive(Debug, Clone, PartialEq)]
pub struct Reflectance {
    /// Incidences in degrees from the normal, ascending in 0..=90, each with its lobe in red, green and blue; `None`
    /// for black.
    lobes: Vec<(f64, [Option<Lobe>; 3])>,
}

/// Angles and values.
type Pairs = Vec<(f64, f64)>;

const EXPECTED: &str = "an incidence, an angle and a value, or red, green and blue,";

impl Reflectance {
    /// The table in a text. Its first line names the columns: `incidence degrees value` or `incidence degrees red green
    /// blue`. Each other line has the incidence of the view and the angle from the mirror direction, both in degrees,
    /// and what is reflected there per steradian: BRDF times cosine. Numbers are apart by commas, semicolons or blanks;
    /// `#` begins a comment. Incidences ascend, and angles within each.
    ///
    /// ```
    /// use ambake_maps::Reflectance;
    /// let table = "incidence degrees value\n0 0 0.3\n0 90 0\n80 0 0.9\n80 60 0\n";
    /// assert_eq!(Reflectance::parse(table)?.incidences(), [0.0, 80.0]);
    /// # Ok::<(), ambake_maps::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Line`] with the first line that is none, [`Error::Lobe`] with the first incidence that is out of range
    /// or order or has no lobe.
    pub fn parse(text: &str) -> Result<Reflectance, Error> {
        let wrong = |line| Error::Line {
            line,
            expected: EXPECTED,
        };
        let columns = columns(text).map_err(wrong)?;
        let colors = match columns.heading.as_slice() {
            ["incidence", "degrees", "value"] => 1,
            ["incidence", "degrees", "red", "green", "blue"] => 3,
            _ => {
                return Err(Error::Line {
                    line: columns.first.max(1),
                    expected: "`incidence degrees value` or `incidence degrees red green blue`",
                });
            }
        };
        let mut groups: Vec<(f64, [Pairs; 3])> = Vec::new();
        for (line, values) in &columns.rows {
            if values.len() != 2 + colors {
                return Err(wrong(*line));
            }
            let incidence = values[0];
            if groups.last().is_none_or(|(last, _)| *last != incidence) {
                groups.push((incidence, Default::default()));
            }
            let (_, pairs) = groups.last_mut().expect("one was pushed");
            for (c, pairs) in pairs.iter_mut().enumerate() {
                pairs.push((values[1], values[2 + c.min(colors - 1)]));
            }
        }
        let sound = groups.iter().all(|(a, _)| (0.0..=90.0).contains(a));
        if groups.is_empty() || !sound || !groups.is_sorted_by(|a, b| a.0 < b.0) {
            return Err(Error::Lobe("incidences ascend in 0..90 degrees".into()));
        }
        let mut lobes = Vec::new();
        for (incidence, pairs) in groups {
            let lobe = |pairs: Pairs| -> Result<Option<Lobe>, Error> {
                if pairs.iter().all(|(_, value)| *value == 0.0) {
                    return Ok(None);
                }
                let lobe = Lobe::by_angle(pairs)?;
                lobe.check()?;
                Ok(Some(lobe))
            };
            let [red, green, blue] = pairs.map(|pairs| {
                lobe(pairs).map_err(|error| match error {
                    Error::Lobe(text) => Error::Lobe(format!("incidence {incidence}: {text}")),
                    other => other,
                })
            });
            lobes.push((incidence, [red?, green?, blue?]));
        }
        Ok(Reflectance { lobes })
    }

    /// Its incidences in degrees, ascending.
    pub fn incidences(&self) -> Vec<f64> {
        self.lobes.iter().map(|(incidence, _)| *incidence).collect()
    }

    /// S for each incidence. In radiance it is what the surface sends on: under a constant map of 1 its reflectance.
    ///
    /// # Errors
    /// As [`convolve`].
    pub fn convolve(
        &self,
        map: &IlluminationMap,
        normalise: Normalise,
        projection: Projection,
        size: (usize, usize),
    ) -> Result<Vec<ReflectionMap>, Error> {
        let normalise = match normalise {
            // The values are per steradian already.
            Normalise::Radiance => Normalise::Factor(1.0),
            other => other,
        };
        let mut requests: Vec<Request> = Vec::new();
        // Which request holds a colour of an incidence; equal lobes of neighbours share one.
        let mut numbers = Vec::new();
        for lobe in self.lobes.iter().flat_map(|(_, lobes)| lobes) {
            numbers.push(lobe.clone().map(|lobe| {
                if requests.last().is_none_or(|last| last.lobe != lobe) {
                    requests.push(Request {
                        lobe,
                        normalise,
                        projection,
                        size,
                    });
                }
                requests.len() - 1
            }));
        }
        let maps = convolve(map, &requests)?;
        let maps = numbers.chunks(3).map(|colors| {
            let mut image = Image::filled(size.0, size.1, [0.0; 3]);
            for (c, number) in colors.iter().enumerate() {
                let Some(number) = number else { continue };
                let from = &maps[*number].image().pixels;
                for (pixel, from) in image.pixels.iter_mut().zip(from) {
                    pixel[c] = from[c];
                }
            }
            Ok(ReflectionMap::new(image, projection)?)
        });
        maps.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const SIZE: (usize, usize) = (32, 16);

    fn uneven() -> IlluminationMap {
        let mut image = Image::filled(64, 32, [0.0; 3]);
        for (at, pixel) in image.pixels.iter_mut().enumerate() {
            *pixel = [at % 7, at % 11, at / 64].map(|v| 0.25 * v as f32);
        }
        IlluminationMap::new(image, Projection::Polar).unwrap()
    }

    #[test]
    fn a_constant_map_shows_the_reflectance_of_each_incidence_and_colour() {
        // Linear in the cosine from v on the mirror direction to 0 at its horizon: 2π ∫ v x dx = π v.
        let text = "incidence degrees red green blue\n\
            0 0 0.1 0.2 0\n0 90 0 0 0\n\
            60 0 0.3 0.2 0.05 # brighter at grazing\n60 90 0 0 0\n";
        let table = Reflectance::parse(text).unwrap();
        let sky = IlluminationMap::new(Image::filled(64, 32, [1.0, 2.0, 4.0]), Projection::Polar);
        let maps = table.convolve(&sky.unwrap(), Normalise::Radiance, Projection::Polar, SIZE);
        for (map, values) in maps
            .unwrap()
            .iter()
            .zip([[0.1, 0.2, 0.0], [0.3, 0.2, 0.05]])
        {
            for pixel in &map.image().pixels {
                for c in 0..3 {
                    let exact = PI * values[c] * [1.0, 2.0, 4.0][c];
                    let found = f64::from(pixel[c]);
                    assert!((found - exact).abs() < 1e-6, "{found} for {exact}");
                }
            }
        }
    }

    #[test]
    fn an_incidence_is_the_map_of_its_lobe() {
        let text = "incidence degrees value\n0,0,1\n0,45,0.25\n0,180,0\n30,0,3\n30,20,0\n";
        let table = Reflectance::parse(text).unwrap();
        let map = uneven();
        let found = table
            .convolve(&map, Normalise::Seed, Projection::Polar, SIZE)
            .unwrap();
        for (found, lobe) in found.iter().zip(["0 1\n45 .25\n180 0", "0 3\n20 0"]) {
            let lobe = Lobe::parse_table(&format!("degrees value\n{lobe}\n")).unwrap();
            let request = Request {
                lobe,
                normalise: Normalise::Seed,
                projection: Projection::Polar,
                size: SIZE,
            };
            assert_eq!(found, &convolve(&map, &[request]).unwrap()[0]);
        }
    }

    #[test]
    fn a_wrong_table_is_named_by_its_line_or_its_incidence() {
        let head = "incidence degrees value\n";
        for (text, word) in [
            (String::new(), "line 1: `incidence degrees value`"),
            ("0 0 1\n".into(), "line 1: `incidence degrees value`"),
            (format!("{head}0 0\n"), "line 2: an incidence"),
            (format!("{head}0 0 1\n0 x 1\n"), "line 3: an incidence"),
            (format!("{head}30 0 1\n0 0 1\n"), "incidences ascend"),
            (format!("{head}91 0 1\n"), "incidences ascend"),
            (format!("{head}0 0 1\n10 50 1\n10 20 0\n"), "incidence 10: "),
            (format!("{head}0 200 1\n"), "incidence 0: 200 degrees"),
            (format!("{head}0 0 -1\n"), "incidence 0: "),
        ] {
            let error = Reflectance::parse(&text).unwrap_err().to_string();
            assert!(error.contains(word), "{text:?}: {error}");
        }
    }
}
