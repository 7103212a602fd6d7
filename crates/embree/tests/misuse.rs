//! Misuse that the compiler refuses.

mod common;

use common::skip::{say, skip};
use std::process::Command;

/// The compiler whose messages are recorded beside the cases; others word them differently.
const RECORDED: &str = "rustc 1.95.";

#[test]
fn misuse_does_not_compile() {
    if ambake_embree::header_version().is_none() {
        return skip("this build has no Embree, and its handles then no values");
    }
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(rustc).arg("--version").output();
    let version = version.map_or_else(
        |error| error.to_string(),
        |output| String::from_utf8_lossy(&output.stdout).into_owned(),
    );
    if !version.starts_with(RECORDED) {
        let version = version.trim();
        // A newer compiler is no fault of the machine.
        return say(&format!(
            "messages are recorded for {RECORDED}, this is {version}"
        ));
    }
    trybuild::TestCases::new().compile_fail("tests/misuse/*.rs");
}
