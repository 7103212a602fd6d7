//! The weights Wd and Ws of the 1984 text: reflectance by the cosine of the angle of view, in one colour or three.

use crate::Error;
use crate::text::{heading, rows};

/// A weight as a function of E·N.
#[derive(Debug, Clone, PartialEq)]
pub enum Weight {
    /// 1 at every angle.
    Constant,
    /// F0 + (1 − F0)(1 − E·N)⁵: C. Schlick, "An Inexpensive BRDF Model for Physically-based Rendering" (1994). F0 in
    /// 0..=1.
    Schlick(f32),
    /// Linear between (cosine, red, green, blue) with ascending cosines; constant beyond the ends. Not empty.
    Table(Vec<[f32; 4]>),
}

impl Weight {
    /// The weight in a text of lines with a cosine and a weight, or red, green and blue, apart by commas or blanks; `#`
    /// begins a comment. After a first line that begins with `degrees` each line begins with the angle from the normal,
    /// ascending in 0..=90.
    ///
    /// # Errors
    /// [`Error::Line`] with the first line that is none, [`Error::Text`] where there are no lines, cosines do not
    /// ascend within 0..=1 or a weight is below 0.
    pub fn parse(text: &str) -> Result<Weight, Error> {
        let (heading, text) = heading(text, &["cosine", "degrees"]);
        let expected = "a cosine or an angle, and a weight or red, green and blue,";
        let grey = |row: Vec<f64>| match row.as_slice() {
            [x, weight] => [*x, *weight, *weight, *weight],
            row => [0, 1, 2, 3].map(|k: usize| row[k]),
        };
        let rows = rows(&text, &[2, 4], expected)?;
        let mut lines: Vec<[f64; 4]> = rows.into_iter().map(grey).collect();
        if heading == Some("degrees") {
            if !lines.iter().all(|[x, ..]| (0.0..=90.0).contains(x)) {
                return Err(Error::Text("angles must ascend within 0..90 degrees"));
            }
            lines
                .iter_mut()
                .for_each(|line| line[0] = line[0].to_radians().cos());
            lines.reverse();
        }
        let sound =
            |line: &[f64; 4]| (0.0..=1.0).contains(&line[0]) && line[1..].iter().all(|w| *w >= 0.0);
        let ascending = lines.windows(2).all(|p| p[0][0] < p[1][0]);
        if lines.is_empty() || !ascending || !lines.iter().all(sound) {
            return Err(Error::Text(
                "cosines must ascend within 0..1 and weights be 0 or above",
            ));
        }
        let lines = lines.into_iter().map(|line| line.map(|v| v as f32));
        Ok(Weight::Table(lines.collect()))
    }

    /// The weight at a cosine in red, green and blue; below 0 counts as 0.
    #[inline(always)]
    pub fn at(&self, cosine: f32) -> [f32; 3] {
        let cosine = cosine.clamp(0.0, 1.0);
        match self {
            Weight::Constant => [1.0; 3],
            Weight::Schlick(f0) => {
                let m = 1.0 - cosine;
                [f0 + (1.0 - f0) * (m * m) * (m * m) * m; 3]
            }
            Weight::Table(lines) => between(lines, cosine),
        }
    }
}

fn between(lines: &[[f32; 4]], cosine: f32) -> [f32; 3] {
    let after = lines.partition_point(|line| line[0] <= cosine);
    match (after.checked_sub(1).map(|k| lines[k]), lines.get(after)) {
        (Some(a), Some(b)) => {
            let part = (cosine - a[0]) / (b[0] - a[0]);
            [1, 2, 3].map(|c: usize| a[c] + (b[c] - a[c]) * part)
        }
        (Some([_, r, g, b]), None) | (None, Some(&[_, r, g, b])) => [r, g, b],
        (None, None) => unreachable!("a table of weights is not empty"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_weights_ascends_within_the_cosines() {
        let half = Weight::parse("0 1\n1 0.5 # at normal view\n").unwrap();
        assert_eq!(
            half,
            Weight::Table(vec![[0.0, 1.0, 1.0, 1.0], [1.0, 0.5, 0.5, 0.5]])
        );
        assert_eq!(half.at(0.5), [0.75; 3]);
        let angles =
            Weight::parse("# gold\ndegrees red green blue\n0 1 .7 .4\n60 1 .8 .6\n").unwrap();
        assert_eq!(angles.at(0.0), [1.0, 0.8, 0.6]);
        assert_eq!(angles.at(1.0), [1.0, 0.7, 0.4]);
        for wrong in [
            "",
            "# no lines\n",
            "0.5 1\n0.25 1\n",
            "0 1\n1.5 1\n",
            "degrees\n10 1\n5 1\n",
            "degrees\n0 1\n91 1\n",
            "0 -1\n",
        ] {
            let error = Weight::parse(wrong).unwrap_err().to_string();
            assert!(error.contains("ascend"), "{wrong:?}: {error}");
        }
        for (text, line) in [
            ("0 1\nhalf 1\n", 2),
            ("0 1 1 1\n1 1 1\n", 2),
            ("degrees w\n0 1\n1\n", 3),
        ] {
            let error = Weight::parse(text).unwrap_err().to_string();
            let exact = format!(
                "line {line}: a cosine or an angle, and a weight or red, green and blue, belong there"
            );
            assert_eq!(error, exact);
        }
    }
}
