//! The charts of one mesh, each flat in a plane of its own, before they have places on pages.

use crate::mask::Mask;
use crate::pack::Shape;
use crate::uv::twice_area;
use glam::DVec2;
use rayon::prelude::*;

/// The part of a box that rounding takes from what fills it.
const ROUNDED: f64 = 1e-9;
/// Charts that one thread cuts at a time.
const FEW: usize = 8;

/// The charts of one mesh, each flat in a plane of its own.
#[derive(Clone)]
pub(crate) struct Sheet {
    pub mesh: usize,
    /// Instances that show it, with texels.
    pub instances: Vec<u32>,
    /// Mesh units to scene units, one an instance: 1 for a mesh placed once, which is flattened in its world shape.
    pub scales: Vec<f64>,
    /// For each vertex, the vertex of the mesh that it repeats.
    pub sources: Vec<u32>,
    /// Flat positions in mesh units; charts begin at (0, 0).
    pub points: Vec<DVec2>,
    pub triangles: Vec<[u32; 3]>,
    /// Triangles of each chart; some triangles have none.
    pub charts: Vec<Vec<u32>>,
    /// Charts that nobody sees: they take one texel.
    pub hidden: Vec<bool>,
}

impl Sheet {
    /// The scale of a chart where its mesh has `scale`.
    pub fn scale(&self, chart: usize, scale: f64) -> f64 {
        if !self.hidden[chart] {
            return scale;
        }
        let points = self.charts[chart]
            .iter()
            .flat_map(|&t| self.triangles[t as usize]);
        let extent = points.fold(0.0, |e: f64, v| {
            e.max(self.points[v as usize].max_element())
        });
        let texel = if extent > 0.0 { 1.0 / extent } else { 1.0 };
        // An object of which nothing is seen has no density of its own.
        if scale > 0.0 { scale.min(texel) } else { texel }
    }

    /// Makes a chart of a triangle of a chart of several; false where it is of none.
    pub fn part(&mut self, triangle: u32) -> bool {
        let has_it = |chart: &Vec<u32>| chart.len() > 1 && chart.contains(&triangle);
        let Some(chart) = self.charts.iter().position(has_it) else {
            return false;
        };
        self.charts[chart].retain(|&own| own != triangle);
        self.charts.push(vec![triangle]);
        self.hidden.push(self.hidden[chart]);
        let own = self.triangles[triangle as usize];
        self.triangles[triangle as usize] = own.map(|vertex| {
            self.sources.push(self.sources[vertex as usize]);
            self.points.push(self.points[vertex as usize]);
            self.sources.len() as u32 - 1
        });
        self.move_to_origin(self.charts.len() - 1);
        true
    }

    /// Moves the points of a chart, which no other chart has, so that it begins at (0, 0).
    pub fn move_to_origin(&mut self, chart: usize) {
        let corners = self.charts[chart].iter();
        let mut own: Vec<u32> = corners.flat_map(|&t| self.triangles[t as usize]).collect();
        own.sort_unstable();
        own.dedup();
        let low = own
            .iter()
            .map(|&v| self.points[v as usize])
            .reduce(DVec2::min);
        for v in own {
            self.points[v as usize] -= low.unwrap_or_default();
        }
    }

