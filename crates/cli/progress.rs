//! Progress on standard error: a bar on a terminal, otherwise a plain line now and then.

use crate::outcome::note;
use crate::stop::Stop;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use layers::Progress;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Between two looks at the counters.
const TICK: Duration = Duration::from_millis(100);
/// Between two plain lines.
const LINE: Duration = Duration::from_secs(10);

/// How far a job is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Seen {
    /// Units of work that are done.
    pub done: u64,
    /// Units of work in all; 0 before the job has said.
    pub total: u64,
    /// Rays that were cast; 0 where the job does not count them.
    pub rays: u64,
}

/// What is shown of a job.
#[derive(Debug, Clone, Copy)]
pub struct Show {
    /// What the work is counted in: `texels`, `pixels`.
    pub unit: &'static str,
    /// Show nothing.
    pub quiet: bool,
}

/// Runs `job` with a listener, while another thread shows its progress and passes a caught signal on.
pub fn watch<R>(show: Show, stop: &Stop, job: impl FnOnce(&dyn Progress) -> R) -> R {
    let meter = Meter {
        quiet: show.quiet,
        ..Meter::default()
    };
    let done = AtomicBool::new(false);
    let ends_cleanly = stop.hold();
    std::thread::scope(|scope| {
        let started =
            std::thread::Builder::new().spawn_scoped(scope, || show.until(&done, stop, &meter));
        // Where the system gives no thread, nobody passes a signal on: it has to end the program.
        let held = started.is_ok().then_some(ends_cleanly);
        let result = job(&meter);
        done.store(true, Ordering::Relaxed);
        if let Ok(watcher) = started {
            watcher.thread().unpark();
        }
        drop(held);
        result
    })
}

/// Counts what a job tells.
#[derive(Debug, Default)]
struct Meter {
    done: AtomicU64,
    total: AtomicU64,
    rays: AtomicU64,
    cancelled: AtomicBool,
    quiet: bool,
}

impl Progress for Meter {
    fn advance(&self, done: u64, total: u64) {
        // Calls of several threads may come out of order.
        self.done.fetch_max(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    fn rays(&self, cast: u64) {
        self.rays.fetch_add(cast, Ordering::Relaxed);
    }

    fn note(&self, line: &str) {
        if !self.quiet {
            eprintln!("ambake: {line}");
        }
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

impl Meter {
    fn look(&self) -> Seen {
        Seen {
            done: self.done.load(Ordering::Relaxed),
            total: self.total.load(Ordering::Relaxed),
            rays: self.rays.load(Ordering::Relaxed),
        }
    }

    fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

impl Show {
    fn until(self, done: &AtomicBool, stop: &Stop, meter: &Meter) {
        let started = Instant::now();
        let terminal = std::io::stderr().is_terminal();
        let target = if self.quiet || !terminal {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}") {
            bar.set_style(style);
        }
        let mut lines = Lines::every(LINE);
        while !done.load(Ordering::Relaxed) {
            std::thread::park_timeout(TICK);
            if stop.signal().is_some() {
                meter.cancel();
            }
            let (seen, elapsed) = (meter.look(), started.elapsed());
            bar.set_length(seen.total);
            bar.set_position(seen.done.min(seen.total));
            bar.set_message(status(seen, self.unit, elapsed));
            if !self.quiet && !terminal && lines.due(elapsed) {
                note(&status(seen, self.unit, elapsed));
            }
        }
        bar.finish_and_clear();
    }
}

/// When the next plain line is due.
struct Lines {
    next: Duration,
    step: Duration,
}

impl Lines {
    fn every(step: Duration) -> Lines {
        Lines { next: step, step }
    }

    fn due(&mut self, elapsed: Duration) -> bool {
        let due = elapsed >= self.next;
        if due {
            self.next = elapsed + self.step;
        }
        due
    }
}

/// A number of things in words: `1 page`, `2 pages`.
pub fn count(number: impl Into<u64>, thing: &str) -> String {
    let number = number.into();
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{plural}")
}

/// Rays per second in words: `3.0 million rays/s`, `40 thousand rays/s`.
pub fn ray_rate(rays: u64, seconds: f64) -> String {
    let rate = rays as f64 / seconds.max(1e-9);
    match rate {
        1e6.. => format!("{:.1} million rays/s", rate / 1e6),
        _ => format!("{:.0} thousand rays/s", rate / 1e3),
    }
}

fn status(seen: Seen, unit: &str, elapsed: Duration) -> String {
    let Seen { done, total, rays } = seen;
    let rate = match rays {
        0 => String::new(),
        rays => format!("{}, ", ray_rate(rays, elapsed.as_secs_f64())),
    };
    let left = match done {
        0 => "?".to_owned(),
        done => {
            let share = total.saturating_sub(done) as f64 / done as f64;
            HumanDuration(elapsed.mul_f64(share)).to_string()
        }
    };
    format!("{done} of {total} {unit}, {rate}{left} left")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_status_tells_work_rays_and_the_time_left() {
        let seen = Seen {
            done: 25,
            total: 100,
            rays: 0,
        };
        let elapsed = Duration::from_secs(10);
        assert_eq!(
            status(seen, "pixels", elapsed),
            "25 of 100 pixels, 30 seconds left"
        );
        let seen = Seen {
            rays: 30_000_000,
            ..seen
        };
        assert_eq!(
            status(seen, "texels", elapsed),
            "25 of 100 texels, 3.0 million rays/s, 30 seconds left"
        );
        assert_eq!(ray_rate(120_000, 3.0), "40 thousand rays/s");
        assert_eq!(
            status(Seen::default(), "pixels", elapsed),
            "0 of 0 pixels, ? left"
        );
    }

    #[test]
    fn plain_lines_are_ten_seconds_apart() {
        let mut lines = Lines::every(LINE);
        let due: Vec<u64> = (0..400)
            .filter(|tenths| lines.due(TICK * *tenths as u32))
            .collect();
        assert_eq!(due, [100, 200, 300]);
    }

    #[test]
    fn a_job_hears_that_it_is_cancelled_and_its_counts_never_fall() {
        let meter = Meter::default();
        meter.advance(7, 10);
        meter.advance(6, 10);
        meter.rays(3);
        meter.rays(4);
        let seen = Seen {
            done: 7,
            total: 10,
            rays: 7,
        };
        assert_eq!(meter.look(), seen);
        assert!(!meter.cancelled());
        meter.cancel();
        assert!(meter.cancelled());
    }
}
