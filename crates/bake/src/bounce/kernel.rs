//! What a texel weighs incoming light by: the cosine of its irradiance, or the specular lobe.

use crate::options::Shading;
use crate::survey::Sample;
use ambient::Frame;
use ambient::sampling::{Lobe, Mixture};
use glam::DVec3;

/// A weight of directions about a surface point, of integral 1 over the directions that it is drawn from.
pub(super) struct Kernel {
    shape: Shape,
    frame: Frame,
}

enum Shape {
    Cosine,
    Lobe(Lobe),
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

    /// The direction of a point of the unit square, with the kernel as its density.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        self.frame.to_world(match self.shape {
            Shape::Cosine => Mixture::COSINE.sample(u),
            Shape::Lobe(lobe) => lobe.sample(u),
        })
    }

    /// The weight of all directions whose ray leaves in the unit direction `ray`: that direction itself and, where the wedge below the
    /// facet looks along its mirror image, the one that is folded onto it.
    pub fn weight(&self, surface: &Sample, shading: Shading, ray: DVec3) -> f64 {
        let height = ray.dot(surface.geometric);
        if height <= 0.0 {
            return 0.0;
        }
        let one = |direction: DVec3| match direction.dot(surface.normal) > 0.0 {
            false => 0.0,
            true => {
                let local = self.frame.to_local(direction);
                match self.shape {
                    Shape::Cosine => Mixture::COSINE.pdf(local),
                    Shape::Lobe(lobe) => lobe.pdf(local),
                }
            }
        };
        match shading {
            Shading::Exact => one(ray),
            Shading::Production => one(ray) + one(ray - 2.0 * height * surface.geometric),
        }
    }
}

/// The direction in which the ray of `direction` leaves a surface; `None` where it counts 0: below the horizon of the shading normal, or
/// in exact shading below the facet.
pub(super) fn leaving(surface: &Sample, shading: Shading, direction: DVec3) -> Option<DVec3> {
    if direction.dot(surface.normal) <= 0.0 {
        return None;
    }
    let height = direction.dot(surface.geometric);
    match shading {
        _ if height > 0.0 => Some(direction),
        Shading::Production if height < 0.0 => Some(direction - 2.0 * height * surface.geometric),
        _ => None,
    }
}
