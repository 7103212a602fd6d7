//! Scenes made in memory bake the bytes of the same scenes read from glTF files.

use crate::{
    AlphaMode, Bake, Baked, Bounces, Engine, Layer, Material, Mesh, MetallicRoughness, Model,
    Placement, Scene, Texture,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A quad of two triangles with coordinates for pictures, a normal and a tangent.
fn quad(name: &str, corner: [f32; 3], right: [f32; 3], down: [f32; 3], material: usize) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.name = name.into();
    let at = |s: f32, t: f32| [0, 1, 2].map(|k| corner[k] + right[k] * s + down[k] * t);
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    mesh.positions = corners.map(|[s, t]| at(s, t)).to_vec();
    mesh.uvs = corners.map(|[s, t]| [2.0 * s, 2.0 * t]).to_vec();
    let (r, d) = (glam::Vec3::from(right), glam::Vec3::from(down));
    mesh.normals = vec![d.cross(r).normalize().to_array(); 4];
    mesh.tangents = vec![r.normalize().extend(1.0).to_array(); 4];
    mesh.triangles = vec![[0, 3, 2], [0, 2, 1]];
    mesh.material = material;
    mesh
}

/// A picture whose pixels are all different.
fn picture(seed: u32) -> Texture {
    let byte = |k: u32| (k.wrapping_mul(2_654_435_761) >> 21) as u8;
    let pixel = |k: u32| [0, 1, 2, 3].map(|c| byte(64 * seed + 4 * k + c).max(1));
    Texture::new(4, 2, (0..8).map(pixel).collect())
}

/// A picture of normals that lean a little.
fn normals() -> Texture {
    let lean = |k: u8| [128 + 9 * (k % 3), 120 + 5 * k, 240, 255];
    Texture::new(4, 2, (0..8).map(lean).collect())
}

fn saved(folder: &Path, name: &str, texture: &Texture) {
    let bytes = texture.pixels.as_flattened().to_vec();
    let image = image::RgbaImage::from_raw(texture.width, texture.height, bytes);
    let saved = image.expect("as many pixels").save(folder.join(name));
    saved.expect("a writable folder");
}

/// A glTF file of these meshes; `rest` has nodes, materials, textures and images.
fn file(folder: &Path, meshes: &[Mesh], rest: Value) -> PathBuf {
    let (mut bin, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    let mut accessor = |bytes: Vec<u8>, count: usize, component: u32, kind: &str, more: Value| {
        let view = json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len() });
        bin.extend(bytes);
        let mut value = json!({ "bufferView": views.len(), "componentType": component, "count": count, "type": kind });
        for (key, of) in more.as_object().into_iter().flatten() {
            value[key] = of.clone();
        }
        views.push(view);
        accessors.push(value);
        accessors.len() - 1
    };
    let floats = |values: &[f32]| {
        values
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let mut list = Vec::new();
    for mesh in meshes {
        let count = mesh.positions.len();
        let bound = |pick: fn(f32, f32) -> f32| {
            let places = mesh.positions.iter().copied();
            places.reduce(|a, b| [0, 1, 2].map(|k| pick(a[k], b[k])))
        };
        let bounds = json!({ "min": bound(f32::min), "max": bound(f32::max) });
        let positions = floats(mesh.positions.as_flattened());
        let mut attributes =
            json!({ "POSITION": accessor(positions, count, 5126, "VEC3", bounds) });
        let others = [
            ("NORMAL", "VEC3", mesh.normals.as_flattened()),
            ("TANGENT", "VEC4", mesh.tangents.as_flattened()),
            ("TEXCOORD_0", "VEC2", mesh.uvs.as_flattened()),
            ("TEXCOORD_1", "VEC2", mesh.lightmap_uvs.as_flattened()),
            ("COLOR_0", "VEC4", mesh.colors.as_flattened()),
        ];
        for (name, kind, values) in others.into_iter().filter(|of| !of.2.is_empty()) {
            attributes[name] = accessor(floats(values), count, 5126, kind, json!({})).into();
        }
        let indices = mesh.triangles.as_flattened();
        let bytes = indices.iter().flat_map(|v| v.to_le_bytes()).collect();
        let indices = accessor(bytes, indices.len(), 5125, "SCALAR", json!({}));
        let primitive =
            json!({ "attributes": attributes, "indices": indices, "material": mesh.material });
        list.push(json!({ "name": mesh.name, "primitives": [primitive] }));
    }
    let nodes = rest["nodes"].as_array().map_or(0, Vec::len);
    let mut document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes).collect::<Vec<_>>() }],
        "meshes": list,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "uri": "scene.bin", "byteLength": bin.len() }],
    });
    for (key, value) in rest.as_object().into_iter().flatten() {
        document[key] = value.clone();
    }
    let path = folder.join("scene.gltf");
    std::fs::write(folder.join("scene.bin"), bin).expect("a writable folder");
    std::fs::write(&path, document.to_string()).expect("a writable folder");
    path
}

