//! The ambient models of a finished bake, looked up with the lightmap coordinates of the scene it wrote.

use crate::Error;
use glam::{DVec2, DVec3, Vec2};
use rays::SurfaceHit;
use report::Page;
use scene::{Mesh, Scene};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A point on a page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TexelPlace {
    /// Page number from 0.
    pub page: u32,
    /// Page coordinates, 0..=1.
    pub uv: Vec2,
}

impl TexelPlace {
    /// The place of a hit on a triangle with these page coordinates at its corners.
    pub fn of(page: u32, hit: &SurfaceHit, corners: [Vec2; 3]) -> TexelPlace {
        let [b, c] = hit.barycentric.map(f64::from);
        let [p, q, r] = corners.map(|uv| uv.as_dvec2());
        TexelPlace {
            page,
            uv: (p * (1.0 - b - c) + q * b + r * c).as_vec2(),
        }
    }

    /// The place of a hit on the scene of [`baked_scene`]; `None` where it has no texels.
    pub fn in_scene(
        scene: &Scene,
        page_of: &[Option<u32>],
        hit: &SurfaceHit,
    ) -> Option<TexelPlace> {
        let number = scene.instances[hit.instance as usize].mesh as usize;
        let mesh = &scene.meshes[number];
        let corners = mesh.triangles[hit.triangle as usize];
        let uv = |corner: u32| mesh.uv_sets[1][corner as usize];
        Some(TexelPlace::of(page_of[number]?, hit, corners.map(uv)))
    }

    /// The value there of a page of `size * size` texels, three planes, bilinear.
    pub fn bilinear(&self, size: u32, planes: [&[f32]; 3]) -> DVec3 {
        let last = f64::from(size - 1);
        let place = self.uv.as_dvec2() * f64::from(size) - 0.5;
        let place = place.clamp(DVec2::ZERO, DVec2::splat(last));
        let low = place.floor();
        let part = place - low;
        let high = (low + 1.0).min(DVec2::splat(last));
        let texel = |x: f64, y: f64| {
            let at = y as usize * size as usize + x as usize;
            DVec3::from_array(planes.map(|plane| f64::from(plane[at])))
        };
        let row = |y| texel(low.x, y).lerp(texel(high.x, y), part.x);
        row(low.y).lerp(row(high.y), part.y)
    }
}

/// The layer of one model on every page, and where a mesh's texels lie.
pub struct Lightmap {
    pages: Vec<Page>,
    files: Vec<PathBuf>,
    /// Page of each mesh; `None` for one that takes no texels.
    page_of: Vec<Option<u32>>,
    layer: String,
}

impl Lightmap {
    /// The scene `DIR/STEM.glb` and the layer `layer` of its pages `DIR/STEM.P.exr`.
    ///
    /// # Errors
    /// A file is absent or damaged, a mesh has no lightmap coordinates, or a page lacks the layer.
    pub fn load(dir: &Path, stem: &str, layer: &str) -> Result<(Scene, Lightmap), Error> {
        let (scene, page_of) = baked_scene(dir, stem)?;
        let count = page_of.iter().flatten().max().map_or(0, |last| last + 1);
        let bake = report::read_record(dir, stem);
        let named = (0..count).map(|page| report::NamedPage {
            name: format!("{stem}.{page}.exr"),
            stem: stem.into(),
            page,
        });
        let mut files = Vec::new();
        let mut pages = Vec::new();
        for named in named {
            let path = dir.join(&named.name);
            let file = match &bake {
                Some(bake) => report::read_page(dir, bake, &named)?,
                None => report::read_page_exr(&path)?,
            };
            let mut page = file.page;
            page.layers
                .retain(|kept| kept.name == layer && kept.channels.len() == 3);
            if page.layers.is_empty() {
                let problem = format!(
                    "it has no layer {layer}; bake again with --layers {layer}, or take another --model"
                );
                return Err(Error::Bake { path, problem });
            }
            pages.push(page);
            files.push(path);
        }
        let layer = layer.into();
        Ok((
            scene,
            Lightmap {
                pages,
                files,
                page_of,
                layer,
            },
        ))
    }

    /// Where the texels of a hit on the scene of [`Lightmap::load`] lie; `None` where it has none.
    pub fn place(&self, scene: &Scene, hit: &SurfaceHit) -> Option<TexelPlace> {
        TexelPlace::in_scene(scene, &self.page_of, hit)
    }

    /// The layer at a place, bilinear.
    pub fn at(&self, place: TexelPlace) -> DVec3 {
        let page = &self.pages[place.page as usize];
        let channels = &page.layers[0].channels;
        place.bilinear(page.size, [0, 1, 2].map(|k: usize| &channels[k].values[..]))
    }

    /// Files of the pages.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Name of the layer.
    pub fn layer(&self) -> &str {
        &self.layer
    }
}

/// The scene `DIR/STEM.glb` of a bake, and the page of each of its meshes: `None` for one that takes no texels.
///
/// # Errors
/// The file is absent or damaged, or no mesh has a page.
pub fn baked_scene(dir: &Path, stem: &str) -> Result<(Scene, Vec<Option<u32>>), Error> {
    let path = dir.join(format!("{stem}.glb"));
    let scene = scene::load(&path)?;
    let json = scene.source.as_ref().map_or(&Value::Null, |s| &s.json);
    // Without a diffuse layer the file has no occlusion texture to tell pages by; one page needs none.
    let single = !dir.join(format!("{stem}.1.exr")).exists();
    let page = |mesh: &Mesh| {
        let laid_out = mesh.uv_sets.len() > 1;
        let told = || page_number(json, mesh.origin.mesh, mesh.origin.primitive);
        laid_out.then(told).flatten()
    };
    let mut page_of: Vec<Option<u32>> = scene.meshes.iter().map(page).collect();
    if page_of.iter().all(Option::is_none) && single {
        let laid_out = |mesh: &Mesh| (mesh.uv_sets.len() > 1).then_some(0);
        page_of = scene.meshes.iter().map(laid_out).collect();
    }
    match page_of.iter().any(Option::is_some) {
        true => Ok((scene, page_of)),
        false => Err(Error::Bake {
            path,
            problem: "no mesh has a lightmap; bake again with the layer diffuse".into(),
        }),
    }
}

/// The page that a primitive's occlusion texture shows: its image is called `STEM.P.occlusion`.
fn page_number(json: &Value, mesh: u32, primitive: u32) -> Option<u32> {
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
