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
        source: bake::Error,
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

/// The rows as a Markdown table.
pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| case | term | backend | expected | baked | off by | bound | status | why |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let status = match row.status {
            Status::Holds => "holds".into(),
            Status::SingleLimit => format!("f32 limit: {:.1e}", row.bound),
            Status::Fails => "FAILS".into(),
        };
        text += &format!(
            "| {} | {} | {} | {:.9} | {:.9} | {:.1e} | {:.1e} | {status} | {} |\n",
            row.case, row.term, row.backend, row.expected, row.baked, row.off, row.bound, row.why
        );
    }
    text
}