/// All layers of all pages have the same bits.
fn assert_same(built: &Baked, read: &Baked) {
    assert_eq!(built.pages().len(), read.pages().len());
    for (a, b) in built.pages().zip(read.pages()) {
        let layers: Vec<Layer> = a.layers().collect();
        assert_eq!(layers, b.layers().collect::<Vec<_>>());
        for layer in layers {
            let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            let same = bits(a.layer(layer)) == bits(b.layer(layer));
            assert!(same, "{} of page {}", layer.name(), a.number());
        }
    }
}

#[test]
fn materials_in_memory_bake_the_bytes_of_a_gltf_file() {
    let mut metal = Material::default();
    metal.name = "metal".into();
    metal.albedo = [0.75, 0.5, 0.25];
    metal.albedo_texture = Some(picture(1));
    let mut of = MetallicRoughness::default();
    (of.metallic, of.roughness, of.texture) = (0.5, 0.75, Some(picture(2)));
    metal.metallic_roughness = Some(of.clone());
    metal.normal_texture = Some(normals());
    metal.normal_scale = 0.5;
    metal.double_sided = false;
    let mut lamp = Material::default();
    lamp.name = "lamp".into();
    lamp.emission = [0.5, 1.0, 0.25];
    lamp.emission_texture = Some(picture(3));
    let mut leaf = Material::default();
    leaf.name = "leaf".into();
    leaf.albedo_texture = Some(picture(4));
    leaf.alpha = 0.75;
    let mut plain = MetallicRoughness::default();
    plain.dielectric = [0.04; 3];
    lamp.metallic_roughness = Some(plain.clone());
    leaf.metallic_roughness = Some(plain);
    let mut cut = leaf.clone();
    cut.name = "cut".into();
    leaf.alpha_mode = AlphaMode::Blend;
    cut.alpha_mode = AlphaMode::Mask { cutoff: 0.25 };

    let (right, down) = ([2.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    let mut tinted = quad("cut", [1.5, 0.75, -1.0], [1.0, 0.0, 0.0], down, 3);
    tinted.colors = vec![
        [0.5, 0.25, 1.0, 1.0],
        [1.0; 4],
        [1.0, 1.0, 0.5, 0.5],
        [1.0; 4],
    ];
    let meshes = vec![
        quad("floor", [-1.0, 0.0, -1.0], right, down, 0),
        quad("lamp", [-1.0, 1.5, -1.0], right, [0.0, -1.0, 0.0], 1),
        quad(
            "leaf",
            [-0.5, 0.5, -0.5],
            [1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            2,
        ),
        tinted,
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let pictures = [picture(1), picture(2), picture(3), picture(4), normals()];
    for (number, picture) in pictures.iter().enumerate() {
        saved(folder.path(), &format!("{number}.png"), picture);
    }
    let rough = |base: Value| {
        let mut pbr = json!({ "metallicFactor": 0.0, "roughnessFactor": 1.0 });
        for (key, value) in base.as_object().into_iter().flatten() {
            pbr[key] = value.clone();
        }
        pbr
    };
    let alpha = || {
        rough(
            json!({ "baseColorFactor": [1.0, 1.0, 1.0, 0.75], "baseColorTexture": { "index": 3 } }),
        )
    };
    let rest = json!({
        "nodes": (0..4).map(|mesh| json!({ "mesh": mesh })).collect::<Vec<_>>(),
        "images": (0..5).map(|n| json!({ "uri": format!("{n}.png") })).collect::<Vec<_>>(),
        "textures": (0..5).map(|n| json!({ "source": n })).collect::<Vec<_>>(),
        "materials": [
            {
                "name": "metal",
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.75, 0.5, 0.25, 1.0], "baseColorTexture": { "index": 0 },
                    "metallicFactor": 0.5, "roughnessFactor": 0.75, "metallicRoughnessTexture": { "index": 1 },
                },
                "normalTexture": { "index": 4, "scale": 0.5 },
            },
            {
                "name": "lamp", "pbrMetallicRoughness": rough(json!({})), "doubleSided": true,
                "emissiveFactor": [0.5, 1.0, 0.25], "emissiveTexture": { "index": 2 },
            },
            { "name": "leaf", "pbrMetallicRoughness": alpha(), "doubleSided": true, "alphaMode": "BLEND" },
            {
                "name": "cut", "pbrMetallicRoughness": alpha(), "doubleSided": true,
                "alphaMode": "MASK", "alphaCutoff": 0.25,
            },
        ],
    });
    let read = crate::load(file(folder.path(), &meshes, rest)).expect("the file loads");
    let built = Scene::from_meshes(meshes, vec![metal, lamp, leaf, cut]).expect("a scene");
    let bake = |scene: &Scene| {
        let bake = Bake::new(scene).size(64).rays(16).normal_maps(true);
        let bake = bake
            .bounces(Bounces::Most(1))
            .layers([Layer::Normal, Layer::Albedo]);
        bake.run(&()).expect("it bakes")
    };
    let (built, read) = (bake(&built), bake(&read));
    assert_eq!(built.job().options().model, Some(Model::Ggx));
    assert_same(&built, &read);
    // The pictures count: without one of them something is another.
    let irradiance = built.page(0).layer(Layer::Irradiance);
    assert!(irradiance.iter().any(|v| *v > 0.0));
}

#[test]
fn placements_share_a_mesh_and_bake_the_bytes_of_a_gltf_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let slab = quad(
        "slab",
        [-1.0, 0.0, -1.0],
        [2.0, 0.0, 0.0],
        [0.0, 0.0, 2.0],
        0,
    );
    let unused = quad("unused", [0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0);
    let place = |name: &str, mesh, scale: f32, at: [f32; 3]| {
        let mut placement = Placement::default();
        (placement.name, placement.mesh) = (name.into(), mesh);
        (0..3).for_each(|k| placement.transform[k][k] = scale);
        placement.transform[3] = [at[0], at[1], at[2], 1.0];
        placement
    };
    let placements = vec![
        place("ground", 0, 2.0, [0.0, 0.0, 0.0]),
        place("table", 0, 0.5, [0.25, 0.5, 0.0]),
        place("shelf", 0, 0.25, [-1.0, 0.75, 0.5]),
    ];
    let nodes: Vec<Value> = (placements.iter())
        .map(|of| json!({ "name": of.name, "mesh": 0, "matrix": of.transform.as_flattened() }))
        .collect();
    let grey = json!({ "baseColorFactor": [0.5, 0.5, 0.5, 1.0], "metallicFactor": 0.0 });
    let rest = json!({
        "nodes": nodes,
        "materials": [{ "pbrMetallicRoughness": grey, "doubleSided": true }],
    });
    let read = crate::load(file(folder.path(), std::slice::from_ref(&slab), rest))
        .expect("the file loads");
    let mut grey = Material::default();
    grey.albedo = [0.5; 3];
    grey.metallic_roughness = Some(MetallicRoughness::default());
    let built = Scene::from_placements(vec![slab, unused], vec![grey], placements);
    let built = built.expect("a scene");
    assert_eq!((built.meshes.len(), built.instances.len()), (1, 3));
    let bake = |scene: &Scene| {
        let bake = Bake::new(scene).size(64).rays(16).layers([Layer::Object]);
        bake.run(&()).expect("it bakes")
    };
    let (built, read) = (bake(&built), bake(&read));
    assert_same(&built, &read);
    let names: Vec<String> = built.objects().map(|object| object.name).collect();
    assert_eq!(names, ["ground", "table", "shelf"]);
    let path = folder.path().join("built.glb");
    built.write_gltf(&path).expect("a writable folder");
    let written = crate::load(&path).expect("the file loads");
    let places =
        |scene: &Scene| -> Vec<_> { scene.instances.iter().map(|of| of.transform).collect() };
    assert_eq!(places(&written), places(built.job().scene()));
    // One layout, a rectangle each.
    let atlas = built.job().atlas();
    assert_eq!((atlas.meshes.len(), atlas.placements.len()), (1, 3));
}

#[test]
fn light_in_memory_is_what_engine_files_hold() {
    let quads = [
        quad("floor", [0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0),
        quad("wall", [0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], 0),
    ];
    let scene = Scene::from_meshes(quads.into(), vec![Material::default()]).expect("a scene");
    let sky = [1.0, 0.5, 2.0];
    let bake = Bake::new(&scene).size(64).rays(8).mips(2).sky(sky);
    let baked = bake.for_engines([Engine::Bevy]).run(&()).expect("it bakes");
    let levels = baked.light(0).expect("it has a diffuse term");
    assert_eq!(
        levels.iter().map(|level| level.size).collect::<Vec<_>>(),
        [64, 32, 16]
    );
    let page = baked.page(0);
    let (coverage, diffuse) = (page.layer(Layer::Coverage), page.layer(Layer::Diffuse));
    for (texel, pixel) in levels[0]
        .pixels
        .iter()
        .enumerate()
        .filter(|(at, _)| coverage[*at] > 0.0)
    {
        assert_eq!(*pixel, sky.map(|sky| sky * diffuse[texel]));
    }

    // The smallest level stands first in the file, the page last.
    let folder = tempfile::tempdir().expect("a folder");
    baked.write(folder.path()).expect("it is written");
    let mut names = std::fs::read_dir(folder.path())
        .expect("a folder")
        .map(|entry| entry.expect("a file").path());
    let file = names
        .find(|name| name.extension().is_some_and(|end| end == "ktx2"))
        .expect("a KTX2 file");
    let file = std::fs::read(file).expect("it is read");
    let halves = levels.iter().rev().flat_map(|level| level.half_floats());
    let bytes: Vec<u8> = halves.flatten().flat_map(u16::to_le_bytes).collect();
    assert!(
        file.ends_with(&bytes),
        "{} bytes of {}",
        bytes.len(),
        file.len()
    );
}
