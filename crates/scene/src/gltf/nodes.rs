//! The node hierarchy: which mesh stands where.

use super::accessor::{Data, number};
use super::lights;
use super::said::Said;
use crate::source::{Input, short};
use crate::validate::{Parts, affine};
use crate::{Error, Instance, Light, WarningKind};
use glam::{DAffine3, DQuat, DVec3, DVec4};
use gltf::json::accessor::Type;
use gltf::json::scene::Node;
use gltf::json::{Index, Root};
use serde_json::Value;
use std::collections::BTreeMap;

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
    data: &Data,
) -> Result<(Vec<Placement>, Vec<Light>), Error> {
    let root = data.root;
    let (mut out, mut shining) = (Vec::new(), Vec::new());
    let mut seen = vec![false; root.nodes.len()];
    // A stack of our own: a chain of nodes may be deeper than the call stack.
    let mut open: Vec<(usize, DAffine3, Said)> = roots(data)
        .map_err(|problem| input.invalid("JSON", problem))?
        .into_iter()
        .rev()
        .map(|n| (n, DAffine3::IDENTITY, Said::default()))
        .collect();
    let meshes = data.document.json["meshes"]
        .as_array()
        .into_iter()
        .flatten();
    let of_meshes = meshes
        .enumerate()
        .map(|(n, mesh)| said(input, &named("mesh", n, mesh), mesh));
    let of_meshes: Vec<Said> = of_meshes.collect::<Result<_, _>>()?;
    while let Some((n, parent, above)) = open.pop() {
        let (Some(node), Some(seen)) = (root.nodes.get(n), seen.get_mut(n)) else {
            continue;
        };
        if is_hidden(node) {
            continue;
        }
        let place = format!("node {n}");
        if std::mem::replace(seen, true) {
            let problem = "it is reached twice, but glTF nodes form trees; export the file again";
            return Err(input.invalid(place, problem));
        }
        let json = &data.document.json["nodes"][n];
        let world =
            parent * local(json).map_err(|problem| input.invalid(place.as_str(), problem))?;
        let children = node.children.iter().flatten().rev();
        let own = said(input, &named("node", n, json), json)?;
        open.extend(children.map(|child| (child.value(), world, own.or(above))));
        shining.extend(lights::of(input, &data.document.json, node, &world));
        let Some(mesh) = node.mesh.map(|mesh| mesh.value()) else {
            continue;
        };
        let skin = json.get("skin").is_some();
        input.warn(
            WarningKind::Skins,
            place.as_str(),
            skin.into(),
            "the skin is left out: the mesh is baked where its node stands",
        );
        let of_mesh = of_meshes.get(mesh).copied().unwrap_or_default();
        let said = own.or(of_mesh).or(above);
        match copies(data, node).map_err(|problem| input.invalid(place, problem))? {
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
    root: &Root,
    placements: Vec<Placement>,
    primitives: &mut BTreeMap<usize, Vec<u32>>,
    parts: &mut Parts,
) {
    for placement in placements {
        let name = root
            .nodes
            .get(placement.node)
            .and_then(|node| node.name.as_deref());
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
fn roots(data: &Data) -> Result<Vec<usize>, String> {
    let (json, count) = (&data.document.json, data.root.nodes.len());
    let scenes = json.get("scenes").and_then(Value::as_array);
    let scene = number(json, "scene").unwrap_or(0);
    let found = scenes.and_then(|scenes| scenes.get(scene));
    if let Some(found) = found {
        let nodes = found.get("nodes").and_then(Value::as_array);
        let number = |node: &Value| {
            let number = node.as_u64().and_then(|n| usize::try_from(n).ok());
            number.filter(|&n| n < count).ok_or_else(|| {
                format!("scene {scene} names the node {node} of {count}; export the file again")
            })
        };
        return nodes.into_iter().flatten().map(number).collect();
    }
    if json.get("scene").is_some() {
        return Err(format!(
            "scene {scene} does not exist; export the file again"
        ));
    }
    let mut is_child = vec![false; count];
    for child in data
        .root
        .nodes
        .iter()
        .flat_map(|node| node.children.iter().flatten())
    {
        if let Some(slot) = is_child.get_mut(child.value()) {
            *slot = true;
        }
    }
    Ok((0..count).filter(|&n| !is_child[n]).collect())
}

/// A node or a mesh by its name, else by its number.
fn named(what: &str, number: usize, json: &Value) -> String {
    match json.get("name").and_then(Value::as_str) {
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
fn is_hidden(node: &Node) -> bool {
    let others = node.extensions.as_ref().map(|e| &e.others);
    let visibility = others.and_then(|others| others.get("KHR_node_visibility"));
    visibility.and_then(|v| v.get("visible")) == Some(&Value::Bool(false))
}

/// A node's own transform, in f64.
fn local(node: &Value) -> Result<DAffine3, String> {
    if let Some(m) = numbers::<16>(node, "matrix") {
        let columns = [0, 4, 8, 12].map(|i| [m[i], m[i + 1], m[i + 2], m[i + 3]]);
        let problem =
            "its matrix is not affine (the last row is not 0 0 0 1); export the file again";
        return affine(columns).ok_or_else(|| problem.into());
    }
    let vector = |key: &str, or: DVec3| numbers(node, key).map_or(or, DVec3::from_array);
    placed(
        vector("translation", DVec3::ZERO),
        numbers(node, "rotation").unwrap_or([0.0, 0.0, 0.0, 1.0]),
        vector("scale", DVec3::ONE),
    )
}

/// A list of numbers as the text has them: 32 bits would round the places of what stands far away.
fn numbers<const N: usize>(node: &Value, key: &str) -> Option<[f64; N]> {
    let list = node.get(key)?.as_array()?;
    let numbers: Option<Vec<f64>> = list.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}

/// Translation times rotation times scale. Writers round quaternions, so it is brought to unit length.
fn placed(translation: DVec3, rotation: [f64; 4], scale: DVec3) -> Result<DAffine3, String> {
    let unit = DVec4::from_array(rotation).try_normalize();
    let unit = unit.ok_or("its rotation is a quaternion without length; export the file again")?;
    Ok(DAffine3::from_scale_rotation_translation(
        scale,
        DQuat::from_vec4(unit),
        translation,
    ))
}

/// The transforms of `EXT_mesh_gpu_instancing` relative to the node; `None` without the extension.
fn copies(data: &Data, node: &Node) -> Result<Option<Vec<DAffine3>>, String> {
    let extension = node
        .extensions
        .as_ref()
        .and_then(|e| e.others.get("EXT_mesh_gpu_instancing"));
    let Some(extension) = extension else {
        return Ok(None);
    };
    let attribute = |name: &str, kind: Type| {
        let Some(value) = extension.get("attributes").and_then(|a| a.get(name)) else {
            return Ok(None);
        };
        let index = value.as_u64().and_then(|index| u32::try_from(index).ok());
        let index = index
            .ok_or_else(|| format!("instancing {name} is no accessor; export the file again"))?;
        data.open(Index::new(index), &[kind]).map(Some)
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
            "its instancing has neither TRANSLATION, ROTATION nor SCALE; export the file again"
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
