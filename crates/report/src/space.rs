//! Whether there is room on the disk for what a job will write.

use crate::Error;
use std::path::Path;

/// Refuses a job whose files will not fit.
///
/// * `needed`: bytes that the job will write into `dir`.
///
/// # Errors
/// [`Error::Full`]. A system that does not tell what is free lets every job begin.
pub fn check_space(dir: &Path, needed: u64) -> Result<(), Error> {
    match free(dir) {
        Some(free) if free < needed => Err(Error::Full {
            path: dir.into(),
            free,
            needed,
        }),
        _ => Ok(()),
    }
}

/// Bytes that the user may still write into `dir`.
#[cfg(all(unix, feature = "write"))]
fn free(dir: &Path) -> Option<u64> {
    let about = rustix::fs::statvfs(dir).ok()?;
    about.f_bavail.checked_mul(about.f_frsize)
}

#[cfg(not(all(unix, feature = "write")))]
fn free(_: &Path) -> Option<u64> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_job_larger_than_the_disk_is_refused_and_a_small_one_is_not() {
        let dir = tempfile::tempdir().unwrap();
        check_space(dir.path(), 1).unwrap();
        let error = check_space(dir.path(), u64::MAX).unwrap_err().to_string();
        assert!(
            error.contains("MiB free") && error.contains("-o"),
            "{error}"
        );
        assert!(!error.contains('\n'));
    }
}
