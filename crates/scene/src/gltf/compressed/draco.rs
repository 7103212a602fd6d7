//! `KHR_draco_mesh_compression`: primitives whose attributes and indices are one compressed stream, decoded by the
//! crate `draco-core`.

use super::edit::{list, take_extension};
use crate::GltfDocument;
use crate::gltf::accessor::number;
use crate::gltf::elements::{ComponentType, component, kind};
use crate::input::short;
use draco_core::{DataType, DecodeLimits, DecoderBuffer, MeshDecoder, PointAttribute, PointIndex};
use serde_json::{Value, json};
use std::collections::BTreeMap;

const NAME: &str = "KHR_draco_mesh_compression";

/// Where a primitive names the accessor of its indices.
const INDICES: &str = "indices";

/// The most triangles that one byte of a stream may hold. A plane in regular triangles has some hundred.
const FACES_A_BYTE: u64 = 4096;

/// The most bytes of decoded attributes in a file: as much as its indices can tell apart in the usual layout.
const MOST_BYTES: u64 = 16 << 30;

/// Which stream an accessor was filled from. Where several attributes of one stream share an accessor, as coordinates
/// that an exporter found equal, they are equal, and the first is taken. Where several streams do, as indices that it
/// found equal before it compressed them, each has its own, and the later ones get accessors of their own.
type Filled = BTreeMap<usize, usize>;

/// Decodes every primitive whose accessors have no data of their own. Decoded bytes lie behind the first buffer. The
/// content of accessors whose stream is damaged is absent.
pub(super) fn decode(document: &mut GltfDocument) {
    let mut filled = Filled::new();
    let mut left = MOST_BYTES;
    let mut remains = false;
    for m in 0..list(&document.json, "meshes").len() {
        for p in 0..list(&document.json["meshes"][m], "primitives").len() {
            let primitive = document.json["meshes"][m]["primitives"][p].clone();
            let Some(stream) = primitive.pointer(&format!("/extensions/{NAME}")) else {
                continue;
            };
            if has_data(document, &primitive, &filled) {
                remains = true;
                continue;
            }
            let decoded = fill(document, &primitive, stream, &mut filled, left);
            let (bytes, places) = decoded.unwrap_or_else(|problem| {
                let view = number(stream, "bufferView").unwrap_or(usize::MAX);
                let view = list(&document.json, "bufferViews").get(view);
                let reason = document.loss(view, &problem);
                (0, lose(document, &primitive, reason))
            });
            left -= bytes.min(left);
            let primitive = &mut document.json["meshes"][m]["primitives"][p];
            take_extension(primitive, NAME);
            for (name, accessor) in places {
                match name.as_str() {
                    INDICES => primitive[INDICES] = accessor.into(),
                    _ => primitive["attributes"][name] = accessor.into(),
                }
            }
            // A stream holds triangles, whatever they were before.
            primitive
                .as_object_mut()
                .and_then(|p| p.shift_remove("mode"));
        }
    }
    if !remains {
        document.forget_extension(NAME);
    }
}

/// Accessors whose content is absent in place of those of a primitive, which others may share.
fn lose(document: &mut GltfDocument, primitive: &Value, reason: String) -> Vec<(String, usize)> {
    let buffer = document.append_absent(reason);
    let view = list(&document.json, "bufferViews").len();
    if let Some(views) = document.json["bufferViews"].as_array_mut() {
        views.push(json!({ "buffer": buffer, "byteLength": 1 }));
    }
    let attributes = primitive.get("attributes").and_then(Value::as_object);
    let attributes = attributes.into_iter().flatten();
    let attributes = attributes.map(|(name, accessor)| (name.as_str(), accessor));
    let indices = primitive.get(INDICES).map(|accessor| (INDICES, accessor));
    let mut places = Vec::new();
    for (name, accessor) in attributes.chain(indices) {
        let Some(accessors) = document.json["accessors"].as_array_mut() else {
            continue;
        };
        let named = crate::gltf::accessor::index(accessor);
        if let Some(mut own) = named.and_then(|named| accessors.get(named)).cloned() {
            own["bufferView"] = view.into();
            places.push((name.to_owned(), accessors.len()));
            accessors.push(own);
        }
    }
    places
}

