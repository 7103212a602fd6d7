//! The alpha test of one mesh: whether a hit on it stops a ray.
//!
//! **Cut-outs** block where alpha reaches the cutoff, equality included, as the glTF specification says.
//!
//! **See-through surfaces** (glTF BLEND, OBJ `d`) let the share `1 - alpha` of the light pass. Ambient light is a mean over
//! rays, so it is enough that this share of the rays passes, which needs no partial hits and is right behind any number of
//! such surfaces. Chance would make a bake depend on its threads, and a threshold of its own for each ray could not be
//! known to a ray library. So the surface is screened: each triangle is divided into [`GRID`] x [`GRID`] cells by its corner
//! weights, each cell has a fixed threshold in 0..1 by a hash, and a hit stops the ray where alpha is above it. Cells are
//! far smaller than what the rays of a texel tell apart; both ray libraries and every thread see the same ones.

use glam::Vec2;
use scene::{Alpha, Mesh, Scene, TextureRef};
use std::sync::Arc;

/// Cells of a see-through triangle along two of its edges: 1 cm on an edge of 160 m.
const GRID: f32 = 16384.0;

/// Decides hits on one mesh with a material that is not opaque. It owns what it reads, so a ray library may keep it.
#[derive(Clone)]
pub struct AlphaTest {
    scene: Arc<Scene>,
    mesh: u32,
}

impl AlphaTest {
    /// The test of a mesh of the scene; `None` where its material is opaque, unless `always`: then one that keeps all.
    pub fn of(scene: &Arc<Scene>, mesh: u32, always: bool) -> Option<Self> {
        let material = scene.meshes[mesh as usize].material;
        let opaque = matches!(scene.materials[material as usize].alpha, Alpha::Opaque);
        (!opaque || always).then(|| Self {
            scene: Arc::clone(scene),
            mesh,
        })
    }

    /// True where the surface stops a ray at the point with the weights `barycentric` of the triangle's second and third
    /// corners.
    pub fn keep(&self, primitive: u32, barycentric: [f32; 2]) -> bool {
        let mesh = &self.scene.meshes[self.mesh as usize];
        let alpha = |factor: f32, map: &Option<TextureRef>| {
            self.alpha(mesh, factor, map.as_ref(), primitive, barycentric)
        };
        match &self.scene.materials[mesh.material as usize].alpha {
            Alpha::Opaque => true,
            Alpha::Mask {
                cutoff,
                factor,
                map,
            } => alpha(*factor, map) >= *cutoff,
            Alpha::Blend { factor, map } => {
                alpha(*factor, map) > threshold([self.mesh, primitive], barycentric)
            }
        }
    }

    /// Alpha at a point: factor times vertex colour times texture, 0..=1.
    fn alpha(
        &self,
        mesh: &Mesh,
        factor: f32,
        map: Option<&TextureRef>,
        primitive: u32,
        [u, v]: [f32; 2],
    ) -> f32 {
        let triangle = mesh.triangles[primitive as usize];
        let mut alpha = factor;
        if !mesh.alphas.is_empty() {
            let [a, b, c] = triangle.map(|vertex| mesh.alphas[vertex as usize]);
            // Exact where the corners are equal.
            alpha *= a + (b - a) * u + (c - a) * v;
        }
        let set = |map: &TextureRef| mesh.uv_sets.get(map.uv_set as usize);
        if let Some((map, set)) = map.and_then(|map| Some((map, set(map)?))) {
            let [a, b, c] = triangle.map(|vertex| set[vertex as usize]);
            let uv: Vec2 = a * (1.0 - u - v) + b * u + c * v;
            alpha *= self.scene.alpha(map, uv);
        }
        alpha
    }
}

/// The threshold of the cell that holds a point of a triangle, given by mesh and number: evenly spread over `0.0..1.0`, all multiples of 2^-24.
fn threshold([mesh, triangle]: [u32; 2], barycentric: [f32; 2]) -> f32 {
    let [u, v] = barycentric.map(|weight| (weight * GRID).floor() as i32 as u32);
    // Rounds of the finaliser of MurmurHash3 (A. Appleby, 2008), one for each number.
    let mix = |mut h: u32| {
        h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
        h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
        h ^ h >> 16
    };
    let numbers = [mesh, triangle, u, v];
    let hash = numbers.into_iter().fold(0x9e37_79b9_u32, |hash, number| {
        mix(hash.wrapping_add(number))
    });
    (hash >> 8) as f32 / 16_777_216.0
}

impl std::fmt::Debug for AlphaTest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("AlphaTest")
            .field("mesh", &self.mesh)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_see_through_triangle_stops_its_share_of_rays_and_layers_are_independent() {
        let (edge, alpha) = (500, 0.3);
        let (mut one, mut both, mut count) = (0, 0, 0);
        for i in 0..edge {
            for j in 0..edge - i {
                let at = [i, j].map(|k| (k as f32 + 0.5) / edge as f32);
                let stops = |mesh| alpha > threshold([mesh, 3], at);
                one += u32::from(stops(7));
                both += u32::from(stops(7) && stops(8));
                count += 1;
            }
        }
        // Three standard errors of 125,250 independent cells are 0.004.
        let share = |n: u32| f64::from(n) / f64::from(count);
        assert!((share(one) - 0.3).abs() < 0.004, "{}", share(one));
        assert!((share(both) - 0.09).abs() < 0.003, "{}", share(both));
    }

    #[test]
    fn alpha_0_and_1_are_decided_everywhere() {
        for i in 0..10_000 {
            let t = threshold([0, i], [i as f32 * 1e-4, 0.25]);
            assert!((0.0..1.0).contains(&t), "{t}");
        }
    }
}
