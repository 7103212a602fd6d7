//! Faces of meshes, whose corners are one where their positions are.

use scene::Scene;
use std::collections::HashMap;

/// A triangle of a list of meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Face {
    pub mesh: u32,
    pub triangle: u32,
    /// Its corners run the other way round than the file has them, as those of most of its surface do.
    pub turned: bool,
}

impl Face {
    /// As the file has it.
    pub fn of(mesh: u32, triangle: u32) -> Self {
        Self {
            mesh,
            triangle,
            turned: false,
        }
    }

    pub(super) fn order<T>(self, [a, b, c]: [T; 3]) -> [T; 3] {
        match self.turned {
            true => [a, c, b],
            false => [a, b, c],
        }
    }
}

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
