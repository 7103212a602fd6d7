//! The places of a glTF document that hold the number of something else of it.

use serde_json::{Map, Value};

/// Calls what it is given with every place that names one kind of thing.
pub(crate) type Each = fn(&mut Value, &mut dyn FnMut(&mut Value));

/// The items of a list.
pub(crate) fn items<'a>(json: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
    let list = json.get_mut(key).and_then(Value::as_array_mut);
    list.into_iter().flatten()
}

/// The values of an object.
pub(crate) fn values(json: Option<&mut Value>) -> impl Iterator<Item = &mut Value> {
    let map = json.and_then(Value::as_object_mut);
    map.into_iter().flat_map(Map::values_mut)
}

/// Every place that names an accessor.
pub(crate) fn each_accessor(json: &mut Value, at: &mut dyn FnMut(&mut Value)) {
    for primitive in items(json, "meshes").flat_map(|mesh| items(mesh, "primitives")) {
        values(primitive.get_mut("attributes")).for_each(&mut *at);
        primitive.get_mut("indices").into_iter().for_each(&mut *at);
        items(primitive, "targets").for_each(|target| values(Some(target)).for_each(&mut *at));
    }
    for node in items(json, "nodes") {
        let attributes = node.pointer_mut("/extensions/EXT_mesh_gpu_instancing/attributes");
        values(attributes).for_each(&mut *at);
    }
    items(json, "skins")
        .filter_map(|skin| skin.get_mut("inverseBindMatrices"))
        .for_each(&mut *at);
    for sampler in items(json, "animations").flat_map(|animation| items(animation, "samplers")) {
        for key in ["input", "output"] {
            sampler.get_mut(key).into_iter().for_each(&mut *at);
        }
    }
}

/// Every place that names a view.
pub(crate) fn each_view(json: &mut Value, at: &mut dyn FnMut(&mut Value)) {
    for accessor in items(json, "accessors") {
        for place in [
            "/bufferView",
            "/sparse/indices/bufferView",
            "/sparse/values/bufferView",
        ] {
            accessor.pointer_mut(place).into_iter().for_each(&mut *at);
        }
    }
    items(json, "images")
        .filter_map(|image| image.get_mut("bufferView"))
        .for_each(&mut *at);
    for primitive in items(json, "meshes").flat_map(|mesh| items(mesh, "primitives")) {
        let packed = primitive.pointer_mut("/extensions/KHR_draco_mesh_compression/bufferView");
        packed.into_iter().for_each(&mut *at);
    }
    let metadata = json.pointer_mut("/extensions/EXT_structural_metadata");
    for table in metadata
        .into_iter()
        .flat_map(|all| items(all, "propertyTables"))
    {
        for property in values(table.get_mut("properties")) {
            for key in ["values", "arrayOffsets", "stringOffsets"] {
                property.get_mut(key).into_iter().for_each(&mut *at);
            }
        }
    }
}

/// Every view, and every extension of one, that names bytes of a buffer.
pub(crate) fn each_place(json: &mut Value, at: &mut dyn FnMut(&mut Value)) {
    for view in items(json, "bufferViews") {
        let inner = values(view.get_mut("extensions"));
        inner
            .filter(|place| place.get("buffer").is_some())
            .for_each(&mut *at);
        at(view);
    }
}

/// An index stored under `key`.
pub(crate) fn index(value: &Value, key: &str) -> Option<usize> {
    usize::try_from(value.get(key)?.as_u64()?).ok()
}
