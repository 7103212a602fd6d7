//! How large a page has to be for the charts of a layout.

use crate::measure::charts;
use crate::uv::{corners, twice_area};
use crate::{Atlas, Options};
use glam::DVec2;
use scene::Scene;

/// The share of a page that is to be inside charts.
const INSIDE: f64 = 0.25;
/// The share of a page that charts with their gutters fill about.
const FILL: f64 = 0.9;
/// The largest page.
const LARGEST: u32 = 16384;

/// The least power of two that, as the edge of a page, holds all charts of this layout with a quarter of the page
/// inside them; `None` where no page does.
///
/// A chart of area a, w by h texels, takes a k² + e (w + h) k + e² texels with its gutter when it is k times as large,
/// where e is twice the gutter and what it touches beyond its border.
pub fn roomy_size(scene: &Scene, atlas: &Atlas) -> Option<u32> {
    let edge = f64::from(2 * atlas.gutter + 1);
    let of_mesh: Vec<Vec<u32>> = atlas.meshes.iter().map(charts).collect();
    let (mut area, mut edges, mut count) = (0.0, 0.0, 0.0);
    for (instance, placement) in scene.instances.iter().zip(&atlas.placements) {
        if !placement.is_somewhere() {
            continue;
        }
        let (layout, charts) = (
            &atlas.meshes[instance.mesh as usize],
            &of_mesh[instance.mesh as usize],
        );
        let all = charts.iter().max().map_or(0, |&last| last as usize + 1);
        let mut boxes = vec![[DVec2::INFINITY, DVec2::NEG_INFINITY]; all];
        for (triangle, &chart) in charts.iter().enumerate() {
            let corners = corners(layout, placement, triangle, f64::from(atlas.page_size));
            area += 0.5 * twice_area(corners).abs();
            let [low, high] = &mut boxes[chart as usize];
            for corner in corners {
                (*low, *high) = (low.min(corner), high.max(corner));
            }
        }
        edges += boxes
            .iter()
            .map(|[low, high]| (*high - *low).element_sum())
            .sum::<f64>();
        count += all as f64;
    }
    let fits = |size: f64| {
        let scale = (INSIDE * size * size / area).sqrt();
        let rims = edge * edges * scale + edge * edge * count;
        INSIDE * size * size + rims <= FILL * size * size
    };
    let sizes = (0..).map(|power| 1u32 << power);
    let mut sizes = sizes.take_while(|&size| size <= LARGEST);
    sizes.find(|&size| area > 0.0 && fits(f64::from(size)))
}

impl Options {
    /// True where the size of a page decides how fine the layout is: no object was given a density.
    pub fn is_shared(&self) -> bool {
        self.density.is_none() && self.density_of.is_empty()
    }
}
