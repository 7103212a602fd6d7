//! The plain data of an atlas: where every triangle of every object lies on which page.

use glam::Vec2;
use serde::Serialize;

/// A finished layout. Pages are square, `page_size` texels on an edge, row 0 and v = 0 on top (glTF's UV space).
#[derive(Debug, Clone)]
pub struct Atlas {
    /// Page edge in texels.
    pub page_size: u32,
    /// Number of pages.
    pub page_count: u32,
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
}

/// One object's rectangle: page UV = `uv * scale + offset`, in 0..=1 of the page.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Placement {
    /// First page.
    pub page: u32,
    /// Scale in u and v.
    pub scale: [f32; 2],
    /// Offset in u and v.
    pub offset: [f32; 2],
}

/// How the lightmap coordinates came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
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
    /// Charts were made and packed by ambake.
    Unwrapped,
}

/// What the raster audit of a layout found. A usable layout has no overlap and nothing missing or outside.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
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
    /// `--density`: texels per scene unit, with as many pages as needed; `None` fits everything on one page.
    pub density: Option<f64>,
    /// Texels that stay empty around every chart that is packed, and around every object's rectangle: two charts are
    /// twice as many apart, and a chart is as many from the page's edge.
    pub gutter: u32,
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
