//! The alpha test of one mesh: whether a hit on it stops a ray.
//!
//! **Cut-outs** block where alpha reaches the cutoff, equality included, as the glTF specification says.
//!
//! **See-through surfaces** (glTF BLEND, OBJ `d`) let the share `1 - alpha` of the light pass, and a surface with
//! transmission a share of what is left. Ambient light is a mean over rays, so it is enough that this share of the rays
//! passes, which needs no partial hits and is right behind any number of such surfaces. Which rays pass is no matter of
//! chance, or a bake would depend on its threads: every ray and triangle have a threshold in 0..1 by a hash, and the
//! ray is stopped where alpha is above it. Both ray libraries get the same rays, so they agree. Instances of one mesh
//! in a row are told apart by where on the triangle the ray meets them.

use crate::backend::Stops;
use crate::material::transmitted;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use scene::{Alpha, AlphaBlocks, Image, Mesh, Scene, TextureRef};
use std::sync::Arc;

/// Cells of a see-through triangle along two of its edges, each with thresholds of its own: enough to tell instances
/// apart, too few for the rounding of a hit to matter.
const CELLS: f32 = 64.0;

/// Decides hits on one mesh with a material that is not opaque. It owns what it reads, so a ray library may keep it.
#[derive(Clone)]
pub struct AlphaTest {
    scene: Arc<Scene>,
    mesh: u32,
    /// Of the image that holds its alpha.
    blocks: Option<Arc<AlphaBlocks>>,
}

impl AlphaTest {
    /// The test of a mesh of the scene; `None` where its material is opaque, unless `always`: then one that keeps all.
    ///
    /// * `blocks`: [`alpha_blocks`] of the scene.
    pub(crate) fn of(
        scene: &Arc<Scene>,
        mesh: u32,
        always: bool,
        blocks: &[Option<Arc<AlphaBlocks>>],
    ) -> Option<Self> {
        let material = &scene.materials[scene.meshes[mesh as usize].material as usize];
        (!material.is_opaque() || always).then(|| Self {
            scene: Arc::clone(scene),
            mesh,
            blocks: map(&material.alpha).and_then(|map| blocks[map.image as usize].clone()),
        })
    }

    /// True where the surface stops a ray at the point with the weights `barycentric` of the triangle's second and
    /// third corners.
    ///
    /// * `ray`: [`crate::Ray::id`] of the ray as it was cast, or the number of a [`Stops`].
    pub fn keep(&self, primitive: u32, barycentric: [f32; 2], ray: u32) -> bool {
        let stopped = self.stopped(primitive, barycentric);
        match ray {
            _ if stopped >= 1.0 => true,
            _ if ray == Stops::All.id() => false,
            _ if ray == Stops::Any.id() => stopped > 0.0,
            _ => stopped > threshold([ray, self.mesh, primitive], barycentric),
        }
    }

    /// The share of the light that the surface stops at a point, 0..=1: of the mean of the channels, for a ray passes
    /// or is stopped with all of them.
    pub(crate) fn stopped(&self, primitive: u32, barycentric: [f32; 2]) -> f32 {
        let (covered, transmitted) = self.covered(primitive, barycentric);
        match transmitted {
            Some((share, tint)) => covered * (1.0 - share * tint.element_sum() / 3.0),
            None => covered,
        }
    }

    /// The share of the light of each channel that the surface lets pass at a point, 0..=1.
    pub(crate) fn passing(&self, primitive: u32, barycentric: [f32; 2]) -> Vec3 {
        let (covered, transmitted) = self.covered(primitive, barycentric);
        let (share, tint) = transmitted.unwrap_or_default();
        1.0 - covered * (1.0 - share * tint)
    }

    /// The share of the light that alpha stops at a point, and what goes straight through of that where some does.
    fn covered(&self, primitive: u32, barycentric: [f32; 2]) -> (f32, Option<(f32, Vec3)>) {
        let mesh = &self.scene.meshes[self.mesh as usize];
        let alpha = |factor, cutoff| self.alpha(mesh, factor, cutoff, primitive, barycentric);
        let material = &self.scene.materials[mesh.material as usize];
        let covered = match material.alpha {
            Alpha::Opaque => 1.0,
            Alpha::Mask { cutoff, factor, .. } => {
                f32::from(u8::from(alpha(factor, Some(cutoff)) >= cutoff))
            }
            Alpha::Blend { factor, .. } => alpha(factor, None),
        };
        let transmitted = (material.transmission.is_some() && covered > 0.0).then(|| {
            let [b, c] = barycentric.map(f64::from);
            transmitted(&self.scene, mesh, primitive, [1.0 - b - c, b, c])
        });
        (covered, transmitted)
    }

    /// Alpha at a point: factor times vertex colour times texture, 0..=1; or where there is a cutoff, some value on the
    /// same side of it.
    fn alpha(
        &self,
        mesh: &Mesh,
        factor: f32,
        cutoff: Option<f32>,
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
        let map = map(&self.scene.materials[mesh.material as usize].alpha);
        let set = map.and_then(|map| mesh.uv_sets.get(map.uv_set as usize));
        if let (Some(map), Some(set), Some(blocks)) = (map, set, &self.blocks) {
            let [a, b, c] = triangle.map(|vertex| set[vertex as usize]);
            let uv: Vec2 = a * (1.0 - u - v) + b * u + c * v;
            alpha *= self.scene.alpha_unless(map, uv, blocks, |[least, most]| {
                let is_told = |cutoff| alpha * least >= cutoff || alpha * most < cutoff;
                least == most || cutoff.is_some_and(is_told)
            });
        }
        alpha
    }
}

