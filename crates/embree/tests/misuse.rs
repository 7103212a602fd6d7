//! Misuse that the compiler refuses.

use std::process::Command;

/// The compiler whose messages are recorded beside the cases; others word them differently.
const RECORDED: &str = "rustc 1.95.";

#[test]
fn misuse_does_not_compile() {
    if ambake_embree::header_version().is_none() {
        println!("skipped: built without Embree, whose handles then have no values");
        return;
    }
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(rustc).arg("--version").output();
    let version = version.map_or_else(
        |error| error.to_string(),
        |output| String::from_utf8_lossy(&output.stdout).into_owned(),
    );
    if !version.starts_with(RECORDED) {
        println!("skipped: messages are recorded for {RECORDED}, this is {version}");
        return;
    }
    trybuild::TestCases::new().compile_fail("tests/misuse/*.rs");
}
