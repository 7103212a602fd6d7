//! `STEM.layout`: an atlas as a file, so that the shards of a bake need not each make it anew.
//!
//! It is a journal (see `checkpoint`): the header names what decides the layout; the first block is JSON (sizes,
//! placements, audit), then one block a mesh: for each layout vertex its source (u32) and its coordinates (2 f32), the
//! corners of the triangles (3 u32), the page of each triangle (u16) where they differ, and whether nobody sees it (a
//! byte, 1 or 0) where that is so of some. Numbers are little-endian.

use crate::{Error, Journal};
use atlas::{Atlas, MeshLayout};
use glam::Vec2;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// An atlas but for its meshes.
#[derive(Serialize, Deserialize)]
struct Head {
    page_size: u32,
    page_count: u32,
    gutter: u32,
    density: f64,
    chart_count: u32,
    source: atlas::UvSource,
    audit: atlas::Audit,
    notes: Vec<String>,
    placements: Vec<atlas::Placement>,
    /// Vertices, triangles and page numbers of each mesh.
    meshes: Vec<[usize; 3]>,
}

/// A hash over the whole atlas: two bakes with the same hash have the same layout.
pub fn layout_hash(atlas: &Atlas) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&head(atlas));
    for layout in &atlas.meshes {
        hasher.update(&mesh(layout));
    }
    hasher.finalize().to_hex().to_string()
}

/// Writes an atlas that `key` decides.
///
/// # Errors
/// [`Error::Write`].
pub fn write_layout(path: &Path, key: &Value, atlas: &Atlas) -> Result<(), Error> {
    let (mut journal, _) = Journal::resume(path, key, |_| false)?;
    for block in layout_blocks(atlas) {
        journal.append(&block)?;
    }
    Ok(())
}

/// An atlas as blocks of a journal.
pub fn layout_blocks(atlas: &Atlas) -> impl Iterator<Item = Vec<u8>> + '_ {
    std::iter::once(head(atlas)).chain(atlas.meshes.iter().map(mesh))
}

/// The atlas in these blocks; `None` where they hold something else. Whether it fits a scene is not asked.
pub fn layout_of_blocks(blocks: &[Vec<u8>]) -> Option<Atlas> {
    let (first, rest) = blocks.split_first()?;
    let head: Head = serde_json::from_slice(first).ok()?;
    if rest.len() != head.meshes.len() {
        return None;
    }
    let sound = |layout: &MeshLayout| {
        let vertices = layout.uvs.len() as u32;
        layout.triangles.iter().flatten().all(|&v| v < vertices)
            && layout.uvs.iter().all(|uv| uv.is_finite())
            && [0, layout.triangles.len()].contains(&layout.triangle_pages.len())
    };
    let meshes = rest.iter().zip(&head.meshes);
    let meshes = meshes.map(|(bytes, counts)| mesh_of(bytes, *counts).filter(sound));
    let meshes: Vec<MeshLayout> = meshes.collect::<Option<_>>()?;
    Some(head.with(meshes))
}

/// The atlas in the file at `path`; `None` where there is no such file, it was cut short, or `key` does not decide it.
///
/// # Errors
/// [`Error::Read`] for a file that is damaged, or that does not fit the scene.
pub fn read_layout(path: &Path, key: &Value, scene: &scene::Scene) -> Result<Option<Atlas>, Error> {
    let Some(mut journal) = Journal::open(path)? else {
        return Ok(None);
    };
    if journal.header() != key || journal.len() != 1 + scene.meshes.len() {
        return Ok(None);
    }
    let wrong = || Error::read(path, "it does not fit the scene: the file is damaged");
    let head: Head = serde_json::from_slice(&journal.block(0)?).map_err(|_| wrong())?;
    let mut meshes = Vec::with_capacity(scene.meshes.len());
    for (number, mesh) in scene.meshes.iter().enumerate() {
        let bytes = journal.block(1 + number)?;
        let counts = *head.meshes.get(number).ok_or_else(wrong)?;
        let layout = mesh_of(&bytes, counts).ok_or_else(wrong)?;
        let vertices = layout.uvs.len() as u32;
        let fits = layout.triangles.len() == mesh.triangles.len()
            && layout.triangles.iter().flatten().all(|&v| v < vertices)
            && layout
                .source_vertices
                .iter()
                .all(|&v| (v as usize) < mesh.positions.len())
            && layout.uvs.iter().all(|uv| uv.is_finite())
            && [0, mesh.triangles.len()].contains(&layout.triangle_pages.len());
        if !fits {
            return Err(wrong());
        }
        meshes.push(layout);
    }
    if !fits_pages(&head, &meshes, scene) {
        return Err(wrong());
    }
    Ok(Some(head.with(meshes)))
}

