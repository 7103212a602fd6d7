//! Borders of charts: edges of triangles beyond which the chart does not go on.

use atlas::{Atlas, MeshLayout, triangle_uv};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rays::World;

/// An object and a chart of its mesh.
pub(super) type Chart = [u32; 2];

/// An edge of a triangle on the border of its chart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Border {
    pub page: u32,
    /// The chart.
    pub chart: Chart,
    /// Both ends in the world.
    pub ends: [DVec3; 2],
    /// Both ends in texels of the page.
    pub texels: [DVec2; 2],
    /// Unit shading normals at both ends.
    pub normals: [DVec3; 2],
    /// Unit direction within the surface, away from the edge.
    pub inward: DVec3,
    /// Scene units that a texel spans away from the edge.
    pub depth: f64,
    /// The way on the page, in texels, of one scene unit along `inward`.
    pub inward_texels: DVec2,
}

impl Border {
    pub fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }

    /// Scene units that a texel spans along the edge.
    pub fn texel(&self) -> f64 {
        self.length() / self.texels_across()
    }

    /// Its length on the page, in texels.
    pub fn texels_across(&self) -> f64 {
        self.texels[0].distance(self.texels[1])
    }

    /// Scene units that a texel spans in the direction in which it spans more.
    pub fn coarseness(&self) -> f64 {
        self.texel().max(self.depth)
    }

    pub fn at(&self, t: f64) -> DVec3 {
        self.ends[0].lerp(self.ends[1], t)
    }

    pub fn texels_at(&self, t: f64) -> DVec2 {
        self.texels[0].lerp(self.texels[1], t)
    }

    pub fn normal_at(&self, t: f64) -> DVec3 {
        self.normals[0].lerp(self.normals[1], t).normalize_or_zero()
    }
}

/// All borders on a page, or on all pages, in the order of objects and triangles. `charts` has the chart of each
/// triangle, mesh by mesh.
pub(super) fn borders(
    world: &World,
    atlas: &Atlas,
    page: Option<u32>,
    charts: &[Vec<u32>],
) -> Vec<Border> {
    let scene = world.scene();
    let edges: Vec<Vec<[u32; 2]>> = atlas.meshes.par_iter().map(border_edges).collect();
    let objects = scene.instances.par_iter().enumerate();
    objects
        .flat_map_iter(|(instance, object)| {
            let edges = edges[object.mesh as usize].iter();
            edges.filter_map(move |&[triangle, side]| {
                let chart = charts[object.mesh as usize][triangle as usize];
                let chart = [instance as u32, chart];
                border(world, atlas, page, chart, triangle, side as usize)
            })
        })
        .collect()
}

/// The border that a triangle's side is, unless it lies on another page or has no length.
fn border(
    world: &World,
    atlas: &Atlas,
    page: Option<u32>,
    chart: Chart,
    triangle: u32,
    side: usize,
) -> Option<Border> {
    let instance = chart[0];
    let (uv, own) = triangle_uv(world.scene(), atlas, instance, triangle);
    if page.is_some_and(|page| page != own) {
        return None;
    }
    let size = f64::from(atlas.page_size);
    let corners = world.corners(instance, triangle);
    let [a, b, c] = [side, (side + 1) % 3, (side + 2) % 3];
    let along = (corners[b] - corners[a]).try_normalize()?;
    let across = corners[c] - corners[a];
    let (beside, length) = (across.dot(along), (corners[b] - corners[a]).length());
    let away = across - along * beside;
    let inward = away.try_normalize()?;
    let normals = match world.normals(instance, triangle) {
        Some(normals) => [normals[a], normals[b]],
        None => [world.face(instance, triangle).try_normalize()?; 2],
    };
    let texels = [a, b].map(|k| uv[k].as_dvec2() * size);
    let side = (texels[1] - texels[0]).try_normalize()?;
    let to_corner = uv[c].as_dvec2() * size - texels[0];
    let height = side.perp_dot(to_corner).abs();
    let away_texels = to_corner - (texels[1] - texels[0]) * (beside / length);
    (height > 0.0).then(|| Border {
        page: own,
        chart,
        ends: [corners[a], corners[b]],
        texels,
        normals: normals.map(DVec3::normalize_or_zero),
        inward,
        depth: away.length() / height,
        inward_texels: away_texels / away.length(),
    })
}

/// Triangle and side (0 runs from corner 0 to corner 1) of every edge of a mesh that one triangle of the layout has
/// alone. Edges are the same where their ends are the same vertices of the layout or, for files that repeat vertices,
/// stand at the same coordinates.
fn border_edges(layout: &MeshLayout) -> Vec<[u32; 2]> {
    let sides = |t: usize| [0, 1, 2].map(|side| [t as u32, side]);
    let all = (0..layout.triangles.len()).flat_map(sides);
    let ends = |&[triangle, side]: &[u32; 2]| {
        let corners = layout.triangles[triangle as usize];
        [side, (side + 1) % 3].map(|k| corners[k as usize])
    };
    let by_vertex = lonely(all, |edge| {
        let [a, b] = ends(edge);
        (a.min(b), a.max(b))
    });
    let mut edges = lonely(by_vertex.into_iter(), |edge| {
        let page = layout.triangle_pages.get(edge[0] as usize);
        let place = |v: u32| layout.uvs[v as usize].to_array().map(f32::to_bits);
        let [a, b] = ends(edge).map(place);
        (page.copied().unwrap_or(0), a.min(b), a.max(b))
    });
    edges.sort_unstable();
    edges
}

/// The edges whose key no other has.
fn lonely<K: Ord + Send>(
    edges: impl Iterator<Item = [u32; 2]>,
    key: impl Fn(&[u32; 2]) -> K,
) -> Vec<[u32; 2]> {
    let mut keyed: Vec<_> = edges.map(|edge| (key(&edge), edge)).collect();
    keyed.par_sort_unstable();
    let groups = keyed.chunk_by(|a, b| a.0 == b.0);
    let alone = groups.filter(|group| group.len() == 1);
    alone.map(|group| group[0].1).collect()
}
