//! `bake.json`: what was asked, what was modelled and why, what came out and what it cost.

mod facts;
#[cfg(test)]
pub(crate) mod tests;

use crate::{Error, check_regular};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The layout of [`BakeReport`] that this version writes and reads. It grows when a field changes its meaning or goes.
pub const BAKE_SCHEMA_VERSION: u32 = 1;

/// The content of `bake.json`. Plain fields; the command line fills them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BakeReport {
    /// [`BAKE_SCHEMA_VERSION`].
    pub schema_version: u32,
    /// Who baked with what.
    pub versions: Versions,
    /// The scene that was baked.
    pub scene: SceneReport,
    /// Every option after defaults were applied, under the name of its flag.
    pub options: serde_json::Map<String, serde_json::Value>,
    /// Seed of the sample stream.
    pub seed: u64,
    /// The rule by which the specular term is viewed, such as `normal` or `eye 1,2,3`.
    pub view: String,
    /// What the stored numbers mean, in words and formulas.
    pub convention: String,
    /// What was modelled and why.
    pub plan: Vec<DecisionReport>,
    /// The layout.
    pub atlas: AtlasReport,
    /// Where the texels went.
    #[serde(default)]
    pub layout: crate::LayoutReport,
    /// One entry for each page, in order.
    pub pages: Vec<PageReport>,
    /// How far the two sides of seams differ; absent where no seam was solved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seams: Option<SeamReport>,
    /// What light that bounces added; absent where it was not asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounces: Option<BounceReport>,
    /// What `--update` kept of an earlier bake; absent without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub update: Option<UpdateReport>,
    /// What layers for any view hold; absent where none was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub any_view: Option<AnyViewReport>,
    /// Whence `STEM.lit.png` is taken; absent where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picture: Option<PictureReport>,
    /// One entry for each object; the `object` layer holds its index.
    pub objects: Vec<ObjectReport>,
    /// Wall time by phase, in the order they ran.
    pub timings: Vec<PhaseReport>,
    /// Wall time of the whole bake in seconds.
    pub seconds: f64,
    /// Rays cast in all.
    pub rays: u64,
    /// What lies inside of solids.
    #[serde(default)]
    pub buried: BuriedReport,
    /// Largest resident memory in bytes, where the system tells it.
    pub peak_memory_bytes: Option<u64>,
    /// Everything that was repaired, ignored or doubtful.
    pub warnings: Vec<WarningReport>,
    /// Why the file's own UV sets were not kept, a sentence each.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Lightmaps made for engines.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lightmaps: Vec<crate::LightmapReport>,
    /// Every file that was written, by name, this one included.
    pub files: Vec<String>,
    /// Blake3 of each of them as it was written, in hex. Those of reports lack: they would have to hold their own.
    #[serde(default)]
    pub hashes: BTreeMap<String, String>,
}

/// Whence the picture of a bake is taken.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PictureReport {
    /// The pinhole, in coordinates of the scene file.
    pub eye: [f64; 3],
    /// Unit vector into the picture.
    pub forward: [f64; 3],
    /// Vertical field of view in degrees.
    pub fov_deg: f64,
    /// Width over height.
    pub aspect: f64,
}

/// What `bake.json` says of layers for any view.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AnyViewReport {
    /// Largest order of the harmonics: 4 or 8.
    pub order: u32,
    /// Numbers a texel.
    pub numbers: u32,
    /// Exponent of the narrowest highlight in use, for which the next two hold; absent where no material has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exponent: Option<f64>,
    /// What orders 4 and 8 leave of its term beside walls and under lids, root mean square over all views.
    #[serde(default)]
    pub truncation: [f64; 2],
    /// The noise to expect in its term.
    #[serde(default)]
    pub noise: f64,
    /// Bytes a texel in the EXR file before it is compressed.
    pub bytes_per_texel: u32,
    /// The picture of the kernels.
    pub kernel: String,
    /// Which row of it a lobe is.
    pub row: String,
    /// The functions for shaders.
    pub shaders: Vec<String>,
}

