//! Runs a prepared bake, in memory or into a directory.

use crate::baked::{Baked, Page};
use crate::error::Error;
use crate::job::Job;
use crate::resume::Saved;
use crate::write::{Writer, Written};
use layers::Progress;
use report::{Output, PhaseReport};
use serde_json::json;
use std::path::Path;
use std::time::Instant;

impl Job {
    /// Bakes every page and keeps the result in memory.
    ///
    /// # Errors
    /// [`Error::Cancelled`] where the listener cancels.
    pub fn run(mut self, progress: &dyn Progress) -> Result<Baked, Error> {
        let started = Instant::now();
        let pages = self.within(|| {
            let baker = self.baker();
            (0..self.atlas().page_count)
                .map(|number| {
                    let mut page = baker.start(number);
                    baker.run(&mut page, progress);
                    match page.finished {
                        true => Ok(Page(page)),
                        false => Err(Error::Cancelled),
                    }
                })
                .collect::<Result<Vec<_>, Error>>()
        })?;
        self.end_phase("bake", started.elapsed().as_secs_f64());
        Ok(Baked::new(self, pages))
    }

    /// Bakes into a directory: pages are written as they are finished, so that one page is in memory at a time. Nothing stands under a
    /// final name until all of it is complete. Where the listener cancels, the state is saved, and the same call with `resume`
    /// continues it to the same bytes.
    ///
    /// # Errors
    /// The directory cannot be written, is too full or another bake's, an output would replace an input, or [`Error::Cancelled`].
    pub fn run_into(
        &self,
        dir: &Path,
        resume: bool,
        progress: &dyn Progress,
    ) -> Result<Written, Error> {
        let output = Output::exclusive(dir)?;
        report::check_space(dir, self.bytes_written())?;
        let mut writer = Writer::new(self, output)?;
        let key = json!({
            "version": crate::VERSION,
            "options": self.options().describe(),
            "scene": self.scene().content_hash,
            "backend": self.backend().describe(),
        });
        let saved = Saved::new(dir, &self.scene().stem(), key);
        let (mut baking, mut writing) = (0.0, 0.0);
        let mut last = None;
        let baker = self.baker();
        for number in 0..self.atlas().page_count {
            let mut page = baker.start(number);
            if resume {
                saved.restore(&mut page)?;
            }
            let clock = Instant::now();
            if !page.finished {
                self.within(|| baker.run(&mut page, progress));
            }
            baking += clock.elapsed().as_secs_f64();
            if !page.finished || self.atlas().page_count > 1 {
                saved.write(&page)?;
            }
            if !page.finished {
                return Err(Error::Cancelled);
            }
            let clock = Instant::now();
            if let Err(error) = self.within(|| writer.page(&page)) {
                return Err(self.unwritten(error, saved.write(&page).is_ok()));
            }
            writing += clock.elapsed().as_secs_f64();
            // Of several pages the states are there already.
            last = (self.atlas().page_count == 1).then_some(page);
        }
        let mut phases = self.phases().to_vec();
        for (phase, seconds) in [("bake", baking), ("write", writing)] {
            phases.push(PhaseReport {
                phase: phase.into(),
                seconds,
            });
        }
        let written = writer.finish(phases).map_err(|error| {
            let kept = last.is_none_or(|page| saved.write(&page).is_ok());
            self.unwritten(error, kept)
        })?;
        saved.clear(self.atlas().page_count);
        Ok(written)
    }
}
