//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: buffer views whose content is compressed.
//!
//! The decoders are those of meshoptimizer, through the crate `meshopt`. They are made for data that nobody vouches
//! for; what they ask of their caller (sizes, strides, counts) is checked here first.

use super::edit::{list, take_extension};
use crate::GltfDocument;
use crate::gltf::accessor::number;
use crate::gltf::document::renumber;
use meshopt::{
    decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat,
    decode_index_buffer, decode_index_sequence, decode_vertex_buffer,
};
use serde_json::Value;

/// The two names of one format; the second is later and knows one more filter.
const NAMES: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The most bytes that one byte decodes to: two bits stand for a byte of each of 256 vertices.
const EXPANSION: usize = 1024;

/// Decodes every view whose own buffer has no content. Decoded bytes lie behind the first buffer; the buffers that only
/// held their place are gone. The content of a view whose data are damaged is absent.
pub(super) fn decode(document: &mut GltfDocument) {
    let held: usize = document.buffers.iter().map(Vec::len).sum();
    let mut left = held.saturating_mul(EXPANSION);
    let empty = document.placeholders();
    let is_empty = |buffer| empty.get(buffer) == Some(&true);
    for i in 0..list(&document.json, "bufferViews").len() {
        let view = &mut document.json["bufferViews"][i];
        if !number(view, "buffer").is_some_and(is_empty) {
            continue;
        }
        let packed = NAMES.iter().find_map(|name| take_extension(view, name));
        let bytes = match &packed {
            Some(packed) => decoded(document, packed, &mut left),
            None => Err("its buffer has neither a uri nor a binary chunk".into()),
        };
        let (buffer, start, length) = match bytes {
            Ok(bytes) => (0, document.append(&bytes), bytes.len()),
            Err(problem) => {
                let reason = document.loss(packed.as_ref(), &format!("buffer view {i}: {problem}"));
                (document.append_absent(reason), 0, 1)
            }
        };
        let view = &mut document.json["bufferViews"][i];
        view["buffer"] = buffer.into();
        view["byteOffset"] = start.into();
        view["byteLength"] = length.into();
    }
    drop_empty_buffers(document);
    for name in NAMES {
        let mut views = list(&document.json, "bufferViews").iter();
        if !views.any(|view| view.pointer(&format!("/extensions/{name}")).is_some()) {
            document.forget_extension(name);
        }
    }
}

/// Takes the buffers away that have no content, and renumbers what names the others.
fn drop_empty_buffers(document: &mut GltfDocument) {
    let kept: Vec<bool> = document.placeholders().iter().map(|empty| !empty).collect();
    if kept.iter().all(|&kept| kept) {
        return;
    }
    let before = |buffer: usize| kept.iter().take(buffer).filter(|&&kept| kept).count();
    renumber(&mut document.json, before);
    let mut keep = kept.iter();
    document.buffers.retain(|_| keep.next() == Some(&true));
    let mut keep = kept.iter();
    document.absent.retain(|_| keep.next() == Some(&true));
    let mut keep = kept.iter();
    if let Some(buffers) = document
        .json
        .get_mut("buffers")
        .and_then(Value::as_array_mut)
    {
        buffers.retain(|_| keep.next() == Some(&true));
        for buffer in buffers {
            NAMES
                .iter()
                .for_each(|name| drop(take_extension(buffer, name)));
        }
    }
}

