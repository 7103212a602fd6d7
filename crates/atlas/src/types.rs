//! The plain data of an atlas: where every triangle of every object lies on which page.

use glam::Vec2;
use serde::{Deserialize, Serialize};

/// Texels on the edge of a tile.
pub const TILE: u32 = 16;

/// A finished layout. Pages are square, `page_size` texels on an edge, row 0 and v = 0 on top (glTF's UV space).
#[derive(Debug, Clone)]
pub struct Atlas {
    /// Page edge in texels.
    pub page_size: u32,
    /// Number of pages.
    pub page_count: u32,
    /// Texels that were kept empty around charts, see [`Options::gutter`].
    pub gutter: u32,
    /// Chart coordinates, one entry for each of `Scene::meshes`.
    pub meshes: Vec<MeshLayout>,
    /// Where each of `Scene::instances` lies.
    pub placements: Vec<Placement>,
    /// How the coordinates came about.
    pub source: UvSource,
    /// What the audit of this layout found.
    pub audit: Audit,
    /// Texels per scene unit that the layout reached (area-weighted mean over the surface).
    pub density: f64,
    /// Number of charts over all meshes.
    pub chart_count: u32,
    /// Why the file's UV sets were not kept as they stand, one sentence each with its count; empty where one was.
    pub notes: Vec<String>,
}

/// Lightmap coordinates of one mesh. Triangles keep the order of `Mesh::triangles`.
#[derive(Debug, Clone, Default)]
pub struct MeshLayout {
    /// For each layout vertex, the vertex of `Mesh::positions` it repeats (seams split vertices).
    pub source_vertices: Vec<u32>,
    /// Layout coordinates in 0..=1 of the mesh's own square; [`Placement`] carries them onto the page.
    pub uvs: Vec<Vec2>,
    /// Indices into `uvs`, one triple a triangle of the mesh, same order.
    pub triangles: Vec<[u32; 3]>,
    /// Page of each triangle relative to [`Placement::page`]; empty means 0 for all.
    pub triangle_pages: Vec<u16>,
    /// Triangles of charts that nobody sees, which have next to no texels; empty where there are none.
    pub hidden: Vec<bool>,
}

impl MeshLayout {
    /// The layout of a mesh that takes no texels: its own vertices and triangles, all at one place.
    pub fn without_texels(mesh: &scene::Mesh) -> MeshLayout {
        MeshLayout {
            source_vertices: (0..mesh.positions.len() as u32).collect(),
            uvs: vec![Vec2::ZERO; mesh.positions.len()],
            triangles: mesh.triangles.clone(),
            triangle_pages: Vec::new(),
            hidden: Vec::new(),
        }
    }
}

/// One object's rectangle: page UV = `uv * scale + offset`, in 0..=1 of the page.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// First page.
    pub page: u32,
    /// Scale in u and v.
    pub scale: [f32; 2],
    /// Offset in u and v.
    pub offset: [f32; 2],
}

impl Placement {
    /// The object takes no texels: it was excluded.
    pub const NOWHERE: Placement = Placement {
        page: u32::MAX,
        scale: [0.0; 2],
        offset: [0.0; 2],
    };

    /// True where the object takes texels.
    pub fn is_somewhere(&self) -> bool {
        self.page != u32::MAX
    }
}

/// How the lightmap coordinates came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UvSource {
    /// The file's UV set (its number) was kept as it stands.
    Kept {
        /// TEXCOORD number.
        set: u32,
    },
    /// The file's UV set was kept, and each object was given a rectangle of its own.
    Repacked {
        /// TEXCOORD number.
        set: u32,
    },
    /// The file's UV set was kept chart by chart, and its charts were packed apart.
    Apart {
        /// TEXCOORD number.
        set: u32,
    },
    /// Charts were made and packed by ambake.
    Unwrapped,
}

impl UvSource {
    /// True where ambake packed the charts, each by itself.
    pub fn is_packed(self) -> bool {
        matches!(self, Self::Apart { .. } | Self::Unwrapped)
    }
}

/// What the raster audit of a layout found. A usable layout has no overlap and nothing missing or outside.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Audit {
    /// Sub-texel sample points strictly inside more than one triangle.
    pub overlaps: u64,
    /// Triangles with no area in the layout.
    pub missing: u64,
    /// Vertices outside 0..1.
    pub outside: u64,
    /// Texels that at least one chart touches, over all pages.
    pub texels: u64,
    /// Triangles too thin or too small for an area of their own in 32-bit coordinates: each holds a speck of a few
    /// units in the last place at its neighbour's corner, so that it is not missing. Its own texels show none of it.
    pub specks: u64,
}

/// What was asked of the layout.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// `--uv`.
    pub uv: UvMode,
    /// `--size`: page edge in texels, 1..=16384.
    pub page_size: u32,
    /// `--density`: texels per scene unit of every object; `None` shares the texels by the rule of `share.rs`.
    pub density: Option<f64>,
    /// `--density even`: all objects without a density that was asked for have one, the largest that fits the pages.
    pub even: bool,
    /// What of a chart is not seen becomes a chart of its own.
    pub cut_hidden: bool,
    /// Texels that stay empty around every chart that is packed, and around every object's rectangle: two charts are
    /// twice as many apart, and a chart is as many from the page's edge.
    pub gutter: u32,
    /// `--density-of`: names of objects, with wildcards, and their texels per scene unit. Later ones win.
    pub density_of: Vec<(String, f64)>,
    /// `--include`: only objects whose names fit one of these take texels; all where there is none.
    pub include: Vec<String>,
    /// `--exclude`: objects whose names fit one of these take no texels.
    pub exclude: Vec<String>,
    /// `--pages`.
    pub pages: Pages,
    /// `--one-page-per-mesh`: where a mesh does not fit on one page, that is an error.
    pub one_page_per_mesh: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            uv: UvMode::Auto,
            page_size: 1024,
            density: None,
            even: false,
            cut_hidden: false,
            gutter: 2,
            density_of: Vec::new(),
            include: Vec::new(),
            exclude: Vec::new(),
            pages: Pages::Auto,
            one_page_per_mesh: false,
        }
    }
}

/// `--pages`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Pages {
    /// As many as a density that was asked for needs; else one, and more only where the charts do not fit on it with
    /// four texels across every object.
    Auto,
    /// So many at most, at least 1; without a density that was asked for, all of them are filled.
    Most(u32),
}

/// `--uv`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum UvMode {
    /// Keep a usable lightmap UV set, else unwrap.
    Auto,
    /// Keep, and fail where it is not usable.
    Keep,
    /// Always unwrap.
    Unwrap,
}

/// A point of a surface: a triangle of an object and barycentric weights of its three corners (sum 1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Triangle of the instance's mesh.
    pub triangle: u32,
    /// Weights of the corners 0, 1, 2.
    pub weights: [f64; 3],
}
