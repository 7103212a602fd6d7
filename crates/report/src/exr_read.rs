//! Reads a page back, for `compare` and `render`: any single-part, flat, square EXR.

use crate::{Channel, Error, Page, PageLayer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Longest page edge that is read, in texels.
pub const MAX_EDGE: u32 = 16_384;

/// Deflate cannot shrink data more than this; a header that promises more texels than that lies about its file.
const MAX_RATIO: u64 = 1032;

/// A page as a file holds it.
#[derive(Debug, Clone, PartialEq)]
pub struct PageFile {
    /// The layers, in the order of their names.
    pub page: Page,
    /// The header's own text attributes (`ambakeVersion`, …) by name.
    pub attributes: BTreeMap<String, String>,
}

/// The page stored in the file at `path`. Half and integer channels become floats.
///
/// A channel `a.b.R` belongs to the layer `a.b` with the suffix `R`; a name without one of the suffixes R, G, B, A, X,
/// Y, Z is a layer of its own.
///
/// # Errors
/// [`Error::Read`] for a file that is absent, cut short, not an EXR, deep, not square, larger than [`MAX_EDGE`], or
/// whose header promises more than its bytes can hold. Memory is bounded by the file's own length times 1032.
pub fn read_page_exr(path: &Path) -> Result<PageFile, Error> {
    let fail = |reason: String| Error::read(path, reason);
    if path.is_dir() {
        return Err(fail(
            "it is a directory; name one of the EXR pages in it".into(),
        ));
    }
    if path.exists() && !path.is_file() {
        return Err(fail("it is a pipe or a device; name an EXR page".into()));
    }
    let file = File::open(path).map_err(|e| fail(e.to_string()))?;
    let length = file.metadata().map_err(|e| fail(e.to_string()))?.len();
    let broken = |e: exr::error::Error| {
        fail(format!(
            "{e}; the file is damaged or not an EXR page, bake again"
        ))
    };
    let mut file = BufReader::new(file);
    let chunks = environment::exr_chunks(&mut file).map_err(broken)?;
    let [header] = chunks.headers() else {
        return Err(fail(format!(
            "it has {} parts; a page has one",
            chunks.headers().len()
        )));
    };
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    if header.deep || width != height || width == 0 {
        return Err(fail(format!(
            "it is {width} x {height}{}; a page is flat and square",
            deep(header.deep)
        )));
    }
    if width > MAX_EDGE as usize {
        return Err(fail(format!(
            "it is {width} texels wide; at most {MAX_EDGE} are read"
        )));
    }
    let promised = (width * height) as u64 * 4 * header.channels.list.len() as u64;
    if promised > length.saturating_mul(MAX_RATIO) {
        return Err(fail(format!(
            "its header promises {promised} bytes of texels, its {length} bytes cannot hold them"
        )));
    }
    if header
        .channels
        .list
        .iter()
        .any(|channel| channel.sampling.x() != 1 || channel.sampling.y() != 1)
    {
        return Err(fail("it has subsampled channels; a page has none".into()));
    }
    let (planes, attributes) = environment::exr_planes(chunks).map_err(broken)?;
    let mut layers: BTreeMap<String, PageLayer> = BTreeMap::new();
    for (full, values) in planes {
        let (name, suffix) = split(&full);
        let layer = layers.entry(name.into()).or_insert_with(|| PageLayer {
            name: name.into(),
            ..PageLayer::default()
        });
        layer.channels.push(Channel {
            suffix: suffix.into(),
            values,
        });
    }
    for layer in layers.values_mut() {
        // The file's order is alphabetical (B, G, R); pictures are thought of as R, G, B, A.
        layer.channels.sort_by_key(|c| "RGBAXYZ".find(&c.suffix));
    }
    let page = Page {
        size: width as u32,
        layers: layers.into_values().collect(),
    };
    Ok(PageFile { page, attributes })
}

fn deep(deep: bool) -> &'static str {
    if deep { ", deep" } else { "" }
}

/// Layer name and suffix of a channel name.
fn split(name: &str) -> (&str, &str) {
    match name.rsplit_once('.') {
        Some((layer, suffix)) if matches!(suffix, "R" | "G" | "B" | "A" | "X" | "Y" | "Z") => {
            (layer, suffix)
        }
        None if matches!(name, "R" | "G" | "B" | "A") => ("", name),
        _ => (name, ""),
    }
}
