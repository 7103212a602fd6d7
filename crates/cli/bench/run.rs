//! `ambake bench`: speed against error, measured in one run.

use super::args::Args;
use crate::bake::prepare::prepare;
use crate::host;
use crate::outcome::{Outcome, note, say, say_json, tell};
use ::bake::PointSet;
use anyhow::Context;
use bench::ceiling::{Loop, Pair, ceiling, loops};
use bench::speed::{quantity, speed};
use bench::summary::{Spread, markdown, median, svg};
use bench::{Subject, burial, grain, hard, maps, samplers, tables};
use rays::{EmbreeBackend, RayBackend};
use report::Output;
use serde_json::json;
use std::path::Path;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    if args.samplers {
        return samplers(args);
    }
    if args.hard {
        return hard_cases(args);
    }
    if args.burial {
        return buried(args);
    }
    if args.maps {
        return convolution(args);
    }
    if args.tables {
        return shading(args);
    }
    if args.texels {
        return super::texels::run(args);
    }
    if args.stated {
        return super::stated::run(args);
    }
    if args.peers {
        return super::peers::run(args);
    }
    let scene = args.scene.as_deref().context("no scene was given")?;
    if args.ceiling {
        return to_ceiling(args, scene);
    }
    if args.grain {
        return grain_of(args, scene);
    }
    against_error(args, scene)
}

/// Every technique, written as rows, picture and table.
fn against_error(args: &Args, scene: &Path) -> anyhow::Result<Outcome> {
    let output = args.output.as_deref().context("no directory was given")?;
    let mut output = Output::create(output)?;
    let job = prepare(scene, &args.job, &args.common)?;
    let (world, plan, atlas) = (job.world(), job.plan(), job.atlas());
    let options = job.baker_options();
    let subject = Subject { world, plan, atlas };
    let rows = speed(subject, options, args.repeats, |row| {
        if !args.common.quiet {
            note(&format!(
                "{} {}: RMSE {:.5}, {:.3} CPU s",
                row.technique, row.effort, row.rmse, row.cpu_seconds
            ));
        }
    })?;
    let ratio = match EmbreeBackend::build(world, rayon::current_num_threads()) {
        Ok(embree) => {
            let pairs = ceiling(subject, options, &embree, &[1], args.repeats as usize)?;
            Spread::of(&pairs.iter().map(|pair| pair.ratio).collect::<Vec<_>>())
        }
        Err(_) => None,
    };
    let title = format!(
        "{}, {} texels, {} triangles, {} threads",
        job.scene().stem(),
        atlas.audit.texels,
        report::SceneReport::of(job.scene()).triangles,
        rayon::current_num_threads()
    );
    let mut csv = String::from(
        "technique,effort,repeat,rmse,estimated_rmse,cpu_seconds,wall_seconds,rays,texels\n",
    );
    for row in &rows {
        csv += &format!(
            "\"{}\",{},{},{},{},{},{},{},{}\n",
            row.technique,
            row.effort,
            row.repeat,
            row.rmse,
            row.estimated_rmse,
            row.cpu_seconds,
            row.wall_seconds,
            row.rays,
            row.texels
        );
    }
    let of = quantity(options);
    let picture = svg(&title, of, &rows);
    let mut table = markdown(&title, of, &rows, ratio);
    table += &format!(
        "\nambake {}, {}, options {}\n",
        host::VERSION,
        job.backend().describe(),
        job.options().describe()
    );
    output.stage_bytes("bench.csv", csv.as_bytes())?;
    match picture {
        Ok(picture) => output.stage_bytes("bench.svg", picture.as_bytes())?,
        // The rows are worth as much.
        Err(error) => tell(&format!("{}: {error}", scene.display())),
    }
    output.stage_bytes("bench.md", table.as_bytes())?;
    output.publish()?;
    if args.common.json {
        say_json(
            &json!({ "schema_version": 1, "ratio_to_ceiling": ratio.map(|r| r.median), "rows": rows }),
        )?;
    } else if !args.common.quiet {
        say(&table)?;
    }
    Ok(Outcome::Done)
}

