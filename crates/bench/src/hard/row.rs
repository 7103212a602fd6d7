//! What is known of a case once it was judged: rows, and the table of them.

use serde::Serialize;

/// One term of one case on one backend.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The case.
    pub case: String,
    /// What is compared: a term's layer, or what is counted.
    pub term: String,
    /// `embree`, `obvhs`, or `load` for what the loader decides.
    pub backend: String,
    /// The exact value.
    pub expected: f64,
    /// The mean over the page; for an exact case the texel farthest off.
    pub baked: f64,
    /// Absolute difference.
    pub off: f64,
    /// The largest difference that passes.
    pub bound: f64,
    /// The verdict.
    pub status: Status,
    /// What the bound is made of.
    pub why: String,
    /// Hash of the bits of every texel, for comparing libraries; 0 where nothing is baked.
    pub bits: u64,
}

/// The verdict on a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Within its bound.
    Holds,
    /// Off by more than sampling explains, within the bound that single precision is given and the row names.
    SingleLimit,
    /// Beyond its bound.
    Fails,
}

/// A row about a number of things, which is exact or wrong.
pub(super) fn count(
    case: &str,
    term: &str,
    backend: &str,
    expected: usize,
    found: usize,
    why: &str,
) -> Row {
    Row {
        case: case.into(),
        term: term.into(),
        backend: backend.into(),
        expected: expected as f64,
        baked: found as f64,
        off: expected.abs_diff(found) as f64,
        bound: 0.0,
        status: if expected == found {
            Status::Holds
        } else {
            Status::Fails
        },
        why: why.into(),
        bits: 0,
    }
}

/// FNV-1a over the bits of the values.
pub(super) fn hash(values: &[f32]) -> u64 {
    values
        .iter()
        .flat_map(|v| v.to_bits().to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
}

/// The rows as a Markdown table: one line for each term of a case, with what every backend gives.
pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| case | term | expected | baked | bound | status | why |\n|---|---|---|---|---|---|---|\n",
    );
    let same = |a: &Row, b: &Row| a.case == b.case && a.term == b.term;
    for (index, first) in rows.iter().enumerate() {
        if rows[..index].iter().any(|row| same(row, first)) {
            continue;
        }
        let all: Vec<&Row> = rows.iter().filter(|row| same(row, first)).collect();
        let baked: Vec<String> = all
            .iter()
            .map(|row| format!("{} {:.7}", row.backend, row.baked))
            .collect();
        // Backends that agree to the bit stand once.
        let equal = all
            .iter()
            .all(|row| row.bits == first.bits && row.baked == first.baked);
        let baked = match equal {
            true => format!("{:.7}", first.baked),
            false => baked.join(", "),
        };
        let status = |status| all.iter().any(|row| row.status == status);
        let status = if status(Status::Fails) {
            "FAILS"
        } else if status(Status::SingleLimit) {
            "f32 limit"
        } else {
            "holds"
        };
        let bound = all.iter().map(|row| row.bound).fold(0.0, f64::max);
        text += &format!(
            "| {} | {} | {:.7} | {baked} | {bound:.1e} | {status} | {} |\n",
            first.case, first.term, first.expected, first.why
        );
    }
    text
}
