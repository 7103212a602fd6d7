//! The node hierarchy: which mesh stands where.

use super::accessor::{index, shown, stated};
use super::elements::Type;
use super::lights;
use super::names::own_name;
use super::reader::Reader;
use super::said::Said;
use crate::GltfDocument;
use crate::input::{Input, short};
use crate::validate::{Parts, affine};
use crate::{Error, Instance, Light, WarningKind};
use glam::{DAffine3, DQuat, DVec3, DVec4};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A glTF mesh placed in the world.
pub(super) struct Placement {
    pub mesh: usize,
    node: usize,
    copy: Option<u32>,
    transform: DAffine3,
    said: Said,
}

/// All visible placements and lights of the default scene (`scene`, else the first, else every root node), parents
/// before children.
pub(super) fn placements(
    input: &mut Input,
    document: &GltfDocument,
) -> Result<(Vec<Placement>, Vec<Light>), Error> {
    let (nodes, meshes) = (document.list("nodes"), document.list("meshes"));
    let (mut out, mut shining) = (Vec::new(), Vec::new());
    let mut seen = vec![false; nodes.len()];
    // A stack of our own: a chain of nodes may be deeper than the call stack.
    let mut open: Vec<(usize, DAffine3, Said)> = roots(input, document)?
        .into_iter()
        .rev()
        .map(|n| (n, DAffine3::IDENTITY, Said::default()))
        .collect();
    let mut of_meshes: HashMap<usize, Said> = HashMap::new();
    while let Some((n, parent, above)) = open.pop() {
        let place = format!("node {n}");
        let (json, seen) = (&nodes[n], &mut seen[n]);
        let mut reader = Reader {
            input,
            place: &place,
        };
        let extensions = reader.object(json, "extensions");
        if is_hidden(&mut reader, extensions) {
            continue;
        }
        if std::mem::replace(seen, true) {
            let problem = "it is reached twice, but glTF nodes form trees; name it in the `children` of one node, or \
                           in the scene's `nodes`, once";
            return Err(input.invalid(place, problem));
        }
        reader.text(json, "name");
        let needed = || -> Result<_, String> {
            let children = numbered(json, "children", "child", nodes.len())?;
            Ok((local(json)?, children, stated(json, "mesh")?))
        };
        let needed = needed().map_err(|problem| reader.input.invalid(place.as_str(), problem));
        let (own, children, mesh) = needed?;
        let world = parent * own;
        shining.extend(lights::of(
            &mut reader,
            &document.json,
            json,
            extensions,
            &world,
        ));
        let own = said(input, &named("node", n, json), json)?;
        let children = children.into_iter().rev();
        open.extend(children.map(|child| (child, world, own.or(above))));
        let Some(mesh) = mesh else {
            continue;
        };
        let Some(of) = meshes.get(mesh) else {
            let problem = format!(
                "its mesh is {mesh}, but there are {}, numbered from 0; correct that number",
                meshes.len()
            );
            return Err(input.invalid(place, problem));
        };
        let skin = json.get("skin").is_some();
        input.warn(
            WarningKind::Skins,
            place.as_str(),
            skin.into(),
            "the skin is left out: the mesh is baked where its node stands",
        );
        let of_mesh = match of_meshes.get(&mesh) {
            Some(&said) => said,
            None => *of_meshes
                .entry(mesh)
                .or_insert(said(input, &named("mesh", mesh, of), of)?),
        };
        let said = own.or(of_mesh).or(above);
        match copies(document, json).map_err(|problem| input.invalid(place, problem))? {
            Some(copies) => out.extend(copies.into_iter().enumerate().map(|(i, copy)| Placement {
                mesh,
                node: n,
                copy: Some(i as u32),
                transform: world * copy,
                said,
            })),
            None => out.push(Placement {
                mesh,
                node: n,
                copy: None,
                transform: world,
                said,
            }),
        }
    }
    Ok((out, shining))
}

