//! What was typed after the verbs that bake.

use crate::map;
use ambake::Resume;
use ambake::flags::bake::{Earlier, Engines, Job};
use ambake::flags::common::Common;
use ambake::flags::values::shard;
use clap::Args as ClapArgs;
use std::path::{Path, PathBuf};

#[derive(ClapArgs)]
pub struct Bake {
    /// Scene file: .obj, .gltf or .glb, or - for standard input; several are baked into a folder each, DIR/STEM
    #[arg(required = true)]
    pub scene: Vec<PathBuf>,
    #[command(flatten)]
    pub job: Job,
    /// Directory for the results; it is made if needed [default: SCENE with the ending .ambake, beside the scene]
    #[arg(help_heading = "Files")]
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub engines: Engines,
    #[command(flatten)]
    pub runs: Runs,
    /// Bake part I of N of the texels, I from 1; all parts share DIR, in any order and on any machine, and `ambake
    /// merge DIR` makes one bake of them. A part that was stopped continues
    #[arg(help_heading = "Runs", hide_short_help = true)]
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<ambake::Shard>,
    #[command(flatten)]
    pub earlier: Earlier,
    /// Also write DIR/report.html, one file to look at the bake in a browser, as `ambake view` does
    #[arg(help_heading = "Files")]
    #[arg(long)]
    pub report: bool,
    /// Of several scenes so many are done, and so many of these were not baked: how the program goes on where the
    /// system refused it memory
    #[arg(long, hide = true, num_args = 2, value_names = ["DONE", "FAILED"])]
    pub after: Vec<usize>,
    #[command(flatten)]
    pub common: Common,
}

impl Bake {
    /// The folder of a scene: what was asked for, of several scenes one in it for each, or else one beside the scene.
    pub fn folder(&self, scene: &Path) -> PathBuf {
        let is_input = scene == Path::new("-");
        match (&self.output, &self.scene[..]) {
            (Some(folder), [_]) => folder.clone(),
            (Some(folder), _) if is_input => folder.join("scene"),
            (Some(folder), _) => folder.join(scene.file_stem().unwrap_or_default()),
            (None, _) if is_input => "scene.ambake".into(),
            (None, _) => scene.with_extension("ambake"),
        }
    }
}

/// What becomes of the state that an interrupted run left.
#[derive(ClapArgs)]
pub struct Runs {
    /// Start anew, also where an interrupted run of the same scene and options left its state in DIR; without it the
    /// run goes on from there
    #[arg(help_heading = "Runs", hide_short_help = true)]
    #[arg(long)]
    pub fresh: bool,
    /// Refuse what has the place of that state and cannot be one, such as a link
    #[arg(long, hide = true, conflicts_with = "fresh")]
    pub resume: bool,
}

impl Runs {
    /// As the library calls it.
    pub fn resume(&self) -> Resume {
        match (self.fresh, self.resume) {
            (true, _) => Resume::Never,
            (_, true) => Resume::Asked,
            _ => Resume::IfFound,
        }
    }
}

#[derive(ClapArgs)]
pub struct LayoutArgs {
    /// Scene file: .obj, .gltf or .glb
    pub scene: PathBuf,
    #[command(flatten)]
    pub job: Job,
    /// Directory for the results; it is made if needed
    #[arg(help_heading = "Files")]
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,
    #[command(flatten)]
    pub unused: Unused,
    #[command(flatten)]
    pub common: Common,
}

/// Flags of `bake` that change no layout: one command line serves the layout and the parts.
#[derive(ClapArgs)]
pub struct Unused {
    #[command(flatten)]
    pub engines: Engines,
    #[arg(long)]
    pub report: bool,
    #[command(flatten)]
    pub runs: Runs,
}

#[derive(ClapArgs)]
pub struct Merge {
    /// The directory that all parts share; the results go there too
    pub dir: PathBuf,
    #[command(flatten)]
    pub common: map::args::Common,
    /// Also print the plan and the time of each phase
    #[arg(short = 'v', long)]
    pub verbose: bool,
}

#[derive(ClapArgs)]
pub struct Watch {
    /// Scene file: .obj, .gltf or .glb
    pub scene: PathBuf,
    #[command(flatten)]
    pub job: Job,
    /// Directory for the results; it is made if needed
    #[arg(help_heading = "Files")]
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: PathBuf,
    #[command(flatten)]
    pub engines: Engines,
    #[command(flatten)]
    pub common: Common,
}

#[derive(ClapArgs)]
pub struct Plan {
    /// Scene file: .obj, .gltf or .glb, or - for standard input
    pub scene: PathBuf,
    #[command(flatten)]
    pub job: Job,
    #[command(flatten)]
    pub common: Common,
}
