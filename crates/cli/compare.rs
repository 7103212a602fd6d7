//! `ambake compare`: the traditional model against the two integrated ones, or any two pages.

use crate::args::Compare as Args;
use crate::outcome::{Outcome, say};
use anyhow::{Context, bail};
use report::{BakeReport, Comparison, Difference, Error, NamedPage, Output, Page, PageFile};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// What is compared within a bake: the baselines that it has minus its integrated models.
fn pairs(bake: &BakeReport) -> Vec<(&'static str, &'static str)> {
    let ggx = bake
        .options
        .get("model")
        .is_some_and(|model| model == "ggx");
    let highlight = if ggx { "ggx" } else { "phong" };
    let mut pairs = vec![("traditional", "lambert"), ("traditional", highlight)];
    let layers = bake.options.get("layers").and_then(Value::as_array);
    if layers.is_some_and(|layers| layers.iter().any(|name| name == CLOSED)) {
        pairs.push((CLOSED, highlight));
    }
    pairs
}

/// The second baseline.
const CLOSED: &str = "traditional.closed";

/// The picture of a difference.
fn picture_name(file: &NamedPage, (a, b): (&str, &str)) -> String {
    // Not the name of a layer's preview, of which there is `difference.phong`.
    format!("{}.{}.difference.{a}-{b}.png", file.stem, file.page)
}

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    match args.paths.as_slice() {
        [dir] => compare_bake(args, dir)?,
        [a, b] => compare_files(args, a, b)?,
        other => bail!(
            "{} paths; name a bake's directory or two EXR pages",
            other.len()
        ),
    }
    Ok(Outcome::Done)
}

/// The models of a finished bake.
fn compare_bake(args: &Args, dir: &Path) -> anyhow::Result<()> {
    if dir.is_file() {
        bail!(
            "{} is a file; name a bake's directory or two EXR pages",
            dir.display()
        );
    }
    let bake = report::read_bake_report(&dir.join("bake.json"))?;
    let files = report::page_files(dir, &bake)?;
    let pairs = pairs(&bake);
    // Pages are read twice, one at a time: the pictures share a scale, which is known after the last page.
    let pages = || {
        files.iter().map(|file| {
            let page = report::read_page(dir, &bake, file)?.page;
            Ok((file, page))
        })
    };
    let numbered = pages().map(|page| page.map(|(file, page)| (file.page, page)));
    let comparisons = report::compare_layers(numbered, bake.objects.len(), &pairs)
        .map_err(|error| in_bake(dir, error))?;

    let mut output = Output::create(args.output.as_deref().unwrap_or(dir))?;
    let limits: Vec<f64> = comparisons
        .iter()
        .map(|comparison| report::nice_limit(comparison.all.maximum))
        .collect();
    for page in pages() {
        let (file, page): (&NamedPage, Page) = page?;
        for (&(a, b), &limit) in pairs.iter().zip(&limits) {
            let name = picture_name(file, (a, b));
            output.stage_bytes(&name, &report::difference_png(&page, (a, b), limit)?)?;
        }
    }
    let written = output.publish()?;
    if args.json {
        let json = bake_json(&bake, &comparisons, &limits, &written);
        return say(&format!("{}\n", serde_json::to_string_pretty(&json)?));
    }
    if args.quiet {
        return Ok(());
    }
    let mut text = String::new();
    for (&(a, b), comparison) in pairs.iter().zip(&comparisons) {
        text += &object_table(&format!("{a} - {b}"), comparison, &bake);
    }
    if comparisons.iter().any(|c| c.objects.is_empty()) {
        text += "for numbers by object and positions bake with --layers object,position\n";
    }
    say(&(text + &written_lines(&written)))
}

/// An error with the bake it came up in; those about a file name it themselves.
fn in_bake(dir: &Path, error: Error) -> anyhow::Error {
    match error {
        Error::Read { .. } => error.into(),
        other => anyhow::Error::new(other).context(dir.display().to_string()),
    }
}

/// Any two pages.
fn compare_files(args: &Args, a: &Path, b: &Path) -> anyhow::Result<()> {
    let names = [a, b].map(|path| path.display().to_string());
    let [first, second] = [report::read_page_exr(a)?, report::read_page_exr(b)?];
    let comparison = report::check_origin(&first, &second)
        .and_then(|()| report::compare_pages(&first.page, &second.page))
        .with_context(|| format!("{} against {}", names[0], names[1]))?;
    let mut written = Vec::new();
    if let Some(dir) = &args.output {
        let mut output = Output::create(dir)?;
        stage_channels(&mut output, a, [&first, &second], &comparison.channels)?;
        written = output.publish()?;
    }
    if args.json {
        let channels: Vec<Value> = comparison
            .channels
            .iter()
            .map(|(name, difference)| with_name(name, difference))
            .collect();
        let json = json!({
            "schema_version": 1, "a": names[0], "b": names[1], "size": first.page.size, "channels": channels,
            "only_a": comparison.only_a, "only_b": comparison.only_b, "files": written,
        });
        return say(&format!("{}\n", serde_json::to_string_pretty(&json)?));
    }
    if args.quiet {
        return Ok(());
    }
    let rows: Vec<_> = comparison
        .channels
        .iter()
        .map(|(name, difference)| (name.as_str(), difference))
        .collect();
    let mut text = table(&format!("{} - {}", names[0], names[1]), &rows, None);
    for (name, only) in names.iter().zip([&comparison.only_a, &comparison.only_b]) {
        if !only.is_empty() {
            text += &format!("only in {name}: {}\n", only.join(", "));
        }
    }
    say(&(text + &written_lines(&written)))
}

