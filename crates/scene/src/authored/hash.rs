//! The content hash of a scene that was built in memory.

use super::{AlphaMode, Material, Mesh, MetallicRoughness, Placement, Texture};
use blake3::Hasher;

/// Takes all that was handed over into `hasher`. Every list is preceded by its length, so that no two different inputs
/// give the same bytes; numbers are little-endian, so that every machine gives the same hash.
pub(super) fn update(
    hasher: &mut Hasher,
    meshes: &[Mesh],
    materials: &[Material],
    placements: Option<&[Placement]>,
) {
    count(hasher, meshes.len());
    meshes.iter().for_each(|mesh| self::mesh(hasher, mesh));
    count(hasher, materials.len());
    materials
        .iter()
        .for_each(|material| self::material(hasher, material));
    count(hasher, placements.iter().len());
    if let Some(placements) = placements {
        count(hasher, placements.len());
        placements.iter().for_each(|of| placement(hasher, of));
    }
}

// The patterns below name every field, so that a new one cannot be forgotten.

fn mesh(hasher: &mut Hasher, mesh: &Mesh) {
    let Mesh {
        name,
        positions,
        normals,
        tangents,
        uvs,
        lightmap_uvs,
        colors,
        triangles,
        material,
        transform,
    } = mesh;
    text(hasher, name);
    list(hasher, positions.as_flattened(), f32::to_le_bytes);
    list(hasher, normals.as_flattened(), f32::to_le_bytes);
    list(hasher, tangents.as_flattened(), f32::to_le_bytes);
    list(hasher, uvs.as_flattened(), f32::to_le_bytes);
    list(hasher, lightmap_uvs.as_flattened(), f32::to_le_bytes);
    list(hasher, colors.as_flattened(), f32::to_le_bytes);
    list(hasher, triangles.as_flattened(), u32::to_le_bytes);
    count(hasher, *material);
    list(hasher, transform.as_flattened(), f32::to_le_bytes);
}

fn placement(hasher: &mut Hasher, placement: &Placement) {
    let Placement {
        name,
        mesh,
        transform,
    } = placement;
    text(hasher, name);
    count(hasher, *mesh);
    list(hasher, transform.as_flattened(), f32::to_le_bytes);
}

fn material(hasher: &mut Hasher, material: &Material) {
    let Material {
        name,
        albedo,
        albedo_texture,
        specular,
        exponent,
        metallic_roughness,
        emission,
        emission_texture,
        normal_texture,
        normal_scale,
        alpha,
        alpha_mode,
        double_sided,
    } = material;
    text(hasher, name);
    for color in [albedo, specular, emission] {
        list(hasher, color, f32::to_le_bytes);
    }
    hasher.update(&exponent.to_le_bytes());
    list(hasher, &[*alpha, *normal_scale], f32::to_le_bytes);
    let (mode, cutoff) = match alpha_mode {
        AlphaMode::Opaque => (0, 0.0),
        AlphaMode::Mask { cutoff } => (1, *cutoff),
        AlphaMode::Blend => (2, 0.0),
    };
    hasher.update(&[mode, u8::from(*double_sided)]);
    list(hasher, &[cutoff], f32::to_le_bytes);
    for picture in [albedo_texture, emission_texture, normal_texture] {
        texture(hasher, picture.as_ref());
    }
    count(hasher, metallic_roughness.iter().len());
    if let Some(of) = metallic_roughness {
        let MetallicRoughness {
            metallic,
            roughness,
            texture: picture,
            dielectric,
        } = of;
        list(hasher, &[*metallic, *roughness], f32::to_le_bytes);
        list(hasher, dielectric, f32::to_le_bytes);
        texture(hasher, picture.as_ref());
    }
}

fn texture(hasher: &mut Hasher, texture: Option<&Texture>) {
    count(hasher, texture.iter().len());
    if let Some(texture) = texture {
        let Texture {
            width,
            height,
            pixels,
        } = texture;
        list(hasher, &[*width, *height], u32::to_le_bytes);
        count(hasher, pixels.len());
        hasher.update(pixels.as_flattened());
    }
}

fn count(hasher: &mut Hasher, count: usize) {
    hasher.update(&(count as u64).to_le_bytes());
}

fn text(hasher: &mut Hasher, text: &str) {
    count(hasher, text.len());
    hasher.update(text.as_bytes());
}

/// The length of a list, then its numbers, some thousand at a time: the hash is fast on long runs of bytes.
fn list<T: Copy>(hasher: &mut Hasher, values: &[T], bytes: fn(T) -> [u8; 4]) {
    count(hasher, values.len());
    let mut run = Vec::with_capacity(4 * values.len().min(4096));
    for values in values.chunks(4096) {
        run.clear();
        run.extend(values.iter().flat_map(|&value| bytes(value)));
        hasher.update(&run);
    }
}
