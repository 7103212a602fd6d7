//! The raster audit of a layout: overlaps, missing triangles, coordinates outside the page.

use crate::raster::PageRaster;
use crate::types::TILE;
use crate::uv::{corners, place, twice_area};
use crate::{Atlas, Audit};
use glam::DVec2;
use rayon::prelude::*;
use scene::Scene;

/// What the audit found, and the first mesh that each finding is about.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    pub audit: Audit,
    pub overlapping: Option<u32>,
    /// Instance and triangle of what lies over others.
    pub over: Vec<[u32; 2]>,
    pub missing: Option<u32>,
    pub outside: Option<u32>,
}

impl Findings {
    /// Nothing overlaps, nothing is missing, nothing lies outside.
    pub fn clean(&self) -> bool {
        let a = &self.audit;
        a.overlaps == 0 && a.missing == 0 && a.outside == 0
    }

    /// The first mesh that any finding is about.
    pub fn mesh(&self) -> Option<u32> {
        self.overlapping.or(self.missing).or(self.outside)
    }
}

/// Sample points on the edge of a texel.
const SAMPLES: u32 = 4;
/// Sample points on the edge of a tile: one bit each.
const ROW: u32 = SAMPLES * TILE;

/// Audits all pages. A sample point counts as inside a triangle when it is further from every edge than 32-bit
/// coordinates can tell, so charts that share a border do not overlap.
pub(crate) fn audit(scene: &Scene, atlas: &Atlas) -> Findings {
    let mut findings = Findings::default();
    let objects = scene.instances.iter().zip(&atlas.placements);
    for (instance, placement) in objects.filter(|(_, p)| p.is_somewhere()) {
        let layout = &atlas.meshes[instance.mesh as usize];
        let outside = |p: DVec2| !(p.min_element() >= 0.0 && p.max_element() <= 1.0);
        let flat = |t: &usize| twice_area(corners(layout, placement, *t, 1.0)) == 0.0;
        let off = layout.uvs.par_iter();
        let off = off.filter(|&&v| outside(place(v, placement))).count() as u64;
        let triangles = (0..layout.triangles.len()).into_par_iter();
        let flat = triangles.filter(flat).count() as u64;
        findings.audit.outside += off;
        findings.audit.missing += flat;
        for (count, first) in [(off, &mut findings.outside), (flat, &mut findings.missing)] {
            if count > 0 {
                first.get_or_insert(instance.mesh);
            }
        }
    }
    for page in 0..atlas.page_count {
        let raster = PageRaster::new(scene, atlas, page);
        let tiles: Vec<(u64, Vec<[u32; 2]>, u64)> = (0..raster.tiles().len())
            .into_par_iter()
            .with_max_len(1)
            .map(|i| {
                let samples = Samples::of(&raster, i, atlas.page_size);
                let texels = raster.texels(i, |texel| samples.certain(texel));
                (samples.twice, samples.over, texels)
            })
            .collect();
        for (overlaps, over, texels) in tiles {
            findings.audit.overlaps += overlaps;
            findings.audit.texels += texels;
            if let Some([instance, _]) = over.first() {
                let mesh = scene.instances[*instance as usize].mesh;
                findings.overlapping.get_or_insert(mesh);
            }
            findings.over.extend(over);
        }
    }
    findings
}

/// The sample points of a tile.
struct Samples {
    /// Those strictly inside more than one triangle, and the triangles, each with its instance, that have such a point
    /// after another.
    twice: u64,
    over: Vec<[u32; 2]>,
    /// Those inside of triangles of which no texel about them can take a sliver only, row by row.
    inside: [u64; ROW as usize],
}

/// Triangles of up to this share of a page, by area, take more than a sliver of a texel that has a sample point inside
/// of them: a disc of two units in the last place about the point is more than 1e-12 of the triangle, a hundred times
/// the least part that is cut out.
const SMALL: f64 = 0.01;

