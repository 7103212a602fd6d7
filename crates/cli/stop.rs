//! Ctrl-C and SIGTERM: the first asks the job to stop at a place where nothing is half-written.

use crate::outcome::Outcome;
use anyhow::Context;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The signal that arrived, if any.
#[derive(Clone)]
pub struct Stop(Arc<AtomicUsize>);

impl Stop {
    /// Starts to listen.
    pub fn listen() -> anyhow::Result<Self> {
        let caught = Arc::new(AtomicUsize::new(0));
        for signal in [SIGINT, SIGTERM] {
            signal_hook::flag::register_usize(signal, Arc::clone(&caught), signal as usize)
                .context("cannot listen for signals")?;
        }
        Ok(Self(caught))
    }

    /// The signal's number.
    pub fn signal(&self) -> Option<i32> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            signal => Some(signal as i32),
        }
    }

    /// How a verb ends whose job was stopped.
    pub fn outcome(&self) -> Outcome {
        Outcome::Stopped(self.signal().unwrap_or(SIGINT))
    }
}
