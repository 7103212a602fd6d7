//! `ambake plan`: what would be modelled and why, and what it would cost.

use super::args::Plan as Args;
use super::options;
use super::run::{Phases, Prepared, decisions, prepare, warnings};
use crate::host;
use crate::outcome::{Outcome, say, say_json};
use ::bake::{Bake, Choice, Effort};
use serde_json::json;

/// Tiles baked to estimate the rate of the rest.
const PILOT_TILES: usize = 24;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let mut phases = Phases::default();
    let prepared = prepare(&args.scene, &args.job, &args.common, &mut phases)?;
    let Prepared {
        scene,
        atlas,
        plan,
        world,
        backend,
        options,
        sky,
        ..
    } = &prepared;
    let bake = Bake::new(world, plan, backend.as_ref(), atlas, options);
    let (pilot_texels, pilot_rays, pilot_seconds) = bake.pilot(PILOT_TILES);
    let texels = atlas.audit.texels;
    let share = texels as f64 / pilot_texels.max(1) as f64;
    let rays = (pilot_rays as f64 * share).round() as u64;
    let seconds = pilot_seconds * share;
    let page_texels = u64::from(atlas.page_size).pow(2);
    let channels: u64 = options
        .layers
        .iter()
        .map(|layer| layer.channels().len() as u64)
        .sum();
    let memory = host::peak_memory().unwrap_or(0) + page_texels * channels * 4 * 2;
    if args.common.json {
        let plan = json!({
            "schema_version": 1,
            "scene": report::SceneReport::of(scene),
            "options": options::describe(&args.job, options, sky),
            "plan": decisions(plan),
            "atlas": report::AtlasReport::of(atlas),
            "estimate": { "texels": texels, "rays": rays, "memory_bytes": memory, "seconds": seconds },
            "backend": backend.describe(),
            "warnings": warnings(scene),
        });
        say_json(&plan)?;
        return Ok(Outcome::Done);
    }
    let mut text = String::new();
    for decision in &plan.decisions {
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
    let cast = cast(
        options.effort,
        plan.models(Choice::Diffuse),
        plan.models(Choice::Specular),
        plan.models(Choice::Sky),
    );
    text += &format!(
        "\n{texels} texels on {} page(s) of {}², {cast}\nabout {rays} rays, {:.1} GiB, {seconds:.1} s with {}\n",
        atlas.page_count,
        atlas.page_size,
        memory as f64 / f64::from(1u32 << 30),
        backend.describe(),
    );
    for warning in warnings(scene) {
        text += &format!(
            "warning: {} ({} times, {})\n",
            warning.message, warning.count, warning.place
        );
    }
    say(&text)?;
    Ok(Outcome::Done)
}

/// The rays of a texel in words: over the hemisphere, over the specular lobe, and as many again from an illumination map.
fn cast(effort: Effort, hemisphere: bool, lobe: bool, map: bool) -> String {
    let over = match (hemisphere, lobe) {
        (true, true) => "over the hemisphere and as many over the specular lobe",
        (true, false) => "over the hemisphere",
        (false, true) => "over the specular lobe",
        (false, false) => return "no rays".into(),
    };
    let each = match effort {
        Effort::Rays(rays) => format!("{rays} rays"),
        Effort::Target { error, max_rays } => {
            format!("rays to a standard error of {error}, at most {max_rays},")
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
            "64 rays each over the hemisphere and as many over the specular lobe"
        );
        assert_eq!(
            cast(rays, false, true, true),
            "64 rays each over the specular lobe, and as many again drawn from the map"
        );
        assert_eq!(cast(rays, false, false, false), "no rays");
        let target = Effort::Target {
            error: 0.01,
            max_rays: 4096,
        };
        assert_eq!(
            cast(target, false, true, false),
            "rays to a standard error of 0.01, at most 4096, each over the specular lobe"
        );
    }
}
