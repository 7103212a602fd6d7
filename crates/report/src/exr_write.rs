//! One OpenEXR file per page: single part, flat, float32 (harmonics: half), ZIP, channels in the order of their names.
//!
//! The bytes are a function of the page and the header alone. The `exr` crate keeps attributes in a hash map and so
//! writes them in a random order; [`sort_attributes`] puts them in the order of their names, as OpenEXR's own library
//! does. See vendor-notes/exr.md.

use crate::Error;
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use exr::block::writer::ChunksWriter;
use exr::compression::Compression;
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use exr::meta::BlockDescription;
use exr::meta::attribute::{AttributeValue, ChannelDescription, LineOrder, SampleType, Text};
use exr::meta::header::{Header, LayerAttributes};
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use std::fs::File;
use std::io::{BufWriter, Cursor, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

/// What the header of a page says about its origin. Everything is a string attribute in the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PageHeader {
    /// ambake's version: `ambakeVersion`, and `software` as `ambake VERSION`.
    pub version: String,
    /// The options of the bake, as JSON: `ambakeOptions`.
    pub options: String,
    /// Seed of the sample stream: `ambakeSeed`.
    pub seed: u64,
    /// What the stored numbers mean: `ambakeConvention`.
    pub convention: String,
    /// The rule by which the specular term is viewed: `ambakeView`.
    pub view: String,
    /// `Scene::content_hash`: `ambakeSceneHash`.
    pub scene_hash: String,
    /// [`crate::layout_hash`]: `ambakeLayout`.
    pub layout: String,
    /// Page number from 0: `ambakePage`.
    pub page: u32,
}

impl PageHeader {
    fn attributes(&self) -> [(&'static str, String); 8] {
        [
            ("ambakeVersion", self.version.clone()),
            ("ambakeOptions", self.options.clone()),
            ("ambakeSeed", self.seed.to_string()),
            ("ambakeConvention", self.convention.clone()),
            ("ambakeView", self.view.clone()),
            ("ambakeSceneHash", self.scene_hash.clone()),
            ("ambakeLayout", self.layout.clone()),
            ("ambakePage", self.page.to_string()),
        ]
    }
}

/// The bytes of a picture of a few channels in the order of their names, ZIP. The header names its writer and no more,
/// so that they depend on the values alone.
pub(crate) fn plain_exr(
    size: (usize, usize),
    channels: impl IntoIterator<Item = AnyChannel<FlatSamples>>,
) -> Vec<u8> {
    let attributes = LayerAttributes {
        software_name: Some(Text::from("ambake")),
        ..LayerAttributes::default()
    };
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(Layer::new(size, attributes, encoding, channels))
        .write()
        .to_unbuffered(&mut bytes)
        .expect("a picture of a few channels, in memory");
    bytes.into_inner()
}

/// Writes a page to `file`, which is empty and open for reading and writing (as [`crate::Output::stage`] hands it out).
///
/// * `size`: edge of the page in texels.
/// * `channels`: each with its name in the file and `size * size` values, rows from the top.
///
/// Some blocks of lines are in memory at a time. The bytes do not depend on the number of threads.
///
/// # Errors
/// [`Error::NonFinite`] for the first NaN or infinity, before a byte is written; [`Error::Write`] with an empty path,
/// which [`crate::Output::stage`] fills in.
///
/// # Panics
/// Where a channel has another length than the page, or two channels have one name: bugs of the caller.
pub fn write_page_exr(
    file: &mut File,
    size: u32,
    channels: &[(String, &[f32])],
    header: &PageHeader,
) -> Result<(), Error> {
    let edge = size as usize;
    for (name, values) in channels {
        assert_eq!(
            values.len(),
            edge * edge,
            "channel {name} of a page of {edge} texels"
        );
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let (x, y) = ((at % edge) as u32, (at / edge) as u32);
            return Err(Error::NonFinite {
                layer: name.clone(),
                x,
                y,
                value: values[at],
            });
        }
    }
    let mut planes: Vec<Plane<'_>> = (channels.iter())
        .map(|(name, values)| Plane {
            name,
            values,
            half: is_half(name),
        })
        .collect();
    planes.sort_by_key(|plane| plane.name);
    if let Some(twin) = planes.windows(2).find(|pair| pair[0].name == pair[1].name) {
        panic!("two channels are called {}", twin[0].name);
    }
    // Bytes, not characters: the file format stores them as they are, and a path may hold any UTF-8.
    let text = |s: &str| Text::from_slice_unchecked(s.as_bytes());
    let mut attributes = LayerAttributes {
        software_name: Some(text(&format!("ambake {}", header.version))),
        ..LayerAttributes::default()
    };
    for (name, value) in header.attributes() {
        attributes
            .other
            .insert(Text::from(name), AttributeValue::Text(text(&value)));
    }
    let described = planes.iter().map(|plane| {
        let kind = match plane.half {
            true => SampleType::F16,
            false => SampleType::F32,
        };
        ChannelDescription::new(plane.name, kind, false)
    });
    let lines = Compression::ZIP16.scan_lines_per_block();
    let header = Header::new(Text::from(""), (edge, edge), described.collect())
        .with_encoding(
            Compression::ZIP16,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        )
        .with_attributes(attributes);
    let firsts: Vec<usize> = (0..edge).step_by(lines).collect();
    // So many blocks are in memory at a time.
    let together = 4 * rayon::current_num_threads();
    let written = exr::block::write(
        BufWriter::new(&mut *file),
        [header].into_iter().collect(),
        true,
        |_, writer| {
            let mut number = 0;
            for batch in firsts.chunks(together) {
                let packed: Vec<Vec<u8>> = (batch.par_iter().with_max_len(1))
                    .map(|&first| block(&planes, edge, first..(first + lines).min(edge)))
                    .collect();
                for (&first, compressed_pixels_le) in batch.iter().zip(packed) {
                    let block = CompressedScanLineBlock {
                        y_coordinate: first as i32,
                        compressed_pixels_le,
                    };
                    let chunk = Chunk {
                        layer_index: 0,
                        compressed_block: CompressedBlock::ScanLine(block),
                    };
                    writer.write_chunk(number, chunk)?;
                    number += 1;
                }
            }
            Ok(())
        },
    );
    written.map_err(|error| {
        let source = match error {
            exr::error::Error::Io(io) => io,
            other => std::io::Error::other(other.to_string()),
        };
        Error::write(Path::new(""), source)
    })?;
    sort_attributes(file).map_err(|e| Error::write(Path::new(""), e))
}

