//! What a texel's footprint is made of: its patches, its mean material and its mean position and normals.

use crate::integrate::term;
use crate::options::Overrides;
use crate::surface::{Patch, PlaneErrors, Sample};
use crate::world::World;
use ambient::sampling::Stream;
use atlas::{Footprint, Tile};
use glam::{DVec2, DVec3, Vec2, Vec3};
use scene::{Scene, Surface};

/// Sample points over the footprint from which means of materials and normals are taken.
const SURVEY_POINTS: u32 = 16;

/// Parameters of the Phong model, averaged over the footprint.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TexelMaterial {
    /// Linear RGB.
    pub albedo: DVec3,
    /// Linear RGB.
    pub specular: DVec3,
    /// Lobe exponent.
    pub exponent: f64,
}

/// A texel ready to be integrated.
pub(crate) struct Survey<'a> {
    pub tile: &'a Tile,
    pub footprint: &'a Footprint,
    patches: Vec<Patch>,
    pub material: TexelMaterial,
    pub position: DVec3,
    pub normal: DVec3,
    pub geometric: DVec3,
    /// Object with the largest share of the footprint.
    pub object: u32,
}

impl<'a> Survey<'a> {
    /// Looks at the footprint at a few points.
    pub fn of(
        world: &World,
        errors: &PlaneErrors,
        overrides: &Overrides,
        tile: &'a Tile,
        footprint: &'a Footprint,
        stream: impl Fn(u32) -> Stream,
    ) -> Self {
        let mut patches: Vec<Patch> = Vec::new();
        let mut largest = (0.0, 0u32);
        let mut before = 0.0;
        for piece in &tile.pieces[footprint.pieces.start as usize..footprint.pieces.end as usize] {
            if !patches
                .iter()
                .any(|p| p.instance == piece.instance && p.triangle == piece.triangle)
            {
                patches.push(Patch::of(world, errors, piece.instance, piece.triangle));
            }
            let share = piece.cumulative - before;
            before = piece.cumulative;
            if share > largest.0 {
                largest = (share, piece.instance);
            }
        }
        let mut survey = Self {
            tile,
            footprint,
            patches,
            material: TexelMaterial::default(),
            position: DVec3::ZERO,
            normal: DVec3::ZERO,
            geometric: DVec3::ZERO,
            object: largest.1,
        };
        survey.average(world, overrides, &stream(term::SURVEY));
        survey
    }

    /// The surface at the footprint's point `u` of the unit square.
    pub fn sample(&self, u: [f64; 2]) -> Sample {
        let point = self.tile.sample(self.footprint, u);
        self.patch(point.instance, point.triangle)
            .sample(point.weights)
    }

    /// The patches that meet the footprint.
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    fn patch(&self, instance: u32, triangle: u32) -> &Patch {
        match self.patches.as_slice() {
            [only] => only,
            patches => patches
                .iter()
                .find(|p| p.instance == instance && p.triangle == triangle)
                .expect("every piece of the footprint has its patch"),
        }
    }

    fn average(&mut self, world: &World, overrides: &Overrides, stream: &Stream) {
        let mut sum = TexelMaterial::default();
        for index in 0..SURVEY_POINTS {
            let [_, _, u, v] = stream.point(index);
            let point = self.tile.sample(self.footprint, [u, v]);
            let patch = self.patch(point.instance, point.triangle);
            let sample = patch.sample(point.weights);
            self.position += sample.position;
            self.normal += sample.normal;
            self.geometric += sample.geometric;
            let material = material_at(world.scene(), &point);
            sum.albedo += material.albedo;
            sum.specular += material.specular;
            sum.exponent += material.exponent;
        }
        let scale = 1.0 / f64::from(SURVEY_POINTS);
        self.position *= scale;
        self.normal = self
            .normal
            .try_normalize()
            .unwrap_or(self.patches[0].upward());
        self.geometric = self
            .geometric
            .try_normalize()
            .unwrap_or(self.patches[0].upward());
        self.material = TexelMaterial {
            albedo: overrides
                .albedo
                .map_or(sum.albedo * scale, |rgb| Vec3::from(rgb).as_dvec3()),
            specular: overrides
                .specular
                .map_or(sum.specular * scale, |rgb| Vec3::from(rgb).as_dvec3()),
            exponent: overrides.exponent.unwrap_or(sum.exponent * scale),
        };
    }
}

/// The Phong parameters at a surface point.
fn material_at(scene: &Scene, point: &atlas::SurfacePoint) -> TexelMaterial {
    let mesh = &scene.meshes[scene.instances[point.instance as usize].mesh as usize];
    let indices = mesh.triangles[point.triangle as usize];
    let uv = |set: u32| -> Vec2 {
        let Some(uvs) = mesh.uv_sets.get(set as usize) else {
            return Vec2::ZERO;
        };
        let mut sum = DVec2::ZERO;
        for (corner, weight) in indices.iter().zip(point.weights) {
            sum += uvs[*corner as usize].as_dvec2() * weight;
        }
        sum.as_vec2()
    };
    match &scene.materials[mesh.material as usize].surface {
        Surface::Phong {
            albedo,
            albedo_map,
            specular,
            exponent,
        } => {
            let tint = albedo_map
                .as_ref()
                .map_or(Vec3::ONE, |map| scene.color(map, uv(map.uv_set)));
            TexelMaterial {
                albedo: (*albedo * tint).as_dvec3(),
                specular: specular.as_dvec3(),
                exponent: *exponent,
            }
        }
        Surface::MetallicRoughness {
            base,
            base_map,
            metallic,
            roughness,
            metallic_roughness_map,
            dielectric,
        } => {
            let base = *base
                * base_map
                    .as_ref()
                    .map_or(Vec3::ONE, |map| scene.color(map, uv(map.uv_set)));
            let (mut metallic, mut roughness) = (*metallic, *roughness);
            if let Some(map) = metallic_roughness_map {
                let texel = scene.linear_texel(map, uv(map.uv_set));
                metallic *= f64::from(texel.z);
                roughness *= f64::from(texel.y);
            }
            let (albedo, specular, exponent) =
                scene::phong_from_metallic_roughness(base, metallic, roughness, *dielectric);
            TexelMaterial {
                albedo: albedo.as_dvec3(),
                specular: specular.as_dvec3(),
                exponent,
            }
        }
    }
}
