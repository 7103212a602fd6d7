//! Small scenes for this crate's tests.

use glam::{DAffine3, Vec3};
use rays::{BackendKind, Layout, RayBackend, World, WorldOptions, build};
use scene::{Alpha, Format, Instance, Material, Mesh, MeshOrigin, Scene, Surface};
use std::sync::Arc;

/// A parallelogram and what it is made of.
pub(crate) struct Sheet {
    /// A corner and the two edges that leave it; the front is on the side of their cross product.
    pub place: [Vec3; 3],
    pub albedo: Vec3,
    pub specular: Vec3,
    pub exponent: f64,
    pub emission: Vec3,
}

/// A matt white sheet.
pub(crate) fn white(place: [Vec3; 3]) -> Sheet {
    Sheet {
        place,
        albedo: Vec3::ONE,
        specular: Vec3::ZERO,
        exponent: 0.0,
        emission: Vec3::ZERO,
    }
}

/// The plane y = 0, wide enough to have no end.
pub(crate) fn ground() -> Sheet {
    white([
        Vec3::new(-4096.0, 0.0, -4096.0),
        Vec3::Z * 8192.0,
        Vec3::X * 8192.0,
    ])
}

/// A world of sheets and the backend that needs no library.
pub(crate) fn world(sheets: &[Sheet]) -> (World, Box<dyn RayBackend>) {
    world_of(sheets, Alpha::Opaque)
}

/// A world of a white sheet that stops this share of the rays.
pub(crate) fn see_through(place: [Vec3; 3], factor: f32) -> (World, Box<dyn RayBackend>) {
    world_of(&[white(place)], Alpha::Blend { factor, map: None })
}

fn world_of(sheets: &[Sheet], alpha: Alpha) -> (World, Box<dyn RayBackend>) {
    let mesh = |(number, sheet): (usize, &Sheet)| {
        let [corner, a, b] = sheet.place;
        Mesh {
            name: "sheet".into(),
            positions: vec![corner, corner + a, corner + a + b, corner + b],
            normals: vec![],
            tangents: Vec::new(),
            colors: Vec::new(),
            alphas: Vec::new(),
            uv_sets: vec![],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
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
        name: "sheet".into(),
        mesh: mesh as u32,
        transform: DAffine3::IDENTITY,
        node: 0,
        copy: None,
        casts: true,
        keeps_buried: None,
    };
    let material = |sheet: &Sheet| Material {
        name: "sheet".into(),
        surface: Surface::Phong {
            albedo: sheet.albedo,
            albedo_map: None,
            specular: sheet.specular,
            exponent: sheet.exponent,
        },
        ambient: None,
        emission: sheet.emission,
        emission_map: None,
        transmission: None,
        alpha: alpha.clone(),
        normal_map: None,
        double_sided: true,
    };
    let scene = Scene {
        path: "sheets.obj".into(),
        format: Format::Obj,
        meshes: sheets.iter().enumerate().map(mesh).collect(),
        instances: (0..sheets.len()).map(instance).collect(),
        materials: sheets.iter().map(material).collect(),
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
