//! Values at vertices: the function that is linear over every triangle and comes nearest to the texels.
//!
//! Source: L. Kavan, A. W. Bargteil, P.-P. Sloan, "Least Squares Vertex Baking", Computer Graphics Forum 30 (4), 2011.
//! Samples at vertices alone miss what happens between them, and a vertex in a corner speaks for all around it. Least
//! squares over the surface do not. Texels stand for the surface here: the value of a texel is the mean over its
//! footprint, and the mean of a linear function over a piece of a triangle is its value at the piece's centroid. So a
//! field that is linear comes out as it is. Each texel counts by its area in the world.
//!
//! Across an edge of two triangles, unfolded into one plane, the slope shall not change, as the paper asks for against
//! Mach bands: what is linear pays nothing for that. Slopes are not carried on to where there are no texels, though,
//! for beside a contact they are steep: vertices of which texels show less than half, or about which there is less than
//! one texel, take to the means of their neighbours. What neither texels nor neighbours tell stays at the mean of its
//! object.

use crate::baked::Baked;
use crate::job::Job;
use ::bake::BakedPage;
use ::scene::Mesh;
use atlas::{PageRaster, Placement, Tile};
use glam::DVec3;
use layers::{Layer, Preview, Unit};
use rayon::prelude::*;
use std::collections::HashMap;

/// What a change of slope counts against the texels. Of 25,084 vertices of `scenes/town.gltf` at 1024², 42 leave 0..1
/// by more than 0.05 before they are bounded. At three times this 28 do, but at a dark spot as narrow as its triangles
/// less than half of the gain over samples at vertices is left.
const SMOOTH: f64 = 0.03;
/// Share of what lies about a vertex that texels show, below which it is drawn to its neighbours; and how much.
const SHOWN: f64 = 0.5;
const DRAWN: f64 = 0.1;
/// Tiles that are cut at a time.
const BATCH: usize = 256;
/// What is left of the residual of the equations when they count as solved.
const SOLVED: f64 = 1e-9;
/// Steps after which they are taken as they are.
const STEPS: usize = 2_000;

/// A layer at the vertices of one object.
#[derive(Debug, Clone, PartialEq)]
pub struct Vertices {
    /// Its name; objects may share one.
    pub name: String,
    /// Number of each vertex in the mesh, or the file's primitive, that it came from.
    pub vertices: Vec<u32>,
    /// One list of values for each of [`Layer::channels`], with a value for each of `vertices`.
    pub channels: Vec<Vec<f32>>,
}

impl Baked {
    /// A layer at the vertices of every object that took texels, in the order of [`Baked::objects`]; `None` where the
    /// layer was not asked for.
    ///
    /// Values are those of area-weighted least squares over the texels. Vertices with the same place and the same
    /// normal have the same value; hard edges, where normals differ, keep two, and each vertex of a mesh without
    /// normals has its own. A mesh whose vertices are farther apart than shadows are wide cannot show them.
    ///
    /// ```
    /// # fn main() -> Result<(), ambake::Error> {
    /// # let scene = ambake::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/wall_long.obj"))?;
    /// use ambake::{Bake, Layer};
    /// let baked = Bake::new(&scene).size(64).rays(16).run(&())?;
    /// for object in baked.vertex_values(Layer::Diffuse).expect("it is among the standard layers") {
    ///     let occlusion: &[f32] = &object.channels[0];
    ///     println!("{}: {} vertices", object.name, occlusion.len());
    /// }
    /// # Ok(())
    /// # }
    /// ```
    pub fn vertex_values(&self, layer: Layer) -> Option<Vec<Vertices>> {
        let job = self.job();
        let mut fit = Fit::of(job, layer);
        self.pages().try_for_each(|page| fit.add(&page.0))?;
        let solved = fit.solved().into_iter().map(|(number, channels)| {
            let instance = &job.scene().instances[number];
            let mesh = &job.scene().meshes[instance.mesh as usize];
            Vertices {
                name: instance.name.clone(),
                vertices: match mesh.source_vertices.is_empty() {
                    true => (0..mesh.positions.len() as u32).collect(),
                    false => mesh.source_vertices.clone(),
                },
                channels,
            }
        });
        Some(solved.collect())
    }
}

/// A layer that is brought to vertices page by page.
pub(crate) struct Fit<'a> {
    job: &'a Job,
    layer: Layer,
    /// Of each instance that took texels.
    systems: Vec<Option<System>>,
}

