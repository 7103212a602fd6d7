//! Facts about this program and this process.

pub use ambake::VERSION;
use std::sync::OnceLock;

/// Instruction set extensions the compiler was allowed to use.
pub const TARGET_FEATURES: &str = env!("AMBAKE_TARGET_FEATURES");

/// Installs the worker pool, the first time that it is called, and returns its size.
pub fn set_threads(threads: Option<u32>) -> anyhow::Result<usize> {
    static INSTALLED: OnceLock<usize> = OnceLock::new();
    if let Some(&count) = INSTALLED.get() {
        return Ok(count);
    }
    let count = threads.map_or_else(
        || std::thread::available_parallelism().map_or(1, |n| n.get()),
        |n| n as usize,
    );
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build_global()?;
    Ok(*INSTALLED.get_or_init(|| count))
}

/// True where the system limits the addresses of this process (`ulimit -v`), and says so.
pub fn limits_addresses() -> bool {
    let limits = std::fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let mut rows = limits
        .lines()
        .filter_map(|row| row.strip_prefix("Max address space"));
    rows.any(|row| !row.trim_start().starts_with("unlimited"))
}
