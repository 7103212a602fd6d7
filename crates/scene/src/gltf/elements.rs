//! The elements of an opened accessor, raw and decoded.

pub(super) use gltf::json::accessor::{ComponentType, Type};
use serde_json::Value;

/// An opened accessor of a [`crate::GltfDocument`]: strides, sparse substitution and absent views are resolved.
pub struct Elements<'a> {
    /// Number of elements, at most `u32::MAX`.
    pub count: usize,
    pub(super) kind: Type,
    pub(super) component: ComponentType,
    pub(super) normalized: bool,
    pub(super) size: usize,
    /// Bytes from the first element on and their stride; `None` where the base is all zeros.
    pub(super) base: Option<(&'a [u8], usize)>,
    /// Numbers of the replaced elements, increasing, and their packed values.
    pub(super) sparse: Option<(Vec<u32>, &'a [u8])>,
}

/// An element of an accessor without data: the largest is a matrix of 4 x 4 floats.
static ZEROS: [u8; 64] = [0; 64];

impl Elements<'_> {
    /// Bytes of one element. The columns of a matrix begin on multiples of four.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Components of a scalar or a vector; `None` for a matrix.
    pub fn lanes(&self) -> Option<usize> {
        let matrix = matches!(self.kind, Type::Mat2 | Type::Mat3 | Type::Mat4);
        (!matrix).then(|| self.kind.multiplicity())
    }

    /// The [`Elements::size`] bytes of element `i` as the file stores them; `None` beyond the last.
    pub fn bytes(&self, i: usize) -> Option<&[u8]> {
        if i >= self.count {
            return None;
        }
        if let Some((numbers, values)) = &self.sparse
            && let Ok(at) = numbers.binary_search(&(i as u32))
        {
            return Some(&values[at * self.size..][..self.size]);
        }
        Some(match self.base {
            Some((bytes, stride)) => &bytes[i * stride..][..self.size],
            None => &ZEROS[..self.size],
        })
    }

    /// Component `lane` of element `i` as it is stored, not normalised; `None` beyond the last and for a matrix.
    pub fn stored(&self, i: usize, lane: usize) -> Option<f64> {
        let width = self.component.size();
        let inside = lane < self.lanes()?;
        let bytes = self.bytes(i).filter(|_| inside)?;
        Some(value(self.component, &bytes[lane * width..]))
    }

    /// Element `i` as numbers, decoded as the specification says (section 3.11 for normalised integers); `None` beyond
    /// the last element and where an element has not `N` components.
    pub fn numbers<const N: usize>(&self, i: usize) -> Option<[f64; N]> {
        let fits = self.lanes()? == N;
        let bytes = self.bytes(i).filter(|_| fits)?;
        let most = match self.component {
            _ if !self.normalized => None,
            ComponentType::I8 => Some(127.0),
            ComponentType::U8 => Some(255.0),
            ComponentType::I16 => Some(32_767.0),
            ComponentType::U16 => Some(65_535.0),
            // The specification forbids both; the first has one natural reading, the second none.
            ComponentType::U32 => Some(f64::from(u32::MAX)),
            ComponentType::F32 => None,
        };
        let width = self.component.size();
        Some(std::array::from_fn(|lane| {
            let stored = value(self.component, &bytes[lane * width..]);
            most.map_or(stored, |most| (stored / most).max(-1.0))
        }))
    }

    /// Element `i < count` of a vector of `N` components, in the loader's precision. Rounding a quotient of small
    /// integers first to f64 and then to f32 gives the f32 quotient.
    pub(super) fn floats<const N: usize>(&self, i: usize) -> [f32; N] {
        let numbers = self.numbers::<N>(i);
        let numbers = numbers
            .unwrap_or_else(|| panic!("element {i} of {} {:?} as {N}", self.count, self.kind));
        numbers.map(|number| number as f32)
    }

    /// Element `i < count` as an index; 0 for a type that is none.
    pub(super) fn index(&self, i: usize) -> u32 {
        match (self.component, self.bytes(i)) {
            (ComponentType::U8, Some(b)) => b[0] as u32,
            (ComponentType::U16, Some(b)) => u16::from_le_bytes([b[0], b[1]]) as u32,
            (ComponentType::U32, Some(b)) => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            _ => 0,
        }
    }

    /// Whether the components are unsigned integers without normalisation, as indices are.
    pub(super) fn holds_indices(&self) -> bool {
        matches!(
            self.component,
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32
        ) && !self.normalized
    }
}

/// The component type that an accessor or its sparse indices name; `None` for an unknown one.
pub(super) fn component(json: &Value) -> Option<ComponentType> {
    Some(match json.get("componentType")?.as_u64()? {
        5120 => ComponentType::I8,
        5121 => ComponentType::U8,
        5122 => ComponentType::I16,
        5123 => ComponentType::U16,
        5125 => ComponentType::U32,
        5126 => ComponentType::F32,
        _ => return None,
    })
}

/// The type that an accessor names; `None` for an unknown one.
pub(super) fn kind(json: &Value) -> Option<Type> {
    Some(match json.get("type")?.as_str()? {
        "SCALAR" => Type::Scalar,
        "VEC2" => Type::Vec2,
        "VEC3" => Type::Vec3,
        "VEC4" => Type::Vec4,
        "MAT2" => Type::Mat2,
        "MAT3" => Type::Mat3,
        "MAT4" => Type::Mat4,
        _ => return None,
    })
}

