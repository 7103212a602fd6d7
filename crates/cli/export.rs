//! `ambake export`: files for engines from a finished bake.

use crate::args::Export as Args;
use crate::outcome::{Outcome, say, say_json};
use serde_json::json;

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let exported = ambake::export(&args.dir, args.engines.iter().copied(), args.compress)?;
    let lightmaps = exported.report.lightmaps;
    if args.json {
        let files = &exported.files;
        say_json(&json!({ "schema_version": 1, "lightmaps": lightmaps, "files": files }))?;
    } else if !args.quiet {
        let mut text = String::new();
        for file in &exported.files {
            text += &format!("wrote {}\n", file.display());
        }
        for engine in &args.engines {
            let of_engine = |map: &&report::LightmapReport| map.engine == engine.name();
            if let Some(map) = lightmaps.iter().find(of_engine) {
                text += &format!("{}: scale {}. {}\n", map.engine, map.scale, map.how);
            }
        }
        say(&text)?;
    }
    Ok(Outcome::Done)
}