/// One instance for each placement of each of its mesh's loaded primitives.
pub(super) fn instances(
    document: &GltfDocument,
    placements: Vec<Placement>,
    primitives: &mut BTreeMap<usize, Vec<u32>>,
    parts: &mut Parts,
) {
    for placement in placements {
        let name = own_name(&document.list("nodes")[placement.node]);
        for &mesh in primitives.get(&placement.mesh).into_iter().flatten() {
            let of = &parts.meshes[mesh as usize].name;
            let name = match name {
                Some(name) => format!("{name} / {of}"),
                None => format!("node {} / {of}", placement.node),
            };
            let (node, copy) = (placement.node as u32, placement.copy);
            parts.instances.push(Instance {
                node,
                copy,
                casts: placement.said.casts.unwrap_or(true),
                keeps_buried: placement.said.keeps_buried,
                density: placement.said.density,
                bakes: placement.said.bakes.unwrap_or(true),
                ..Instance::new(name, mesh, placement.transform)
            });
        }
    }
}

/// The nodes that the scene names, which may be none; without a scene all that are nobody's child.
fn roots(input: &mut Input, document: &GltfDocument) -> Result<Vec<usize>, Error> {
    let (nodes, scenes) = (document.list("nodes"), document.list("scenes"));
    let mut reader = Reader {
        input,
        place: "the file",
    };
    let named = reader.index(&document.json, "scene");
    let scene = named.unwrap_or(0);
    let found = match scenes.get(scene) {
        Some(found) => numbered(found, "nodes", "node", nodes.len())
            .map_err(|problem| format!("scene {scene}: {problem}")),
        None if named.is_some() => Err(format!(
            "scene {scene} does not exist, of {}; take the line `\"scene\": {scene}` out of the file, and the \
                first one is baked",
            scenes.len()
        )),
        None => {
            let children = nodes
                .iter()
                .filter_map(|node| node.get("children")?.as_array());
            let children: BTreeSet<usize> = children.flatten().filter_map(index).collect();
            Ok((0..nodes.len()).filter(|n| !children.contains(n)).collect())
        }
    };
    let found: Vec<usize> = found.map_err(|problem| input.invalid("JSON", problem))?;
    let others = scenes.iter().enumerate().filter(|(number, other)| {
        let nodes = other.get("nodes").and_then(Value::as_array);
        let mut nodes = nodes.into_iter().flatten().filter_map(index);
        *number != scene && nodes.any(|node| !found.contains(&node))
    });
    let others = others.count() as u64;
    input.warn(
        WarningKind::OtherScenes,
        format!("scene {scene}"),
        others,
        "this scene of the file is baked; what stands in its other scenes alone is left out, and files of their own \
         bring it in",
    );
    Ok(found)
}

/// The numbers under a key, each below `count`.
///
/// # Errors
/// A sentence. `what`: what they are.
fn numbered(json: &Value, key: &str, what: &str, count: usize) -> Result<Vec<usize>, String> {
    let list = json.get(key).filter(|list| !list.is_null());
    if list.is_some_and(|list| !list.is_array()) {
        return Err(format!(
            "its {key} are {}, and must be a list of the numbers of nodes",
            shown(json, key)
        ));
    }
    let number = |value: &Value| {
        let number = index(value).filter(|&n| n < count);
        number.ok_or_else(|| {
            let value = short(&value.to_string());
            format!(
                "it names the {what} {value}, but there are {count} nodes, numbered from 0; correct its {key}"
            )
        })
    };
    let list = list.and_then(Value::as_array);
    list.into_iter().flatten().map(number).collect()
}

/// A node or a mesh by its name, else by its number.
fn named(what: &str, number: usize, json: &Value) -> String {
    match own_name(json) {
        Some(name) => format!("{what} `{}`", short(name)),
        None => format!("{what} {number}"),
    }
}

/// What `extras.ambake` of a node or a mesh says; names in it that mean nothing are told of.
fn said(input: &mut Input, place: &str, holder: &Value) -> Result<Said, Error> {
    let (said, unknown) = Said::of(holder).map_err(|problem| input.invalid(place, problem))?;
    if !unknown.is_empty() {
        input.warn(
            WarningKind::UnknownExtras,
            place,
            unknown.len() as u64,
            format!(
                "extras.ambake says `{}`, which means nothing; there are bake, buried, cast and density",
                unknown.join("`, `")
            ),
        );
    }
    Ok(said)
}

/// `KHR_node_visibility`: the node and all below it are absent.
fn is_hidden(reader: &mut Reader, extensions: &Value) -> bool {
    let visibility = reader.object(extensions, "KHR_node_visibility");
    reader.read(visibility, "visible", Value::as_bool) == Some(false)
}

