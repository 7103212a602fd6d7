//! The output directory: files are staged under temporary names and published together.

mod staging;
#[cfg(test)]
mod tests;

use crate::Error;
use crate::lock::Lock;
use crate::regular::{hash_of, hash_own};
pub use staging::{Folder, remove_staged_on_panic};
use staging::{Staging, TRIES, temporary};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempPath;

/// An output directory with a set of staged files.
///
/// Nothing stands under a final name until [`Output::publish`]. Dropping the set removes what was staged and leaves
/// earlier output untouched, and removes directories that it made and that hold nothing.
#[derive(Debug)]
pub struct Output {
    dir: PathBuf,
    /// Files that no output may replace.
    inputs: Vec<PathBuf>,
    staged: Vec<Staged>,
    /// Names of files that go when the set is published, each with the hash of its content.
    superseded: Vec<(String, String)>,
    /// Where files wait for their names.
    staging: Staging,
    /// Held for as long as nobody else may bake into `dir`.
    _lock: Option<Lock>,
    /// Dropped last, when nothing staged is left.
    folder: Folder,
}

/// A file that waits for its name.
#[derive(Debug)]
struct Staged {
    file: TempPath,
    path: PathBuf,
    /// Blake3 of its content, in hex.
    hash: String,
}

impl Output {
    /// An empty set in `dir`, which is made with its parents where it is absent and is proved writable. Temporary files
    /// that a killed run left there are removed.
    ///
    /// # Errors
    /// [`Error::Directory`] where `dir` is a file, cannot be made, or takes no file.
    pub fn create(dir: &Path) -> Result<Output, Error> {
        let fail = |reason: String| Error::Directory {
            path: dir.to_owned(),
            reason,
        };
        if dir.exists() && !dir.is_dir() {
            return Err(fail("a file of that name exists".into()));
        }
        if dir.is_symlink() && !dir.exists() {
            return Err(fail("it is a link to what is not there".into()));
        }
        let mut folder = Folder::default();
        let mut tries = 0..TRIES;
        let staging = loop {
            match folder.make(dir).and_then(|()| Staging::make(dir)) {
                Err(error) if error.kind() == ErrorKind::NotFound && tries.next().is_some() => {}
                made => break made.map_err(|e| fail(e.to_string()))?,
            }
        };
        Staging::sweep(dir);
        Ok(Output {
            dir: dir.to_owned(),
            inputs: Vec::new(),
            staged: Vec::new(),
            superseded: Vec::new(),
            staging,
            _lock: None,
            folder,
        })
    }

    /// As [`Output::create`], for one job alone: a second one in `dir` is refused until this one is dropped or its
    /// process ends.
    ///
    /// # Errors
    /// As [`Output::create`]; [`Error::Busy`].
    pub fn exclusive(dir: &Path) -> Result<Output, Error> {
        let mut output = Output::create(dir)?;
        // The directory itself is locked, so that no lock file is left behind.
        if let Ok(handle) = File::open(dir) {
            // A run that only looks whether it may begin holds the lock for a moment.
            output._lock = (0..5).find_map(|attempt| {
                std::thread::sleep(Duration::from_millis(20 * attempt));
                Lock::of(&handle).ok().flatten()
            });
            if output._lock.is_none() {
                return Err(Error::Busy { path: dir.into() });
            }
        }
        Ok(output)
    }

    /// An empty set in the directory of one file.
    ///
    /// # Errors
    /// As [`Output::create`].
    pub fn for_file(path: &Path) -> Result<Output, Error> {
        match path.parent() {
            Some(dir) if dir != Path::new("") => Output::create(dir),
            _ => Output::create(Path::new(".")),
        }
    }

    /// Refuses from now on to replace these files, which the outputs are made from.
    pub fn protect(&mut self, inputs: impl IntoIterator<Item = PathBuf>) {
        self.inputs.extend(inputs);
    }

    /// Checks that a file called `name` would not replace an input.
    ///
    /// # Errors
    /// [`Error::ReplacesInput`].
    pub fn check(&self, name: &str) -> Result<(), Error> {
        let path = self.dir.join(name);
        match self.inputs.iter().any(|input| same_file(input, &path)) {
            true => Err(Error::ReplacesInput { path }),
            false => Ok(()),
        }
    }

    /// The directory.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Gives the set and the lock up. The directory stays at least until what is returned is dropped.
    pub fn folder(self) -> Folder {
        self.folder
    }

