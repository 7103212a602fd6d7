//! `ambake bench`: speed against error. It needs the feature `bench`, as the figures of `render` do.

pub mod args;
#[cfg(feature = "bench")]
mod peers;
#[cfg(feature = "bench")]
pub mod run;
#[cfg(feature = "bench")]
mod stated;
#[cfg(feature = "bench")]
mod texels;

/// What a program without the measurements answers.
#[cfg(not(feature = "bench"))]
pub fn absent<T>() -> anyhow::Result<T> {
    anyhow::bail!(
        "this program was built without its measurements; `cargo build --release --features bench`, in ambake's \
         folder, builds it with them"
    )
}

/// Stands in for the measurements.
#[cfg(not(feature = "bench"))]
pub mod run {
    use super::args::Args;
    use crate::outcome::Outcome;

    /// Says how to build them.
    pub fn run(_: &Args) -> anyhow::Result<Outcome> {
        super::absent()
    }
}
