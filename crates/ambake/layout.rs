//! The atlas of a bake by itself: `layout.json`, pictures of its charts, and a file from which bakes take it.

use crate::error::Error;
use crate::options::Options;
use crate::scene::Scene;
use atlas::{Atlas, PageRaster};
use rayon::prelude::*;
use report::{AtlasReport, LayoutReport, Output, SceneReport};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// The options that decide a layout, as [`Options::describe`] calls them.
pub(crate) const DECIDING: [&str; 15] = [
    "size",
    "density",
    "density_of",
    "include",
    "exclude",
    "no_cast",
    "seen_from",
    "buried",
    "buried_of",
    "pages",
    "one_page_per_mesh",
    "uv",
    "gutter",
    "mips",
    "align",
];

/// Where every texel of a bake lies, before a ray is cast.
#[derive(Debug, Clone)]
pub struct Layout {
    scene: Scene,
    atlas: Atlas,
    report: LayoutReport,
    key: Value,
    hash: String,
}

impl Layout {
    pub(crate) fn new(scene: &Scene, options: &Options, atlas: Atlas) -> Self {
        Self {
            scene: scene.clone(),
            report: LayoutReport::of(scene, &atlas),
            key: key(scene, options),
            hash: report::layout_hash(&atlas),
            atlas,
        }
    }

    /// Where [`Layout::write`] puts the file that bakes take the layout from.
    pub fn path(dir: &Path, scene: &Scene) -> PathBuf {
        dir.join(format!("{}.layout", scene.stem()))
    }

    /// Its atlas for a bake of this scene with these options; `None` where it is of others.
    pub(crate) fn serve(&self, scene: &Scene, options: &Options) -> Option<Atlas> {
        (self.key == key(scene, options)).then(|| self.atlas.clone())
    }

    /// The atlas.
    pub fn atlas(&self) -> &Atlas {
        &self.atlas
    }

    /// Where the texels went.
    pub fn report(&self) -> &LayoutReport {
        &self.report
    }

    /// A hash over the whole atlas. Bakes with the same hash have the same layout, and the parts of a sharded bake
    /// state it.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// The content of `layout.json`.
    pub fn describe(&self) -> Value {
        let stem = self.scene.stem();
        let mut files = vec!["layout.json".into(), format!("{stem}.layout")];
        files.extend((0..self.atlas.page_count).map(|page| picture_name(&stem, page)));
        json!({
            "schema_version": 1,
            "versions": {"ambake": crate::VERSION},
            "scene": SceneReport::of(&self.scene),
            "options": self.key["options"],
            "atlas": AtlasReport::of(&self.atlas),
            "layout": self.report,
            "hash": self.hash,
            "warnings": self.report.warnings(),
            "notes": self.atlas.notes,
            "files": files,
        })
    }

    /// Writes `layout.json`, a picture of each page's charts, and the file that bakes take the layout from.
    ///
    /// # Errors
    /// The directory cannot be written, or an output would replace an input.
    pub fn write(&self, dir: &Path) -> Result<Vec<PathBuf>, Error> {
        let stem = self.scene.stem();
        let mut output = Output::create(dir)?;
        output.protect(self.scene.inputs.clone());
        let path = Self::path(dir, &self.scene);
        output.check(&format!("{stem}.layout"))?;
        for page in 0..self.atlas.page_count {
            output.stage_bytes(&picture_name(&stem, page), &self.picture(page))?;
        }
        let text = format!("{:#}\n", self.describe());
        output.stage_bytes("layout.json", text.as_bytes())?;
        report::write_layout(&path, &self.key, &self.atlas)?;
        let mut files = vec![path];
        files.extend(output.publish()?);
        Ok(files)
    }

    /// A page as a PNG: each chart in a colour of its own, darker where a texel is covered in part, black where it is
    /// free.
    fn picture(&self, page: u32) -> Vec<u8> {
        let size = self.atlas.page_size as usize;
        let raster = PageRaster::new(&self.scene, &self.atlas, page);
        let charts: Vec<Vec<u32>> = self.atlas.meshes.par_iter().map(atlas::charts).collect();
        let tiles: Vec<Vec<(usize, [f32; 3])>> = (0..raster.tiles().len())
            .into_par_iter()
            .map(|tile| {
                let tile = raster.tile(tile);
                let texel = |footprint: &atlas::Footprint| {
                    let piece = &tile.pieces_of(footprint)[0];
                    let mesh = self.scene.instances[piece.instance as usize].mesh as usize;
                    let chart = charts[mesh][piece.triangle as usize];
                    let at = footprint.y as usize * size + footprint.x as usize;
                    let shade = 0.3 + 0.7 * footprint.coverage;
                    (at, colour(piece.instance, chart).map(|c| c * shade))
                };
                tile.footprints.iter().map(texel).collect()
            })
            .collect();
        let mut pixels = vec![[0.0; 3]; size * size];
        for (at, colour) in tiles.into_iter().flatten() {
            pixels[at] = colour;
        }
        report::picture_png(size, &pixels)
    }
}

/// The layout in the file at `path`, where it is of this scene and these options. A file that is of no use is as good
/// as none.
pub(crate) fn read(path: &Path, scene: &Scene, options: &Options) -> Option<Atlas> {
    report::read_layout(path, &key(scene, options), scene)
        .ok()
        .flatten()
        .filter(|atlas| atlas.page_size == options.size)
}

/// Everything that decides a layout.
fn key(scene: &Scene, options: &Options) -> Value {
    let all = options.describe();
    let own: Map<String, Value> = DECIDING
        .iter()
        .map(|&name| (name.into(), all[name].clone()))
        .collect();
    json!({
        "version": crate::VERSION,
        "revision": crate::REVISION,
        "scene": scene.content_hash,
        "options": own,
    })
}

fn picture_name(stem: &str, page: u32) -> String {
    format!("{stem}.{page}.layout.png")
}

/// A colour that differs from one chart to the next: hues by the golden ratio, brightness by the object.
fn colour(instance: u32, chart: u32) -> [f32; 3] {
    let hue = (f64::from(instance) * 0.381_966 + f64::from(chart) * 0.618_034).fract() as f32;
    let value = 0.5 + 0.4 * (instance % 2) as f32;
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|shift: f32| {
        let ramp = ((hue + shift).fract() * 6.0 - 3.0).abs() - 1.0;
        value * (0.25 + 0.75 * ramp.clamp(0.0, 1.0))
    })
}