/// The texture whose alpha it is.
fn map(alpha: &Alpha) -> Option<&TextureRef> {
    match alpha {
        Alpha::Opaque => None,
        Alpha::Mask { map, .. } | Alpha::Blend { map, .. } => map.as_ref(),
    }
}

/// By image, the blocks of those that hold the alpha of a mesh.
pub(crate) fn alpha_blocks(scene: &Scene) -> Vec<Option<Arc<AlphaBlocks>>> {
    let mut asked = vec![false; scene.images.len()];
    for mesh in &scene.meshes {
        if let Some(map) = map(&scene.materials[mesh.material as usize].alpha) {
            asked[map.image as usize] = true;
        }
    }
    let images = asked.into_par_iter().zip(&scene.images);
    let blocks = |(asked, image): (bool, &Image)| asked.then(|| Arc::new(AlphaBlocks::of(image)));
    images.map(blocks).collect()
}

/// The threshold of a ray, a mesh and a triangle of it, where the ray meets it: evenly spread over `0.0..1.0`, all
/// multiples of 2^-24.
fn threshold([ray, mesh, triangle]: [u32; 3], barycentric: [f32; 2]) -> f32 {
    let [u, v] = barycentric.map(|weight| (weight * CELLS).floor() as i32 as u32);
    // Rounds of the finaliser of MurmurHash3 (A. Appleby, 2008), one for each number.
    let mix = |mut h: u32| {
        h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
        h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
        h ^ h >> 16
    };
    let numbers = [ray, mesh, triangle, u, v];
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
    use crate::fixture;

    fn test(scene: Scene) -> AlphaTest {
        let blocks = alpha_blocks(&scene);
        AlphaTest::of(&Arc::new(scene), 0, true, &blocks).expect("always")
    }

    #[test]
    fn a_see_through_triangle_stops_its_share_of_rays_and_layers_are_independent() {
        let (rays, alpha) = (100_000, 0.3);
        let stops = |ray, mesh, u| alpha > threshold([ray, mesh, 3], [u, 0.25]);
        let share = |of: &dyn Fn(u32) -> bool| {
            f64::from((0..rays).filter(|&ray| of(ray)).count() as u32) / f64::from(rays)
        };
        // Three standard errors of 100,000 independent rays are 0.0043.
        let one = share(&|ray| stops(ray, 0, 0.5));
        assert!((one - 0.3).abs() < 0.0043, "{one}");
        let meshes = share(&|ray| stops(ray, 0, 0.5) && stops(ray, 1, 0.5));
        assert!((meshes - 0.09).abs() < 0.0027, "{meshes}");
        let instances = share(&|ray| stops(ray, 0, 0.5) && stops(ray, 0, 0.6));
        assert!((instances - 0.09).abs() < 0.0027, "{instances}");
    }

    #[test]
    fn a_see_through_mesh_of_alpha_0_stops_nothing_and_of_alpha_1_everything() {
        for (factor, share) in [(0.0, 0..=0), (0.5, 440..=560), (1.0, 1000..=1000)] {
            let mut scene = fixture::scene(vec![fixture::square(0.0)]);
            scene.materials[0].alpha = Alpha::Blend { factor, map: None };
            let test = test(scene);
            let stopped = (0..1000).filter(|&ray| test.keep(1, [0.25, 0.5], ray));
            let stopped = stopped.count();
            assert!(share.contains(&stopped), "{factor}: {stopped}");
        }
    }

    #[test]
    fn a_surface_that_stops_a_share_stops_rays_that_ask_for_any_and_none_that_ask_for_all() {
        for (factor, kept) in [(0.0, [false; 2]), (0.25, [true, false]), (1.0, [true; 2])] {
            let mut scene = fixture::scene(vec![fixture::square(0.0)]);
            scene.materials[0].alpha = Alpha::Blend { factor, map: None };
            let test = test(scene);
            let asked = [Stops::Any, Stops::All].map(|stops| test.keep(1, [0.25, 0.5], stops.id()));
            assert_eq!(asked, kept, "{factor}");
            assert_eq!(test.stopped(1, [0.25, 0.5]), factor);
        }
    }

    #[test]
    fn a_pane_passes_its_share_of_the_rays_and_a_hole_in_it_all() {
        let mut scene = fixture::scene(vec![fixture::square(0.0)]);
        fixture::mask_left_half(&mut scene);
        scene.materials[0].transmission = Some(scene::Transmission {
            factor: 0.75,
            map: None,
        });
        let test = test(scene);
        let passed = |at: [f32; 2]| (0..100_000).filter(|&ray| !test.keep(0, at, ray)).count();
        // The second corner is right, the first left. Three standard errors of 100,000 rays are 411.
        let pane = passed([0.9, 0.05]);
        assert!(pane.abs_diff(75_000) < 411, "{pane}");
        assert_eq!(passed([0.05, 0.05]), 100_000);
    }

    #[test]
    fn thresholds_lie_between_alpha_0_and_1() {
        for ray in 0..10_000 {
            let t = threshold([ray, 1, 2], [ray as f32 * 1e-4, 0.25]);
            assert!((0.0..1.0).contains(&t), "{t}");
        }
    }
}
