//! The sky as probes see it: a uniform floor and what stands out of it.

use ambient::convention::SPHERE;
use ambient::sampling::power_over_density;
use environment::SkyMap;
use glam::{DVec3, Vec3};

/// Radiance from every direction that meets no surface, linear RGB.
#[derive(Debug, Clone, Copy)]
pub struct Sky<'a>(pub &'a environment::Sky);

impl<'a> Sky<'a> {
    /// What is the same from every direction.
    pub fn floor(&self) -> DVec3 {
        self.0.floor().into()
    }

    /// The map, where directions are to be drawn from it.
    pub(crate) fn drawn(&self) -> Option<&'a SkyMap> {
        self.0.map()
    }

    /// Radiance along a unit direction.
    pub(crate) fn radiance(&self, direction: DVec3) -> DVec3 {
        match self.drawn() {
            None => self.floor(),
            Some(map) => self.floor() + DVec3::from(map.above(texel(map, direction)).0),
        }
    }

    /// Radiance along a unit direction that counts for a ray of this density per steradian, beside as many that are
    /// drawn from the map.
    pub(crate) fn shared(&self, direction: DVec3, density: f64) -> DVec3 {
        let floor = self.floor();
        let Some(map) = self.drawn() else {
            return floor;
        };
        let (above, drawn) = map.above(texel(map, direction));
        floor + DVec3::from(above) * (density * power_over_density(density, drawn))
    }

    /// A direction drawn from the map for a point of the unit square, and the radiance above the floor over its density
    /// there.
    pub(crate) fn draw(
        map: &SkyMap,
        [u0, u1]: [f64; 2],
        density: impl Fn(DVec3) -> f64,
    ) -> (DVec3, DVec3) {
        let (directions, texels) = map.sample16(&[u0 as f32; 16], &[u1 as f32; 16]);
        let direction = Vec3::from(directions.map(|axis| axis[0])).as_dvec3();
        let (above, drawn) = map.above(texels[0]);
        (
            direction,
            DVec3::from(above) * power_over_density(drawn, density(direction)),
        )
    }
}

/// The texel that a unit direction shows.
fn texel(map: &SkyMap, direction: DVec3) -> u32 {
    map.texels16(&direction.as_vec3().to_array().map(|v| [v; 16]))[0]
}

/// Density of even directions over the sphere, per steradian.
pub(crate) const EVEN: f64 = 1.0 / SPHERE;