/// Bytes of one element; the columns of a matrix begin on multiples of four.
pub(super) fn element_size(kind: Type, component: ComponentType) -> usize {
    let width = component.size();
    let column = |rows: usize| (rows * width).next_multiple_of(4);
    match kind {
        Type::Mat2 => 2 * column(2),
        Type::Mat3 => 3 * column(3),
        Type::Mat4 => 4 * column(4),
        vector => vector.multiplicity() * width,
    }
}

/// The stored number at the head of `bytes`.
fn value(component: ComponentType, bytes: &[u8]) -> f64 {
    match (component, bytes) {
        (ComponentType::I8, &[a, ..]) => f64::from(a as i8),
        (ComponentType::U8, &[a, ..]) => f64::from(a),
        (ComponentType::I16, &[a, b, ..]) => f64::from(i16::from_le_bytes([a, b])),
        (ComponentType::U16, &[a, b, ..]) => f64::from(u16::from_le_bytes([a, b])),
        (ComponentType::U32, &[a, b, c, d, ..]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (ComponentType::F32, &[a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => unreachable!("{component:?} in {} bytes", bytes.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GltfDocument;
    use serde_json::json;

    fn document(accessor: Value, views: Value, bytes: &[u8]) -> GltfDocument {
        GltfDocument {
            json: json!({ "accessors": [accessor], "bufferViews": views }),
            buffers: vec![bytes.to_vec()],
            absent: Vec::new(),
            images: Vec::new(),
        }
    }

    #[test]
    fn columns_of_small_matrices_are_padded_and_stay_whole() {
        let accessor =
            json!({ "bufferView": 0, "componentType": 5121, "type": "MAT3", "count": 2 });
        let bytes: Vec<u8> = (0..24).collect();
        let views = json!([{ "buffer": 0, "byteLength": 24 }]);
        let document = document(accessor, views, &bytes);
        let elements = document.accessor(0).unwrap();
        assert_eq!((elements.size(), elements.lanes()), (12, None));
        assert_eq!(elements.bytes(1), Some(&bytes[12..]));
        assert_eq!(elements.bytes(2), None);
        assert_eq!(elements.stored(0, 0), None);
        assert_eq!(elements.numbers::<9>(0), None);
    }

    #[test]
    fn sparse_values_stand_in_for_strided_elements_and_for_zeros() {
        let accessor = |base: Value| {
            let mut accessor = json!({ "componentType": 5122, "type": "VEC2", "count": 3, "normalized": true,
                "sparse": { "count": 1, "indices": { "bufferView": 1, "componentType": 5121 },
                            "values": { "bufferView": 1, "byteOffset": 4 } } });
            accessor
                .as_object_mut()
                .unwrap()
                .extend(base.as_object().unwrap().clone());
            accessor
        };
        let views = json!([
            { "buffer": 0, "byteOffset": 8, "byteLength": 20, "byteStride": 8 },
            { "buffer": 0, "byteLength": 8 },
        ]);
        let mut bytes = vec![1, 0, 0, 0, 0xff, 0x7f, 0x01, 0x80]; // index 1: 32767 and -32767
        bytes.extend([
            0, 0, 0, 0x80, 9, 9, 9, 9, 7, 7, 7, 7, 9, 9, 9, 9, 1, 0, 2, 0,
        ]);
        let strided = document(accessor(json!({ "bufferView": 0 })), views.clone(), &bytes);
        let elements = strided.accessor(0).unwrap();
        // -32768 is below the range and is clamped.
        assert_eq!(elements.numbers::<2>(0), Some([0.0, -1.0]));
        assert_eq!(elements.stored(0, 1), Some(-32_768.0));
        assert_eq!(elements.numbers::<2>(1), Some([1.0, -1.0]));
        assert_eq!(
            elements.numbers::<2>(2),
            Some([1.0, 2.0].map(|v: f64| v / 32_767.0))
        );
        assert_eq!((elements.stored(2, 2), elements.stored(3, 0)), (None, None));
        let zeros = document(accessor(json!({})), views, &bytes);
        let elements = zeros.accessor(0).unwrap();
        assert_eq!(elements.bytes(0), Some(&[0; 4][..]));
        assert_eq!(elements.bytes(1), Some(&bytes[4..8]));
    }

    #[test]
    fn an_accessor_without_data_holds_zeros_of_any_number() {
        let accessor = json!({ "componentType": 5126, "type": "MAT4", "count": u32::MAX });
        let document = document(accessor, json!([]), &[]);
        let elements = document.accessor(0).unwrap();
        assert_eq!(elements.bytes(u32::MAX as usize - 1), Some(&ZEROS[..]));
    }

    #[test]
    fn normalised_integers_round_to_the_f32_quotient() {
        let accessor = json!({ "bufferView": 0, "componentType": 5123, "type": "SCALAR", "count": 65_536,
                               "normalized": true });
        let bytes: Vec<u8> = (0..=u16::MAX).flat_map(u16::to_le_bytes).collect();
        let views = json!([{ "buffer": 0, "byteLength": bytes.len() }]);
        let document = document(accessor, views, &bytes);
        let elements = document.accessor(0).unwrap();
        for i in 0..=u16::MAX {
            assert_eq!(
                elements.floats::<1>(i.into()),
                [f32::from(i) / 65_535.0],
                "{i}"
            );
        }
    }
}