/// Whether the positions of a primitive stand in the file uncompressed too.
fn has_data(document: &GltfDocument, primitive: &Value, filled: &Filled) -> bool {
    let positions = number(&primitive["attributes"], "POSITION");
    let positions = positions.filter(|accessor| !filled.contains_key(accessor));
    let accessor = positions.and_then(|i| list(&document.json, "accessors").get(i));
    accessor.is_some_and(|accessor| accessor.get("bufferView").is_some())
        && primitive
            .pointer(&format!("/extensions/{NAME}/attributes/POSITION"))
            .is_some()
}

/// Decodes a stream into accessors, and returns how many bytes it had and the accessor of each attribute and of the
/// indices.
fn fill(
    document: &mut GltfDocument,
    primitive: &Value,
    stream: &Value,
    filled: &mut Filled,
    left: u64,
) -> Result<(u64, Vec<(String, usize)>), String> {
    let view = number(stream, "bufferView").unwrap_or(usize::MAX);
    let bytes = list(&document.json, "bufferViews").get(view);
    let bytes = bytes.and_then(|view| document.named_bytes(view));
    let bytes = bytes.ok_or("its compressed data reach beyond their buffer")?;
    let limits = DecodeLimits::default()
        .with_max_faces(FACES_A_BYTE.saturating_mul(bytes.len() as u64).min(1 << 28))
        .with_max_decoded_bytes(left.min(2 << 30));
    let mut mesh = draco_core::Mesh::new();
    MeshDecoder::new()
        .decode(
            &mut DecoderBuffer::new(bytes).with_limits(limits),
            &mut mesh,
        )
        .map_err(|e| format!("its compressed data are damaged ({})", short(e.message())))?;
    let points = mesh.num_points();
    let mut total = 0;

    let indices = number(primitive, INDICES).ok_or("it is compressed but has no indices")?;
    let corners = mesh.faces().iter().flatten().map(|point| point.0);
    let (kind, numbers): (u32, Vec<u8>) = match u16::try_from(points) {
        Ok(_) => (
            5123,
            corners.flat_map(|i| (i as u16).to_le_bytes()).collect(),
        ),
        Err(_) => (5125, corners.flat_map(u32::to_le_bytes).collect()),
    };
    total += numbers.len() as u64;
    let shape = json!({ "componentType": kind, "count": 3 * mesh.num_faces() });
    let indices = place(document, indices, &numbers, None, shape, filled, view)?;
    let mut places = vec![(INDICES.to_string(), indices)];

    for (name, id) in stream
        .get("attributes")
        .and_then(Value::as_object)
        .into_iter()
        .flatten()
    {
        let accessor = number(&primitive["attributes"], name);
        let accessor = accessor.ok_or_else(|| format!("{} has no accessor", short(name)))?;
        let attribute = id.as_u64().and_then(|id| u32::try_from(id).ok());
        let attribute = attribute.and_then(|id| mesh.attribute_by_unique_id(id));
        let attribute = attribute.ok_or_else(|| format!("{} is not in its stream", short(name)))?;
        let rows = rows(document, accessor, attribute, points)?;
        total += rows.bytes.len() as u64;
        let mut shape = json!({ "count": points });
        let json = &list(&document.json, "accessors")[accessor];
        for (key, values) in ["min", "max"].into_iter().zip(rows.bounds) {
            // Those of the file are of what was compressed, and decoded numbers are others.
            if json.get(key).is_some() {
                shape[key] = values.into();
            }
        }
        let (bytes, stride) = (&rows.bytes, Some(rows.stride));
        let accessor = place(document, accessor, bytes, stride, shape, filled, view)?;
        places.push((name.clone(), accessor));
    }
    Ok((total, places))
}

/// The decoded numbers of an attribute, in the type of its accessor.
struct Rows {
    bytes: Vec<u8>,
    /// Bytes of the row of a point, a multiple of four.
    stride: usize,
    /// The least and the largest number of each component.
    bounds: [Vec<Value>; 2],
}

