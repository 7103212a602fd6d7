//! Turns what a program hands over into a scene, under the same rules as a file.

use super::{Material, Mesh, Placement, hash, material, named, place};
use crate::input::Input;
use crate::validate::{self, Parts};
use crate::{Error, Format, Instance, MeshOrigin, Scene};
use glam::{DAffine3, Vec2, Vec3, Vec4};
use std::path::Path;

impl Scene {
    /// The scene of meshes and materials in memory, validated and repaired as a file's would be.
    ///
    /// Each mesh becomes one object, in the order given. Without materials every mesh is of the default one, and its
    /// [`material`](Mesh::material) is 0. [`Scene::path`] is `scene`, the stem of the files that a bake of it writes.
    ///
    /// # Errors
    /// [`Error::Authored`], one line that names the mesh or the material: a position that a triangle uses is not finite
    /// or beyond 1e18, a vertex or material number is out of range, normals or UVs are not one a vertex, a transform is
    /// not affine, a texture has more or fewer pixels than its size says, or no triangle with an area is left.
    ///
    /// ```
    /// use ambake_scene::{Scene, authored::{Material, Mesh}};
    ///
    /// let mut floor = Mesh::default();
    /// floor.name = "floor".into();
    /// floor.positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, 0.0]];
    /// floor.triangles = vec![[0, 1, 2], [0, 2, 3]];
    /// let mut lid = floor.clone();
    /// lid.name = "lid".into();
    /// lid.material = 1;
    /// lid.transform[3] = [0.0, 1.5, 0.0, 1.0];
    ///
    /// let mut brick = Material::default();
    /// brick.albedo = [0.6, 0.3, 0.2];
    /// let scene = Scene::from_meshes(vec![floor, lid], vec![Material::default(), brick])?;
    /// assert_eq!(scene.instances[1].transform.translation.y, 1.5);
    /// # Ok::<(), ambake_scene::Error>(())
    /// ```
    pub fn from_meshes(meshes: Vec<Mesh>, materials: Vec<Material>) -> Result<Scene, Error> {
        built(meshes, materials, None)
    }

    /// As [`Scene::from_meshes`], with each mesh placed as often as `placements` say, which may be never: each
    /// placement becomes one object, in the order given. Objects of one mesh share its triangles and the shape of its
    /// layout; each has texels of its own. A mesh's own [`transform`](Mesh::transform) comes before the placement's.
    ///
    /// # Errors
    /// As [`Scene::from_meshes`]; a placement's mesh number is out of range.
    ///
    /// ```
    /// use ambake_scene::{Scene, authored::{Mesh, Placement}};
    ///
    /// let mut slab = Mesh::default();
    /// slab.positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, 0.0]];
    /// slab.triangles = vec![[0, 1, 2], [0, 2, 3]];
    /// let floor = Placement::default();
    /// let mut lid = Placement::default();
    /// lid.transform[3] = [0.0, 1.5, 0.0, 1.0];
    ///
    /// let scene = Scene::from_placements(vec![slab], vec![], vec![floor, lid])?;
    /// assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    /// # Ok::<(), ambake_scene::Error>(())
    /// ```
    pub fn from_placements(
        meshes: Vec<Mesh>,
        materials: Vec<Material>,
        placements: Vec<Placement>,
    ) -> Result<Scene, Error> {
        built(meshes, materials, Some(placements))
    }
}

fn built(
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    placements: Option<Vec<Placement>>,
) -> Result<Scene, Error> {
    let mut input = Input::new(Path::new("scene"));
    hash::update(
        &mut input.hasher,
        &meshes,
        &materials,
        placements.as_deref(),
    );
    parts(&mut input, meshes, materials, placements)
        .and_then(|parts| validate::scene(input, Format::Memory, parts))
        .map_err(without_file)
}

/// The errors of the readers name a file; here there is none.
fn without_file(error: Error) -> Error {
    match error {
        Error::Invalid { place, problem, .. } => Error::Authored { place, problem },
        Error::NoTriangles { hint, .. } => Error::Authored {
            place: "scene".into(),
            problem: format!("no mesh has a triangle with an area; hand over at least one{hint}"),
        },
        other => other,
    }
}

