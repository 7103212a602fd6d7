//! The light that surfaces send on: albedo at the hit times the irradiance that the pages hold there.

use atlas::Atlas;
use glam::{DVec2, DVec3};
use rays::{Overrides, SurfaceHit, World, material_at};

/// The irradiance of a page that is sent on, over pi.
#[derive(Clone)]
pub(super) struct PageLight {
    /// Linear RGB, texel by texel.
    pub irradiance: Vec<[f32; 3]>,
    /// Texels that hold some: those of charts that can be seen.
    pub holds: Vec<bool>,
}

impl PageLight {
    /// Adds other light of the same page, so many times.
    pub fn add(&mut self, other: &Self, times: f64) {
        let times = times as f32;
        for (own, other) in self.irradiance.iter_mut().zip(&other.irradiance) {
            own.iter_mut()
                .zip(other)
                .for_each(|(own, other)| *own += times * other);
        }
    }
}

/// Radiosities of all surfaces, as Lambertian reflectors. A surface sends light from the side that its texels lie on;
/// its back, and surfaces without texels, send none.
pub(super) struct Radiosity<'a> {
    pub world: &'a World,
    pub atlas: &'a Atlas,
    pub overrides: &'a Overrides,
    pub pages: &'a [PageLight],
}

impl Radiosity<'_> {
    /// Radiance, linear RGB, that a surface sends back along the ray that met it.
    pub fn sent(&self, hit: &SurfaceHit, ray: DVec3) -> DVec3 {
        if self.world.face(hit.instance, hit.triangle).dot(ray) >= 0.0 {
            return DVec3::ZERO;
        }
        let weights = {
            let [b, c] = hit.barycentric.map(f64::from);
            [(1.0 - b - c).max(0.0), b, c]
        };
        let Some(irradiance) = self.irradiance(hit, weights) else {
            return DVec3::ZERO;
        };
        let scene = self.world.scene();
        let material = material_at(scene, hit.instance, hit.triangle, weights);
        self.overrides.applied(material).albedo * irradiance
    }

    /// The bilinear look-up among the four texels about a point, of those that hold light; `None` where none does.
    fn irradiance(&self, hit: &SurfaceHit, weights: [f64; 3]) -> Option<DVec3> {
        let placement = &self.atlas.placements[hit.instance as usize];
        if !placement.is_somewhere() {
            return None;
        }
        let mesh = self.world.scene().instances[hit.instance as usize].mesh;
        let layout = &self.atlas.meshes[mesh as usize];
        let triangle = hit.triangle as usize;
        let further = layout.triangle_pages.get(triangle).copied();
        let page = self
            .pages
            .get(placement.page as usize + usize::from(further.unwrap_or(0)))?;
        let mut uv = DVec2::ZERO;
        for (corner, weight) in layout.triangles[triangle].iter().zip(weights) {
            uv += layout.uvs[*corner as usize].as_dvec2() * weight;
        }
        let [scale, offset] = [placement.scale, placement.offset].map(DVec2::from_f32);
        let size = i64::from(self.atlas.page_size);
        let at = (uv * scale + offset) * size as f64 - 0.5;
        let (low, part) = (at.floor(), at - at.floor());
        let (mut sum, mut whole) = (DVec3::ZERO, 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let [x, y] = [low.x as i64 + dx, low.y as i64 + dy].map(|c| c.clamp(0, size - 1));
            let texel = (y * size + x) as usize;
            let share = |part: f64, step: i64| if step == 1 { part } else { 1.0 - part };
            let weight = share(part.x, dx) * share(part.y, dy);
            if page.holds[texel] {
                sum += weight * DVec3::from(page.irradiance[texel].map(f64::from));
                whole += weight;
            }
        }
        (whole > 0.0).then(|| sum / whole)
    }
}

/// Pairs of 32-bit numbers in 64 bits.
trait FromF32 {
    fn from_f32(pair: [f32; 2]) -> Self;
}

impl FromF32 for DVec2 {
    fn from_f32([x, y]: [f32; 2]) -> Self {
        DVec2::new(x.into(), y.into())
    }
}
