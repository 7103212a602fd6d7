//! What a bake can do without refuses no file, however broken it is: it is as if it were not there, and told of where
//! something that is baked names it.

use super::support::{Document, F32, Folder, U8, png, push};
use ambake_scene::WarningKind::{
    self, BrokenParts, IgnoredExtensions, MissingNormalMaps, MissingTextures, MorphTargets,
    OtherScenes, Skins, TexturesWithoutUvs, UnreadTextures, UvSetsAfterAGap,
};
use ambake_scene::{MaterialModel, Scene};
use glam::Vec3;
use serde_json::{Value, json};

/// A unit square of two triangles: a texture of one sRGB grey over a base colour of 0.5, matt.
fn square() -> Document {
    let mut document = Document::square();
    let uvs = document.floats("VEC2", &[0., 0., 1., 0., 1., 1., 0., 1.]);
    let indices = document.accessor(U8, "SCALAR", 6, &[0, 1, 2, 0, 2, 3]);
    let view = document.view(&png(&[[GREY, GREY, GREY, 255]]));
    let primitive = document.primitive();
    primitive["attributes"]["TEXCOORD_0"] = json!(uvs);
    primitive["indices"] = json!(indices);
    document.json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    document.json["samplers"] = json!([{}]);
    document.json["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    let pbr = json!({ "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0, "baseColorTexture": { "index": 0 } });
    document.wear(json!([{ "name": "paint", "pbrMetallicRoughness": pbr }]));
    document
}

const GREY: u8 = 188;

/// sRGB's own formula.
fn grey() -> f32 {
    ((f64::from(GREY) / 255.0 + 0.055) / 1.055).powf(2.4) as f32
}

/// The sum over objects of the areas of their triangles in the world.
fn area(scene: &Scene) -> f64 {
    let object = |instance: &ambake_scene::Instance| -> f64 {
        let mesh = &scene.meshes[instance.mesh as usize];
        let at = |i: u32| {
            let place = mesh.positions[i as usize].as_dvec3();
            instance.transform.transform_point3(place)
        };
        let triangle = |t: &[u32; 3]| {
            let [a, b, c] = t.map(at);
            (b - a).cross(c - a).length() / 2.0
        };
        mesh.triangles.iter().map(triangle).sum()
    };
    scene.instances.iter().map(object).sum()
}

/// Base colour times the mean of its texture, of the material of mesh 0.
fn base(scene: &Scene) -> Vec3 {
    match &scene.materials[scene.meshes[0].material as usize].surface {
        MaterialModel::MetallicRoughness { base, base_map, .. } => base_map
            .as_ref()
            .map_or(*base, |map| *base * scene.mean_color(map)),
        MaterialModel::Phong { albedo, .. } => *albedo,
        other => panic!("{other:?}"),
    }
}

/// The base colour that is left.
#[derive(Clone, Copy, PartialEq)]
enum Base {
    Whole,
    /// The factor alone.
    Factor,
    /// The picture alone.
    Picture,
    /// No material.
    White,
}

/// What is broken, how, what is counted, and what is left of the base colour.
type Case = (&'static str, fn(&mut Value), &'static [WarningKind], Base);

/// A node, a mesh and a primitive of the scene.
fn node(json: &mut Value) -> &mut Value {
    &mut json["nodes"][0]
}

fn primitive(json: &mut Value) -> &mut Value {
    &mut json["meshes"][0]["primitives"][0]
}

fn material(json: &mut Value) -> &mut Value {
    &mut json["materials"][0]
}

fn pbr(json: &mut Value) -> &mut Value {
    &mut material(json)["pbrMetallicRoughness"]
}

/// Adds an image with a texture for it, and returns the texture's number.
fn texture(json: &mut Value, image: Value) -> usize {
    let source = push(&mut json["images"], image);
    push(&mut json["textures"], json!({ "source": source }))
}

const FAR: &str = "https://example.com/gone.png";

