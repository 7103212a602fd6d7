//! Why a case could not be judged.

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
