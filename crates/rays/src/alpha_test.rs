//! The alpha test of one masked mesh: whether a hit on it stops a ray.

use glam::Vec2;
use scene::{Alpha, Scene};
use std::sync::Arc;

/// Decides hits on one mesh with a masked material. It owns what it reads, so a ray library may keep it.
#[derive(Clone)]
pub struct AlphaTest {
    scene: Arc<Scene>,
    mesh: u32,
}

impl AlphaTest {
    /// The test of a mesh of the scene; `None` where its material is opaque, unless `always`: then one that keeps all.
    pub fn of(scene: &Arc<Scene>, mesh: u32, always: bool) -> Option<Self> {
        let material = scene.meshes[mesh as usize].material;
        let masked = matches!(scene.materials[material as usize].alpha, Alpha::Mask { .. });
        (masked || always).then(|| Self {
            scene: Arc::clone(scene),
            mesh,
        })
    }

    /// True where the surface is there: `factor * alpha >= cutoff` at the point with the weights `barycentric` of the
    /// triangle's second and third corners.
    pub fn keep(&self, primitive: u32, barycentric: [f32; 2]) -> bool {
        let mesh = &self.scene.meshes[self.mesh as usize];
        let Alpha::Mask {
            cutoff,
            factor,
            map,
        } = &self.scene.materials[mesh.material as usize].alpha
        else {
            return true;
        };
        let Some(map) = map else {
            return *factor >= *cutoff;
        };
        let Some(set) = mesh.uv_sets.get(map.uv_set as usize) else {
            return *factor >= *cutoff;
        };
        let [a, b, c] = mesh.triangles[primitive as usize].map(|vertex| set[vertex as usize]);
        let [u, v] = barycentric;
        let uv: Vec2 = a * (1.0 - u - v) + b * u + c * v;
        factor * self.scene.alpha(map, uv) >= *cutoff
    }
}

impl std::fmt::Debug for AlphaTest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("AlphaTest")
            .field("mesh", &self.mesh)
            .finish_non_exhaustive()
    }
}
