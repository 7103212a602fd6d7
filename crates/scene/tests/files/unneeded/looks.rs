//! What of materials, textures and pictures may be broken.

use super::*;

pub const CASES: &[Case] = &[
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
