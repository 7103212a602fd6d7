//! A glTF document for a scene that came from an OBJ file or was built in memory: vertices in the order of the layout,
//! materials mapped.
//!
//! Base colour is the albedo (Kd, scaled where Kd + Ks is above 1), because engines multiply lightmaps by the base
//! colour. Metallic is 0, and roughness the inverse of [`scene::phong_from_metallic_roughness`]: `roughness = (2n +
//! 1)^(-1/4)`.
//!
//! glTF gives every dielectric a coat that reflects, and takes from the base what it reflects. Readers disagree on how
//! much of a lightmap it takes: Bevy nothing, three.js a share that depends on the view, the standard `max Ks` at
//! normal view. So the coat is off: `specularFactor` of `KHR_materials_specular` is 0. Its colour, Ks / 0.04, stands
//! beside it: a factor of 1 brings the highlights of lamps back. `extras.ambake` holds Ks and Ns, by which ambake reads
//! back the materials of the scene.
//!
//! Metallic-roughness materials of built scenes stand as they are, and so do their normal maps.
//!
//! Ke is the emissive factor, with `KHR_materials_emissive_strength` where a channel is above 1.

use super::document::{Document, Target};
use super::{Origins, Reason};
use crate::preview::encode;
use atlas::Atlas;
use glam::Vec3;
use scene::{Alpha, Format, Image, Material, MaterialModel, Scene, TextureRef, Wrap};
use serde_json::{Value, json};
use std::collections::HashMap;

/// The extension for radiance above 1.
const STRENGTH: &str = "KHR_materials_emissive_strength";

/// The extension for another reflectance of the coat than [`COAT`].
const SPECULAR: &str = "KHR_materials_specular";

/// What the coat of glTF's dielectric reflects at normal view.
const COAT: f32 = 0.04;

