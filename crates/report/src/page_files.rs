//! The EXR pages that a finished bake names.

use crate::{BakeReport, Error};
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
