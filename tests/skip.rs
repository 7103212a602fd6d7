//! How a test says that it does nothing here; shared by the tests of all crates through `#[path]`.
#![allow(dead_code)]

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Says why the running test or a part of it does nothing here. With `AMBAKE_TEST_STRICT=1` that is a failure.
pub fn skip(reason: &str) {
    let strict = std::env::var_os("AMBAKE_TEST_STRICT").is_some_and(|value| value == "1");
    assert!(
        !strict,
        "AMBAKE_TEST_STRICT is set, but this was skipped: {reason}"
    );
    say(reason);
}

/// A real model or photograph shared beside the project, `None` with a printed line where it is absent. A clone has no
/// such folder, so that this is no failure anywhere.
pub fn model(name: &str) -> Option<PathBuf> {
    let path = repository().join("../shared/models").join(name);
    if path.exists() {
        return Some(path);
    }
    say(&format!("../shared/models/{name} is not here"));
    None
}

/// The folder that holds this file's folder, whichever crate includes it.
fn repository() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors()
        .find(|folder| folder.join("tests/skip.rs").is_file())
        .unwrap_or(own)
}

/// Prints to standard error, past the harness; the same line of the same test once. No failure anywhere.
pub fn say(reason: &str) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let thread = std::thread::current();
    let line = format!("skipped, {}: {reason}", thread.name().unwrap_or("a test"));
    let mut said = SAID.lock().unwrap_or_else(PoisonError::into_inner);
    if said.insert(line.clone()) {
        // A closed standard error is no reason to fail.
        let _ = writeln!(std::io::stderr(), "{line}");
    }
}