/// The document and where it holds the scene: mesh and instance numbers are those of the scene.
pub fn document(scene: &Scene, atlas: &Atlas) -> Result<(Document<'static>, Origins), Reason> {
    let json = json!({
        "asset": { "version": "2.0", "generator": format!("ambake {}", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": (0..scene.instances.len()).collect::<Vec<_>>() }],
    });
    let mut document = Document::empty(json)?;
    let mut textures = HashMap::new();
    for material in &scene.materials {
        let value = material_value(&mut document, &mut textures, scene, material)?;
        document.push("materials", value)?;
    }
    if scene.materials.iter().any(is_coated) {
        document.push("extensionsUsed", SPECULAR.into())?;
    }
    if scene
        .materials
        .iter()
        .any(|m| m.emission.max_element() > 1.0)
    {
        document.push("extensionsUsed", STRENGTH.into())?;
    }
    for (mesh, layout) in scene.meshes.iter().zip(&atlas.meshes) {
        let mut attributes = json!({});
        let gathered: Vec<[f32; 3]> = layout
            .source_vertices
            .iter()
            .map(|&v| mesh.positions[v as usize].into())
            .collect();
        attributes["POSITION"] = document.push_floats(&gathered, true)?.into();
        if !mesh.normals.is_empty() {
            let gathered: Vec<[f32; 3]> = layout
                .source_vertices
                .iter()
                .map(|&v| mesh.normals[v as usize].into())
                .collect();
            attributes["NORMAL"] = document.push_floats(&gathered, false)?.into();
        }
        if !mesh.tangents.is_empty() {
            let tangents = layout.source_vertices.iter();
            let gathered: Vec<[f32; 4]> = tangents
                .map(|&v| mesh.tangents[v as usize].into())
                .collect();
            attributes["TANGENT"] = document.push_floats(&gathered, false)?.into();
        }
        let color = |v: u32| mesh.colors.get(v as usize).copied().unwrap_or(Vec3::ONE);
        if !mesh.alphas.is_empty() {
            let colors = layout.source_vertices.iter();
            let gathered: Vec<[f32; 4]> = colors
                .map(|&v| color(v).extend(mesh.alphas[v as usize]).into())
                .collect();
            attributes["COLOR_0"] = document.push_floats(&gathered, false)?.into();
        } else if !mesh.colors.is_empty() {
            let colors = layout.source_vertices.iter();
            let gathered: Vec<[f32; 3]> = colors.map(|&v| color(v).into()).collect();
            attributes["COLOR_0"] = document.push_floats(&gathered, false)?.into();
        }
        for (set, uvs) in mesh.uv_sets.iter().enumerate() {
            let gathered: Vec<[f32; 2]> = layout
                .source_vertices
                .iter()
                .map(|&v| uvs[v as usize].into())
                .collect();
            attributes[format!("TEXCOORD_{set}")] = document.push_floats(&gathered, false)?.into();
        }
        let indices = document.push_indices(&layout.triangles, layout.uvs.len())?;
        let primitive =
            json!({ "attributes": attributes, "indices": indices, "material": mesh.material });
        document.push(
            "meshes",
            json!({ "name": mesh.name, "primitives": [primitive] }),
        )?;
    }
    for instance in &scene.instances {
        let columns = instance.transform.to_cols_array();
        let [x, y, z, w] = [0, 3, 6, 9].map(|c| &columns[c..c + 3]);
        let mut node = json!({ "name": instance.name, "mesh": instance.mesh });
        if instance.transform != glam::DAffine3::IDENTITY {
            node["matrix"] = [x, &[0.0], y, &[0.0], z, &[0.0], w, &[1.0]].concat().into();
        }
        document.push("nodes", node)?;
    }
    let origins = Origins {
        meshes: (0..scene.meshes.len()).map(|mesh| (mesh, 0)).collect(),
        instances: (0..scene.instances.len())
            .map(|node| (node, None))
            .collect(),
        laid_out: true,
    };
    Ok((document, origins))
}

/// Textures made so far, by colour image, alpha image and wrap rules.
type Textures = HashMap<(Option<u32>, Option<u32>, [u32; 2]), usize>;

fn material_value(
    document: &mut Document,
    textures: &mut Textures,
    scene: &Scene,
    material: &Material,
) -> Result<Value, Reason> {
    let (base, albedo_map) = match &material.surface {
        MaterialModel::Phong {
            albedo, albedo_map, ..
        } => (*albedo, albedo_map.as_ref()),
        MaterialModel::MetallicRoughness { base, base_map, .. } => (*base, base_map.as_ref()),
        MaterialModel::SpecularGlossiness { diffuse, .. } => {
            unreachable!("an OBJ or built material with diffuse colour {diffuse}")
        }
    };
    let base = base.clamp(Vec3::ZERO, Vec3::ONE);
    let (factor, alpha_map) = match &material.alpha {
        Alpha::Opaque => (1.0, None),
        Alpha::Mask { factor, map, .. } | Alpha::Blend { factor, map } => {
            (factor.clamp(0.0, 1.0), map.as_ref())
        }
    };
    let mut value = json!({
        "name": material.name,
        "pbrMetallicRoughness": { "baseColorFactor": [base.x, base.y, base.z, factor] },
    });
    if is_coated(material) {
        value["extensions"] = json!({ SPECULAR: {} });
    }
    match &material.surface {
        MaterialModel::MetallicRoughness {
            metallic,
            roughness,
            metallic_roughness_map,
            dielectric,
            ..
        } => {
            let pbr = &mut value["pbrMetallicRoughness"];
            pbr["metallicFactor"] = json!(metallic);
            pbr["roughnessFactor"] = json!(roughness);
            if let Some(map) = metallic_roughness_map {
                pbr["metallicRoughnessTexture"] = picture(document, textures, scene, map)?;
            }
            if is_coated(material) {
                let color = (*dielectric / COAT).to_array();
                value["extensions"][SPECULAR]["specularColorFactor"] = json!(color);
            }
        }
        MaterialModel::Phong {
            specular, exponent, ..
        } => {
            let specular = specular.clamp(Vec3::ZERO, Vec3::ONE);
            let pbr = &mut value["pbrMetallicRoughness"];
            pbr["metallicFactor"] = json!(0.0);
            pbr["roughnessFactor"] = json!((2.0 * exponent + 1.0).powf(-0.25));
            value["extensions"][SPECULAR]["specularFactor"] = json!(0.0);
            if specular != Vec3::ZERO {
                let color = (specular / COAT).to_array();
                value["extensions"][SPECULAR]["specularColorFactor"] = json!(color);
                value["extras"] =
                    json!({ "ambake": { "Ks": specular.to_array(), "Ns": exponent } });
            }
        }
        MaterialModel::SpecularGlossiness { .. } => {}
    }
    if let Some(any) = albedo_map.or(alpha_map) {
        let texture = base_color(document, textures, scene, any, albedo_map, alpha_map)?;
        value["pbrMetallicRoughness"]["baseColorTexture"] =
            json!({ "index": texture, "texCoord": any.uv_set });
    }
    if material.emission != Vec3::ZERO {
        let strength = material.emission.max_element().max(1.0);
        let factor = material.emission / strength;
        value["emissiveFactor"] = factor.to_array().into();
        if strength > 1.0 {
            value["extensions"][STRENGTH] = json!({ "emissiveStrength": strength });
        }
        if let Some(map) = &material.emission_map {
            value["emissiveTexture"] = picture(document, textures, scene, map)?;
        }
    }
    if let Some(map) = material.normal_map.as_ref()
        && scene.format == Format::Memory
    {
        // Read as every picture of a built scene: repeated and bilinear.
        let packed = &scene.packed_images[map.texture.image as usize];
        let image = scene.normal_image(map).map_err(|e| e.to_string())?;
        let size = [image.width, image.height];
        let png = encode(
            size,
            png::ColorType::Rgba,
            image.pixels.as_flattened(),
            None,
        );
        let view = document.push_view(&png, Target::None)?;
        let image = document.push(
            "images",
            json!({ "name": packed.name, "mimeType": "image/png", "bufferView": view }),
        )?;
        let texture = document.push("textures", json!({ "source": image }))?;
        value["normalTexture"] =
            json!({ "index": texture, "texCoord": map.texture.uv_set, "scale": map.scale });
    }
    match material.alpha {
        Alpha::Opaque => {}
        Alpha::Mask { cutoff, .. } => {
            value["alphaMode"] = "MASK".into();
            value["alphaCutoff"] = cutoff.into();
        }
        Alpha::Blend { .. } => value["alphaMode"] = "BLEND".into(),
    }
    if material.double_sided {
        value["doubleSided"] = true.into();
    }
    Ok(value)
}

/// True where the reflectance of a material's coat is not that of glTF's default.
fn is_coated(material: &Material) -> bool {
    match material.surface {
        MaterialModel::MetallicRoughness { dielectric, .. } => dielectric != Vec3::splat(COAT),
        _ => true,
    }
}

/// The use of a picture with all of its channels.
fn picture(
    document: &mut Document,
    textures: &mut Textures,
    scene: &Scene,
    map: &TextureRef,
) -> Result<Value, Reason> {
    let texture = base_color(document, textures, scene, map, Some(map), Some(map))?;
    Ok(json!({ "index": texture, "texCoord": map.uv_set }))
}

/// The texture that holds colour and alpha together, as glTF wants them.
fn base_color(
    document: &mut Document,
    textures: &mut Textures,
    scene: &Scene,
    any: &TextureRef,
    color: Option<&TextureRef>,
    alpha: Option<&TextureRef>,
) -> Result<usize, Reason> {
    let wrap = any.wrap.map(|wrap| match wrap {
        Wrap::Repeat => 10497,
        Wrap::Clamp => 33071,
        Wrap::Mirror => 33648,
    });
    let key = (color.map(|t| t.image), alpha.map(|t| t.image), wrap);
    if let Some(&texture) = textures.get(&key) {
        return Ok(texture);
    }
    let image = |map: Option<&TextureRef>| map.map(|t| &scene.images[t.image as usize]);
    let (color, alpha) = (image(color), image(alpha));
    let size = color
        .or(alpha)
        .map_or([1, 1], |image| [image.width, image.height]);
    let sample = |image: &Image, x: u32, y: u32| {
        let scale =
            |at: u32, from: u32, to: u32| (u64::from(at) * u64::from(to) / u64::from(from)) as u32;
        let (x, y) = (
            scale(x, size[0], image.width),
            scale(y, size[1], image.height),
        );
        image.pixels[(y * image.width + x) as usize]
    };
    let mut pixels = Vec::with_capacity(size[0] as usize * size[1] as usize * 4);
    for y in 0..size[1] {
        for x in 0..size[0] {
            let [r, g, b, _] = color.map_or([255; 4], |image| sample(image, x, y));
            let a = alpha.map_or(255, |image| sample(image, x, y)[3]);
            pixels.extend([r, g, b, a]);
        }
    }
    let png = encode(size, png::ColorType::Rgba, &pixels, None);
    let view = document.push_view(&png, Target::None)?;
    let name = color.or(alpha).map_or("", |image| &image.name);
    let image = document.push(
        "images",
        json!({ "name": name, "mimeType": "image/png", "bufferView": view }),
    )?;
    let filter = if any.linear { 9729 } else { 9728 };
    let sampler =
        json!({ "magFilter": filter, "minFilter": filter, "wrapS": wrap[0], "wrapT": wrap[1] });
    let sampler = document.push("samplers", sampler)?;
    let texture = document.push("textures", json!({ "sampler": sampler, "source": image }))?;
    textures.insert(key, texture);
    Ok(texture)
}
