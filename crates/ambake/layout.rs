//! The atlas of a bake by itself.

use crate::options::Options;
use crate::scene::Scene;
use atlas::Atlas;
use report::{AtlasReport, LayoutReport, SceneReport};
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
    pub(crate) scene: Scene,
    pub(crate) atlas: Atlas,
    report: LayoutReport,
    pub(crate) key: Value,
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

pub(crate) fn picture_name(stem: &str, page: u32) -> String {
    format!("{stem}.{page}.layout.png")
}
