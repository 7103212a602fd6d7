//! CPU and wall time of a job.

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

/// Nanoseconds on a CPU of every live thread, as Linux counts them.
fn cpu_seconds() -> Option<f64> {
    let mut nanoseconds = 0.0;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let path = task.ok()?.path().join("schedstat");
        // A thread may end between the two calls.
        let Ok(text) = std::fs::read_to_string(path) else {
            continue;
        };
        nanoseconds += text.split_whitespace().next()?.parse::<f64>().ok()?;
    }
    Some(nanoseconds * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn busy_time_is_counted_and_sleep_is_not() {
        let (_, busy) = time(|| {
            let until = Instant::now() + std::time::Duration::from_millis(60);
            while Instant::now() < until {
                std::hint::black_box(0);
            }
        });
        let (_, idle) = time(|| std::thread::sleep(std::time::Duration::from_millis(60)));
        if cfg!(target_os = "linux") {
            assert!(busy.cpu > idle.cpu + 0.01, "{busy:?} {idle:?}");
        }
        assert!(idle.wall >= 0.06);
    }
}
