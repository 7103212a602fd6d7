//! A microfacet surface that a camera sees, see [`ambient::ggx`].

use ambient::Frame;
use ambient::ggx::{Albedos, Ggx, alpha_of, base, frame};
use glam::DVec3;
use rays::PhongMaterial;

/// A surface of GGX microfacets over a matte base, seen from one direction.
pub(crate) struct Coat {
    ggx: Ggx,
    frame: Frame,
    /// Reflectance along the normal.
    f0: DVec3,
    /// What light between facets adds.
    gain: DVec3,
    /// Diffuse reflectance of the base.
    pub base: DVec3,
}

impl Coat {
    /// The coat of a point with this unit normal, seen from the unit direction `view`.
    ///
    /// * `points`: of the unit square; what an open surface reflects is a mean over them, at least one. Directions that
    ///   are drawn by the same points then return exactly 1 from a white mirror.
    pub fn of(
        material: &PhongMaterial,
        normal: DVec3,
        view: DVec3,
        points: impl ExactSizeIterator<Item = [f64; 2]>,
    ) -> Coat {
        let ggx = Ggx::new(alpha_of(material.exponent), normal.dot(view));
        let share = 1.0 / points.len() as f64;
        let mut open = Albedos {
            tinted: 0.0,
            white: 0.0,
        };
        for point in points {
            let drawn = ggx.sample(point);
            open.tinted += share * drawn.weight * (1.0 - drawn.fresnel);
            open.white += share * drawn.weight * drawn.fresnel;
        }
        let f0 = material.specular.min(DVec3::ONE);
        Coat {
            ggx,
            frame: frame(normal, view),
            f0,
            gain: open.gain(f0),
            base: base(material.albedo, f0, open.of(f0)),
        }
    }

    /// The unit direction of a point of the unit square.
    pub fn sample(&self, point: [f64; 2]) -> DVec3 {
        self.frame.to_world(self.ggx.sample(point).direction)
    }

    /// Probability per steradian of a unit direction.
    pub fn pdf(&self, toward: DVec3) -> f64 {
        self.ggx.pdf(self.frame.to_local(toward))
    }

    /// What radiance from a unit direction counts, over its probability.
    pub fn weight(&self, toward: DVec3) -> DVec3 {
        let local = self.frame.to_local(toward);
        let fresnel = self.ggx.fresnel(local);
        self.gain * self.ggx.weight(local) * (self.f0 * (1.0 - fresnel) + fresnel)
    }

    /// Radiance toward the eye for an irradiance of 1 on a plane across the unit direction `toward` of a far light,
    /// 1/sr.
    pub fn reflected(&self, toward: DVec3) -> DVec3 {
        self.pdf(toward) * self.weight(toward)
    }
}
