//! An index of a page's triangles by tile. Footprints are cut out on demand, a tile at a time.

use crate::centre::draw_together;
use crate::cover::Wholes;
use crate::cutter::{Cutter, covered};
use crate::footprint::{Collector, Footprint, Tile};
use crate::types::TILE;
use crate::uv::{corners, page, twice_area};
use crate::{Atlas, MeshLayout, Placement};
use glam::DVec2;
use rayon::prelude::*;
use scene::Scene;
use std::sync::{Arc, Mutex, PoisonError};

/// The triangles of one page, by tile. Shared by reference between threads.
pub struct PageRaster<'a> {
    layouts: &'a [MeshLayout],
    placements: &'a [Placement],
    page_size: u32,
    index: Arc<Index>,
}

/// What of a raster is found by looking at every triangle.
#[derive(Debug)]
struct Index {
    /// Mesh of each instance.
    meshes: Vec<u32>,
    /// Tile numbers with at least one triangle, ascending.
    tiles: Vec<u32>,
    /// Where each tile's entries begin, one more than `tiles`.
    starts: Vec<usize>,
    /// Instance and triangle.
    entries: Vec<[u32; 2]>,
}

/// The rasters of an atlas, of which the last is kept: the steps of a bake take a page one after another.
#[derive(Debug, Default)]
pub struct Rasters(Mutex<Option<(u32, Arc<Index>)>>);

impl Rasters {
    /// The index of page `page`, as [`PageRaster::new`] makes it. Scene and atlas are the same at each call.
    pub fn page<'a>(&self, scene: &Scene, atlas: &'a Atlas, page: u32) -> PageRaster<'a> {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let index = match &*last {
            Some((number, index)) if *number == page => Arc::clone(index),
            _ => Arc::new(Index::new(scene, atlas, page)),
        };
        *last = Some((page, Arc::clone(&index)));
        PageRaster::with(atlas, index)
    }
}

/// Triangles of an instance that are binned together.
const VISITED: usize = 1 << 14;

/// Parts of a texel to which centroids are told.
const GRAIN: f64 = (1 << 20) as f64;

/// Tiles are binned this much larger, in texels, than they are: far above the rounding of the test, so none is missed.
const SLACK: f64 = 1e-6;

