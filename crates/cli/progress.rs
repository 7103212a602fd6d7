//! Progress on standard error: a bar on a terminal, otherwise a plain line now and then.

use crate::stop::Stop;
use ::bake::Progress;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Between two looks at the counters.
const TICK: Duration = Duration::from_millis(100);
/// Between two plain lines.
const LINE: Duration = Duration::from_secs(10);

/// Runs `job` while another thread shows its progress and passes a caught signal on.
pub fn watch<R>(
    total: u64,
    quiet: bool,
    stop: &Stop,
    progress: &Progress,
    job: impl FnOnce() -> R,
) -> R {
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let watcher = scope.spawn(|| show(total, quiet, stop, progress, &done));
        let result = job();
        done.store(true, Ordering::Relaxed);
        watcher.thread().unpark();
        result
    })
}

fn show(total: u64, quiet: bool, stop: &Stop, progress: &Progress, done: &AtomicBool) {
    let started = Instant::now();
    let terminal = std::io::stderr().is_terminal();
    let target = if quiet || !terminal {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr()
    };
    let bar = ProgressBar::with_draw_target(Some(total), target);
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}") {
        bar.set_style(style);
    }
    let mut line_at = LINE;
    while !done.load(Ordering::Relaxed) {
        std::thread::park_timeout(TICK);
        if stop.signal().is_some() {
            progress.stop.store(true, Ordering::Relaxed);
        }
        let elapsed = started.elapsed();
        let text = status(progress, total, elapsed);
        bar.set_position(progress.texels.load(Ordering::Relaxed).min(total));
        bar.set_message(text.clone());
        if !quiet && !terminal && elapsed >= line_at {
            eprintln!("{text}");
            line_at = elapsed + LINE;
        }
    }
    bar.finish_and_clear();
}

fn status(progress: &Progress, total: u64, elapsed: Duration) -> String {
    let texels = progress.texels.load(Ordering::Relaxed);
    let rays = progress.rays.load(Ordering::Relaxed) as f64;
    let seconds = elapsed.as_secs_f64().max(1e-9);
    let left = if texels == 0 {
        "?".to_owned()
    } else {
        HumanDuration(elapsed.mul_f64(total.saturating_sub(texels) as f64 / texels as f64))
            .to_string()
    };
    format!(
        "{texels} of {total} texels, {:.1} million rays/s, {left} left",
        rays / seconds / 1e6
    )
}
