//! The EXR pages that a finished bake names.

use crate::{BakeReport, Error, PageFile, read_page_exr};
use serde_json::Value;
use std::path::Path;

/// One EXR page of a bake.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedPage {
    /// Its file, beside `bake.json`.
    pub name: String,
    /// What the name begins with, before the page number: the scene's.
    pub stem: String,
    /// Page number from 0.
    pub page: u32,
}

/// The pages that `bake`, read from `dir`, names as `STEM.P.exr`, in order; at least one.
///
/// # Errors
/// [`Error::Read`] where it names none, or leaves one out.
pub fn page_files(dir: &Path, bake: &BakeReport) -> Result<Vec<NamedPage>, Error> {
    let broken = |reason: String| Error::Read {
        path: dir.join("bake.json"),
        reason,
    };
    let named = |page: u32| {
        let ending = format!(".{page}.exr");
        // A file beside bake.json: a name with a directory in it is not ours.
        let plain = |name: &&String| Path::new(name).file_name() == Some(name.as_ref());
        let mut names = bake.files.iter().filter(plain);
        let found = names.find_map(|name| {
            name.strip_suffix(&ending).map(|stem| NamedPage {
                name: name.clone(),
                stem: stem.into(),
                page,
            })
        });
        found.ok_or_else(|| broken(format!("it names no file of page {page}; bake again")))
    };
    if bake.pages.is_empty() {
        return Err(broken("it has no pages; bake again".into()));
    }
    bake.pages.iter().map(|page| named(page.page)).collect()
}

/// The page in a file that `bake`, read from `dir`, names.
///
/// # Errors
/// [`Error::Read`] where it is absent or damaged, or where its own header tells of another bake: of a set whose
/// files were being given their names when the program was killed, some are of the bake before.
pub fn read_page(dir: &Path, bake: &BakeReport, named: &NamedPage) -> Result<PageFile, Error> {
    let path = dir.join(&named.name);
    let file = read_page_exr(&path)?;
    match other_bake(&file, bake) {
        None => Ok(file),
        Some(what) => Err(Error::read(
            &path,
            format!("it is of another bake than the report beside it, {what} differs; bake again"),
        )),
    }
}

/// What the header of a page says otherwise than the report. A header that says nothing, as another program leaves
/// it, does not.
fn other_bake(file: &PageFile, bake: &BakeReport) -> Option<&'static str> {
    let mut options = bake.options.clone();
    // What the header does not name changes no value.
    let stated = file.attributes.get("ambakeOptions");
    if let Some(Ok(Value::Object(stated))) = stated.map(|text| serde_json::from_str(text)) {
        options.retain(|name, _| stated.contains_key(name));
    }
    let told = [
        (
            "ambakeSceneHash",
            Value::from(&*bake.scene.content_hash),
            "the scene",
        ),
        ("ambakeOptions", options.into(), "an option"),
        ("ambakeLayout", Value::from(&*bake.atlas.hash), "the layout"),
        (
            "ambakeVersion",
            Value::from(&*bake.versions.ambake),
            "ambake's version",
        ),
    ];
    let differs = |(name, told, _): &(&str, Value, &str)| {
        let stated = file
            .attributes
            .get(*name)
            .filter(|stated| !stated.is_empty());
        stated.is_some_and(|stated| match told {
            Value::String(told) => stated != told,
            told => serde_json::from_str(stated).ok().as_ref() != Some(told),
        })
    };
    told.into_iter().find(differs).map(|(.., what)| what)
}
