//! Runs a prepared bake into a directory.

use crate::baked::{Baked, Page};
use crate::error::Error;
use crate::job::Job;
use crate::parts::Kind;
use crate::resume::{Resume, Saved};
use crate::update::Tracker;
use crate::write::{Writer, Written};
use ::bake::{BakedPage, BounceStats};
use layers::Progress;
use report::{Output, PhaseReport, cpu_seconds};
use serde_json::json;
use std::path::Path;
use std::time::Instant;

/// What is done to baked pages, as a listener hears it.
pub(crate) const WRITING: &str = "writing";

impl Job {
    /// Bakes into a directory: pages are written as they are finished, so that one page is in memory at a time; where
    /// light is added to them, all are, because it goes from page to page. Nothing stands under a final name until all
    /// of it is complete. What is baked is saved now and then; where the listener cancels, the process dies or a file
    /// cannot be written, the same call continues it to the same bytes.
    ///
    /// * `resume`: what is done about a state that was saved.
    ///
    /// # Errors
    /// The directory cannot be written, is too full or another bake's, an output would replace an input, or
    /// [`Error::Cancelled`].
    pub fn run_into(
        &self,
        dir: &Path,
        resume: Resume,
        progress: &dyn Progress,
    ) -> Result<Written, Error> {
        let (written, ..) = self.run_taking(dir, resume, progress, drop)?;
        Ok(written)
    }

    /// As [`Job::run_into`], and keeps every page in memory too.
    ///
    /// # Errors
    /// As [`Job::run_into`].
    pub fn run_into_kept(
        self,
        dir: &Path,
        resume: Resume,
        progress: &dyn Progress,
    ) -> Result<(Baked, Written), Error> {
        let mut pages = Vec::new();
        let take = |page| pages.push(Page(page));
        let (written, bounces, seconds) = self.run_taking(dir, resume, progress, take)?;
        Ok((Baked::new(self.ran(seconds), pages, bounces), written))
    }

    /// The same with tiles of gathers brought to the disk now and then, and when the listener cancels.
    pub(crate) fn bounce_saving(
        &self,
        pages: &mut [BakedPage],
        saved: &mut Saved,
        progress: &dyn Progress,
    ) -> Result<Option<BounceStats>, Error> {
        if self.options().adds_light() {
            // Gathers take memory of their own.
            saved.flush().map_err(self.unsaved(saved))?;
        }
        match self.bounce(pages, saved, progress) {
            Err(Error::Cancelled) => {
                saved.flush()?;
                Err(Error::Cancelled)
            }
            other => other.map_err(self.unsaved(saved)),
        }
    }

    /// Bakes into a directory; pages are handed on in their order, each once it is written. Comes back with the seconds
    /// of pages and of the light that was added.
    fn run_taking(
        &self,
        dir: &Path,
        resume: Resume,
        progress: &dyn Progress,
        mut take: impl FnMut(BakedPage),
    ) -> Result<(Written, Option<BounceStats>, [f64; 2]), Error> {
        let output = Output::exclusive(dir)?;
        report::check_space(dir, self.room().peak())?;
        let mut writer = Writer::new(self, output)?;
        let baker = self.baker();
        let header = json!({"key": self.key()});
        let state = dir.join(Kind::Bake.state_name(&self.scene().stem(), None));
        let resumes = resume.wants(&state);
        let mut saved = Saved::new(state, header, self.widths(&baker));
        if resumes {
            let damage = saved.resume()?;
            let said = damage.as_deref().into_iter().chain(saved.origin());
            said.for_each(|line| progress.note(line));
        }
        let mut tracker = Tracker::of(self, &baker);
        if let Some(reason) = tracker.reason() {
            progress.note(&format!("--update keeps less than it could: {reason}"));
        }
        let (mut baking, mut writing) = (0.0, 0.0);
        let mut processors = Some(0.0);
        let adds_light = self.options().adds_light();
        let mut waiting = Vec::new();
        for number in 0..self.atlas().page_count {
            let mut page = baker.start(number);
            let mut fits = true;
            saved.restore(number, |block| {
                page.stats.seconds += block.seconds;
                fits &= block.tiles.iter().all(|tile| page.store(tile));
            })?;
            if !fits {
                progress.note(&format!(
                    "what was saved of page {number} is not of this bake; starting that page over"
                ));
                page = baker.start(number);
            }
            let (clock, cpu) = (Instant::now(), cpu_seconds());
            let tiles = self.within(|| tracker.keep(&mut page, &|line| progress.note(line)));
            let whole = self
                .within(|| baker.fill(&mut page, progress, &mut |tile| saved.add(number, &tile)))
                .map_err(self.unsaved(&saved))?;
            if !whole {
                saved.flush()?;
                return Err(Error::Cancelled);
            }
            self.within(|| tracker.verify(&page, &tiles))?;
            if let Err(error) = self.within(|| writer.tiles(&page, tracker.key(), &tiles)) {
                return Err(self.unwritten(error, saved.flush().is_ok()));
            }
            self.within(|| baker.finish(&mut page, progress));
            baking += clock.elapsed().as_secs_f64();
            processors = processors.and_then(|sum| Some(sum + cpu_seconds()? - cpu?));
            if adds_light {
                waiting.push(page);
                continue;
            }
            let clock = Instant::now();
            progress.phase(WRITING);
            if let Err(error) = self.within(|| writer.page(&page)) {
                return Err(self.unwritten(error, saved.flush().is_ok()));
            }
            writing += clock.elapsed().as_secs_f64();
            take(page);
        }
        let clock = Instant::now();
        let bounced = self.bounce_saving(&mut waiting, &mut saved, progress)?;
        let bouncing = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        progress.phase(WRITING);
        for page in waiting {
            if let Err(error) = self.within(|| writer.page(&page)) {
                return Err(self.unwritten(error, saved.flush().is_ok()));
            }
            take(page);
        }
        writing += clock.elapsed().as_secs_f64();
        let mut phases = self.phases().to_vec();
        let bounce = adds_light.then_some(("bounce", bouncing));
        phases.push(PhaseReport {
            phase: "bake".into(),
            seconds: baking,
            cpu_seconds: processors,
        });
        for (phase, seconds) in bounce.into_iter().chain([("write", writing)]) {
            phases.push(PhaseReport {
                phase: phase.into(),
                seconds,
                ..PhaseReport::default()
            });
        }
        writer.tracked(tracker)?;
        match writer.finish(phases, bounced) {
            Ok(written) => {
                saved.remove();
                Ok((written, bounced, [baking, bouncing]))
            }
            Err(error) => Err(self.unwritten(error, saved.flush().is_ok())),
        }
    }
}
