//! Takes out of a document what nothing names any more: accessors and views that others took the place of, and their
//! bytes.
//!
//! Numbers change, so every place that names an accessor, a view or a buffer has to be known. A document with an
//! extension that may name one in a place of its own stays as it is.

use super::places::{Each, each_accessor, each_place, each_view, index};
use serde_json::Value;
use std::collections::HashSet;
use std::ops::Range;

/// Extensions whose places of accessors and views are followed here, or that have none.
const KNOWN: [&str; 25] = [
    "EXT_instance_features",
    "EXT_lights_image_based",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_structural_metadata",
    "EXT_texture_astc",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MOZ_lightmap",
    "MSFT_lod",
    "MSFT_texture_dds",
    "VRM",
];
const KNOWN_KINDS: [&str; 3] = ["KHR_materials_", "MSFT_packing_", "VRMC_"];

/// Views and ranges keep their place modulo this, which is what the strictest of them need.
const ALIGNED: usize = 8;

/// The document without what nothing names, and the bytes of its buffer 0, in which all content now stands; `None`
/// where the places of its numbers are not all known, or a view lies outside of its buffer.
///
/// * `buffers`: the content of each buffer; one without content stands for what is compressed elsewhere.
pub fn pruned(json: &Value, buffers: &[&[u8]]) -> Option<(Value, Vec<u8>)> {
    if !is_known(json) {
        return None;
    }
    let mut json = json.clone();
    drop_unnamed(&mut json, "accessors", each_accessor)?;
    drop_unnamed(&mut json, "bufferViews", each_view)?;
    let bytes = compact(&mut json, buffers)?;
    Some((json, bytes))
}

/// True where no object has an extension that is not among the known ones.
fn is_known(json: &Value) -> bool {
    let known = |name: &String| {
        KNOWN.contains(&name.as_str()) || KNOWN_KINDS.iter().any(|kind| name.starts_with(kind))
    };
    match json {
        Value::Array(list) => list.iter().all(is_known),
        Value::Object(map) => {
            let extensions = map.get("extensions").and_then(Value::as_object);
            extensions.is_none_or(|extensions| extensions.keys().all(known))
                && map
                    .iter()
                    .filter(|(key, _)| *key != "extras")
                    .all(|(_, value)| is_known(value))
        }
        _ => true,
    }
}

/// Drops the items of a list that nothing names, and gives the rest their new numbers wherever they are named.
fn drop_unnamed(json: &mut Value, key: &str, each: Each) -> Option<()> {
    let mut named = HashSet::new();
    each(json, &mut |number| named.extend(number.as_u64()));
    let Some(items) = json.get_mut(key) else {
        return named.is_empty().then_some(());
    };
    let items = items.as_array_mut()?;
    if named.iter().any(|number| *number >= items.len() as u64) {
        return None;
    }
    let (mut numbers, mut next) = (Vec::with_capacity(items.len()), 0);
    for old in 0..items.len() as u64 {
        numbers.push(next);
        next += usize::from(named.contains(&old));
    }
    let mut old = 0..;
    items.retain(|_| old.next().is_some_and(|old| named.contains(&old)));
    if items.is_empty() {
        json.as_object_mut()?.shift_remove(key);
    }
    each(json, &mut |number| {
        if let Some(new) = number.as_u64().and_then(|old| numbers.get(old as usize)) {
            *number = (*new).into();
        }
    });
    Some(())
}

