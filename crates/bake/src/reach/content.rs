//! The content of a scene's objects as hashes: what rays see of them, and what their own texels take from them.

use blake3::Hasher;
use rayon::prelude::*;
use rays::World;
use scene::Scene;

/// 128 bits of a blake3 hash: two different contents share one by chance in 2^64 scenes.
pub type Fingerprint = [u8; 16];

/// The first 128 bits.
pub(super) fn short(hasher: &Hasher) -> Fingerprint {
    let mut bytes = [0; 16];
    hasher.finalize_xof().fill(&mut bytes);
    bytes
}

/// A hash that takes small pieces: it hashes many blocks side by side, which needs long ones.
#[derive(Default)]
pub(super) struct Feed {
    hasher: Hasher,
    waiting: Vec<u8>,
}

impl Feed {
    /// Bytes that are hashed at a time.
    const BLOCK: usize = 1 << 16;

    /// Goes on where another hash is.
    pub fn after(hasher: &Hasher) -> Self {
        Self {
            hasher: hasher.clone(),
            waiting: Vec::new(),
        }
    }

    pub fn update(&mut self, bytes: &[u8]) {
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() >= Self::BLOCK {
            self.hasher.update(&self.waiting);
            self.waiting.clear();
        }
    }

    pub fn numbers(&mut self, values: &[f64]) {
        for value in values {
            self.update(&value.to_le_bytes());
        }
    }

    pub fn short(mut self) -> Fingerprint {
        self.hasher.update(&self.waiting);
        short(&self.hasher)
    }
}

/// An object's content.
#[derive(Debug, Clone, Copy)]
pub(super) struct Content {
    /// Everything: triangles, normals, coordinates, material with its pictures, placement.
    pub own: Fingerprint,
    /// What a ray can meet: the triangles in the world and where they let rays through.
    pub seen: Fingerprint,
}

/// The content of each instance of the world's scene.
pub(super) fn contents(world: &World) -> Vec<Content> {
    let scene = world.scene();
    let images: Vec<Fingerprint> = scene
        .images
        .par_iter()
        .map(|image| {
            let mut hasher = Hasher::new();
            hasher.update(&[image.width, image.height].map(u32::to_le_bytes).concat());
            hasher.update(image.pixels.as_flattened());
            short(&hasher)
        })
        .collect();
    let materials: Vec<Fingerprint> = (0..scene.materials.len())
        .into_par_iter()
        .map(|material| surface(scene, material, &images))
        .collect();
    let meshes: Vec<Fingerprint> = scene.meshes.par_iter().map(mesh).collect();
    (0..scene.instances.len() as u32)
        .into_par_iter()
        .map(|instance| {
            let seen = seen(world, instance, &images);
            let placed = &scene.instances[instance as usize];
            let material = scene.meshes[placed.mesh as usize].material as usize;
            let mut own = Hasher::new();
            own.update(&seen);
            own.update(&meshes[placed.mesh as usize]);
            own.update(&materials[material]);
            own.update(&numbers(&placed.transform.to_cols_array()));
            own.update(format!("{:?}", placed.keeps_buried).as_bytes());
            Content {
                own: short(&own),
                seen,
            }
        })
        .collect()
}

/// What a ray can meet of an instance.
fn seen(world: &World, instance: u32, images: &[Fingerprint]) -> Fingerprint {
    let (part, geometry) = world.part(instance);
    let mut hasher = Feed::default();
    if !world.casts(instance) {
        hasher.update(b"unseen");
        return hasher.short();
    }
    for position in geometry.positions.iter() {
        hasher.update(position.to_array().map(f32::to_le_bytes).as_flattened());
    }
    for triangle in geometry.triangles() {
        hasher.update(triangle.map(u32::to_le_bytes).as_flattened());
    }
    if let Some(transform) = part.transform {
        hasher.update(b"carried");
        hasher.update(
            transform
                .to_cols_array()
                .map(f32::to_le_bytes)
                .as_flattened(),
        );
    }
    let mesh = geometry.mesh();
    let material = &world.scene().materials[mesh.material as usize];
    if material.is_opaque() {
        return hasher.short();
    }
    // Which rays a see-through triangle stops depends on the number of its mesh.
    hasher.update(&geometry.mesh.to_le_bytes());
    hasher.update(&surface(world.scene(), mesh.material as usize, images));
    for value in &mesh.alphas {
        hasher.update(&value.to_le_bytes());
    }
    for color in &mesh.colors {
        hasher.update(color.to_array().map(f32::to_le_bytes).as_flattened());
    }
    for uv in mesh.uv_sets.iter().flatten() {
        hasher.update(uv.to_array().map(f32::to_le_bytes).as_flattened());
    }
    hasher.short()
}

/// Every array of a mesh.
fn mesh(mesh: &scene::Mesh) -> Fingerprint {
    let mut hasher = Feed::default();
    let mut array = |values: &mut dyn Iterator<Item = [f32; 4]>| {
        let mut count = 0u64;
        for value in values {
            hasher.update(value.map(f32::to_le_bytes).as_flattened());
            count += 1;
        }
        hasher.update(&count.to_le_bytes());
    };
    array(&mut mesh.positions.iter().map(|p| [p.x, p.y, p.z, 0.0]));
    array(&mut mesh.normals.iter().map(|n| [n.x, n.y, n.z, 0.0]));
    array(&mut mesh.tangents.iter().map(|t| t.to_array()));
    array(&mut mesh.colors.iter().map(|c| [c.x, c.y, c.z, 0.0]));
    array(&mut mesh.alphas.iter().map(|&a| [a, 0.0, 0.0, 0.0]));
    for set in &mesh.uv_sets {
        array(&mut set.iter().map(|uv| [uv.x, uv.y, 0.0, 0.0]));
    }
    for triangle in &mesh.triangles {
        hasher.update(triangle.map(u32::to_le_bytes).as_flattened());
    }
    hasher.short()
}

/// A material but for its name, with the pictures that it reads. The words name every field, so that a new one cannot
/// be forgotten here; the numbers of pictures in them may cost a bake where pictures change places, and never keep what
/// changed.
fn surface(scene: &Scene, material: usize, images: &[Fingerprint]) -> Fingerprint {
    let mut material = scene.materials[material].clone();
    material.name.clear();
    let mut hasher = Hasher::new();
    hasher.update(format!("{material:?}").as_bytes());
    for map in material.textures() {
        hasher.update(&images[map.image as usize]);
    }
    if let Some(map) = &material.normal_map
        && let Some(image) = scene.packed_images.get(map.texture.image as usize)
    {
        hasher.update(image.bytes());
    }
    short(&hasher)
}

/// Numbers as bytes.
pub(super) fn numbers(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feed_of_small_pieces_hashes_what_lies_end_to_end() {
        let bytes: Vec<u8> = (0..200_000u32).map(|k| (k * 7 % 251) as u8).collect();
        let mut begun = Hasher::new();
        begun.update(&bytes[..100]);
        let mut feed = Feed::after(&begun);
        bytes[100..].chunks(12).for_each(|piece| feed.update(piece));
        let mut whole = Hasher::new();
        whole.update(&bytes);
        assert_eq!(feed.short(), short(&whole));
    }
}
