//! Folders of temporary files inside an output directory, and the directories that an output made.

use crate::lock::Lock;
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::{NamedTempFile, TempDir};

/// How names of such folders begin.
const STAGING: &str = ".ambake-staged-";

/// How often a folder is made that other runs take away. Each of those that start or fail at this very moment may do so
/// once.
pub(super) const TRIES: usize = 10_000;

/// The folders that this process has made and not removed.
static STANDING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Has a panic remove what this process has staged and not published, after it was told of. For a program that a panic
/// ends without unwinding: nothing is dropped then.
pub fn remove_staged_on_panic() {
    let tell = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        tell(panic);
        // Where this very thread panicked with the list in hand, the next run sweeps.
        for folder in STANDING
            .try_lock()
            .iter_mut()
            .flat_map(|list| list.drain(..))
        {
            let _ = fs::remove_dir_all(folder);
        }
    }));
}

/// A folder of temporary files inside an output directory, locked for as long as its process lives: one that is there
/// and not locked, a killed run left.
#[derive(Debug)]
pub(super) struct Staging {
    pub folder: TempDir,
    _lock: Lock,
}

impl Staging {
    /// A new one in `dir`; [`ErrorKind::NotFound`] where `dir` went, or where another run took the new one for a
    /// leftover before it was locked.
    pub fn make(dir: &Path) -> io::Result<Self> {
        let folder = tempfile::Builder::new().prefix(STAGING).tempdir_in(dir)?;
        let lock = Lock::of(&File::open(folder.path())?)?;
        match lock {
            Some(_lock) if folder.path().is_dir() => {
                standing().push(folder.path().to_owned());
                Ok(Self { folder, _lock })
            }
            _ => Err(ErrorKind::NotFound.into()),
        }
    }

    /// Removes those that killed runs left in `dir`.
    pub fn sweep(dir: &Path) {
        for entry in fs::read_dir(dir).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let ours = name.to_string_lossy().starts_with(STAGING)
                && entry.file_type().is_ok_and(|kind| kind.is_dir());
            let folder = entry.path();
            if let Some(Ok(handle)) = ours.then(|| File::open(&folder))
                && let Some(_lock) = Lock::proved(&handle)
            {
                // One that cannot be removed is in nobody's way.
                let _ = fs::remove_dir_all(&folder);
            }
        }
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        standing().retain(|folder| folder != self.folder.path());
    }
}

fn standing() -> std::sync::MutexGuard<'static, Vec<PathBuf>> {
    STANDING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The directories that an output made, the innermost first. Those that hold nothing when this is dropped go again: a
/// job that may fail keeps it until its end.
#[derive(Debug, Default)]
pub struct Folder(Vec<PathBuf>);

impl Folder {
    /// Makes `dir` and its parents.
    pub(super) fn make(&mut self, dir: &Path) -> io::Result<()> {
        let absent = |dir: &&Path| !dir.as_os_str().is_empty() && !dir.exists();
        let absent = dir.ancestors().take_while(absent).map(Path::to_owned);
        let absent: Vec<PathBuf> = absent.collect();
        if absent.len() > self.0.len() {
            self.0 = absent;
        }
        fs::create_dir_all(dir)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        for dir in &self.0 {
            // One that holds something stays.
            if fs::remove_dir(dir).is_err() {
                return;
            }
        }
    }
}

/// A new temporary file in `dir`, with the permissions any new file gets.
pub(super) fn temporary(dir: &Path) -> io::Result<NamedTempFile> {
    #[cfg_attr(not(unix), allow(unused_mut, reason = "permissions are those of Unix"))]
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(dir)
}
