//! `ambake map stats`: what a map holds in numbers.

use super::args::Stats;
use super::file::Source;
use crate::host;
use crate::outcome::{say, say_json};
use anyhow::Context;
use environment::MapStats;
use serde_json::json;

/// Runs the sub-verb.
pub fn run(args: &Stats) -> anyhow::Result<()> {
    host::set_threads(args.common.threads)?;
    let path = &args.input.input;
    let source = Source::read_unchecked(&args.input)?;
    let (size, projection) = (source.layout.size, source.layout.projection);
    let orientation = source.layout.orientation.name();
    let stats =
        MapStats::of(&source.image, projection).with_context(|| path.display().to_string())?;
    if args.common.json {
        return say_json(&json!({
            "schema_version": 1, "map": path, "size": [size.0, size.1],
            "projection": projection.name(), "orientation": orientation,
            "mean": stats.mean, "maximum": stats.maximum, "maximum_at": stats.maximum_at,
            "maximum_direction": stats.maximum_direction, "minimum": stats.minimum,
            "integral": stats.integral, "solid_angle": stats.solid_angle,
            "non_finite": stats.non_finite, "negative": stats.negative,
        }));
    }
    let triple = |v: [f64; 3]| v.map(|v| format!("{v:.6}")).join(" ");
    let [x, y] = stats.maximum_at;
    say(&format!(
        "{} x {} texels, {}, axes of {orientation}\nmean       {}\nintegral   {} (radiance times sr)\n\
         maximum    {} at ({x}, {y})\n\
         minimum    {}\nnon-finite {} texels\nnegative   {} texels\n",
        size.0,
        size.1,
        projection.name(),
        triple(stats.mean),
        triple(stats.integral),
        stats.maximum,
        stats.minimum,
        stats.non_finite,
        stats.negative,
    ))
}
