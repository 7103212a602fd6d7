//! What a picture file holds, and how large a picture may be.

use crate::Image;
use std::collections::BTreeMap;

/// Longest side that is read, in pixels.
pub(super) const MAX_SIDE: usize = 1 << 16;

/// Most pixels that are read: 3 GiB as [`Image`].
const MAX_PIXELS: usize = 1 << 28;

/// A read error without its file; [`crate::read`] adds it.
pub(super) type Reason = String;

/// Text of a file's header by name: `ambakeProjection`, `ambakeAxes`, `ambakeNormalisation`, …
pub type Labels = BTreeMap<String, String>;

/// A picture with what its header says.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageFile {
    /// The picture.
    pub image: Image,
    /// The header's own text.
    pub labels: Labels,
}

/// A side length pair that fits in memory.
pub(super) fn check_size(width: usize, height: usize) -> Result<(), Reason> {
    if width == 0 || height == 0 {
        return Err(format!("it is {width} x {height} pixels"));
    }
    if width > MAX_SIDE || height > MAX_SIDE || width * height > MAX_PIXELS {
        return Err(format!(
            "it is {width} x {height} pixels; at most {MAX_SIDE} a side and {MAX_PIXELS} in all are read"
        ));
    }
    Ok(())
}
