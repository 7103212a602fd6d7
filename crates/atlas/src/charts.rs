//! Charts made by `uvunwrap`, which nothing outside this file names. See vendor-notes/uvunwrap.md.

use crate::Error;
use crate::measure::{mesh_area, world_area};
use crate::twins::{self, Shape};
use glam::{DMat3, DVec2, DVec3, Vec3};
use rayon::prelude::*;
use scene::{Mesh, Scene};
use std::collections::HashMap;
use uvunwrap::{Density, MeshInput, Packing};

/// Charts of curved surfaces stay below this many triangles on average: flattening takes more than linear time.
const SOLVABLE: f64 = 200_000.0;
/// Height fields from so many triangles on are not flattened but seen from above.
const MANY: usize = 20_000;
/// Cosine of the steepest slope of a height field: 60 degrees, where a texel is twice as long as wide.
const STEEPEST: f64 = 0.5;
/// Edge of the pages on which charts are handed over, in texels, and the texels of a triangle there: coordinates are
/// rounded to 32 bits, a thousandth of a texel.
const HANDED: u32 = 8192;
const HANDED_TRIANGLE: f64 = 16.0;

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

/// The charts of every mesh that takes texels, in the order of meshes. `included` says which instances do.
pub(crate) fn sheets(
    scene: &Scene,
    included: &[bool],
    cancel: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Sheet>, Error> {
    let mut instances = vec![Vec::new(); scene.meshes.len()];
    for (i, instance) in scene
        .instances
        .iter()
        .enumerate()
        .filter(|&(i, _)| included[i])
    {
        instances[instance.mesh as usize].push(i as u32);
    }
    let placed: Vec<(usize, Vec<u32>)> = instances
        .into_iter()
        .enumerate()
        .filter(|(m, users)| !users.is_empty() && !scene.meshes[*m].triangles.is_empty())
        .collect();
    let placed: Vec<Placed> = placed
        .into_par_iter()
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
    let made: Vec<_> = placed.par_iter().enumerate().map(sheet).collect();
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
    let welded = weld(data, &positions);
    let corners: Vec<u32> = data.triangles.iter().flatten().copied().collect();
    let indices: Vec<u32> = corners.iter().map(|&v| welded[v as usize]).collect();
    let projected = projection(&data.triangles, &positions);
    let area: f64 = data
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| shaped[v as usize] / size);
            0.5 * (b - a).cross(c - a).length()
        })
        .sum();
    let count = data.triangles.len() as f64;
    let most = match count > SOLVABLE {
        true => (area * SOLVABLE / count) as f32,
        false => 0.0,
    };
    // Long charts may be longer than the mesh: then once more at half the size.
    let mut scale = (count.clamp(1e3, 2.5e5) * HANDED_TRIANGLE / area).sqrt();
    scale = scale.min(f64::from(HANDED) / 2.0);
    let made = loop {
        let settings = uvunwrap::Options {
            density: Density::Fixed {
                texels_per_unit: scale as f32,
                page_size: Some(HANDED),
            },
            padding: 0,
            packing: Packing::Fast,
            max_chart_area: most,
            ..uvunwrap::Options::default()
        };
        let input = MeshInput {
            existing_uvs: projected.as_deref(),
            ..MeshInput::new(&positions, &indices)
        };
        match uvunwrap::generate_with_progress(&[input], &settings, |_| !cancel()) {
            Err(uvunwrap::Error::ChartTooLarge { .. }) if scale > 1.0 => scale *= 0.25,
            Err(uvunwrap::Error::Cancelled) => return Err(Error::Cancelled),
            Err(other) => return Err(Error::Unwrap(other.to_string())),
            Ok(made) => break made,
        }
    };
    let texel = size / f64::from(scale as f32);
    let page = DVec2::new(f64::from(made.width), f64::from(made.height)) * texel;
    let out = &made.meshes[0];
    assert_eq!(
        out.indices.len(),
        indices.len(),
        "indices of mesh {}",
        placed.mesh
    );
    // Corners of the unwrapper's vertices by the mesh's own, which it does not know apart.
    let mut numbers = HashMap::new();
    let mut vertices: Vec<(u32, usize)> = Vec::with_capacity(out.vertices.len());
    let mut number = |(&made, &own): (&u32, &u32)| {
        *numbers.entry((made, own)).or_insert_with(|| {
            vertices.push((own, made as usize));
            vertices.len() as u32 - 1
        })
    };
    let split: Vec<u32> = out.indices.iter().zip(&corners).map(&mut number).collect();
    let triangles: Vec<[u32; 3]> = split.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let chart_of = |v: u32| out.vertices[vertices[v as usize].1].chart;
    let mut charts = vec![Vec::new(); made.chart_count as usize];
    for (t, corners) in triangles.iter().enumerate() {
        if let Some(chart) = chart_of(corners[0]) {
            charts[chart as usize].push(t as u32);
        }
    }
    let mut points: Vec<DVec2> = out
        .vertices
        .iter()
        .map(|v| DVec2::new(f64::from(v.uv[0]), f64::from(v.uv[1])) * page)
        .collect();
    let mut corner = vec![DVec2::INFINITY; charts.len()];
    for (v, p) in out.vertices.iter().zip(&points) {
        if let Some(chart) = v.chart {
            corner[chart as usize] = corner[chart as usize].min(*p);
        }
    }
    for (v, p) in out.vertices.iter().zip(&mut points) {
        *p = v
            .chart
            .map_or(DVec2::ZERO, |chart| *p - corner[chart as usize]);
    }
    Ok(Sheet {
        mesh: placed.mesh,
        instances: placed.instances.clone(),
        scales: placed.scales.clone(),
        sources: vertices.iter().map(|&(own, _)| own).collect(),
        points: vertices.iter().map(|&(_, made)| points[made]).collect(),
        triangles,
        hidden: vec![false; charts.len()],
        charts,
    })
}

