//! A finished bake as a renderer sees it: surfaces with lightmap coordinates, and pages to look them up in.

use atlas::{Atlas, triangle_uv};
use bake::BakedPage;
use glam::{DVec2, DVec3};
use layers::Layer;
use rays::World;

/// A scene with its baked pages.
#[derive(Clone, Copy)]
pub struct Lit<'a> {
    /// The triangles as the rays saw them.
    pub world: &'a World,
    /// Where they lie.
    pub atlas: &'a Atlas,
    /// The finished pages, in order.
    pub pages: &'a [BakedPage],
}

impl Lit<'_> {
    /// Every triangle that has a place on a page, as instance and number.
    pub(super) fn triangles(&self) -> Vec<(u32, u32)> {
        let scene = self.world.scene();
        let placed = (0u32..).zip(&scene.instances).zip(&self.atlas.placements);
        placed
            .filter(|(_, placement)| placement.is_somewhere())
            .flat_map(|((instance, object), _)| {
                let count = scene.meshes[object.mesh as usize].triangles.len() as u32;
                (0..count).map(move |triangle| (instance, triangle))
            })
            .collect()
    }

    /// Corners of a triangle in texels of its page, and the page.
    pub(super) fn places(&self, instance: u32, triangle: u32) -> ([DVec2; 3], u32) {
        let (uv, page) = triangle_uv(self.world.scene(), self.atlas, instance, triangle);
        let size = f64::from(self.atlas.page_size);
        (uv.map(|p| p.as_dvec2() * size), page)
    }

    /// The diffuse term at a place of a page, in texels, through the four-tap bilinear filter.
    pub(super) fn diffuse(&self, page: u32, place: DVec2) -> f64 {
        let page = &self.pages[page as usize];
        let values = page.layer(Layer::Diffuse).unwrap_or(&[]);
        bilinear(values, page.size as usize, place)
    }

    /// Unit normals at the corners of a triangle that its front shades with, and the front's geometric normal; zero for
    /// a triangle without an area.
    pub(super) fn normals(&self, instance: u32, triangle: u32) -> ([DVec3; 3], DVec3) {
        let geometric = self.world.face(instance, triangle).normalize_or_zero();
        let shading = self.world.normals(instance, triangle);
        (shading.unwrap_or([geometric; 3]), geometric)
    }
}

/// The four taps around a place, weights and texels of a square page of `size`: texel centres lie at halves, and the
/// border repeats. This is what graphics interfaces call linear filtering with clamp to edge.
pub(super) fn taps(size: usize, place: DVec2) -> [(usize, f64); 4] {
    let last = size as f64 - 1.0;
    let at = (place - 0.5).clamp(DVec2::ZERO, DVec2::splat(last));
    let low = at.floor();
    let part = at - low;
    let high = (low + 1.0).min(DVec2::splat(last));
    let tap = |x: f64, y: f64, weight: f64| (y as usize * size + x as usize, weight);
    [
        tap(low.x, low.y, (1.0 - part.x) * (1.0 - part.y)),
        tap(high.x, low.y, part.x * (1.0 - part.y)),
        tap(low.x, high.y, (1.0 - part.x) * part.y),
        tap(high.x, high.y, part.x * part.y),
    ]
}

/// A plane of a square page looked up at a place in texels.
pub(super) fn bilinear(values: &[f32], size: usize, place: DVec2) -> f64 {
    let taps = taps(size, place).into_iter();
    taps.map(|(texel, weight)| f64::from(values[texel]) * weight)
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page of 16² texels that holds `f` at its texel centres.
    fn page(f: impl Fn(f64, f64) -> f64) -> Vec<f32> {
        let at = |i: usize| f((i % 16) as f64 + 0.5, (i / 16) as f64 + 0.5) as f32;
        (0..256).map(at).collect()
    }

    #[test]
    fn a_linear_page_is_looked_up_without_error() {
        let values = page(|x, y| 0.25 + 0.02 * x - 0.01 * y);
        for k in 0..100 {
            let place = DVec2::new(0.5 + 0.15 * f64::from(k), 15.5 - 0.1 * f64::from(k));
            let expected = 0.25 + 0.02 * place.x - 0.01 * place.y;
            let found = bilinear(&values, 16, place);
            assert!((found - expected).abs() < 1e-7, "{place}: {found}");
        }
        // Beyond the last centres the border repeats.
        let corner = bilinear(&values, 16, DVec2::ZERO);
        assert_eq!(corner, bilinear(&values, 16, DVec2::splat(0.5)));
    }

    #[test]
    fn a_parabola_is_off_by_a_quarter_between_centres() {
        // Linear interpolation of x² is off by (1/2) f'' t (1 - t) with t in 0..1: at most 1/4.
        let values = page(|x, _| x * x);
        let off = |x: f64| bilinear(&values, 16, DVec2::new(x, 8.0)) - x * x;
        assert!((off(4.0) - 0.25).abs() < 1e-5, "{}", off(4.0));
        assert!(off(4.5).abs() < 1e-5, "{}", off(4.5));
        assert!((off(4.75) - 0.1875).abs() < 1e-5, "{}", off(4.75));
    }
}
