//! `ambake bench --texels`: lightmaps judged on the surface.

use super::args::Args;
use crate::bake::prepare::prepare;
use crate::host;
use crate::outcome::{Outcome, note, say, say_json};
use ::bake::Baker;
use anyhow::Context;
use bench::texels::{self, Facts, Lit};
use layers::Layer;
use report::Output;
use serde_json::json;
use std::path::Path;

/// Runs the mode: the ten scenes, or the figures of one.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    match args.scene.as_deref() {
        Some(scene) => facts(args, scene),
        None => scenes(args),
    }
}

/// Bakes and judges the ten scenes.
fn scenes(args: &Args) -> anyhow::Result<Outcome> {
    let threads = host::set_threads(args.common.threads)?;
    let mut output = args.output.as_deref().map(Output::create).transpose()?;
    let backend = args.job.backend;
    let kind = backend.map(|choice| choice.kind());
    let rows = texels::run(kind, args.job.rays, &mut |rows| {
        if !args.common.quiet {
            for row in rows.iter().filter(|row| !row.holds()) {
                note(&format!(
                    "{} {} ({}) fails",
                    row.test, row.variant, row.backend
                ));
            }
        }
    })?;
    let mut table = texels::markdown(&rows);
    let rays = args.job.rays;
    table += &format!(
        "\nambake {}, {rays} rays a texel, {threads} threads\n",
        host::VERSION
    );
    if let Some(output) = &mut output {
        output.stage_bytes("texels.csv", texels::csv(&rows).as_bytes())?;
        output.stage_bytes("texels.md", table.as_bytes())?;
    }
    if let Some(output) = output {
        output.publish()?;
    }
    if args.common.json {
        say_json(&json!({ "schema_version": 1, "rays": rays, "rows": rows }))?;
    } else if !args.common.quiet {
        say(&table)?;
    }
    match rows.iter().filter(|row| !row.holds()).count() {
        0 => Ok(Outcome::Done),
        count => anyhow::bail!("{count} of {} criteria fail; see the table", rows.len()),
    }
}

/// Bakes one scene and counts what an artist asks first.
fn facts(args: &Args, scene: &Path) -> anyhow::Result<Outcome> {
    let mut asked = args.job.clone();
    asked.only = vec![
        Layer::Diffuse,
        Layer::StdErrDiffuse,
        Layer::Object,
        Layer::Validity,
    ];
    let job = prepare(scene, &asked, &args.common)?;
    let (world, atlas) = (job.world(), job.atlas());
    let baker = Baker::new(world, job.plan(), job.backend(), atlas, job.baker_options());
    let pages: Vec<_> = (0..atlas.page_count)
        .map(|page| {
            let mut page = baker.start(page);
            baker.run(&mut page, &());
            page
        })
        .collect();
    let facts = Facts::of(&Lit {
        world,
        atlas,
        pages: &pages,
    });
    if args.common.json {
        say_json(
            &json!({ "schema_version": 1, "scene": scene.file_name().context("no file name")?.to_string_lossy(),
                "facts": facts }),
        )?;
    } else if !args.common.quiet {
        say(&facts.text())?;
    }
    Ok(Outcome::Done)
}
