//! Cases that break bakers: each baked on every backend and held against its exact value.
//!
//! A case is a small chart at a known point, so that the mean over its texels is the value at that point, and what stands
//! above it. Its bound is four of the standard errors that the bake itself states, plus what rays of a finite number can
//! resolve, plus how far the triangles are from the shape of the formula (computed on the triangles by the polygon
//! formulas, or bounded in the case). Where single precision cannot hold the case, the case names the bound that does.

mod cases;
mod input;
mod judge;
mod setup;

pub use cases::{Case, Expected, TableEntry, cases};
pub use judge::{Row, Status, run};
pub use setup::Setup;

/// Why a case could not be judged.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A backend or the planner refused a scene.
    #[error("hard case `{case}`: {source}")]
    Bake {
        /// The case's name.
        case: String,
        /// What was wrong.
        source: rays::Error,
    },
    /// A broken input file could not be written.
    #[error(
        "hard case `{case}`: cannot write its scene to the temporary directory, free some space: {source}"
    )]
    Write {
        /// The case's name.
        case: String,
        /// What was wrong.
        source: std::io::Error,
    },
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
