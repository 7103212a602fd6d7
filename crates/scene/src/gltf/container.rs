//! The GLB container: a header, a JSON chunk, and an optional binary chunk.

use std::ops::Range;

/// Where the chunks of a GLB file lie.
pub(super) struct Chunks {
    /// The JSON text.
    pub json: Range<usize>,
    /// The content of the first buffer.
    pub bin: Option<Range<usize>>,
}

/// The JSON text and the binary chunk of a GLB file that starts with its magic. Chunks of other types are skipped, as
/// the specification asks.
///
/// # Errors
/// Place and sentence.
pub(super) fn chunks(bytes: &[u8]) -> Result<Chunks, (String, String)> {
    let short = |place: String, needed: usize| {
        let there = bytes.len();
        let problem = format!(
            "{needed} bytes are announced, {there} are there; the file is truncated, copy it again"
        );
        (place, problem)
    };
    let word = |at: usize| {
        bytes
            .get(at..at + 4)
            .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(short("GLB header".into(), 12));
    };
    if version != 2 {
        let problem = format!("GLB version {version} is not read; convert it to glTF 2.0 first");
        return Err(("GLB header".into(), problem));
    }
    let end = length as usize;
    if end > bytes.len() {
        return Err(short("GLB header".into(), end));
    }
    let (mut json, mut bin) = (None, None);
    let mut at = 12;
    while at < end {
        let (Some(size), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) else {
            return Err(short(format!("GLB chunk at byte {at}"), at + 8));
        };
        let stop = at + 8 + size as usize;
        if stop > bytes.len() {
            return Err(short(format!("GLB chunk at byte {at}"), stop));
        }
        let body = at + 8..stop;
        match (kind, json.is_some()) {
            (b"JSON", false) => json = Some(body),
            (_, false) => break,
            (b"BIN\0", true) => bin = bin.or(Some(body)),
            _ => {}
        }
        at = stop;
    }
    let missing = || {
        (
            "GLB chunk at byte 12".to_string(),
            "the first chunk is not JSON; the file is damaged, copy or export it again".into(),
        )
    };
    json.map(|json| Chunks { json, bin }).ok_or_else(missing)
}