/// Prints what counts as buried by each rule.
fn buried(args: &Args) -> anyhow::Result<Outcome> {
    host::set_threads(args.common.threads)?;
    let rows = burial::run()?;
    if args.common.json {
        let rules: Vec<&str> = burial::rules().collect();
        say_json(&json!({ "schema_version": 1, "rules": rules, "rows": rows }))?;
    } else if !args.common.quiet {
        say(&burial::markdown(&rows))?;
    }
    Ok(Outcome::Done)
}

/// Prints the hard cases with their verdicts.
fn hard_cases(args: &Args) -> anyhow::Result<Outcome> {
    host::set_threads(args.common.threads)?;
    let rows = hard::run()?;
    if args.common.json {
        say_json(&json!({ "schema_version": 1, "rows": rows }))?;
    } else {
        say(&hard::markdown(&rows))?;
    }
    let failed = rows.iter().filter(|row| row.status == hard::Status::Fails);
    match failed.count() {
        0 => Ok(Outcome::Done),
        count => anyhow::bail!("{count} of {} hard cases fail; see the table", rows.len()),
    }
}

/// Times of convolution beside the plain double sum, written as rows and table.
fn convolution(args: &Args) -> anyhow::Result<Outcome> {
    let threads = host::set_threads(args.common.threads)?;
    let output = args.output.as_deref().context("no directory was given")?;
    let mut output = Output::create(output)?;
    let rows = maps::maps(args.repeats as usize)?;
    let mut table = maps::markdown(&rows);
    table += &format!("\nambake {}, {threads} threads\n", host::VERSION);
    output.stage_bytes("maps.csv", maps::csv(&rows).as_bytes())?;
    output.stage_bytes("maps.md", table.as_bytes())?;
    output.publish()?;
    if args.common.json {
        say_json(&json!({ "schema_version": 1, "threads": threads, "rows": rows }))?;
    } else if !args.common.quiet {
        say(&table)?;
    }
    Ok(Outcome::Done)
}

/// Error, flicker and time of shading from tables, written as rows and tables.
fn shading(args: &Args) -> anyhow::Result<Outcome> {
    let threads = host::set_threads(args.common.threads)?;
    let output = args.output.as_deref().context("no directory was given")?;
    let mut output = Output::create(output)?;
    let speed = tables::speed(args.repeats as usize)?;
    let rows = tables::quality()?;
    let mut table = tables::markdown(&rows, &speed);
    table += &format!("\nambake {}, {threads} threads\n", host::VERSION);
    output.stage_bytes("tables.csv", tables::csv(&rows).as_bytes())?;
    output.stage_bytes("tables_speed.csv", tables::speed_csv(&speed).as_bytes())?;
    output.stage_bytes("tables.md", table.as_bytes())?;
    output.publish()?;
    if args.common.json {
        say_json(
            &json!({ "schema_version": 1, "threads": threads, "speed": speed, "rows": rows }),
        )?;
    } else if !args.common.quiet {
        say(&table)?;
    }
    Ok(Outcome::Done)
}

