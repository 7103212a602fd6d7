//! Long loops that tell how far they are and end where they are asked to.

use crate::Error;
use layers::Progress;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Fewest units of work that a thread takes at a time.
const GRAIN: usize = 16;

/// One of several like parts of a job, for the job's listener: each of six pictures, each frame of a sequence.
pub struct Part<'a> {
    /// Who listens to the whole.
    pub whole: &'a dyn Progress,
    /// Which part this is, from 0.
    pub index: u64,
    /// Number of parts.
    pub count: u64,
}

impl Progress for Part<'_> {
    fn advance(&self, done: u64, total: u64) {
        self.whole
            .advance(self.index * total + done, self.count * total);
    }

    fn rays(&self, cast: u64) {
        self.whole.rays(cast);
    }

    fn cancelled(&self) -> bool {
        self.whole.cancelled()
    }
}

/// What `job` makes of every number below `count`, in order, made by all threads. Each number is `units` units of the
/// work that `progress` hears of; with 0 it hears of none, but is still asked whether to go on.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn each<T: Send>(
    count: usize,
    units: usize,
    progress: &dyn Progress,
    job: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>, Error> {
    let done = AtomicU64::new(0);
    let made = |number| {
        if progress.cancelled() {
            return None;
        }
        let result = job(number);
        if units > 0 {
            let before = done.fetch_add(units as u64, Ordering::Relaxed);
            progress.advance(before + units as u64, (count * units) as u64);
        }
        Some(result)
    };
    let numbers = (0..count).into_par_iter();
    let results: Option<Vec<T>> = numbers
        .with_min_len(GRAIN.div_ceil(units.max(1)))
        .map(made)
        .collect();
    results.ok_or(Error::Cancelled)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    /// Remembers what it hears and cancels after so much of it.
    struct Heard {
        calls: Mutex<Vec<(u64, u64)>>,
        limit: u64,
    }

    impl Heard {
        fn up_to(limit: u64) -> Heard {
            Heard {
                calls: Mutex::new(Vec::new()),
                limit,
            }
        }

        fn most(&self) -> Option<(u64, u64)> {
            self.calls.lock().unwrap().iter().copied().max()
        }
    }

    impl Progress for Heard {
        fn advance(&self, done: u64, total: u64) {
            self.calls.lock().unwrap().push((done, total));
        }

        fn cancelled(&self) -> bool {
            self.most().is_some_and(|(done, _)| done >= self.limit)
        }
    }

    #[test]
    fn every_number_is_made_once_in_order_and_all_units_are_told() {
        let heard = Heard::up_to(u64::MAX);
        let made = each(100, 7, &heard, |number| number * number).unwrap();
        assert!(made.into_iter().eq((0..100).map(|number| number * number)));
        assert_eq!(heard.most(), Some((700, 700)));
        assert_eq!(heard.calls.lock().unwrap().len(), 100);
    }

    #[test]
    fn a_cancelled_loop_is_an_error_and_leaves_work_undone() {
        let heard = Heard::up_to(5);
        let made = AtomicU64::new(0);
        let result = each(100_000, 1, &heard, |_| made.fetch_add(1, Ordering::Relaxed));
        assert!(matches!(result, Err(Error::Cancelled)), "{result:?}");
        let made = made.into_inner();
        assert!(made < 100_000, "{made} of 100000 were made");
    }

    #[test]
    fn parts_of_a_job_add_up_to_the_whole() {
        let heard = Heard::up_to(u64::MAX);
        for index in 0..3 {
            let part = Part {
                whole: &heard,
                index,
                count: 3,
            };
            each(10, 2, &part, |_| ()).unwrap();
            assert_eq!(heard.most(), Some((20 * (index + 1), 60)));
        }
    }
}
