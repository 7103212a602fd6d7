//! The output directory: files are staged under temporary names and published together.

use crate::Error;
use crate::lock::Lock;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::{NamedTempFile, TempDir, TempPath};

/// An output directory with a set of staged files.
///
/// Nothing stands under a final name until [`Output::publish`]. Dropping the set removes what was staged and leaves
/// earlier output untouched, and removes directories that it made and that hold nothing.
#[derive(Debug)]
pub struct Output {
    dir: PathBuf,
    /// Files that no output may replace.
    inputs: Vec<PathBuf>,
    staged: Vec<(TempPath, PathBuf)>,
    /// Where files wait for their names.
    staging: Staging,
    /// Held for as long as nobody else may bake into `dir`.
    _lock: Option<Lock>,
    /// Dropped last, when nothing staged is left.
    _made: Made,
}

/// A folder of temporary files inside an output directory, locked for as long as its process lives: one that is there and not locked, a
/// killed run left.
#[derive(Debug)]
struct Staging {
    folder: TempDir,
    _lock: Lock,
}

/// How names of such folders begin.
const STAGING: &str = ".ambake-staged-";

impl Staging {
    /// A new one in `dir`.
    fn make(dir: &Path) -> io::Result<Self> {
        loop {
            let folder = tempfile::Builder::new().prefix(STAGING).tempdir_in(dir)?;
            // Another run may take it for a leftover before it is locked, and remove it.
            let lock = Lock::of(&File::open(folder.path())?)?;
            match lock {
                Some(_lock) if folder.path().is_dir() => return Ok(Self { folder, _lock }),
                _ => {}
            }
        }
    }

