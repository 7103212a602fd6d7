//! The `ambake` command: arguments to typed options to calls, and exit codes.
//!
//! Every verb has a folder or a file. Its `args.rs` is what was typed; the files beside it say what that means, call
//! the crates that do the work, and print.
//!
//! Exit status: 0 done, 1 the job failed (one line on standard error), 2 the command line is wrong (likewise), 130 and
//! 143 stopped by Ctrl-C or SIGTERM with nothing half-written; a bake leaves a state that the same command continues.
//!
//! # Where what is
//!
//! * The verbs that bake, lay out, merge and watch: `bake`. Maps: `map`. Pictures: `render`. Measurements: `bench`.
//!   Light for what moves: `probes`. Every other verb is a file beside this one.
//! * `ambake.toml`: `project.rs`. When `watch` bakes, and how fine: `bake/watch.rs`. What a picture file of `render`
//!   holds: `render/file.rs`.
//! * Progress: `progress.rs`. Ctrl-C: `stop.rs`. What `--version` says: `host.rs` with the root's build script. The end
//!   of memory: `allocate.rs`; `crates/ambake/memory.rs` looks before a bake.
// `allocate` alone needs some: Rust has no safe word for an allocator.
#![deny(unsafe_code)]

mod allocate;
mod args;
mod bake;
mod bench;
mod common;
mod compare;
mod doctor;
mod export;
mod fit;
mod host;
mod manual;
mod map;
mod outcome;
mod probes;
mod progress;
mod project;
mod render;
mod stop;
#[cfg(test)]
mod tables;
mod view;

use args::Verb;
use std::process::ExitCode;

fn main() -> ExitCode {
    report::remove_staged_on_panic();
    let words = match project::with_own_table(args::words()) {
        Ok(words) => words,
        Err(error) => return outcome::exit_code(Err(error)),
    };
    let args = match args::Args::of(words) {
        Ok(args) => args,
        Err(error) => return outcome::misused(&error),
    };
    outcome::exit_code(match &args.verb {
        Verb::Bake(bake) => bake::run::run(bake),
        Verb::Plan(plan) => bake::plan::run(plan),
        Verb::Watch(watch) => bake::watch::run(watch),
        Verb::Layout(layout) => bake::layout::run(layout),
        Verb::Merge(merge) => bake::merge::run(merge),
        Verb::Compare(compare) => compare::run(compare),
        Verb::Export(export) => export::run(export),
        Verb::Fit(fit) => fit::run(fit),
        Verb::Render(render) => render::run::run(render),
        Verb::Probes(probes) => probes::run::run(probes),
        Verb::Map(map) => map::run::run(map),
        Verb::Bench(bench) => bench::run::run(bench),
        Verb::View(view) => view::run(view),
        Verb::Completions(completions) => manual::completions(completions),
        Verb::Man(man) => manual::pages(man),
        Verb::Doctor(doctor) => doctor::run(doctor),
    })
}
