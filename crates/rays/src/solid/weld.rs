//! Corners of faces that are one where their positions are.

use super::topology::Face;
use scene::Scene;
use std::collections::HashMap;

/// The corners of faces as numbers that are equal where positions are.
pub(super) fn weld(scene: &Scene, faces: &[Face]) -> Vec<[u32; 3]> {
    let mut numbers: HashMap<[u32; 3], u32, Quick> = HashMap::default();
    let mut of_mesh: Vec<u32> = Vec::new();
    let mut mesh = u32::MAX;
    let mut welded = Vec::with_capacity(faces.len());
    for face in faces {
        let of = &scene.meshes[face.mesh as usize];
        if face.mesh != mesh {
            mesh = face.mesh;
            of_mesh = vec![u32::MAX; of.positions.len()];
        }
        welded.push(
            face.order(of.triangles[face.triangle as usize])
                .map(|vertex| {
                    let known = &mut of_mesh[vertex as usize];
                    if *known == u32::MAX {
                        // Adding 0 makes a negative zero positive.
                        let position = of.positions[vertex as usize] + 0.0;
                        let next = numbers.len() as u32;
                        *known = *numbers
                            .entry(position.to_array().map(f32::to_bits))
                            .or_insert(next);
                    }
                    *known
                }),
        );
    }
    welded
}

/// A fast hash of positions; nobody gains by collisions but in their own bake.
pub(super) type Quick = std::hash::BuildHasherDefault<Mixer>;

#[derive(Default)]
pub(super) struct Mixer(u64);

impl std::hash::Hasher for Mixer {
    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 29
    }

    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(4) {
            let word = chunk
                .iter()
                .fold(0, |word, byte| word << 8 | u64::from(*byte));
            self.write_u64(word);
        }
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}
