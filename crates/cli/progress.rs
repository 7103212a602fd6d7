//! Progress on standard error: a bar on a terminal, otherwise a plain line now and then.

use crate::host::limits_addresses;
use crate::outcome::{note, wants_ascii};
use crate::stop::Stop;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use layers::Progress;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
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

/// Shows the phases of a job that a signal ends at once, with the program.
pub struct Phases {
    bar: ProgressBar,
    now: Arc<Now>,
    /// Prints plain lines. Not where addresses are limited: a thread would take some that the job may lack.
    teller: Option<JoinHandle<()>>,
    quiet: bool,
}

/// Where a job is.
struct Now {
    meter: Meter,
    /// When its phase began to count, and at what.
    began: Mutex<Option<(Instant, Seen)>>,
    started: Instant,
    over: AtomicBool,
    /// When the bar was drawn last, in milliseconds from the start.
    drawn: AtomicU64,
}

impl Phases {
    /// Shows nothing where `quiet`.
    pub fn new(quiet: bool) -> Phases {
        let now = Arc::new(Now {
            meter: Meter::default(),
            began: Mutex::default(),
            started: Instant::now(),
            over: AtomicBool::new(false),
            drawn: AtomicU64::new(0),
        });
        let plain = !quiet && !std::io::stderr().is_terminal() && !limits_addresses();
        let teller = plain.then(|| {
            let now = Arc::clone(&now);
            std::thread::Builder::new().spawn(move || now.tell())
        });
        Phases {
            bar: bar(quiet),
            now,
            teller: teller.and_then(Result::ok),
            quiet,
        }
    }
}

impl Phases {
    fn draw(&self) {
        let seen = self.now.meter.look();
        self.bar.set_length(seen.total);
        self.bar.set_position(seen.done);
        self.bar.set_message(self.now.line());
    }
}

impl Now {
    /// Prints the phase now and then, less and less often: a preparation may take hours.
    fn tell(&self) {
        let mut lines = Lines::every(LINE);
        while !self.over.load(Ordering::Relaxed) {
            std::thread::park_timeout(TICK);
            let elapsed = self.started.elapsed();
            if lines.due(elapsed) {
                lines.slow(elapsed);
                note(&format!("{}, {} s", self.line(), elapsed.as_secs()));
            }
        }
    }

    /// The phase, and how far it is where it counts.
    fn line(&self) -> String {
        let seen = self.meter.look();
        let mut began = self.began.lock().unwrap_or_else(PoisonError::into_inner);
        if seen.total == 0 {
            *began = None;
        }
        let (then, before) = *began.get_or_insert((Instant::now(), seen));
        let phase = self.meter.phase.lock();
        let phase = phase.unwrap_or_else(PoisonError::into_inner);
        status((&phase, "triangles"), seen, before, then.elapsed())
    }
}

impl Drop for Phases {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
        self.now.over.store(true, Ordering::Relaxed);
        if let Some(teller) = self.teller.take() {
            teller.thread().unpark();
            let _ = teller.join();
        }
    }
}

impl Progress for Phases {
    fn advance(&self, done: u64, total: u64) {
        self.now.meter.advance(done, total);
        // Charts may be many and small: the bar is drawn ten times a second at most.
        let now = self.now.started.elapsed().as_millis() as u64;
        let before = self.now.drawn.load(Ordering::Relaxed);
        if now >= before + TICK.as_millis() as u64 {
            self.now.drawn.store(now, Ordering::Relaxed);
            self.draw();
        }
    }

    fn phase(&self, name: &str) {
        self.now.meter.phase(name);
        let began = self.now.began.lock();
        *began.unwrap_or_else(PoisonError::into_inner) = None;
        self.draw();
    }

    fn note(&self, line: &str) {
        if !self.quiet {
            crate::outcome::tell(line);
        }
    }
}

