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
    /// Number of the object. A pixel is shaded as one object: other objects behind its edge do not bend what it
    /// reflects.
    pub object: u32,
    /// Number of its shader in the list that the picture is shaded by.
    pub shader: u32,
    /// What its mirrored ray meets, where its shader is traced.
    pub mirrored: Option<Mirrored>,
}

/// What the mirrored ray of a surface meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mirrored {
    /// Nothing but the environment in this unit direction.
    Environment(DVec3),
    /// A surface, which is shaded from its own tables.
    Surface(Reflected),
}

/// A surface that is seen in a mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflected {
    /// Unit shading normal on the side of the mirror.
    pub normal: DVec3,
    /// Unit direction back along the ray.
    pub view: DVec3,
    /// kd and ks.
    pub reflectances: [DVec3; 2],
    /// Exponent of the lobe.
    pub exponent: f64,
    /// Number of its shader.
    pub shader: u32,
}

/// How the objects of an instance are shaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Shading {
    /// Number of the shader.
    pub shader: u32,
    /// Its mirrored rays are traced.
    pub traced: bool,
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
    /// How each instance of the scene is shaded; those beyond the end by the first shader.
    pub shadings: &'a [Shading],
}

impl Subject<'_> {
    /// The surface that a ray from `eye` in a unit direction meets first; `None` where it meets none.
    pub fn hit(&self, eye: DVec3, direction: DVec3) -> Option<Surfel> {
        let (mut surfel, geometric, origin) = self.meet(eye.as_vec3().to_array(), direction)?;
        if self.shading(surfel.object).traced {
            let along = |n: DVec3| direction - n * (2.0 * direction.dot(n));
            // Where a shading normal sends the ray into the surface, the plane of the triangle mirrors it.
            let bent = along(surfel.normal);
            let toward = match bent.dot(geometric) > 0.0 {
                true => bent,
                false => along(geometric),
            };
            let toward = toward.normalize();
            surfel.mirrored = Some(match self.meet(origin, toward) {
                None => Mirrored::Environment(toward),
                Some((met, ..)) => Mirrored::Surface(Reflected {
                    normal: met.normal,
                    view: -toward,
                    reflectances: [met.albedo, met.specular],
                    exponent: met.exponent,
                    shader: met.shader,
                }),
            });
        }
        Some(surfel)
    }

    /// What a ray meets, the geometric normal there, and where rays leave it.
    fn meet(&self, origin: [f32; 3], direction: DVec3) -> Option<(Surfel, DVec3, [f32; 3])> {
        let hit = self.backend.closest(&Ray {
            origin,
            direction: direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        })?;
        let point = self.surfaces.at(&hit, -direction);
        let material = self.overrides.applied(point.material);
        let surfel = Surfel {
            normal: point.normal,
            albedo: material.albedo,
            specular: material.specular,
            exponent: material.exponent,
            object: hit.instance,
            shader: self.shading(hit.instance).shader,
            mirrored: None,
        };
        Some((surfel, point.geometric, point.origin))
    }

    fn shading(&self, instance: u32) -> Shading {
        let shading = self.shadings.get(instance as usize);
        shading.copied().unwrap_or_default()
    }
}
