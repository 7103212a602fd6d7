//! Materials of glTF: factors, textures and extensions, and what is said of those that bake black.

use super::support::{Document, F32, U8, U16, png};
use ambake_scene::{Alpha, MaterialModel, Warning, WarningKind};
use glam::Vec3;
use serde_json::{Value, json};

#[test]
fn materials_follow_the_file_and_a_primitive_without_one_is_untinted() {
    let mut document = Document::triangle();
    let uvs = document.floats("VEC2", &[0.; 6]);
    let image = document.view(&png(&[[255, 255, 255, 0], [255, 255, 255, 255]]));
    document.json["images"] = json!([{ "bufferView": image, "mimeType": "image/png" }]);
    document.json["samplers"] = json!([{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }]);
    document.json["textures"] =
        json!([{ "source": 0, "sampler": 0 }, { "extensions": { "KHR_texture_basisu": {} } }]);
    let turned = json!({ "KHR_texture_transform": { "rotation": std::f32::consts::FRAC_PI_2, "scale": [2, 3],
                         "offset": [0.5, 1], "texCoord": 1 } });
    document.json["materials"] = json!([
        {},
        { "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 1, 3, 0.75], "baseColorTexture":
            { "index": 0, "extensions": turned } }, "extensions": { "KHR_materials_ior": { "ior": 2 },
            "KHR_materials_specular": { "specularFactor": 0.5 },
            "KHR_materials_sheen": { "sheenColorFactor": [0, 1, 0] } } },
        { "pbrMetallicRoughness": { "baseColorTexture": { "index": 1 } }, "normalTexture": { "index": 0 } },
    ]);
    let positions = document.primitive()["attributes"]["POSITION"].clone();
    let primitive = |material: Option<u32>, sets: usize| {
        let mut primitive = json!({ "attributes": { "POSITION": positions } });
        (0..sets).for_each(|n| primitive["attributes"][format!("TEXCOORD_{n}")] = json!(uvs));
        material
            .into_iter()
            .for_each(|m| primitive["material"] = json!(m));
        primitive
    };
    let primitives = [
        primitive(Some(1), 2),
        primitive(None, 0),
        primitive(Some(0), 0),
        primitive(Some(1), 1),
        primitive(Some(2), 1),
    ];
    document.json["meshes"] = json!([{ "name": "m", "primitives": primitives }]);
    let scene = document.load().unwrap();

    let MaterialModel::MetallicRoughness {
        metallic,
        roughness,
        base,
        ..
    } = scene.materials[0].surface
    else {
        panic!()
    };
    assert_eq!((metallic, roughness, base), (1.0, 1.0, Vec3::ONE));
    let tinted = &scene.materials[scene.meshes[0].material as usize];
    let MaterialModel::MetallicRoughness {
        base,
        base_map: Some(map),
        dielectric,
        ..
    } = &tinted.surface
    else {
        panic!()
    };
    assert_eq!(*base, Vec3::new(0.5, 1.0, 1.0));
    assert_eq!(*dielectric, Vec3::splat((1.0f64 / 9.0) as f32 * 0.5));
    assert_eq!(
        (map.uv_set, map.linear, map.wrap),
        (
            1,
            false,
            [ambake_scene::Wrap::Clamp, ambake_scene::Wrap::Mirror]
        )
    );
    // A quarter turn counter-clockwise in a picture whose v grows down: u goes to -v, v to u.
    let expected = [[0.0, 3.0, 0.5], [-2.0, 0.0, 1.0]];
    let close = map
        .transform
        .iter()
        .flatten()
        .zip(expected.iter().flatten())
        .all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close, "{:?}", map.transform);
    assert!(matches!(
        tinted.alpha,
        Alpha::Blend {
            factor: 0.75,
            map: Some(_)
        }
    ));

    let untinted = &scene.materials[scene.meshes[1].material as usize];
    assert!(matches!(
        untinted.surface,
        MaterialModel::Phong {
            albedo: Vec3::ONE,
            specular: Vec3::ZERO,
            ..
        }
    ));
    // The fourth primitive has one UV set, its texture reads the second: it gets the material without texture.
    let reduced = &scene.materials[scene.meshes[3].material as usize];
    assert!(matches!(
        reduced.surface,
        MaterialModel::MetallicRoughness { base_map: None, .. }
    ));
    let kinds = [
        WarningKind::UnreadTextures,
        WarningKind::IgnoredExtensions,
        WarningKind::ClampedFactors,
        WarningKind::TexturesWithoutUvs,
        WarningKind::IgnoredNormalMaps,
    ];
    assert_eq!(kinds.map(|kind| scene.warned(kind)), [1, 1, 1, 2, 1]);
}

