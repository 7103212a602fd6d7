//! The weights Wd and Ws of the 1984 text: reflectance by the cosine of the angle of view.

use crate::Error;
use crate::text::rows;

/// A weight as a function of E·N.
#[derive(Debug, Clone, PartialEq)]
pub enum Weight {
    /// 1 at every angle.
    Constant,
    /// F0 + (1 − F0)(1 − E·N)⁵: C. Schlick, "An Inexpensive BRDF Model for Physically-based Rendering" (1994). F0 in 0..=1.
    Schlick(f32),
    /// Linear between (cosine, weight) pairs with ascending cosines; constant beyond the ends. Not empty.
    Table(Vec<[f32; 2]>),
}

impl Weight {
    /// The weight in a text of lines with a cosine and a weight, apart by commas or blanks; `#` begins a comment.
    ///
    /// # Errors
    /// [`Error::Line`] with the first line that is none, [`Error::Text`] where there are no lines, cosines do not ascend
    /// within 0..=1 or a weight is below 0.
    pub fn parse(text: &str) -> Result<Weight, Error> {
        let pairs: Vec<[f32; 2]> = rows::<2>(text, "a cosine and a weight")?
            .into_iter()
            .map(|pair| pair.map(|v| v as f32))
            .collect();
        let sound = |[x, w]: &[f32; 2]| (0.0..=1.0).contains(x) && w.is_finite() && *w >= 0.0;
        let ascending = pairs.windows(2).all(|p| p[0][0] < p[1][0]);
        if pairs.is_empty() || !ascending || !pairs.iter().all(sound) {
            return Err(Error::Text(
                "cosines must ascend within 0..1 and weights be 0 or above",
            ));
        }
        Ok(Weight::Table(pairs))
    }

    /// The weight at a cosine; below 0 counts as 0.
    #[inline(always)]
    pub fn at(&self, cosine: f32) -> f32 {
        let cosine = cosine.clamp(0.0, 1.0);
        match self {
            Weight::Constant => 1.0,
            Weight::Schlick(f0) => {
                let m = 1.0 - cosine;
                f0 + (1.0 - f0) * (m * m) * (m * m) * m
            }
            Weight::Table(pairs) => between(pairs, cosine),
        }
    }
}

fn between(pairs: &[[f32; 2]], cosine: f32) -> f32 {
    let after = pairs.partition_point(|p| p[0] <= cosine);
    match (after.checked_sub(1).map(|k| pairs[k]), pairs.get(after)) {
        (Some([x0, w0]), Some([x1, w1])) => w0 + (w1 - w0) * (cosine - x0) / (x1 - x0),
        (Some([_, w]), None) | (None, Some(&[_, w])) => w,
        (None, None) => unreachable!("a table of weights is not empty"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_weights_ascends_within_the_cosines() {
        let half = Weight::parse("0 1\n1 0.5 # at normal view\n").unwrap();
        assert_eq!(half, Weight::Table(vec![[0.0, 1.0], [1.0, 0.5]]));
        assert_eq!(half.at(0.5), 0.75);
        for wrong in [
            "",
            "# no lines\n",
            "0.5 1\n0.25 1\n",
            "0 1\n1.5 1\n",
            "0 -1\n",
        ] {
            let error = Weight::parse(wrong).unwrap_err().to_string();
            assert!(error.contains("ascend"), "{wrong:?}: {error}");
        }
        let error = Weight::parse("0 1\nhalf 1\n").unwrap_err().to_string();
        assert_eq!(error, "line 2: a cosine and a weight belong there");
    }
}
