//! The state of an interrupted bake: one file a page in the output directory, removed when the bake is done.
//!
//! Layout: the line `ambake-resume 2`, a line of JSON (key, state, the length of each plane), then the planes as
//! little-endian f32. The key names everything that decides the values; a file with another key is not used.

use crate::Error;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

const MAGIC: &str = "ambake-resume 2";

/// One page's state.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint {
    /// Everything that decides the values of the bake.
    pub key: Value,
    /// The baker's counters.
    pub state: Value,
    /// All planes.
    pub planes: Vec<Vec<f32>>,
}

#[derive(Serialize, Deserialize)]
struct Header {
    key: Value,
    state: Value,
    /// Values of each plane.
    lengths: Vec<usize>,
}

/// Where the state of a page of `stem` lies in `dir`.
pub fn checkpoint_path(dir: &Path, stem: &str, page: u32) -> PathBuf {
    dir.join(format!(".{stem}.{page}.ambake-resume"))
}

/// Writes a page's state, under a temporary name first.
///
/// # Errors
/// [`Error::Write`].
pub fn write_checkpoint(path: &Path, checkpoint: &Checkpoint) -> Result<(), Error> {
    let fail = |source| Error::write(path, source);
    let dir = path.parent().unwrap_or(Path::new("."));
    let mut file = NamedTempFile::new_in(dir).map_err(fail)?;
    let header = Header {
        key: checkpoint.key.clone(),
        state: checkpoint.state.clone(),
        lengths: checkpoint.planes.iter().map(Vec::len).collect(),
    };
    let header = serde_json::to_string(&header).map_err(|e| fail(e.into()))?;
    writeln!(file, "{MAGIC}\n{header}").map_err(fail)?;
    for plane in &checkpoint.planes {
        let bytes: Vec<u8> = plane.iter().flat_map(|v| v.to_le_bytes()).collect();
        file.write_all(&bytes).map_err(fail)?;
    }
    file.as_file().sync_all().map_err(fail)?;
    file.persist(path).map_err(|e| fail(e.error))?;
    Ok(())
}

/// Reads a page's state; `None` where there is no file, or one of another bake (another key).
///
/// # Errors
/// [`Error::Read`] for a file that is damaged.
pub fn read_checkpoint(path: &Path, key: &Value) -> Result<Option<Checkpoint>, Error> {
    let damaged = |reason: String| {
        Error::read(
            path,
            format!("{reason}; delete it, or bake without --resume"),
        )
    };
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(damaged(error.to_string())),
    };
    let bytes = file.metadata().map_or(0, |m| m.len());
    let mut reader = BufReader::new(file);
    let mut line = || {
        let mut text = String::new();
        (&mut reader)
            .take(1 << 20)
            .read_line(&mut text)
            .map(|_| text)
            .map_err(|e| damaged(e.to_string()))
    };
    if line()?.trim_end() != MAGIC {
        return Err(damaged("not the state of an interrupted bake".into()));
    }
    let header: Header = serde_json::from_str(&line()?).map_err(|e| damaged(e.to_string()))?;
    if header.key != *key {
        return Ok(None);
    }
    let wanted = header
        .lengths
        .iter()
        .fold(0u64, |sum, &length| sum.saturating_add(length as u64));
    if wanted.saturating_mul(4) > bytes {
        return Err(damaged("the file is truncated".into()));
    }
    let mut planes = Vec::with_capacity(header.lengths.len());
    for length in header.lengths {
        let mut raw = vec![0u8; length * 4];
        reader
            .read_exact(&mut raw)
            .map_err(|_| damaged("the file is truncated".into()))?;
        planes.push(
            raw.as_chunks::<4>()
                .0
                .iter()
                .map(|b| f32::from_le_bytes(*b))
                .collect(),
        );
    }
    Ok(Some(Checkpoint {
        key: header.key,
        state: header.state,
        planes,
    }))
}

/// Removes a page's state where there is one.
pub fn remove_checkpoint(path: &Path) {
    // A file that cannot be removed is harmless: the next `--resume` checks its key.
    let _ = std::fs::remove_file(path);
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn state_returns_for_its_own_key_only() {
        let dir = tempfile::tempdir().unwrap();
        let path = checkpoint_path(dir.path(), "room", 0);
        let state = Checkpoint {
            key: json!({"seed": 1}),
            state: json!(7),
            planes: vec![vec![0.5, -1.0], vec![2.0, 3.0, 4.0]],
        };
        assert_eq!(read_checkpoint(&path, &state.key).unwrap(), None);
        write_checkpoint(&path, &state).unwrap();
        assert_eq!(
            read_checkpoint(&path, &state.key).unwrap(),
            Some(state.clone())
        );
        assert_eq!(read_checkpoint(&path, &json!({"seed": 2})).unwrap(), None);
        let bytes = std::fs::read(&path).unwrap();
        for cut in [0, 5, 20, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..cut]).unwrap();
            let error = read_checkpoint(&path, &state.key).unwrap_err().to_string();
            assert!(error.contains("delete it"), "{error}");
        }
    }

    #[test]
    fn numbers_of_key_and_state_return_bit_for_bit() {
        let dir = tempfile::tempdir().unwrap();
        let path = checkpoint_path(dir.path(), "room", 0);
        let numbers: Vec<f64> = (1..20_000u64)
            .map(|i| f64::from_bits(i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 2))
            .filter(|v| v.is_finite())
            .collect();
        let state = Checkpoint {
            key: json!(numbers),
            state: json!(numbers),
            planes: vec![vec![f32::MIN_POSITIVE]],
        };
        write_checkpoint(&path, &state).unwrap();
        assert!(read_checkpoint(&path, &state.key).unwrap() == Some(state));
    }

    #[test]
    fn a_header_that_promises_more_than_the_file_holds_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = checkpoint_path(dir.path(), "room", 0);
        let header = r#"{"key":1,"state":2,"lengths":[4611686018427387904,4611686018427387904]}"#;
        std::fs::write(&path, format!("{MAGIC}\n{header}\n")).unwrap();
        let error = read_checkpoint(&path, &json!(1)).unwrap_err().to_string();
        assert!(error.contains("truncated"), "{error}");
    }
}