impl<'a> Fit<'a> {
    /// Before the first page.
    pub fn of(job: &'a Job, layer: Layer) -> Self {
        let count = layer.channels().len();
        let system = |(number, placement): (usize, &Placement)| {
            let is_somewhere = placement.is_somewhere();
            is_somewhere.then(|| System::new(job, number as u32, count))
        };
        let placements = job.atlas().placements.par_iter().enumerate();
        Self {
            job,
            layer,
            systems: job.within(|| placements.map(system).collect()),
        }
    }

    /// Adds the texels of a page; `None` where it has no such layer.
    pub fn add(&mut self, page: &BakedPage) -> Option<()> {
        let channels = 0..self.layer.channels().len();
        let channels: Option<Vec<&[f32]>> = channels.map(|c| page.channel(self.layer, c)).collect();
        let channels = channels?;
        let raster = PageRaster::new(self.job.scene(), self.job.atlas(), page.page);
        let tiles: Vec<usize> = (0..raster.tiles().len()).collect();
        for batch in tiles.chunks(BATCH) {
            let cut = batch.par_iter();
            let cut = cut.map(|&tile| texels(&raster.tile(tile), page.size));
            let cut: Vec<Vec<Texel>> = self.job.within(|| cut.collect());
            for texel in cut.iter().flatten() {
                if let Some(system) = &mut self.systems[texel.instance as usize] {
                    system.add(texel, &channels);
                }
            }
        }
        Some(())
    }

    /// The values at the vertices of each instance that took texels, channel by channel.
    pub fn solved(self) -> Vec<(usize, Vec<Vec<f32>>)> {
        let systems = self.systems.into_par_iter().enumerate();
        let solved = systems
            .filter_map(|(number, system)| Some((number, bounded(self.layer, system?.solved()))));
        self.job.within(|| solved.collect())
    }
}

/// Light and shares are not negative and shares at most 1, also at vertices beyond the middles of texels.
fn bounded(layer: Layer, mut channels: Vec<Vec<f32>>) -> Vec<Vec<f32>> {
    let most = match (layer.unit(), layer.preview()) {
        (Unit::Share | Unit::Reflectance, _) => 1.0,
        (Unit::Radiance, Preview::Srgb) => f32::INFINITY,
        _ => return channels,
    };
    let values = channels.iter_mut().flatten();
    values.for_each(|value| *value = value.clamp(0.0, most));
    channels
}

/// What a texel has of one object: each triangle with its share of the texel and the weights of its corners at the
/// centroid of that part.
struct Texel {
    instance: u32,
    /// Row-major over the page.
    index: usize,
    /// Triangle, area in texels, weights.
    parts: Vec<(u32, f64, DVec3)>,
}

fn texels(tile: &Tile, page_size: u32) -> Vec<Texel> {
    let mut texels: Vec<Texel> = Vec::new();
    for footprint in &tile.footprints {
        let index = footprint.y as usize * page_size as usize + footprint.x as usize;
        let (first, mut before) = (texels.len(), 0.0);
        for piece in tile.pieces_of(footprint) {
            let area = piece.cumulative - before;
            before = piece.cumulative;
            let [a, b, c] = piece.corners;
            let middle = match piece.square {
                true => 0.5 * (b + c),
                false => (a + b + c) / 3.0,
            };
            let part = (piece.triangle, area, middle);
            match texels[first..]
                .iter_mut()
                .find(|of| of.instance == piece.instance)
            {
                Some(texel) => texel.parts.push(part),
                None => texels.push(Texel {
                    instance: piece.instance,
                    index,
                    parts: vec![part],
                }),
            }
        }
    }
    texels
}

/// The equations of one object.
struct System {
    /// The unknown of each corner, triangle by triangle, and the area in the world of a texel of it.
    triangles: Vec<([u32; 3], f64)>,
    /// The unknown of each vertex.
    unknowns: Vec<u32>,
    /// The area in the world about each unknown, and what texels show of it.
    around: Vec<f64>,
    shown: Vec<f64>,
    /// How many texels these are.
    texels: Vec<f64>,
    /// The symmetric matrix, row by row.
    rows: Vec<Vec<(u32, f64)>>,
    /// By channel.
    rights: Vec<Vec<f64>>,
    /// Sum of the texels by their area, by channel; the area.
    sums: (Vec<f64>, f64),
}

