//! Facts about this program and this process.

/// ambake's version, with the git revision where the build knew it.
pub const VERSION: &str = env!("AMBAKE_VERSION");

/// Git revision at build time; empty where there was none.
pub const REVISION: &str = env!("AMBAKE_REVISION");

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
