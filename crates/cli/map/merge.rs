//! `ambake map merge`: exposure brackets to one picture of radiance.

use super::args::{Merge, Response};
use crate::host;
use crate::outcome::{say, say_json};
use anyhow::{Context, bail};
use environment::{Format, Labels};
use maps::merge;
use report::Output;
use serde_json::json;

/// Runs the sub-verb.
pub fn run(args: &Merge) -> anyhow::Result<()> {
    host::set_threads(args.common.threads)?;
    let format = Format::of(&args.output)?;
    let count = args.inputs.len();
    if count < 2 {
        bail!("one photograph is no series; name at least two with different exposure times");
    }
    if !args.times.is_empty() && args.times.len() != count {
        bail!(
            "--times has {} values for {count} photographs; give one for each, or none to use EXIF",
            args.times.len()
        );
    }
    let mut brackets = merge::read_brackets(&args.inputs, &args.times)?;
    let aligned = args.align.then(|| merge::align(&mut brackets));
    let merged = match &args.response {
        Response::Model(model) => merge::merge(&brackets, *model)?,
        Response::File(path) => merge::merge_by(&brackets, merge::read_curves(path)?)?,
    };
    let saturated = merged.saturated.iter().filter(|s| **s).count();
    let confidence: Vec<f32> = merged
        .saturated
        .iter()
        .map(|s| if *s { 0.0 } else { 1.0 })
        .collect();
    let labels: Labels = [
        ("ambakeVersion", host::VERSION),
        (
            "ambakeNormalisation",
            "radiance up to one factor; where confidence is 0 every bracket is saturated, \
             and the value is a lower bound",
        ),
    ]
    .map(|(name, text)| (name.to_owned(), text.to_owned()))
    .into();
    let bytes = environment::encode_with(
        &merged.image,
        Some(("confidence", &confidence)),
        format,
        &labels,
    )
    .with_context(|| args.output.display().to_string())?;
    let mut output = Output::for_file(&args.output)?;
    output.protect(args.inputs.iter().cloned());
    let name = args
        .output
        .file_name()
        .context("the output has no file name")?;
    output.stage_bytes(&name.to_string_lossy(), &bytes)?;
    let mut files = output.publish()?;
    if let Some(path) = &args.save_response {
        let mut output = Output::for_file(path)?;
        output.protect(args.inputs.iter().chain([&args.output]).cloned());
        let name = path
            .file_name()
            .context("--save-response has no file name")?;
        let text = merge::curves_text(&merged.responses);
        output.stage_bytes(&name.to_string_lossy(), text.as_bytes())?;
        files.extend(output.publish()?);
    }
    if args.common.json {
        let times: Vec<f64> = brackets.iter().map(|b| b.time).collect();
        return say_json(&json!({
            "schema_version": 1, "photographs": args.inputs, "times": times,
            "shifts": args.align.then(|| brackets.iter().map(|b| b.shift).collect::<Vec<_>>()),
            "size": [merged.image.width, merged.image.height],
            "saturated_pixels": saturated, "files": files,
        }));
    }
    if args.common.quiet {
        return Ok(());
    }
    let mut text = String::new();
    for (index, (path, bracket)) in args.inputs.iter().zip(&brackets).enumerate() {
        text += &format!("{}: {} s", path.display(), bracket.time);
        if let Some(found) = &aligned {
            let [x, y] = bracket.shift;
            text += &format!(", shifted by {x},{y} pixels");
            text += if found[index] {
                ""
            } else {
                " as its neighbour: too dark or too bright to tell"
            };
        }
        text += "\n";
    }
    text += &format!(
        "{saturated} of {} pixels are saturated in every photograph: confidence 0, the value is a lower bound\n",
        merged.saturated.len()
    );
    for file in &files {
        text += &format!("wrote {}\n", file.display());
    }
    say(&text)
}
