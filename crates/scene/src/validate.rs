//! What is accepted, what is repaired and what is refused, decided in one place.
//!
//! Data that is corrupt stops the load: a bake of it would be a lie. Junk that has no influence on the picture is
//! repaired or left out, and counted in [`Scene::warnings`] with mesh and primitive: the variants of [`WarningKind`]
//! say what and how. The rest:
//!
//! | finding | verdict |
//! |---|---|
//! | scene file or buffer absent, empty, unreadable or cut short; directory for a file; wrong magic | error |
//! | broken JSON, broken OBJ number, index 0 in OBJ, reference out of range, cycle of nodes | error |
//! | required extension that is not implemented | error `Extension` |
//! | vertex index out of range | error |
//! | position that is not finite, or beyond [`REACH`], used by a triangle | error |
//! | instance that reaches beyond [`REACH`] in the world, or whose matrix is not finite or not affine | error |
//! | instance of which no side is as long as 1e-12 units, or whose transform has no inverse | left out |
//! | no triangle in the whole scene | error `NoTriangles` |
//! | broken, but the scene can do without (picture, attribute but positions, property of a material) | left out |
//! | in memory: normals or UVs not one a vertex, material number out of range, texture of another size | `Authored` |
//! | normal that is not of unit length | made so, silently |

use crate::around;
use crate::input::{Input, short};
use crate::material::tell_scaled;
use crate::{
    Alpha, Error, Format, GltfDocument, Image, Instance, Light, Material, MaterialModel, Mesh,
    PackedImage, Scene, TextureRef, WarningKind, far,
};
use glam::{DAffine3, DVec3, DVec4, Vec2, Vec3, Vec4};
use std::collections::HashMap;
use std::sync::Arc;

/// Largest coordinate that the ray tracers take: Embree ignores vertices from about 1.8e18 on, so that squares of
/// coordinates stay finite in f32.
pub(crate) const REACH: f32 = 1e18;

/// The least that an instance's largest side may be. Embree multiplies three lengths in f32, and meets nothing of what
/// is 1e-16 long.
const LEAST: f64 = 1e-12;

/// What a reader hands over; [`scene`] makes a [`Scene`] of it.
#[derive(Default)]
pub(crate) struct Parts {
    pub meshes: Vec<Mesh>,
    pub instances: Vec<Instance>,
    pub materials: Vec<Material>,
    pub images: Vec<Image>,
    pub packed_images: Vec<PackedImage>,
    pub lights: Vec<Light>,
    pub source: Option<Arc<GltfDocument>>,
}

/// The scene, once what the reader found is judged as a whole.
pub(crate) fn scene(mut input: Input, format: Format, mut parts: Parts) -> Result<Scene, Error> {
    instances(&mut input, &mut parts)?;
    if parts.instances.is_empty() {
        let mut told: Vec<&str> = Vec::new();
        for message in input
            .warnings
            .iter()
            .map(|warning| warning.message.as_str())
        {
            if !told.contains(&message) && told.len() < 2 {
                told.push(message);
            }
        }
        let hint: String = told.iter().map(|message| format!("; {message}")).collect();
        return Err(Error::NoTriangles {
            path: input.path,
            hint,
        });
    }
    far::warn(&mut input, format, &parts.meshes, &parts.instances);
    invisible_materials(&mut input, &parts);
    textures_without_uvs(&mut input, &mut parts);
    tell_scaled(&mut input);
    let Parts {
        mut meshes,
        mut instances,
        mut materials,
        mut images,
        packed_images,
        lights,
        source,
    } = parts;
    meshes.shrink_to_fit();
    instances.shrink_to_fit();
    materials.shrink_to_fit();
    images.shrink_to_fit();
    let content_hash = input.hasher.finalize().to_hex().to_string();
    Ok(Scene {
        path: input.path,
        format,
        meshes,
        instances,
        materials,
        images,
        packed_images,
        lights,
        warnings: input.warnings,
        content_hash,
        source,
        inputs: input.files,
    })
}

/// Judges and repairs one mesh as read; false if no triangle is left.
///
/// `place` names mesh and primitive. Positions, normals and UVs have the same length, or normals are empty.
pub(crate) fn mesh(input: &mut Input, mesh: &mut Mesh, place: &str) -> Result<bool, Error> {
    faces(input, mesh, place, |_| false)
}

