//! The layout of an earlier version of a scene, for what is the same in both: charts stay where they are.

use crate::audit::audit;
use crate::measure::{chart_count, density, world_triangle_areas};
use crate::objects::{object_names, objects};
use crate::{Atlas, Error, MeshLayout, Options};
use scene::{Mesh, Scene};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Areas and edges that differ by less than this share are the same: an object may be moved, and rounding move its corners.
const SAME: f64 = 1e-3;

/// What decides how an instance is laid out, apart from where it stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Name of its object.
    object: String,
    /// Its mesh: index into the scene's.
    mesh: u32,
    /// Hash of the mesh's triangles and coordinates.
    charts: String,
    /// Surface in square scene units, the sum of the squares of its triangles' areas, and the length of all edges: what no movement
    /// changes.
    shape: [f64; 3],
    /// Texels per scene unit that were asked for it by name.
    asked: Option<f64>,
    /// It takes texels.
    included: bool,
}

/// What each instance of a scene claims, in their order.
///
/// # Errors
///
/// As [`crate::layout`], for names and densities that do not fit the scene.
pub fn claims(scene: &Scene, options: &Options) -> Result<Vec<Claim>, Error> {
    let charts: Vec<String> = scene.meshes.iter().map(charts_hash).collect();
    let mut claims = vec![None; scene.instances.len()];
    let named = object_names(scene).into_iter();
    for (object, name) in objects(scene, options)?.into_iter().zip(named) {
        for &instance in &object.instances {
            let mesh = scene.instances[instance as usize].mesh;
            claims[instance as usize] = Some(Claim {
                object: name.name.clone(),
                mesh,
                charts: charts[mesh as usize].clone(),
                shape: shape(scene, instance as usize),
                asked: object.asked,
                included: object.included,
            });
        }
    }
    Ok(claims.into_iter().flatten().collect())
}

/// The places of an earlier layout for a scene all of whose instances it knows; `None` where one is new, has another shape or is asked
/// for at another density. Earlier instances that are gone leave their places free.
pub fn reuse(earlier: &Atlas, before: &[Claim], scene: &Scene, now: &[Claim]) -> Option<Atlas> {
    if before.len() != earlier.placements.len() || now.len() != scene.instances.len() {
        return None;
    }
    let mut known: HashMap<_, Vec<usize>> = HashMap::new();
    for (place, claim) in before.iter().enumerate().rev() {
        let key = (&claim.object, &claim.charts);
        known.entry(key).or_default().push(place);
    }
    let mut places = Vec::with_capacity(now.len());
    for claim in now {
        let place = known.get_mut(&(&claim.object, &claim.charts))?.pop()?;
        if !claim.stays(&before[place]) {
            return None;
        }
        places.push(place);
    }
    let layout_of = |(mesh, own): (usize, &Mesh)| {
        let mut placed = (0..now.len()).filter(|&instance| now[instance].mesh as usize == mesh);
        let Some(first) = placed.next() else {
            return Some(MeshLayout::without_texels(own));
        };
        let source = |instance: usize| before[places[instance]].mesh;
        // All instances of a mesh share its coordinates.
        if placed.any(|other| source(other) != source(first)) {
            return None;
        }
        let layout = earlier.meshes.get(source(first) as usize)?;
        let fits = layout.triangles.len() == own.triangles.len()
            && layout
                .source_vertices
                .iter()
                .all(|&v| (v as usize) < own.positions.len());
        fits.then(|| layout.clone())
    };
    let meshes: Vec<MeshLayout> = scene
        .meshes
        .iter()
        .enumerate()
        .map(layout_of)
        .collect::<Option<_>>()?;
    let mut atlas = Atlas {
        placements: places
            .iter()
            .map(|&place| earlier.placements[place])
            .collect(),
        chart_count: meshes.iter().map(chart_count).sum(),
        meshes,
        ..earlier.clone()
    };
    let findings = audit(scene, &atlas);
    if !findings.clean() {
        return None;
    }
    atlas.audit.texels = findings.audit.texels;
    atlas.density = density(scene, &atlas.meshes, &atlas.placements, atlas.page_size);
    Some(atlas)
}

impl Claim {
    /// True where the earlier place serves the claim.
    fn stays(&self, earlier: &Claim) -> bool {
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME * a.abs().max(b.abs());
        self.asked == earlier.asked
            && self.included == earlier.included
            && self.shape.iter().zip(&earlier.shape).all(near)
    }
}

fn charts_hash(mesh: &Mesh) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(mesh.positions.len() as u64).to_le_bytes());
    for triangle in &mesh.triangles {
        hasher.update(triangle.map(u32::to_le_bytes).as_flattened());
    }
    for set in &mesh.uv_sets {
        for uv in set {
            hasher.update(uv.to_array().map(f32::to_le_bytes).as_flattened());
        }
        hasher.update(b"set");
    }
    hasher.finalize().to_hex().to_string()
}

/// See [`Claim::shape`].
fn shape(scene: &Scene, instance: usize) -> [f64; 3] {
    let [mut area, mut squares] = [0.0; 2];
    for triangle in world_triangle_areas(scene, instance) {
        area += triangle;
        squares += triangle * triangle;
    }
    let placed = &scene.instances[instance];
    let mesh = &scene.meshes[placed.mesh as usize];
    let edges = mesh.triangles.iter().map(|triangle| {
        let at = |v: u32| mesh.positions[v as usize].as_dvec3();
        let [a, b, c] = triangle.map(|v| placed.transform.transform_vector3(at(v)));
        (b - a).length() + (c - b).length() + (a - c).length()
    });
    [area, squares, edges.sum()]
}