const CASES: &[Case] = &[
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
    // Materials.
    (
        "a material that is not there",
        |j| primitive(j)["material"] = json!(3),
        &[BrokenParts],
        Base::White,
    ),
    (
        "a material by a word",
        |j| primitive(j)["material"] = json!("paint"),
        &[BrokenParts],
        Base::White,
    ),
    (
        "an alpha mode that is none",
        |j| material(j)["alphaMode"] = json!("GLASS"),
        &[BrokenParts],
        Base::Whole,
    ),
    (
        "factors that are no numbers",
        |j| {
            material(j)["emissiveFactor"] = json!([1, "x", 0]);
            pbr(j)["roughnessFactor"] = json!("smooth");
            material(j)["doubleSided"] = json!(1);
            material(j)["alphaCutoff"] = json!("half");
        },
        &[BrokenParts; 4],
        Base::Whole,
    ),
    (
        "a base colour of three numbers",
        |j| pbr(j)["baseColorFactor"] = json!([0.5, 0.5, 0.5]),
        &[BrokenParts],
        Base::Picture,
    ),
    (
        "extensions of a material",
        |j| {
            material(j)["extensions"] = json!({ "KHR_materials_ior": { "ior": "glass" }, "KHR_materials_specular": 3,
            "KHR_materials_emissive_strength": { "emissiveStrength": [] },
            "KHR_materials_transmission": { "transmissionFactor": {} } });
        },
        &[BrokenParts; 4],
        Base::Whole,
    ),
    (
        "a normal texture that is not there",
        |j| material(j)["normalTexture"] = json!({ "index": 9 }),
        &[MissingNormalMaps],
        Base::Whole,
    ),
    (
        "a normal texture far away",
        |j| {
            let index = texture(j, json!({ "uri": FAR }));
            material(j)["normalTexture"] = json!({ "index": index, "scale": "high" });
        },
        &[BrokenParts, MissingNormalMaps],
        Base::Whole,
    ),
    // Textures.
    (
        "a texture that is not there",
        |j| pbr(j)["baseColorTexture"]["index"] = json!(9),
        &[MissingTextures],
        Base::Factor,
    ),
    (
        "a texture by a word",
        |j| pbr(j)["baseColorTexture"]["index"] = json!("wood"),
        &[BrokenParts],
        Base::Factor,
    ),
    (
        "a texture that is a number",
        |j| pbr(j)["baseColorTexture"] = json!(0),
        &[BrokenParts],
        Base::Factor,
    ),
    (
        "a texture whose picture is not there",
        |j| j["textures"][0]["source"] = json!(9),
        &[MissingTextures],
        Base::Factor,
    ),
    (
        "a texture without a picture",
        |j| j["textures"][0] = json!({}),
        &[UnreadTextures],
        Base::Factor,
    ),
    (
        "a sampler of no known kind",
        |j| j["samplers"][0] = json!({ "wrapS": 1, "magFilter": "soft", "minFilter": 7 }),
        &[BrokenParts; 2],
        Base::Whole,
    ),
    (
        "a sampler that is not there",
        |j| j["textures"][0]["sampler"] = json!(4),
        &[BrokenParts],
        Base::Whole,
    ),
    (
        "a texture transform in words",
        |j| {
            let moved = json!({ "KHR_texture_transform": { "scale": "2 2", "rotation": "90", "texCoord": "second" } });
            pbr(j)["baseColorTexture"]["extensions"] = moved;
        },
        &[BrokenParts; 3],
        Base::Whole,
    ),
    (
        "a set of coordinates by a word",
        |j| pbr(j)["baseColorTexture"]["texCoord"] = json!("first"),
        &[BrokenParts],
        Base::Whole,
    ),
    // Pictures.
    (
        "a picture far away",
        |j| j["images"][0] = json!({ "uri": FAR }),
        &[MissingTextures],
        Base::Factor,
    ),
    (
        "a picture that is none",
        |j| j["images"][0] = json!({ "uri": "data:image/png;base64,AAAA" }),
        &[MissingTextures],
        Base::Factor,
    ),
    (
        "a picture without a byte",
        |j| j["images"][0] = json!({ "uri": "data:image/png;base64," }),
        &[MissingTextures],
        Base::Factor,
    ),
    (
        "a picture that is not base64",
        |j| j["images"][0] = json!({ "uri": "data:image/png;base64,?" }),
        &[MissingTextures],
        Base::Factor,
    ),
    (
        "a picture beyond its buffer",
        |j| j["bufferViews"][4]["byteLength"] = json!(1 << 30),
        &[MissingTextures],
        Base::Factor,
    ),
    (
        "a picture that ends early",
        |j| j["bufferViews"][4]["byteLength"] = json!(40),
        &[MissingTextures],
        Base::Factor,
    ),
    (
        "a picture in a view that is not there",
        |j| j["images"][0] = json!({ "bufferView": 99 }),
        &[MissingTextures],
        Base::Factor,
    ),
    (
        "a picture from nowhere",
        |j| j["images"][0] = json!({}),
        &[MissingTextures],
        Base::Factor,
    ),
    (
        "pictures that are no list",
        |j| j["images"] = json!("none"),
        &[BrokenParts, MissingTextures],
        Base::Factor,
    ),
    (
        "materials that are no list",
        |j| j["materials"] = json!(7),
        &[BrokenParts, BrokenParts],
        Base::White,
    ),
];

