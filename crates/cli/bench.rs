//! `ambake bench`: speed against error, measured in one run.

use crate::args::Bench as Args;
use crate::bake::{Phases, Prepared, prepare};
use crate::{Outcome, host, say};
use ::bake::{EmbreeBackend, PointSet};
use anyhow::Context;
use bench::ceiling::{Pair, ceiling};
use bench::{Subject, hard, samplers};
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
    let scene = args.scene.as_deref().context("no scene was given")?;
    if args.ceiling {
        return to_ceiling(args, scene);
    }
    anyhow::bail!("not yet")
}

/// Prints the hard cases with their verdicts.
fn hard_cases(args: &Args) -> anyhow::Result<Outcome> {
    host::set_threads(args.common.threads)?;
    let rows = hard::run()?;
    if args.common.json {
        let text = json!({ "schema_version": 1, "rows": rows });
        say(&format!("{}\n", serde_json::to_string_pretty(&text)?))?;
    } else {
        say(&hard::markdown(&rows))?;
    }
    let failed = rows.iter().filter(|row| row.status == hard::Status::Fails);
    match failed.count() {
        0 => Ok(Outcome::Done),
        count => anyhow::bail!("{count} of {} hard cases fail; see the table", rows.len()),
    }
}

/// Prints the ratio of a bake to the bare loop, at one thread and at all.
fn to_ceiling(args: &Args, scene: &Path) -> anyhow::Result<Outcome> {
    let mut phases = Phases::default();
    let prepared = prepare(scene, &args.job, &args.common, &mut phases)?;
    let Prepared {
        atlas,
        plan,
        world,
        options,
        ..
    } = &prepared;
    let threads = rayon::current_num_threads();
    let embree = EmbreeBackend::build(world, threads)?;
    let counts: &[usize] = if threads > 1 { &[1, threads] } else { &[1] };
    let pairs = ceiling(
        Subject { world, plan, atlas },
        options,
        &embree,
        counts,
        args.repeats as usize,
    )?;
    if args.common.json {
        let text = json!({ "schema_version": 1, "pairs": pairs });
        say(&format!("{}\n", serde_json::to_string_pretty(&text)?))?;
        return Ok(Outcome::Done);
    }
    let mut text = String::from("threads  bake s   bare s   Mrays/s  bare Mrays/s  ratio\n");
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
    say(&text)?;
    Ok(Outcome::Done)
}

/// The median of at least one value.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
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
        let text = json!({ "schema_version": 1, "rows": rows });
        say(&format!("{}\n", serde_json::to_string_pretty(&text)?))?;
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