/// A triangle whose base colour is texture 0.
fn textured(textures: Value, images: impl FnOnce(&mut Document) -> Value) -> Document {
    let mut document = Document::triangle();
    let uvs = document.floats("VEC2", &[0.; 6]);
    document.json["images"] = images(&mut document);
    document.json["textures"] = textures;
    document.json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 },
        "metallicFactor": 0 } }]);
    document.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    document.primitive()["material"] = json!(0);
    document
}

#[test]
fn webp_is_decoded_where_its_extension_alone_names_it() {
    let mut webp = Vec::new();
    image::codecs::webp::WebPEncoder::new_lossless(&mut webp)
        .encode(&[10, 20, 30, 255], 1, 1, image::ExtendedColorType::Rgba8)
        .unwrap();
    let textures = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    let mut document = textured(textures, |document| {
        let view = document.view(&webp);
        json!([{ "bufferView": view, "mimeType": "image/webp" }])
    });
    document.json["extensionsUsed"] = json!(["EXT_texture_webp"]);
    document.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    let scene = document.load().unwrap();
    assert_eq!(scene.images[0].pixels, [[10, 20, 30, 255]]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn textures_that_are_not_read_are_warned_of_and_the_scene_is_loaded() {
    for (extension, format) in [
        ("KHR_texture_basisu", "KTX2"),
        ("EXT_texture_avif", "AVIF"),
        ("MSFT_texture_dds", "DDS"),
    ] {
        let textures = json!([{ "extensions": { extension: { "source": 0 } } }]);
        let mut document = textured(textures, |_| json!([{ "uri": "gone.bin" }]));
        document.json["extensionsUsed"] = json!([extension]);
        document.json["extensionsRequired"] = json!([extension]);
        let scene = document.load().unwrap();
        let unread = |w: &&Warning| w.kind == WarningKind::UnreadTextures;
        let warning = scene.warnings.iter().find(unread).expect(extension);
        assert!(warning.message.contains(format), "{}", warning.message);
        // Its number is no part of the message, so that all such textures are told of in one line.
        assert_eq!(warning.place, "texture 0 of material 0");
        assert!(!warning.message.contains("texture 0"));
        assert!(scene.images.is_empty());
    }
}

#[test]
fn metals_by_omission_are_named_where_they_are_used() {
    let metals = |pbr: Value, used: usize| {
        let mut document = textured(json!([{ "source": 0 }]), |document| {
            let view = document.view(&png(&[[255; 4]]));
            json!([{ "bufferView": view, "mimeType": "image/png" }])
        });
        document.json["materials"] = json!([
            { "name": "two words %", "pbrMetallicRoughness": pbr },
            { "pbrMetallicRoughness": { "metallicFactor": 0 } }
        ]);
        document.primitive()["material"] = json!(used);
        document.load().unwrap().warnings
    };
    for black in [
        json!({}),
        json!({ "metallicFactor": 1, "roughnessFactor": 0.3 }),
    ] {
        let warnings = metals(black.clone(), 0);
        let [warning] = &warnings[..] else {
            panic!("{black}: {warnings:?}")
        };
        assert_eq!(warning.kind, WarningKind::BlackMetals);
        assert_eq!(warning.place, "material `two words %`");
        assert!(warning.message.contains("metallicFactor"), "{warning:?}");
        assert!(metals(black, 1).is_empty(), "nothing wears it");
    }
    let mapped = json!({ "metallicRoughnessTexture": { "index": 0 } });
    for other in [mapped, json!({ "metallicFactor": 0.99 })] {
        assert!(metals(other.clone(), 0).is_empty(), "{other}");
    }
}

#[test]
fn vertex_colours_of_every_type_multiply_base_colour_and_alpha() {
    // Shares of 255: a corner of each.
    let codes = [[255u8, 0, 51, 255], [0, 255, 102, 0], [51, 51, 255, 51]];
    let shares = codes.map(|c| c.map(|c| f32::from(c) / 255.0));
    for lanes in [3, 4] {
        let of = |corner: usize| codes[corner][..lanes].to_vec();
        let bytes: Vec<Vec<u8>> = (0..3).map(of).collect();
        for (component, normalized) in [
            (U8, true),
            (U8, false),
            (U16, true),
            (U16, false),
            (F32, false),
        ] {
            let mut document = Document::triangle();
            let encoded = |code: &u8| match component {
                U8 => vec![*code],
                U16 => (u16::from(*code) * 257).to_le_bytes().to_vec(),
                _ => (f32::from(*code) / 255.0).to_le_bytes().to_vec(),
            };
            // Vertices begin on multiples of four.
            let vertex = |corner: &Vec<u8>| {
                let mut bytes: Vec<u8> = corner.iter().flat_map(encoded).collect();
                bytes.resize(bytes.len().next_multiple_of(4), 0);
                bytes
            };
            let data: Vec<u8> = bytes.iter().flat_map(vertex).collect();
            let color = document.accessor(
                component,
                if lanes == 3 { "VEC3" } else { "VEC4" },
                3,
                &data,
            );
            document.json["accessors"][color]["normalized"] = json!(normalized);
            let view = document.json["accessors"][color]["bufferView"]
                .as_u64()
                .unwrap() as usize;
            document.json["bufferViews"][view]["byteStride"] = json!(data.len() / 3);
            document.primitive()["attributes"]["COLOR_0"] = json!(color);
            let mesh = document.load().unwrap().meshes.remove(0);
            let expected = shares.map(|[r, g, b, _]| Vec3::new(r, g, b));
            assert_eq!(mesh.colors, expected, "{lanes} x {component}");
            let alphas: &[f32] = if lanes == 3 {
                &[]
            } else {
                &shares.map(|c| c[3])
            };
            assert_eq!(mesh.alphas, alphas, "{lanes} x {component}");
        }
    }
    let mut white = Document::triangle();
    let color = white.floats("VEC4", &[1.0; 12]);
    white.primitive()["attributes"]["COLOR_0"] = json!(color);
    let mesh = white.load().unwrap().meshes.remove(0);
    assert!(mesh.colors.is_empty() && mesh.alphas.is_empty());
}

#[test]
fn specular_glossiness_and_transmission_are_read_with_their_textures() {
    let mut document = textured(json!([{ "source": 0 }]), |document| {
        let view = document.view(&png(&[[255, 255, 255, 128]]));
        json!([{ "bufferView": view, "mimeType": "image/png" }])
    });
    let texture = json!({ "index": 0 });
    document.wear(json!([
        { "alphaMode": "MASK", "extensions": { "KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.5, 0.25, 1, 0.75], "diffuseTexture": texture, "specularFactor": [0.25, 0.5, 0],
            "glossinessFactor": 0.5, "specularGlossinessTexture": texture } } },
        { "alphaMode": "BLEND", "extensions": { "KHR_materials_pbrSpecularGlossiness": {} } },
        { "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "KHR_materials_transmission": {
            "transmissionFactor": 0.75, "transmissionTexture": texture } } },
        { "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "KHR_materials_transmission": {} } },
    ]));
    let scene = document.load().unwrap();
    // The second is a mirror.
    let warned = scene.warnings.iter().map(|w| (w.kind, w.place.as_str()));
    assert_eq!(
        warned.collect::<Vec<_>>(),
        [(WarningKind::BlackMetals, "material `material 1`")]
    );
    let MaterialModel::SpecularGlossiness {
        diffuse,
        diffuse_map: Some(_),
        specular,
        glossiness,
        specular_glossiness_map: Some(_),
    } = &scene.materials[0].surface
    else {
        panic!("{:?}", scene.materials[0].surface)
    };
    assert_eq!(
        (*diffuse, *specular, *glossiness),
        (Vec3::new(0.5, 0.25, 1.0), Vec3::new(0.25, 0.5, 0.0), 0.5)
    );
    assert!(matches!(
        scene.materials[0].alpha,
        Alpha::Mask {
            factor: 0.75,
            map: Some(_),
            cutoff: 0.5
        }
    ));
    let MaterialModel::SpecularGlossiness {
        diffuse,
        specular,
        glossiness,
        ..
    } = scene.materials[1].surface
    else {
        panic!()
    };
    assert_eq!(
        (diffuse, specular, glossiness),
        (Vec3::ONE, Vec3::ONE, 1.0),
        "the defaults of its text"
    );
    assert!(
        scene.materials[2]
            .transmission
            .as_ref()
            .is_some_and(|t| t.factor == 0.75 && t.map.is_some())
    );
    assert!(!scene.materials[2].is_opaque());
    assert!(scene.materials[3].is_opaque(), "a factor of 0");
    document.json["materials"][2]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 0, 0, 1]);
    document.json["meshes"][0]["primitives"][0]["material"] = json!(2);
    let scene = document.load().unwrap();
    assert_eq!(
        scene.warned(WarningKind::GreyTransmission),
        1,
        "{:?}",
        scene.warnings
    );
}

