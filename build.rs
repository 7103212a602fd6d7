//! Stamps provenance into the `ambake` binary and lets it find an Embree that stands outside the system's folders.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-env-changed=EMBREE_LIB_DIR");
    println!("cargo:rerun-if-changed=.git/HEAD");
    println!("cargo:rerun-if-changed=.git/refs");
    let revision = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_default();
    let version = std::env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let full = if revision.is_empty() {
        version
    } else {
        format!("{version}+{revision}")
    };
    println!("cargo:rustc-env=AMBAKE_VERSION={full}");
    println!("cargo:rustc-env=AMBAKE_REVISION={revision}");
    let features = std::env::var("CARGO_CFG_TARGET_FEATURE").unwrap_or_default();
    println!("cargo:rustc-env=AMBAKE_TARGET_FEATURES={features}");
    if let Ok(dir) = std::env::var("EMBREE_LIB_DIR") {
        println!("cargo:rustc-link-arg=-Wl,-rpath,{dir}");
    }
}

/// The first line that git prints; `None` outside a checkout or without git.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
