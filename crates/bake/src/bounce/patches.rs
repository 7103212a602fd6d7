//! The surfaces that send light on, texel by texel.

use crate::survey::Texel;
use glam::DVec3;

/// The surface of one texel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// Of its texel on its page.
    pub index: u32,
    position: [f32; 3],
    normal: [f32; 3],
    /// In the world, squared units.
    pub area: f32,
    /// Mean of the channels.
    pub albedo: f32,
}

impl Patch {
    /// That of a texel; `None` where it sends nothing on.
    pub fn of(texel: &Texel, index: u32) -> Option<Self> {
        let (area, albedo) = (texel.area, super::mean(texel.material.albedo));
        let sends = area > 0.0 && albedo > 0.0 && texel.seen.share > 0.0;
        sends.then(|| Self::new(index, texel.position, texel.normal, area, albedo))
    }

    pub fn new(index: u32, position: DVec3, normal: DVec3, area: f64, albedo: f64) -> Self {
        Self {
            index,
            position: position.as_vec3().to_array(),
            normal: normal.as_vec3().to_array(),
            area: area as f32,
            albedo: albedo as f32,
        }
    }

    pub fn position(&self) -> DVec3 {
        DVec3::from(self.position.map(f64::from))
    }

    pub fn normal(&self) -> DVec3 {
        DVec3::from(self.normal.map(f64::from))
    }
}
