//! `STEM.glb`: the input scene with the lightmap UV set as `TEXCOORD_1` and the diffuse term as `occlusionTexture`.
//!
//! A glTF input is patched, not rewritten: the scene keeps its document as plain values, so extensions, extras,
//! animations, skins, cameras, morph targets and every attribute survive whether ambake knows them or not. The file is
//! not opened again. What changes is listed in vendor-notes/gltf-writing.md. A scene without a document, from OBJ or
//! built in memory, becomes a small glTF document first and takes the same road.

mod accessor;
mod document;
mod from_obj;
mod geometry;
mod material;
mod node;
pub(crate) mod places;
mod prune;

use crate::{Error, check_regular};
use atlas::Atlas;
use document::Document;
use geometry::Geometry;
use material::Materials;
use scene::Scene;
use serde_json::Value;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// By object, a number for each vertex of its mesh, 0..=1; none of an object without texels.
pub type Shades = HashMap<usize, Vec<f32>>;

/// A reason, without the file: the caller adds it.
type Reason = String;

/// Where the meshes and objects of a scene stand in the document, and how much of it the layout leaves as it is.
struct Origins {
    /// glTF mesh and primitive of each scene mesh.
    meshes: Vec<(usize, usize)>,
    /// glTF node of each instance, and which copy of its mesh under `EXT_mesh_gpu_instancing`.
    instances: Vec<(usize, Option<usize>)>,
    /// The document's vertices and indices are those of the layout already.
    laid_out: bool,
}

/// The GLB of a baked scene: self-contained, lightmap coordinates baked into the vertices.
///
/// * `occlusion`: one PNG file a page, as [`crate::occlusion_png`] makes it; embedded and named by every material whose
///   triangles lie on that page. `None` writes the lightmap coordinates alone.
/// * `shades`: by what vertex colours are multiplied.
///
/// # Errors
/// [`Error::Write`] with an empty path where the file would pass the format's 4 GiB.
///
/// # Panics
/// Where scene, atlas and pages do not fit each other: a bug of the caller.
pub fn write_gltf(
    scene: &Scene,
    atlas: &Atlas,
    occlusion: Option<&[Vec<u8>]>,
    shades: &Shades,
) -> Result<Vec<u8>, Error> {
    assert_eq!(
        scene.meshes.len(),
        atlas.meshes.len(),
        "a layout for each mesh"
    );
    assert_eq!(
        scene.instances.len(),
        atlas.placements.len(),
        "a placement for each instance"
    );
    assert!(
        occlusion.is_none_or(|pictures| pictures.len() == atlas.page_count as usize),
        "a picture for each page"
    );
    let read = |reason: Reason| Error::read(&scene.path, reason);
    let (mut document, origins) = match &scene.source {
        None => from_obj::document(scene, atlas).map_err(read)?,
        Some(source) => {
            let origins = Origins {
                meshes: scene
                    .meshes
                    .iter()
                    .map(|m| (m.origin.mesh as usize, m.origin.primitive as usize))
                    .collect(),
                instances: scene
                    .instances
                    .iter()
                    .map(|i| (i.node as usize, i.copy.map(|c| c as usize)))
                    .collect(),
                laid_out: false,
            };
            (Document::of(source).map_err(read)?, origins)
        }
    };
    patch(&mut document, scene, atlas, (occlusion, shades), &origins).map_err(read)?;
    document.prune();
    document
        .into_glb()
        .map_err(|e| Error::write(Path::new(""), e))
}

/// The GLB of a scene as its glTF file has it, self-contained; `None` of a scene that came from no such file.
///
/// # Errors
/// As [`write_gltf`].
pub fn source_gltf(scene: &Scene) -> Result<Option<Vec<u8>>, Error> {
    let Some(source) = &scene.source else {
        return Ok(None);
    };
    let document = Document::of(source).map_err(|reason| Error::read(&scene.path, reason))?;
    let glb = document.into_glb();
    glb.map(Some).map_err(|e| Error::write(Path::new(""), e))
}

/// The bytes of a GLB that a bake wrote.
///
/// # Errors
/// It is absent, or no regular file.
pub fn read_gltf(path: &Path) -> Result<Vec<u8>, Error> {
    let bytes = check_regular(path).and_then(|()| std::fs::read(path));
    bytes.map_err(|e| Error::read(path, e.to_string()))
}

