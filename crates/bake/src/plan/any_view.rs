//! What the planner says of layers for any view.

use super::reflects;
use crate::options::Options;
use scene::{Scene, Surface};

/// Largest exponents whose terms orders 4 and 8 keep within about 0.02 of full scale beside walls and under lids, root mean square.
const HELD: [(usize, f64); 2] = [(4, 10.0), (8, 50.0)];

/// The rest of the sentence about the visibility; empty where no such layer is asked for.
pub(super) fn words(scene: &Scene, options: &Options) -> String {
    let Some(order) = options.any_view() else {
        return String::new();
    };
    let numbers = ambient::any_view::count(order);
    let exponent = options.overrides.exponent.or_else(|| narrowest(scene));
    let held = HELD.iter().find(|(_, most)| exponent <= Some(*most));
    let advice = match (exponent, held) {
        (None, _) => "no material reflects specularly".into(),
        (Some(n), Some((enough, _))) if *enough > order => {
            format!("lobes are as narrow as n = {n:.0}, which `any-view.8` holds better")
        }
        (Some(n), Some((enough, _))) if *enough < order => {
            format!("lobes are no narrower than n = {n:.0}, which `any-view` holds too")
        }
        (Some(n), Some(_)) => format!("lobes are no narrower than n = {n:.0}, which they hold"),
        (Some(n), None) => format!(
            "lobes are as narrow as n = {n:.0}, more than they hold; `error.any-view` says by how much"
        ),
    };
    format!(", and the same rays give {numbers} numbers a texel for any view: {advice}")
}

/// Largest exponent of the materials in use that reflect specularly.
fn narrowest(scene: &Scene) -> Option<f64> {
    let used = scene
        .meshes
        .iter()
        .map(|mesh| &scene.materials[mesh.material as usize].surface);
    let exponents = used
        .filter(|surface| reflects(surface))
        .map(|surface| match surface {
            Surface::Phong { exponent, .. } => *exponent,
            Surface::MetallicRoughness {
                base,
                metallic,
                roughness,
                dielectric,
                ..
            } => scene::phong_from_metallic_roughness(*base, *metallic, *roughness, *dielectric).2,
        });
    exponents.max_by(f64::total_cmp)
}