#[test]
fn black_metals_are_told_of_by_what_the_file_says() {
    for (pbr, says) in [
        (json!({}), "where no metallicFactor is given"),
        (
            json!({ "metallicFactor": 1 }),
            "all metal by its metallicFactor",
        ),
    ] {
        let mut document = Document::triangle();
        document.json["materials"] = json!([{ "pbrMetallicRoughness": pbr }]);
        document.primitive()["material"] = json!(0);
        let warnings = document.load().unwrap().warnings;
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert_eq!(warnings[0].kind, WarningKind::BlackMetals);
        assert!(
            warnings[0].message.contains(says),
            "{}",
            warnings[0].message
        );
    }
}

#[test]
fn mirrors_are_told_of_as_metals_with_what_makes_them_other() {
    let warnings = |material: &Value| {
        let mut document = Document::triangle();
        document.json["materials"] = json!([material]);
        document.primitive()["material"] = json!(0);
        document.load().unwrap().warnings
    };
    let glossy = |of: Value| json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": of } });
    let with_ior = |metallic: f64, ior: f64| {
        json!({ "pbrMetallicRoughness": { "metallicFactor": metallic },
                "extensions": { "KHR_materials_ior": { "ior": ior } } })
    };
    let diffuse = [0.6, 0.5, 0.4, 1.0];
    for (mirror, says, cure) in [
        (
            glossy(json!({ "diffuseFactor": diffuse })),
            "without a specularFactor",
            "specularFactor of 0.04",
        ),
        (
            glossy(json!({ "specularFactor": [0.2, 1.0, 0.0] })),
            "by its specularFactor",
            "specularFactor of 0.04",
        ),
        (with_ior(0.0, 0.0), "by KHR_materials_ior", "an ior of 1.5"),
    ] {
        let warnings = warnings(&mirror);
        let kinds: Vec<_> = warnings.iter().map(|warning| warning.kind).collect();
        assert_eq!(kinds, [WarningKind::BlackMetals], "{warnings:?}");
        let message = &warnings[0].message;
        assert!(
            message.contains(says) && message.contains(cure),
            "{message}"
        );
    }
    for other in [
        glossy(json!({ "specularFactor": [0.04, 0.04, 0.04] })),
        with_ior(0.0, 1.5),
    ] {
        assert!(warnings(&other).is_empty(), "{other}");
    }
}
