//! What a bake has done so far, as a file that grows: kept while a bake runs, left by an interrupted one, and what a
//! shard hands to `ambake merge`.
//!
//! Layout: the line `ambake-part 2`; a line of JSON, the header; the blake3 hash of both lines in hex and a line
//! feed; then blocks. A block is its length in bytes as a little-endian u64, the bytes, and the blake3 hash (32
//! bytes) over its number from 0 as a little-endian u64 and the bytes. A file that ends within a block was cut short
//! by a crash: its whole blocks count. A hash that does not fit is damage.

mod scan;
#[cfg(test)]
mod tests;
mod writer;

use crate::lock::Lock;
use crate::regular::{check_own, open_own};
use crate::{Error, check_regular};
use scan::{HASH, MAGIC, damaged, hash_of, scan};
use serde_json::Value;
use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
pub use writer::{JournalWriter, write_journal};

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

/// Removes a journal where there is one. One that cannot be removed is harmless: its header is checked before it is
/// used.
pub fn remove_journal(path: &Path) {
    let _ = std::fs::remove_file(path);
}

/// Brings the name of a file to the disk; a file system that cannot do so still has it.
fn sync_directory(path: &Path) {
    let dir = path.parent().filter(|dir| !dir.as_os_str().is_empty());
    let _ = File::open(dir.unwrap_or(Path::new("."))).and_then(|dir| dir.sync_all());
}
