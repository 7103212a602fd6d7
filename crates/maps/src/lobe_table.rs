//! Reflectance functions from measured tables.

use crate::columns::columns;
use crate::{Error, Lobe};

impl Lobe {
    /// The lobe in a text of lines with a cosine and a value, apart by commas, semicolons or blanks; `#` begins a
    /// comment. After a first line `degrees value` each line begins with the angle from the mirror direction in
    /// 0..=180.
    ///
    /// # Errors
    /// [`Error::Line`] with the first line that is none; [`Error::Lobe`] for angles beyond 180 degrees and for what
    /// [`Lobe::check`] refuses.
    pub fn parse_table(text: &str) -> Result<Lobe, Error> {
        let wrong = |line| Error::Line {
            line,
            expected: "a cosine or an angle and a value",
        };
        let columns = columns(text).map_err(wrong)?;
        let degrees = match columns.heading.as_slice() {
            [] | ["cosine", _] => false,
            ["degrees", _] => true,
            _ => return Err(wrong(columns.first)),
        };
        let mut pairs = Vec::new();
        for (line, values) in &columns.rows {
            let [x, value] = values.as_slice() else {
                return Err(wrong(*line));
            };
            pairs.push((*x, *value));
        }
        let lobe = match degrees {
            true => Lobe::by_angle(pairs)?,
            false => Lobe::Table(pairs),
        };
        lobe.check()?;
        Ok(lobe)
    }

    /// The lobe of pairs of an angle in degrees, ascending, and a value.
    pub(crate) fn by_angle(mut pairs: Vec<(f64, f64)>) -> Result<Lobe, Error> {
        if let Some((angle, _)) = pairs.iter().find(|(x, _)| !(0.0..=180.0).contains(x)) {
            return Err(Error::Lobe(format!(
                "{angle} degrees; an angle lies in 0..180"
            )));
        }
        pairs
            .iter_mut()
            .for_each(|pair| pair.0 = pair.0.to_radians().cos());
        pairs.reverse();
        Ok(Lobe::Table(pairs))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_cosines_are_the_same_lobe() {
        let cosines = Lobe::parse_table("# x\ncosine;value\n-1 0\n0,0\n1\t1\n").unwrap();
        assert_eq!(
            cosines,
            Lobe::Table(vec![(-1.0, 0.0), (0.0, 0.0), (1.0, 1.0)])
        );
        let angles = Lobe::parse_table("degrees,value\n0,1\n90,0\n180,0\n").unwrap();
        for x in [-1.0, -0.5, 0.0, 0.25, 1.0] {
            let (a, b) = (angles.value(x), cosines.value(x));
            // The cosine of 90 degrees is 6e-17.
            assert!((a - b).abs() < 1e-15, "{a} for {b} at {x}");
        }
    }

    #[test]
    fn a_wrong_table_is_named_by_its_line_or_its_number() {
        for (text, word) in [
            ("0.5 1\nhalf one\n", "line 2"),
            ("0.5 1\ndegrees value\n", "line 2"),
            ("0.5 1 2\n", "line 1"),
            ("degrees value\n0 1\n200 1\n", "200 degrees"),
            ("0.5 1\n0.2 1\n", "ascending"),
            ("", "ascending"),
        ] {
            let error = Lobe::parse_table(text).unwrap_err().to_string();
            assert!(error.contains(word), "{text:?}: {error}");
        }
    }
}
