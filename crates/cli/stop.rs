//! Ctrl-C and SIGTERM. While a job runs that can stop cleanly, the first asks it to, at a place where nothing is
//! half-written, and the second ends the program. Before and after such a job (load, plan, layout, build) nothing
//! stands in a file, so the first ends it.

use crate::outcome::Outcome;
use anyhow::Context;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// The signal that arrived, if any.
#[derive(Clone)]
pub struct Stop {
    caught: Arc<AtomicUsize>,
    /// The next signal ends the program, with the signal's exit status.
    at_once: Arc<AtomicBool>,
}

/// A time in which the first signal only asks.
pub struct Held<'a>(&'a Stop);

impl Stop {
    /// Starts to listen.
    pub fn listen() -> anyhow::Result<Self> {
        let stop = Self {
            caught: Arc::default(),
            at_once: Arc::new(AtomicBool::new(true)),
        };
        for signal in [SIGINT, SIGTERM] {
            let (caught, at_once) = (&stop.caught, &stop.at_once);
            // In this order: the one that arms the end of the program comes last, so that the second signal meets it.
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(at_once))
                .and_then(|_| flag::register_usize(signal, Arc::clone(caught), signal as usize))
                .and_then(|_| flag::register(signal, Arc::clone(at_once)))
                .context("cannot listen for signals")?;
        }
        // A file that may not grow is a write that fails, not a signal that kills.
        #[cfg(unix)]
        flag::register(signal_hook::consts::SIGXFSZ, Arc::default())
            .context("cannot listen for signals")?;
        Ok(stop)
    }

    /// Lets the next signal ask instead of ending the program, until the guard is dropped. Not where one has asked
    /// before.
    pub fn hold(&self) -> Held<'_> {
        self.at_once.store(false, Ordering::SeqCst);
        if self.signal().is_some() {
            self.at_once.store(true, Ordering::SeqCst);
        }
        Held(self)
    }

    /// The signal's number.
    pub fn signal(&self) -> Option<i32> {
        match self.caught.load(Ordering::SeqCst) {
            0 => None,
            signal => Some(signal as i32),
        }
    }

    /// How a verb ends whose job was stopped.
    pub fn outcome(&self) -> Outcome {
        Outcome::Stopped(self.signal().unwrap_or(SIGINT))
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        self.0.at_once.store(true, Ordering::SeqCst);
    }
}
