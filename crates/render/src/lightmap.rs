//! The ambient models of a finished bake, looked up with the lightmap coordinates of the scene it wrote.

use crate::Error;
use glam::{DVec2, DVec3};
use rays::SurfaceHit;
use report::Page;
use scene::Scene;
use serde_json::Value;
use std::path::Path;

/// The layer of one model on every page, and where a mesh's texels lie.
pub struct Lightmap {
    pages: Vec<Page>,
    /// Page of each mesh.
    page_of: Vec<usize>,
    layer: String,
}

impl Lightmap {
    /// The scene `DIR/STEM.glb` and the layer `layer` of its pages `DIR/STEM.P.exr`.
    ///
    /// # Errors
    /// A file is absent or damaged, a mesh has no lightmap coordinates, or a page lacks the layer.
    pub fn load(dir: &Path, stem: &str, layer: &str) -> Result<(Scene, Lightmap), Error> {
        let path = dir.join(format!("{stem}.glb"));
        let fail = |problem: String| Error::Bake {
            path: path.clone(),
            problem,
        };
        let scene = scene::load(&path)?;
        let json = scene.source.as_ref().map_or(&Value::Null, |s| &s.json);
        let mut page_of = Vec::with_capacity(scene.meshes.len());
        for mesh in &scene.meshes {
            let page = (mesh.uv_sets.len() > 1)
                .then(|| page_number(json, mesh.origin.mesh, mesh.origin.primitive))
                .flatten();
            page_of.push(page.ok_or_else(|| {
                let name = &mesh.name;
                fail(format!(
                    "`{name}` has no lightmap; name the GLB that ambake bake wrote"
                ))
            })?);
        }
        let count = page_of.iter().max().map_or(0, |last| last + 1);
        let mut pages = Vec::with_capacity(count);
        for number in 0..count {
            let path = dir.join(format!("{stem}.{number}.exr"));
            let mut page = report::read_page_exr(&path)?.page;
            page.layers
                .retain(|kept| kept.name == layer && kept.channels.len() == 3);
            if page.layers.is_empty() {
                return Err(Error::Bake {
                    path,
                    problem: format!("it has no layer {layer}; bake again with --layers {layer}"),
                });
            }
            pages.push(page);
        }
        let layer = layer.into();
        Ok((
            scene,
            Lightmap {
                pages,
                page_of,
                layer,
            },
        ))
    }

    /// The layer at a hit on the scene of [`Lightmap::load`], bilinear.
    pub fn at(&self, scene: &Scene, hit: &SurfaceHit) -> DVec3 {
        let mesh_index = scene.instances[hit.instance as usize].mesh as usize;
        let mesh = &scene.meshes[mesh_index];
        let [b, c] = hit.barycentric.map(f64::from);
        let corners = mesh.triangles[hit.triangle as usize];
        let uv: DVec2 = corners
            .iter()
            .zip([1.0 - b - c, b, c])
            .map(|(&corner, weight)| mesh.uv_sets[1][corner as usize].as_dvec2() * weight)
            .sum();
        let page = &self.pages[self.page_of[mesh_index]];
        let last = f64::from(page.size - 1);
        let place = (uv * f64::from(page.size) - 0.5).clamp(DVec2::ZERO, DVec2::splat(last));
        let low = place.floor();
        let part = place - low;
        let high = (low + 1.0).min(DVec2::splat(last));
        let channels = &page.layers[0].channels;
        let texel = |x: f64, y: f64| {
            let at = y as usize * page.size as usize + x as usize;
            DVec3::from_array([0, 1, 2].map(|k: usize| f64::from(channels[k].values[at])))
        };
        let row = |y| texel(low.x, y).lerp(texel(high.x, y), part.x);
        row(low.y).lerp(row(high.y), part.y)
    }

    /// Name of the layer.
    pub fn layer(&self) -> &str {
        &self.layer
    }
}

/// The page that a primitive's occlusion texture shows: its image is called `STEM.P.occlusion`.
fn page_number(json: &Value, mesh: u32, primitive: u32) -> Option<usize> {
    let item = |list: &str, index: &Value| json.get(list)?.get(index.as_u64()? as usize);
    let primitive = &json["meshes"][mesh as usize]["primitives"][primitive as usize];
    let material = item("materials", &primitive["material"])?;
    let occlusion = &material["occlusionTexture"];
    let texture = item("textures", &occlusion["index"])?;
    let name = item("images", &texture["source"])?["name"].as_str()?;
    let (rest, kind) = name.rsplit_once('.')?;
    let (_, page) = rest.rsplit_once('.')?;
    (kind == "occlusion").then(|| page.parse().ok()).flatten()
}
