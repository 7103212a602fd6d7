//! What can go wrong while light is gathered.

/// Why there are no probes or maps.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The listener asked the job to stop.
    #[error("the probes were cancelled")]
    Cancelled,
}
