//! glTF primitives as meshes.

use super::accessor::Data;
use super::elements::Elements;
use super::nodes::Placement;
use crate::source::Input;
use crate::validate::{self, Parts};
use crate::{Error, Mesh, MeshOrigin, WarningKind};
use glam::{Vec2, Vec3, Vec4};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use std::collections::BTreeMap;

/// Stands in [`Mesh::material`] for a primitive without a material until all materials are known.
pub(super) const NO_MATERIAL: u32 = u32::MAX;

/// Loads the primitives of every mesh that is placed, in file order, and returns for each glTF mesh its meshes.
pub(super) fn load(
    input: &mut Input,
    data: &Data,
    placements: &[Placement],
    parts: &mut Parts,
) -> Result<BTreeMap<usize, Vec<u32>>, Error> {
    let mut loaded: BTreeMap<usize, Vec<u32>> =
        placements.iter().map(|p| (p.mesh, Vec::new())).collect();
    for (&m, numbers) in &mut loaded {
        // Validation has seen the index.
        let Some(mesh) = data.root.meshes.get(m) else {
            continue;
        };
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {m} primitive {p}");
            let name = match (&mesh.name, mesh.primitives.len()) {
                (Some(name), 1) => name.clone(),
                (Some(name), _) => format!("{name} primitive {p}"),
                (None, _) => place.clone(),
            };
            let origin = MeshOrigin {
                mesh: m as u32,
                primitive: p as u32,
            };
            let Some(mut mesh) = read(input, data, primitive, &place, name, origin)? else {
                continue;
            };
            if validate::mesh(input, &mut mesh, &place)? {
                numbers.push(parts.meshes.len() as u32);
                parts.meshes.push(mesh);
            }
        }
    }
    Ok(loaded)
}

fn read(
    input: &mut Input,
    data: &Data,
    primitive: &Primitive,
    place: &str,
    name: String,
    origin: MeshOrigin,
) -> Result<Option<Mesh>, Error> {
    let mode = match primitive.mode {
        Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
        _ => {
            input.warn(
                WarningKind::PointsAndLines,
                place,
                1,
                "a primitive without surface is left out",
            );
            return Ok(None);
        }
    };
    if !primitive
        .attributes
        .contains_key(&Checked::Valid(Semantic::Positions))
    {
        let message = "a primitive without POSITION has no surface and is left out";
        input.warn(WarningKind::EmptyMeshes, place, 1, message);
        return Ok(None);
    }
    let targets = primitive
        .targets
        .as_ref()
        .map_or(0, |targets| targets.len() as u64);
    input.warn(
        WarningKind::MorphTargets,
        place,
        targets,
        "morph targets are left out: the base shape is baked",
    );
    let invalid = |problem: String| input.invalid(place, problem);
    let attribute = |semantic: Semantic, kind: Type| {
        let index = primitive.attributes.get(&Checked::Valid(semantic));
        index
            .map(|&index| data.open(index, &[kind]))
            .transpose()
            .map_err(invalid)
    };

    let positions = attribute(Semantic::Positions, Type::Vec3)?;
    let positions =
        positions.ok_or_else(|| invalid("it has no POSITION; export the file again".into()))?;
    let normals = attribute(Semantic::Normals, Type::Vec3)?;
    let tangents = attribute(Semantic::Tangents, Type::Vec4)?;
    let mut color = primitive
        .attributes
        .get(&Checked::Valid(Semantic::Colors(0)))
        .map(|&index| data.open(index, &[Type::Vec3, Type::Vec4]))
        .transpose()
        .map_err(invalid)?;
    // Integers are always shares here; a file that does not say so has the same numbers.
    if let Some(color) = &mut color {
        color.normalized = true;
    }
    let mut uvs = Vec::new();
    while let Some(set) = attribute(Semantic::TexCoords(uvs.len() as u32), Type::Vec2)? {
        uvs.push(set);
    }
    for (what, other) in normals
        .iter()
        .map(|n| ("NORMAL", n))
        .chain(tangents.iter().map(|t| ("TANGENT", t)))
        .chain(color.iter().map(|c| ("COLOR_0", c)))
        .chain(uvs.iter().map(|u| ("TEXCOORD", u)))
    {
        if other.count != positions.count {
            let problem = format!(
                "{} of {what} for {} of POSITION; the file is corrupt",
                other.count, positions.count
            );
            return Err(invalid(problem));
        }
    }
    let indices = primitive
        .indices
        .map(|index| data.open(index, &[Type::Scalar]))
        .transpose()
        .map_err(invalid)?;
    if indices
        .as_ref()
        .is_some_and(|indices| !indices.holds_indices())
    {
        return Err(invalid(
            "its indices are not unsigned integers; export the file again".into(),
        ));
    }
    let corners = indices
        .as_ref()
        .map_or(positions.count, |indices| indices.count);
    let mut triangles = match &indices {
        Some(indices) => triangles_of(mode, corners, |i| indices.index(i)),
        None => triangles_of(mode, corners, |i| i as u32),
    };

    let used = compacted(&mut triangles, positions.count).map_err(invalid)?;
    let is_set = |s: &&Checked<Semantic>| matches!(s, Checked::Valid(Semantic::TexCoords(_)));
    let beyond = primitive.attributes.keys().filter(is_set).count() - uvs.len();
    let mesh = Mesh {
        name,
        positions: gather(&positions, &used, Vec3::from_array),
        normals: normals
            .map(|normals| gather(&normals, &used, Vec3::from_array))
            .unwrap_or_default(),
        tangents: tangents
            .map(|tangents| gather(&tangents, &used, Vec4::from_array))
            .unwrap_or_default(),
        colors: match &color {
            Some(rgb) if rgb.lanes() == Some(3) => gather(rgb, &used, Vec3::from_array),
            Some(rgba) => gather(rgba, &used, |[r, g, b, _]| Vec3::new(r, g, b)),
            None => Vec::new(),
        },
        alphas: color
            .filter(|color| color.lanes() == Some(4))
            .map(|color| gather(&color, &used, |[_, _, _, alpha]| alpha))
            .unwrap_or_default(),
        uv_sets: uvs
            .iter()
            .map(|set| gather(set, &used, Vec2::from_array))
            .collect(),
        triangles,
        source_triangles: Vec::new(),
        source_vertices: used.unwrap_or_default(),
        material: primitive
            .material
            .map_or(NO_MATERIAL, |material| material.value() as u32),
        origin,
    };
    input.warn(
        WarningKind::UvSetsAfterAGap,
        place,
        beyond as u64,
        "UV sets after a missing number are left out",
    );
    let leftover = if mode == Mode::Triangles {
        corners % 3
    } else {
        0
    };
    input.warn(
        WarningKind::LeftoverIndices,
        place,
        leftover as u64,
        "indices that make no whole triangle are left out",
    );
    Ok(Some(mesh))
}

