//! Reads accessors: every range is checked once when the accessor is opened, every element afterwards is inside.

use super::elements::{ComponentType, Elements, Type, component, element_size, kind};
use crate::GltfDocument;
use crate::input::short;
use serde_json::Value;

/// So many elements without data are read in a file of any size.
const MOST_ZEROS: usize = 1 << 16;

impl GltfDocument {
    /// The elements of a top-level array; none where there is no such array.
    pub(super) fn list(&self, key: &str) -> &[Value] {
        let list = self.json.get(key).and_then(Value::as_array);
        list.map_or(&[], Vec::as_slice)
    }

    /// Opens an accessor of one of the types in `types`. One without data holds zeros.
    ///
    /// # Errors
    /// A sentence that names the accessor.
    pub(super) fn typed(&self, index: usize, types: &[Type]) -> Result<Elements<'_>, String> {
        let elements = self.accessor(index)?;
        let (kind, count) = (elements.kind, elements.count);
        let named = |problem: String| Err(format!("accessor {index}: {problem}"));
        if !types.contains(&kind) {
            let word = |kind: &Type| format!("{kind:?}").to_uppercase();
            let words: Vec<String> = types.iter().map(word).collect();
            return named(format!(
                "its type is {}, and must be {} for this use",
                word(&kind),
                words.join(" or ")
            ));
        }
        // Zeros cost no byte in the file, so their number needs a bound of its own.
        let bytes: usize = self.buffers.iter().map(Vec::len).sum();
        if elements.base.is_none() && count > bytes.max(MOST_ZEROS) {
            return named(format!(
                "{count} elements without data in a file of {bytes} bytes; the file is corrupt"
            ));
        }
        Ok(elements)
    }

    /// Bytes of a buffer view and its stride, if it has one.
    pub(super) fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), String> {
        let view = self
            .list("bufferViews")
            .get(index)
            .ok_or_else(|| format!("buffer view {index} does not exist"))?;
        let buffer = number(view, "buffer").unwrap_or(usize::MAX);
        if let Some(Some(reason)) = self.absent.get(buffer) {
            return Err(reason.clone());
        }
        let bytes = self.buffers.get(buffer).map_or(&[][..], Vec::as_slice);
        let from = stated(view, "byteOffset")?.unwrap_or(0);
        let to = number(view, "byteLength").and_then(|length| from.checked_add(length));
        let range = to.and_then(|to| bytes.get(from..to)).ok_or_else(|| {
            format!(
                "buffer view {index} reaches beyond the {} bytes of buffer {buffer}; the file is corrupt",
                bytes.len()
            )
        })?;
        Ok((range, stated(view, "byteStride")?))
    }

    /// Opens an accessor of any type. Nothing is copied but the numbers of a sparse accessor; an accessor without data
    /// holds zeros.
    ///
    /// # Errors
    /// A sentence that names the accessor: it is absent, of an unknown type, or reaches out of its buffer.
    pub fn accessor(&self, index: usize) -> Result<Elements<'_>, String> {
        let accessor = self
            .list("accessors")
            .get(index)
            .ok_or_else(|| format!("accessor {index} does not exist; the file is corrupt"))?;
        self.opened(accessor)
            .map_err(|problem| format!("accessor {index}: {problem}"))
    }

    fn opened(&self, accessor: &Value) -> Result<Elements<'_>, String> {
        let component = component(accessor).ok_or_else(|| {
            let said = shown(accessor, "componentType");
            format!("its componentType is {said}, and must be one of 5120 to 5123, 5125 and 5126")
        })?;
        let kind = kind(accessor).ok_or_else(|| {
            let said = shown(accessor, "type");
            format!("its type is {said}, and must be SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4")
        })?;
        let size = element_size(kind, component);
        let count = number(accessor, "count").unwrap_or(usize::MAX);
        let base = match stated(accessor, "bufferView")? {
            Some(view) => {
                let (bytes, stride) = self.view(view)?;
                let stride = stride.unwrap_or(size);
                let offset = stated(accessor, "byteOffset")?.unwrap_or(0);
                Some((elements(bytes, offset, stride, size, count)?, stride))
            }
            None => None,
        };
        let sparse = match accessor.get("sparse").filter(|sparse| !sparse.is_null()) {
            Some(sparse) => Some(self.sparse(sparse, size, count)?),
            None => None,
        };
        if u32::try_from(count).is_err() {
            return Err(format!("{count} elements; split the mesh"));
        }
        Ok(Elements {
            count,
            kind,
            component,
            normalized: accessor.get("normalized") == Some(&Value::Bool(true)),
            size,
            base,
            sparse,
        })
    }

    /// The numbers of the replaced elements, and their values of `size` bytes, packed.
    fn sparse(
        &self,
        sparse: &Value,
        size: usize,
        count: usize,
    ) -> Result<(Vec<u32>, &[u8]), String> {
        let part = |key: &str, size: usize| -> Result<(&[u8], usize), String> {
            let json = &sparse[key];
            let (bytes, _) = self.view(number(json, "bufferView").unwrap_or(usize::MAX))?;
            let offset = number(json, "byteOffset").unwrap_or(0);
            let replaced = number(sparse, "count").unwrap_or(usize::MAX);
            Ok((elements(bytes, offset, size, size, replaced)?, replaced))
        };
        let width = match component(&sparse["indices"]) {
            Some(ComponentType::U8) => 1,
            Some(ComponentType::U16) => 2,
            Some(ComponentType::U32) => 4,
            _ => {
                return Err(format!(
                    "the componentType of its sparse indices is {}, and must be 5121, 5123 or 5125",
                    shown(&sparse["indices"], "componentType")
                ));
            }
        };
        let (bytes, replaced) = part("indices", width)?;
        let numbers: Vec<u32> = bytes
            .chunks_exact(width)
            .take(replaced)
            .map(unsigned)
            .collect();
        let increasing = numbers.windows(2).all(|pair| pair[0] < pair[1]);
        if !increasing || numbers.last().is_some_and(|&last| last as usize >= count) {
            return Err(format!(
                "sparse indices do not increase below {count}; the file is corrupt"
            ));
        }
        Ok((numbers, part("values", size)?.0))
    }
}