impl<'a> PageRaster<'a> {
    /// The index of page `page`. Triangles without area are left out.
    pub fn new(scene: &Scene, atlas: &'a Atlas, page: u32) -> PageRaster<'a> {
        Self::with(atlas, Arc::new(Index::new(scene, atlas, page)))
    }

    fn with(atlas: &'a Atlas, index: Arc<Index>) -> PageRaster<'a> {
        PageRaster {
            layouts: &atlas.meshes,
            placements: &atlas.placements,
            page_size: atlas.page_size,
            index,
        }
    }

    /// Numbers (row-major over the page) of the tiles that triangles meet, ascending.
    pub fn tiles(&self) -> &[u32] {
        &self.index.tiles
    }

    /// The footprints of the tile `self.tiles()[index]`, cut out anew on each call.
    ///
    /// # Panics
    ///
    /// If `index` is not below the number of tiles.
    pub fn tile(&self, index: usize) -> Tile {
        let [x0, y0] = self.tile_origin(index);
        let triangles = self.triangles(index);
        let tile = [x0, y0, self.page_size];
        let mut collector = Collector::new(tile, Wholes::none(), triangles.len());
        for (entry, corners) in triangles {
            collector.add(entry, corners);
        }
        collector.finish()
    }

    /// The same, where texels that triangles of one object cover wholly hold these uncut ([`Footprint::is_whole`]) if
    /// all of them are `kept`, by instance and triangle.
    ///
    /// # Panics
    ///
    /// If `index` is not below the number of tiles.
    pub fn whole_tile(&self, index: usize, kept: impl Fn([u32; 2]) -> bool) -> Tile {
        let [x0, y0] = self.tile_origin(index);
        let triangles: Vec<([u32; 2], [DVec2; 3])> = self.triangles(index).collect();
        if Wholes::are_rare(triangles.len()) {
            return self.tile(index);
        }
        let corners = triangles.iter().map(|&(_, corners)| corners);
        let tile = [x0, y0, self.page_size];
        let wholes = Wholes::of(tile, corners, |number| {
            let (entry, _) = triangles[number];
            (entry[0], kept(entry))
        });
        let mut collector = Collector::new(tile, wholes, triangles.len());
        for (entry, corners) in triangles {
            collector.add(entry, corners);
        }
        collector.finish()
    }

    /// How many texels of a tile triangles cover: as many as [`PageRaster::tile`] has footprints. Of texels of the
    /// tile, row-major, that are `known` to be covered no more is asked.
    pub(crate) fn texels(&self, index: usize, known: impl Fn(u16) -> bool) -> u64 {
        let [x0, y0] = self.tile_origin(index);
        let cutter = Cutter::new(x0, y0, self.page_size);
        let triangles = self.triangles(index).map(|(_, corners)| corners);
        covered(cutter, known, triangles)
    }

    /// The centroid of a footprint, in texels of the page, without its last bits: a look-up at the centre of a whole
    /// texel, found a rounding beside it, would read that texel's neighbours too.
    ///
    /// # Panics
    ///
    /// If the footprint is not one of this tile's.
    pub fn middle(&self, tile: &Tile, footprint: &Footprint) -> DVec2 {
        let pieces = tile.pieces_of(footprint);
        let (mut sum, mut before) = (DVec2::ZERO, 0.0);
        for piece in pieces {
            let layout = &self.layouts[self.index.meshes[piece.instance as usize] as usize];
            let placement = &self.placements[piece.instance as usize];
            let size = f64::from(self.page_size);
            let [p, q, r] = corners(layout, placement, piece.triangle as usize, size);
            let [a, b, c] = piece.corners;
            let w = if piece.square {
                (b + c) / 2.0
            } else {
                (a + b + c) / 3.0
            };
            sum += (p * w.x + q * w.y + r * w.z) * (piece.cumulative - before);
            before = piece.cumulative;
        }
        (sum / before * GRAIN).round() / GRAIN
    }

    /// The same with each footprint drawn together into its point nearest to the texel's centre.
    ///
    /// # Panics
    ///
    /// If `index` is not below the number of tiles.
    pub fn centres(&self, index: usize) -> Tile {
        let mut tile = self.tile(index);
        draw_together(&mut tile, |instance, triangle| {
            let layout = &self.layouts[self.index.meshes[instance as usize] as usize];
            let placement = &self.placements[instance as usize];
            corners(
                layout,
                placement,
                triangle as usize,
                f64::from(self.page_size),
            )
        });
        tile
    }

    /// Instance and triangle of all that meets a tile, and about how many texels of it each covers: its own area, and
    /// at most that of the part of its bounds inside of the tile.
    ///
    /// # Panics
    ///
    /// If `index` is not below the number of tiles.
    pub fn areas(&self, index: usize) -> impl Iterator<Item = ([u32; 2], f64)> + '_ {
        let origin = DVec2::from(self.tile_origin(index).map(f64::from));
        self.triangles(index).map(move |(entry, p)| {
            let low = p[0].min(p[1]).min(p[2]).max(origin);
            let high = p[0].max(p[1]).max(p[2]).min(origin + f64::from(TILE));
            let bounds = (high - low).max(DVec2::ZERO).element_product();
            (entry, bounds.min(twice_area(p).abs() / 2.0))
        })
    }

    /// First column and row of a tile.
    pub(crate) fn tile_origin(&self, index: usize) -> [u32; 2] {
        let (number, across) = (self.index.tiles[index], self.page_size.div_ceil(TILE));
        [number % across * TILE, number / across * TILE]
    }

    /// Instance and triangle, and the corners in texels, of all that meets a tile.
    pub(crate) fn triangles(
        &self,
        index: usize,
    ) -> impl ExactSizeIterator<Item = ([u32; 2], [DVec2; 3])> + '_ {
        let size = f64::from(self.page_size);
        let of = &self.index;
        of.entries[of.starts[index]..of.starts[index + 1]]
            .iter()
            .map(move |&entry| {
                let [instance, triangle] = entry.map(|i| i as usize);
                let layout = &self.layouts[of.meshes[instance] as usize];
                (
                    entry,
                    corners(layout, &self.placements[instance], triangle, size),
                )
            })
    }
}

