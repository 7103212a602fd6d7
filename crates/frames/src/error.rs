//! What can go wrong before or while a frame is made.

/// A failure with one line that says what to change.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A frame cannot be seen, or the listener asked to stop.
    #[error(transparent)]
    Render(#[from] render::Error),
    /// A map cannot be used.
    #[error(transparent)]
    Map(#[from] environment::Error),
    /// A map cannot be blurred.
    #[error(transparent)]
    Blur(#[from] maps::Error),
    /// The camera of a frame has no direction or no upright.
    #[error("frame {frame}: {source}")]
    Frame {
        /// Number of the frame, from 0.
        frame: u32,
        /// What is wrong with the camera.
        source: render::Error,
    },
    /// Reflection maps that do not belong together.
    #[error("{0}")]
    Tables(String),
}
