//! Line 9 of the 1984 algorithm: what a surface of one type looks up.

use crate::index::{Index, dot};
use crate::table::Table;
use render::Weight;

/// A surface type: which tables are looked up by which directions, and what each counts.
///
/// Radiance toward the eye is `Wd kd D[N] + Ws ks S[index] + ½ I[R]`, each term where its table is given. A translucent
/// surface has `(1 − t) D[N] + t D[−N]` in place of `D[N]`: what section 10 hopes for, at the cost of one more look-up.
/// With tables in radiance normalisation a constant environment of 1 gives `Wd kd + Ws ks + ½`. Self-luminous is a
/// constant D.
#[derive(Debug, Clone)]
pub struct Shader<'a> {
    /// D, indexed by N.
    pub diffuse: Option<&'a Table>,
    /// The share of the diffuse light that comes through from behind, 0..=1: leaves, paper.
    pub translucency: f32,
    /// S.
    pub specular: Option<&'a Table>,
    /// S for several exponents, ascending, each with a table for every one of `incidences`: each pixel reads those that
    /// its material and its E·N lie between. Beside `specular`, mostly in its place.
    pub glosses: Vec<(f64, Vec<&'a Table>)>,
    /// E·N of the tables of a gloss, ascending, no two alike; empty for one table at all incidences.
    pub incidences: Vec<f32>,
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

impl<'a> Shader<'a> {
    /// An opaque surface that these tables light, S by the mirror direction, each with a weight of 1.
    pub fn of(diffuse: Option<&'a Table>, specular: Option<&'a Table>) -> Self {
        Self {
            diffuse,
            translucency: 0.0,
            specular,
            glosses: Vec::new(),
            incidences: Vec::new(),
            index: Index::Mirror,
            coat: None,
            diffuse_weight: Weight::Constant,
            specular_weight: Weight::Constant,
        }
    }

    /// How much of each of `glosses` a material of this exponent shows: linear in ln(n + 1) between two, the nearest
    /// beyond the ends.
    pub(super) fn shares(&self, exponent: f64) -> Vec<f32> {
        let places: Vec<f64> = self.glosses.iter().map(|(n, _)| n.ln_1p()).collect();
        let mut shares = vec![0.0; places.len()];
        let at = exponent.ln_1p();
        let after = places.partition_point(|place| *place <= at);
        match (after.checked_sub(1), places.get(after)) {
            (Some(before), Some(next)) => {
                let part = ((at - places[before]) / (next - places[before])) as f32;
                shares[before] = 1.0 - part;
                shares[after] = part;
            }
            (Some(last), None) => shares[last] = 1.0,
            (None, Some(_)) => shares[0] = 1.0,
            (None, None) => {}
        }
        shares
    }

    /// How much of the table of this incidence shows at E·N: linear between two, the nearest beyond the ends.
    #[inline(always)]
    pub(super) fn incidence_share(&self, which: usize, cosine: f32) -> f32 {
        let Some(own) = self.incidences.get(which) else {
            return 1.0;
        };
        let next = match cosine < *own {
            true => which.checked_sub(1),
            false => Some(which + 1),
        };
        match next.and_then(|next| self.incidences.get(next)) {
            Some(next) => (1.0 - (cosine - own) / (next - own)).max(0.0),
            None => 1.0,
        }
    }

    /// [`Shader::point`] with what `glosses` show of a lobe of this exponent.
    pub(super) fn at(
        &self,
        normal: [f32; 3],
        view: [f32; 3],
        material: [[f32; 3]; 2],
        exponent: f64,
    ) -> [f32; 3] {
        let mut value = self.point(normal, view, material);
        let cosine = dot(normal, view);
        let ws = self.specular_weight.at(cosine);
        let direction = self.index.direction(normal, view);
        for (share, (_, tables)) in self.shares(exponent).into_iter().zip(&self.glosses) {
            for (which, table) in tables.iter().enumerate() {
                let share = share * self.incidence_share(which, cosine);
                let s = table.bilinear(direction);
                value = std::array::from_fn(|c| value[c] + ws[c] * share * material[1][c] * s[c]);
            }
        }
        value
    }

    /// Radiance toward `view` of a point with reflectances `[kd, ks]`, by bilinear look-up, without `glosses`. Unit
    /// vectors.
    pub fn point(&self, normal: [f32; 3], view: [f32; 3], material: [[f32; 3]; 2]) -> [f32; 3] {
        let read = |table: Option<&Table>, direction| {
            table.map_or([0.0; 3], |table| table.bilinear(direction))
        };
        let mut d = read(self.diffuse, normal);
        if self.translucency > 0.0 {
            let behind = read(self.diffuse, normal.map(|v| -v));
            let t = self.translucency;
            d = std::array::from_fn(|c| (1.0 - t) * d[c] + t * behind[c]);
        }
        let s = read(self.specular, self.index.direction(normal, view));
        let coat = read(self.coat, Index::Mirror.direction(normal, view));
        let cosine = dot(normal, view);
        let wd = self.diffuse_weight.at(cosine);
        let ws = self.specular_weight.at(cosine);
        let [kd, ks] = material;
        std::array::from_fn(|c| wd[c] * kd[c] * d[c] + ws[c] * ks[c] * s[c] + COAT * coat[c])
    }
}
