//! Accessors of the file as raw elements in a new order, with their types and every other property untouched.

use super::Reason;
use super::document::{Document, Target};
use super::places::index;
use scene::Elements;
use serde_json::{Value, json};

/// Appends an accessor that holds the elements `vertices` of the file's accessor `source`, opened as `elements`, in
/// that order, with the same type and every other property. Bounds are rewritten where they are given, and written
/// where `bounds` asks for them.
///
/// # Errors
/// `elements` has not that many elements.
pub fn gather(
    document: &mut Document,
    source: usize,
    elements: &Elements,
    vertices: &[u32],
    bounds: bool,
) -> Result<usize, Reason> {
    let stride = elements.size().next_multiple_of(4);
    let mut bytes = vec![0; stride * vertices.len()];
    for (slot, &vertex) in bytes.chunks_exact_mut(stride).zip(vertices) {
        let element = elements.bytes(vertex as usize);
        let element =
            element.ok_or_else(|| format!("accessor {source} has no element {vertex}"))?;
        slot[..element.len()].copy_from_slice(element);
    }
    let mut accessor = document.get("accessors", source)?.clone();
    let bounds = bounds || accessor.get("min").is_some() || accessor.get("max").is_some();
    let float = index(&accessor, "componentType") == Some(5126);
    let limits = match bounds {
        true => limits(elements, vertices, float),
        false => None,
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

/// Smallest and largest stored value of each component; `None` for matrices and for values that JSON cannot hold.
fn limits(elements: &Elements, vertices: &[u32], float: bool) -> Option<(Vec<Value>, Vec<Value>)> {
    let number = |v: f64| if float { json!(v) } else { json!(v as i64) };
    let mut limits = (Vec::new(), Vec::new());
    for lane in 0..elements.lanes()? {
        let values = vertices
            .iter()
            .filter_map(|&vertex| elements.stored(vertex as usize, lane));
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = values.fold(start, |(low, high), v| (low.min(v), high.max(v)));
        // Also where there is no vertex.
        if !low.is_finite() || !high.is_finite() {
            return None;
        }
        limits.0.push(number(low));
        limits.1.push(number(high));
    }
    Some(limits)
}
