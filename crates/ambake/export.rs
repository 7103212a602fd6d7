//! Files for engines from a finished bake.

use crate::error::Error;
use report::{BakeReport, Engine, NamedPage, Output, Page, PageLight, ScenePictures};
use std::path::{Path, PathBuf};

/// What an export left in the directory of a bake.
#[derive(Debug)]
#[non_exhaustive]
pub struct Exported {
    /// The content of `bake.json`, which now lists the new files too.
    pub report: BakeReport,
    /// Every file that was written, `bake.json` last.
    pub files: Vec<PathBuf>,
}

/// Writes the files of `engines` beside the finished bake in `dir`, and lists them in its `bake.json`. They are the
/// files, byte for byte, that the bake itself would have made for these engines; what was exported for others stays.
/// `compress`: as [`crate::Bake::compress`].
///
/// # Errors
/// `dir` holds no finished bake, a page of it is absent or damaged or lacks a layer, a file cannot be written, or
/// nothing of what is asked for can be compressed. Nothing is left half written.
pub fn export(
    dir: impl AsRef<Path>,
    engines: impl IntoIterator<Item = Engine>,
    compress: bool,
) -> Result<Exported, Error> {
    let dir = dir.as_ref();
    let mut report = report::read_bake_report(&dir.join("bake.json"))?;
    let mut chosen: Vec<Engine> = Vec::new();
    for engine in engines {
        if !chosen.contains(&engine) {
            chosen.push(engine);
        }
    }
    if compress {
        let checked = report::check_compressed(&chosen, report.atlas.page_size);
        checked.map_err(|problem| Error::option("compress", problem))?;
    }
    let pages = report::page_files(dir, &report)?;
    let mut output = Output::create(dir)?;
    let mut lightmaps = report.lightmaps.clone();
    lightmaps.retain(|map| chosen.iter().all(|engine| engine.name() != map.engine));
    let mut scenes = ScenePictures::new(&chosen);
    for named in &pages {
        let file = report::read_page(dir, &report, named)?;
        let light = page_light(dir, &report, named, &file.page)?;
        scenes.add(&light);
        let made = report::stage_engines(&mut output, &named.stem, &light, &chosen, compress)?;
        lightmaps.extend(made);
    }
    let stem = &pages[0].stem;
    if !scenes.is_empty() {
        let path = dir.join(format!("{stem}.glb"));
        let read = report::check_regular(&path).and_then(|()| std::fs::read(&path));
        let glb = read.map_err(|error| report::Error::Read {
            path,
            reason: format!("{error}; bake again"),
        })?;
        lightmaps.extend(scenes.stage(&mut output, stem, &glb, &chosen)?);
    }
    report.lightmaps = lightmaps;
    report::stage_report(&mut output, &mut report, stem)?;
    let files = output.publish()?;
    Ok(Exported { report, files })
}

/// What engine files of a page are made of.
fn page_light<'a>(
    dir: &Path,
    report: &BakeReport,
    named: &NamedPage,
    page: &'a Page,
) -> Result<PageLight<'a>, Error> {
    let light = PageLight::of(report, named.page, page).map_err(|error| match error {
        report::Error::MissingLayer { layer } => report::Error::Read {
            path: dir.join(&named.name),
            reason: format!("it has no layer {layer}; bake again with --layers {layer}"),
        },
        other => other,
    })?;
    Ok(light)
}
