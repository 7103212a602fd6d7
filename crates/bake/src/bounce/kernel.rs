//! What a texel weighs incoming light by: the cosine of its irradiance, or the specular lobe.

use crate::options::Shading;
use crate::survey::Sample;
use ambient::Frame;
use ambient::ggx::{Ggx, alpha_of, frame};
use ambient::sampling::{Lobe, Mixture};
use glam::{DVec2, DVec3};

/// A weight of directions about a surface point, of integral 1 over the directions that it is drawn from.
pub(super) struct Kernel {
    shape: Shape,
    frame: Frame,
}

enum Shape {
    Cosine,
    Lobe(Lobe),
    /// With the albedo of a white mirror.
    Ggx(Ggx, f64),
}

impl Kernel {
    /// The cosine over pi about a normal.
    pub fn cosine(normal: DVec3) -> Self {
        Self {
            shape: Shape::Cosine,
            frame: Frame::from_normal(normal),
        }
    }

    /// The lobe `(n + 1)/2pi cos^n` about an axis.
    pub fn lobe(axis: DVec3, exponent: f64) -> Self {
        Self {
            shape: Shape::Lobe(Lobe::new(exponent)),
            frame: Frame::from_normal(axis),
        }
    }

    /// The GGX lobe of a white mirror, seen along `view`, over its `albedo`.
    pub fn ggx(normal: DVec3, view: DVec3, exponent: f64, albedo: f64) -> Self {
        let ggx = Ggx::new(alpha_of(exponent), normal.dot(view));
        Self {
            shape: Shape::Ggx(ggx, albedo),
            frame: frame(normal, view),
        }
    }

    /// The direction of a point of the unit square.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        self.frame.to_world(match self.shape {
            Shape::Cosine => Mixture::COSINE.sample(u),
            Shape::Lobe(lobe) => lobe.sample(u),
            Shape::Ggx(ggx, _) => ggx.sample(u).direction,
        })
    }

    /// The weight of one direction that light comes from; 0 below the horizon of the shading normal.
    pub fn toward(&self, surface: &Sample, direction: DVec3) -> f64 {
        self.one(surface, direction).x
    }

    /// The weight of all directions whose ray leaves in the unit direction `ray`, and the density with which they are
    /// drawn: that direction itself and, where the wedge below the facet looks along its mirror image, the one that is
    /// folded onto it.
    pub fn weight(&self, surface: &Sample, shading: Shading, ray: DVec3) -> DVec2 {
        let height = ray.dot(surface.geometric);
        if height <= 0.0 {
            return DVec2::ZERO;
        }
        let one = |direction| self.one(surface, direction);
        match shading {
            Shading::Exact => one(ray),
            Shading::Production => one(ray) + one(ray - 2.0 * height * surface.geometric),
        }
    }

    /// Weight and density of one direction.
    fn one(&self, surface: &Sample, direction: DVec3) -> DVec2 {
        if direction.dot(surface.normal) <= 0.0 {
            return DVec2::ZERO;
        }
        let local = self.frame.to_local(direction);
        match self.shape {
            Shape::Cosine => DVec2::splat(Mixture::COSINE.pdf(local)),
            Shape::Lobe(lobe) => DVec2::splat(lobe.pdf(local)),
            Shape::Ggx(ggx, albedo) => {
                let density = ggx.pdf(local);
                DVec2::new(density * ggx.weight(local) / albedo, density)
            }
        }
    }
}
