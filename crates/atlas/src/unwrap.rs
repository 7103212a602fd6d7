//! Parts of a mesh handed to `uvunwrap`, which nothing but this file and `parts.rs` names, and the charts that come
//! back. See vendor-notes/uvunwrap.md.

use crate::Error;
use crate::flat::Face;
use crate::parts::Part;
use crate::sheet::Sheet;
use crate::told::OfMesh;
use glam::DVec2;
use scene::Mesh;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicUsize, Ordering};
use uvunwrap::{Density, MeshInput, Packing};

/// Charts of curved surfaces stay below this many triangles on average: flattening takes more than linear time.
const SOLVABLE: f64 = 200_000.0;
/// Edge of the pages on which charts are handed over, in texels, and the texels of a triangle there: coordinates are
/// rounded to 32 bits, a thousandth of a texel.
const HANDED: u32 = 8192;
const HANDED_TRIANGLE: f64 = 16.0;
/// The edges of a chart together are at most so many times as long as those of its triangles. A triangle may be four
/// times too large, its edges twice too long; where the unwrapper's solver fails it returns needles of the right area.
const LONGEST: f64 = 3.0;

/// How much is handed to the unwrapper at once.
#[derive(Clone, Copy)]
pub(crate) struct Handed {
    pub triangles: usize,
    /// In squared units of it.
    pub area: f64,
    /// What its unit is in units of the mesh.
    pub unit: f64,
}

/// A chart that the unwrapper made of a part.
#[derive(Default)]
struct Made {
    /// By their numbers in the part.
    triangles: Vec<usize>,
    /// Lengths of their edges and areas together, in the chart and in the part.
    lengths: [f64; 2],
    areas: [f64; 2],
    /// Its box, in texels of the unwrapper's page.
    low: DVec2,
    high: DVec2,
}

impl Made {
    /// The charts of a part by their numbers. `page` is the size of the unwrapper's page in texels, of which so many
    /// are one unit of the part.
    fn of(
        part: &Part,
        out: &uvunwrap::OutputMesh,
        (page, density): (DVec2, f64),
    ) -> BTreeMap<u32, Self> {
        let mut charts: BTreeMap<u32, Self> = BTreeMap::new();
        for (number, corners) in out.indices.chunks_exact(3).enumerate() {
            let corners = [corners[0], corners[1], corners[2]].map(|v| &out.vertices[v as usize]);
            let Some(chart) = corners[0].chart else {
                continue;
            };
            let made = charts.entry(chart).or_insert_with(|| Self {
                low: DVec2::INFINITY,
                ..Self::default()
            });
            made.triangles.push(number);
            // What is too thin for a chart has its corners anywhere.
            if corners.iter().all(|corner| corner.chart == Some(chart)) {
                let flat = corners.map(|corner| DVec2::from(corner.uv.map(f64::from)) * page);
                made.low = flat.into_iter().fold(made.low, DVec2::min);
                made.high = flat.into_iter().fold(made.high, DVec2::max);
                let flat = flat.map(|place| (place / density).extend(0.0));
                for (k, triangle) in [flat, part.corners(number)].into_iter().enumerate() {
                    let [a, b, c] = triangle;
                    made.lengths[k] += a.distance(b) + b.distance(c) + c.distance(a);
                    made.areas[k] += 0.5 * (b - a).cross(c - a).length();
                }
            }
        }
        charts
    }

    /// How many times too small it came out: more than 1 where it had to be made to fit the page.
    fn shrunk(&self) -> f64 {
        match (self.high - self.low).max_element() >= f64::from(HANDED - 1) {
            true => (self.areas[1] / self.areas[0]).sqrt(),
            false => 1.0,
        }
    }

    fn is_spoilt(&self) -> bool {
        let [flat, own] = self.lengths;
        let is_right = self.shrunk() * flat <= LONGEST * own;
        !is_right
    }
}

