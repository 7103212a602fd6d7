//! Small scenes for this crate's tests.

use glam::{DAffine3, DVec3, Vec3};
use rays::{BackendKind, Layout, RayBackend, World, WorldOptions, build};
use scene::{Alpha, Format, Instance, Material, Mesh, MeshOrigin, Scene, Surface};
use std::sync::Arc;

/// Parallelograms of one material: a corner and the two edges that leave it, the front on the side of their cross product.
pub(crate) struct Sheets {
    pub places: Vec<[DVec3; 3]>,
    pub albedo: f32,
    pub emission: f32,
}

/// A box with its corners here, its faces outward.
pub(crate) fn block(low: DVec3, high: DVec3) -> Vec<[DVec3; 3]> {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * (high - low));
    vec![
        [low, y, x],
        [low, z, y],
        [low, x, z],
        [high, -x, -y],
        [high, -y, -z],
        [high, -z, -x],
    ]
}

/// The same with its faces inward.
pub(crate) fn room(low: DVec3, high: DVec3) -> Vec<[DVec3; 3]> {
    let turned = |[corner, a, b]: [DVec3; 3]| [corner, b, a];
    block(low, high).into_iter().map(turned).collect()
}

/// A world of one-sided sheets, each an object, and the backend that needs no library.
pub(crate) fn world(all: &[Sheets]) -> (World, Box<dyn RayBackend>) {
    let mesh = |(number, sheets): (usize, &Sheets)| {
        let corners =
            |&[corner, a, b]: &[DVec3; 3]| [corner, corner + a, corner + a + b, corner + b];
        let positions: Vec<DVec3> = sheets.places.iter().flat_map(corners).collect();
        // Corners that meet are one, so that bodies are closed.
        let mut shared: Vec<Vec3> = Vec::new();
        let index: Vec<u32> = positions
            .iter()
            .map(|position| {
                let position = position.as_vec3();
                let known = shared.iter().position(|old| *old == position);
                known.unwrap_or_else(|| {
                    shared.push(position);
                    shared.len() - 1
                }) as u32
            })
            .collect();
        let triangles = index
            .chunks_exact(4)
            .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
        Mesh {
            name: "sheets".into(),
            triangles: triangles.collect(),
            positions: shared,
            normals: vec![],
            tangents: Vec::new(),
            colors: Vec::new(),
            alphas: Vec::new(),
            uv_sets: vec![],
            source_triangles: vec![],
            source_vertices: vec![],
            material: number as u32,
            origin: MeshOrigin {
                mesh: number as u32,
                primitive: 0,
            },
        }
    };
    let instance = |mesh: usize| Instance {
        name: "sheets".into(),
        mesh: mesh as u32,
        transform: DAffine3::IDENTITY,
        node: 0,
        copy: None,
        casts: true,
        keeps_buried: None,
    };
    let material = |sheets: &Sheets| Material {
        name: "sheets".into(),
        surface: Surface::Phong {
            albedo: Vec3::splat(sheets.albedo),
            albedo_map: None,
            specular: Vec3::ZERO,
            exponent: 0.0,
        },
        ambient: None,
        emission: Vec3::splat(sheets.emission),
        emission_map: None,
        transmission: None,
        alpha: Alpha::Opaque,
        normal_map: None,
        double_sided: false,
    };
    let scene = Scene {
        path: "sheets.obj".into(),
        format: Format::Obj,
        meshes: all.iter().enumerate().map(mesh).collect(),
        instances: (0..all.len()).map(instance).collect(),
        materials: all.iter().map(material).collect(),
        images: vec![],
        packed_images: Vec::new(),
        lights: Vec::new(),
        warnings: vec![],
        content_hash: String::new(),
        source: None,
        inputs: Vec::new(),
    };
    let options = WorldOptions {
        instancing: false,
        alpha_test_all: false,
    };
    let world = World::new(Arc::new(scene), options).unwrap();
    let backend = build(BackendKind::Obvhs(Layout::Cwbvh), &world, 1).unwrap();
    (world, backend)
}
