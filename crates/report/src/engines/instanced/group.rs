//! Which nodes are copies of one another.

use super::super::container::list;
use scene::{Elements, GltfDocument};
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Nodes of one list that differ in where they stand and in their rectangles alone: two or more.
pub struct Group {
    /// JSON pointer of the list that names them: a scene's nodes or a node's children.
    pub list: String,
    /// In the order of the list.
    pub copies: Vec<Copy>,
}

/// One of them.
pub struct Copy {
    pub node: usize,
    /// Scale and offset from the first copy's coordinates to its own, for each primitive.
    pub rects: Vec<[f32; 4]>,
}

/// What a node may hold to become a copy.
const PLAIN: [&str; 5] = ["mesh", "name", "translation", "rotation", "scale"];

/// Farther apart than this, coordinates are not the same: a tenth of a texel of a page of 8192.
const NEAR: f64 = 1e-5;

/// The groups of a document, in the order of its lists; `None` where it is broken.
pub fn groups(document: &GltfDocument) -> Option<Vec<Group>> {
    let json = &document.json;
    let named = |key: &str, inner: &str| {
        let lists = list(json, key).iter().enumerate();
        let of =
            |(i, item): (usize, &Value)| (format!("/{key}/{i}/{inner}"), indices(&item[inner]));
        lists.map(of).collect::<Vec<_>>()
    };
    let lists = [named("scenes", "nodes"), named("nodes", "children")].concat();
    let mut times: HashMap<usize, u32> = HashMap::new();
    for &node in lists.iter().flat_map(|(_, members)| members) {
        *times.entry(node).or_default() += 1;
    }
    let busy = busy(json);
    let mut groups = Vec::new();
    for (list_at, members) in &lists {
        let mut alike: BTreeMap<String, usize> = BTreeMap::new();
        let mut own: Vec<Group> = Vec::new();
        for &node in members {
            let free = times[&node] == 1 && !busy.contains(&node);
            let Some(key) = free.then(|| key(json, node)).flatten() else {
                continue;
            };
            let slot = *alike.entry(key).or_insert(own.len());
            if slot == own.len() {
                own.push(Group {
                    list: list_at.clone(),
                    copies: Vec::new(),
                });
            }
            let first = own[slot].copies.first().map_or(node, |first| first.node);
            if let Some(rects) = rects(document, first, node) {
                own[slot].copies.push(Copy { node, rects });
            }
        }
        groups.extend(own.into_iter().filter(|group| group.copies.len() > 1));
    }
    Some(groups)
}

fn indices(value: &Value) -> Vec<usize> {
    let numbers = value.as_array().into_iter().flatten();
    numbers.filter_map(|n| Some(n.as_u64()? as usize)).collect()
}

/// Nodes that animations and skins name.
fn busy(json: &Value) -> HashSet<usize> {
    let skins = list(json, "skins").iter();
    let joints = skins.flat_map(|skin| {
        [
            indices(&skin["joints"]),
            indices(&json!([skin["skeleton"]])),
        ]
        .concat()
    });
    let channels = list(json, "animations")
        .iter()
        .flat_map(|animation| list(animation, "channels"));
    let moved = channels.filter_map(|channel| Some(channel["target"]["node"].as_u64()? as usize));
    joints.chain(moved).collect()
}

/// What copies have in common: their mesh without its name and the lightmap coordinates; `None` for a node that can be
/// no copy.
fn key(json: &Value, node: usize) -> Option<String> {
    let node = list(json, "nodes").get(node)?.as_object()?;
    if !node.keys().all(|key| PLAIN.contains(&key.as_str())) {
        return None;
    }
    // Readers turn the faces of a mirrored node, but not those of a mirrored copy.
    let scale = node.get("scale").and_then(Value::as_array);
    let numbers = scale.into_iter().flatten().filter_map(Value::as_f64);
    let size: f64 = numbers.product();
    if size < 0.0 {
        return None;
    }
    let mesh = node.get("mesh")?.as_u64()? as usize;
    let mut mesh = list(json, "meshes").get(mesh)?.clone();
    mesh.as_object_mut()?.shift_remove("name");
    for primitive in mesh["primitives"].as_array_mut()? {
        let attributes = primitive["attributes"].as_object_mut()?;
        let lightmap = attributes.shift_remove("TEXCOORD_1")?;
        if attributes.get("TEXCOORD_0") == Some(&lightmap) {
            attributes.insert("TEXCOORD_0".into(), "the same".into());
        }
    }
    Some(mesh.to_string())
}

/// The rectangles that lead from the coordinates of one node to those of another; `None` where some are not so.
fn rects(document: &GltfDocument, first: usize, node: usize) -> Option<Vec<[f32; 4]>> {
    let from = lightmaps(document, first)?;
    let to = lightmaps(document, node)?;
    from.iter()
        .zip(&to)
        .map(|(from, to)| rect(from, to))
        .collect()
}

/// The lightmap coordinates of each primitive of a node.
fn lightmaps(document: &GltfDocument, node: usize) -> Option<Vec<Vec<[f64; 2]>>> {
    let json = &document.json;
    let mesh = list(json, "nodes").get(node)?["mesh"].as_u64()? as usize;
    let of = |primitive: &Value| {
        let accessor = primitive["attributes"]["TEXCOORD_1"].as_u64()? as usize;
        let elements: Elements<'_> = document.accessor(accessor).ok()?;
        (0..elements.count)
            .map(|i| elements.numbers::<2>(i))
            .collect()
    };
    list(list(json, "meshes").get(mesh)?, "primitives")
        .iter()
        .map(of)
        .collect()
}

/// Scale and offset from the points `from` to `to`; `None` where they are not alike.
fn rect(from: &[[f64; 2]], to: &[[f64; 2]]) -> Option<[f32; 4]> {
    let bounds = |points: &[[f64; 2]], k: usize| {
        let values = points.iter().map(|point| point[k]);
        values.fold([f64::MAX, f64::MIN], |[low, high], v| {
            [low.min(v), high.max(v)]
        })
    };
    let mut rect = [1.0, 1.0, 0.0, 0.0];
    for k in 0..2 {
        let ([low, high], [to_low, to_high]) = (bounds(from, k), bounds(to, k));
        if high > low {
            rect[k] = (to_high - to_low) / (high - low);
        }
        rect[k + 2] = to_low - low * rect[k];
    }
    let rect = rect.map(|number| number as f32);
    let lands = |(from, to): (&[f64; 2], &[f64; 2])| {
        (0..2)
            .all(|k| (from[k] * f64::from(rect[k]) + f64::from(rect[k + 2]) - to[k]).abs() <= NEAR)
    };
    (from.len() == to.len() && from.iter().zip(to).all(lands)).then_some(rect)
}
