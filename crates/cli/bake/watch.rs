//! `ambake watch`: bakes a scene again whenever its files are saved, coarse at first and finer until the next save.

use super::args::Watch as Args;
use super::prepare::{Target, prepare_in};
use super::summary::lines;
use crate::args::{Verb, words};
use crate::outcome::{Outcome, one_line, say, tell};
use crate::progress::{Show, watch};
use crate::stop::Stop;
use crate::{host, project, view};
use ambake::flags::bake::Job;
use ambake::flags::common::Common;
use ambake::{Resume, Written};
use layers::Progress;
use report::Output;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

/// Between two looks at the files. They are asked, and no system is told to report, so that it works on network shares
/// too.
const LOOK: Duration = Duration::from_millis(250);
/// Steps of refinement, each of so many times the rays of the one before; the last has `--rays`.
const STEPS: u32 = 3;
const FINER: u32 = 4;
/// The folder in the output folder that keeps what each step starts from.
const KEPT: &str = ".ambake-watch";

/// Runs the verb until it is stopped.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let stop = Stop::listen()?;
    host::set_threads(args.common.threads)?;
    let _folder = Output::exclusive(&args.output)?.folder();
    let mut files = Files::default();
    loop {
        files.look_at(&[
            args.scene.clone(),
            args.scene.with_file_name(project::PROJECT_FILE),
        ]);
        if let Err(error) = refine(args, &mut files, &stop) {
            tell(&format!("{}; waiting for the next save", one_line(&error)));
        }
        let held = stop.hold();
        while !files.changed() && stop.signal().is_none() {
            std::thread::sleep(LOOK);
        }
        drop(held);
        if stop.signal().is_some() {
            // What cannot be removed is in nobody's way.
            let _ = std::fs::remove_dir_all(args.output.join(KEPT));
            return Ok(stop.outcome());
        }
        // A file in the middle of being saved is left alone until it rests.
        let mut before = files.stamps();
        loop {
            std::thread::sleep(LOOK);
            let now = files.stamps();
            if std::mem::replace(&mut before, now) == before {
                break;
            }
        }
    }
}

/// Bakes all steps, until a file changes or the listener stops.
fn refine(args: &Args, files: &mut Files, stop: &Stop) -> anyhow::Result<()> {
    let completed = project::completed(&args.scene, &words())?;
    let args = match &completed {
        Some(Verb::Watch(watch)) => watch,
        _ => args,
    };
    let (job, common) = (&args.job, &args.common);
    for step in (0..STEPS).rev() {
        let rays = job.rays / FINER.pow(step);
        // Under a target error there is one step.
        if step > 0 && (rays == 0 || job.target_error.is_some()) {
            continue;
        }
        let job = Job {
            rays,
            ..job.clone()
        };
        let clock = Instant::now();
        let kept = args.output.join(KEPT).join(rays.to_string());
        match bake(args, &job, common, &kept, files, stop)? {
            Some(written) => {
                tell_step(args, &job, &written, clock.elapsed())?;
                if step == 0 && !common.quiet {
                    say(&lines(&written.report.warnings))?;
                }
            }
            None => return Ok(()),
        }
    }
    Ok(())
}

/// Bakes a step, refreshes the report and keeps the state in `kept`; `None` where it was broken off.
fn bake(
    args: &Args,
    job: &Job,
    common: &Common,
    kept: &Path,
    files: &mut Files,
    stop: &Stop,
) -> anyhow::Result<Option<Written>> {
    let target = Target {
        dir: &args.output,
        parts: false,
        engines: &args.engines,
        update: Some(kept).filter(|kept| kept.join("bake.json").is_file()),
        verify: false,
    };
    let prepared = prepare_in(&target, &args.scene, job, common)?;
    files.look_at(&prepared.inputs());
    let show = Show {
        unit: "texels",
        quiet: common.quiet,
    };
    let files = &*files;
    let written = watch(show, stop, |progress| {
        prepared.run_into(&args.output, Resume::Never, &Until::of(progress, files))
    });
    let written = match written {
        Err(ambake::Error::Cancelled) => return Ok(None),
        other => other?,
    };
    let _ends_cleanly = stop.hold();
    view::write(&args.output)?;
    let mut names: Vec<&str> = vec!["bake.json"];
    let states = written.report.files.iter().map(String::as_str);
    names.extend(states.filter(|name| name.ends_with(".state")));
    report::copy_files(&args.output, &names, kept)?;
    Ok(Some(written))
}

fn tell_step(args: &Args, job: &Job, written: &Written, took: Duration) -> anyhow::Result<()> {
    if args.common.quiet {
        return Ok(());
    }
    let share = written.report.update.as_ref().map_or(1.0, |of| of.share);
    let rays = match job.target_error {
        Some(error) => format!("error {error}"),
        None => format!("{} rays", job.rays),
    };
    say(&format!(
        "{rays}: {:.1} % of the texels baked, {:.1} s, {}\n",
        100.0 * share,
        took.as_secs_f64(),
        args.output.join(report::REPORT_NAME).display()
    ))
}

/// When files were written last and how long they are; `None` for one that is absent.
type Stamps = BTreeMap<PathBuf, Option<(SystemTime, u64)>>;

/// The files of a scene, and what they were when they were read.
#[derive(Default)]
struct Files(Stamps);

impl Files {
    /// Adds files; those that are known get a new stamp only where all are given anew by [`Files::stamps`].
    fn look_at(&mut self, paths: &[PathBuf]) {
        for path in paths {
            self.0.entry(path.clone()).or_insert_with(|| stamp(path));
        }
    }

    fn stamps(&mut self) -> Stamps {
        for (path, known) in &mut self.0 {
            *known = stamp(path);
        }
        self.0.clone()
    }

    fn changed(&self) -> bool {
        self.0.iter().any(|(path, known)| stamp(path) != *known)
    }
}

fn stamp(path: &Path) -> Option<(SystemTime, u64)> {
    let facts = std::fs::metadata(path).ok()?;
    Some((facts.modified().ok()?, facts.len()))
}

/// A listener that breaks a bake off where a file changes.
struct Until<'a> {
    inner: &'a dyn Progress,
    files: &'a Files,
    looked: Mutex<Instant>,
    over: AtomicBool,
}

impl<'a> Until<'a> {
    fn of(inner: &'a dyn Progress, files: &'a Files) -> Self {
        Self {
            inner,
            files,
            looked: Mutex::new(Instant::now()),
            over: AtomicBool::new(false),
        }
    }
}

impl Progress for Until<'_> {
    fn advance(&self, done: u64, total: u64) {
        self.inner.advance(done, total);
    }

    fn phase(&self, name: &str) {
        self.inner.phase(name);
    }

    fn rays(&self, cast: u64) {
        self.inner.rays(cast);
    }

    fn note(&self, line: &str) {
        self.inner.note(line);
    }

    fn cancelled(&self) -> bool {
        // One thread looks, and now and then.
        if let Ok(mut looked) = self.looked.try_lock()
            && looked.elapsed() >= LOOK
        {
            *looked = Instant::now();
            if self.files.changed() {
                self.over.store(true, Ordering::Relaxed);
            }
        }
        self.over.load(Ordering::Relaxed) || self.inner.cancelled()
    }
}
