//! The surface where a ray met it, for callers that shade hits or send rays on.

use crate::backend::SurfaceHit;
use crate::material::{PhongMaterial, emission_at, material_at};
use crate::panes::relative;
use crate::surface::{Patch, PlaneErrors};
use crate::world::World;
use glam::{DVec3, Vec3};

/// Turns hits into surface points.
#[derive(Debug)]
pub struct Surfaces<'a> {
    world: &'a World,
    errors: PlaneErrors,
}

/// A point of a surface as seen from one side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// World position.
    pub position: DVec3,
    /// Unit geometric normal on the side of the viewer.
    pub geometric: DVec3,
    /// Unit shading normal, on the same side of the surface; bent by the material's normal map where the world has read
    /// them.
    pub normal: DVec3,
    /// Origin of rays that leave the surface on that side; it cannot meet the own triangle.
    pub origin: [f32; 3],
    /// Phong parameters.
    pub material: PhongMaterial,
    /// Radiance that the surface sends out by itself.
    pub emission: DVec3,
}

impl<'a> Surfaces<'a> {
    /// The surfaces of a world.
    pub fn new(world: &'a World) -> Self {
        Self {
            world,
            errors: PlaneErrors::of(world),
        }
    }

    /// The world.
    pub fn world(&self) -> &'a World {
        self.world
    }

    /// The surface at a hit, seen by an eye in the direction `toward` (of any length): normals are those of the side
    /// that the eye sees. The point keeps the rounding bound away from its triangle's edges.
    pub fn at(&self, hit: &SurfaceHit, toward: DVec3) -> SurfacePoint {
        let patch = Patch::of(self.world, &self.errors, hit.instance, hit.triangle);
        let [b, c] = hit.barycentric.map(f64::from);
        let weights = patch.kept_inside(DVec3::new(1.0 - b - c, b, c).max(DVec3::ZERO));
        let position = patch.position(weights);
        let up = patch.geometric;
        let side = if up.dot(toward) < 0.0 { -1.0 } else { 1.0 };
        let geometric = up * side;
        let bent = self.world.bent_at(hit.instance, hit.triangle, weights);
        let normal = (bent.unwrap_or_else(|| patch.normal(weights)) * side)
            .try_normalize()
            .unwrap_or(geometric);
        let scene = self.world.scene();
        SurfacePoint {
            position,
            geometric,
            normal,
            origin: (position + geometric * patch.offset(position.abs()))
                .as_vec3()
                .to_array(),
            material: material_at(scene, hit.instance, hit.triangle, weights.to_array()),
            emission: emission_at(scene, hit),
        }
    }

    /// True where an eye in the direction `toward`, of any length, sees the side of a surface that its shading normals
    /// are on.
    pub fn shows_front(&self, hit: &SurfaceHit, toward: DVec3) -> bool {
        let patch = Patch::of(self.world, &self.errors, hit.instance, hit.triangle);
        patch.geometric.dot(toward) > 0.0
    }

    /// False where the surface at a hit sends out no light by itself.
    pub fn may_shine(&self, hit: &SurfaceHit) -> bool {
        let scene = self.world.scene();
        let mesh = &scene.meshes[scene.instances[hit.instance as usize].mesh as usize];
        scene.materials[mesh.material as usize].emission != Vec3::ZERO
    }

    /// The share of the light that the surface stops at a hit, 0..=1.
    pub fn stopped(&self, hit: &SurfaceHit) -> f32 {
        let alpha = self.world.part(hit.instance).1.alpha.as_ref();
        alpha.map_or(1.0, |alpha| alpha.stopped(hit.triangle, hit.barycentric))
    }

    /// What the surface at a hit leaves of the channels of light that passes it, for their mean.
    pub fn tint(&self, hit: &SurfaceHit) -> Vec3 {
        match self.world.has_tints() {
            true => relative(self.world.passing(hit)),
            false => Vec3::ONE,
        }
    }

    /// Radiance that the surface at a hit sends out by itself toward the side from which it was met, linear RGB.
    pub fn emission(&self, hit: &SurfaceHit) -> DVec3 {
        emission_at(self.world.scene(), hit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use glam::Vec3;

    #[test]
    fn a_hit_has_the_place_and_the_normals_of_the_side_that_is_seen() {
        let mut mesh = fixture::square(3.0);
        mesh.normals = vec![Vec3::Z, Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::Z];
        let world = fixture::world(fixture::scene(vec![mesh]));
        let hit = SurfaceHit {
            t: 1.0,
            instance: 0,
            triangle: 0,
            barycentric: [0.25, 0.5],
            front: true,
        };
        for side in [1.0, -1.0] {
            let point = Surfaces::new(&world).at(&hit, DVec3::Z * side);
            // 1/4 of (-1, -1), 1/4 of (1, -1), 1/2 of (1, 1).
            let off = point.position - DVec3::new(0.5, 0.0, 3.0);
            assert!(off.length() < 1e-12, "{}", point.position);
            assert_eq!(point.geometric, DVec3::Z * side);
            let expected = DVec3::new(0.3, 0.0, 0.9).normalize() * side;
            assert!(
                (point.normal - expected).length() < 1e-7,
                "{}",
                point.normal
            );
            assert!((f64::from(point.origin[2]) - 3.0) * side >= 0.0);
            assert_eq!(
                Surfaces::new(&world).shows_front(&hit, DVec3::Z * side),
                side > 0.0
            );
        }
    }
}