/// The same for faces that were cut into triangles: `goes_on` is true for the number of a triangle that is of the face
/// that the one before is of.
pub(crate) fn faces(
    input: &mut Input,
    mesh: &mut Mesh,
    place: &str,
    goes_on: impl Fn(usize) -> bool,
) -> Result<bool, Error> {
    let vertices = mesh.positions.len();
    if let Some(t) = mesh
        .triangles
        .iter()
        .position(|t| t.iter().any(|&i| i as usize >= vertices))
    {
        let problem = format!(
            "triangle {t} uses vertices {:?} but there are {vertices}; its indices are corrupt, \
             export or build it again",
            mesh.triangles[t]
        );
        return Err(input.invalid(place, problem));
    }
    bad_positions(input, mesh, place)?;
    zero_areas(input, mesh, place, goes_on);
    if mesh.triangles.is_empty() {
        input.warn(
            WarningKind::EmptyMeshes,
            place,
            1,
            "the mesh has no triangle with an area and is left out",
        );
        return Ok(false);
    }
    bad_normals(input, mesh, place);
    let good = |t: &Vec4| t.is_finite() && t.truncate() != Vec3::ZERO;
    let bad = mesh.tangents.iter().filter(|t| !good(t)).count();
    if bad > 0 {
        mesh.tangents = Vec::new();
        let message = "tangents that are zero or not finite: the mesh gets tangents from its UVs";
        input.warn(WarningKind::BadTangents, place, bad as u64, message);
    }
    colors(input, mesh, place);
    for set in &mut mesh.uv_sets {
        let mut count = 0;
        for uv in set.iter_mut().filter(|uv| !uv.is_finite()) {
            *uv = Vec2::ZERO;
            count += 1;
        }
        input.warn(
            WarningKind::BadUvs,
            place,
            count,
            "UVs that are not finite are set to (0, 0)",
        );
    }
    Ok(true)
}

/// Brings vertex colours into 0..=1, and leaves those away that change nothing.
fn colors(input: &mut Input, mesh: &mut Mesh, place: &str) {
    let mut changed = 0;
    for color in &mut mesh.colors {
        *color = color.map(|c| clamped(c, 0.0, 1.0, 1.0, &mut changed));
    }
    for alpha in &mut mesh.alphas {
        *alpha = clamped(*alpha, 0.0, 1.0, 1.0, &mut changed);
    }
    let message = "channels of vertex colours out of 0 to 1 are clamped";
    input.warn(WarningKind::ClampedFactors, place, changed, message);
    if mesh.colors.iter().all(|&color| color == Vec3::ONE) {
        mesh.colors = Vec::new();
    }
    if mesh.alphas.iter().all(|&alpha| alpha == 1.0) {
        mesh.alphas = Vec::new();
    }
}

fn bad_positions(input: &mut Input, mesh: &mut Mesh, place: &str) -> Result<(), Error> {
    // False for NaN too.
    let good = |p: &Vec3| p.abs().max_element() <= REACH && p.is_finite();
    let Some(first) = mesh.positions.iter().position(|p| !good(p)) else {
        return Ok(());
    };
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        if let Some(&v) = triangle
            .iter()
            .find(|&&v| v as usize >= first && !good(&mesh.positions[v as usize]))
        {
            let p = mesh.positions[v as usize];
            let problem = format!(
                "vertex {v} of triangle {t} lies at ({}, {}, {}), which is not finite or beyond {REACH:e}; \
                 repair the mesh",
                p.x, p.y, p.z
            );
            return Err(input.invalid(place, problem));
        }
    }
    let home = mesh
        .triangles
        .first()
        .map_or(Vec3::ZERO, |t| mesh.positions[t[0] as usize]);
    let mut count = 0;
    for p in mesh.positions.iter_mut().filter(|p| !good(p)) {
        *p = home;
        count += 1;
    }
    let message =
        "vertices that are not finite and that no triangle uses are moved onto a used vertex";
    input.warn(WarningKind::UnusedBadVertices, place, count, message);
    Ok(())
}

