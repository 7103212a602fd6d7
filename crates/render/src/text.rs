//! Tables of numbers in text files: weights, camera paths.

use crate::Error;

/// Lines of `N` finite numbers apart by commas or blanks; `#` begins a comment, empty lines are left out.
///
/// # Errors
/// [`Error::Line`] with the number of the first other line, and that `expected` belongs there.
pub(crate) fn rows<const N: usize>(
    text: &str,
    expected: &'static str,
) -> Result<Vec<[f64; N]>, Error> {
    let mut rows = Vec::new();
    for (at, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let words = line.split([' ', '\t', ',', '\r']).filter(|w| !w.is_empty());
        let values: Option<Vec<f64>> = words.map(finite).collect();
        match values.map(<[f64; N]>::try_from) {
            Some(Ok(row)) => rows.push(row),
            Some(Err(values)) if values.is_empty() => {}
            _ => {
                return Err(Error::Line {
                    line: at + 1,
                    expected,
                });
            }
        }
    }
    Ok(rows)
}

fn finite(word: &str) -> Option<f64> {
    word.parse().ok().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_through_comments_and_any_separator() {
        let text = "# a heading\n1,2\r\n\n 3\t4 # a key\n-5e1 , 0.5\n";
        let found = rows::<2>(text, "two numbers").unwrap();
        assert_eq!(found, [[1.0, 2.0], [3.0, 4.0], [-50.0, 0.5]]);
    }

    #[test]
    fn a_line_that_is_no_row_is_named() {
        for (text, wrong) in [
            ("1 2\n3\n", 2),
            ("1 2 3\n", 1),
            ("\n1 x\n", 2),
            ("inf 1", 1),
        ] {
            let error = rows::<2>(text, "two numbers").unwrap_err().to_string();
            assert_eq!(error, format!("line {wrong}: two numbers belong there"));
        }
    }
}
