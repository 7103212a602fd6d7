//! What was typed after `ambake bench`.

use ambake::flags::bake::Job;
use ambake::flags::common::Common;
use ambake::flags::parse::whole;
use clap::Args as ClapArgs;
use std::path::PathBuf;

#[derive(ClapArgs)]
pub struct Args {
    /// Scene file: .obj, .gltf or .glb
    #[arg(required_unless_present_any = ["burial", "samplers", "hard", "maps", "peers", "stated", "tables", "texels"])]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub job: Job,
    /// Directory for bench.csv, bench.svg and bench.md; it is made if needed
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    #[arg(required_unless_present_any = ["burial", "samplers", "ceiling", "grain", "hard", "stated", "texels"])]
    pub output: Option<PathBuf>,
    /// Only the ratio of a bake to the bare loop of rtcOccluded16 over its packets
    #[arg(long, conflicts_with = "samplers")]
    pub ceiling: bool,
    /// Only bakes of few rays, plain and denoised, against one of many: a Markdown table
    #[arg(long, conflicts_with_all = ["samplers", "ceiling"])]
    pub grain: bool,
    /// Only the error of the point sets on four exact scenes
    #[arg(long)]
    pub samplers: bool,
    /// Only the cases that break bakers, on every backend: a Markdown table; exit 1 if one fails
    #[arg(long, conflicts_with_all = ["scene", "samplers", "ceiling"])]
    pub hard: bool,
    /// Only the convolution of maps against the plain double sum: maps.csv and maps.md in DIR
    #[arg(long, conflicts_with_all = ["scene", "samplers", "ceiling", "hard"])]
    pub maps: bool,
    /// Only shading from reflection maps: error and flicker of each look-up, frames a second; tables.csv,
    /// tables_speed.csv and tables.md in DIR
    #[arg(long, conflicts_with_all = ["scene", "samplers", "ceiling", "hard", "maps"])]
    pub tables: bool,
    /// Only the ten scenes that break lightmaps, judged on their surfaces: a Markdown table, with -o also texels.csv
    /// and texels.md in DIR; exit 1 if one fails. With a scene: page use, buried texels, seams and grain of its bake
    #[arg(long, conflicts_with_all = ["samplers", "ceiling", "hard", "maps", "tables"])]
    pub texels: bool,
    /// Only stated errors beside true ones, of a bake of a quarter of --rays and of all of them: a Markdown table, with
    /// -o also stated.md in DIR. Without a scene five are made by --seed
    #[arg(long, conflicts_with_all = ["samplers", "ceiling", "grain", "hard", "maps", "tables", "texels"])]
    pub stated: bool,
    /// Only what counts as buried, by the rule of a bake and by others, on small scenes whose hidden parts are known: a
    /// Markdown table
    #[arg(long, conflicts_with_all = ["scene", "samplers", "ceiling", "grain", "hard", "maps", "tables", "texels"])]
    pub burial: bool,
    /// Only other programs on the same texels of three generated scenes: peers.csv, peers.svg and peers.md in DIR. They
    /// are installed from PyPI into DIR/peers.work (bpy, mitsuba, open3d, pymeshlab); what cannot be is skipped
    #[arg(long)]
    #[arg(conflicts_with_all = ["scene", "samplers", "ceiling", "grain", "hard", "maps", "stated", "tables", "texels"])]
    pub peers: bool,
    /// The Python that --peers runs; its version decides which bpy fits
    #[arg(
        long,
        value_name = "PATH",
        default_value = "python3",
        requires = "peers"
    )]
    pub python: PathBuf,
    /// Repeats of every measurement
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole::<u32>(1..=100))]
    pub repeats: u32,
    #[command(flatten)]
    pub common: Common,
}