/// Twice the area times the geometric normal. Differences of f32 and their products are exact enough in f64 that the
/// result is zero for triangles with a repeated corner or three corners in line on representable multiples.
fn area_vector(positions: &[Vec3], triangle: [u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Drops triangles without an area. Where a face has one all the same, it was cut so because corners of it are in line
/// or coincide, and is nobody's fault; the others count.
fn zero_areas(input: &mut Input, mesh: &mut Mesh, place: &str, goes_on: impl Fn(usize) -> bool) {
    let positions = &mesh.positions;
    let flat = |t: &[u32; 3]| area_vector(positions, *t) == DVec3::ZERO;
    let count = mesh.triangles.iter().filter(|t| flat(t)).count();
    if count == 0 {
        return;
    }
    let (mut faces, mut is_flat) = (0, false);
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        if !goes_on(number) {
            faces += u64::from(is_flat);
            is_flat = true;
        }
        is_flat &= flat(triangle);
    }
    faces += u64::from(is_flat);
    let mut source = Vec::with_capacity(mesh.triangles.len() - count);
    let mut number = 0..mesh.triangles.len() as u32;
    mesh.triangles.retain(|triangle| {
        let keep = !flat(triangle);
        source.extend(number.next().filter(|_| keep));
        keep
    });
    mesh.triangles.shrink_to_fit();
    mesh.source_triangles = source;
    input.warn(
        WarningKind::ZeroAreaTriangles,
        place,
        faces,
        "faces without an area are dropped",
    );
}

fn bad_normals(input: &mut Input, mesh: &mut Mesh, place: &str) {
    let mut bad: HashMap<u32, DVec3> = HashMap::new();
    for (i, normal) in mesh.normals.iter_mut().enumerate() {
        match normal.as_dvec3().try_normalize() {
            Some(unit) => *normal = unit.as_vec3(),
            None => {
                bad.insert(i as u32, DVec3::ZERO);
            }
        }
    }
    if bad.is_empty() {
        return;
    }
    let count = bad.len() as u64;
    if bad.len() == mesh.normals.len() {
        mesh.normals = Vec::new();
        let message =
            "every normal is zero or not finite: the mesh is shaded with its geometric normals";
        input.warn(WarningKind::BadNormals, place, count, message);
        return;
    }
    let mut last = HashMap::new();
    for triangle in &mesh.triangles {
        for corner in triangle {
            if let Some(sum) = bad.get_mut(corner) {
                let area = area_vector(&mesh.positions, *triangle);
                *sum += area;
                last.insert(*corner, area);
            }
        }
    }
    for (vertex, sum) in bad {
        // Opposite faces cancel: then one of them stands for all. A vertex without triangles gets any unit vector.
        let one = last.get(&vertex).copied().unwrap_or(DVec3::Z);
        let unit = scaled_unit(sum).or(scaled_unit(one)).unwrap_or(DVec3::Z);
        mesh.normals[vertex as usize] = unit.as_vec3();
    }
    let message = "normals that are zero or not finite are replaced by the mean geometric normal around the vertex";
    input.warn(WarningKind::BadNormals, place, count, message);
}

/// Unit vector, also where the squared length would overflow or underflow.
fn scaled_unit(v: DVec3) -> Option<DVec3> {
    (v / v.abs().max_element()).try_normalize()
}

fn instances(input: &mut Input, parts: &mut Parts) -> Result<(), Error> {
    let bounds: Vec<(DVec3, DVec3)> = parts
        .meshes
        .iter()
        .map(|mesh| box_of(&mesh.positions))
        .collect();
    let mut kept = Vec::with_capacity(parts.instances.len());
    for instance in std::mem::take(&mut parts.instances) {
        let (low, high) = bounds[instance.mesh as usize];
        let transform = instance.transform;
        let corners = (0..8).map(|k| {
            DVec3::new(
                [low.x, high.x][k & 1],
                [low.y, high.y][k >> 1 & 1],
                [low.z, high.z][k >> 2],
            )
        });
        let mut corners = corners.map(|corner| transform.transform_point3(corner));
        let reaches = |corner: DVec3| corner.abs().max_element() <= REACH as f64;
        if !transform.is_finite() || !corners.all(reaches) {
            let problem = format!(
                "its transform puts the mesh beyond {REACH:e} or is not finite; scale the scene down"
            );
            return Err(input.invalid(short(&instance.name), problem));
        }
        if transform.matrix3.determinant() == 0.0 || !transform.inverse().is_finite() {
            let message =
                "the transform has no inverse (a scale of 0?), so the instance is left out";
            input.warn(WarningKind::SingularTransforms, instance.name, 1, message);
            continue;
        }
        let m = transform.matrix3;
        let size = high - low;
        let sides = m.x_axis.abs() * size.x + m.y_axis.abs() * size.y + m.z_axis.abs() * size.z;
        if sides.max_element() < LEAST {
            let message = format!(
                "the instance is smaller than {LEAST:e} units, where rays in f32 meet nothing, and is left out; scale \
                 the scene up"
            );
            input.warn(WarningKind::TinyInstances, instance.name, 1, message);
            continue;
        }
        kept.push(instance);
    }
    parts.instances = kept;
    Ok(())
}

fn box_of(positions: &[Vec3]) -> (DVec3, DVec3) {
    around(positions.iter().map(|p| p.as_dvec3()))
}

/// Notes materials in use that let all light through: some writers of OBJ mean the opposite by `Tr 1`.
fn invisible_materials(input: &mut Input, parts: &Parts) {
    let mut used = vec![false; parts.materials.len()];
    for instance in &parts.instances {
        used[parts.meshes[instance.mesh as usize].material as usize] = true;
    }
    for (material, _) in parts.materials.iter().zip(used).filter(|(_, used)| *used) {
        let invisible = matches!(material.alpha, Alpha::Blend { factor, .. } if factor == 0.0);
        let message = "it lets all light through (an alpha of 0, `Tr 1` or `d 0`), so that nothing of it blocks \
                       light; where it is meant to be opaque, give it an alpha of 1 (`d 1`)";
        let place = format!("material `{}`", short(&material.name));
        input.warn(
            WarningKind::InvisibleMaterials,
            place,
            invisible.into(),
            message,
        );
    }
}

/// Gives each mesh a material whose textures read only UV sets that the mesh has.
fn textures_without_uvs(input: &mut Input, parts: &mut Parts) {
    let mut reduced: HashMap<(u32, usize), u32> = HashMap::new();
    for mesh in &mut parts.meshes {
        let sets = mesh.uv_sets.len();
        let material = &parts.materials[mesh.material as usize];
        let has = |set: u32| (set as usize) < sets;
        let Some(material) = without_textures(input, &mesh.name, material, has) else {
            continue;
        };
        mesh.material = *reduced.entry((mesh.material, sets)).or_insert_with(|| {
            parts.materials.push(material);
            parts.materials.len() as u32 - 1
        });
    }
}

/// A material without the textures that read UV sets which a mesh has not, told of; `None` where it has all.
pub(crate) fn without_textures(
    input: &mut Input,
    mesh: &str,
    material: &Material,
    has: impl Fn(u32) -> bool,
) -> Option<Material> {
    let mut reduced = material.clone();
    let mut dropped = 0;
    for slot in slots(&mut reduced) {
        if slot.as_ref().is_some_and(|texture| !has(texture.uv_set)) {
            *slot = None;
            dropped += 1;
        }
    }
    let map = reduced.normal_map.as_ref();
    if map.is_some_and(|map| !has(map.texture.uv_set)) {
        reduced.normal_map = None;
        dropped += 1;
    }
    let message = format!(
        "material `{}` reads UV sets that the mesh has not; its factors stand alone",
        material.name
    );
    input.warn(WarningKind::TexturesWithoutUvs, mesh, dropped, message);
    (dropped > 0).then_some(reduced)
}

/// The places of a material where a texture can stand.
pub(crate) fn slots(material: &mut Material) -> impl Iterator<Item = &mut Option<TextureRef>> {
    let surface = match &mut material.surface {
        MaterialModel::Phong { albedo_map, .. } => [Some(albedo_map), None],
        MaterialModel::MetallicRoughness {
            base_map,
            metallic_roughness_map,
            ..
        } => [Some(base_map), Some(metallic_roughness_map)],
        MaterialModel::SpecularGlossiness {
            diffuse_map,
            specular_glossiness_map,
            ..
        } => [Some(diffuse_map), Some(specular_glossiness_map)],
    };
    let alpha = match &mut material.alpha {
        Alpha::Opaque => None,
        Alpha::Mask { map, .. } | Alpha::Blend { map, .. } => Some(map),
    };
    let transmission = material.transmission.as_mut().map(|t| &mut t.map);
    surface
        .into_iter()
        .chain([alpha, transmission, Some(&mut material.emission_map)])
        .flatten()
}

/// How far the last row of a matrix may be from 0 0 0 1: what is left of it where matrices are multiplied in 32 bits,
/// or where decimals of six digits are written. A row that means a perspective is farther.
const ROUNDING: f64 = 1e-5;

/// The affine transform of a matrix given column by column; `None` where its last row is not 0 0 0 1, but for rounding.
pub(crate) fn affine(columns: [[f64; 4]; 4]) -> Option<DAffine3> {
    let [x, y, z, w] = columns.map(|[x, y, z, _]| DVec3::new(x, y, z));
    let row = DVec4::from_array(columns.map(|column| column[3]));
    // False for NaN too.
    let affine = (row - DVec4::W).abs().max_element() <= ROUNDING && row.is_finite();
    affine.then(|| DAffine3::from_cols(x, y, z, w))
}

/// A factor brought into `low..=high`; `fallback` for NaN. Counts what it changes.
pub(crate) fn clamped(value: f32, low: f32, high: f32, fallback: f32, changed: &mut u64) -> f32 {
    let good = if value.is_nan() {
        fallback
    } else {
        value.clamp(low, high)
    };
    *changed += (good != value) as u64;
    good
}