/// What an update baked and what it kept.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct UpdateReport {
    /// Texels baked anew.
    pub baked: u64,
    /// Texels whose values were kept, bit for bit.
    pub kept: u64,
    /// Share of the texels that was baked anew, 0..=1.
    pub share: f64,
    /// Names of the objects that changed, came or went, in order.
    pub changed: Vec<String>,
    /// Why nothing of the earlier bake could serve, or its layout could not; absent where all of it did.
    pub reason: Option<String>,
    /// Kept texels that `--verify` baked again and found the same.
    pub verified: u64,
}

/// Versions of the program and of what it relied on.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Versions {
    /// ambake's version.
    pub ambake: String,
    /// Revision of the source, where the build knew it.
    pub git_revision: Option<String>,
    /// `embree` or `obvhs`.
    pub backend: String,
    /// Version of the library that was really loaded.
    pub backend_version: String,
}

/// The scene that was baked.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneReport {
    /// Path as given; `scene` without a file.
    pub path: String,
    /// The file as seen from the output folder, links resolved; absent without a file, or where that is not in UTF-8.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// `obj`, `gltf`, `glb`, or `memory` without a file.
    pub format: String,
    /// Blake3 over all bytes read or handed over.
    pub content_hash: String,
    /// Distinct meshes.
    pub meshes: u64,
    /// Placements of meshes.
    pub instances: u64,
    /// Triangles of the distinct meshes.
    pub triangles: u64,
    /// Triangles of all placements.
    pub instanced_triangles: u64,
    /// Materials.
    pub materials: u64,
    /// Images.
    pub images: u64,
}

/// One decision of the planner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DecisionReport {
    /// A stable word for the decision.
    pub decision: String,
    /// True where it is modelled, false where it is left out.
    pub modelled: bool,
    /// Why it was taken, as a sentence.
    pub reason: String,
    /// For a term, how it comes about: `closed_form`, `rays` or `off`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
}

/// The layout.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AtlasReport {
    /// `unwrapped` or `kept`.
    pub source: String,
    /// The file's UV set that was kept.
    pub kept_set: Option<u32>,
    /// Page edge in texels.
    pub page_size: u32,
    /// Number of pages.
    pub pages: u32,
    /// Number of charts.
    pub charts: u32,
    /// Texels per scene unit reached, area-weighted mean.
    pub density: f64,
    /// Sample points inside more than one triangle.
    pub overlaps: u64,
    /// Triangles without area in the layout.
    pub missing: u64,
    /// Vertices outside 0..1.
    pub outside: u64,
    /// Texels that at least one chart touches.
    pub texels: u64,
    /// [`crate::layout_hash`]; pages state it too.
    #[serde(default)]
    pub hash: String,
}

/// What lies inside of solids, where nobody sees it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BuriedReport {
    /// Texels of which nothing can be seen.
    pub texels: u64,
    /// Share of the covered area that cannot be seen, 0..=1.
    pub share: f64,
}

/// What happened on one page.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PageReport {
    /// Page number from 0.
    pub page: u32,
    /// Texels with coverage above 0.
    pub texels: u64,
    /// Sum of the coverage over all texels divided by their number, 0..=1.
    pub coverage_used: f64,
    /// What lies inside of solids.
    #[serde(default)]
    pub buried: BuriedReport,
    /// Mean standard error of `diffuse` over covered texels.
    pub mean_error: f64,
    /// Largest standard error of `diffuse`.
    pub max_error: f64,
    /// Column and row of the first texel that has it.
    #[serde(default)]
    pub worst_texel: [u32; 2],
    /// Largest standard error of `diffuse` over its value, of texels whose value is at least 1/255.
    #[serde(default)]
    pub worst_relative: f64,
    /// Estimated root mean square error of `diffuse` over covered texels: that of the layer `error`.
    #[serde(default)]
    pub rmse: f64,
    /// The part of it that the rays leave, before seams move texels.
    #[serde(default)]
    pub rmse_rays: f64,
    /// What the true error that the rays leave stays below with 99.9 % confidence.
    #[serde(default)]
    pub rmse_bound: f64,
    /// Under an illumination map: estimated root mean square error of `irradiance`, mean of its channels, as a
    /// radiance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub irradiance_rmse: Option<f64>,
    /// What that is held against, where the layer `irradiance` is baked: its mean over covered texels and channels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub irradiance_mean: Option<f64>,
    /// Rays cast for the page, those of all gathers of bounces and lights included.
    pub rays: u64,
    /// Seconds spent integrating the page, and on its part of the gathers.
    pub seconds: f64,
    /// `rays / seconds`; 0 where no ray was cast.
    pub rays_per_second: f64,
}

