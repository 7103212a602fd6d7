//! What a bake has done so far, as a file that grows: kept while a bake runs, left by an interrupted one, and what a
//! shard hands to `ambake merge`.
//!
//! Layout: the line `ambake-part 2`; a line of JSON, the header; the blake3 hash of both lines in hex and a line
//! feed; then blocks. A block is its length in bytes as a little-endian u64, the bytes, and the blake3 hash (32
//! bytes) over its number from 0 as a little-endian u64 and the bytes. A file that ends within a block was cut short
//! by a crash: its whole blocks count. A hash that does not fit is damage.

use crate::lock::Lock;
use crate::regular::{check_own, open_own};
use crate::{Error, check_regular};
use serde_json::Value;
use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

const MAGIC: &str = "ambake-part 2\n";
/// Longest header in bytes.
const MAX_HEADER: u64 = 1 << 24;
/// Bytes of a hash.
const HASH: usize = blake3::OUT_LEN;

/// A file of checksummed blocks, open for reading and perhaps for more blocks.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    header: Value,
    /// Where each block's bytes begin, and how many there are.
    blocks: Vec<(u64, u64)>,
    /// Where the next block goes.
    end: u64,
    /// Held against other writers.
    _lock: Option<Lock>,
}

impl Journal {
    /// The journal at `path`, held against other writers. Its blocks are kept where `fits` holds for its header; else,
    /// and where it is absent, it starts anew with `header`. The second value tells of damage, for which it was started
    /// anew.
    ///
    /// # Errors
    /// The file cannot be written, a link or anything else than a regular file has its place, or another process writes
    /// it.
    pub fn resume(
        path: &Path,
        header: &Value,
        fits: impl Fn(&Value) -> bool,
    ) -> Result<(Self, Option<String>), Error> {
        let fail = |source| Error::write(path, source);
        match check_own(path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(Error::read(path, format!("{error}; remove it")));
            }
            _ => {}
        }
        let file = open_own(path).map_err(fail)?;
        let Some(lock) = Lock::of(&file).map_err(fail)? else {
            let reason = "another run is writing it; wait for that run, or stop it";
            return Err(Error::read(path, reason));
        };
        let empty = file.metadata().map_err(fail)?.len() == 0;
        let (found, damage) = match scan(path, &file) {
            _ if empty => (None, None),
            Ok(found) => (Some(found), None),
            Err(error) => (None, Some(error.to_string())),
        };
        let mut journal = Self {
            path: path.to_owned(),
            file,
            header: header.clone(),
            blocks: Vec::new(),
            end: 0,
            _lock: Some(lock),
        };
        match found.filter(|found| fits(&found.header)) {
            Some(found) => {
                (journal.blocks, journal.end) = (found.blocks, found.end);
                journal.header = found.header;
                journal.file.set_len(found.end).map_err(fail)?;
            }
            None => journal.begin().map_err(fail)?,
        }
        Ok((journal, damage))
    }

    /// The journal at `path`, to be read; `None` where there is no such file.
    ///
    /// # Errors
    /// [`Error::Read`] where it is damaged.
    pub fn open(path: &Path) -> Result<Option<Self>, Error> {
        let file = match check_regular(path).and_then(|()| File::open(path)) {
            Ok(file) => file,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(Error::read(path, error.to_string())),
        };
        let found = scan(path, &file)?;
        Ok(Some(Self {
            path: path.to_owned(),
            file,
            header: found.header,
            blocks: found.blocks,
            end: found.end,
            _lock: None,
        }))
    }

    /// What the journal says of itself.
    pub fn header(&self) -> &Value {
        &self.header
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// True without any block.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// The bytes of a block, which are checked again.
    ///
    /// # Errors
    /// [`Error::Read`].
    ///
    /// # Panics
    /// Where there is no such block.
    pub fn block(&mut self, number: usize) -> Result<Vec<u8>, Error> {
        let (start, length) = self.blocks[number];
        let mut bytes = vec![0; length as usize];
        let mut hash = [0; HASH];
        let mut read = || {
            self.file.seek(SeekFrom::Start(start))?;
            self.file.read_exact(&mut bytes)?;
            self.file.read_exact(&mut hash)
        };
        read().map_err(|e| Error::read(&self.path, e.to_string()))?;
        match hash_of(number, &bytes) == hash {
            true => Ok(bytes),
            false => Err(damaged(&self.path, "a block does not fit its checksum")),
        }
    }

    /// The first four bytes of a block, as a little-endian number; `None` for a shorter one.
    ///
    /// # Errors
    /// [`Error::Read`].
    ///
    /// # Panics
    /// Where there is no such block.
    pub fn tag(&mut self, number: usize) -> Result<Option<u32>, Error> {
        let (start, length) = self.blocks[number];
        if length < 4 {
            return Ok(None);
        }
        let mut bytes = [0; 4];
        let mut read = || {
            self.file.seek(SeekFrom::Start(start))?;
            self.file.read_exact(&mut bytes)
        };
        read().map_err(|e| Error::read(&self.path, e.to_string()))?;
        Ok(Some(u32::from_le_bytes(bytes)))
    }

    /// Adds a block, which is on the disk when the call returns.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn append(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let length = bytes.len() as u64;
        let mut write = || {
            self.file.seek(SeekFrom::Start(self.end))?;
            self.file.write_all(&length.to_le_bytes())?;
            self.file.write_all(bytes)?;
            self.file.write_all(&hash_of(self.blocks.len(), bytes))?;
            self.file.sync_data()
        };
        write().map_err(|e| Error::write(&self.path, e))?;
        self.blocks.push((self.end + 8, length));
        self.end += 8 + length + HASH as u64;
        Ok(())
    }

    /// Gives the file another name in the same directory.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn rename(&mut self, path: &Path) -> Result<(), Error> {
        std::fs::rename(&self.path, path).map_err(|e| Error::write(path, e))?;
        path.clone_into(&mut self.path);
        sync_directory(path);
        Ok(())
    }

    /// Writes the header of an empty journal.
    fn begin(&mut self) -> io::Result<()> {
        self.file.set_len(0)?;
        self.file.seek(SeekFrom::Start(0))?;
        let text = format!("{MAGIC}{}\n", self.header);
        let hash = blake3::hash(text.as_bytes()).to_hex();
        let text = format!("{text}{hash}\n");
        self.file.write_all(text.as_bytes())?;
        self.file.sync_all()?;
        sync_directory(&self.path);
        (self.blocks, self.end) = (Vec::new(), text.len() as u64);
        Ok(())
    }
}