    /// Removes those that killed runs left in `dir`.
    fn sweep(dir: &Path) {
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

/// Directories that an output made, the innermost first; those that are empty in the end go again.
#[derive(Debug)]
struct Made(Vec<PathBuf>);

impl Made {
    /// Makes `dir` and its parents.
    fn make(dir: &Path) -> io::Result<Self> {
        let absent = |dir: &&Path| !dir.as_os_str().is_empty() && !dir.exists();
        let absent = dir.ancestors().take_while(absent).map(Path::to_owned);
        let made = Self(absent.collect());
        fs::create_dir_all(dir)?;
        Ok(made)
    }
}

impl Drop for Made {
    fn drop(&mut self) {
        for dir in &self.0 {
            // One that holds something stays.
            if fs::remove_dir(dir).is_err() {
                return;
            }
        }
    }
}

impl Output {
    /// An empty set in `dir`, which is made with its parents where it is absent and is proved writable. Temporary files that a killed run
    /// left there are removed.
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
        let made = Made::make(dir).map_err(|e| fail(e.to_string()))?;
        Staging::sweep(dir);
        let staging = Staging::make(dir).map_err(|e| fail(e.to_string()))?;
        Ok(Output {
            dir: dir.to_owned(),
            inputs: Vec::new(),
            staged: Vec::new(),
            staging,
            _lock: None,
            _made: made,
        })
    }

    /// As [`Output::create`], for one job alone: a second one in `dir` is refused until this one is dropped or its process ends.
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

/// Files that an earlier `bake.json` in `dir` lists and that are not among `names`: leftovers of an earlier bake. Only files directly in `dir`
/// count; without a readable `bake.json` there are none.
pub fn stale_files(dir: &Path, names: &[String]) -> Vec<PathBuf> {
    let Ok(earlier) = crate::read_bake_report(&dir.join("bake.json")) else {
        return Vec::new();
    };
    let plain = |name: &String| Path::new(name).file_name() == Some(name.as_ref());
    let stale = earlier
        .files
        .iter()
        .filter(|name| plain(name) && !names.contains(name));
    stale.map(|name| dir.join(name)).collect()
}

/// Removes leftovers of an earlier bake. One that cannot be removed stays; it is not listed any more.
pub fn remove_stale(files: &[PathBuf]) {
    for file in files {
        let _ = fs::remove_file(file);
    }
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

/// A new temporary file in `dir`, with the permissions any new file gets.
fn temporary(dir: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
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

    #[cfg(unix)]
    #[test]
    fn a_second_job_is_refused_and_leftovers_of_a_killed_one_go() {
        let dir = tempfile::tempdir().unwrap();
        let mut first = Output::exclusive(dir.path()).unwrap();
        let error = Output::exclusive(dir.path()).unwrap_err().to_string();
        assert!(
            error.contains("another bake") && error.contains("-o"),
            "{error}"
        );
        // A verb that adds a file beside the bake is no second bake.
        let mut picture = Output::create(dir.path()).unwrap();
        picture.stage_bytes("lit.png", b"one").unwrap();
        first.stage_bytes("x.png", b"one").unwrap();
        // As if the process were killed: the files stay, the locks go.
        let killed = dir.path().join(".ambake-staged-killed");
        fs::create_dir(&killed).unwrap();
        fs::write(killed.join("x"), b"half").unwrap();
        drop(first);
        assert_eq!(names(dir.path()).len(), 2, "{:?}", names(dir.path()));
        // Whoever writes there next removes what was left, and nothing that somebody still writes.
        let second = Output::create(dir.path()).unwrap();
        assert!(!killed.exists());
        drop(second);
        picture.publish().unwrap();
        assert_eq!(names(dir.path()), ["lit.png"]);
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
    fn directories_that_were_made_for_nothing_go_again() {
        let dir = tempfile::tempdir().unwrap();
        let inner = dir.path().join("a/b");
        drop(Output::create(&inner).unwrap());
        assert!(names(dir.path()).is_empty());
        let mut out = Output::exclusive(&inner).unwrap();
        out.stage_bytes("x.png", b"new").unwrap();
        out.publish().unwrap();
        assert_eq!(names(&inner), ["x.png"]);
        fs::create_dir(dir.path().join("mine")).unwrap();
        drop(Output::create(&dir.path().join("mine")).unwrap());
        assert_eq!(names(dir.path()), ["a", "mine"]);
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

    #[test]
    fn an_input_is_never_replaced_under_any_of_its_names() {
        let dir = tempfile::tempdir().unwrap();
        let input = dir.path().join("scene.glb");
        fs::write(&input, b"mine").unwrap();
        let mut out = Output::create(dir.path()).unwrap();
        out.protect([dir.path().join("./scene.glb")]);
        let error = out
            .stage_bytes("scene.glb", b"new")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("scene.glb") && error.contains("-o"),
            "{error}"
        );
        #[cfg(unix)]
        {
            let folder = dir.path().join("linked");
            fs::create_dir(&folder).unwrap();
            fs::hard_link(&input, folder.join("copy.glb")).unwrap();
            std::os::unix::fs::symlink(&input, folder.join("link.glb")).unwrap();
            let mut out = Output::create(&folder).unwrap();
            out.protect([input.clone()]);
            assert!(out.check("copy.glb").is_err() && out.check("link.glb").is_err());
        }
        out.stage_bytes("other.glb", b"new").unwrap();
        out.publish().unwrap();
        assert_eq!(fs::read(&input).unwrap(), b"mine");
    }

    #[test]
    fn leftovers_are_what_an_earlier_report_lists_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        assert!(stale_files(dir.path(), &[]).is_empty());
        let files = ["a.0.exr", "a.1.exr", "../outside", "bake.json"].map(String::from);
        let mut report = crate::bake_json::tests::report();
        report.files = files.to_vec();
        fs::write(dir.path().join("bake.json"), report.to_json()).unwrap();
        let kept = ["a.0.exr".to_owned(), "bake.json".to_owned()];
        assert_eq!(stale_files(dir.path(), &kept), [dir.path().join("a.1.exr")]);
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
