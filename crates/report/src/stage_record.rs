//! How the report of a bake is staged: see `record.rs`.

use crate::record::{record_name, stem_of};
use crate::{BakeReport, Error, Output, REPORT_FILE, read_bake_report};
use std::fs;
use std::path::Path;

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