#[test]
fn what_a_bake_can_do_without_refuses_no_file() {
    let mut wrong = Vec::new();
    for (what, edit, kinds, left) in CASES {
        let mut document = square();
        edit(&mut document.json);
        let scene = match Folder::new().load("scene.glb", document.glb()) {
            Ok(scene) => scene,
            Err(error) => {
                wrong.push(format!("{what}: {error}"));
                continue;
            }
        };
        let found: Vec<WarningKind> = scene.warnings.iter().map(|w| w.kind).collect();
        if found != *kinds {
            wrong.push(format!("{what}: {:?}", scene.warnings));
        }
        let expected = match left {
            Base::Whole => 0.5 * grey(),
            Base::Factor => 0.5,
            Base::Picture => grey(),
            Base::White => 1.0,
        };
        let off = (base(&scene) - Vec3::splat(expected)).abs().max_element();
        if scene.instances.len() != 1 || area(&scene) != 1.0 || off > 1e-6 {
            let area = area(&scene);
            wrong.push(format!("{what}: area {area}, base colour {}", base(&scene)));
        }
        for warning in &scene.warnings {
            let line = format!("{}: {}", warning.place, warning.message);
            if line.contains('\n') || line.len() > 300 {
                wrong.push(format!("{what}: {line}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn references_to_what_is_not_there_do_not_reach_a_writer() {
    let mut document = square();
    let json = &mut document.json;
    push(
        &mut json["meshes"],
        json!({ "primitives": [{ "attributes": { "POSITION": 99, "NORMAL": 0 }, "material": 9 }] }),
    );
    push(&mut json["nodes"], json!({ "mesh": 9, "children": [0, 9] }));
    push(
        &mut json["materials"],
        json!({ "normalTexture": { "index": 9 }, "occlusionTexture": { "index": 0 } }),
    );
    primitive(json)["extensions"] = json!({ "KHR_materials_variants":
        { "mappings": [{ "material": 9, "variants": [0] }, { "material": 1, "variants": [1] }] } });
    let scene = document.load().unwrap();
    let kept = &scene.source.as_ref().unwrap().json;
    assert_eq!(
        kept["meshes"][1]["primitives"],
        json!([{ "attributes": { "NORMAL": 0 } }])
    );
    assert_eq!(kept["nodes"][1], json!({ "children": [0] }));
    assert_eq!(
        kept["materials"][1],
        json!({ "occlusionTexture": { "index": 0 } })
    );
    let variants = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings";
    assert_eq!(
        kept.pointer(variants),
        Some(&json!([{ "material": 1, "variants": [1] }]))
    );
    assert_eq!(
        kept["meshes"][0]["primitives"][0]["attributes"],
        document.json["meshes"][0]["primitives"][0]["attributes"]
    );
}