/// For each vertex the first one at its place with its normal: the seams of textures are no borders of charts, hard edges are.
fn weld(mesh: &Mesh, positions: &[[f32; 3]]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len());
    let bits = |v: [f32; 3]| v.map(|x| (x + 0.0).to_bits());
    let key = |v: usize| {
        let normal = mesh.normals.get(v).map_or([0.0; 3], |n| n.to_array());
        (bits(positions[v]), bits(normal))
    };
    (0..positions.len())
        .map(|v| *first.entry(key(v)).or_insert(v as u32))
        .collect()
}

/// The view along its mean normal of a mesh that is all seen from there: a height field needs no flattening, which takes
/// seconds from some ten thousand triangles on.
///
/// Lengths along a slope shrink by its cosine, at least [`STEEPEST`], as in every lightmap of a terrain. `None` for a
/// smaller mesh and for one of another shape. Where the view covers a place twice the unwrapper flattens that part itself.
fn projection(triangles: &[[u32; 3]], positions: &[[f32; 3]]) -> Option<Vec<[f32; 2]>> {
    if triangles.len() < MANY {
        return None;
    }
    let at = |v: u32| Vec3::from(positions[v as usize]).as_dvec3();
    let cross = |t: &[u32; 3]| {
        let [a, b, c] = t.map(at);
        (b - a).cross(c - a)
    };
    let axis = triangles
        .iter()
        .map(cross)
        .sum::<DVec3>()
        .normalize_or_zero();
    let steep = |t: &[u32; 3]| {
        let normal = cross(t);
        normal.dot(axis) < STEEPEST * normal.length()
    };
    if axis == DVec3::ZERO || triangles.iter().any(steep) {
        return None;
    }
    let (u, v) = axis.any_orthonormal_pair();
    let flat = |p: &[f32; 3]| {
        let p = Vec3::from(*p).as_dvec3();
        [p.dot(u) as f32, p.dot(v) as f32]
    };
    Some(positions.iter().map(flat).collect())
}