/// The steps of the diffuse term at points of all seams, between bilinear look-ups on their two sides.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SeamReport {
    /// Points.
    pub points: u64,
    /// Root mean square step before seams were solved.
    pub rms_before: f64,
    /// The same in the written pages.
    pub rms_after: f64,
    /// Largest step before.
    pub max_before: f64,
    /// Largest step in the written pages.
    pub max_after: f64,
    /// Root mean square over all texels of what they moved by for that.
    #[serde(default)]
    pub rms_moved: f64,
}

/// What the gathers of light that bounces added.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct BounceReport {
    /// How many there were.
    pub gathers: u32,
    /// Share of all light that the last one added.
    pub change: f64,
    /// Estimated share of all light that is still missing; 1 where one gather alone tells nothing.
    pub missing: f64,
    /// Rays of all gathers.
    pub rays: u64,
}

/// An object: one placement of a mesh.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectReport {
    /// Name of node and mesh.
    pub name: String,
    /// Triangles.
    pub triangles: u64,
    /// First page it lies on.
    pub page: u32,
}

/// Wall time of one phase.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseReport {
    /// Phase, such as `load`, `layout`, `build`, `integrate`, `finish`, `write`.
    pub phase: String,
    /// Seconds.
    pub seconds: f64,
    /// Seconds that threads of the process had a processor meanwhile, user and system, where that was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpu_seconds: Option<f64>,
}

/// Something that was repaired, ignored or is doubtful.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct WarningReport {
    /// A stable word.
    pub kind: String,
    /// What it is about.
    pub place: String,
    /// How many times.
    pub count: u64,
    /// One sentence.
    pub message: String,
}

/// The objects of a scene in the order of the `object` layer.
pub fn object_reports(scene: &scene::Scene, atlas: &atlas::Atlas) -> Vec<ObjectReport> {
    let objects = scene.instances.iter().zip(&atlas.placements);
    let report = |(instance, placement): (&scene::Instance, &atlas::Placement)| ObjectReport {
        name: instance.name.clone(),
        triangles: scene.meshes[instance.mesh as usize].triangles.len() as u64,
        page: if placement.is_somewhere() {
            placement.page
        } else {
            0
        },
    };
    objects.map(report).collect()
}

impl BakeReport {
    /// The file's text: indented JSON that ends with a line feed.
    pub fn to_json(&self) -> String {
        let text =
            serde_json::to_string_pretty(self).expect("plain structs with text keys become JSON");
        text + "\n"
    }
}

/// The report of a finished bake, from its `bake.json`.
///
/// # Errors
/// [`Error::Read`] for an absent file, other JSON, or another schema version.
pub fn read_bake_report(path: &Path) -> Result<BakeReport, Error> {
    #[derive(Deserialize)]
    struct Head {
        schema_version: u32,
    }
    let text = check_regular(path)
        .and_then(|()| std::fs::read_to_string(path))
        .map_err(|e| Error::read(path, format!("{e}; name the directory of a finished bake")))?;
    let broken =
        |e: serde_json::Error| Error::read(path, format!("{e}; the file is damaged, bake again"));
    let head: Head = serde_json::from_str(&text).map_err(broken)?;
    if head.schema_version != BAKE_SCHEMA_VERSION {
        let found = head.schema_version;
        let reason = format!(
            "it has schema version {found}, this ambake reads {BAKE_SCHEMA_VERSION}; bake again"
        );
        return Err(Error::read(path, reason));
    }
    serde_json::from_str(&text).map_err(broken)
}
