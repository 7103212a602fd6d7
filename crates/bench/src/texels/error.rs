//! Why a scene could not be judged.

/// Why a scene could not be judged.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene was refused.
    #[error("scene `{name}`: {source}")]
    Scene {
        /// The scene's name.
        name: String,
        /// What was wrong.
        source: scene::Error,
    },
    /// Its charts could not be laid out.
    #[error("scene `{name}`: {source}")]
    Layout {
        /// The scene's name.
        name: String,
        /// What was wrong.
        source: atlas::Error,
    },
    /// A backend or the planner refused it.
    #[error("scene `{name}`: {source}")]
    Bake {
        /// The scene's name.
        name: String,
        /// What was wrong.
        source: rays::Error,
    },
}
