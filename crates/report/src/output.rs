//! The output directory: files are staged under temporary names and published together.

use crate::Error;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};

/// An output directory with a set of staged files.
///
/// Nothing stands under a final name until [`Output::publish`]. Dropping the set removes what was staged and leaves
/// earlier output untouched.
#[derive(Debug)]
pub struct Output {
    dir: PathBuf,
    staged: Vec<(TempPath, PathBuf)>,
}

impl Output {
    /// An empty set in `dir`, which is made with its parents where it is absent and is proved writable.
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
        fs::create_dir_all(dir).map_err(|e| fail(e.to_string()))?;
        temporary(dir).map_err(|e| fail(e.to_string()))?;
        Ok(Output {
            dir: dir.to_owned(),
            staged: Vec::new(),
        })
    }

    /// The directory.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Stages one file called `name`: `write` fills it, then it is flushed to the disk under a temporary name.
    ///
    /// An error of `write` whose path is empty is given the file's final name.
    ///
    /// # Errors
    /// What `write` returns, or [`Error::Write`].
    pub fn stage(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut File) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let path = self.dir.join(name);
        let mut file = temporary(&self.dir).map_err(|e| Error::write(&path, e))?;
        write(file.as_file_mut()).map_err(|error| match error {
            Error::Write {
                path: empty,
                source,
            } if empty.as_os_str().is_empty() => Error::write(&path, source),
            other => other,
        })?;
        file.as_file()
            .sync_all()
            .map_err(|e| Error::write(&path, e))?;
        self.staged.push((file.into_temp_path(), path));
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

    /// Names of the staged files, in the order of staging.
    pub fn names(&self) -> Vec<String> {
        let name = |path: &PathBuf| path.file_name().map(|n| n.to_string_lossy().into_owned());
        self.staged
            .iter()
            .filter_map(|(_, path)| name(path))
            .collect()
    }

    /// Renames every staged file to its final name, in the order of staging (stage `bake.json` last), and returns the names.
    ///
    /// # Errors
    /// [`Error::Write`]. A name taken by a directory is found before the first rename.
    pub fn publish(self) -> Result<Vec<PathBuf>, Error> {
        if let Some((_, path)) = self.staged.iter().find(|(_, path)| path.is_dir()) {
            return Err(Error::write(path, io::ErrorKind::IsADirectory.into()));
        }
        let mut names = Vec::with_capacity(self.staged.len());
        for (temporary, path) in self.staged {
            temporary
                .persist(&path)
                .map_err(|e| Error::write(&path, e.error))?;
            names.push(path);
        }
        // The names themselves reach the disk with the directory; a file system that cannot sync one still has them.
        let _ = File::open(&self.dir).and_then(|dir| dir.sync_all());
        Ok(names)
    }
}

/// A new temporary file in `dir`, with the permissions any new file gets.
fn temporary(dir: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ambake-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(dir)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(dir: &Path) -> Vec<String> {
        let mut all: Vec<_> = fs::read_dir(dir)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        all.sort();
        all
    }

    #[test]
    fn files_appear_only_on_publish() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("a/b");
        let mut out = Output::create(&target).unwrap();
        out.stage_bytes("x.png", b"one").unwrap();
        out.stage_bytes("bake.json", b"{}").unwrap();
        assert!(!target.join("x.png").exists());
        assert_eq!(
            out.publish().unwrap(),
            [target.join("x.png"), target.join("bake.json")]
        );
        assert_eq!(names(&target), ["bake.json", "x.png"]);
    }

    #[test]
    fn a_failed_write_leaves_good_output_untouched() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("x.png"), b"good").unwrap();
        let mut out = Output::create(dir.path()).unwrap();
        out.stage_bytes("x.png", b"new").unwrap();
        let full = |_: &mut File| {
            Err(Error::write(
                Path::new(""),
                io::ErrorKind::StorageFull.into(),
            ))
        };
        let error = out.stage("y.png", full).unwrap_err().to_string();
        assert!(
            error.contains("y.png") && error.contains("free some space"),
            "{error}"
        );
        drop(out);
        assert_eq!(names(dir.path()), ["x.png"]);
        assert_eq!(fs::read(dir.path().join("x.png")).unwrap(), b"good");
    }

    #[test]
    fn a_file_in_place_of_the_directory_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out");
        fs::write(&path, b"").unwrap();
        for bad in [path.clone(), path.join("below")] {
            let error = Output::create(&bad).unwrap_err().to_string();
            assert!(
                error.contains(bad.to_str().unwrap()) && error.contains("-o"),
                "{error}"
            );
            assert!(!error.contains('\n'));
        }
    }

    #[test]
    fn a_directory_in_place_of_a_file_stops_the_whole_set() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("bake.json")).unwrap();
        let mut out = Output::create(dir.path()).unwrap();
        out.stage_bytes("x.png", b"one").unwrap();
        out.stage_bytes("bake.json", b"{}").unwrap();
        let error = out.publish().unwrap_err().to_string();
        assert!(error.contains("bake.json"), "{error}");
        assert_eq!(names(dir.path()), ["bake.json"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_reported_with_what_to_do() {
        let mut options = fs::OpenOptions::new();
        let mut full = options.write(true).open("/dev/full").unwrap();
        let error =
            Error::write(Path::new("out/x.exr"), full.write_all(b"x").unwrap_err()).to_string();
        assert!(
            error.contains("out/x.exr") && error.contains("free some space"),
            "{error}"
        );
    }
}
