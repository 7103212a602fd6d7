//! What was typed: the verbs. Each has its own arguments.

use crate::{bake, bench, fit, map, probes, render};
use ambake::flags::bake::Job;
use ambake::flags::common::Common;
use ambake::flags::values::engine;
use clap::{Arg, Args as ClapArgs, Command, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Ambient-reflection lightmap baker that states its error.
#[derive(Parser)]
#[command(name = "ambake", version = crate::host::VERSION, max_term_width = 100)]
pub struct Args {
    #[command(subcommand)]
    pub verb: Verb,
}

impl Args {
    /// What these words say.
    ///
    /// # Errors
    /// Those of clap, help and version among them.
    pub fn of(words: Vec<OsString>) -> Result<Self, clap::Error> {
        let found = Self::grammar().try_get_matches_from(words)?;
        Self::from_arg_matches(&found)
    }

    /// What may be typed, and its help.
    pub fn grammar() -> Command {
        let unused = bake::args::Unused::augment_args(Command::new("unused"));
        let is_unused = |arg: &Arg| unused.get_arguments().any(|of| of.get_id() == arg.get_id());
        let hide = |arg: Arg| match is_unused(&arg) {
            true => arg.hide(true),
            false => arg,
        };
        lenient(Self::command().mut_subcommand("layout", |layout| layout.mut_args(hide)))
    }
}

/// What was typed, the program's name and a verb first. A scene in the place of the verb is baked.
pub fn words() -> Vec<OsString> {
    let mut words: Vec<OsString> = std::env::args_os().collect();
    if words.get(1).is_some_and(|word| is_scene(word.as_ref())) {
        words.insert(1, "bake".into());
    }
    words
}

impl Verb {
    /// The options of a bake, of the verbs that take them and a scene.
    pub fn options(&self) -> Option<(&Job, &Common)> {
        match self {
            Verb::Bake(bake) => Some((&bake.job, &bake.common)),
            Verb::Plan(plan) => Some((&plan.job, &plan.common)),
            Verb::Watch(watch) => Some((&watch.job, &watch.common)),
            Verb::Layout(layout) => Some((&layout.job, &layout.common)),
            Verb::Bench(bench) => Some((&bench.job, &bench.common)),
            _ => None,
        }
    }
}

fn is_scene(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    ["obj", "gltf", "glb"].iter().any(|known| ending == *known)
}

/// A number below 0 is the value of its flag, which says what belongs there, and no unknown flag. Of a flag
/// that stands twice the last one counts.
fn lenient(command: Command) -> Command {
    let command = command.mut_args(|arg| {
        let is_value = !arg.is_positional() && arg.get_action().takes_values();
        arg.allow_negative_numbers(is_value)
    });
    command.args_override_self(true).mut_subcommands(lenient)
}

#[derive(Subcommand)]
pub enum Verb {
    /// Bakes a scene: lightmap atlas, previews, glTF and bake.json
    Bake(bake::args::Bake),
    /// Says what a bake of this scene would model and why, and what it would cost
    Plan(bake::args::Plan),
    /// Bakes a scene whenever its files are saved: with a sixteenth of the rays, a fourth, and all of them, until the
    /// next save
    Watch(bake::args::Watch),
    /// The atlas alone: the layout that a bake of this scene makes, to look at and for the shards of a bake
    Layout(bake::args::LayoutArgs),
    /// The parts of `bake --shard I/N` into the files of a whole bake, and those of `probes`
    Merge(bake::args::Merge),
    /// Traditional against Lambert against Phong from a finished bake, or any two EXR pages
    Compare(Compare),
    /// Files for engines from a finished bake
    Export(Export),
    /// A picture of a scene through a camera, shaded by an ambient model and lights
    Render(Box<render::args::Args>),
    /// Light for what moves: what arrives at places in the air from all directions, as harmonics with their errors
    Probes(Box<probes::args::Args>),
    /// Diffuse and specular reflectance and exponent of a known shape, from pictures of it in ambient light
    Fit(Box<fit::Args>),
    /// Illumination maps and reflection maps: convert, convolve, measure
    #[command(subcommand)]
    Map(Box<map::args::Args>),
    /// Speed against error: CSV, SVG and a readable summary; needs a program built with `--features bench`
    Bench(bench::args::Args),
    /// Writes DIR/report.html, one file to look at a finished bake in a browser, and opens it
    View(View),
    /// Prints the completions of a shell
    Completions(Completions),
    /// Prints the manual page, or writes one for each verb
    Man(Man),
    /// Tells which ray libraries were really loaded and what they can do; exit 1 if one is unusable
    Doctor(Doctor),
}

#[derive(ClapArgs)]
pub struct Compare {
    /// A finished bake's directory, or two EXR pages
    #[arg(num_args = 1..=2, required = true, value_name = "DIR | A.exr B.exr")]
    pub paths: Vec<PathBuf>,
    /// Directory for the difference pictures [default: the bake's directory; with two pages, none are written]
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print a machine-readable summary on standard output
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(ClapArgs)]
pub struct Export {
    /// A finished bake's directory; the files are written into it, and bake.json lists them
    pub dir: PathBuf,
    /// Engines, separated by commas: gltf, three, blender, bevy, godot, unity, unreal
    #[arg(long = "for", value_name = "ENGINE,..", value_delimiter = ',', required = true, value_parser = engine)]
    pub engines: Vec<ambake::Engine>,
    /// Compress the lightmaps of three and bevy for the graphics processor, an eighth as large: BC6H in place of
    /// uncompressed KTX2, and occlusion as BC7
    #[arg(long)]
    pub compress: bool,
    /// Print a machine-readable summary on standard output
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(ClapArgs)]
pub struct View {
    /// A finished bake's directory
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Write the file and open no browser
    #[arg(long)]
    pub no_open: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(ClapArgs)]
pub struct Completions {
    /// Shell that completes
    #[arg(value_enum)]
    pub shell: Shell,
}

#[derive(ClapArgs)]
pub struct Man {
    /// Directory for one page a verb, `ambake.1`, `ambake-bake.1`, … [default: `ambake.1` goes to standard output]
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub output: Option<PathBuf>,
}

#[derive(ClapArgs)]
pub struct Doctor {
    /// Print a machine-readable summary on standard output
    #[arg(long)]
    pub json: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verbs_with_many_flags_say_under_headings_what_they_do_and_the_short_help_is_short() {
        let grammar = Args::grammar();
        for verb in ["bake", "plan", "watch", "layout", "probes", "render"] {
            let command = grammar.find_subcommand(verb).expect("the verb");
            let flags = || command.get_arguments().filter(|arg| !arg.is_positional());
            for arg in flags().filter(|arg| !arg.is_hide_set()) {
                let name = arg.get_long().unwrap_or_default();
                let has_none = arg.get_help_heading().is_none();
                assert!(
                    !has_none || name == "help",
                    "{verb}: --{name} stands under no heading"
                );
            }
            let short = flags().filter(|arg| !arg.is_hide_short_help_set());
            assert!(short.count() <= 27, "{verb} -h is for what is needed most");
        }
    }
}
