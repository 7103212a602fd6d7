//! The bytes of a journal: what it begins with, its hashes, and a scan that checks them all.

use crate::Error;
use serde_json::Value;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

pub(super) const MAGIC: &str = "ambake-part 2\n";
/// Longest header in bytes.
const MAX_HEADER: u64 = 1 << 24;
/// Bytes of a hash.
pub(super) const HASH: usize = blake3::OUT_LEN;

/// What a scan of a journal finds.
pub(super) struct Found {
    pub header: Value,
    pub blocks: Vec<(u64, u64)>,
    pub end: u64,
}

/// Reads a journal from its beginning and checks every hash.
pub(super) fn scan(path: &Path, file: &File) -> Result<Found, Error> {
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

pub(super) fn damaged(path: &Path, reason: &str) -> Error {
    Error::read(path, format!("{reason}: the file is damaged"))
}

fn hasher_of(number: usize) -> blake3::Hasher {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(number as u64).to_le_bytes());
    hasher
}

pub(super) fn hash_of(number: usize, bytes: &[u8]) -> [u8; HASH] {
    *hasher_of(number).update(bytes).finalize().as_bytes()
}