/// Prints the ratio of a bake to the bare loop, at one thread and at all.
fn to_ceiling(args: &Args, scene: &Path) -> anyhow::Result<Outcome> {
    let job = prepare(scene, &args.job, &args.common)?;
    let (world, plan, atlas) = (job.world(), job.plan(), job.atlas());
    let options = job.baker_options();
    let threads = rayon::current_num_threads();
    let embree = EmbreeBackend::build(world, threads)?;
    let counts: &[usize] = if threads > 1 { &[1, threads] } else { &[1] };
    let subject = Subject { world, plan, atlas };
    let repeats = args.repeats as usize;
    let pairs = ceiling(subject, options, &embree, counts, repeats)?;
    let loops = loops(subject, options, &embree, counts, repeats)?;
    if args.common.json {
        say_json(
            &json!({ "schema_version": 1, "backend": embree.describe(), "pairs": pairs, "loops": loops }),
        )?;
        return Ok(Outcome::Done);
    }
    let mut text = format!(
        "{}\n\nthreads  bake s   bare s   Mrays/s  bare Mrays/s  ratio\n",
        embree.describe()
    );
    for pair in &pairs {
        let rate = |seconds: f64| pair.rays as f64 / seconds / 1e6;
        text += &format!(
            "{:>7}  {:<7.3}  {:<7.3}  {:>7.1}  {:>12.1}  {:.3}\n",
            pair.threads,
            pair.bake_seconds,
            pair.bare_seconds,
            rate(pair.bake_seconds),
            rate(pair.bare_seconds),
            pair.ratio
        );
    }
    for &threads in counts {
        let own = || pairs.iter().filter(|pair| pair.threads == threads);
        let median = |of: fn(&Pair) -> f64| median(own().map(of).collect());
        text += &format!(
            "{threads} threads: median ratio {:.3}, {:.1} Mrays/s\n",
            median(|pair| pair.ratio),
            median(|pair| pair.rays as f64 / pair.bake_seconds) / 1e6
        );
    }
    text += "\nthreads  width  hint      Mrays/s of the wrapper, median\n";
    for &threads in counts {
        for (width, coherent) in [(16, false), (16, true), (8, false), (8, true)] {
            let own = |l: &&Loop| (l.threads, l.width, l.coherent) == (threads, width, coherent);
            let rate = |l: &Loop| l.rays as f64 / l.seconds / 1e6;
            text += &format!(
                "{threads:>7}  {width:>5}  {:<8}  {:.1}\n",
                if coherent { "coherent" } else { "none" },
                median(loops.iter().filter(own).map(rate).collect())
            );
        }
    }
    say(&text)?;
    Ok(Outcome::Done)
}

/// Prints what denoising does to bakes of few rays.
fn grain_of(args: &Args, scene: &Path) -> anyhow::Result<Outcome> {
    let job = prepare(scene, &args.job, &args.common)?;
    let (world, plan, atlas) = (job.world(), job.plan(), job.atlas());
    let subject = Subject { world, plan, atlas };
    let rows = grain::grain(subject, job.backend(), job.baker_options());
    if args.common.json {
        say_json(&json!({ "schema_version": 1, "rows": rows }))?;
        return Ok(Outcome::Done);
    }
    let title = format!("{}, {} texels", job.scene().stem(), atlas.audit.texels);
    say(&grain::markdown(&title, &rows))?;
    Ok(Outcome::Done)
}

/// Prints C = RMSE N^3/4 of each point set on each exact scene.
fn samplers(args: &Args) -> anyhow::Result<Outcome> {
    let mut rows = Vec::new();
    for footprint in [0.0, 0.3] {
        for scene in &samplers::OCCLUDERS {
            for set in [PointSet::Random, PointSet::Sobol, PointSet::Lattice] {
                for m in 2..=12 {
                    let batches = (400_000 >> m).clamp(100, 2000);
                    rows.push(samplers::measure(scene, set, 1 << m, batches, footprint));
                }
            }
        }
    }
    if args.common.json {
        say_json(&json!({ "schema_version": 1, "rows": rows }))?;
        return Ok(Outcome::Done);
    }
    let mut text = String::from("C = RMSE N^(3/4) at N =");
    for m in 2..=12 {
        text += &format!(" {:>5}", 1 << m);
    }
    for line in rows.chunks(11) {
        let first = &line[0];
        text += &format!(
            "\n{:17} {:10} {:3}",
            first.scene, first.points, first.footprint
        );
        for row in line {
            text += &format!(" {:5.3}", row.c);
        }
    }
    say(&(text + "\n"))?;
    Ok(Outcome::Done)
}