    /// The corners of a chart's triangles times `scale`.
    pub fn corners(&self, chart: usize, scale: f64) -> impl Iterator<Item = [DVec2; 3]> + '_ {
        let scale = self.scale(chart, scale);
        let triangles = self.charts[chart].iter();
        triangles.map(move |&t| self.triangles[t as usize].map(|v| self.points[v as usize] * scale))
    }

    /// The size of a chart's box times `scale`, in whole texels.
    pub fn size(&self, chart: usize, scale: f64) -> [u32; 2] {
        self.size_and_fill(chart, scale).0
    }

    /// The size, and whether its triangles fill the box, or are so large that they would without each other.
    pub fn size_and_fill(&self, chart: usize, scale: f64) -> ([u32; 2], bool) {
        let (mut high, mut twice) = (DVec2::ZERO, 0.0);
        for corners in self.corners(chart, scale) {
            high = corners.into_iter().fold(high, DVec2::max);
            twice += twice_area(corners).abs();
        }
        // What rounding adds is no texel more.
        let texels = (high - 1e-6).ceil().max(DVec2::ONE);
        let fills = 0.5 * twice >= (1.0 - ROUNDED) * high.element_product();
        (texels.to_array().map(|t| t as u32), fills)
    }

    /// The texels of each chart at so many texels a unit, in all quarter turns that differ; in a draft as they stand.
    pub fn shapes(&self, scale: f64, draft: bool) -> Vec<Shape> {
        let shape = |chart: usize| {
            let ([width, height], fills) = self.size_and_fill(chart, scale);
            let mask = match fills {
                true => Mask::full(width, height),
                false => Mask::of(self.corners(chart, scale), width, height),
            };
            if draft || mask.is_full() && width == height {
                return vec![mask];
            }
            if mask.is_full() {
                return vec![mask, Mask::full(height, width)];
            }
            let box_size = DVec2::new(f64::from(width), f64::from(height));
            let turned = self
                .corners(chart, scale)
                .map(|t| t.map(|p| turn(p, 1, box_size)));
            let quarter = Mask::of(turned, height, width);
            let half = mask.half_turn();
            if mask == half {
                return vec![mask, quarter];
            }
            let last = quarter.half_turn();
            vec![mask, quarter, half, last]
        };
        let charts = (0..self.charts.len()).into_par_iter();
        charts.with_min_len(FEW).map(shape).collect()
    }
}

/// A point of a box after quarter turns from +u to +v, in the turned box.
pub(crate) fn turn(p: DVec2, quarters: u8, size: DVec2) -> DVec2 {
    match quarters {
        0 => p,
        1 => DVec2::new(size.y - p.y, p.x),
        2 => size - p,
        _ => DVec2::new(p.y, size.x - p.x),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_that_is_parted_leaves_the_others_where_they_are() {
        let place = |x: f64, y: f64| DVec2::new(x, y);
        let mut sheet = Sheet {
            mesh: 0,
            instances: vec![0],
            scales: vec![1.0],
            sources: vec![7, 8, 9, 4],
            points: vec![
                place(0.0, 0.0),
                place(2.0, 0.0),
                place(2.0, 2.0),
                place(1.0, 1.0),
            ],
            triangles: vec![[0, 1, 2], [3, 1, 2]],
            charts: vec![vec![0, 1]],
            hidden: vec![true],
        };
        assert!(!sheet.part(2));
        assert!(sheet.part(1));
        assert_eq!(sheet.charts, [vec![0], vec![1]]);
        assert_eq!(sheet.hidden, [true, true]);
        let corners = |sheet: &Sheet, chart| sheet.corners(chart, 1.0).collect::<Vec<_>>();
        let half = [place(0.0, 0.0), place(1.0, 0.0), place(1.0, 1.0)];
        assert_eq!(corners(&sheet, 0), [half]);
        sheet.hidden.fill(false);
        let alone = [place(0.0, 1.0), place(1.0, 0.0), place(1.0, 2.0)];
        assert_eq!(corners(&sheet, 1), [alone]);
        assert_eq!(
            sheet.triangles[1].map(|v| sheet.sources[v as usize]),
            [4, 8, 9]
        );
        assert!(!sheet.part(0) && !sheet.part(1), "both are alone");
    }

    #[test]
    fn two_halves_fill_their_box_and_one_does_not() {
        let place = |x: f64, y: f64| DVec2::new(x, y);
        let sheet = Sheet {
            mesh: 0,
            instances: vec![0],
            scales: vec![1.0],
            sources: vec![0; 4],
            points: vec![
                place(0.0, 0.0),
                place(0.7, 0.0),
                place(0.7, 0.3),
                place(0.0, 0.3),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 1, 2]],
            charts: vec![vec![0, 1], vec![2]],
            hidden: vec![false; 2],
        };
        assert_eq!(sheet.size_and_fill(0, 10.0), ([7, 3], true));
        assert_eq!(sheet.size_and_fill(1, 11.0), ([8, 4], false));
    }
}