/// The triangles of section 3.7.2.1 of the specification, in its order of corners.
fn triangles_of(mode: Mode, corners: usize, index: impl Fn(usize) -> u32) -> Vec<[u32; 3]> {
    let count = if mode == Mode::Triangles {
        corners / 3
    } else {
        corners.saturating_sub(2)
    };
    let triangle = |i: usize| match mode {
        Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
        Mode::TriangleFan => [i + 1, i + 2, 0],
        _ => [3 * i, 3 * i + 1, 3 * i + 2],
    };
    (0..count).map(|i| triangle(i).map(&index)).collect()
}

/// Vertex arrays up to this size are kept whole, with the file's numbers.
const KEPT_WHOLE: usize = 4096;

/// Many primitives may share one large array and each use a small part of it. Then the used vertices are kept alone, in
/// file order, and the triangles refer to those; otherwise one array would be loaded as often as it is named. `None`
/// where all are kept, with the file's numbers: a small array, or at most six vertices a triangle.
fn compacted(triangles: &mut [[u32; 3]], vertices: usize) -> Result<Option<Vec<u32>>, String> {
    if vertices <= KEPT_WHOLE.max(6 * triangles.len()) {
        return Ok(None);
    }
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    if let Some(last) = used.last().filter(|&&last| last as usize >= vertices) {
        return Err(format!(
            "a triangle uses vertex {last} but there are {vertices}; the file is corrupt, export it again"
        ));
    }
    for index in triangles.iter_mut().flatten() {
        *index = used.partition_point(|u| u < index) as u32;
    }
    Ok(Some(used))
}

fn gather<const N: usize, T>(
    elements: &Elements,
    used: &Option<Vec<u32>>,
    make: impl Fn([f32; N]) -> T,
) -> Vec<T> {
    match used {
        Some(used) => used
            .iter()
            .map(|&i| make(elements.floats(i as usize)))
            .collect(),
        None => (0..elements.count)
            .map(|i| make(elements.floats(i)))
            .collect(),
    }
}
