//! How long this process has had a processor.

/// Seconds, user and system, of every thread that this process has or had; `None` where the system does not tell.
pub fn cpu_seconds() -> Option<f64> {
    #[cfg(all(unix, feature = "write"))]
    {
        let spent = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(spent.tv_sec as f64 + spent.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(all(unix, feature = "write")))]
    None
}
