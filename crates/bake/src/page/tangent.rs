//! The layer `bent.tangent`: bent normals in the frames in which engines read normal maps.

use super::planes::{BakedPage, LayerPlanes};
use atlas::{Atlas, Dilation, PageRaster, Tile};
use glam::DVec3;
use layers::Layer;
use rayon::prelude::*;
use rays::{Frames, World};

/// The layer that a layer is made of, itself but for this one.
pub(super) fn source(layer: Layer) -> Layer {
    match layer {
        Layer::BentTangent => Layer::Bent,
        other => other,
    }
}

/// Makes the layer of the finished bent normals. The pieces of a texel may have frames that differ: it has the mean of
/// what they make of its bent normal, of unit length.
///
/// * `rings`: how many rings of gutter are filled.
pub(super) fn make(
    page: &mut BakedPage,
    world: &World,
    atlas: &Atlas,
    raster: &PageRaster<'_>,
    rings: u32,
) {
    let (texels, size) = (page.texels(), page.size as usize);
    let plane = |channel| page.channel(Layer::Bent, channel).unwrap_or_default();
    let bent = [0, 1, 2].map(plane);
    let frames = Frames::new(world, |mesh, triangle| {
        let layout = &atlas.meshes[mesh as usize];
        layout.triangles[triangle as usize].map(|vertex| layout.uvs[vertex as usize])
    });
    let of_tile = |tile: Tile| {
        let mut found = Vec::with_capacity(tile.footprints.len());
        for footprint in &tile.footprints {
            let texel = footprint.y as usize * size + footprint.x as usize;
            let direction = DVec3::from(bent.map(|plane| f64::from(plane[texel])));
            let (mut sum, mut before) = (DVec3::ZERO, 0.0);
            for piece in tile.pieces_of(footprint) {
                let [a, b, c] = piece.corners;
                let middle = match piece.square {
                    true => (b + c) / 2.0,
                    false => (a + b + c) / 3.0,
                };
                let local = frames.local(piece.instance, piece.triangle, middle, direction);
                sum += local * (piece.cumulative - before);
                before = piece.cumulative;
            }
            found.push((texel, sum.normalize_or_zero()));
        }
        found
    };
    let tiles = (0..raster.tiles().len()).into_par_iter().with_max_len(1);
    let found: Vec<(usize, DVec3)> = tiles
        .flat_map_iter(|index| of_tile(raster.tile(index)))
        .collect();
    let mut made = LayerPlanes::void(Layer::BentTangent, texels);
    let mut put = |texel: usize, value: DVec3| {
        for (channel, value) in value.to_array().into_iter().enumerate() {
            made.values[channel * texels + texel] = value as f32;
        }
    };
    found
        .into_iter()
        .for_each(|(texel, local)| put(texel, local));
    let coverage = page.layer(Layer::Coverage).unwrap_or_default();
    let dilation = Dilation::new(coverage, page.size, rings);
    let planes = made.values.chunks_mut(texels);
    planes.for_each(|plane| dilation.apply(plane));
    for &target in dilation.targets() {
        let at = [0, 1, 2].map(|channel| channel * texels + target as usize);
        let unit = DVec3::from(at.map(|at| f64::from(made.values[at]))).normalize_or_zero();
        at.into_iter()
            .zip(unit.to_array())
            .for_each(|(at, value)| made.values[at] = value as f32);
    }
    page.planes.push(made);
}