/// Moves the bytes that views and their extensions name into buffer 0, drops the buffers that nothing names any more,
/// and returns the bytes.
fn compact(json: &mut Value, buffers: &[&[u8]]) -> Option<Vec<u8>> {
    let mut ranges: Vec<Vec<Range<usize>>> = vec![Vec::new(); buffers.len()];
    let mut empty = HashSet::new();
    let mut is_within = true;
    each_place(json, &mut |place| match range(place, buffers) {
        Some((buffer, _)) if buffers[buffer].is_empty() => {
            empty.insert(buffer);
        }
        Some((buffer, range)) => {
            let start = range.start / ALIGNED * ALIGNED;
            let end = range.end.next_multiple_of(ALIGNED);
            ranges[buffer].push(start..end.min(buffers[buffer].len()));
        }
        None => is_within = false,
    });
    if !is_within || empty.contains(&0) {
        return None;
    }
    // Where the ranges of a buffer begin, there and in the bytes.
    let mut bytes = Vec::new();
    let mut moved: Vec<Vec<[usize; 2]>> = Vec::with_capacity(buffers.len());
    for (content, mut ranges) in buffers.iter().zip(ranges) {
        ranges.sort_unstable_by_key(|range| (range.start, range.end));
        let (mut starts, mut end) = (Vec::new(), 0);
        for range in ranges {
            if starts.is_empty() || range.start > end {
                bytes.resize(bytes.len().next_multiple_of(ALIGNED), 0);
                starts.push([range.start, bytes.len()]);
                end = range.start;
            }
            if range.end > end {
                bytes.extend_from_slice(content.get(end..range.end)?);
                end = range.end;
            }
        }
        moved.push(starts);
    }
    let stay: Vec<usize> = (1..buffers.len())
        .filter(|old| empty.contains(old))
        .collect();
    each_place(json, &mut |place| {
        let Some((buffer, range)) = range(place, buffers) else {
            return;
        };
        if let Some(at) = stay.iter().position(|old| *old == buffer) {
            place["buffer"] = (at + 1).into();
            return;
        }
        let starts = &moved[buffer];
        let before = starts.partition_point(|[start, _]| *start <= range.start);
        if let Some([old, new]) = before.checked_sub(1).map(|k| starts[k]) {
            place["buffer"] = 0.into();
            place["byteOffset"] = (range.start - old + new).into();
        }
    });
    let list = json.get_mut("buffers")?.as_array_mut()?;
    let mut old = 0..;
    list.retain(|_| {
        old.next()
            .is_some_and(|old| old == 0 || stay.contains(&old))
    });
    Some(bytes)
}

