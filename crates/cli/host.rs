//! Facts about this program and this process.

/// Version with the git revision where the build knew it.
pub const VERSION: &str = env!("AMBAKE_VERSION");

/// Git revision at build time; empty where there was none.
pub const REVISION: &str = env!("AMBAKE_REVISION");

/// Instruction set extensions the compiler was allowed to use.
pub const TARGET_FEATURES: &str = env!("AMBAKE_TARGET_FEATURES");

/// Peak resident memory of this process in bytes, where the system tells.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace()
        .nth(1)?
        .parse::<u64>()
        .ok()
        .map(|kib| kib * 1024)
}

/// Installs the worker pool and returns its size.
pub fn set_threads(threads: Option<u32>) -> anyhow::Result<usize> {
    let count = threads.map_or_else(
        || std::thread::available_parallelism().map_or(1, |n| n.get()),
        |n| n as usize,
    );
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build_global()?;
    Ok(count)
}
