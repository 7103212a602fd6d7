//! Reads accessors: every range is checked once when the accessor is opened, every element afterwards is inside.

use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, buffer};
use std::borrow::Cow;

/// The document and its bytes.
pub(super) struct Data<'a> {
    pub root: &'a Root,
    pub buffers: Vec<Cow<'a, [u8]>>,
}

/// An opened accessor.
pub(super) struct Elements<'a> {
    /// Number of elements.
    pub count: usize,
    component: ComponentType,
    normalized: bool,
    size: usize,
    /// Bytes from the first element on and their stride; `None` where the base is all zeros.
    base: Option<(&'a [u8], usize)>,
    /// Numbers of the replaced elements, increasing, and their packed values.
    sparse: Option<(Vec<u32>, &'a [u8])>,
}

impl<'a> Data<'a> {
    /// Bytes of a buffer view and its stride, if it has one.
    pub fn view(&self, index: Index<buffer::View>) -> Result<(&[u8], Option<usize>), String> {
        let view = self
            .root
            .get(index)
            .ok_or_else(|| format!("buffer view {index} does not exist"))?;
        let bytes = self
            .buffers
            .get(view.buffer.value())
            .map(|b| b.as_ref())
            .unwrap_or(&[]);
        let from = view.byte_offset.unwrap_or_default().0;
        let range = from
            .checked_add(view.byte_length.0)
            .and_then(|to| bytes.get(usize::try_from(from).ok()?..usize::try_from(to).ok()?));
        let bytes = range.ok_or_else(|| {
            format!(
                "buffer view {index} reaches beyond the {} bytes of buffer {}; the file is corrupt",
                bytes.len(),
                view.buffer
            )
        })?;
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }

    /// Opens an accessor of one of the types in `types`.
    ///
    /// # Errors
    /// A sentence that names the accessor.
    pub fn open(&self, index: Index<Accessor>, types: &[Type]) -> Result<Elements<'_>, String> {
        let accessor = self
            .root
            .get(index)
            .ok_or_else(|| format!("accessor {index} does not exist; the file is corrupt"))?;
        let named = |problem: String| format!("accessor {index}: {problem}");
        self.opened(accessor, types).map_err(named)
    }

    fn opened(&self, accessor: &Accessor, types: &[Type]) -> Result<Elements<'_>, String> {
        let (Checked::Valid(component), Checked::Valid(kind)) =
            (accessor.component_type, accessor.type_)
        else {
            return Err("unknown type; export the file again".into());
        };
        if !types.contains(&kind) {
            return Err(format!(
                "{kind:?} where {types:?} is expected; export the file again"
            ));
        }
        let component = component.0;
        let size = component.size() * kind.multiplicity();
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        let base = match accessor.buffer_view {
            Some(view) => {
                let (bytes, stride) = self.view(view)?;
                let stride = stride.unwrap_or(size);
                let offset = usize::try_from(accessor.byte_offset.unwrap_or_default().0)
                    .unwrap_or(usize::MAX);
                Some((elements(bytes, offset, stride, size, count)?, stride))
            }
            None => None,
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => {
                let replaced = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
                let Checked::Valid(kind) = sparse.indices.component_type else {
                    return Err("unknown type of sparse indices; export the file again".into());
                };
                let (bytes, _) = self.view(sparse.indices.buffer_view)?;
                let offset = usize::try_from(sparse.indices.byte_offset.0).unwrap_or(usize::MAX);
                let width = kind.0.size();
                let bytes = elements(bytes, offset, width, width, replaced)?;
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
                let (bytes, _) = self.view(sparse.values.buffer_view)?;
                let offset = usize::try_from(sparse.values.byte_offset.0).unwrap_or(usize::MAX);
                Some((numbers, elements(bytes, offset, size, size, replaced)?))
            }
            None => None,
        };
        if base.is_none() && sparse.is_none() {
            return Err("it has no data; if the file is compressed, decode it: `npx @gltf-transform/cli copy IN OUT`".into());
        }
        // Zeros cost no byte in the file, so their number needs a bound of its own.
        let bytes: usize = self.buffers.iter().map(|b| b.len()).sum();
        if base.is_none() && count > bytes {
            return Err(format!(
                "{count} elements without data in a file of {bytes} bytes; the file is corrupt"
            ));
        }
        if u32::try_from(count).is_err() {
            return Err(format!("{count} elements; split the mesh"));
        }
        Ok(Elements {
            count,
            component,
            normalized: accessor.normalized,
            size,
            base,
            sparse,
        })
    }
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
            "{count} elements of {size} bytes at a stride of {stride} do not fit into {} bytes from {offset} on; the file is corrupt",
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

impl Elements<'_> {
    fn bytes(&self, i: usize) -> Option<&[u8]> {
        if let Some((numbers, values)) = &self.sparse
            && let Ok(at) = numbers.binary_search(&(i as u32))
        {
            return Some(&values[at * self.size..][..self.size]);
        }
        self.base
            .map(|(bytes, stride)| &bytes[i * stride..][..self.size])
    }

    /// Element `i < count` as an index; 0 for a type that is none.
    pub fn index(&self, i: usize) -> u32 {
        match (self.component, self.bytes(i)) {
            (ComponentType::U8, Some(b)) => b[0] as u32,
            (ComponentType::U16, Some(b)) => u16::from_le_bytes([b[0], b[1]]) as u32,
            (ComponentType::U32, Some(b)) => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            _ => 0,
        }
    }

    /// Whether the components are unsigned integers without normalisation, as indices are.
    pub fn holds_indices(&self) -> bool {
        matches!(
            self.component,
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32
        ) && !self.normalized
    }

    /// Element `i < count` of `N` components, decoded as the specification says (section 3.11 for normalised ones).
    pub fn floats<const N: usize>(&self, i: usize) -> [f32; N] {
        let Some(bytes) = self.bytes(i) else {
            return [0.0; N];
        };
        let width = self.component.size();
        assert!(
            bytes.len() == N * width,
            "{} bytes for {N} components of {width}",
            bytes.len()
        );
        std::array::from_fn(|lane| {
            let b = &bytes[lane * width..][..width];
            let (value, most) = match self.component {
                ComponentType::F32 => return f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
                ComponentType::I8 => (b[0] as i8 as f32, 127.0),
                ComponentType::U8 => (b[0] as f32, 255.0),
                ComponentType::I16 => (i16::from_le_bytes([b[0], b[1]]) as f32, 32767.0),
                ComponentType::U16 => (u16::from_le_bytes([b[0], b[1]]) as f32, 65535.0),
                ComponentType::U32 => (
                    u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
                    u32::MAX as f32,
                ),
            };
            if self.normalized {
                (value / most).max(-1.0)
            } else {
                value
            }
        })
    }
}