/// A bar on a terminal; elsewhere it is not seen.
fn bar(quiet: bool) -> ProgressBar {
    let target = if quiet || !std::io::stderr().is_terminal() {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr()
    };
    let bar = ProgressBar::with_draw_target(Some(0), target);
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}") {
        let style = match wants_ascii() {
            true => style.progress_chars("=> "),
            false => style,
        };
        bar.set_style(style);
    }
    bar
}

/// Counts what a job tells.
#[derive(Debug, Default)]
struct Meter {
    phase: Mutex<String>,
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

    fn phase(&self, name: &str) {
        let mut phase = self.phase.lock().unwrap_or_else(PoisonError::into_inner);
        if *phase != name {
            name.clone_into(&mut phase);
            self.total.store(0, Ordering::Relaxed);
            self.done.store(0, Ordering::Relaxed);
        }
    }

    fn rays(&self, cast: u64) {
        self.rays.fetch_add(cast, Ordering::Relaxed);
    }

    fn note(&self, line: &str) {
        if !self.quiet {
            crate::outcome::tell(line);
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
        let bar = bar(self.quiet);
        let mut lines = Lines::every(LINE);
        let (mut began, mut phase) = (None, String::new());
        while !done.load(Ordering::Relaxed) {
            std::thread::park_timeout(TICK);
            if stop.signal().is_some() {
                meter.cancel();
            }
            let (seen, elapsed) = (meter.look(), started.elapsed());
            let current = meter.phase.lock().unwrap_or_else(PoisonError::into_inner);
            if *current != phase {
                current.clone_into(&mut phase);
                began = None;
            }
            drop(current);
            bar.set_length(seen.total);
            bar.set_position(seen.done.min(seen.total));
            // What is prepared before the first unit of work, and units that an earlier run has done, say nothing of
            // the speed.
            let (then, before) = *began.get_or_insert((elapsed, seen));
            if seen.total == 0 {
                began = None;
            }
            let line = status((&phase, self.unit), seen, before, elapsed - then);
            if !self.quiet && !terminal && lines.due(elapsed) {
                note(&line);
            }
            bar.set_message(line);
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

    /// Lets half as much time pass before the next line as has passed so far.
    fn slow(&mut self, elapsed: Duration) {
        self.next = elapsed + self.step.max(elapsed / 2);
    }
}

/// A number of things in words: `1 page`, `2 pages`.
pub fn count(number: impl Into<u64>, thing: &str) -> String {
    let number = number.into();
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{plural}")
}

/// The size of a page of this edge, in texels.
pub fn square(edge: u32) -> String {
    format!("{edge} x {edge}")
}

/// A number of bytes in the unit that fits it, of powers of 1024: `7.20 GiB`, `340 KiB`.
pub fn size(bytes: u64) -> String {
    let units = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    // What would round to 1000 digits of three is one of the next.
    while value >= 999.5 && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    let digits = match value {
        _ if unit == 0 => 0,
        ..9.995 => 2,
        ..99.95 => 1,
        _ => 0,
    };
    format!("{value:.digits$} {}", units[unit])
}

/// Rays per second in words: `3.0 million rays/s`, `40 thousand rays/s`.
pub fn ray_rate(rays: u64, seconds: f64) -> String {
    let rate = rays as f64 / seconds.max(1e-9);
    match rate {
        1e6.. => format!("{:.1} million rays/s", rate / 1e6),
        _ => format!("{:.0} thousand rays/s", rate / 1e3),
    }
}

/// How far a phase of a job is, `elapsed` after it was at `before`.
fn status((phase, unit): (&str, &str), seen: Seen, before: Seen, elapsed: Duration) -> String {
    let Seen { done, total, rays } = seen;
    let rate = match rays.saturating_sub(before.rays) {
        0 => String::new(),
        rays => format!("{}, ", ray_rate(rays, elapsed.as_secs_f64())),
    };
    let counted = match done.saturating_sub(before.done) {
        _ if total == 0 => String::new(),
        // What is left then is not counted.
        _ if done >= total => format!("{total} of {total} {unit}, finishing"),
        0 => format!("{done} of {total} {unit}"),
        new => {
            let left = elapsed.mul_f64((total - done) as f64 / new as f64);
            format!(
                "{done} of {total} {unit}, {rate}{} left",
                HumanDuration(left)
            )
        }
    };
    match (phase, counted.as_str()) {
        ("", "") => "preparing".to_owned(),
        (phase, "") => phase.to_owned(),
        ("", counted) => counted.to_owned(),
        (phase, counted) => format!("{phase}: {counted}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_the_unit_that_fits_them() {
        for (bytes, text) in [
            (0, "0 bytes"),
            (999, "999 bytes"),
            (1000, "0.98 KiB"),
            (340 << 10, "340 KiB"),
            (1 << 20, "1.00 MiB"),
            (23 << 30, "23.0 GiB"),
            (1023 << 30, "1.00 TiB"),
        ] {
            assert_eq!(size(bytes), text);
        }
    }

    #[test]
    fn a_status_tells_work_rays_and_the_time_left() {
        let seen = |done, rays| Seen {
            done,
            total: 100,
            rays,
        };
        let elapsed = Duration::from_secs(10);
        let start = Seen::default();
        let said = |seen, before| status(("", "texels"), seen, before, elapsed);
        assert_eq!(said(start, start), "preparing");
        assert_eq!(said(seen(0, 0), start), "0 of 100 texels");
        assert_eq!(
            said(seen(25, 0), start),
            "25 of 100 texels, 30 seconds left"
        );
        assert_eq!(
            said(seen(25, 30_000_000), start),
            "25 of 100 texels, 3.0 million rays/s, 30 seconds left"
        );
        // Resumed at 50.
        assert_eq!(said(seen(50, 0), seen(50, 0)), "50 of 100 texels");
        assert_eq!(
            said(seen(75, 40_000), seen(50, 10_000)),
            "75 of 100 texels, 3 thousand rays/s, 10 seconds left"
        );
        assert_eq!(said(seen(100, 0), start), "100 of 100 texels, finishing");
        let gather = |seen| status(("gather 2", "texels"), seen, start, elapsed);
        assert_eq!(gather(start), "gather 2");
        assert_eq!(
            gather(seen(25, 0)),
            "gather 2: 25 of 100 texels, 30 seconds left"
        );
        assert_eq!(ray_rate(120_000, 3.0), "40 thousand rays/s");
    }

    #[test]
    fn phases_of_a_preparation_count_where_they_can() {
        let phases = Phases::new(true);
        phases.phase("planning");
        assert_eq!(phases.now.line(), "planning");
        phases.phase("making charts");
        phases.advance(0, 40);
        assert_eq!(phases.now.line(), "making charts: 0 of 40 triangles");
        phases.advance(10, 40);
        let line = phases.now.line();
        let begin = "making charts: 10 of 40 triangles, ";
        assert!(line.starts_with(begin) && line.ends_with(" left"), "{line}");
        phases.phase("packing charts");
        assert_eq!(phases.now.line(), "packing charts");
    }

    #[test]
    fn plain_lines_are_ten_seconds_apart() {
        let mut lines = Lines::every(LINE);
        let due: Vec<u64> = (0..400)
            .filter(|tenths| lines.due(TICK * *tenths as u32))
            .collect();
        assert_eq!(due, [100, 200, 300]);
        let mut lines = Lines::every(LINE);
        let mut due = Vec::new();
        for elapsed in (0..6000).map(|tenths| TICK * tenths) {
            if lines.due(elapsed) {
                lines.slow(elapsed);
                due.push(elapsed.as_secs());
            }
        }
        assert_eq!(due, [10, 20, 30, 45, 67, 101, 152, 228, 342, 513]);
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
        // Each phase counts anew; one that goes on goes on.
        meter.phase("gather 2");
        meter.advance(2, 10);
        meter.phase("gather 2");
        assert_eq!(meter.look(), Seen { done: 2, ..seen });
        meter.phase("writing");
        assert_eq!((meter.look().done, meter.look().total), (0, 0));
        assert!(!meter.cancelled());
        meter.cancel();
        assert!(meter.cancelled());
    }
}
