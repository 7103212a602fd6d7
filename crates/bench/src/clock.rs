//! CPU and wall time of a job.

use report::cpu_seconds;
use std::time::Instant;

/// Seconds that a job took.
#[derive(Debug, Clone, Copy)]
pub struct Spent {
    /// Over all threads of this process, user and system, where the system tells; else wall time.
    pub cpu: f64,
    /// On the wall.
    pub wall: f64,
}

/// Runs and times a job.
pub fn time<R>(job: impl FnOnce() -> R) -> (R, Spent) {
    let (cpu, started) = (cpu_seconds(), Instant::now());
    let result = job();
    let wall = started.elapsed().as_secs_f64();
    let cpu = match (cpu, cpu_seconds()) {
        (Some(before), Some(after)) => after - before,
        _ => wall,
    };
    (result, Spent { cpu, wall })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use rustix::time::{ClockId, clock_gettime};

    /// Keeps this thread busy until it has had 20 ms of a CPU, however many others want it.
    fn spin() {
        let own = || {
            let t = clock_gettime(ClockId::ThreadCPUTime);
            t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
        };
        let until = own() + 0.02;
        while own() < until {}
    }

    #[test]
    fn busy_time_of_this_thread_and_of_one_that_ended_is_counted() {
        let (_, spent) = time(|| {
            spin();
            std::thread::spawn(spin).join()
        });
        assert!(spent.cpu >= 0.04, "{spent:?}");
    }
}
