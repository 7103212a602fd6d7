//! Wavefront OBJ: one [`Mesh`] and one [`Instance`] for each (object or group, material) of the file. It stands
//! where the file says, or, far from the origin, at one place for all, from which their coordinates count.
//!
//! The file is read as a stream by a reader of our own, for reasons measured in `vendor-notes/obj.md`: a line costs no
//! allocation, a face is turned into corners at once, and memory stays near twice the raw data. `tobj` is the referee
//! of the tests.
//!
//! What is junk rather than corruption is counted: see [`WarningKind`].

mod corners;
mod lines;
mod mtl;
mod options;
mod polygon;

use crate::input::{Input, kept_name};
use crate::validate::{self, Parts};
use crate::{Error, Instance, Material, Mesh, MeshOrigin, WarningKind, far};
use corners::{Corners, Faces, NONE};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use std::collections::{HashMap, HashSet};

/// What the lines of the file say, before corners become vertices.
#[derive(Default)]
struct File {
    /// As precise as the text has them: far from the origin 32 bits would lose what is fine.
    positions: Vec<DVec3>,
    /// Linear colours of the first positions, as far as one was named; the others are white.
    colors: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    corners: Corners,
    /// Names of the parts, and the number of the material name of each.
    parts: Vec<(String, u32)>,
    /// Material names in the order of their first use; the first is the empty name for none.
    materials: Vec<String>,
    libraries: Vec<String>,
}

/// Reads the OBJ file of `input`, its material libraries and textures.
pub(crate) fn load(input: &mut Input) -> Result<Parts, Error> {
    let mut file = lines::read(input)?;
    let mut parts = Parts::default();
    // The same material for every part that names none or an unknown one; dropped again if there is no such part.
    let used: HashSet<&str> = (file.parts.iter())
        .map(|&(_, material)| file.materials[material as usize].as_str())
        .collect();
    let library = mtl::load(input, &file.libraries, &used, &mut parts)?;
    let mut untinted_index = None;
    let mut index_of = |input: &mut Input, parts: &mut Parts, name: &str| {
        if let Some(&known) = library.get(name) {
            return known;
        }
        let message = "the material is in no library that was read; its parts stay untinted";
        input.warn(
            WarningKind::UnknownMaterials,
            format!("material `{name}`"),
            !name.is_empty() as u64,
            message,
        );
        *untinted_index.get_or_insert_with(|| {
            parts.materials.push(Material::untinted("none"));
            parts.materials.len() as u32 - 1
        })
    };
    let mut materials = HashMap::new();
    let home = far::home(far::samples(file.positions.len()).map(|v| file.positions[v]));
    let (meshes, faces) = meshes(input, &mut file, home);
    for ((mesh, faces), part) in meshes.into_iter().zip(faces).zip(&file.parts) {
        let name = &file.materials[part.1 as usize];
        let material = match materials.get(name) {
            Some(&known) => known,
            None => *materials
                .entry(name)
                .or_insert(index_of(input, &mut parts, name)),
        };
        add(input, &mut parts, Mesh { material, ..mesh }, &faces, home)?;
    }
    if parts.materials.is_empty() {
        parts.materials.push(Material::untinted("none"));
    }
    Ok(parts)
}

/// A number, also as C libraries print what is none: `-nan(ind)`, `-1.#IND`, `1.#INF`.
fn number(word: &str) -> Option<f64> {
    let none = || {
        let bare = word.trim_start_matches(['-', '+']).to_ascii_lowercase();
        (bare.starts_with("nan") || bare.starts_with("1.#")).then_some(f64::NAN)
    };
    word.parse().ok().or_else(none)
}

/// A name of an object, a group or a material.
fn name(bytes: &[u8]) -> String {
    kept_name(&text_of(bytes)).into_owned()
}

/// What a line says. OBJ files come in every encoding: what is not UTF-8 is read byte by byte as Latin-1, which is
/// wrong for some, and keeps apart what differs in all.
fn text_of(bytes: &[u8]) -> String {
    let bytes = bytes.trim_ascii();
    let text = str::from_utf8(bytes).map(str::to_owned);
    text.unwrap_or_else(|_| bytes.iter().map(|&byte| char::from(byte)).collect())
}

fn add(
    input: &mut Input,
    parts: &mut Parts,
    mut mesh: Mesh,
    faces: &Faces,
    home: DVec3,
) -> Result<(), Error> {
    let place = format!("part {} `{}`", mesh.origin.mesh, mesh.name);
    if validate::faces(input, &mut mesh, &place, |triangle| faces.goes_on(triangle))? {
        parts.instances.push(Instance::new(
            mesh.name.clone(),
            parts.meshes.len() as u32,
            DAffine3::from_translation(home),
        ));
        parts.meshes.push(mesh);
    }
    Ok(())
}

/// One mesh a part, material not yet set, whose coordinates count from `home`, and which of its triangles are of one
/// face. Takes the corners and the vertex data out of `file`.
fn meshes(input: &mut Input, file: &mut File, home: DVec3) -> (Vec<Mesh>, Vec<Faces>) {
    let mut meshes: Vec<Mesh> = Vec::with_capacity(file.parts.len());
    let (corners, mut triangles, faces) =
        std::mem::take(&mut file.corners).into_vertices(file.parts.len());
    for (i, (name, _)) in file.parts.iter().enumerate() {
        let mut kept = std::mem::take(&mut triangles[i]);
        kept.shrink_to_fit();
        meshes.push(Mesh {
            name: name.clone(),
            triangles: kept,
            origin: MeshOrigin {
                mesh: i as u32,
                primitive: 0,
            },
            ..Mesh::default()
        });
    }
    // A part has normals or UVs if one of its corners has; the others get a zero, which validation repairs or keeps.
    let mut counts = vec![[0usize; 3]; meshes.len()];
    for corner in &corners {
        let count = &mut counts[corner.part as usize];
        count[0] += 1;
        count[1] += (corner.uv != NONE) as usize;
        count[2] += (corner.normal != NONE) as usize;
    }
    for (mesh, &[vertices, uvs, normals]) in meshes.iter_mut().zip(&counts) {
        mesh.positions.reserve_exact(vertices);
        if uvs > 0 {
            mesh.uv_sets.push(Vec::with_capacity(vertices));
            let message = "corners without a vt in a mesh that has some get the UV (0, 0)";
            input.warn(
                WarningKind::MissingUvs,
                format!("part `{}`", mesh.name),
                (vertices - uvs) as u64,
                message,
            );
        }
        if normals > 0 {
            mesh.normals.reserve_exact(vertices);
        }
    }
    for corner in &corners {
        let mesh = &mut meshes[corner.part as usize];
        let position = file.positions[corner.position as usize] - home;
        mesh.positions.push(position.as_vec3());
        if !file.colors.is_empty() {
            let color = file.colors.get(corner.position as usize);
            mesh.colors.push(color.copied().unwrap_or(Vec3::ONE));
        }
        if let Some(set) = mesh.uv_sets.first_mut() {
            // OBJ counts v upward from the bottom of the picture, glTF downward from its top.
            let uv = file
                .uvs
                .get(corner.uv as usize)
                .map_or(Vec2::ZERO, |uv| Vec2::new(uv.x, 1.0 - uv.y));
            set.push(uv);
        }
        if counts[corner.part as usize][2] > 0 {
            mesh.normals.push(
                file.normals
                    .get(corner.normal as usize)
                    .copied()
                    .unwrap_or(Vec3::ZERO),
            );
        }
    }
    (file.positions, file.colors, file.uvs, file.normals) = Default::default();
    (meshes, faces)
}
