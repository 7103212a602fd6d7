//! The folder of authored scenes is what its generator writes.

use crate::support::{files, scene, skip};
use std::process::Command;

#[test]
fn generator_writes_the_committed_bytes() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let script = scene("generate.py");
    let run = Command::new("python3")
        .arg(&script)
        .arg(folder.path())
        .output();
    let Ok(output) = run else {
        return skip("python3 is not installed");
    };
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let written = files(folder.path());
    let kept = files(script.parent().expect("a folder"));
    let kept: Vec<_> = kept
        .into_iter()
        .filter(|name| !["README.md", "generate.py"].contains(&name.as_str()))
        .collect();
    assert_eq!(written, kept);
    for name in written {
        let (new, old) = (
            std::fs::read(folder.path().join(&name)),
            std::fs::read(scene(&name)),
        );
        assert!(
            new.expect("it is there") == old.expect("it is there"),
            "{name} differs"
        );
    }
}
