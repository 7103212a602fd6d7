//! Tables of numbers in text files, with or without a heading.

/// What a text holds.
pub(crate) struct Columns<'a> {
    /// The words of the first line, where they are not all numbers.
    pub heading: Vec<&'a str>,
    /// Number of that line, from 1.
    pub first: usize,
    /// Each other line's number, and its numbers.
    pub rows: Vec<(usize, Vec<f64>)>,
}

/// The columns of a text, apart by commas, semicolons or blanks; `#` begins a comment, empty lines are left out.
///
/// # Errors
/// The number of the first line, but for a heading, that does not hold numbers alone.
pub(crate) fn columns(text: &str) -> Result<Columns<'_>, usize> {
    let mut found = Columns {
        heading: Vec::new(),
        first: 0,
        rows: Vec::new(),
    };
    for (at, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let separator = |c: char| c == ',' || c == ';' || c.is_whitespace();
        let words: Vec<_> = line.split(separator).filter(|w| !w.is_empty()).collect();
        if words.is_empty() {
            continue;
        }
        let values: Result<Vec<f64>, _> = words.iter().map(|w| w.parse()).collect();
        match values {
            Ok(values) => found.rows.push((at + 1, values)),
            Err(_) if found.first == 0 => found.heading = words,
            Err(_) => return Err(at + 1),
        }
        if found.first == 0 {
            found.first = at + 1;
        }
    }
    Ok(found)
}
