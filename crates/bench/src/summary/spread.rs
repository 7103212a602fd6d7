//! The middle and the ends of repeated measurements.

use std::fmt;

/// The median of repeats with the least and the most of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// The middle one, or the mean of the two in the middle.
    pub median: f64,
    /// The least.
    pub min: f64,
    /// The most.
    pub max: f64,
    /// How many there are, at least 1.
    pub repeats: usize,
}

impl Spread {
    /// Of these repeats; `None` of none.
    pub fn of(values: &[f64]) -> Option<Spread> {
        let fold = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick);
        Some(Spread {
            median: median(values.to_vec()),
            min: fold(f64::min)?,
            max: fold(f64::max)?,
            repeats: values.len(),
        })
    }
}

/// `1.09 (1.05 to 1.12)`; the median alone of one repeat, which has no spread.
impl fmt::Display for Spread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [median, min, max] = [self.median, self.min, self.max].map(|v| rounded(v, 3));
        match self.repeats {
            1 => write!(f, "{median}"),
            _ => write!(f, "{median} ({min} to {max})"),
        }
    }
}

/// The middle of the values, or the mean of the two in the middle; 0 of none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let upper = values.len() / 2;
    match values.len() {
        0 => 0.0,
        odd if odd % 2 == 1 => values[upper],
        _ => 0.5 * (values[upper - 1] + values[upper]),
    }
}

/// A number with so many significant digits, without an exponent.
pub fn rounded(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    // Rounded as text first: 0.9996 of three digits is 1.00, not 1.000.
    let text = format!("{value:.*e}", digits as usize - 1);
    let (Some((_, exponent)), Ok(value)) = (text.split_once('e'), text.parse::<f64>()) else {
        return text;
    };
    let decimals = digits - 1 - exponent.parse::<i32>().unwrap_or(0);
    format!("{value:.*}", decimals.max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_is_between_the_two_in_the_middle() {
        assert_eq!(median(vec![4.0, 1.0]), 2.5);
        assert_eq!(median(vec![9.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(Vec::new()), 0.0);
    }

    #[test]
    fn one_repeat_shows_no_spread() {
        let text = |values: &[f64]| Spread::of(values).map(|spread| spread.to_string());
        assert_eq!(text(&[]), None);
        assert_eq!(text(&[1.0874]), Some("1.09".into()));
        let three = text(&[1.0874, 0.9996, 12.34]);
        assert_eq!(three, Some("1.09 (1.00 to 12.3)".into()));
    }

    #[test]
    fn numbers_keep_their_significant_digits() {
        let cases = [
            (55_353.6, 2, "55000"),
            (0.034_31, 2, "0.034"),
            (1.4464, 2, "1.4"),
            (0.005, 1, "0.005"),
            (-12.34, 3, "-12.3"),
            (0.0, 3, "0"),
        ];
        for (value, digits, text) in cases {
            assert_eq!(rounded(value, digits), text, "{value} of {digits} digits");
        }
    }
}
