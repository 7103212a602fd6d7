//! What a camera ray of a table-shaded picture meets.

use glam::DVec3;
use rays::{Overrides, Ray, RayBackend, Surfaces};

/// A surface where a ray met it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surfel {
    /// Unit shading normal on the side of the viewer.
    pub normal: DVec3,
    /// Diffuse reflectance kd.
    pub albedo: DVec3,
    /// Specular reflectance ks.
    pub specular: DVec3,
    /// Exponent of the lobe, for shaders with an S for each of several.
    pub exponent: f64,
    /// Number of the object. A pixel is shaded as one object: other objects behind its edge do not bend what it reflects.
    pub object: u32,
}

/// A scene as camera rays find it.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// What the rays meet.
    pub surfaces: &'a Surfaces<'a>,
    /// Who casts them.
    pub backend: &'a dyn RayBackend,
    /// Values that replace the materials' own.
    pub overrides: Overrides,
}

impl Subject<'_> {
    /// The surface that a ray from `eye` in a unit direction meets first; `None` where it meets none.
    pub fn hit(&self, eye: DVec3, direction: DVec3) -> Option<Surfel> {
        let hit = self.backend.closest(&Ray {
            origin: eye.as_vec3().to_array(),
            direction: direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        })?;
        let point = self.surfaces.at(&hit, -direction);
        let material = self.overrides.applied(point.material);
        Some(Surfel {
            normal: point.normal,
            albedo: material.albedo,
            specular: material.specular,
            exponent: material.exponent,
            object: hit.instance,
        })
    }
}
