//! How long a thread had a processor: what others do on the machine does not count.

/// A moment in the time of the thread that asks.
pub(crate) struct ThreadClock(
    #[cfg(all(unix, feature = "thread-clock"))] rustix::time::Timespec,
    #[cfg(not(all(unix, feature = "thread-clock")))] std::time::Instant,
);

impl ThreadClock {
    /// Now.
    pub fn now() -> Self {
        #[cfg(all(unix, feature = "thread-clock"))]
        let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        #[cfg(not(all(unix, feature = "thread-clock")))]
        let now = std::time::Instant::now();
        Self(now)
    }

    /// Seconds since then, of the same thread; of the wall clock where the system tells no other.
    pub fn seconds(&self) -> f64 {
        let now = Self::now().0;
        #[cfg(all(unix, feature = "thread-clock"))]
        let seconds =
            (now.tv_sec - self.0.tv_sec) as f64 + (now.tv_nsec - self.0.tv_nsec) as f64 * 1e-9;
        #[cfg(not(all(unix, feature = "thread-clock")))]
        let seconds = now.duration_since(self.0).as_secs_f64();
        seconds
    }
}
