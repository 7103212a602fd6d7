//! Whose report is whose, in a folder that may hold bakes of several scenes.
//!
//! `bake.json` is the report of the last bake. From the second scene on each scene has its own as `STEM.bake.json` too,
//! so that a bake still finds what an earlier one of the same scene wrote.

use crate::{BakeReport, Error, Output, read_bake_report};
use std::fs;
use std::path::{Component, Path};

/// The report of the last bake in a folder.
pub const REPORT_FILE: &str = "bake.json";

/// The name of a scene's own report.
pub fn record_name(stem: &str) -> String {
    format!("{stem}.{REPORT_FILE}")
}

/// The report of the last bake in `dir` of a scene whose files begin with `stem`, where one can be read.
pub fn read_record(dir: &Path, stem: &str) -> Option<BakeReport> {
    let last = read_bake_report(&dir.join(REPORT_FILE)).ok();
    last.filter(|last| stem_of(last) == Some(stem))
        .or_else(|| read_bake_report(&dir.join(record_name(stem))).ok())
}

/// The file at `path` as seen from the folder `dir`, links resolved. It is the same in every copy of a project. `None`
/// where one of the two is absent, or the result is not in UTF-8.
pub fn scene_file(dir: &Path, path: &Path) -> Option<String> {
    let [dir, path] = [dir, path].map(fs::canonicalize);
    let (dir, path) = (dir.ok()?, path.ok()?);
    let shared = dir.components().zip(path.components());
    let shared = shared.take_while(|(a, b)| a == b).count();
    let up = dir.components().skip(shared).map(|_| Component::ParentDir);
    let seen = up.chain(path.components().skip(shared));
    let seen: Option<Vec<&str>> = seen.map(|part| part.as_os_str().to_str()).collect();
    Some(seen?.join("/"))
}

/// Lists all that is staged in `report`, the report of a scene whose files begin with `stem`, and stages it: as
/// `bake.json`, and where the folder holds bakes of other scenes as the scene's own report too. The report of the last
/// bake of another scene is kept as that scene's.
///
/// # Errors
/// [`Error::Write`], [`Error::ReplacesInput`].
pub fn stage_report(output: &mut Output, report: &mut BakeReport, stem: &str) -> Result<(), Error> {
    let own = record_name(stem);
    report
        .files
        .retain(|name| *name != own && name != REPORT_FILE);
    for (name, hash) in output.listed() {
        if !report.files.contains(&name) {
            report.files.push(name.clone());
        }
        report.hashes.insert(name, hash);
    }
    let mut shared = holds_records(output.dir());
    if let Some((other, last)) = last_of_another(output.dir(), stem) {
        shared = true;
        if !output.dir().join(&other).exists() {
            output.stage_bytes(&other, &last)?;
        }
    }
    if shared {
        report.files.push(own.clone());
    }
    report.files.push(REPORT_FILE.into());
    let text = report.to_json();
    if shared {
        output.stage_bytes(&own, text.as_bytes())?;
    }
    output.stage_bytes(REPORT_FILE, text.as_bytes())
}

/// How the names of a bake's files begin: what stands before the number of its first page.
fn stem_of(report: &BakeReport) -> Option<&str> {
    let plain = |name: &&String| Path::new(name).file_name() == Some(name.as_ref());
    let mut names = report.files.iter().filter(plain);
    names.find_map(|name| name.strip_suffix(".0.exr"))
}

/// The report of the last bake with a name for it, where that was of a scene with another stem.
fn last_of_another(dir: &Path, stem: &str) -> Option<(String, Vec<u8>)> {
    let path = dir.join(REPORT_FILE);
    let last = read_bake_report(&path).ok()?;
    let other = stem_of(&last).filter(|other| *other != stem)?;
    Some((record_name(other), fs::read(path).ok()?))
}

/// True where a scene has a report of its own.
fn holds_records(dir: &Path) -> bool {
    let ending = format!(".{REPORT_FILE}");
    let is_record = |entry: fs::DirEntry| entry.file_name().to_string_lossy().ends_with(&ending);
    let entries = fs::read_dir(dir).into_iter().flatten();
    entries.flatten().any(is_record)
}
