//! Accessors of any kind as raw elements: strides, sparse substitution and absent views resolved, types untouched.

use super::Reason;
use super::document::{Document, Target, index};
use serde_json::{Value, json};

/// The elements of an accessor, packed without gaps.
struct Elements {
    /// Bytes of one element.
    size: usize,
    count: usize,
    bytes: Vec<u8>,
}

/// Appends an accessor that holds the elements `vertices` of the accessor `source`, in that order, with the same type
/// and every other property. Bounds are rewritten where they are given, and written where `bounds` asks for them.
pub fn gather(
    document: &mut Document,
    source: usize,
    vertices: &[u32],
    bounds: bool,
) -> Result<usize, Reason> {
    let elements = elements(document, source)?;
    let stride = elements.size.next_multiple_of(4);
    let mut bytes = vec![0; stride * vertices.len()];
    for (slot, &vertex) in bytes.chunks_exact_mut(stride).zip(vertices) {
        let at = vertex as usize * elements.size;
        let element = elements.bytes.get(at..at + elements.size);
        let element =
            element.ok_or_else(|| format!("accessor {source} has no element {vertex}"))?;
        slot[..elements.size].copy_from_slice(element);
    }
    let mut accessor = document.get("accessors", source)?.clone();
    let bounds = bounds || accessor.get("min").is_some() || accessor.get("max").is_some();
    let limits = if bounds {
        limits(&accessor, &bytes, stride)
    } else {
        None
    };
    let view = document.push_view(&bytes, Target::Vertices(stride))?;
    let map = accessor
        .as_object_mut()
        .ok_or_else(|| format!("accessor {source} is not an object"))?;
    for key in ["sparse", "byteOffset", "min", "max"] {
        map.shift_remove(key);
    }
    map.insert("bufferView".into(), view.into());
    map.insert("count".into(), vertices.len().into());
    if let Some((min, max)) = limits {
        map.insert("min".into(), min.into());
        map.insert("max".into(), max.into());
    }
    document.push("accessors", accessor)
}

/// The numbers of a float accessor, or of a normalised integer one, `width` an element.
pub fn floats(document: &Document, accessor: usize, width: usize) -> Result<Vec<f64>, Reason> {
    let elements = elements(document, accessor)?;
    let json = document.get("accessors", accessor)?;
    let kind = index(json, "componentType").unwrap_or(0);
    let bytes = component_size(kind)?;
    if elements.size != width * bytes {
        return Err(format!(
            "accessor {accessor} has elements of another width than {width}"
        ));
    }
    let most = match kind {
        5120 => 127.0,
        5121 => 255.0,
        5122 => 32_767.0,
        5123 => 65_535.0,
        _ => 1.0,
    };
    let number = |stored: f64| {
        if most == 1.0 {
            stored
        } else {
            (stored / most).max(-1.0)
        }
    };
    Ok(elements
        .bytes
        .chunks_exact(bytes)
        .map(|c| number(component(kind, c)))
        .collect())
}

/// Number of elements of an accessor.
pub fn count(document: &Document, accessor: usize) -> Result<usize, Reason> {
    index(document.get("accessors", accessor)?, "count")
        .ok_or_else(|| format!("accessor {accessor} has no count"))
}

fn elements(document: &Document, accessor: usize) -> Result<Elements, Reason> {
    let json = document.get("accessors", accessor)?;
    let size = element_size(json).map_err(|e| format!("accessor {accessor}: {e}"))?;
    let count = count(document, accessor)?;
    let view = index(json, "bufferView");
    let offset = index(json, "byteOffset").unwrap_or(0);
    let mut bytes = match view {
        Some(view) => strided(document, view, offset, size, count),
        // Without a view every element is zero. Callers have compared `count` with a mesh that is in memory.
        None => Ok(vec![0; count * size]),
    }
    .map_err(|e| format!("accessor {accessor}: {e}"))?;
    if let Some(sparse) = json.get("sparse") {
        overlay(document, sparse, size, &mut bytes)
            .map_err(|e| format!("accessor {accessor}: sparse: {e}"))?;
    }
    Ok(Elements { size, count, bytes })
        .inspect(|e| debug_assert_eq!(e.bytes.len(), e.size * e.count))
}

