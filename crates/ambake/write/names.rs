//! Names of the files of a bake: those that it will write, and those that an earlier one left.

use crate::error::Error;
use crate::state;
use layers::Layer;
use report::{BakeReport, Engine};
use std::io::ErrorKind;
use std::path::Path;

/// Checks that the file system takes a file of that name.
pub(crate) fn check_length(dir: &Path, name: &str) -> Result<(), Error> {
    let path = dir.join(name);
    match std::fs::symlink_metadata(&path) {
        Err(error) if error.kind() == ErrorKind::InvalidFilename => Err(Error::LongName {
            path: path.display().to_string(),
        }),
        _ => Ok(()),
    }
}

/// What an earlier bake of the same scene file listed in `dir` and may have left: names that no bake of a scene of this
/// stem makes are nobody's to remove, whoever listed them.
pub(super) fn leftovers(dir: &Path, stem: &str, now: &BakeReport) -> Vec<(String, String)> {
    let earlier = report::read_record(dir, stem);
    let same = earlier.filter(|of| of.scene.file.is_some() && of.scene.file == now.scene.file);
    let hashes = same.map(|earlier| earlier.hashes).unwrap_or_default();
    hashes
        .into_iter()
        .filter(|(name, _)| is_made(stem, name))
        .collect()
}

/// True for the name of a file that some bake of a scene of this stem makes.
fn is_made(stem: &str, name: &str) -> bool {
    let number = || {
        let (number, _) = name
            .strip_prefix(stem)?
            .strip_prefix('.')?
            .split_once('.')?;
        number.parse().ok()
    };
    let (engines, layers): (Vec<_>, Vec<_>) = (Engine::all().collect(), Layer::all().collect());
    let of_bake = names_of_bake(stem, &engines, true);
    let of_page = |compress| {
        let of_page = number().map(|page| names_of_page(stem, page, &engines, &layers, compress));
        of_page.unwrap_or_default()
    };
    let of_pages = [of_page(false), of_page(true)].concat();
    of_bake.into_iter().chain(of_pages).any(|made| made == name)
}

/// The names of files that a bake makes once.
pub(super) fn names_of_bake(stem: &str, engines: &[Engine], any_view: bool) -> Vec<String> {
    let mut names = vec![
        report::REPORT_FILE.into(),
        report::record_name(stem),
        report::REPORT_NAME.into(),
        glb_name(stem),
        vertex_glb_name(stem),
        lit_name(stem),
        state::head_name(stem),
    ];
    if any_view {
        names.extend(report::any_view_files(stem));
    }
    names.extend(report::scene_files(stem, engines));
    names
}

/// The names of files that a bake makes for each page.
pub(super) fn names_of_page(
    stem: &str,
    page: u32,
    engines: &[Engine],
    layers: &[Layer],
    compress: bool,
) -> Vec<String> {
    let directional = layers.contains(&Layer::Sh);
    let mut names = vec![page_name(stem, page), state::tiles_name(stem, page)];
    names.extend(report::engine_files(
        stem,
        page,
        engines,
        directional,
        compress,
    ));
    names.extend(layers.iter().map(|&layer| preview_name(stem, page, layer)));
    names
}

pub(super) fn glb_name(stem: &str) -> String {
    format!("{stem}.glb")
}

pub(super) fn vertex_glb_name(stem: &str) -> String {
    format!("{stem}.vertices.glb")
}

pub(super) fn page_name(stem: &str, page: u32) -> String {
    format!("{stem}.{page}.exr")
}

pub(super) fn preview_name(stem: &str, page: u32, layer: Layer) -> String {
    format!("{stem}.{page}.{}.png", layer.name())
}

pub(super) fn lit_name(stem: &str) -> String {
    format!("{stem}.lit.png")
}
