//! The flags of `ambake bake` and `ambake probes`: the one table from which the command line, `ambake.toml`, the
//! keyword arguments of Python and the table of docs/flags.md are read.
//!
//! A new option is a field of [`bake::Job`] with its line in [`bake::Job::bake`], and one of [`crate::Options`] with
//! its setter. `crates/cli/tables.rs` writes what the documents and Python's stubs say of it.

pub mod bake;
pub mod common;
pub mod keywords;
pub mod parse;
pub mod probes;
pub mod sky;
pub mod values;
#[cfg(feature = "cli")]
mod words;

use crate::error::Error;
use crate::scene::Scene;
pub use clap::Parser;

/// What a function may be asked for that bakes a scene.
#[derive(Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
pub struct Bake {
    #[command(flatten)]
    pub job: bake::Job,
    #[command(flatten)]
    pub engines: bake::Engines,
    #[command(flatten)]
    pub earlier: bake::Earlier,
    #[command(flatten)]
    pub common: common::Common,
}

impl Bake {
    /// The bake that was asked for.
    ///
    /// # Errors
    /// The sky's picture cannot be read.
    pub fn bake(self, scene: &Scene) -> Result<crate::Bake, Error> {
        let mut bake = self.job.bake(scene, &self.common)?;
        bake = bake
            .for_engines(self.engines.engines)
            .compress(self.engines.compress);
        if let Some(dir) = self.earlier.update {
            bake = bake.update(dir).verify(self.earlier.verify);
        }
        Ok(match self.common.threads {
            Some(threads) => bake.threads(threads as usize),
            None => bake,
        })
    }
}

/// What a function may be asked for that gathers probes.
#[derive(Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
pub struct Probes {
    #[command(flatten)]
    pub job: probes::Job,
    #[command(flatten)]
    pub common: common::Common,
}