/// Writes a whole journal into an empty file, which whoever stages it brings to the disk.
///
/// # Errors
/// [`Error::Write`] without a path.
pub fn write_journal(
    file: &mut File,
    header: &Value,
    blocks: impl IntoIterator<Item = Vec<u8>>,
) -> Result<(), Error> {
    let mut writer = JournalWriter::new(file, header)?;
    for block in blocks {
        writer.block(&block)?;
    }
    writer.finish()
}

/// A journal that is written block by block into an empty file, which whoever stages it brings to the disk. All errors
/// are [`Error::Write`] without a path.
#[derive(Debug)]
pub struct JournalWriter<'a> {
    file: BufWriter<&'a mut File>,
    blocks: usize,
}

impl<'a> JournalWriter<'a> {
    /// Writes the header.
    ///
    /// # Errors
    /// See above.
    pub fn new(file: &'a mut File, header: &Value) -> Result<Self, Error> {
        let mut file = BufWriter::new(file);
        let text = format!("{MAGIC}{header}\n");
        let hash = blake3::hash(text.as_bytes()).to_hex();
        let written = file.write_all(format!("{text}{hash}\n").as_bytes());
        written.map_err(unplaced)?;
        Ok(Self { file, blocks: 0 })
    }

    /// Writes one more block.
    ///
    /// # Errors
    /// See above.
    pub fn block(&mut self, block: &[u8]) -> Result<(), Error> {
        let mut write = || {
            self.file.write_all(&(block.len() as u64).to_le_bytes())?;
            self.file.write_all(block)?;
            self.file.write_all(&hash_of(self.blocks, block))
        };
        write().map_err(unplaced)?;
        self.blocks += 1;
        Ok(())
    }

    /// Hands the last bytes to the system.
    ///
    /// # Errors
    /// See above.
    pub fn finish(mut self) -> Result<(), Error> {
        self.file.flush().map_err(unplaced)
    }
}

fn unplaced(error: io::Error) -> Error {
    Error::write(Path::new(""), error)
}

/// Removes a journal where there is one. One that cannot be removed is harmless: its header is checked before it is
/// used.
pub fn remove_journal(path: &Path) {
    let _ = std::fs::remove_file(path);
}