impl Samples {
    fn of(raster: &PageRaster, tile: usize, size: u32) -> Self {
        let mut seen = [0u64; ROW as usize];
        let mut twice = [0u64; ROW as usize];
        let (mut over, mut inside) = (Vec::new(), [0u64; ROW as usize]);
        let origin = DVec2::from(raster.tile_origin(tile).map(f64::from));
        // Two units in the last place of a coordinate in 0.5..1.
        let inset = f64::from(size) * 0.5f64.powi(23);
        for (triangle, corners) in raster.triangles(tile) {
            let small = twice_area(corners).abs() < 2.0 * SMALL * f64::from(size).powi(2);
            scan(corners.map(|p| p - origin), inset, |row, mask| {
                let both = seen[row] & mask;
                seen[row] |= mask;
                twice[row] |= both;
                if both != 0 && over.last() != Some(&triangle) {
                    over.push(triangle);
                }
                if small {
                    inside[row] |= mask;
                }
            });
        }
        Self {
            twice: twice.iter().map(|r| u64::from(r.count_ones())).sum(),
            over,
            inside,
        }
    }

    /// True where a texel of the tile, row-major, is covered for certain.
    fn certain(&self, texel: u16) -> bool {
        let [x, y] = [u32::from(texel) % TILE, u32::from(texel) / TILE];
        let own = ((1 << SAMPLES) - 1) << (SAMPLES * x);
        let rows = (SAMPLES * y) as usize..(SAMPLES * (y + 1)) as usize;
        self.inside[rows].iter().any(|row| row & own != 0)
    }
}

/// Calls `found` with each row of sample points and the bits of those further than `inset` inside the triangle.
fn scan(p: [DVec2; 3], inset: f64, mut found: impl FnMut(usize, u64)) {
    let turn = twice_area(p).signum();
    let edges = [(p[0], p[1]), (p[1], p[2]), (p[2], p[0])].map(|(a, b)| {
        let n = (b - a).normalize_or_zero().perp() * turn;
        (n, n.dot(a) + inset)
    });
    let samples = f64::from(SAMPLES);
    let row_of = |y: f64| (y * samples - 0.5).clamp(-1.0, f64::from(ROW));
    let first = row_of(p[0].y.min(p[1].y).min(p[2].y)).ceil().max(0.0) as u32;
    let last = row_of(p[0].y.max(p[1].y).max(p[2].y)).floor();
    for row in first..(last + 1.0).clamp(0.0, f64::from(ROW)) as u32 {
        let y = (f64::from(row) + 0.5) / samples;
        let (mut low, mut high) = (-1.0, f64::from(ROW));
        for (n, limit) in edges {
            let rest = limit - n.y * y;
            // In sample numbers: those above `at`, or those below, are inside this edge.
            let at = rest / n.x * samples - 0.5;
            if n.x > 0.0 {
                low = at.max(low);
            } else if n.x < 0.0 {
                high = at.min(high);
            } else if rest >= 0.0 {
                high = -1.0;
            }
        }
        let from = low.floor() + 1.0;
        let to = high.ceil();
        if from < to {
            let bits = (to - from) as u32;
            let mask = (!0u64 >> (ROW - bits)) << from as u32;
            found(row as usize, mask);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_hold_the_sample_points_inside_of_a_triangle() {
        let found = |corners: [[f64; 2]; 3]| {
            let mut rows = vec![0u64; ROW as usize];
            scan(corners.map(DVec2::from), 0.0, |row, bits| rows[row] |= bits);
            rows
        };
        // Over the whole tile, and over the half up to its diagonal.
        let whole = found([[-10.0, -10.0], [60.0, -10.0], [-10.0, 60.0]]);
        assert!(whole.iter().all(|&row| row == u64::MAX), "{whole:x?}");
        let half = found([[0.0, 0.0], [16.1, 0.0], [0.0, 16.1]]);
        for (row, bits) in half.iter().enumerate() {
            assert_eq!(*bits, u64::MAX >> row, "row {row}");
        }
    }
}
