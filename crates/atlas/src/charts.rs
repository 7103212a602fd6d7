//! Charts made by `uvunwrap`, which nothing outside this file names. See vendor-notes/uvunwrap.md.

use crate::Error;
use crate::measure::{mesh_area, world_area};
use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;
use scene::Scene;
use uvunwrap::{Density, MeshInput, Packing};

/// Charts of curved surfaces stay below this many triangles on average: flattening takes more than linear time.
const SOLVABLE: f64 = 200_000.0;
/// Edge of the pages on which charts are handed over, in texels, and the texels of a triangle there: coordinates are
/// rounded to 32 bits, a thousandth of a texel.
const HANDED: u32 = 8192;
const HANDED_TRIANGLE: f64 = 16.0;

/// The charts of one mesh, each flat in a plane of its own.
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
}

impl Sheet {
    /// The corners of a chart's triangles times `scale`.
    pub fn corners(&self, chart: usize, scale: f64) -> impl Iterator<Item = [DVec2; 3]> + '_ {
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
    let sheet = |(mesh, instances)| sheet(scene, mesh, instances, cancel);
    placed.into_par_iter().map(sheet).collect()
}

fn sheet(
    scene: &Scene,
    mesh: usize,
    instances: Vec<u32>,
    cancel: &(dyn Fn() -> bool + Sync),
) -> Result<Sheet, Error> {
    let data = &scene.meshes[mesh];
    let extent = || Error::Extent(scene.instances[instances[0] as usize].name.clone());
    let (shape, scales) = match instances[..] {
        [only] => (scene.instances[only as usize].transform.matrix3, vec![1.0]),
        _ => {
            let own = mesh_area(scene, mesh);
            let scale = |&i: &u32| (world_area(scene, i as usize) / own).sqrt();
            (DMat3::IDENTITY, instances.iter().map(scale).collect())
        }
    };
    if !scales.iter().all(|s: &f64| s.is_finite() && *s > 0.0) {
        return Err(extent());
    }
    // About the middle, where 32 bits are finest, and at a size far from the ends of their range.
    let shaped: Vec<DVec3> = data
        .positions
        .iter()
        .map(|p| shape * p.as_dvec3())
        .collect();
    let used = || data.triangles.iter().flatten().map(|&v| shaped[v as usize]);
    let low = used().fold(DVec3::INFINITY, DVec3::min);
    let size = (used().fold(DVec3::NEG_INFINITY, DVec3::max) - low).max_element();
    if !(size.is_finite() && size > 0.0) {
        return Err(extent());
    }
    let unit = |p: &DVec3| ((*p - low) / size - 0.5).as_vec3().to_array();
    let positions: Vec<[f32; 3]> = shaped.iter().map(unit).collect();
    let indices: Vec<u32> = data.triangles.iter().flatten().copied().collect();
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
        let input = MeshInput::new(&positions, &indices);
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
    assert_eq!(out.indices.len(), indices.len(), "indices of mesh {mesh}");
    let triangles: Vec<[u32; 3]> = out
        .indices
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .collect();
    let mut charts = vec![Vec::new(); made.chart_count as usize];
    for (t, corners) in triangles.iter().enumerate() {
        if let Some(chart) = out.vertices[corners[0] as usize].chart {
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
        mesh,
        instances,
        scales,
        sources: out.vertices.iter().map(|v| v.xref).collect(),
        points,
        triangles,
        charts,
    })
}