impl System {
    /// The equations about slopes.
    fn new(job: &Job, instance: u32, channels: usize) -> Self {
        let (scene, atlas) = (job.scene(), job.atlas());
        let mesh = &scene.meshes[scene.instances[instance as usize].mesh as usize];
        let (unknowns, count) = unknowns(mesh);
        let corners = |t: usize| job.world().corners(instance, t as u32);
        let texel = |t: usize| {
            let (uvs, _) = atlas::triangle_uv(scene, atlas, instance, t as u32);
            let [a, b, c] = uvs.map(|uv| uv.as_dvec2() * f64::from(atlas.page_size));
            let [p, q, r] = corners(t);
            let on_page = (b - a).perp_dot(c - a).abs();
            // No texel shows a triangle without area on the page.
            if on_page > 0.0 {
                (q - p).cross(r - p).length() / on_page
            } else {
                0.0
            }
        };
        let triangle =
            |(t, corners): (usize, &[u32; 3])| (corners.map(|v| unknowns[v as usize]), texel(t));
        let mut system = Self {
            triangles: mesh.triangles.iter().enumerate().map(triangle).collect(),
            unknowns,
            around: vec![0.0; count],
            shown: vec![0.0; count],
            texels: vec![0.0; count],
            rows: vec![Vec::new(); count],
            rights: vec![vec![0.0; count]; channels],
            sums: (vec![0.0; channels], 0.0),
        };
        for (t, (names, _)) in system.triangles.iter().enumerate() {
            let [a, b, c] = corners(t);
            let third = (b - a).cross(c - a).length() / 6.0;
            names
                .iter()
                .for_each(|&name| system.around[name as usize] += third);
        }
        for [one, other] in system.edges() {
            if let Some((weight, terms)) = hinge(&system.triangles, corners, [one, other]) {
                system.weigh(&terms, SMOOTH * weight);
            }
        }
        system
    }

    /// The pairs of triangles that share an edge: number of each, and which of its corners is not on the edge.
    fn edges(&self) -> Vec<[(usize, usize); 2]> {
        let mut sides: Vec<([u32; 2], (usize, usize))> = Vec::new();
        for (t, (corners, _)) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
                sides.push(([a.min(b), a.max(b)], (t, k)));
            }
        }
        sides.sort_unstable();
        let edges = sides.chunk_by(|a, b| a.0 == b.0);
        let pairs = edges.filter_map(|edge| match edge {
            [(ends, one), (_, other)] if ends[0] != ends[1] => Some([*one, *other]),
            _ => None,
        });
        pairs.collect()
    }

    /// Adds the square of a sum of unknowns.
    fn weigh(&mut self, terms: &[(u32, f64)], weight: f64) {
        for &(i, a) in terms {
            let row = &mut self.rows[i as usize];
            for &(j, b) in terms {
                match row.iter_mut().find(|entry| entry.0 == j) {
                    Some(entry) => entry.1 += weight * a * b,
                    None => row.push((j, weight * a * b)),
                }
            }
        }
    }

    /// Adds what a texel says.
    fn add(&mut self, texel: &Texel, channels: &[&[f32]]) {
        let covered: f64 = texel.parts.iter().map(|part| part.1).sum();
        let mut terms: Vec<(u32, f64)> = Vec::new();
        let mut area = 0.0;
        for &(triangle, part, weights) in &texel.parts {
            let (corners, world) = self.triangles[triangle as usize];
            area += part * world;
            for (corner, weight) in corners.into_iter().zip(weights.to_array()) {
                let own = weight * part / covered;
                match terms.iter_mut().find(|term| term.0 == corner) {
                    Some(term) => term.1 += own,
                    None => terms.push((corner, own)),
                }
            }
        }
        self.weigh(&terms, area);
        for (channel, values) in channels.iter().enumerate() {
            let value = f64::from(values[texel.index]);
            self.sums.0[channel] += area * value;
            for &(i, a) in &terms {
                self.rights[channel][i as usize] += area * a * value;
            }
        }
        self.sums.1 += area;
        for &(i, a) in &terms {
            self.shown[i as usize] += area * a;
            self.texels[i as usize] += covered * a;
        }
    }

    /// Draws what texels hardly show to its neighbours.
    fn draw(&mut self) {
        let hidden = |&name: &u32| {
            let (shown, all) = (self.shown[name as usize], self.around[name as usize]);
            shown < SHOWN * all || self.texels[name as usize] < 1.0
        };
        let mut pairs = Vec::new();
        for (names, _) in &self.triangles {
            for k in 0..3 {
                let [i, j] = [names[k], names[(k + 1) % 3]];
                if i != j && (hidden(&i) || hidden(&j)) {
                    let area = self.around[i as usize].min(self.around[j as usize]);
                    pairs.push((i, j, area));
                }
            }
        }
        for (i, j, area) in pairs {
            self.weigh(&[(i, 1.0), (j, -1.0)], DRAWN * area);
        }
    }

    /// The values at all vertices of the mesh, channel by channel.
    fn solved(mut self) -> Vec<Vec<f32>> {
        self.draw();
        let (sums, area) = self.sums;
        let channels = self.rights.into_iter().zip(sums);
        let solved = channels.map(|(right, sum)| {
            let mean = sum / area.max(f64::MIN_POSITIVE);
            let values = solve(&self.rows, right, mean);
            let value = |&unknown: &u32| values[unknown as usize] as f32;
            self.unknowns.iter().map(value).collect()
        });
        solved.collect()
    }
}

