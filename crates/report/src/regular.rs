//! What may be opened in a folder that somebody else may have filled.

use std::fs::{File, FileType, OpenOptions};
use std::io::{self, Seek};
use std::path::Path;

/// Refuses what is no regular file: a pipe would be waited for, also by signals, and a device be read without end.
///
/// # Errors
/// The file is absent, cannot be asked about, or is something else.
pub fn check_regular(path: &Path) -> io::Result<()> {
    regular(std::fs::metadata(path)?.file_type())
}

/// As [`check_regular`], for a file that is written in place: a link is refused too, for it would have another file
/// overwritten.
///
/// # Errors
/// As of [`check_regular`].
pub(crate) fn check_own(path: &Path) -> io::Result<()> {
    regular(std::fs::symlink_metadata(path)?.file_type())
}

/// Opens a file to be read and written in place, and makes it where it is absent. It is for after [`check_own`]: what
/// has taken the file's place since then is neither followed nor waited for, where the system can do so.
///
/// # Errors
/// The system's, also for a link.
pub(crate) fn open_own(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(false);
    open(path, &mut options)
}

/// The Blake3 hash of a file in hex. A link is not followed.
///
/// # Errors
/// The system's, also for a link.
pub(crate) fn hash_own(path: &Path) -> io::Result<String> {
    check_own(path)?;
    hash_of(&mut open(path, &mut OpenOptions::new())?)
}

/// The Blake3 hash of all that an open file holds, in hex.
///
/// # Errors
/// The system's.
pub(crate) fn hash_of(file: &mut File) -> io::Result<String> {
    file.rewind()?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(file)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// Opens a regular file to be read, and for what else `options` say; nothing that has taken its place is followed or
/// waited for, where the system can do so.
fn open(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    options.read(true);
    #[cfg(all(unix, feature = "write"))]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt;
        options.custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32);
    }
    let file = options.open(path)?;
    regular(file.metadata()?.file_type())?;
    Ok(file)
}

fn regular(kind: FileType) -> io::Result<()> {
    let what = match kind {
        _ if kind.is_file() => return Ok(()),
        _ if kind.is_dir() => "it is a directory",
        _ if kind.is_symlink() => "it is a symbolic link",
        _ => "it is a pipe or a device",
    };
    Err(io::Error::other(what))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn no_link_is_opened_to_be_written_whatever_it_leads_to() {
        let dir = tempfile::tempdir().unwrap();
        let [file, link, made] = ["file", "link", "made"].map(|name| dir.path().join(name));
        std::fs::write(&file, "mine").unwrap();
        for target in ["file", "gone", "."] {
            std::os::unix::fs::symlink(target, &link).unwrap();
            let refused = check_own(&link).unwrap_err();
            assert_eq!(refused.to_string(), "it is a symbolic link", "{target}");
            // The check may have been passed by a file that stood there then.
            assert!(open_own(&link).is_err(), "{target}");
            std::fs::remove_file(&link).unwrap();
        }
        assert!(!dir.path().join("gone").exists());
        assert!(check_own(&file).is_ok() && open_own(&file).is_ok());
        assert_eq!(std::fs::read(&file).unwrap(), b"mine");
        assert!(open_own(&made).is_ok() && made.is_file());
    }

    #[test]
    fn a_pipe_that_took_a_files_place_is_not_waited_for() {
        let dir = tempfile::tempdir().unwrap();
        let pipe = dir.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        assert!(open_own(&pipe).is_err());
    }
}
