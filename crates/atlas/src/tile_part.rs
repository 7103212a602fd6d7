//! What of a triangle meets a tile: enough to say what the tile's footprints depend on, and cheaper than to cut them
//! out.

use crate::PageRaster;
use crate::clip::Polygon;
use crate::types::TILE;
use glam::{DVec2, DVec3};

/// A tile's part is cut this much larger, in texels, than the tile is.
const SLACK: f64 = 1e-3;

/// A triangle that meets a tile.
#[derive(Debug, Clone)]
pub struct TilePart {
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Triangle of the instance's mesh.
    pub triangle: u32,
    /// Its corners in texels of the page.
    pub corners: [DVec2; 3],
    /// Barycentric weights of points whose convex hull holds everything of the triangle that lies in the tile.
    pub hull: Vec<DVec3>,
}

impl PageRaster<'_> {
    /// All triangles that meet the tile `self.tiles()[index]`, in the order in which its footprints take them.
    ///
    /// # Panics
    ///
    /// If `index` is not below the number of tiles.
    pub fn parts(&self, index: usize) -> impl Iterator<Item = TilePart> + '_ {
        let origin = self.tile_origin(index).map(f64::from);
        self.triangles(index).map(move |(entry, corners)| {
            let whole = Polygon::triangle(corners);
            let mut part = whole.clone();
            let [mut low, mut inside, mut high] = [const { Polygon::EMPTY }; 3];
            for (axis, start) in origin.into_iter().enumerate() {
                part.split(axis, start - SLACK, &mut low, &mut inside);
                inside.split(axis, start + f64::from(TILE) + SLACK, &mut part, &mut high);
            }
            // One that only touches the tile leaves nothing; it counts whole.
            let kept = if part.corners().is_empty() {
                &whole
            } else {
                &part
            };
            TilePart {
                instance: entry[0],
                triangle: entry[1],
                corners,
                hull: kept.corners().iter().map(|corner| corner.w).collect(),
            }
        })
    }
}
