//! What the tests share: how one of them is skipped.

use std::io::Write;

/// Says on standard error, past the harness, why a test does nothing here. With `AMBAKE_TEST_STRICT=1` that is a failure.
pub fn skip(reason: &str) {
    let strict = std::env::var_os("AMBAKE_TEST_STRICT").is_some_and(|value| value == "1");
    assert!(
        !strict,
        "AMBAKE_TEST_STRICT is set, but this was skipped: {reason}"
    );
    let thread = std::thread::current();
    let name = thread.name().unwrap_or("a test");
    // A closed standard error is no reason to fail.
    let _ = writeln!(std::io::stderr(), "skipped, {name}: {reason}");
}
