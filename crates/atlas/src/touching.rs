//! Texels of coordinates that were kept from the file, of which one look-up mixes surfaces that do not go on in each
//! other: charts that lie side by side without a gutter.

use crate::types::TILE;
use crate::uv::{corners, twice_area};
use crate::{Atlas, Footprint, PageRaster, Tile};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use scene::Scene;

/// Cosine of the turn from which two surfaces are not one: 60 degrees.
pub(crate) const TURN: f64 = 0.5;

/// Texels side by side are as many texels apart in space at most, where they are of one surface.
const JUMP: f64 = 8.0;

/// The surface of a texel.
#[derive(Clone, Copy)]
struct Place {
    instance: u32,
    position: DVec3,
    normal: DVec3,
    /// Edge of a texel, in scene units.
    step: f64,
}

impl Place {
    fn goes_on_in(&self, other: &Self) -> bool {
        let apart = self.position.distance(other.position);
        self.normal.dot(other.normal) >= TURN && apart <= JUMP * self.step.max(other.step)
    }
}

/// Texels of some rows of a page: the surface of each, and whether it holds another that this does not go on in.
type Rows = Vec<Option<(Place, bool)>>;

/// Share of the texels from which charts that touch are told of, or packed apart.
pub const LEAST_TOUCHING: f64 = 1e-3;

/// True where enough look-ups of the atlas mix surfaces to be told of.
pub(crate) fn is_touching(scene: &Scene, atlas: &Atlas) -> bool {
    let texels = touching(scene, atlas).map_or(0, |found| found.0);
    texels as f64 >= LEAST_TOUCHING * atlas.audit.texels.max(1) as f64
}

/// How many texels hold, or have beside them, a surface that their own does not go on in, and one of the instances
/// that have any.
pub fn touching(scene: &Scene, atlas: &Atlas) -> Option<(u64, u32)> {
    let width = atlas.page_size as usize;
    let across = atlas.page_size.div_ceil(TILE);
    let (mut count, mut first) = (0, None);
    for page in 0..atlas.page_count {
        let raster = PageRaster::new(scene, atlas, page);
        let tiles: Vec<(usize, u32)> = raster.tiles().iter().copied().enumerate().collect();
        let mut above: Option<(u32, Rows)> = None;
        for band in tiles.chunk_by(|a, b| a.1 / across == b.1 / across) {
            let found = band
                .par_iter()
                .map(|&(tile, _)| of_tile(scene, atlas, &raster.whole_tile(tile, |_| true)));
            let found: Vec<Vec<(u32, u32, Place, bool)>> = found.collect();
            // A row before those of the band, where the band above has any.
            let number = band[0].1 / across;
            let mut rows: Rows = match above.take() {
                Some((last, rows)) if last + 1 == number => rows[rows.len() - width..].to_vec(),
                _ => vec![None; width],
            };
            rows.resize(width * (TILE as usize + 1), None);
            let mut mark = |texel: &mut (Place, bool)| {
                if !texel.1 {
                    texel.1 = true;
                    count += 1;
                    first.get_or_insert(texel.0.instance);
                }
            };
            for (x, y, place, mixed) in found.into_iter().flatten() {
                let texel = rows[((y - number * TILE + 1) as usize) * width + x as usize]
                    .insert((place, false));
                if mixed {
                    mark(texel);
                }
            }
            for at in 0..rows.len() {
                let right = Some(at + 1).filter(|right| !right.is_multiple_of(width));
                for other in right.into_iter().chain([at + width]) {
                    if let Ok([Some(a), Some(b)]) = rows.get_disjoint_mut([at, other])
                        && !a.0.goes_on_in(&b.0)
                    {
                        mark(a);
                        mark(b);
                    }
                }
            }
            above = Some((number, rows));
        }
    }
    first.map(|first| (count, first))
}

/// Column, row and surface of each texel of a tile, and whether it holds another that this does not go on in.
fn of_tile(scene: &Scene, atlas: &Atlas, tile: &Tile) -> Vec<(u32, u32, Place, bool)> {
    let facets = tile.triangles.iter();
    let facets: Vec<Option<Facet>> = facets.map(|&of| Facet::of(scene, atlas, of)).collect();
    let texel = |footprint: &Footprint| {
        let mut places = (tile.middles(footprint))
            .filter_map(|(number, weights)| Some(facets[number as usize].as_ref()?.at(weights)));
        let first = places.next()?;
        let mixed = places.any(|place| !first.goes_on_in(&place));
        Some((footprint.x, footprint.y, first, mixed))
    };
    tile.footprints.iter().filter_map(texel).collect()
}

/// A triangle in space, by its corners as columns, and what all its places have in common.
struct Facet {
    corners: DMat3,
    common: Place,
}

impl Facet {
    /// `None` where the triangle has no area.
    fn of(scene: &Scene, atlas: &Atlas, [instance, triangle]: [u32; 2]) -> Option<Self> {
        let object = &scene.instances[instance as usize];
        let mesh = &scene.meshes[object.mesh as usize];
        let at = |vertex: u32| {
            let position = mesh.positions[vertex as usize].as_dvec3();
            object.transform.transform_point3(position)
        };
        let [a, b, c] = mesh.triangles[triangle as usize].map(at);
        let across = (b - a).cross(c - a);
        let layout = &atlas.meshes[object.mesh as usize];
        let placement = &atlas.placements[instance as usize];
        let size = f64::from(atlas.page_size);
        let texels = twice_area(corners(layout, placement, triangle as usize, size)).abs();
        let common = Place {
            instance,
            position: a,
            normal: across.try_normalize()?,
            step: (across.length() / texels).sqrt(),
        };
        Some(Self {
            corners: DMat3::from_cols(a, b, c),
            common,
        })
    }

    /// The surface at weights of the corners.
    fn at(&self, weights: DVec3) -> Place {
        Place {
            position: self.corners * weights,
            ..self.common
        }
    }
}