/// A size, offset or index stored under `key`; one that this machine cannot address is as large as it gets.
pub(super) fn number(json: &Value, key: &str) -> Option<usize> {
    json.get(key).and_then(index)
}

/// As [`number`], where it may be absent but not be something else.
///
/// # Errors
/// A sentence.
pub(super) fn stated(json: &Value, key: &str) -> Result<Option<usize>, String> {
    let value = json.get(key).filter(|value| !value.is_null());
    let stated = value.map(|value| {
        let other = || {
            format!(
                "{key} is {}, and must be a whole number from 0 on",
                short(&value.to_string())
            )
        };
        index(value).ok_or_else(other)
    });
    stated.transpose()
}

/// What stands under a key, for messages that say what must.
pub(super) fn shown(json: &Value, key: &str) -> String {
    let value = json.get(key);
    value.map_or_else(|| "absent".into(), |value| short(&value.to_string()))
}

/// As [`number`], of the value itself.
pub(super) fn index(value: &Value) -> Option<usize> {
    let number = value.as_u64()?;
    Some(usize::try_from(number).unwrap_or(usize::MAX))
}

/// The bytes from `offset` on, once `count` elements are known to fit.
fn elements(
    bytes: &[u8],
    offset: usize,
    stride: usize,
    size: usize,
    count: usize,
) -> Result<&[u8], String> {
    let needed = match count {
        0 => Some(0),
        _ => (count - 1)
            .checked_mul(stride)
            .and_then(|n| n.checked_add(size)),
    };
    let fits = needed
        .and_then(|n| n.checked_add(offset))
        .is_some_and(|n| n <= bytes.len());
    match bytes.get(offset..) {
        Some(rest) if fits && stride >= size => Ok(rest),
        _ => Err(format!(
            "{count} elements of {size} bytes at a stride of {stride} do not fit into {} bytes from {offset} on; the \
             file is corrupt",
            bytes.len()
        )),
    }
}

/// A little-endian unsigned integer of 1, 2 or 4 bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |value, &byte| value << 8 | byte as u32)
}
