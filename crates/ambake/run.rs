//! Runs a prepared bake, in memory or into a directory.

use crate::baked::{Baked, Page};
use crate::error::Error;
use crate::job::Job;
use crate::resume::Saved;
use crate::shard::state_name;
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
    /// final name until all of it is complete. What is baked is saved now and then; where the listener cancels, the process dies or a file
    /// cannot be written, the same call with `resume` continues it to the same bytes.
    ///
    /// # Errors
    /// The directory cannot be written, an output would replace an input, or [`Error::Cancelled`].
    pub fn run_into(
        &self,
        dir: &Path,
        resume: bool,
        progress: &dyn Progress,
    ) -> Result<Written, Error> {
        let output = Output::create(dir)?;
        let mut writer = Writer::new(self, output)?;
        let baker = self.baker();
        let header = json!({"key": self.key()});
        let columns = baker.layers();
        let columns = columns.iter().map(|layer| layer.channels().len()).sum();
        let state = dir.join(state_name(&self.scene().stem(), None));
        let mut saved = Saved::new(state, header, columns);
        if resume && let Some(damage) = saved.resume()? {
            progress.note(&damage);
        }
        let (mut baking, mut writing) = (0.0, 0.0);
        for number in 0..self.atlas().page_count {
            let mut page = baker.start(number);
            saved.restore(number, |block| {
                page.stats.seconds += block.seconds;
                for tile in &block.tiles {
                    page.store(tile);
                }
            })?;
            let clock = Instant::now();
            self.within(|| {
                baker.run_saved(&mut page, progress, &mut |tile| saved.add(number, tile))
            })?;
            baking += clock.elapsed().as_secs_f64();
            if !page.finished {
                saved.flush()?;
                return Err(Error::Cancelled);
            }
            let clock = Instant::now();
            if let Err(error) = self.within(|| writer.page(&page)) {
                // What is baked is kept where that is possible at all.
                let _ = saved.flush();
                return Err(error);
            }
            writing += clock.elapsed().as_secs_f64();
        }
        let mut phases = self.phases().to_vec();
        for (phase, seconds) in [("bake", baking), ("write", writing)] {
            phases.push(PhaseReport {
                phase: phase.into(),
                seconds,
            });
        }
        match writer.finish(phases) {
            Ok(written) => {
                saved.remove();
                Ok(written)
            }
            Err(error) => {
                let _ = saved.flush();
                Err(error)
            }
        }
    }
}
