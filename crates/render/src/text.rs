//! Tables of numbers in text files: weights, camera paths.

use crate::Error;

/// Lines of finite numbers apart by commas or blanks, all as many as in the first, whose number is one of `lengths`;
/// `#` begins a comment, empty lines are left out.
///
/// # Errors
/// [`Error::Line`] with the number of the first other line, and that `expected` belongs there.
pub fn rows(text: &str, lengths: &[usize], expected: &'static str) -> Result<Vec<Vec<f64>>, Error> {
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for (at, line) in text.lines().enumerate() {
        let words = words(line);
        if words.is_empty() {
            continue;
        }
        let values: Option<Vec<f64>> = words.into_iter().map(finite).collect();
        let fits = |row: &Vec<f64>| match rows.first() {
            Some(first) => row.len() == first.len(),
            None => lengths.contains(&row.len()),
        };
        let row = values.filter(fits).ok_or(Error::Line {
            line: at + 1,
            expected,
        })?;
        rows.push(row);
    }
    Ok(rows)
}

/// Which of `known` the first line begins with, and the text with that line left empty.
pub(crate) fn heading<'a>(text: &str, known: &[&'a str]) -> (Option<&'a str>, String) {
    let mut lines: Vec<&str> = text.lines().collect();
    let first = lines.iter().position(|line| !words(line).is_empty());
    let word = first.map(|at| words(lines[at])[0]);
    let found = known.iter().find(|known| Some(**known) == word).copied();
    if let (Some(at), Some(_)) = (first, found) {
        lines[at] = "";
    }
    (found, lines.join("\n"))
}

fn words(line: &str) -> Vec<&str> {
    let line = line.split('#').next().unwrap_or_default();
    let words = line.split([' ', '\t', ',', '\r']);
    words.filter(|word| !word.is_empty()).collect()
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
        let found = rows(text, &[2], "two numbers").unwrap();
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
            let error = rows(text, &[2], "two numbers").unwrap_err().to_string();
            assert_eq!(error, format!("line {wrong}: two numbers belong there"));
        }
    }
}
