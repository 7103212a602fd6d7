//! The charts of every mesh that takes texels: flat faces as they lie, the rest as the unwrapper cuts it.

use crate::Error;
use crate::measure::{mesh_area, world_area};
use crate::parts::{parts, weld};
use crate::sheet::Sheet;
use crate::told::{OfMesh, Told};
use crate::twins::{self, Shape};
use crate::unwrap::Handed;
use glam::{DMat3, DVec3, Vec3};
use layers::Progress;
use rayon::prelude::*;
use scene::{Mesh, Scene, around};

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
    progress: &dyn Progress,
) -> Result<Vec<Sheet>, Error> {
    progress.phase("making charts");
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
    let own = (0..meshes.len()).filter(|&i| firsts[i] == i);
    let told = Told::new(progress, own.map(|i| sizes[i][1]).sum());
    let sheet = |(i, placed): (usize, &Placed)| {
        (firsts[i] == i).then(|| {
            let told = told.mesh(sizes[i][1]);
            let made = sheet(scene, placed, &told);
            told.finish();
            made
        })
    };
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
    let (low, high) = around(used());
    let size = (high - low).max_element();
    let unit = |p: &DVec3| ((*p - low) / size - 0.5).as_vec3().to_array();
    (size.is_finite() && size > 0.0).then(|| Unit {
        positions: corners.iter().map(unit).collect(),
        size,
    })
}

/// The charts of one mesh.
fn sheet(scene: &Scene, placed: &Placed, told: &OfMesh<'_>) -> Result<Sheet, Error> {
    let data = &scene.meshes[placed.mesh];
    let shaped = placed.corners(data);
    let Unit { positions, size } =
        unit(data, &shaped).ok_or_else(|| extent(scene, placed.instances[0]))?;
    let (faces, parts) = parts(data, &positions, told);
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
        for (part, scale) in sheet.unwrap(data, &parts, whole, told)? {
            let alone = Handed {
                triangles: part.triangles.len(),
                area: part.area(),
                unit: size * scale,
            };
            for (part, scale) in sheet.unwrap(data, &[part], alone, told)? {
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