/// Puts the attributes of a single-part file's header in the order of their names. The header keeps its length, so the
/// offset table after it stays true.
fn sort_attributes(file: &mut File) -> std::io::Result<()> {
    const PREFIX: usize = 8; // magic number and version
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    let mut chunk = [0; 1 << 16];
    let records = loop {
        let count = file.read(&mut chunk)?;
        assert!(
            count > 0,
            "the header just written has an end within its {} bytes",
            bytes.len()
        );
        bytes.extend_from_slice(&chunk[..count]);
        if let Some(records) = attribute_records(&bytes[PREFIX..]) {
            break records;
        }
    };
    let length: usize = records.iter().map(|record| record.len()).sum();
    let mut sorted = records;
    sorted.sort(); // a record begins with its name and a zero byte, so this is the order of the names
    let sorted = sorted.concat();
    assert_eq!(sorted.len(), length);
    file.seek(SeekFrom::Start(PREFIX as u64))?;
    file.write_all(&sorted)?;
    file.seek(SeekFrom::End(0))?;
    Ok(())
}

/// Each attribute (name, zero, type, zero, length, value) up to the header's closing zero; `None` if `bytes` end
/// before.
fn attribute_records(bytes: &[u8]) -> Option<Vec<&[u8]>> {
    let mut records = Vec::new();
    let mut at = 0;
    while *bytes.get(at)? != 0 {
        let name = bytes[at..].iter().position(|&b| b == 0)? + 1;
        let kind = bytes[at + name..].iter().position(|&b| b == 0)? + 1;
        let value = at + name + kind + 4;
        let length = u32::from_le_bytes(bytes.get(value - 4..value)?.try_into().ok()?) as usize;
        records.push(bytes.get(at..value + length)?);
        at = value + length;
    }
    Some(records)
}

/// True for channels of layers that are stored as halves.
fn is_half(name: &str) -> bool {
    let layer = name
        .rsplit_once('.')
        .and_then(|(layer, _)| layers::Layer::from_name(layer));
    layer.is_some_and(layers::Layer::is_half)
}

/// A borrowed channel.
struct Plane<'a> {
    name: &'a str,
    values: &'a [f32],
    half: bool,
}

/// Some lines of a page as OpenEXR's ZIP packs them: the low bytes of all samples before the high ones, each as its
/// difference from the last, deflated; as they are where that does not make them shorter.
fn block(planes: &[Plane<'_>], edge: usize, lines: Range<usize>) -> Vec<u8> {
    let of_line = |plane: &Plane<'_>| edge * if plane.half { 2 } else { 4 };
    let mut bytes = vec![0u8; lines.len() * planes.iter().map(of_line).sum::<usize>()];
    let mut rest = &mut bytes[..];
    for y in lines {
        for plane in planes {
            let samples = &plane.values[y * edge..][..edge];
            let line;
            (line, rest) = rest.split_at_mut(of_line(plane));
            if plane.half {
                for (to, &sample) in line.as_chunks_mut().0.iter_mut().zip(samples) {
                    *to = half::f16::from_f32(sample).to_le_bytes();
                }
            } else {
                for (to, sample) in line.as_chunks_mut().0.iter_mut().zip(samples) {
                    *to = sample.to_le_bytes();
                }
            }
        }
    }
    let mut parted = vec![0u8; bytes.len()];
    let (low, high) = parted.split_at_mut(bytes.len() / 2);
    let pairs = bytes.as_chunks::<2>().0;
    for ((low, high), pair) in low.iter_mut().zip(high).zip(pairs) {
        [*low, *high] = *pair;
    }
    // The first byte has none before it, and stays.
    let mut last = 128;
    for byte in &mut parted {
        let own = *byte;
        *byte = own.wrapping_sub(last).wrapping_add(128);
        last = own;
    }
    let mut packed = ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    let packed = packed.write_all(&parted).and_then(|()| packed.finish());
    let packed = packed.expect("memory takes what is written");
    match packed.len() < bytes.len() {
        true => packed,
        false => bytes,
    }
}
