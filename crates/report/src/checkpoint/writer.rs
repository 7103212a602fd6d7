//! Journals that are written as a whole.

use super::scan::{MAGIC, hash_of};
use crate::Error;
use serde_json::Value;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

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
