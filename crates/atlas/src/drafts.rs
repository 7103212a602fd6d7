//! What shapes take with their gutters, by the budget of texels that they share: what is known of it, and where between
//! it is asked.

use crate::Error;

/// Two budgets that are so many times apart at most are known well enough.
const CLOSE: f64 = 1.05;
/// How far beside the budget that what is known points at the next one is asked: twice that is just [`CLOSE`] enough.
const BESIDE: f64 = 1.024;

/// The texels that shapes touch or that are their gutters, at the budgets at which they were cut.
pub(crate) struct Drafts<F> {
    cut: F,
    /// Budgets and texels, ascending by budget.
    known: Vec<(f64, f64)>,
}

impl<F: Fn(f64) -> Result<f64, Error>> Drafts<F> {
    /// None yet. `cut` tells the texels at a budget, more or as many at a larger one, and is asked once for each.
    pub fn new(cut: F) -> Self {
        Self {
            cut,
            known: Vec::new(),
        }
    }

    /// The texels at a budget.
    ///
    /// # Errors
    ///
    /// Those of `cut`.
    pub fn grown(&mut self, budget: f64) -> Result<f64, Error> {
        let at = self.known.partition_point(|&(known, _)| known < budget);
        match self.known.get(at) {
            Some(&(known, grown)) if known == budget => Ok(grown),
            _ => {
                let grown = (self.cut)(budget)?;
                self.known.insert(at, (budget, grown));
                Ok(grown)
            }
        }
    }

    /// Two budgets from 1 to `most`, a twentieth apart at most: at the first shapes take no more than `room`, at the
    /// second they do. The first is 1 where they always take more, and both are `most` where they never do.
    ///
    /// # Errors
    ///
    /// Those of `cut`.
    pub fn around(&mut self, room: f64, most: f64) -> Result<(f64, f64), Error> {
        let is_over = |known: &[(f64, f64)]| {
            let first = known.iter().find(|(_, grown)| *grown > room);
            first.copied().filter(|(budget, _)| *budget <= most)
        };
        if is_over(&self.known).is_none() && self.grown(most)? <= room {
            return Ok((most, most));
        }
        if self.grown(1.0)? > room {
            return Ok((1.0, CLOSE.min(most)));
        }
        let mut high = is_over(&self.known).unwrap_or((most, f64::INFINITY));
        let below = self.known.iter().rev().find(|(budget, _)| *budget < high.0);
        let mut low = *below.unwrap_or(&(1.0, room));
        // Texels are whole, and small shapes stay as they are over many budgets: where what is known leads nowhere,
        // what is between is halved.
        let mut leads = true;
        while high.0 > CLOSE * low.0 {
            let half = f64::sqrt(low.0 * high.0);
            let budget = match leads && high.1.is_finite() {
                true => {
                    let pointed = between(low, high, room);
                    let beside = match pointed > half {
                        true => pointed / BESIDE,
                        false => pointed * BESIDE,
                    };
                    beside.clamp(low.0 * BESIDE, high.0 / BESIDE)
                }
                false => half,
            };
            let before = high.0 / low.0;
            let grown = self.grown(budget)?;
            match grown <= room {
                true => low = (budget, grown),
                false => high = (budget, grown),
            }
            leads = !leads || (high.0 / low.0).powi(2) < before;
        }
        Ok((low.0, high.0))
    }

    /// About the budget at which shapes take so many times the texels that they take at `budget`, by what is known.
    pub fn times(&self, budget: f64, times: f64) -> f64 {
        let finite = |pair: &[(f64, f64)]| (pair[1].1.is_finite()).then_some((pair[0], pair[1]));
        let pairs = || self.known.windows(2).map_while(finite);
        let Some((low, high)) = pairs().find(|(_, high)| budget <= high.0) else {
            return budget;
        };
        let part = (budget.sqrt() - low.0.sqrt()) / (high.0.sqrt() - low.0.sqrt());
        let room = times * (low.1.sqrt() + part * (high.1.sqrt() - low.1.sqrt())).powi(2);
        let pair = pairs().find(|(_, high)| high.1 >= room);
        pair.map_or(budget, |(low, high)| between(low, high, room).max(budget))
    }
}

/// The budget between two at which shapes take so many texels: they and their gutters are squares whose edges grow with
/// the root of the budget.
fn between(low: (f64, f64), high: (f64, f64), room: f64) -> f64 {
    let part = (room.sqrt() - low.1.sqrt()) / (high.1.sqrt() - low.1.sqrt()).max(f64::MIN_POSITIVE);
    let edge = low.0.sqrt() + part.clamp(0.0, 1.0) * (high.0.sqrt() - low.0.sqrt());
    edge * edge
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// The budgets around `room` of pages from 1 to `pages`, and how often shapes were cut.
    fn asked(pages: u32, grown: impl Fn(f64) -> f64) -> (Vec<(f64, f64)>, u32) {
        let count = Cell::new(0);
        let mut drafts = Drafts::new(|budget| {
            count.set(count.get() + 1);
            Ok(grown(budget))
        });
        let around = |page| drafts.around(f64::from(page) * 1e6, f64::from(page) * 1e6);
        let found = (1..=pages)
            .map(around)
            .map(|found| found.expect("no error"));
        (found.collect(), count.get())
    }

    #[test]
    fn few_drafts_are_cut_however_many_pages_are_asked_about() {
        // Charts that grow with the root of their texels, charts of a texel each up to some budget, and such as do not
        // fit on a page from one on.
        let curves: [&dyn Fn(f64) -> f64; 4] = [
            &|budget| 48_000.0 * (5.0 + (budget / 48_000.0).sqrt()).powi(2),
            &|budget| 900_000.0 + (budget - 600_000.0).max(0.0) * 4.0,
            &|budget| {
                if budget < 3e5 {
                    2.0 * budget
                } else {
                    f64::INFINITY
                }
            },
            &|budget| 1.1 * budget,
        ];
        for (number, curve) in curves.into_iter().enumerate() {
            let (found, count) = asked(8, curve);
            for (page, (low, high)) in (1..).zip(found) {
                let room = f64::from(page) * 1e6;
                let fits = |budget: f64| curve(budget) <= room;
                assert!(low >= 1.0 && high <= room && high <= CLOSE * low || low == 1.0);
                assert!(
                    fits(low) || low == 1.0,
                    "{number}, page {page}: {low} is too much"
                );
                assert!(
                    !fits(high) || high == room,
                    "{number}, page {page}: {high} fits"
                );
            }
            assert!(count <= 60, "{count} drafts for curve {number}");
        }
    }
}
