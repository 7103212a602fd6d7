//! Small scenes and ready layouts, as plain structs.

use ambake_atlas::{Atlas, Audit, MeshLayout, Placement, UvSource};
use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use scene::{Format, Instance, Material, Mesh, Scene};

pub fn mesh(name: &str, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        name: name.into(),
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// A scene of these meshes; each instance is a mesh, a node and a transform.
pub fn scene(meshes: Vec<Mesh>, instances: &[(u32, u32, DAffine3)]) -> Scene {
    let instance = |&(mesh, node, transform): &(u32, u32, DAffine3)| Instance {
        node,
        ..Instance::new(format!("node {node}"), mesh, transform)
    };
    Scene {
        path: "test".into(),
        format: Format::Obj,
        meshes,
        instances: instances.iter().map(instance).collect(),
        materials: vec![Material::untinted("grey")],
        ..Scene::default()
    }
}

/// One mesh placed once, with a finished layout at these page coordinates (in texels, exact in 32 bits).
pub fn laid_out(texels: &[[f64; 2]], triangles: Vec<[u32; 3]>, page_size: u32) -> (Scene, Atlas) {
    let uv = |t: &[f64; 2]| Vec2::new(t[0] as f32, t[1] as f32) / page_size as f32;
    let uvs: Vec<Vec2> = texels.iter().map(uv).collect();
    let positions = uvs.iter().map(|v| v.extend(0.0)).collect();
    let atlas = Atlas {
        page_size,
        page_count: 1,
        gutter: 2,
        meshes: vec![MeshLayout {
            source_vertices: (0..uvs.len() as u32).collect(),
            uvs,
            triangles: triangles.clone(),
            ..MeshLayout::default()
        }],
        placements: vec![Placement {
            page: 0,
            scale: [1.0; 2],
            offset: [0.0; 2],
        }],
        source: UvSource::Kept { set: 0 },
        audit: Audit::default(),
        density: 1.0,
        chart_count: 1,
        notes: Vec::new(),
    };
    let scene = scene(
        vec![mesh("flat", positions, triangles)],
        &[(0, 0, DAffine3::IDENTITY)],
    );
    (scene, atlas)
}

/// A box of 12 triangles with a full 0..1 set in which each face has its sixth.
pub fn cube() -> Mesh {
    let mut positions = Vec::new();
    let mut uvs = Vec::new();
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in 0..2 {
            let face = (2 * axis + side) as f32;
            let first = positions.len() as u32;
            for (a, b) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                let mut p = [0.0; 3];
                p[axis] = side as f32;
                p[(axis + 1) % 3] = a;
                p[(axis + 2) % 3] = b;
                positions.push(Vec3::from(p));
                let cell = Vec2::new((face % 3.0) / 3.0, (face / 3.0).floor() / 2.0);
                uvs.push(cell + Vec2::new(a, b) * Vec2::new(0.3, 0.45));
            }
            triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    let mut cube = mesh("cube", positions, triangles);
    cube.uv_sets = vec![uvs];
    cube
}

/// A closed bumpy ball of `2 * n * n` or so triangles.
pub fn ball(n: u32) -> Mesh {
    let point = |i: u32, j: u32| {
        let theta = std::f32::consts::PI * i as f32 / n as f32;
        let phi = std::f32::consts::TAU * (j % n) as f32 / n as f32;
        let r = 1.0 + 0.1 * (5.0 * theta).sin() * (3.0 * phi).cos();
        Vec3::new(
            theta.sin() * phi.cos(),
            theta.cos(),
            theta.sin() * phi.sin(),
        ) * r
    };
    let mut positions = vec![point(0, 0), point(n, 0)];
    for i in 1..n {
        positions.extend((0..n).map(|j| point(i, j)));
    }
    let at = |i: u32, j: u32| match i {
        0 => 0,
        i if i == n => 1,
        i => 2 + (i - 1) * n + j % n,
    };
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..n {
            if i > 0 {
                triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            }
            if i + 1 < n {
                triangles.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
            }
        }
    }
    mesh("ball", positions, triangles)
}

pub fn moved(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

pub fn scaled(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(x, y, z)))
}