/// What a scan of a journal finds.
struct Found {
    header: Value,
    blocks: Vec<(u64, u64)>,
    end: u64,
}

/// Reads a journal from its beginning and checks every hash.
fn scan(path: &Path, file: &File) -> Result<Found, Error> {
    let failed = |error: io::Error| Error::read(path, error.to_string());
    let size = file.metadata().map_err(failed)?.len();
    let mut reader = BufReader::with_capacity(1 << 16, file);
    let mut line = || {
        let mut bytes = Vec::new();
        let mut limited = (&mut reader).take(MAX_HEADER);
        let read = limited.read_until(b'\n', &mut bytes);
        read.map(|_| bytes).map_err(failed)
    };
    let (magic, text, hash) = (line()?, line()?, line()?);
    if magic != MAGIC.as_bytes() {
        return Err(damaged(path, "it is not the state of a bake"));
    }
    let wanted = blake3::hash(&[magic.as_slice(), &text].concat()).to_hex();
    if hash.trim_ascii_end() != wanted.as_bytes() {
        return Err(damaged(path, "its header does not fit its checksum"));
    }
    let header = serde_json::from_slice(&text).map_err(|e| damaged(path, &e.to_string()))?;
    let mut end = (magic.len() + text.len() + hash.len()) as u64;
    let mut blocks = Vec::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        let mut length = [0; 8];
        if size.saturating_sub(end) < 8 + HASH as u64 {
            break;
        }
        reader.read_exact(&mut length).map_err(failed)?;
        let length = u64::from_le_bytes(length);
        if length > size - end - 8 - HASH as u64 {
            break;
        }
        let mut hasher = hasher_of(blocks.len());
        let mut left = length;
        while left > 0 {
            let some = &mut buffer[..left.min(1 << 16) as usize];
            reader.read_exact(some).map_err(failed)?;
            hasher.update(some);
            left -= some.len() as u64;
        }
        let mut hash = [0; HASH];
        reader.read_exact(&mut hash).map_err(failed)?;
        if *hasher.finalize().as_bytes() != hash {
            return Err(damaged(path, "a block does not fit its checksum"));
        }
        blocks.push((end + 8, length));
        end += 8 + length + HASH as u64;
    }
    Ok(Found {
        header,
        blocks,
        end,
    })
}

fn damaged(path: &Path, reason: &str) -> Error {
    Error::read(path, format!("{reason}: the file is damaged"))
}

fn hasher_of(number: usize) -> blake3::Hasher {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(number as u64).to_le_bytes());
    hasher
}

fn hash_of(number: usize, bytes: &[u8]) -> [u8; HASH] {
    *hasher_of(number).update(bytes).finalize().as_bytes()
}

