//! The output directory: files are staged under temporary names and published together.

use crate::Error;
use crate::lock::Lock;
use crate::regular::{hash_of, hash_own};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
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

/// A folder of temporary files inside an output directory, locked for as long as its process lives: one that is there
/// and not locked, a killed run left.
#[derive(Debug)]
struct Staging {
    folder: TempDir,
    _lock: Lock,
}

/// How names of such folders begin.
const STAGING: &str = ".ambake-staged-";

/// How often a folder is made that other runs take away. Each of those that start or fail at this very moment may do so
/// once.
const TRIES: usize = 10_000;

impl Staging {
    /// A new one in `dir`; [`ErrorKind::NotFound`] where `dir` went, or where another run took the new one for a
    /// leftover before it was locked.
    fn make(dir: &Path) -> io::Result<Self> {
        let folder = tempfile::Builder::new().prefix(STAGING).tempdir_in(dir)?;
        let lock = Lock::of(&File::open(folder.path())?)?;
        match lock {
            Some(_lock) if folder.path().is_dir() => Ok(Self { folder, _lock }),
            _ => Err(ErrorKind::NotFound.into()),
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

/// The directories that an output made, the innermost first. Those that hold nothing when this is dropped go again: a
/// job that may fail keeps it until its end.
#[derive(Debug, Default)]
pub struct Folder(Vec<PathBuf>);

impl Folder {
    /// Makes `dir` and its parents.
    fn make(&mut self, dir: &Path) -> io::Result<()> {
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

/// A new temporary file in `dir`, with the permissions any new file gets.
fn temporary(dir: &Path) -> io::Result<NamedTempFile> {
    #[cfg_attr(not(unix), allow(unused_mut, reason = "permissions are those of Unix"))]
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
        let full = |_: &mut File| Err(Error::write(Path::new(""), ErrorKind::StorageFull.into()));
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

    #[cfg(unix)]
    #[test]
    fn only_what_still_has_the_content_of_the_earlier_set_goes_with_it() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("out");
        fs::create_dir_all(folder.join("sub")).unwrap();
        for name in ["old", "edited", "input", "kept", "sub/old", "../old"] {
            fs::write(folder.join(name), b"one").unwrap();
        }
        std::os::unix::fs::symlink("input", folder.join("link")).unwrap();
        fs::write(folder.join("edited"), b"two").unwrap();
        let hash = blake3::hash(b"one").to_hex().to_string();
        let listed = [
            "old", "edited", "input", "kept", "sub/old", "../old", "link", "gone", "sub",
        ];
        let mut out = Output::create(&folder).unwrap();
        out.protect([folder.join("input")]);
        out.supersede(listed.map(|name| (name.to_owned(), hash.clone())));
        out.stage_bytes("kept", b"one").unwrap();
        assert_eq!(out.listed(), [("kept".to_owned(), hash)]);
        out.publish().unwrap();
        assert_eq!(names(&folder), ["edited", "input", "kept", "link", "sub"]);
        assert_eq!(names(&folder.join("sub")), ["old"]);
        assert_eq!(names(dir.path()), ["old", "out"]);
    }

    /// Runs `job` for each of `count` numbers at the same moment.
    fn at_once(count: usize, job: impl Fn(usize) + Sync) {
        let start = std::sync::Barrier::new(count);
        std::thread::scope(|scope| {
            for number in 0..count {
                let (start, job) = (&start, &job);
                scope.spawn(move || {
                    start.wait();
                    job(number);
                });
            }
        });
    }

    #[cfg(unix)]
    #[test]
    fn outputs_that_begin_at_once_in_an_absent_folder_take_nothing_from_each_other() {
        let dir = tempfile::tempdir().unwrap();
        for round in 0..20 {
            let folder = dir.path().join(format!("{round}/a/b"));
            at_once(32, |number| {
                // Some end at once, with all that they made.
                let mut out = Output::create(&folder).unwrap();
                if number % 2 == 1 {
                    out.stage_bytes(&number.to_string(), b"one").unwrap();
                    out.publish().unwrap();
                }
            });
            assert_eq!(names(&folder).len(), 16, "{:?}", names(&folder));
        }
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