/// A node's own transform, in f64.
fn local(node: &Value) -> Result<DAffine3, String> {
    if let Some(m) = numbers::<16>(node, "matrix")? {
        let columns = [0, 4, 8, 12].map(|i| [m[i], m[i + 1], m[i + 2], m[i + 3]]);
        let problem = || {
            let row = columns.map(|column| column[3].to_string());
            format!(
                "the last row of its matrix, its numbers 4, 8, 12 and 16, is {}, and must be 0 0 0 1: a node turns, \
                 scales, shears and moves, and has no perspective",
                row.join(" ")
            )
        };
        return affine(columns).ok_or_else(problem);
    }
    let vector = |key: &str, or: [f64; 3]| -> Result<DVec3, String> {
        Ok(numbers(node, key)?.unwrap_or(or).into())
    };
    placed(
        vector("translation", [0.0; 3])?,
        numbers(node, "rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]),
        vector("scale", [1.0; 3])?,
    )
}

/// A list of numbers as the text has them: 32 bits would round the places of what stands far away.
fn numbers<const N: usize>(node: &Value, key: &str) -> Result<Option<[f64; N]>, String> {
    let numbers = |list: &Value| {
        let numbers: Option<Vec<f64>> = list.as_array()?.iter().map(Value::as_f64).collect();
        numbers?.try_into().ok()
    };
    let list = node.get(key).filter(|list| !list.is_null());
    let other = || format!("its {key} is {}, and must be {N} numbers", shown(node, key));
    list.map(|list| numbers(list).ok_or_else(other)).transpose()
}

/// Translation times rotation times scale. Writers round quaternions, so it is brought to unit length.
fn placed(translation: DVec3, rotation: [f64; 4], scale: DVec3) -> Result<DAffine3, String> {
    let unit = DVec4::from_array(rotation).try_normalize();
    let unit = unit.ok_or(
        "its rotation is a quaternion without length; write 0, 0, 0, 1 in its place, or turn it anew in your editor",
    )?;
    Ok(DAffine3::from_scale_rotation_translation(
        scale,
        DQuat::from_vec4(unit),
        translation,
    ))
}

/// The transforms of `EXT_mesh_gpu_instancing` relative to the node; `None` without the extension.
fn copies(document: &GltfDocument, node: &Value) -> Result<Option<Vec<DAffine3>>, String> {
    let Some(extension) = node.pointer("/extensions/EXT_mesh_gpu_instancing") else {
        return Ok(None);
    };
    let attributes = extension.get("attributes").unwrap_or(&Value::Null);
    let attribute = |name: &str, kind: Type| {
        let accessor =
            stated(attributes, name).map_err(|problem| format!("instancing {problem}"))?;
        accessor
            .map(|accessor| document.typed(accessor, &[kind]))
            .transpose()
    };
    let translation = attribute("TRANSLATION", Type::Vec3)?;
    let rotation = attribute("ROTATION", Type::Vec4)?;
    let scale = attribute("SCALE", Type::Vec3)?;
    let counts: Vec<usize> = [&translation, &rotation, &scale]
        .into_iter()
        .flatten()
        .map(|e| e.count)
        .collect();
    let Some(&count) = counts.first() else {
        return Err(
            "its EXT_mesh_gpu_instancing has neither TRANSLATION, ROTATION nor SCALE, and must have one of them; \
             without the extension the mesh is placed once"
                .into(),
        );
    };
    if counts.iter().any(|&other| other != count) {
        return Err(format!(
            "its instancing has attributes of different counts {counts:?}; the file is corrupt"
        ));
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let copy = |i: usize| {
        placed(
            translation
                .as_ref()
                .map_or(DVec3::ZERO, |t| vector(t.floats(i))),
            rotation
                .as_ref()
                .map_or([0.0, 0.0, 0.0, 1.0], |r| r.floats(i).map(f64::from)),
            scale.as_ref().map_or(DVec3::ONE, |s| vector(s.floats(i))),
        )
        .map_err(|problem| format!("instancing copy {i}: {problem}"))
    };
    (0..count).map(copy).collect::<Result<_, _>>().map(Some)
}
