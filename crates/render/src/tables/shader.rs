//! Line 9 of the 1984 algorithm for every pixel of a buffer.

use super::antialias::Lookup;
use super::gbuffer::GBuffer;
use super::index::{Index, dot};
use super::row::Row;
use super::table::Table;
use super::weight::Weight;
use crate::Camera;
use maps::Image;
use pulp::Arch;
use rayon::prelude::*;

/// A surface type: which tables are looked up by which directions, and what each counts.
///
/// Radiance toward the eye is `Wd kd D[N] + Ws ks S[index] + ½ I[R]`, each term where its table is given. With tables in
/// radiance normalisation a constant environment of 1 gives `Wd kd + Ws ks + ½`. Self-luminous is a constant D.
#[derive(Debug, Clone)]
pub struct Shader<'a> {
    /// D, indexed by N.
    pub diffuse: Option<&'a Table>,
    /// S.
    pub specular: Option<&'a Table>,
    /// What indexes S.
    pub index: Index,
    /// I of a clear coat of varnish that mirrors half of what meets it, section 6.2 (3).
    pub coat: Option<&'a Table>,
    /// Wd.
    pub diffuse_weight: Weight,
    /// Ws.
    pub specular_weight: Weight,
}

/// Share that a coat of varnish mirrors.
pub(super) const COAT: f32 = 0.5;

impl Shader<'_> {
    /// Radiance toward `view` of a point with reflectances `[kd, ks]`, by bilinear look-up. Unit vectors.
    pub fn point(&self, normal: [f32; 3], view: [f32; 3], material: [[f32; 3]; 2]) -> [f32; 3] {
        let read = |table: Option<&Table>, direction| {
            table.map_or([0.0; 3], |table| table.bilinear(direction))
        };
        let d = read(self.diffuse, normal);
        let s = read(self.specular, self.index.direction(normal, view));
        let coat = read(self.coat, Index::Mirror.direction(normal, view));
        let cosine = dot(normal, view);
        let wd = self.diffuse_weight.at(cosine);
        let ws = self.specular_weight.at(cosine);
        let [kd, ks] = material;
        std::array::from_fn(|c| wd * kd[c] * d[c] + ws * ks[c] * s[c] + COAT * coat[c])
    }

    /// Shades the pixels of `buffer` over what `picture` holds behind them.
    ///
    /// # Panics
    /// Where the picture has another size, or an antialiased look-up meets a buffer without corners.
    pub fn frame(&self, buffer: &GBuffer, lookup: Lookup, picture: &mut Image) {
        let [width, height] = buffer.camera.size.map(|n| n as usize);
        assert_eq!((picture.width, picture.height), (width, height));
        let cornered = !buffer.corners.is_empty();
        assert!(cornered || !lookup.needs_corners(), "no corners");
        let arch = Arch::new();
        let row = |(y, pixels): (usize, &mut [[f32; 3]])| {
            arch.dispatch(Row {
                shader: self,
                buffer,
                lookup,
                y,
                pixels,
            });
        };
        let rows = picture.pixels.par_chunks_exact_mut(width).enumerate();
        rows.with_min_len(8).for_each(row);
    }
}

/// The picture of an environment alone: bilinear at the middle of each pixel, or black without one.
pub fn backdrop(camera: &Camera, environment: Option<&Table>) -> Image {
    let [width, height] = camera.size.map(|n| n as usize);
    let mut picture = Image::filled(width, height, [0.0; 3]);
    if let Some(environment) = environment {
        let rows = picture.pixels.par_chunks_exact_mut(width).enumerate();
        rows.for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let direction = camera.direction(x as f64 + 0.5, y as f64 + 0.5);
                *pixel = environment.bilinear(direction.as_vec3().to_array());
            }
        });
    }
    picture
}
