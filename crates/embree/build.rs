//! Turns what `embree4-sys` found into `cfg(embree)`.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(embree)");
    if env::var("DEP_EMBREE_AVAILABLE").as_deref() == Ok("1") {
        println!("cargo::rustc-cfg=embree");
        // A library from a newer system wants symbols of that system's C library, which is there when it runs.
        if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
            println!("cargo::rustc-link-arg=-Wl,--allow-shlib-undefined");
        }
    }
}
