//! The commands of README.md and of the pages in docs/, run as they stand from what a fresh clone holds.
//!
//! Each page gets a clone of its own, with nothing beside it, and its commands run in order. Each must end with status
//! 0 within two minutes. `cargo test readme -- --nocapture` prints how long each took, and what was not run and why.

mod extract;

use crate::support::ambake;
use extract::commands;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Instant;

/// The longest that a command may take, in seconds.
const LIMIT: u32 = 120;

/// What a clone holds that commands may write into: copied, where all else is linked.
const COPIED: [&str; 2] = ["scenes", "docs"];

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A folder like a clone's, in a temporary folder that holds nothing else but `bin/ambake`.
struct Clone {
    folder: tempfile::TempDir,
}

impl Clone {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (clone, bin) = (folder.path().join("ambake"), folder.path().join("bin"));
        for made in [&clone, &bin] {
            std::fs::create_dir(made).expect("a folder");
        }
        for entry in entries(repository()) {
            let name = entry.file_name().expect("a name").to_string_lossy();
            if COPIED.contains(&&*name) {
                copy(&entry, &clone.join(&*name));
            } else if !name.starts_with('.') && !["target", "out"].contains(&&*name) {
                symlink(&entry, clone.join(&*name)).expect("a link");
            }
        }
        // The program as the tests start it, behind a loader where one is set.
        let start = ambake();
        let words: Vec<String> = std::iter::once(start.get_program())
            .chain(start.get_args())
            .map(|word| format!("'{}'", word.to_string_lossy()))
            .collect();
        let script = bin.join("ambake");
        let text = format!("#!/bin/sh\nexec {} \"$@\"\n", words.join(" "));
        std::fs::write(&script, text).expect("a script");
        std::fs::set_permissions(&script, PermissionsExt::from_mode(0o755)).expect("its mode");
        Self { folder }
    }

    /// Runs a line of shell, as if typed in the clone.
    fn run(&self, line: &str) -> Output {
        let path = std::env::var("PATH").unwrap_or_default();
        let bin = self.folder.path().join("bin");
        Command::new("timeout")
            .args(["--kill-after=10", &LIMIT.to_string()])
            .args(["bash", "-euo", "pipefail", "-c", line])
            .current_dir(self.folder.path().join("ambake"))
            .env("PATH", format!("{}:{path}", bin.display()))
            // Nothing opens on the screen of whoever runs the tests.
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .stdin(Stdio::null())
            .output()
            .expect("timeout (of coreutils) and bash are installed")
    }
}

/// What a folder holds, in order.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut all: Vec<PathBuf> = all.map(|entry| entry.expect("an entry").path()).collect();
    all.sort();
    all
}

fn copy(from: &Path, to: &Path) {
    if !from.is_dir() {
        std::fs::copy(from, to).expect("a file is copied");
        return;
    }
    std::fs::create_dir(to).expect("a folder");
    for entry in entries(from) {
        copy(&entry, &to.join(entry.file_name().expect("a name")));
    }
}

/// Runs every command of a page; returns how many, and what failed.
fn run_page(page: &Path) -> (usize, Vec<String>) {
    let shown = page.strip_prefix(repository()).unwrap_or(page).display();
    let text = std::fs::read_to_string(page).unwrap_or_else(|e| panic!("{shown}: {e}"));
    let commands = commands(&text).unwrap_or_else(|e| panic!("{shown}, {e}"));
    let clone = Clone::new();
    let (mut count, mut failed) = (0, Vec::new());
    for command in commands {
        let place = format!("{shown}:{}: {}", command.line, command.text);
        if let Some(reason) = command.skipped {
            println!("not run ({reason}): {place}");
            continue;
        }
        let start = Instant::now();
        let output = clone.run(&command.text);
        println!(
            "{:6.1} s, {}: {place}",
            start.elapsed().as_secs_f64(),
            output.status
        );
        count += 1;
        if !output.status.success() {
            let errors = String::from_utf8_lossy(&output.stderr);
            // What timeout says by its status.
            let why = match output.status.code() {
                Some(124 | 137) => format!("it took more than {LIMIT} s"),
                _ => output.status.to_string(),
            };
            failed.push(format!("{place}\n    {why}\n    {}", errors.trim()));
        }
    }
    (count, failed)
}

#[test]
fn every_command_of_the_readme_ends_well_in_a_fresh_clone() {
    let (count, failed) = run_page(&repository().join("README.md"));
    assert!(count > 0, "README.md gives no command");
    assert!(failed.is_empty(), "\n{}", failed.join("\n"));
}

#[test]
fn every_command_of_the_docs_ends_well_in_a_fresh_clone() {
    let mut failed = Vec::new();
    for page in entries(&repository().join("docs")) {
        if page.extension().is_some_and(|ending| ending == "md") {
            failed.extend(run_page(&page).1);
        }
    }
    assert!(failed.is_empty(), "\n{}", failed.join("\n"));
}

/// The rows of a page's tables, cell by cell.
fn rows(page: &str) -> impl Iterator<Item = Vec<&str>> {
    let rows = page.lines().filter(|line| line.starts_with("| "));
    rows.map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
}

/// What stands between backticks.
fn quoted(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

#[test]
fn every_row_of_the_sources_has_a_command_that_ends_well_and_tests_that_are_there() {
    let page = std::fs::read_to_string(repository().join("docs/sources.md")).expect("the page");
    let (mut commands, mut tests) = (0, 0);
    let clone = Clone::new();
    for row in rows(&page) {
        for line in row.iter().flat_map(|cell| quoted(cell)) {
            if line.starts_with("ambake ") {
                let output = clone.run(line);
                let said = String::from_utf8_lossy(&output.stderr);
                assert!(output.status.success(), "{line}\n{said}");
                commands += 1;
            }
        }
        let mut file = String::new();
        for word in row.last().into_iter().flat_map(|cell| quoted(cell)) {
            if word.ends_with(".rs") {
                let path = repository().join(word);
                file = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{word}: {e}"));
            } else {
                assert!(
                    file.contains(&format!("fn {word}(")),
                    "there is no test {word}"
                );
                tests += 1;
            }
        }
    }
    assert!(
        commands > 30 && tests > 50,
        "{commands} commands, {tests} tests"
    );
}
