//! Runs a prepared bake in memory.

use crate::baked::{Baked, Page};
use crate::error::Error;
use crate::job::Job;
#[cfg(feature = "write")]
use crate::update::Tracker;
use ::bake::{BakedPage, BounceStats, Bounces, KeepGathers};
use layers::Progress;
use std::time::Instant;

impl Job {
    /// Bakes every page and keeps the result in memory. The same job gives the same bytes each time.
    ///
    /// # Errors
    /// [`Error::Cancelled`] where the listener cancels.
    pub fn run(&self, progress: &dyn Progress) -> Result<Baked, Error> {
        let mut pages = Vec::new();
        let (bounces, seconds) = self.each_page(progress, &mut |page| pages.push(Page(page)))?;
        Ok(Baked::new(self.clone().ran(seconds), pages, bounces))
    }

    /// Bakes every page and hands each over, in order, as soon as it is finished: one page is in memory at a time, but
    /// where light is added to them (bounces, lights), because it goes from page to page. What surfaces sent on comes
    /// back, where that was asked for. A panic of `take` goes through.
    ///
    /// # Errors
    /// [`Error::Cancelled`] where the listener cancels; pages that were handed over are sound.
    pub fn run_pages(
        &self,
        progress: &dyn Progress,
        mut take: impl FnMut(Page),
    ) -> Result<Option<BounceStats>, Error> {
        let (bounces, _) = self.each_page(progress, &mut |page| take(Page(page)))?;
        Ok(bounces)
    }

    /// The same, and the seconds of pages and of the light that was added.
    fn each_page(
        &self,
        progress: &dyn Progress,
        take: &mut dyn FnMut(BakedPage),
    ) -> Result<(Option<BounceStats>, [f64; 2]), Error> {
        let (baker, adds_light) = (self.baker(), self.options().adds_light());
        #[cfg(feature = "write")]
        let mut tracker = self
            .earlier()
            .map(|_| self.within(|| Tracker::of(self, &baker)));
        let (mut baking, mut waiting) = (0.0, Vec::new());
        for number in 0..self.atlas().page_count {
            let clock = Instant::now();
            let page = self.within(|| {
                let mut page = baker.start(number);
                #[cfg(feature = "write")]
                if let Some(tracker) = &mut tracker {
                    let tiles = tracker.keep(&mut page, &|line| progress.note(line));
                    tracker.verify(&page, &tiles)?;
                }
                baker.run(&mut page, progress);
                match page.finished {
                    true => Ok(page),
                    false => Err(Error::Cancelled),
                }
            })?;
            baking += clock.elapsed().as_secs_f64();
            match adds_light {
                true => waiting.push(page),
                false => take(page),
            }
        }
        let clock = Instant::now();
        let bounces = self.bounce(&mut waiting, &mut (), progress)?;
        let bouncing = clock.elapsed().as_secs_f64();
        waiting.into_iter().for_each(take);
        Ok((bounces, [baking, bouncing]))
    }

    /// Adds the light of lights and what surfaces send on to all pages, where that was asked for. Tiles of gathers go
    /// through `kept`. `None` where
    /// surfaces send none.
    pub(crate) fn bounce<K: KeepGathers>(
        &self,
        pages: &mut [BakedPage],
        kept: &mut K,
        progress: &dyn Progress,
    ) -> Result<Option<BounceStats>, Error>
    where
        Error: From<K::Error>,
    {
        if !self.options().adds_light() {
            return Ok(None);
        }
        let stats = self.within(|| self.baker().bounce(pages, kept, progress))?;
        let stats = stats.ok_or(Error::Cancelled)?;
        Ok((self.options().bounces != Bounces::Off).then_some(stats))
    }

    /// With the seconds of its pages and of the light that was added to them.
    pub(crate) fn ran(mut self, [baking, bouncing]: [f64; 2]) -> Self {
        self.end_phase("bake", baking);
        if self.options().adds_light() {
            self.end_phase("bounce", bouncing);
        }
        self
    }
}
