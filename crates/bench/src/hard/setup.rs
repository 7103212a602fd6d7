//! A receiving chart and what stands above it, as a scene with its atlas.

use crate::exact::{Open, polygon_form_factor, polygon_solid_angle};
use atlas::{Atlas, Audit, MeshLayout, Placement, UvSource};
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use scene::{Format, Instance, Material, MaterialModel, Mesh, Scene};
use std::f64::consts::TAU;

/// Page edge in texels; the receiver fills the page.
pub(super) const SIZE: u32 = 16;

/// A receiver and its surroundings. The receiver's front is +z before any turn.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Counter-clockwise corners of the receiving quad.
    pub receiver: [DVec3; 4],
    /// Unit shading normal of the receiver; `None` shades flat.
    pub normal: Option<DVec3>,
    /// Triangles that block.
    pub blockers: Vec<[DVec3; 3]>,
    /// Direction from the receiver to the eye; the eye stands 1e6 units away. `None` sees along the normal.
    pub view: Option<DVec3>,
    /// Lobe exponent, asked for only where there is one.
    pub exponent: Option<f64>,
}

impl Setup {
    /// A square receiver of half edge `half` about (x, 0, 0), with nothing above it.
    pub fn at(x: f64, half: f64) -> Self {
        Self::over([x - half, x + half], half)
    }

    /// A receiver that spans `x` and `-half..half` in y, with nothing above it.
    pub fn over(x: [f64; 2], half: f64) -> Self {
        let corner = |x, y| DVec3::new(x, y, 0.0);
        Self {
            receiver: [
                corner(x[0], -half),
                corner(x[1], -half),
                corner(x[1], half),
                corner(x[0], half),
            ],
            normal: None,
            blockers: Vec::new(),
            view: None,
            exponent: None,
        }
    }

    /// With a quad that blocks.
    pub fn quad(mut self, [a, b, c, d]: [[f64; 3]; 4]) -> Self {
        let [a, b, c, d] = [a, b, c, d].map(DVec3::from);
        self.blockers.extend([[a, b, c], [a, c, d]]);
        self
    }

    /// With a horizontal rectangle at `z` that blocks.
    pub fn plate(self, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> Self {
        self.quad([[x0, y0, z], [x0, y1, z], [x1, y1, z], [x1, y0, z]])
    }

    /// With an upright wall of `height` in the plane x = 0, `2 * reach` long.
    pub fn wall(self, height: f64, reach: f64) -> Self {
        let r = reach;
        self.quad([
            [0.0, -r, 0.0],
            [0.0, r, 0.0],
            [0.0, r, height],
            [0.0, -r, height],
        ])
    }

    /// Every point mapped.
    pub fn map(mut self, f: impl Fn(DVec3) -> DVec3) -> Self {
        self.receiver = self.receiver.map(&f);
        for triangle in &mut self.blockers {
            *triangle = triangle.map(&f);
        }
        self
    }

    /// Turned about an axis that is none of the grid's.
    pub fn turned(self) -> Self {
        let turn = DQuat::from_axis_angle(DVec3::new(0.3, 1.0, -0.2).normalize(), 0.7);
        self.map(|p| turn * p)
    }

    /// The middle of the receiver.
    pub fn centre(&self) -> DVec3 {
        self.receiver.iter().sum::<DVec3>() * 0.25
    }

    /// The terms at the middle of an unturned receiver under the triangles as f32 holds them. They must not overlap as
    /// seen from there; of a closed `convex` body only the faces that look at the point are summed.
    pub fn on_triangles(&self, convex: bool) -> Open {
        let mut open = Open::FULL;
        for triangle in &self.blockers {
            let corners = triangle.map(|p| p.as_vec3().as_dvec3() - self.centre());
            let [a, b, c] = corners;
            if convex && (b - a).cross(c - a).dot(a) >= 0.0 {
                continue;
            }
            open.visibility -= polygon_solid_angle(&corners, DVec3::Z) / TAU;
            open.diffuse -= polygon_form_factor(&corners, DVec3::Z);
        }
        open
    }

    /// The scene and where its receiver lies on the page. What blocks has no place there.
    pub fn scene(&self) -> (Scene, Atlas) {
        let corners = self.receiver.map(|p| p.as_vec3());
        let mut receiver = mesh(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
        if let Some(normal) = self.normal {
            receiver.normals = vec![normal.as_vec3(); 4];
        }
        let uvs = vec![Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::X, Vec2::ZERO];
        let mut layouts = vec![MeshLayout {
            source_vertices: vec![0, 1, 2, 3],
            uvs,
            triangles: receiver.triangles.clone(),
            ..MeshLayout::default()
        }];
        let mut meshes = vec![receiver];
        if !self.blockers.is_empty() {
            let positions: Vec<Vec3> = self
                .blockers
                .iter()
                .flatten()
                .map(|p| p.as_vec3())
                .collect();
            let count = positions.len() as u32;
            let triangles: Vec<_> = (0..count / 3)
                .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
                .collect();
            layouts.push(MeshLayout {
                source_vertices: (0..count).collect(),
                uvs: vec![Vec2::ZERO; positions.len()],
                triangles: triangles.clone(),
                ..MeshLayout::default()
            });
            meshes.push(mesh(positions, triangles));
        }
        let placement = Placement {
            page: 0,
            scale: [1.0; 2],
            offset: [0.0; 2],
        };
        let atlas = Atlas {
            page_size: SIZE,
            page_count: 1,
            gutter: 2,
            placements: vec![placement; meshes.len()],
            meshes: layouts,
            source: UvSource::Kept { set: 0 },
            audit: Audit::default(),
            density: 1.0,
            chart_count: 1,
            notes: Vec::new(),
        };
        (scene(meshes), atlas)
    }
}

fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        name: "mesh".into(),
        positions,
        triangles,
        ..Mesh::default()
    }
}

fn scene(meshes: Vec<Mesh>) -> Scene {
    let instances =
        (0..meshes.len() as u32).map(|mesh| Instance::new("object", mesh, DAffine3::IDENTITY));
    Scene {
        path: "hard.obj".into(),
        format: Format::Obj,
        instances: instances.collect(),
        meshes,
        materials: vec![Material {
            surface: MaterialModel::Phong {
                albedo: Vec3::ONE,
                albedo_map: None,
                specular: Vec3::ONE,
                exponent: 0.0,
            },
            // What is baked is the side that a formula is of, also where nobody could look at it.
            double_sided: false,
            ..Material::untinted("matt")
        }],
        ..Scene::default()
    }
}