/// The content of a view. `left` is how many bytes all views to come may have.
fn decoded(document: &GltfDocument, packed: &Value, left: &mut usize) -> Result<Vec<u8>, String> {
    let bytes = document.named_bytes(packed);
    let bytes = bytes.ok_or("its compressed data reach beyond their buffer")?;
    let field = |key: &str| number(packed, key).ok_or(format!("its compression has no {key}"));
    let (count, stride) = (field("count")?, field("byteStride")?);
    let size = count.saturating_mul(stride);
    if size > bytes.len().saturating_mul(EXPANSION) || size > *left {
        let there = bytes.len();
        return Err(format!(
            "{size} bytes cannot come of {there} compressed ones"
        ));
    }
    *left -= size;
    let word = |key: &str| packed.get(key).and_then(Value::as_str);
    let filter = word("filter").unwrap_or("NONE");
    let out = match (word("mode").unwrap_or(""), stride, filter) {
        ("TRIANGLES", 2, "NONE") if count % 3 == 0 => {
            decode_index_buffer::<u16>(bytes, count).map(|v| le(v, u16::to_le_bytes))
        }
        ("TRIANGLES", 4, "NONE") if count % 3 == 0 => {
            decode_index_buffer::<u32>(bytes, count).map(|v| le(v, u32::to_le_bytes))
        }
        ("INDICES", 2, "NONE") => {
            decode_index_sequence::<u16>(bytes, count).map(|v| le(v, u16::to_le_bytes))
        }
        ("INDICES", 4, "NONE") => {
            decode_index_sequence::<u32>(bytes, count).map(|v| le(v, u32::to_le_bytes))
        }
        ("ATTRIBUTES", 4, "OCTAHEDRAL") => decode_vertex_buffer(bytes, count).map(|mut v| {
            decode_filter_oct::<i8>(&mut v);
            le(v.into_flattened(), i8::to_le_bytes)
        }),
        ("ATTRIBUTES", 8, "OCTAHEDRAL") => decode_vertex_buffer(bytes, count).map(|mut v| {
            decode_filter_oct::<i16>(&mut v);
            le(v.into_flattened(), i16::to_le_bytes)
        }),
        ("ATTRIBUTES", 8, "QUATERNION") => decode_vertex_buffer(bytes, count).map(|mut v| {
            decode_filter_quat(&mut v);
            le(v.into_flattened(), i16::to_le_bytes)
        }),
        ("ATTRIBUTES", 4, "COLOR") => decode_vertex_buffer(bytes, count).map(|mut v| {
            decode_filter_color::<u8>(&mut v);
            v.into_flattened()
        }),
        ("ATTRIBUTES", 8, "COLOR") => decode_vertex_buffer(bytes, count).map(|mut v| {
            decode_filter_color::<u16>(&mut v);
            le(v.into_flattened(), u16::to_le_bytes)
        }),
        ("ATTRIBUTES", 4..=256, "NONE" | "EXPONENTIAL") if stride % 4 == 0 => {
            words(bytes, count, stride / 4).map(|mut v| {
                if filter == "EXPONENTIAL" {
                    decode_filter_exp(v.as_chunks_mut::<1>().0);
                }
                le(v, u32::to_le_bytes)
            })
        }
        (mode, ..) => {
            let mode: String = mode.chars().take(16).collect();
            let filter: String = filter.chars().take(16).collect();
            return Err(format!(
                "mode {mode:?} with {count} elements of {stride} bytes and filter {filter:?} is none \
                 that the format has"
            ));
        }
    };
    out.map_err(|_| "its compressed data are damaged".into())
}

/// Little-endian bytes of numbers.
fn le<T, const N: usize>(numbers: Vec<T>, bytes: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    numbers.into_iter().flat_map(bytes).collect()
}

/// Vertices of `size` words of 32 bits, one after the other.
fn words(bytes: &[u8], count: usize, size: usize) -> meshopt::Result<Vec<u32>> {
    /// The standard library has no default of long arrays.
    #[derive(Clone)]
    struct Vertex<const N: usize>([u32; N]);
    impl<const N: usize> Default for Vertex<N> {
        fn default() -> Self {
            Vertex([0; N])
        }
    }
    fn of<const N: usize>(bytes: &[u8], count: usize) -> meshopt::Result<Vec<u32>> {
        let vertices: Vec<Vertex<N>> = decode_vertex_buffer(bytes, count)?;
        Ok(vertices.into_iter().flat_map(|vertex| vertex.0).collect())
    }
    macro_rules! by_size {
        ($($n:literal)*) => {
            match size {
                $($n => of::<$n>(bytes, count),)*
                _ => unreachable!("{size} words were let pass"),
            }
        };
    }
    by_size!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
             33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}