/// An unknown for each vertex, and how many there are: vertices at one place with one normal share theirs.
fn unknowns(mesh: &Mesh) -> (Vec<u32>, usize) {
    if mesh.normals.is_empty() {
        let count = mesh.positions.len();
        return ((0..count as u32).collect(), count);
    }
    let mut known = HashMap::new();
    let places = mesh.positions.iter().zip(&mesh.normals);
    let unknowns = places.map(|(place, normal)| {
        // Adding 0 makes one zero of two.
        let bits = [*place, *normal].map(|v| v.to_array().map(|x| (x + 0.0).to_bits()));
        let next = known.len() as u32;
        *known.entry(bits).or_insert(next)
    });
    let unknowns: Vec<u32> = unknowns.collect();
    let count = known.len();
    (unknowns, count)
}

/// The change of slope across the edge of two triangles in their common plane, times the smaller of their heights, as a
/// sum of unknowns; and the area that it counts for. `None` where a triangle is too thin to have a slope.
fn hinge(
    triangles: &[([u32; 3], f64)],
    corners: impl Fn(usize) -> [DVec3; 3],
    sides: [(usize, usize); 2],
) -> Option<(f64, Vec<(u32, f64)>)> {
    let mut area = 0.0;
    let mut slopes = Vec::with_capacity(2);
    for (t, k) in sides {
        let (names, places) = (triangles[t].0, corners(t));
        let [i, j] = [(k + 1) % 3, (k + 2) % 3];
        let edge = places[j] - places[i];
        let along = (places[k] - places[i]).dot(edge) / edge.length_squared();
        let height = (places[k] - places[i] - edge * along).length();
        if height.is_nan() || height <= 1e-6 * edge.length() {
            return None;
        }
        area += 0.5 * height * edge.length();
        let terms = [(names[k], 1.0), (names[i], along - 1.0), (names[j], -along)];
        slopes.push((height, terms));
    }
    let least = slopes
        .iter()
        .map(|slope| slope.0)
        .fold(f64::INFINITY, f64::min);
    let mut sum: Vec<(u32, f64)> = Vec::with_capacity(4);
    for (height, terms) in slopes {
        for (name, factor) in terms {
            let own = factor * least / height;
            match sum.iter_mut().find(|term| term.0 == name) {
                Some(term) => term.1 += own,
                None => sum.push((name, own)),
            }
        }
    }
    Some((area / 3.0, sum))
}

/// The solution of symmetric equations that is nearest to `start` where there are several: conjugate gradients from
/// there, preconditioned by the diagonal.
fn solve(rows: &[Vec<(u32, f64)>], right: Vec<f64>, start: f64) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let times = |x: &[f64]| -> Vec<f64> {
        let row = |row: &Vec<(u32, f64)>| row.iter().map(|&(j, a)| a * x[j as usize]).sum();
        rows.iter().map(row).collect()
    };
    let inverse: Vec<f64> = (0..rows.len())
        .map(|i| {
            let diagonal = rows[i].iter().find(|entry| entry.0 as usize == i);
            diagonal.map_or(0.0, |entry| 1.0 / entry.1)
        })
        .collect();
    let eased = |r: &[f64]| -> Vec<f64> { r.iter().zip(&inverse).map(|(r, d)| r * d).collect() };
    let mut x = vec![start; rows.len()];
    let of_start = times(&x);
    let mut residual: Vec<f64> = right.iter().zip(of_start).map(|(b, a)| b - a).collect();
    let mut direction = eased(&residual);
    let mut energy = dot(&residual, &direction);
    let enough = SOLVED * SOLVED * energy;
    for _ in 0..STEPS {
        if energy <= enough || energy == 0.0 {
            break;
        }
        let moved = times(&direction);
        let curvature = dot(&direction, &moved);
        if curvature <= 0.0 {
            break;
        }
        let step = energy / curvature;
        for i in 0..x.len() {
            x[i] += step * direction[i];
            residual[i] -= step * moved[i];
        }
        let next = eased(&residual);
        let before = std::mem::replace(&mut energy, dot(&residual, &next));
        for (d, n) in direction.iter_mut().zip(next) {
            *d = n + *d * (energy / before);
        }
    }
    x
}

#[cfg(test)]
#[path = "vertices_tests.rs"]
mod tests;