fn parts(
    input: &mut Input,
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    placements: Option<Vec<Placement>>,
) -> Result<Parts, Error> {
    let mut parts = Parts::default();
    for (number, given) in materials.into_iter().enumerate() {
        let material = material::built(input, &mut parts, number, given)?;
        parts.materials.push(material);
    }
    if parts.materials.is_empty() {
        parts.materials.push(crate::Material::untinted("none"));
    }
    let once = |mesh| Placement {
        mesh,
        ..Placement::default()
    };
    let placements = placements.unwrap_or_else(|| (0..meshes.len()).map(once).collect());
    let mut is_placed = vec![false; meshes.len()];
    for (number, placement) in placements.iter().enumerate() {
        let count = meshes.len();
        *is_placed.get_mut(placement.mesh).ok_or_else(|| {
            let problem = format!(
                "it places mesh {} but there are {count}, numbered from 0; correct its number",
                placement.mesh
            );
            input.invalid(place("placement", number, &placement.name), problem)
        })? = true;
    }
    let mut built = Vec::with_capacity(meshes.len());
    for (number, (given, is_placed)) in meshes.into_iter().zip(is_placed).enumerate() {
        built.push(match is_placed {
            true => mesh(input, &mut parts, number, given)?,
            false => None,
        });
    }
    for (number, placement) in placements.into_iter().enumerate() {
        let Some((mesh, own)) = built[placement.mesh] else {
            continue;
        };
        let name = named(&placement.name, || parts.meshes[mesh as usize].name.clone());
        let transform = affine(input, placement.transform, || {
            place("placement", number, &placement.name)
        })?;
        parts
            .instances
            .push(Instance::new(name, mesh, transform * own));
    }
    Ok(parts)
}

/// Adds a mesh; its number and its own transform, or `None` where no triangle of it is left.
fn mesh(
    input: &mut Input,
    parts: &mut Parts,
    number: usize,
    given: Mesh,
) -> Result<Option<(u32, DAffine3)>, Error> {
    let place = place("mesh", number, &given.name);
    let vertices = given.positions.len();
    for (what, count) in [
        ("normals", given.normals.len()),
        ("tangents", given.tangents.len()),
        ("uvs", given.uvs.len()),
        ("lightmap_uvs", given.lightmap_uvs.len()),
        ("colors", given.colors.len()),
    ] {
        if count != 0 && count != vertices {
            let problem =
                format!("{count} {what} for {vertices} positions; give one a vertex or none");
            return Err(input.invalid(place, problem));
        }
    }
    if given.material >= parts.materials.len() {
        let problem = format!(
            "it is of material {} but there are {}, numbered from 0; correct its number",
            given.material,
            parts.materials.len()
        );
        return Err(input.invalid(place, problem));
    }
    // Lightmap coordinates are the second set, and textures do not read what stands in for the first.
    let is_bare = given.uvs.is_empty() && !given.lightmap_uvs.is_empty();
    let mut material = given.material as u32;
    if is_bare {
        let textured = &parts.materials[given.material];
        if let Some(plain) = validate::without_textures(input, &place, textured, |set| set != 0) {
            parts.materials.push(plain);
            material = parts.materials.len() as u32 - 1;
        }
    }
    let transform = affine(input, given.transform, || place.clone())?;
    let colors = given.colors.into_iter().map(Vec4::from_array);
    let (colors, alphas) = colors.map(|color| (color.truncate(), color.w)).unzip();
    let mut mesh = crate::Mesh {
        name: named(&given.name, || format!("mesh {number}")),
        positions: vectors(given.positions),
        normals: vectors(given.normals),
        tangents: given.tangents.into_iter().map(Vec4::from_array).collect(),
        colors,
        alphas,
        uv_sets: uv_sets(given.uvs, given.lightmap_uvs, vertices),
        triangles: given.triangles,
        material,
        origin: MeshOrigin {
            mesh: number as u32,
            primitive: 0,
        },
        ..crate::Mesh::default()
    };
    if !validate::mesh(input, &mut mesh, &place)? {
        return Ok(None);
    }
    parts.meshes.push(mesh);
    Ok(Some((parts.meshes.len() as u32 - 1, transform)))
}

/// Coordinates for textures, then those for lightmaps, which are the second set also where they are alone.
fn uv_sets(uvs: Vec<[f32; 2]>, lightmap: Vec<[f32; 2]>, vertices: usize) -> Vec<Vec<Vec2>> {
    let vectors = |uvs: Vec<[f32; 2]>| uvs.into_iter().map(Vec2::from_array).collect();
    match (uvs.is_empty(), lightmap.is_empty()) {
        (true, true) => Vec::new(),
        (false, true) => vec![vectors(uvs)],
        (false, false) => vec![vectors(uvs), vectors(lightmap)],
        (true, false) => vec![vec![Vec2::ZERO; vertices], vectors(lightmap)],
    }
}

/// The transform of these columns.
fn affine(
    input: &Input,
    columns: [[f32; 4]; 4],
    place: impl Fn() -> String,
) -> Result<DAffine3, Error> {
    validate::affine(columns.map(|column| column.map(f64::from))).ok_or_else(|| {
        let problem = "its transform is not affine (the last row is not 0 0 0 1); are rows and columns exchanged?";
        input.invalid(place(), problem)
    })
}

fn vectors(arrays: Vec<[f32; 3]>) -> Vec<Vec3> {
    arrays.into_iter().map(Vec3::from_array).collect()
}
