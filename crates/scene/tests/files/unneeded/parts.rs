//! What of buffers, nodes and meshes may be broken.

use super::*;

pub const CASES: &[Case] = &[
    ("nothing", |_| (), &[], Base::Whole),
    // What nothing in the scene names.
    (
        "an unused view of a buffer that is not there",
        |j| {
            push(
                &mut j["bufferViews"],
                json!({ "buffer": 7, "byteLength": 1_000_000_000 }),
            );
        },
        &[],
        Base::Whole,
    ),
    (
        "an unused accessor of a type that is none",
        |j| {
            push(
                &mut j["accessors"],
                json!({ "componentType": 1, "type": 5, "count": -3, "bufferView": "x" }),
            );
        },
        &[],
        Base::Whole,
    ),
    (
        "an unused mesh",
        |j| {
            push(
                &mut j["meshes"],
                json!({ "primitives": [{ "attributes": { "POSITION": 99 } }] }),
            );
        },
        &[],
        Base::Whole,
    ),
    (
        "an unused mesh without primitives",
        |j| {
            push(&mut j["meshes"], json!({ "extras": { "ambake": 3 } }));
        },
        &[],
        Base::Whole,
    ),
    (
        "an unused node",
        |j| {
            push(
                &mut j["nodes"],
                json!({ "mesh": 99, "children": [5], "matrix": [] }),
            );
        },
        &[],
        Base::Whole,
    ),
    (
        "an unused scene",
        |j| {
            push(&mut j["scenes"], json!({ "nodes": [77] }));
        },
        &[OtherScenes],
        Base::Whole,
    ),
    (
        "an unused material",
        |j| {
            push(
                &mut j["materials"],
                json!({ "alphaMode": 3, "pbrMetallicRoughness": { "baseColorTexture": { "index": 9 } } }),
            );
        },
        &[],
        Base::Whole,
    ),
    (
        "a picture far away in an unused material",
        |j| {
            let index = texture(j, json!({ "uri": FAR }));
            push(
                &mut j["materials"],
                json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": index } } }),
            );
        },
        &[],
        Base::Whole,
    ),
    (
        "an unused texture, sampler and image",
        |j| {
            push(&mut j["textures"], json!({ "source": 50, "sampler": "x" }));
            push(&mut j["samplers"], json!({ "wrapS": 1, "magFilter": [] }));
            push(&mut j["images"], json!({ "uri": 5 }));
        },
        &[],
        Base::Whole,
    ),
    (
        "an unused node that is no object",
        |j| {
            push(&mut j["nodes"], json!(3));
        },
        &[BrokenParts],
        Base::Whole,
    ),
    // What a bake does not read.
    (
        "animations, skins and cameras",
        |j| {
            let channels = json!([{ "sampler": 9, "target": { "node": 44 } }]);
            j["animations"] = json!([{ "channels": channels, "samplers": [{ "input": 88 }] }, {}]);
            j["skins"] = json!([{ "joints": [99], "inverseBindMatrices": 77, "skeleton": "x" }]);
            j["cameras"] = json!([{ "type": 7, "perspective": "wide" }]);
            node(j)["camera"] = json!("first");
        },
        &[],
        Base::Whole,
    ),
    (
        "a skin that is not there",
        |j| node(j)["skin"] = json!(12),
        &[Skins],
        Base::Whole,
    ),
    (
        "bounds, targets and mime types",
        |j| {
            j["accessors"][0]["min"] = json!("low");
            j["bufferViews"][0]["target"] = json!(1.5);
            j["images"][0]["mimeType"] = json!("text/plain");
        },
        &[],
        Base::Whole,
    ),
    (
        "extras of any kind",
        |j| {
            j["extras"] = json!(5);
            node(j)["extras"] = json!("text");
            primitive(j)["extras"] = json!([1]);
            material(j)["extras"] = json!({ "ambake": "Ks" });
        },
        &[],
        Base::Whole,
    ),
    (
        "morph targets and weights",
        |j| {
            primitive(j)["targets"] = json!([{ "POSITION": 99 }, 7]);
            j["meshes"][0]["weights"] = json!("none");
        },
        &[MorphTargets],
        Base::Whole,
    ),
    (
        "morph targets that are no list",
        |j| primitive(j)["targets"] = json!(3),
        &[],
        Base::Whole,
    ),
    (
        "attributes that are not read",
        |j| {
            primitive(j)["attributes"]["JOINTS_0"] = json!(99);
            primitive(j)["attributes"]["_OWN"] = json!("x");
        },
        &[],
        Base::Whole,
    ),
    (
        "a variant of a material that is not there",
        |j| {
            let mappings = json!([{ "material": 99, "variants": [9] }, 4]);
            primitive(j)["extensions"] =
                json!({ "KHR_materials_variants": { "mappings": mappings } });
        },
        &[],
        Base::Whole,
    ),
    (
        "names of extensions that are no list",
        |j| {
            j["extensionsUsed"] = json!("KHR_draco_mesh_compression");
            j["extensionsRequired"] = json!({});
        },
        &[BrokenParts, BrokenParts],
        Base::Whole,
    ),
    (
        "used extensions that nobody knows",
        |j| j["extensionsUsed"] = json!(["ACME_unheard_of", 7]),
        &[],
        Base::Whole,
    ),
    (
        "extensions that are no object",
        |j| {
            node(j)["extensions"] = json!([1]);
            material(j)["extensions"] = json!("none");
        },
        &[BrokenParts, BrokenParts],
        Base::Whole,
    ),
    (
        "an occlusion texture",
        |j| material(j)["occlusionTexture"] = json!({ "index": "x" }),
        &[],
        Base::Whole,
    ),
    // Names and what holds of a node but its place.
    (
        "names that are numbers",
        |j| {
            node(j)["name"] = json!(7);
            j["meshes"][0]["name"] = json!([]);
            material(j)["name"] = json!(false);
        },
        &[BrokenParts; 3],
        Base::Whole,
    ),
    (
        "a light that is not there",
        |j| {
            node(j)["extensions"] = json!({ "KHR_lights_punctual": { "light": 3 } });
        },
        &[IgnoredExtensions],
        Base::Whole,
    ),
    (
        "a light by a word",
        |j| node(j)["extensions"] = json!({ "KHR_lights_punctual": { "light": "sun" } }),
        &[BrokenParts],
        Base::Whole,
    ),
    (
        "a visibility that is no truth",
        |j| node(j)["extensions"] = json!({ "KHR_node_visibility": { "visible": "no" } }),
        &[BrokenParts],
        Base::Whole,
    ),
    (
        "a default scene by a word",
        |j| j["scene"] = json!("main"),
        &[BrokenParts],
        Base::Whole,
    ),
    // Attributes.
    (
        "tangents that are not there",
        |j| primitive(j)["attributes"]["TANGENT"] = json!(99),
        &[BrokenParts],
        Base::Whole,
    ),
    (
        "normals, one too few",
        |j| {
            let mut accessor = j["accessors"][1].clone();
            accessor["count"] = json!(3);
            let normals = push(&mut j["accessors"], accessor);
            primitive(j)["attributes"]["NORMAL"] = json!(normals);
        },
        &[BrokenParts],
        Base::Whole,
    ),
    (
        "colours beyond their buffer",
        |j| {
            let colors = push(
                &mut j["accessors"],
                json!({ "bufferView": 0, "byteOffset": 1 << 20, "componentType": F32, "type": "VEC4", "count": 4 }),
            );
            primitive(j)["attributes"]["COLOR_0"] = json!(colors);
        },
        &[BrokenParts],
        Base::Whole,
    ),
    (
        "a set of coordinates that nothing uses",
        |j| primitive(j)["attributes"]["TEXCOORD_3"] = json!(99),
        &[UvSetsAfterAGap],
        Base::Whole,
    ),
    (
        "the set of coordinates that the texture reads",
        |j| primitive(j)["attributes"]["TEXCOORD_0"] = json!(99),
        &[BrokenParts, TexturesWithoutUvs],
        Base::Factor,
    ),
];
