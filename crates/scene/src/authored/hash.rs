//! The content hash of a scene that was built in memory.

use super::{Material, Mesh, Texture};
use blake3::Hasher;

/// Takes all that was handed over into `hasher`. Every list is preceded by its length, so that no two different inputs
/// give the same bytes; numbers are little-endian, so that every machine gives the same hash.
pub(super) fn update(hasher: &mut Hasher, meshes: &[Mesh], materials: &[Material]) {
    count(hasher, meshes.len());
    meshes.iter().for_each(|mesh| self::mesh(hasher, mesh));
    count(hasher, materials.len());
    materials
        .iter()
        .for_each(|material| self::material(hasher, material));
}

// The patterns below name every field, so that a new one cannot be forgotten.

fn mesh(hasher: &mut Hasher, mesh: &Mesh) {
    let Mesh {
        name,
        positions,
        normals,
        uvs,
        triangles,
        material,
        transform,
    } = mesh;
    text(hasher, name);
    list(hasher, positions.as_flattened(), f32::to_le_bytes);
    list(hasher, normals.as_flattened(), f32::to_le_bytes);
    list(hasher, uvs.as_flattened(), f32::to_le_bytes);
    list(hasher, triangles.as_flattened(), u32::to_le_bytes);
    count(hasher, *material);
    list(hasher, transform.as_flattened(), f32::to_le_bytes);
}

fn material(hasher: &mut Hasher, material: &Material) {
    let Material {
        name,
        albedo,
        albedo_texture,
        specular,
        exponent,
        emission,
        alpha,
        alpha_cutoff,
        double_sided,
    } = material;
    text(hasher, name);
    for color in [albedo, specular, emission] {
        list(hasher, color, f32::to_le_bytes);
    }
    hasher.update(&exponent.to_le_bytes());
    hasher.update(&alpha.to_le_bytes());
    list(hasher, alpha_cutoff.as_slice(), f32::to_le_bytes);
    hasher.update(&[u8::from(*double_sided)]);
    count(hasher, albedo_texture.iter().len());
    if let Some(texture) = albedo_texture {
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