impl Sheet {
    /// Adds the charts that the unwrapper makes of parts of a mesh. What it could not flatten comes back as parts about
    /// 1 in size, each with what its unit is among those of `parts`.
    pub fn unwrap(
        &mut self,
        data: &Mesh,
        parts: &[Part],
        Handed {
            triangles,
            area,
            unit,
        }: Handed,
        told: &OfMesh<'_>,
    ) -> Result<Vec<(Part, f64)>, Error> {
        let count = triangles as f64;
        let most = match count > SOLVABLE {
            true => (area * SOLVABLE / count) as f32,
            false => 0.0,
        };
        let scale = (count.clamp(1e3, 2.5e5) * HANDED_TRIANGLE / area).sqrt();
        let scale = scale.min(f64::from(HANDED) / 2.0);
        let settings = uvunwrap::Options {
            density: Density::Fixed {
                texels_per_unit: scale as f32,
                page_size: Some(HANDED),
            },
            padding: 0,
            packing: Packing::Fast,
            max_chart_area: most,
            // Long charts may be longer than the mesh.
            max_chart_size: HANDED,
            ..uvunwrap::Options::default()
        };
        let inputs: Vec<MeshInput<'_>> = parts.iter().map(Part::input).collect();
        // The unwrapper counts the faces that it has laid flat; its calls do not overlap.
        let flat = AtomicUsize::new(0);
        let listen = |of: uvunwrap::Progress| {
            if of.stage == uvunwrap::Stage::Parameterizing {
                let before = flat.swap(of.done, Ordering::Relaxed);
                told.done(of.done.saturating_sub(before));
            }
            !told.cancelled()
        };
        let made = match uvunwrap::generate_with_progress(&inputs, &settings, listen) {
            Err(uvunwrap::Error::Cancelled) => return Err(Error::Cancelled),
            Err(other) => return Err(Error::Unwrap(other.to_string())),
            Ok(made) => made,
        };
        let density = f64::from(scale as f32);
        let page = DVec2::new(f64::from(made.width), f64::from(made.height));
        let texel = page * (unit / density);
        let (charts, points) = (self.charts.len(), self.points.len());
        self.charts
            .resize(charts + made.chart_count as usize, Vec::new());
        let (mut chart_of, mut spoilt) = (Vec::new(), Vec::new());
        let mut shrunk = vec![1.0; made.chart_count as usize];
        for (part, out) in parts.iter().zip(&made.meshes) {
            let charts_of = Made::of(part, out, (page, density));
            for (&chart, made) in &charts_of {
                shrunk[chart as usize] = made.shrunk();
                spoilt.extend(made.is_spoilt().then(|| part.some(&made.triangles)));
            }
            // Corners of the unwrapper's vertices by the mesh's own, which it does not know apart.
            let mut numbers = HashMap::new();
            for (&t, corners) in part.triangles.iter().zip(out.indices.chunks_exact(3)) {
                let first = corners[0];
                let chart = |made: &u32| out.vertices[*made as usize].chart;
                if chart(&first).is_some_and(|chart| charts_of[&chart].is_spoilt()) {
                    continue;
                }
                // One that is too thin for a chart may have its corners in several: it goes to the first.
                let is_parted = corners.iter().any(|made| chart(made) != chart(&corners[0]));
                let corners = corners.iter().zip(data.triangles[t as usize]);
                let mut number = |(&made, own): (&u32, u32)| {
                    let made = if is_parted { first } else { made };
                    *numbers.entry((made, own)).or_insert_with(|| {
                        let vertex = &out.vertices[made as usize];
                        let [u, v] = vertex.uv.map(f64::from);
                        self.sources.push(own);
                        self.points.push(DVec2::new(u, v) * texel);
                        chart_of.push(vertex.chart);
                        self.sources.len() as u32 - 1
                    })
                };
                let numbered: Vec<u32> = corners.map(&mut number).collect();
                self.triangles[t as usize] = [numbered[0], numbered[1], numbered[2]];
                if let Some(chart) = chart_of[numbered[0] as usize - points] {
                    self.charts[charts + chart as usize].push(t);
                }
            }
        }
        // Charts begin at (0, 0).
        let mut low = vec![DVec2::INFINITY; made.chart_count as usize];
        let places = |chart: &Option<u32>| chart.map(|c| c as usize);
        let own = &mut self.points[points..];
        for (p, chart) in own.iter().zip(chart_of.iter().map(places)) {
            if let Some(chart) = chart {
                low[chart] = low[chart].min(*p);
            }
        }
        for (p, chart) in own.iter_mut().zip(chart_of.iter().map(places)) {
            *p = chart.map_or(DVec2::ZERO, |chart| (*p - low[chart]) * shrunk[chart]);
        }
        self.charts.retain(|chart| !chart.is_empty());
        Ok(spoilt)
    }

    /// Adds a face as a chart; its units are `size` of the mesh's.
    pub fn add(&mut self, face: &Face, data: &Mesh, size: f64) {
        let mut numbers = HashMap::new();
        for (&t, places) in face.triangles.iter().zip(&face.places) {
            let mut number = |own: u32, place: DVec2| {
                // A triangle that is turned over lies elsewhere than its corners.
                let key = (own, place.to_array().map(f64::to_bits));
                *numbers.entry(key).or_insert_with(|| {
                    self.sources.push(own);
                    self.points.push(place * size);
                    self.sources.len() as u32 - 1
                })
            };
            let [a, b, c] = data.triangles[t as usize];
            let corners = [
                number(a, places[0]),
                number(b, places[1]),
                number(c, places[2]),
            ];
            self.triangles[t as usize] = corners;
        }
        self.charts.push(face.triangles.clone());
        self.move_to_origin(self.charts.len() - 1);
    }
}
