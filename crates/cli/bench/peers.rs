//! `ambake bench --peers`: the same texels by ambake and by other programs.
//!
//! The other programs are Python packages. They are installed into an environment of their own under the output folder,
//! and a script runs everybody in turns; what cannot be installed is skipped.

use super::args::Args;
use crate::outcome::{Outcome, note, say};
use anyhow::{Context, bail};
use report::Output;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The scripts, by file name.
const SCRIPTS: [(&str, &str); 8] = [
    (
        "generate.py",
        include_str!("../../bench/scenes/generate.py"),
    ),
    ("run.py", include_str!("../../bench/peers/run.py")),
    ("mesh.py", include_str!("../../bench/peers/mesh.py")),
    ("summary.py", include_str!("../../bench/peers/summary.py")),
    (
        "bake_cycles.py",
        include_str!("../../bench/peers/bake_cycles.py"),
    ),
    (
        "bake_mitsuba.py",
        include_str!("../../bench/peers/bake_mitsuba.py"),
    ),
    (
        "bake_open3d.py",
        include_str!("../../bench/peers/bake_open3d.py"),
    ),
    (
        "bake_pymeshlab.py",
        include_str!("../../bench/peers/bake_pymeshlab.py"),
    ),
];

/// Packages that bake, from PyPI.
const PEERS: [&str; 4] = ["bpy", "mitsuba", "open3d", "pymeshlab"];

/// The generated scenes that are baked.
const SCENES: [&str; 3] = ["room", "displaced", "colonnade"];

/// Runs the mode.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let out = args.output.as_deref().context("no directory was given")?;
    if args.repeats < 2 {
        bail!("--peers needs --repeats of 2 or more: errors come from pairs of bakes");
    }
    let work = out.join("peers.work");
    let scripts = work.join("scripts");
    let mut output = Output::create(&scripts)?;
    for (name, text) in SCRIPTS {
        output.stage_bytes(name, text.as_bytes())?;
    }
    output.publish()?;
    let python = environment(&args.python, &work.join("venv"))?;
    let scenes = work.join("scenes");
    for scene in SCENES {
        if !scenes.join(format!("{scene}.obj")).exists() {
            let mut command = Command::new(&python);
            command.arg(scripts.join("generate.py")).arg(&scenes);
            finished(command.args(["--only", scene]))?;
        }
    }
    let mut command = Command::new(&python);
    command.arg(scripts.join("run.py")).arg(&scenes);
    command.arg(work.join("bakes")).arg(out);
    command.args(["--repeats", &args.repeats.to_string()]);
    command.args(["--size", &args.job.size.to_string()]);
    command.args(["--rays", &args.job.rays.to_string()]);
    command.env("AMBAKE", std::env::current_exe()?);
    finished(&mut command)?;
    let table = out.join("peers.md");
    let table = std::fs::read_to_string(&table).with_context(|| table.display().to_string())?;
    if !args.common.quiet {
        say(&table)?;
    }
    Ok(Outcome::Done)
}

/// The Python of an environment with numpy and with every peer that can be installed, made where it is not there.
fn environment(python: &Path, folder: &Path) -> anyhow::Result<PathBuf> {
    let own = folder.join("bin").join("python");
    if !own.exists() {
        finished(Command::new(python).args(["-m", "venv"]).arg(folder))?;
    }
    let install = |package: &str| {
        let mut command = Command::new(&own);
        command.args(["-m", "pip", "install", "--quiet", "--only-binary=:all:"]);
        finished(command.arg("--disable-pip-version-check").arg(package))
    };
    install("numpy").context("numpy could not be installed, which every comparison needs")?;
    for peer in PEERS {
        if install(peer).is_err() {
            note(&format!("skip {peer}: it could not be installed"));
        }
    }
    Ok(own)
}

/// Runs a command to its end. What it prints goes to standard error, for standard output is the table's.
fn finished(command: &mut Command) -> anyhow::Result<()> {
    let name = command.get_program().to_string_lossy().into_owned();
    command.stdin(Stdio::null()).stdout(std::io::stderr());
    let status = command.status().with_context(|| {
        format!("{name} could not be started; --peers needs Python, which --python PATH names")
    })?;
    if !status.success() {
        let arguments: Vec<_> = command.get_args().map(|a| a.to_string_lossy()).collect();
        bail!("{name} {} ended with {status}", arguments.join(" "));
    }
    Ok(())
}
