//! What may be opened in a folder that somebody else may have filled.

use std::io;
use std::path::Path;

/// Refuses what is no regular file: a pipe would be waited for, also by signals, and a device be read without end.
///
/// # Errors
/// The file is absent, cannot be asked about, or is something else.
pub fn check_regular(path: &Path) -> io::Result<()> {
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_file() {
        return Ok(());
    }
    let what = match kind.is_dir() {
        true => "it is a directory",
        false => "it is a pipe or a device",
    };
    Err(io::Error::other(what))
}
