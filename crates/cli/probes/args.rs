//! What was typed after `ambake probes`.

use crate::bake::args::Runs;
use ambake::flags::common::Common;
use ambake::flags::probes::Job;
use ambake::flags::values::{engine, shard};
use clap::Args as ClapArgs;
use std::path::PathBuf;

#[derive(ClapArgs)]
pub struct Args {
    /// Scene file: .obj, .gltf or .glb
    pub scene: PathBuf,
    /// Directory for the results; it is made if needed
    #[arg(help_heading = "Files")]
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,
    /// Also write files for these engines, separated by commas: bevy, three, unity, godot; with --reflections gltf and
    /// blender too
    #[arg(help_heading = "Files")]
    #[arg(long = "for", value_name = "ENGINE,..", value_delimiter = ',', value_parser = engine)]
    pub engines: Vec<ambake::Engine>,
    #[command(flatten)]
    pub job: Job,
    #[command(flatten)]
    pub runs: Runs,
    /// Gather part I of N, I from 1; all parts share DIR, in any order and on any machine, and `ambake merge DIR` makes
    /// the files of all. A part that was stopped continues
    #[arg(help_heading = "Runs", hide_short_help = true)]
    #[arg(long, value_name = "I/N", conflicts_with = "refine", value_parser = shard)]
    pub shard: Option<ambake::Shard>,
    #[command(flatten)]
    pub common: Common,
}