/// A mesh user: a node, or one copy of an instanced node.
type User = (usize, Option<usize>);

fn patch(
    document: &mut Document,
    scene: &Scene,
    atlas: &Atlas,
    (occlusion, shades): (Option<&[Vec<u8>]>, &Shades),
    origins: &Origins,
) -> Result<(), Reason> {
    geometry::share_texcoord_1(document);
    // The objects of each user, by primitive.
    let mut users: Vec<(User, HashMap<usize, usize>)> = Vec::new();
    let mut at: HashMap<User, usize> = HashMap::new();
    for (i, instance) in scene.instances.iter().enumerate() {
        let user = origins.instances[i];
        let slot = *at.entry(user).or_insert_with(|| {
            users.push((user, HashMap::new()));
            users.len() - 1
        });
        users[slot]
            .1
            .insert(origins.meshes[instance.mesh as usize].1, i);
    }
    let plan = node::MeshPlan::of(document, users.iter().map(|(user, _)| *user))?;
    let originals = document.list("meshes")?.clone();
    // Primitives of which some object takes no texels: it keeps its material.
    let unlit: HashSet<(usize, usize)> = scene
        .instances
        .iter()
        .zip(&atlas.placements)
        .filter(|(_, placement)| !placement.is_somewhere())
        .map(|(instance, _)| origins.meshes[instance.mesh as usize])
        .collect();
    let mut materials = Materials::new(document, scene, occlusion, |mesh, primitive| {
        let place = (mesh, primitive);
        plan.stays(mesh) || unlit.contains(&place) || !origins.meshes.contains(&place)
    })?;
    let as_placed = atlas
        .placements
        .iter()
        .filter(|p| p.is_somewhere())
        .all(|p| p.scale == [1.0; 2] && p.offset == [0.0; 2]);
    let mut geometries: HashMap<u32, Geometry> = HashMap::new();
    let mut placed = Vec::with_capacity(users.len());
    for (user, objects) in &users {
        let original = plan.mesh_of(document, user.0)?;
        let mut mesh = originals
            .get(original)
            .ok_or_else(|| format!("mesh {original} is absent"))?
            .clone();
        let mut primitives = Vec::new();
        let old = mesh
            .get("primitives")
            .and_then(Value::as_array)
            .ok_or("a mesh has no primitives")?;
        for (p, primitive) in old.iter().enumerate() {
            let lit = objects
                .get(&p)
                .filter(|&&o| atlas.placements[o].is_somewhere());
            let Some(&object) = lit else {
                primitives.push(primitive.clone());
                continue;
            };
            let instance = &scene.instances[object];
            let geometry = match geometries.entry(instance.mesh) {
                std::collections::hash_map::Entry::Occupied(entry) => entry.into_mut(),
                std::collections::hash_map::Entry::Vacant(entry) => {
                    let (mesh, layout) = (
                        &scene.meshes[instance.mesh as usize],
                        &atlas.meshes[instance.mesh as usize],
                    );
                    entry.insert(Geometry::build(
                        document,
                        primitive,
                        mesh,
                        layout,
                        origins.laid_out,
                        as_placed,
                    )?)
                }
            };
            let layout = &atlas.meshes[instance.mesh as usize];
            let placement = &atlas.placements[object];
            let lightmap = geometry::lightmap(document, geometry, layout, placement)?;
            let mesh = &scene.meshes[instance.mesh as usize];
            let shade = shades.get(&object);
            let shade = shade.map(|shades| geometry::colors(document, (mesh, shades), layout));
            let shade = shade.transpose()?;
            for part in &geometry.parts {
                let page = placement.page + u32::from(part.page);
                let mut own = geometry.primitive(primitive, part, lightmap, |uses| {
                    materials.get(document, uses, page)
                })?;
                if let Some(shade) = shade {
                    own["attributes"]["COLOR_0"] = shade.into();
                }
                primitives.push(own);
            }
        }
        mesh["primitives"] = Value::Array(primitives);
        placed.push((*user, plan.place(document, original, *user, mesh)?));
    }
    node::assign(document, &plan, &placed)?;
    for removed in [
        "EXT_mesh_gpu_instancing",
        "KHR_draco_mesh_compression",
        "KHR_texture_transform",
    ] {
        document.drop_unused_extension(removed);
    }
    Ok(())
}
