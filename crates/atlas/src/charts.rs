//! Charts made by `uvunwrap`, which nothing outside this file names. See vendor-notes/uvunwrap.md.

use crate::Error;
use crate::flat::Face;
use crate::measure::{mesh_area, world_area};
use crate::parts::{Part, parts, weld};
use crate::twins::{self, Shape};
use glam::{DMat3, DVec2, DVec3, Vec3};
use rayon::prelude::*;
use scene::{Mesh, Scene};
use std::collections::{BTreeMap, HashMap};
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
        let corners = self.corners(chart, scale).flatten();
        let high = corners.fold(DVec2::ZERO, DVec2::max);
        // What rounding adds is no texel more.
        (high - 1e-6)
            .ceil()
            .max(DVec2::ONE)
            .to_array()
            .map(|t| t as u32)
    }
}

/// The instances of each mesh that are included, in order.
pub(crate) fn users(scene: &Scene, included: &[bool]) -> Vec<Vec<u32>> {
    let mut users = vec![Vec::new(); scene.meshes.len()];
    let instances = scene.instances.iter().zip(included).enumerate();
    for (i, (instance, _)) in instances.filter(|(_, (_, included))| **included) {
        users[instance.mesh as usize].push(i as u32);
    }
    users
}

/// The charts of every mesh that takes texels, in the order of meshes. `included` says which instances do.
pub(crate) fn sheets(
    scene: &Scene,
    included: &[bool],
    cancel: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Sheet>, Error> {
    let placed: Vec<(usize, Vec<u32>)> = users(scene, included)
        .into_iter()
        .enumerate()
        .filter(|(m, users)| !users.is_empty() && !scene.meshes[*m].triangles.is_empty())
        .collect();
    let placed: Vec<Placed> = placed
        .into_par_iter()
        .with_max_len(1)
        .map(|(mesh, instances)| Placed::new(scene, mesh, instances))
        .collect::<Result<_, _>>()?;
    let meshes: Vec<&Mesh> = placed.iter().map(|p| &scene.meshes[p.mesh]).collect();
    let sizes: Vec<[usize; 2]> = meshes
        .iter()
        .map(|mesh| [mesh.positions.len(), mesh.triangles.len()])
        .collect();
    let firsts = twins::firsts(&sizes, &|i| {
        let corners = placed[i].corners(meshes[i]);
        let welded = weld(meshes[i], &unit(meshes[i], &corners)?.positions);
        let triangles = &meshes[i].triangles;
        Some(Shape {
            triangles,
            corners,
            welded,
        })
    });
    let sheet =
        |(i, placed): (usize, &Placed)| (firsts[i] == i).then(|| sheet(scene, placed, cancel));
    let made: Vec<_> = placed
        .par_iter()
        .with_max_len(1)
        .enumerate()
        .map(sheet)
        .collect();
    let mut sheets: Vec<Sheet> = Vec::with_capacity(placed.len());
    for ((made, placed), first) in made.into_iter().zip(placed).zip(firsts) {
        let sheet = match made {
            Some(made) => made?,
            None => sheets[first].clone(),
        };
        sheets.push(Sheet {
            mesh: placed.mesh,
            instances: placed.instances,
            scales: placed.scales,
            ..sheet
        });
    }
    Ok(sheets)
}

/// A mesh that takes texels.
struct Placed {
    mesh: usize,
    instances: Vec<u32>,
    scales: Vec<f64>,
    /// The mesh as it is unwrapped.
    shape: DMat3,
}

impl Placed {
    fn new(scene: &Scene, mesh: usize, instances: Vec<u32>) -> Result<Self, Error> {
        let (shape, scales) = match instances[..] {
            [only] => (scene.instances[only as usize].transform.matrix3, vec![1.0]),
            _ => {
                let own = mesh_area(scene, mesh);
                let scale = |&i: &u32| (world_area(scene, i as usize) / own).sqrt();
                (DMat3::IDENTITY, instances.iter().map(scale).collect())
            }
        };
        if !scales.iter().all(|s: &f64| s.is_finite() && *s > 0.0) {
            return Err(extent(scene, instances[0]));
        }
        Ok(Self {
            mesh,
            instances,
            scales,
            shape,
        })
    }

    fn corners(&self, mesh: &Mesh) -> Vec<DVec3> {
        let corner = |p: &Vec3| self.shape * p.as_dvec3();
        mesh.positions.iter().map(corner).collect()
    }
}

fn extent(scene: &Scene, instance: u32) -> Error {
    Error::Extent(scene.instances[instance as usize].name.clone())
}

/// A mesh about its middle, where 32 bits are finest, and at a size far from the ends of their range.
struct Unit {
    positions: Vec<[f32; 3]>,
    /// What one unit is.
    size: f64,
}

/// `None` where the mesh has no size.
fn unit(mesh: &Mesh, corners: &[DVec3]) -> Option<Unit> {
    let used = || {
        mesh.triangles
            .iter()
            .flatten()
            .map(|&v| corners[v as usize])
    };
    let low = used().fold(DVec3::INFINITY, DVec3::min);
    let size = (used().fold(DVec3::NEG_INFINITY, DVec3::max) - low).max_element();
    let unit = |p: &DVec3| ((*p - low) / size - 0.5).as_vec3().to_array();
    (size.is_finite() && size > 0.0).then(|| Unit {
        positions: corners.iter().map(unit).collect(),
        size,
    })
}

/// The charts of one mesh.
fn sheet(
    scene: &Scene,
    placed: &Placed,
    cancel: &(dyn Fn() -> bool + Sync),
) -> Result<Sheet, Error> {
    let data = &scene.meshes[placed.mesh];
    let shaped = placed.corners(data);
    let Unit { positions, size } =
        unit(data, &shaped).ok_or_else(|| extent(scene, placed.instances[0]))?;
    let (faces, parts) = parts(data, &positions, cancel);
    let mut sheet = Sheet {
        mesh: placed.mesh,
        instances: placed.instances.clone(),
        scales: placed.scales.clone(),
        sources: Vec::new(),
        points: Vec::new(),
        triangles: vec![[0; 3]; data.triangles.len()],
        charts: Vec::new(),
        hidden: Vec::new(),
    };
    if !parts.is_empty() {
        let area: f64 = data
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| shaped[v as usize] / size);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        let whole = Handed {
            triangles: data.triangles.len(),
            area,
            unit: size,
        };
        // By itself, about 1 in size, most that is spoilt is flattened after all.
        for (part, scale) in sheet.unwrap(data, &parts, whole, cancel)? {
            let alone = Handed {
                triangles: part.triangles.len(),
                area: part.area(),
                unit: size * scale,
            };
            for (part, scale) in sheet.unwrap(data, &[part], alone, cancel)? {
                for face in part.faces() {
                    sheet.add(&face, data, scale * alone.unit);
                }
            }
        }
    }
    for face in &faces {
        sheet.add(face, data, size);
    }
    sheet.hidden = vec![false; sheet.charts.len()];
    Ok(sheet)
}

/// How much is handed to the unwrapper at once.
#[derive(Clone, Copy)]
struct Handed {
    triangles: usize,
    /// In squared units of it.
    area: f64,
    /// What its unit is in units of the mesh.
    unit: f64,
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
    fn unwrap(
        &mut self,
        data: &Mesh,
        parts: &[Part],
        Handed {
            triangles,
            area,
            unit,
        }: Handed,
        cancel: &(dyn Fn() -> bool + Sync),
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
        let made = match uvunwrap::generate_with_progress(&inputs, &settings, |_| !cancel()) {
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
    fn add(&mut self, face: &Face, data: &Mesh, size: f64) {
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
}
