//! glTF primitives as meshes.

use super::accessor::{index, shown, stated};
use super::elements::{Elements, Type};
use super::names::own_name;
use super::nodes::Placement;
use super::reader::Reader;
use crate::GltfDocument;
use crate::input::{Input, short};
use crate::validate::{self, Parts};
use crate::{Error, Mesh, MeshOrigin, WarningKind};
use glam::{Vec2, Vec3, Vec4};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Stands in [`Mesh::material`] for a primitive without a material until all materials are known.
pub(super) const NO_MATERIAL: u32 = u32::MAX;

/// Loads the primitives of every mesh that is placed, in file order, and returns for each glTF mesh its meshes.
pub(super) fn load(
    input: &mut Input,
    document: &GltfDocument,
    placements: &[Placement],
    parts: &mut Parts,
) -> Result<BTreeMap<usize, Vec<u32>>, Error> {
    let mut loaded: BTreeMap<usize, Vec<u32>> =
        placements.iter().map(|p| (p.mesh, Vec::new())).collect();
    for (&m, numbers) in &mut loaded {
        let json = &document.list("meshes")[m];
        Reader {
            input,
            place: &format!("mesh {m}"),
        }
        .text(json, "name");
        let own = own_name(json);
        let primitives = json.get("primitives").and_then(Value::as_array);
        let primitives = primitives.ok_or_else(|| {
            let said = shown(json, "primitives");
            let problem = format!("its primitives are {said}, and must be a list");
            input.invalid(format!("mesh {m}"), problem)
        })?;
        for (p, primitive) in primitives.iter().enumerate() {
            let place = format!("mesh {m} primitive {p}");
            let name = match (own, primitives.len()) {
                (Some(name), 1) => name.to_owned(),
                (Some(name), _) => format!("{name} primitive {p}"),
                (None, _) => place.clone(),
            };
            let origin = MeshOrigin {
                mesh: m as u32,
                primitive: p as u32,
            };
            let Some(mut mesh) = read(input, document, primitive, &place, name, origin)? else {
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

/// How indices make triangles.
#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Triangles,
    Strip,
    Fan,
}

fn read(
    input: &mut Input,
    document: &GltfDocument,
    primitive: &Value,
    place: &str,
    name: String,
    origin: MeshOrigin,
) -> Result<Option<Mesh>, Error> {
    let stated =
        |key: &str| stated(primitive, key).map_err(|problem| input.invalid(place, problem));
    let mode = match stated("mode")?.unwrap_or(4) {
        4 => Mode::Triangles,
        5 => Mode::Strip,
        6 => Mode::Fan,
        0..=3 => {
            input.warn(
                WarningKind::PointsAndLines,
                place,
                1,
                "a primitive without surface is left out",
            );
            return Ok(None);
        }
        other => {
            let problem =
                format!("its mode is {other}, and must be 4, 5 or 6 for triangles, or 0 to 3");
            return Err(input.invalid(place, problem));
        }
    };
    let indices = stated("indices")?;
    let attributes = primitive.get("attributes").and_then(Value::as_object);
    let Some((attributes, positions)) = attributes.and_then(|a| Some((a, a.get("POSITION")?)))
    else {
        let message = "a primitive without POSITION has no surface and is left out";
        input.warn(WarningKind::EmptyMeshes, place, 1, message);
        return Ok(None);
    };
    let targets = primitive.get("targets").and_then(Value::as_array);
    input.warn(
        WarningKind::MorphTargets,
        place,
        targets.map_or(0, Vec::len) as u64,
        "morph targets are left out: the base shape is baked",
    );
    let open = |accessor: usize, kind: Type| document.typed(accessor, &[kind]);
    let positions = index(positions)
        .ok_or_else(|| format!("POSITION is {}", short(&positions.to_string())))
        .and_then(|positions| open(positions, Type::Vec3))
        .map_err(|problem| input.invalid(place, problem))?;
    let indices = indices
        .map(|indices| open(indices, Type::Scalar))
        .transpose()
        .map_err(|problem| input.invalid(place, problem))?;
    if indices
        .as_ref()
        .is_some_and(|indices| !indices.holds_indices())
    {
        let problem = "its indices are not unsigned integers: the componentType of their accessor must be 5121, 5123 \
                       or 5125, and `normalized` not be true";
        return Err(input.invalid(place, problem));
    }
    let invalid = |problem: String| input.invalid(place, problem);
    let corners = indices
        .as_ref()
        .map_or(positions.count, |indices| indices.count);
    let mut triangles = match &indices {
        Some(indices) => triangles_of(mode, corners, |i| indices.index(i)),
        None => triangles_of(mode, corners, |i| i as u32),
    };

    let used = compacted(&mut triangles, positions.count).map_err(invalid)?;
    let mut reader = Reader { input, place };
    let mut attribute = |name: &str, kinds: &[Type], instead: &str| {
        let found = attribute(document, attributes, name, kinds, positions.count)?;
        let told = |problem| reader.broken(problem, instead);
        found.map_err(told).ok()
    };
    let normals = attribute(
        "NORMAL",
        &[Type::Vec3],
        "the mesh is shaded with its geometric normals",
    );
    let tangents = attribute(
        "TANGENT",
        &[Type::Vec4],
        "tangents are made from the mesh's UVs where a map needs them",
    );
    let mut color = attribute("COLOR_0", &[Type::Vec3, Type::Vec4], "the mesh is white");
    // Integers are always shares here; a file that does not say so has the same numbers.
    if let Some(color) = &mut color {
        color.normalized = true;
    }
    let set = |n: usize| format!("TEXCOORD_{n}");
    let mut uvs = Vec::new();
    while let Some(uv) = attribute(&set(uvs.len()), &[Type::Vec2], "textures cannot read it") {
        uvs.push(uv);
    }
    let is_set = |name: &&String| {
        let number = name.strip_prefix("TEXCOORD_").map(str::parse::<u32>);
        matches!(number, Some(Ok(_)))
    };
    // The set that ends them is told of where it is there.
    let sets = attributes.keys().filter(is_set).count();
    let beyond = sets - uvs.len() - usize::from(attributes.contains_key(&set(uvs.len())));
    let material = reader.index(primitive, "material").filter(|&material| {
        let is_there = material < document.list("materials").len();
        if !is_there {
            reader.broken(
                format!("material {material} is not in the file"),
                "the mesh is white and matt",
            );
        }
        is_there
    });
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
        source_vertices: used.unwrap_or_default(),
        material: material.map_or(NO_MATERIAL, |material| material as u32),
        origin,
        ..Mesh::default()
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

/// An attribute that is not needed, one element for each vertex; `None` without it.
///
/// # Errors
/// What is wrong with it.
fn attribute<'a>(
    document: &'a GltfDocument,
    attributes: &Map<String, Value>,
    name: &str,
    kinds: &[Type],
    vertices: usize,
) -> Option<Result<Elements<'a>, String>> {
    let value = attributes.get(name)?;
    let accessor = index(value).ok_or_else(|| short(&value.to_string()));
    let opened = accessor.and_then(|accessor| document.typed(accessor, kinds));
    let whole = opened.and_then(|elements| match elements.count == vertices {
        true => Ok(elements),
        false => Err(format!(
            "{} of them for {vertices} of POSITION",
            elements.count
        )),
    });
    Some(whole.map_err(|problem| format!("{name}: {problem}")))
}

/// The triangles of section 3.7.2.1 of the specification, in its order of corners.
fn triangles_of(mode: Mode, corners: usize, index: impl Fn(usize) -> u32) -> Vec<[u32; 3]> {
    let count = if mode == Mode::Triangles {
        corners / 3
    } else {
        corners.saturating_sub(2)
    };
    let triangle = |i: usize| match mode {
        Mode::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
        Mode::Fan => [i + 1, i + 2, 0],
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