/// Brings the name of a file to the disk; a file system that cannot do so still has it.
fn sync_directory(path: &Path) {
    let dir = path.parent().filter(|dir| !dir.as_os_str().is_empty());
    let _ = File::open(dir.unwrap_or(Path::new("."))).and_then(|dir| dir.sync_all());
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// A journal of three blocks, closed.
    fn written(path: &Path, header: &Value) -> Vec<u8> {
        let (mut journal, damage) = Journal::resume(path, header, |_| true).unwrap();
        assert_eq!(damage, None);
        for block in [b"one".as_slice(), b"", b"three"] {
            journal.append(block).unwrap();
        }
        std::fs::read(path).unwrap()
    }

    #[test]
    fn blocks_return_for_a_header_that_fits_only() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state");
        assert!(Journal::open(&path).unwrap().is_none());
        let header = json!({"seed": 1, "numbers": [0.1, 1e300]});
        written(&path, &header);
        let mut journal = Journal::open(&path).unwrap().unwrap();
        assert_eq!((journal.header(), journal.len()), (&header, 3));
        assert_eq!(journal.block(2).unwrap(), b"three");
        assert_eq!(journal.block(1).unwrap(), b"");
        drop(journal);
        let (journal, _) = Journal::resume(&path, &header, |found| *found == header).unwrap();
        assert_eq!(journal.len(), 3);
        drop(journal);
        let other = json!({"seed": 2});
        let (journal, damage) = Journal::resume(&path, &other, |found| *found == other).unwrap();
        assert!(journal.is_empty() && damage.is_none());
        drop(journal);
        assert_eq!(*Journal::open(&path).unwrap().unwrap().header(), other);
    }

    #[test]
    fn a_journal_that_is_closed_is_free_whoever_has_a_copy_of_the_handle() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state");
        let (journal, _) = Journal::resume(&path, &json!(1), |_| true).unwrap();
        assert!(Journal::resume(&path, &json!(1), |_| true).is_err());
        // A child process has such a copy between its fork and its own program.
        let copy = journal.file.try_clone().unwrap();
        drop(journal);
        assert!(Journal::resume(&path, &json!(1), |_| true).is_ok());
        drop(copy);
    }

    #[test]
    fn a_torn_tail_costs_its_own_block_alone() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state");
        let header = json!(7);
        let bytes = written(&path, &header);
        for cut in 1..8 + 5 + HASH {
            std::fs::write(&path, &bytes[..bytes.len() - cut]).unwrap();
            let (mut journal, damage) = Journal::resume(&path, &header, |_| true).unwrap();
            assert_eq!((journal.len(), damage), (2, None), "{cut}");
            assert!(!journal.is_empty());
            journal.append(b"three").unwrap();
            assert!(std::fs::read(&path).unwrap() == bytes, "{cut}");
        }
    }

    #[test]
    fn of_a_long_torn_tail_nothing_is_left_behind_a_shorter_block() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state");
        let (mut journal, _) = Journal::resume(&path, &json!(1), |_| true).unwrap();
        journal.append(&[0; 1000]).unwrap();
        drop(journal);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
        let (mut journal, damage) = Journal::resume(&path, &json!(1), |_| true).unwrap();
        assert_eq!((journal.len(), damage), (0, None));
        journal.append(b"short").unwrap();
        drop(journal);
        let journal = Journal::open(&path).unwrap();
        assert_eq!(journal.expect("it is there").len(), 1);
    }

    #[test]
    fn a_block_that_changed_since_it_was_found_is_not_handed_out() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state");
        let mut bytes = written(&path, &json!(1));
        let mut journal = Journal::open(&path).unwrap().unwrap();
        let last = bytes.len() - HASH - 1;
        bytes[last] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        let error = journal.block(2).unwrap_err().to_string();
        assert!(error.contains("does not fit its checksum"), "{error}");
        assert_eq!(journal.block(0).unwrap(), b"one");
    }

    #[test]
    fn flipped_bits_are_found() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state");
        let header = json!({"seed": 1});
        let bytes = written(&path, &header);
        for at in (0..bytes.len()).step_by(3) {
            let mut bad = bytes.clone();
            bad[at] ^= 4;
            std::fs::write(&path, &bad).unwrap();
            // A length that grew looks like a torn tail: the block is lost, and nothing wrong is read.
            if let Ok(Some(journal)) = Journal::open(&path) {
                assert!(journal.len() < 3, "byte {at}");
                continue;
            }
            let (journal, damage) = Journal::resume(&path, &header, |_| true).unwrap();
            let damage = damage.unwrap_or_else(|| panic!("byte {at} is not told of"));
            assert!(journal.is_empty(), "byte {at}");
            assert!(
                damage.contains("damaged") && !damage.contains('\n'),
                "{damage}"
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_journal_is_not_written_through_a_link() {
        let dir = tempfile::tempdir().unwrap();
        let [real, link] = ["real", "link"].map(|name| dir.path().join(name));
        let bytes = written(&real, &json!(1));
        std::os::unix::fs::symlink("real", &link).unwrap();
        for fits in [true, false] {
            let error = Journal::resume(&link, &json!(2), |_| fits).unwrap_err();
            let line = error.to_string();
            let said = "link: it is a symbolic link; remove it";
            assert!(line.ends_with(said), "{line}");
        }
        assert!(std::fs::read(&real).unwrap() == bytes);
        // To read through one harms nothing.
        let mut journal = Journal::open(&link).unwrap().unwrap();
        assert_eq!(journal.len(), 3);
        // Another name is given to the link, and it is the link that goes.
        journal.rename(&dir.path().join("other")).unwrap();
        remove_journal(journal.path());
        assert!(std::fs::read(&real).unwrap() == bytes);
    }

    #[test]
    fn two_writers_do_not_share_a_journal() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state");
        let (_first, _) = Journal::resume(&path, &json!(1), |_| true).unwrap();
        let error = Journal::resume(&path, &json!(1), |_| true).unwrap_err();
        assert!(error.to_string().contains("another run"), "{error}");
    }
}
