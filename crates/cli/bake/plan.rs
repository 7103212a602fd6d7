//! `ambake plan`: what would be modelled and why, and what it would cost.

use super::args::Plan as Args;
use super::prepare::prepare;
use super::summary;
use crate::outcome::{Outcome, say, say_json};
use crate::progress::{count, size, square};
use ambake::{Choice, Effort, Estimate, Job, Method, Term};
use serde_json::json;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let job = prepare(&args.scene, &args.job, &args.common)?;
    let cost = job.estimate();
    if args.common.json {
        let warnings: Vec<report::WarningReport> = warnings(&job);
        say_json(&json!({
            "schema_version": 1,
            "scene": report::SceneReport::of(job.scene()),
            "options": job.options().describe(),
            "plan": job.decisions(),
            "atlas": report::AtlasReport::of(job.atlas()),
            "layout": job.layout_report(),
            "estimate": {
                "texels": cost.texels,
                "rays": cost.rays,
                "memory_bytes": cost.memory_bytes,
                "disk_bytes": cost.disk_bytes,
                "state_bytes": cost.state_bytes,
                "disk_peak_bytes": cost.disk_peak_bytes,
                "cpu_seconds": cost.cpu_seconds,
                "seconds": cost.seconds,
            },
            "backend": job.backend().describe(),
            "warnings": warnings,
        }))?;
    } else if !args.common.quiet {
        say(&text(&job, &cost))?;
    }
    Ok(Outcome::Done)
}

fn warnings(job: &Job) -> Vec<report::WarningReport> {
    job.warnings()
}

fn text(job: &Job, cost: &Estimate) -> String {
    let mut text = format!("{:<10} {:<9} {}\n", "what", "decision", "why");
    for decision in &job.plan().decisions {
        let word = if decision.modelled {
            "modelled"
        } else {
            "left out"
        };
        text += &format!(
            "{:<10} {word:<9} {}\n",
            decision.choice.name(),
            decision.reason
        );
    }
    text += &format!(
        "\n{} texels on {} of {}, {}\nabout {} rays, {} of memory, {:.1} s ({:.1} processor seconds) with {}\n\
         about {} on the disk, {} of it for --update; {} while it bakes\n",
        cost.texels,
        count(job.atlas().page_count, "page"),
        square(job.atlas().page_size),
        effort(job),
        cost.rays,
        size(cost.memory_bytes),
        cost.seconds,
        cost.cpu_seconds,
        job.backend().describe(),
        size(cost.disk_bytes),
        size(cost.state_bytes),
        size(cost.disk_peak_bytes),
    );
    text += &job.layout_report().text();
    text += &summary::lines(&warnings(job));
    text
}

/// What is cast for each texel.
fn effort(job: &Job) -> String {
    let by_rays = |term| job.plan().method(term) == Method::Rays;
    cast(
        job.options().effort,
        by_rays(Term::Diffuse) || by_rays(Term::Visibility),
        by_rays(Term::Specular),
        job.plan().models(Choice::Sky),
    )
}

/// The rays of a texel in words: over the hemisphere, over the specular lobe, and as many again from an illumination
/// map.
fn cast(effort: Effort, hemisphere: bool, lobe: bool, map: bool) -> String {
    let over = match (hemisphere, lobe) {
        (true, true) => "over the hemisphere, and over the specular lobe as many as it is worth",
        (true, false) => "over the hemisphere",
        (false, true) => "over the specular lobe",
        (false, false) => return "no rays: every term has a closed form or is left out".into(),
    };
    let each = match effort {
        Effort::Rays(rays) => format!("{rays} rays"),
        Effort::Target {
            error,
            relative,
            max_rays,
        } => {
            let or = match relative {
                0.0 => String::new(),
                _ => format!(" or of {relative} of the value"),
            };
            format!("rays to a standard error of {error}{or}, at most {max_rays},")
        }
    };
    let drawn = match map {
        true => ", and as many again drawn from the map",
        false => "",
    };
    format!("{each} each {over}{drawn}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rays_that_are_cast_are_named() {
        let rays = Effort::Rays(64);
        assert_eq!(
            cast(rays, true, false, false),
            "64 rays each over the hemisphere"
        );
        assert_eq!(
            cast(rays, true, true, false),
            "64 rays each over the hemisphere, and over the specular lobe as many as it is worth"
        );
        assert_eq!(
            cast(rays, false, true, true),
            "64 rays each over the specular lobe, and as many again drawn from the map"
        );
        assert_eq!(
            cast(rays, false, false, false),
            "no rays: every term has a closed form or is left out"
        );
        let target = Effort::Target {
            error: 0.01,
            relative: 0.0,
            max_rays: 4096,
        };
        assert_eq!(
            cast(target, false, true, false),
            "rays to a standard error of 0.01, at most 4096, each over the specular lobe"
        );
    }
}