/// The numbers of all points.
fn rows(
    document: &GltfDocument,
    accessor: usize,
    attribute: &PointAttribute,
    points: usize,
) -> Result<Rows, String> {
    let none = || format!("accessor {accessor} is of no known type");
    let json = list(&document.json, "accessors")
        .get(accessor)
        .ok_or_else(none)?;
    let (component, kind) = (
        component(json).ok_or_else(none)?,
        kind(json).ok_or_else(none)?,
    );
    let lanes = usize::from(attribute.num_components());
    if lanes != kind.multiplicity() {
        return Err(format!(
            "accessor {accessor} is {kind:?}, but its stream has {lanes} components"
        ));
    }
    let stride = (lanes * component.size()).next_multiple_of(4);
    let width = attribute.data_type().byte_length();
    let step = usize::try_from(attribute.byte_stride()).map_err(|_| none())?;
    let stored = attribute.buffer().data();
    let mut rows = Vec::with_capacity(points * stride);
    let mut bounds = vec![[f64::INFINITY, f64::NEG_INFINITY]; lanes];
    for point in 0..points {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let from = value.checked_mul(step);
        let bytes = from.and_then(|from| stored.get(from..)?.get(..lanes * width));
        let bytes = bytes.ok_or_else(|| format!("accessor {accessor} lacks point {point}"))?;
        for (lane, bounds) in bytes.chunks_exact(width).zip(&mut bounds) {
            let number = write(component, read(attribute.data_type(), lane), &mut rows);
            *bounds = [bounds[0].min(number), bounds[1].max(number)];
        }
        rows.resize((point + 1) * stride, 0);
    }
    let bound = |number: f64| match component {
        ComponentType::F32 => json!(number),
        _ => json!(number as i64),
    };
    let bounds = [0, 1].map(|k| bounds.iter().map(|of| bound(of[k])).collect());
    Ok(Rows {
        bytes: rows,
        stride,
        bounds,
    })
}

/// Gives an accessor its bytes, once, or a copy of it where another stream has filled it; returns which.
fn place(
    document: &mut GltfDocument,
    accessor: usize,
    bytes: &[u8],
    stride: Option<usize>,
    shape: Value,
    filled: &mut Filled,
    from: usize,
) -> Result<usize, String> {
    let json = list(&document.json, "accessors").get(accessor);
    let json = json.ok_or_else(|| format!("accessor {accessor} does not exist"))?;
    let before = filled.get(&accessor);
    if before == Some(&from) {
        return Ok(accessor);
    }
    if before.is_none() && json.get("bufferView").is_some() {
        return Err(format!(
            "accessor {accessor} has data beside the compressed ones"
        ));
    }
    let mut own = json.clone();
    let is_copy = before.is_some();
    let start = document.append(bytes);
    let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() });
    view["target"] = if stride.is_some() { 34962 } else { 34963 }.into();
    if let Some(stride) = stride {
        view["byteStride"] = stride.into();
    }
    let views = document.json["bufferViews"].as_array_mut();
    let views = views.ok_or("there are no buffer views")?;
    views.push(view);
    own["bufferView"] = (views.len() - 1).into();
    own["byteOffset"] = 0.into();
    for (key, value) in shape.as_object().into_iter().flatten() {
        own[key] = value.clone();
    }
    let accessors = document.json["accessors"].as_array_mut();
    let accessors = accessors.ok_or("there are no accessors")?;
    let place = match is_copy {
        true => {
            accessors.push(own);
            accessors.len() - 1
        }
        false => {
            accessors[accessor] = own;
            accessor
        }
    };
    filled.insert(place, from);
    Ok(place)
}

/// The number that a stream stores; 0 for a type that it should not have.
fn read(kind: DataType, bytes: &[u8]) -> f64 {
    match (kind, bytes) {
        (DataType::Int8, &[a]) => f64::from(a as i8),
        (DataType::Uint8 | DataType::Bool, &[a]) => f64::from(a),
        (DataType::Int16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (DataType::Uint16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (DataType::Int32, &[a, b, c, d]) => f64::from(i32::from_le_bytes([a, b, c, d])),
        (DataType::Uint32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (DataType::Float32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => 0.0,
    }
}

/// Writes a number in the type of an accessor, and returns what stands there: what is out of its range ends at it.
fn write(kind: ComponentType, number: f64, out: &mut Vec<u8>) -> f64 {
    macro_rules! write_as {
        ($kind:ty) => {{
            let number = number as $kind;
            out.extend(number.to_le_bytes());
            f64::from(number)
        }};
    }
    match kind {
        ComponentType::I8 => write_as!(i8),
        ComponentType::U8 => write_as!(u8),
        ComponentType::I16 => write_as!(i16),
        ComponentType::U16 => write_as!(u16),
        ComponentType::U32 => write_as!(u32),
        ComponentType::F32 => write_as!(f32),
    }
}
