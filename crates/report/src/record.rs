//! Whose report is whose, in a folder that may hold bakes of several scenes.
//!
//! `bake.json` is the report of the last bake. From the second scene on each scene has its own as `STEM.bake.json` too,
//! so that a bake still finds what an earlier one of the same scene wrote.

use crate::{BakeReport, read_bake_report};
use std::fs;
use std::path::{Component, Path};

/// The report of the last bake in a folder.
pub const REPORT_FILE: &str = "bake.json";

/// The name of the file.
pub const REPORT_NAME: &str = "report.html";

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

/// How the names of a bake's files begin: what stands before the number of its first page.
pub(crate) fn stem_of(report: &BakeReport) -> Option<&str> {
    let plain = |name: &&String| Path::new(name).file_name() == Some(name.as_ref());
    let mut names = report.files.iter().filter(plain);
    names.find_map(|name| name.strip_suffix(".0.exr"))
}
