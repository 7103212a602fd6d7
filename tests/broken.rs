//! Broken input and hopeless situations: one clear line, the right exit status, no panic, and nothing under a final
//! name.

mod gltf_cases;
mod obj_cases;
mod situations;

use crate::support::{ambake, files};
use std::ffi::OsString;
use std::path::Path;

/// One thing that must be refused.
pub struct Case {
    /// What is wrong, for the failure message.
    pub what: &'static str,
    /// Files to put in the folder beforehand.
    pub files: Vec<(&'static str, Vec<u8>)>,
    /// Arguments; `@name` stands for a path in the folder. `-o @out` is added for `bake`.
    pub arguments: Vec<&'static str>,
    /// Expected exit status.
    pub status: i32,
    /// What the line must name.
    pub names: &'static str,
}

impl Case {
    /// A scene file that `bake` must refuse by naming it.
    pub fn scene(what: &'static str, file: &'static str, bytes: impl Into<Vec<u8>>) -> Self {
        Self {
            what,
            files: vec![(file, bytes.into())],
            arguments: vec!["bake", file],
            status: 1,
            names: file,
        }
    }

    /// Runs the case; what went wrong with it, if anything.
    fn complaint(&self) -> Option<String> {
        let folder = tempfile::tempdir().expect("a temporary directory");
        for (name, bytes) in &self.files {
            std::fs::write(folder.path().join(name), bytes).expect("the folder is writable");
        }
        let known: Vec<&str> = self.files.iter().map(|(name, _)| *name).collect();
        let place = |word: &str| -> OsString {
            match word.strip_prefix('@') {
                Some(name) => folder.path().join(name).into(),
                None if known.contains(&word) => folder.path().join(word).into(),
                None => word.into(),
            }
        };
        let mut arguments: Vec<OsString> = self.arguments.iter().map(|word| place(word)).collect();
        if self.arguments[0] == "bake" && !self.arguments.contains(&"-o") {
            arguments.extend([
                "--size".into(),
                "32".into(),
                "--rays".into(),
                "4".into(),
                "--quiet".into(),
            ]);
            arguments.extend(["-o".into(), place("@out")]);
        }
        let output = ambake()
            .args(&arguments)
            .output()
            .expect("the program starts");
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        let lines: Vec<&str> = errors
            .lines()
            .filter(|line| !line.trim().is_empty())
            .collect();
        let mut wrong = Vec::new();
        if output.status.code() != Some(self.status) {
            wrong.push(format!(
                "ended with {} instead of {}",
                output.status, self.status
            ));
        }
        if errors.contains("panicked") || errors.contains("RUST_BACKTRACE") {
            wrong.push("panicked".into());
        }
        if lines.len() != 1 || !errors.starts_with("ambake: ") {
            wrong.push(format!(
                "{} lines instead of one `ambake: ...`",
                lines.len()
            ));
        }
        if lines.is_empty() || !errors.contains(self.names) {
            wrong.push(format!("does not name `{}`", self.names));
        }
        let left = left_behind(&folder.path().join("out"));
        if !left.is_empty() {
            wrong.push(format!("left {left:?}"));
        }
        for (name, bytes) in &self.files {
            if std::fs::read(folder.path().join(name)).ok().as_ref() != Some(bytes) {
                wrong.push(format!("touched {name}"));
            }
        }
        println!("{}: {}", self.what, errors.trim_end());
        (!wrong.is_empty()).then(|| {
            format!(
                "{}: {}\n    {}",
                self.what,
                wrong.join(", "),
                errors.trim_end()
            )
        })
    }
}

/// The files a refused bake left in its output directory.
fn left_behind(out: &Path) -> Vec<String> {
    if out.is_dir() { files(out) } else { Vec::new() }
}

/// Runs all cases; fails with every complaint at once.
pub fn refuse_all(cases: &[Case]) {
    let complaints: Vec<String> = cases.iter().filter_map(Case::complaint).collect();
    assert!(
        complaints.is_empty(),
        "{} of {} cases:\n{}",
        complaints.len(),
        cases.len(),
        complaints.join("\n")
    );
}