/// The buffer of a place, and its bytes there; `None` where they lie outside of it.
fn range(place: &Value, buffers: &[&[u8]]) -> Option<(usize, Range<usize>)> {
    let buffer = index(place, "buffer").filter(|buffer| *buffer < buffers.len())?;
    let start = match place.get("byteOffset") {
        Some(_) => index(place, "byteOffset")?,
        None => 0,
    };
    let end = start.checked_add(index(place, "byteLength")?)?;
    (end <= buffers[buffer].len() || buffers[buffer].is_empty()).then_some((buffer, start..end))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Five accessors over as many views, of which some are named; two buffers, and one that stands for another.
    fn document() -> Value {
        json!({
            "buffers": [{ "byteLength": 40 }, { "byteLength": 16 }, { "byteLength": 99 }],
            "bufferViews": [
                { "buffer": 0, "byteOffset": 0, "byteLength": 8 },
                { "buffer": 0, "byteOffset": 12, "byteLength": 4 },
                { "buffer": 1, "byteLength": 6 },
                { "buffer": 0, "byteOffset": 14, "byteLength": 12 },
                { "buffer": 2, "byteOffset": 20, "byteLength": 8,
                  "extensions": { "EXT_meshopt_compression":
                    { "buffer": 1, "byteOffset": 8, "byteLength": 4 } } },
                { "buffer": 0, "byteOffset": 36, "byteLength": 4 },
            ],
            "accessors": [
                { "bufferView": 0 },
                { "bufferView": 1 },
                { "bufferView": 2, "sparse": { "indices": { "bufferView": 3 }, "values": { "bufferView": 3 } } },
                { "bufferView": 4 },
                { "count": 3 },
            ],
            "meshes": [{ "primitives": [
                { "attributes": { "POSITION": 2 }, "indices": 1, "targets": [{ "NORMAL": 4 }] },
            ] }],
            "skins": [{ "inverseBindMatrices": 3 }],
            "images": [{ "uri": "a.png" }],
        })
    }

    fn buffers() -> [Vec<u8>; 3] {
        [(0..40).collect(), (100..116).collect(), Vec::new()]
    }

    #[test]
    fn what_nothing_names_leaves_and_the_rest_keeps_its_bytes() {
        let buffers = buffers();
        let slices = buffers.each_ref().map(Vec::as_slice);
        let (json, bytes) = pruned(&document(), &slices).expect("all places are known");
        // View 0 and the last one are named by nothing; the others overlap or lie in a second buffer.
        let expected: Vec<u8> = (8..32).chain(100..116).collect();
        assert_eq!(bytes, expected);
        assert_eq!(
            json["bufferViews"],
            json!([
                { "buffer": 0, "byteOffset": 4, "byteLength": 4 },
                { "buffer": 0, "byteOffset": 24, "byteLength": 6 },
                { "buffer": 0, "byteOffset": 6, "byteLength": 12 },
                { "buffer": 1, "byteOffset": 20, "byteLength": 8,
                  "extensions": { "EXT_meshopt_compression":
                    { "buffer": 0, "byteOffset": 32, "byteLength": 4 } } },
            ])
        );
        assert_eq!(
            json["buffers"],
            json!([{ "byteLength": 40 }, { "byteLength": 99 }])
        );
        let primitive = &json["meshes"][0]["primitives"][0];
        assert_eq!(
            *primitive,
            json!({ "attributes": { "POSITION": 1 }, "indices": 0, "targets": [{ "NORMAL": 3 }] })
        );
        assert_eq!(json["skins"][0]["inverseBindMatrices"], 2);
        assert_eq!(
            json["accessors"],
            json!([
                { "bufferView": 0 },
                { "bufferView": 1, "sparse": { "indices": { "bufferView": 2 }, "values": { "bufferView": 2 } } },
                { "bufferView": 3 },
                { "count": 3 },
            ])
        );
    }

    #[test]
    fn a_property_table_and_a_compressed_primitive_keep_their_views() {
        let mut document = document();
        document["extensions"]["EXT_structural_metadata"] =
            json!({ "propertyTables": [{ "properties": { "height": { "values": 5 } } }] });
        let packed = json!({ "bufferView": 0, "attributes": { "POSITION": 4 } });
        document["meshes"][0]["primitives"][0]["extensions"] =
            json!({ "KHR_draco_mesh_compression": packed });
        let buffers = buffers();
        let slices = buffers.each_ref().map(Vec::as_slice);
        let (json, bytes) = pruned(&document, &slices).expect("all places are known");
        let table = &json["extensions"]["EXT_structural_metadata"]["propertyTables"][0];
        assert_eq!(table["properties"]["height"]["values"], 5);
        let expected: Vec<u8> = (0..32).chain(32..40).chain(100..116).collect();
        assert_eq!(bytes, expected);
        let packed =
            &json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
        assert_eq!(
            *packed,
            json!({ "bufferView": 0, "attributes": { "POSITION": 4 } })
        );
    }

    #[test]
    fn a_document_whose_numbers_are_not_all_known_stays_as_it_is() {
        let buffers = buffers();
        let slices = buffers.each_ref().map(Vec::as_slice);
        let mut unknown = document();
        unknown["nodes"] = json!([{ "extensions": { "ACME_curve": { "points": 0 } } }]);
        assert_eq!(pruned(&unknown, &slices), None);
        // The same beside an extension is a program's own note.
        let mut noted = document();
        noted["nodes"] = json!([{ "extras": { "extensions": { "ACME_curve": { "points": 0 } } } }]);
        assert!(pruned(&noted, &slices).is_some());
        let mut outside = document();
        outside["bufferViews"][3]["byteLength"] = 27.into();
        assert_eq!(pruned(&outside, &slices), None);
        let mut absent = document();
        absent["skins"][0]["inverseBindMatrices"] = 5.into();
        assert_eq!(pruned(&absent, &slices), None);
    }
}
