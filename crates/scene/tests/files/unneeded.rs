//! What a bake can do without refuses no file, however broken it is: it is as if it were not there, and told of where
//! something that is baked names it.

#[path = "unneeded/looks.rs"]
mod looks;
#[path = "unneeded/parts.rs"]
mod parts;

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

#[test]
fn what_a_bake_can_do_without_refuses_no_file() {
    let mut wrong = Vec::new();
    for (what, edit, kinds, left) in parts::CASES.iter().chain(looks::CASES) {
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