/// A picture of each channel that two pages share, named after the first.
fn stage_channels(
    output: &mut Output,
    a: &Path,
    files: [&PageFile; 2],
    channels: &[(String, Difference)],
) -> anyhow::Result<()> {
    let stem = a
        .file_stem()
        .map_or_else(|| "page".into(), |s| s.to_string_lossy());
    let [first, second] = files.map(|file| file.page.named_channels());
    let coverage = files.map(|file| file.page.values("coverage"));
    for (name, difference) in channels {
        let find = |named: &[(String, &[f32])]| {
            let found = named.iter().position(|(other, _)| other == name);
            found.with_context(|| format!("channel {name} is gone"))
        };
        let (a, b) = (first[find(&first)?].1, second[find(&second)?].1);
        let value = |i: usize| {
            let counts = match coverage {
                [Some(a), Some(b)] => a[i] > 0.0 || b[i] > 0.0,
                _ => true,
            };
            let value = f64::from(a[i]) - f64::from(b[i]);
            (counts && value.is_finite()).then_some(value)
        };
        let limit = report::nice_limit(difference.maximum);
        let title = format!("{name}: first - second");
        let png = report::difference_picture([files[0].page.size; 2], &title, limit, value);
        // A foreign channel may be called anything; a file name takes letters, digits and a few signs.
        let plain = |c: char| c.is_alphanumeric() || ".-_".contains(c);
        let name = name.replace(|c| !plain(c), "_");
        output.stage_bytes(&format!("{stem}.difference.{name}.png"), &png)?;
    }
    Ok(())
}

/// A difference as JSON with a name in front.
fn with_name(name: &str, difference: &Difference) -> Value {
    let mut value = json!({ "name": name });
    if let (Some(map), Value::Object(fields)) = (value.as_object_mut(), json!(difference)) {
        map.extend(fields);
    }
    value
}

fn bake_json(
    bake: &BakeReport,
    comparisons: &[Comparison],
    limits: &[f64],
    written: &[PathBuf],
) -> Value {
    let pairs = pairs(bake);
    let models = pairs.iter().zip(comparisons).zip(limits);
    let models: Vec<Value> = models
        .map(|((&(a, b), comparison), limit)| {
            let objects = comparison.objects.iter().zip(&bake.objects);
            let objects: Vec<Value> = objects
                .map(|(difference, object)| with_name(&object.name, difference))
                .collect();
            json!({ "a": a, "b": b, "picture_limit": limit, "all": comparison.all, "objects": objects })
        })
        .collect();
    json!({ "schema_version": 1, "scene": bake.scene.path, "comparisons": models, "files": written })
}

fn object_table(title: &str, comparison: &Comparison, bake: &BakeReport) -> String {
    let names: Vec<&str> = bake.objects.iter().map(|o| o.name.as_str()).collect();
    let objects = comparison.objects.iter().zip(&names);
    let mut rows: Vec<_> = objects
        .map(|(difference, &name)| (name, difference))
        .collect();
    rows.push(("in all", &comparison.all));
    table(title, &rows, Some(&names))
}

/// Rows of numbers with aligned columns. `objects`: within a bake, the names that object indices point to.
fn table(title: &str, rows: &[(&str, &Difference)], objects: Option<&[&str]>) -> String {
    let longest = rows.iter().map(|(name, _)| name.chars().count()).max();
    let wide = longest.unwrap_or(0).clamp(6, 48);
    let mut text = format!(
        "{title}\n  {:<wide$} {:>9} {:>11} {:>11} {:>11}  worst texel\n",
        "", "texels", "RMSE", "mean", "maximum"
    );
    for (name, difference) in rows {
        let worst = match &difference.worst {
            Some(worst) => place(worst, objects),
            None if difference.texels > 0 => "no difference".into(),
            None => "no texels".into(),
        };
        let left_out = match difference.non_finite {
            0 => String::new(),
            count => format!("; {count} texels left out, NaN or infinite"),
        };
        text += &format!(
            "  {name:<wide$} {:>9} {:>11} {:>11} {:>11}  {worst}{left_out}\n",
            difference.texels,
            number(difference.rmse),
            number(difference.mean_signed),
            number(difference.maximum),
        );
    }
    text
}

/// Where a worst texel lies.
fn place(worst: &report::Worst, objects: Option<&[&str]>) -> String {
    let mut text = format!("({}, {})", worst.x, worst.y);
    if objects.is_some() {
        text = format!("page {} {text}", worst.page);
    }
    let object = objects.zip(worst.object);
    if let Some(name) = object.and_then(|(names, o)| names.get(o as usize)) {
        text += &format!(" on {name}");
    }
    if let Some([x, y, z]) = worst.position {
        text += &format!(" at {x}, {y}, {z}");
    }
    text
}

/// Six decimals where they tell something, else an exponent.
fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e4).contains(&value.abs()) {
        format!("{value:.6}")
    } else {
        format!("{value:.3e}")
    }
}

fn written_lines(written: &[PathBuf]) -> String {
    let line = |path: &PathBuf| format!("wrote {}\n", path.display());
    written.iter().map(line).collect()
}
