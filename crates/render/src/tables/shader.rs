//! Line 9 of the 1984 algorithm: what a surface of one type looks up.

use super::index::{Index, dot};
use super::table::Table;
use super::weight::Weight;

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
}