impl Head {
    fn with(self, meshes: Vec<MeshLayout>) -> Atlas {
        Atlas {
            page_size: self.page_size,
            page_count: self.page_count,
            gutter: self.gutter,
            meshes,
            placements: self.placements,
            source: self.source,
            audit: self.audit,
            density: self.density,
            chart_count: self.chart_count,
            notes: self.notes,
        }
    }
}

/// True where every object of the scene has a place, on pages that there are. No page is empty, so that there are no
/// more of them than triangles.
fn fits_pages(head: &Head, meshes: &[MeshLayout], scene: &scene::Scene) -> bool {
    let most = scene.instances.iter();
    let most = most.map(|i| scene.meshes[i.mesh as usize].triangles.len() as u64);
    let placed = |(instance, placement): (&scene::Instance, &atlas::Placement)| {
        let more = meshes[instance.mesh as usize].triangle_pages.iter().max();
        let last = u64::from(placement.page) + more.map_or(0, |&more| u64::from(more));
        let finite = placement.scale.iter().chain(&placement.offset);
        *placement == atlas::Placement::NOWHERE
            || last < u64::from(head.page_count) && finite.copied().all(f32::is_finite)
    };
    head.placements.len() == scene.instances.len()
        && (1..=most.sum::<u64>().max(1)).contains(&u64::from(head.page_count))
        && scene.instances.iter().zip(&head.placements).all(placed)
}

fn head(atlas: &Atlas) -> Vec<u8> {
    let counts = |mesh: &MeshLayout| {
        [
            mesh.uvs.len(),
            mesh.triangles.len(),
            mesh.triangle_pages.len(),
        ]
    };
    let head = Head {
        page_size: atlas.page_size,
        page_count: atlas.page_count,
        gutter: atlas.gutter,
        density: atlas.density,
        chart_count: atlas.chart_count,
        source: atlas.source,
        audit: atlas.audit,
        notes: atlas.notes.clone(),
        placements: atlas.placements.clone(),
        meshes: atlas.meshes.iter().map(counts).collect(),
    };
    serde_json::to_vec(&head).expect("plain structs become JSON")
}

fn mesh(layout: &MeshLayout) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(12 * (layout.uvs.len() + layout.triangles.len()));
    for source in &layout.source_vertices {
        bytes.extend(source.to_le_bytes());
    }
    for uv in &layout.uvs {
        bytes.extend(uv.to_array().map(f32::to_le_bytes).as_flattened());
    }
    for triangle in &layout.triangles {
        bytes.extend(triangle.map(u32::to_le_bytes).as_flattened());
    }
    for page in &layout.triangle_pages {
        bytes.extend(page.to_le_bytes());
    }
    bytes.extend(layout.hidden.iter().map(|&hidden| u8::from(hidden)));
    bytes
}

/// The layout of a mesh with so many vertices, triangles and page numbers; `None` where the bytes are more or fewer.
fn mesh_of(bytes: &[u8], [vertices, triangles, pages]: [usize; 3]) -> Option<MeshLayout> {
    let mut rest = bytes;
    let mut take = |count: usize, size: usize| {
        let (own, others) = rest.split_at_checked(count.checked_mul(size)?)?;
        rest = others;
        Some(own)
    };
    let words = |bytes: &[u8]| -> Vec<[u8; 4]> { bytes.as_chunks().0.to_vec() };
    let sources = words(take(vertices, 4)?);
    let uvs = words(take(vertices, 8)?);
    let corners = words(take(triangles, 12)?);
    let numbers = take(pages, 2)?.as_chunks::<2>().0.to_vec();
    [0, triangles].contains(&rest.len()).then(|| MeshLayout {
        source_vertices: sources.into_iter().map(u32::from_le_bytes).collect(),
        uvs: uvs
            .as_chunks()
            .0
            .iter()
            .map(|uv: &[[u8; 4]; 2]| Vec2::from(uv.map(f32::from_le_bytes)))
            .collect(),
        triangles: corners
            .as_chunks()
            .0
            .iter()
            .map(|corners: &[[u8; 4]; 3]| corners.map(u32::from_le_bytes))
            .collect(),
        triangle_pages: numbers.into_iter().map(u16::from_le_bytes).collect(),
        hidden: rest.iter().map(|&hidden| hidden != 0).collect(),
    })
}