    /// Has files of an earlier set removed when this one is published, each by its name and the Blake3 hash of its
    /// content in hex. One that holds anything else by then stays, as do inputs, links and what this set writes.
    pub fn supersede(&mut self, earlier: impl IntoIterator<Item = (String, String)>) {
        let plain = |name: &str| Path::new(name).file_name() == Some(name.as_ref());
        let earlier = earlier.into_iter().filter(|(name, _)| plain(name));
        self.superseded.extend(earlier);
    }

    /// Stages one file called `name`: `write` fills it, then it is flushed to the disk under a temporary name.
    ///
    /// An error of `write` whose path is empty is given the file's final name.
    ///
    /// # Errors
    /// What `write` returns, [`Error::Write`], or [`Error::ReplacesInput`].
    pub fn stage(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut File) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.check(name)?;
        let path = self.dir.join(name);
        let mut file = temporary(self.staging.folder.path()).map_err(|e| Error::write(&path, e))?;
        write(file.as_file_mut()).map_err(|error| match error {
            Error::Write {
                path: empty,
                source,
            } if empty.as_os_str().is_empty() => Error::write(&path, source),
            other => other,
        })?;
        let hash = hash_of(file.as_file_mut()).and_then(|hash| {
            file.as_file().sync_all()?;
            Ok(hash)
        });
        self.staged.push(Staged {
            hash: hash.map_err(|e| Error::write(&path, e))?,
            file: file.into_temp_path(),
            path,
        });
        Ok(())
    }

    /// Stages `bytes` as a file called `name`.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn stage_bytes(&mut self, name: &str, bytes: &[u8]) -> Result<(), Error> {
        self.stage(name, |file| {
            file.write_all(bytes)
                .map_err(|e| Error::write(Path::new(""), e))
        })
    }

    /// The staged files in the order of staging: the name of each, and the Blake3 hash of its content in hex.
    pub fn listed(&self) -> Vec<(String, String)> {
        let listed = |staged: &Staged| {
            let name = staged.path.file_name()?.to_string_lossy().into_owned();
            Some((name, staged.hash.clone()))
        };
        self.staged.iter().filter_map(listed).collect()
    }

    /// Renames every staged file to its final name, in the order of staging (stage `bake.json` last), removes what the
    /// set supersedes, and returns the names.
    ///
    /// # Errors
    /// [`Error::Write`]. A name taken by a directory is found before the first rename.
    pub fn publish(self) -> Result<Vec<PathBuf>, Error> {
        if let Some(taken) = self.staged.iter().find(|staged| staged.path.is_dir()) {
            return Err(Error::write(&taken.path, ErrorKind::IsADirectory.into()));
        }
        let superseded = self.superseded.iter().filter(|(name, _)| {
            let written = self.staged.iter().any(|s| s.path == self.dir.join(name));
            !written && self.check(name).is_ok()
        });
        let superseded: Vec<_> = superseded.cloned().collect();
        let mut names = Vec::with_capacity(self.staged.len());
        for Staged { file, path, .. } in self.staged {
            file.persist(&path)
                .map_err(|e| Error::write(&path, e.error))?;
            names.push(path);
        }
        for (name, hash) in superseded {
            let path = self.dir.join(name);
            if hash_own(&path).is_ok_and(|found| found == hash) {
                // One that cannot be removed stays; it is not listed any more.
                let _ = fs::remove_file(path);
            }
        }
        // The names themselves reach the disk with the directory; a file system that cannot sync one still has them.
        let _ = File::open(&self.dir).and_then(|dir| dir.sync_all());
        Ok(names)
    }
}

/// True where both paths lead to one existing file, whatever links are in between.
fn same_file(a: &Path, b: &Path) -> bool {
    let found = |path: &Path| fs::canonicalize(path).ok();
    if let (Some(real_a), Some(real_b)) = (found(a), found(b)) {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            if let (Ok(a), Ok(b)) = (fs::metadata(&real_a), fs::metadata(&real_b)) {
                return (a.dev(), a.ino()) == (b.dev(), b.ino());
            }
        }
        return real_a == real_b;
    }
    false
}

/// Copies of some files of a directory in another, which is made where it is absent; all of them or none.
///
/// # Errors
/// A file cannot be read or written.
pub fn copy_files(from: &Path, names: &[&str], into: &Path) -> Result<(), Error> {
    let mut output = Output::create(into)?;
    for name in names {
        let path = from.join(name);
        let mut source = File::open(&path).map_err(|e| Error::read(&path, e.to_string()))?;
        output.stage(name, |file| {
            let copied = io::copy(&mut source, file);
            copied.map_err(|e| Error::write(Path::new(""), e)).map(drop)
        })?;
    }
    output.publish().map(drop)
}