/// Puts the sparse values in their places.
fn overlay(
    document: &Document,
    sparse: &Value,
    size: usize,
    bytes: &mut [u8],
) -> Result<(), Reason> {
    let part = |key: &str| sparse.get(key).ok_or_else(|| format!("{key} are absent"));
    let (indices, values) = (part("indices")?, part("values")?);
    let count = index(sparse, "count").ok_or("it has no count")?;
    let read = |json: &Value, size| {
        let view = index(json, "bufferView").ok_or("it has no bufferView")?;
        strided(
            document,
            view,
            index(json, "byteOffset").unwrap_or(0),
            size,
            count,
        )
    };
    let kind = index(indices, "componentType").unwrap_or(0);
    let width = component_size(kind)?;
    let places = read(indices, width)?;
    let values = read(values, size)?;
    for (place, value) in places.chunks_exact(width).zip(values.chunks_exact(size)) {
        let at = component(kind, place) as usize * size;
        let slot = bytes
            .get_mut(at..at + size)
            .ok_or("an index is out of range")?;
        slot.copy_from_slice(value);
    }
    Ok(())
}

/// `count` elements of `size` bytes from a buffer view, packed.
fn strided(
    document: &Document,
    view: usize,
    offset: usize,
    size: usize,
    count: usize,
) -> Result<Vec<u8>, Reason> {
    let json = document.get("bufferViews", view)?;
    let buffer = index(json, "buffer")
        .and_then(|b| document.buffers.get(b))
        .ok_or("its buffer is absent")?;
    let start = index(json, "byteOffset").unwrap_or(0);
    let length = index(json, "byteLength").unwrap_or(0);
    let data = start
        .checked_add(length)
        .and_then(|end| buffer.get(start..end))
        .ok_or("its view leaves the buffer")?;
    let stride = index(json, "byteStride").unwrap_or(size).max(1);
    let end = count
        .saturating_sub(1)
        .checked_mul(stride)
        .and_then(|v| v.checked_add(offset)?.checked_add(size));
    if count == 0 || end.is_none_or(|end| end > data.len()) {
        return Err(format!(
            "{count} elements do not fit its view of {length} bytes"
        ));
    }
    let mut bytes = Vec::with_capacity(count * size);
    for i in 0..count {
        let at = offset + i * stride;
        bytes.extend_from_slice(&data[at..at + size]);
    }
    Ok(bytes)
}

/// Smallest and largest value of each component; `None` for matrices and for values that JSON cannot hold.
fn limits(accessor: &Value, bytes: &[u8], stride: usize) -> Option<(Vec<Value>, Vec<Value>)> {
    let kind = index(accessor, "componentType")?;
    let width = component_size(kind).ok()?;
    let columns = columns(accessor)?;
    if columns.0 != 1 || bytes.is_empty() {
        return None;
    }
    let mut limits = (Vec::new(), Vec::new());
    for c in 0..columns.1 {
        let values = bytes
            .chunks_exact(stride)
            .map(|e| component(kind, &e[c * width..(c + 1) * width]));
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        if !low.is_finite() || !high.is_finite() {
            return None;
        }
        let number = |v: f64| {
            if kind == 5126 {
                json!(v)
            } else {
                json!(v as i64)
            }
        };
        limits.0.push(number(low));
        limits.1.push(number(high));
    }
    Some(limits)
}

/// Number of columns and of components in each.
fn columns(accessor: &Value) -> Option<(usize, usize)> {
    Some(match accessor.get("type")?.as_str()? {
        "SCALAR" => (1, 1),
        "VEC2" => (1, 2),
        "VEC3" => (1, 3),
        "VEC4" => (1, 4),
        "MAT2" => (2, 2),
        "MAT3" => (3, 3),
        "MAT4" => (4, 4),
        _ => return None,
    })
}

/// Bytes of one element; the columns of a matrix begin on multiples of four.
fn element_size(accessor: &Value) -> Result<usize, Reason> {
    let width = component_size(index(accessor, "componentType").unwrap_or(0))?;
    let (count, rows) = columns(accessor).ok_or("its type is unknown")?;
    Ok(if count == 1 {
        rows * width
    } else {
        count * (rows * width).next_multiple_of(4)
    })
}

fn component_size(kind: usize) -> Result<usize, Reason> {
    match kind {
        5120 | 5121 => Ok(1),
        5122 | 5123 => Ok(2),
        5125 | 5126 => Ok(4),
        _ => Err(format!("component type {kind} is unknown")),
    }
}

/// The stored number, not normalised.
fn component(kind: usize, bytes: &[u8]) -> f64 {
    match (kind, bytes) {
        (5120, &[a]) => f64::from(a as i8),
        (5121, &[a]) => f64::from(a),
        (5122, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (5123, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (5125, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (5126, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => unreachable!("component type {kind} of {} bytes", bytes.len()),
    }
}
