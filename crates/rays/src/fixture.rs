//! Small scenes for unit tests.

use crate::mix::Mix;
use glam::{DAffine3, Vec2, Vec3};
use scene::{Alpha, Format, Image, Instance, Material, Mesh, Scene, TextureRef, Wrap};
use std::sync::Arc;

/// A mesh without normals or UV sets, of material 0.
pub(crate) fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        name: "mesh".into(),
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// Triangles that share no vertices.
pub(crate) fn soup(corners: &[[Vec3; 3]]) -> Mesh {
    let triangles = (0..corners.len() as u32)
        .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
        .collect();
    mesh(corners.iter().flatten().copied().collect(), triangles)
}

/// The box about `center` with these half edges, its faces outward, or inward where `inward`.
pub(crate) fn block(center: Vec3, half: Vec3, inward: bool) -> Mesh {
    let corner = |k: u32| {
        let sign = |axis: u32| if k >> axis & 1 == 0 { -1.0 } else { 1.0 };
        center + half * Vec3::new(sign(0), sign(1), sign(2))
    };
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| match inward {
        false => [[a, b, c], [a, c, d]],
        true => [[a, c, b], [a, d, c]],
    });
    mesh((0..8).map(corner).collect(), triangles.collect())
}

/// The square -1..=1 in x and y at height z, its front up, as two triangles with UVs 0..=1.
pub(crate) fn square(z: f32) -> Mesh {
    let corners = [
        Vec2::new(-1.0, -1.0),
        Vec2::new(1.0, -1.0),
        Vec2::new(1.0, 1.0),
        Vec2::new(-1.0, 1.0),
    ];
    let mut mesh = mesh(
        corners.iter().map(|corner| corner.extend(z)).collect(),
        vec![[0, 1, 2], [0, 2, 3]],
    );
    mesh.uv_sets
        .push(corners.iter().map(|corner| (*corner + 1.0) * 0.5).collect());
    mesh
}

/// A scene of meshes, each an instance without a transform, with one opaque material.
pub(crate) fn scene(meshes: Vec<Mesh>) -> Scene {
    let placed = (0..meshes.len() as u32)
        .map(|mesh| (mesh, DAffine3::IDENTITY))
        .collect::<Vec<_>>();
    placed_scene(meshes, &placed)
}

/// A scene of meshes and their placements, with one opaque material.
pub(crate) fn placed_scene(meshes: Vec<Mesh>, placed: &[(u32, DAffine3)]) -> Scene {
    let instance = |&(mesh, transform)| Instance::new("object", mesh, transform);
    Scene {
        path: "fixture.obj".into(),
        format: Format::Obj,
        meshes,
        instances: placed.iter().map(instance).collect(),
        materials: vec![Material::untinted("matt")],
        ..Scene::default()
    }
}

/// Masks material 0 by a picture of two texels: the left half of every mesh is a hole, the right half is there.
pub(crate) fn mask_left_half(scene: &mut Scene) {
    scene.images = vec![Image {
        name: "mask".into(),
        width: 2,
        height: 1,
        pixels: vec![[255, 255, 255, 0], [255, 255, 255, 255]],
    }];
    let map = TextureRef {
        wrap: [Wrap::Clamp; 2],
        linear: false,
        ..TextureRef::new(0)
    };
    scene.materials[0].alpha = Alpha::Mask {
        cutoff: 0.5,
        factor: 1.0,
        map: Some(map),
    };
}

/// A sphere of `3 * 4^levels * 8 / 3` triangles: an octahedron, divided and pushed out, closed and with shared
/// vertices.
pub(crate) fn sphere(levels: u32) -> Mesh {
    let mut positions = vec![
        Vec3::X,
        Vec3::NEG_X,
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::Z,
        Vec3::NEG_Z,
    ];
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    mesh(positions, triangles)
}

/// A deterministic stream of numbers in 0..1.
pub(crate) struct Dice(pub Mix);

impl Dice {
    pub fn roll(&mut self) -> f32 {
        self.0.unit() as f32
    }

    /// A point of the cube -1..1.
    pub fn point(&mut self) -> Vec3 {
        Vec3::new(self.roll(), self.roll(), self.roll()) * 2.0 - 1.0
    }
}

/// A world of the scene with instancing and alpha tests.
pub(crate) fn world(scene: Scene) -> crate::world::World {
    let options = crate::world::WorldOptions::default();
    crate::world::World::new(Arc::new(scene), options).expect("fixtures fit single precision")
}
