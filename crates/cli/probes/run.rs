//! What the flags of `ambake probes` mean, and what is printed.

use super::args::Args;
use crate::bake::shard::{finish, given, unless_stopped};
use crate::host;
use crate::outcome::{Outcome, say, say_json, tell};
use crate::progress::{Show, count, watch};
use crate::stop::Stop;
use ambake::flags::common::Common;
use ambake::{Places, ProbeOptions, ProbeReport, Probes, Scene, Shard};
use ambient::harmonics::{MOST, matt_rms};
use glam::DVec3;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let stop = Stop::listen()?;
    let asked = Asked::of(args, &args.common)?;
    let Asked {
        scene,
        places,
        options,
    } = &asked;
    let left_out = options.lights.is_none() && args.job.bake.is_none() && !scene.lights.is_empty();
    if left_out && args.job.lights.is_none() && !args.common.quiet {
        tell(
            "warning: lights of the file are not gathered; `--lights file` takes them, `--lights none` leaves them out",
        );
    }
    if let Some(shard) = args.shard {
        return part(args, &asked, shard, &stop);
    }
    let resume = args.runs.resume();
    let gathered = watch(show(&args.common), &stop, |progress| {
        Probes::gather_into(scene, places, options, (&args.output, resume), progress)
    });
    match unless_stopped(gathered, &args.common)? {
        None => Ok(stop.outcome()),
        Some(probes) => write(args, &args.common, &args.output, probes, started),
    }
}

/// Gathers the part.
fn part(args: &Args, asked: &Asked, shard: Shard, stop: &Stop) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let given = given()?;
    let place = (args.output.as_path(), shard, &given);
    let gathered = watch(show(&args.common), stop, |progress| {
        Probes::gather_shard(&asked.scene, &asked.places, &asked.options, place, progress)
    });
    let Some(part) = unless_stopped(gathered, &args.common)? else {
        return Ok(stop.outcome());
    };
    let facts = json!({"places": part.places, "faces": part.faces});
    let words = format!("{} places, {} faces", part.places, part.faces);
    let of = (shard, part.path.as_path(), part.already);
    finish(&args.common, of, (facts, &words), started)
}

/// What is to be gathered.
pub struct Asked {
    pub scene: Scene,
    pub places: Places,
    pub options: ProbeOptions,
}

impl Asked {
    /// What was typed, with `common` in place of its own.
    pub fn of(args: &Args, common: &Common) -> anyhow::Result<Self> {
        host::set_threads(common.threads)?;
        let scene = ambake::load_with(&args.scene, common.files())?;
        let options = args.job.options(&scene, args.common.seed)?;
        let places = args.job.places();
        Ok(Self {
            scene,
            places,
            options,
        })
    }
}

pub fn show(common: &Common) -> Show {
    Show {
        unit: "probes",
        quiet: common.quiet,
    }
}

/// Writes what was gathered, and prints what came out.
pub fn write(
    args: &Args,
    common: &Common,
    dir: &Path,
    mut probes: Probes,
    started: Instant,
) -> anyhow::Result<Outcome> {
    let written = probes.write(dir, &args.engines)?;
    let seconds = started.elapsed().as_secs_f64();
    if common.json {
        let report = probes.report();
        say_json(&json!({
            "schema_version": 1, "scene": args.scene, "options": report.options, "probes": report.probes.len(),
            "grid": report.grid, "moved": moved(report), "invalid": invalid(report),
            "interpolated": interpolated(report), "std_err": std_err(report),
            "interpolation": report.interpolation, "reflections": report.reflections, "files": report.files,
            "written": written, "seconds": seconds,
        }))?;
    } else if !common.quiet {
        say(&summary(probes.report(), &written, seconds))?;
    }
    Ok(Outcome::Done)
}

fn moved(report: &ProbeReport) -> usize {
    report
        .probes
        .iter()
        .filter(|probe| probe.asked.is_some())
        .count()
}

fn invalid(report: &ProbeReport) -> usize {
    report.probes.iter().filter(|probe| probe.invalid).count()
}

fn interpolated(report: &ProbeReport) -> usize {
    let probes = report.probes.iter();
    probes.filter(|probe| probe.interpolated).count()
}

/// Root mean square of the standard errors of the light E / π, over probes, normals and channels.
fn std_err(report: &ProbeReport) -> f64 {
    let square = |probe: &ambake::ProbeRecord| {
        let mut errors = [DVec3::ZERO; MOST];
        for (error, stated) in errors.iter_mut().zip(&probe.std_err) {
            *error = DVec3::from(stated.map(f64::from));
        }
        matt_rms(&errors).length_squared() / 3.0
    };
    let sum: f64 = report.probes.iter().map(square).sum();
    (sum / report.probes.len().max(1) as f64).sqrt()
}

fn summary(report: &ProbeReport, written: &[PathBuf], seconds: f64) -> String {
    let mut text = String::new();
    if !report.probes.is_empty() {
        text += &of_probes(report);
    }
    if let Some(of) = &report.interpolation {
        let share = 100.0 * of.rms / of.mean.max(f64::MIN_POSITIVE);
        text += &format!(
            "linear interpolation at {} places in the air: mean light {:.3e}, RMS error {:.1e} ({share:.1} %), p99 \
             {:.1e}; {:.1e} of it is noise\n",
            of.places, of.mean, of.rms, of.p99, of.noise
        );
    }
    for of in &report.reflections {
        let level = |level: &ambake::ReflectionLevel| {
            format!("{:.1}: {:.1e}", level.roughness, level.error)
        };
        let levels: Vec<String> = of.levels.iter().map(level).collect();
        text += &format!(
            "{}: standard error by roughness {}\n",
            of.specular,
            levels.join(", ")
        );
    }
    for path in written {
        text += &format!("wrote {}\n", path.display());
    }
    text + &format!("{seconds:.1} s\n")
}

/// How many probes there are, and their error.
fn of_probes(report: &ProbeReport) -> String {
    let mut text = count(report.probes.len() as u64, "probe");
    if let Some(grid) = &report.grid {
        let [x, y, z] = grid.counts;
        text += &format!(", {x} x {y} x {z}");
    }
    for (number, what) in [
        (moved(report), "moved out of solids"),
        (invalid(report), "invalid"),
        (interpolated(report), "interpolated"),
    ] {
        if number > 0 {
            text += &format!(", {number} {what}");
        }
    }
    text += &format!("\nstandard error of E/pi {:.2e}\n", std_err(report));
    text
}