impl Index {
    fn new(scene: &Scene, atlas: &Atlas, page: u32) -> Self {
        let meshes: Vec<u32> = scene.instances.iter().map(|i| i.mesh).collect();
        let across = atlas.page_size.div_ceil(TILE);
        let found = visit(&meshes, atlas, page);
        let mut counts = vec![0u32; (across * across) as usize];
        for &(tile, _) in found.iter().flatten() {
            counts[tile as usize] += 1;
        }
        let (mut tiles, mut starts) = (Vec::new(), vec![0]);
        // From here `counts` holds where the next entry of a tile goes, counted from the tile's place.
        let mut slots = vec![0usize; counts.len()];
        for (tile, &count) in counts.iter().enumerate() {
            if count > 0 {
                slots[tile] = starts[tiles.len()];
                tiles.push(tile as u32);
                starts.push(slots[tile] + count as usize);
            }
        }
        let mut entries = vec![[0; 2]; starts[tiles.len()]];
        for (tile, entry) in found.into_iter().flatten() {
            let slot = &mut slots[tile as usize];
            entries[*slot] = entry;
            *slot += 1;
        }
        Self {
            meshes,
            tiles,
            starts,
            entries,
        }
    }
}

/// Every tile with an instance and a triangle that meet on the page, in order of instance and triangle, in parts.
fn visit(meshes: &[u32], atlas: &Atlas, wanted: u32) -> Vec<Vec<(u32, [u32; 2])>> {
    let across = atlas.page_size.div_ceil(TILE);
    let objects = meshes.iter().zip(&atlas.placements).enumerate();
    let objects = objects.filter(|(_, (mesh, placement))| {
        let on_one_page = atlas.meshes[**mesh as usize].triangle_pages.is_empty();
        placement.page == wanted || (placement.page < wanted && !on_one_page)
    });
    let jobs = objects.flat_map(|(instance, (&mesh, placement))| {
        let layout = &atlas.meshes[mesh as usize];
        let starts = (0..layout.triangles.len()).step_by(VISITED);
        starts.map(move |start| (instance, layout, placement, start))
    });
    let jobs: Vec<_> = jobs.collect();
    jobs.into_par_iter()
        .fold(
            Vec::new,
            |mut found, (instance, layout, placement, start)| {
                for triangle in start..layout.triangles.len().min(start + VISITED) {
                    let corners = corners(layout, placement, triangle, f64::from(atlas.page_size));
                    if page(layout, placement, triangle) == wanted && twice_area(corners) != 0.0 {
                        let entry = [instance as u32, triangle as u32];
                        tiles_of(corners, across, |tile| found.push((tile, entry)));
                    }
                }
                found
            },
        )
        .collect()
}

/// Every tile that a triangle meets, and perhaps a few that it only touches.
fn tiles_of(p: [DVec2; 3], across: u32, mut found: impl FnMut(u32)) {
    let edge = f64::from(TILE);
    let low = p[0].min(p[1]).min(p[2]);
    let high = p[0].max(p[1]).max(p[2]);
    let first = |v: f64| ((v - SLACK) / edge).floor().clamp(0.0, f64::from(across)) as u32;
    let last = |v: f64| ((v + SLACK) / edge).ceil().clamp(0.0, f64::from(across)) as u32;
    let (columns, rows) = (first(low.x)..last(high.x), first(low.y)..last(high.y));
    let few = columns.len() <= 1 || rows.len() <= 1;
    let turn = twice_area(p).signum();
    // Inward normals: the tile is off when even its innermost corner is outside an edge.
    let edges = [(p[0], p[1]), (p[1], p[2]), (p[2], p[0])].map(|(a, b)| {
        let n = (b - a).perp() * turn;
        (a, n, n.abs().element_sum() * SLACK)
    });
    for ty in rows {
        for tx in columns.clone() {
            let corner = DVec2::new(f64::from(tx), f64::from(ty)) * edge;
            let meets = |&(a, n, slack): &(DVec2, DVec2, f64)| {
                let far = corner
                    + DVec2::new(
                        if n.x > 0.0 { edge } else { 0.0 },
                        if n.y > 0.0 { edge } else { 0.0 },
                    );
                (far - a).dot(n) >= -slack
            };
            if few || edges.iter().all(meets) {
                found(ty * across + tx);
            }
        }
    }
}
