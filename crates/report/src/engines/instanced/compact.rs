//! Takes nodes out of a document, and the meshes, accessors and bytes that only they used.

use crate::gltf::places::{Each, each_accessor, each_view, items};
use serde_json::Value;
use std::collections::HashSet;

/// Meshes, accessors and buffer views that something names.
pub type Used = [HashSet<usize>; 3];

/// What is used of a document.
pub fn used(json: &mut Value) -> Used {
    [each_mesh, each_accessor, each_view].map(|each| named(json, each))
}

/// Drops nodes, and what was used `before` and is no longer; returns the bytes that are left.
pub fn without(
    json: &mut Value,
    bin: &[u8],
    nodes: HashSet<usize>,
    before: Used,
) -> Option<Vec<u8>> {
    drop(json, "nodes", &nodes, each_node)?;
    let [meshes, accessors, views] = before;
    drop_unused(json, "meshes", &meshes, each_mesh)?;
    drop_unused(json, "accessors", &accessors, each_accessor)?;
    drop_unused(json, "bufferViews", &views, each_view)?;
    let mut left = Vec::with_capacity(bin.len());
    for view in json["bufferViews"].as_array_mut()? {
        let number = |key: &str| view[key].as_u64().unwrap_or(0) as usize;
        let (at, length) = (number("byteOffset"), number("byteLength"));
        left.resize(left.len().next_multiple_of(4), 0);
        view["byteOffset"] = left.len().into();
        left.extend(bin.get(at..at.checked_add(length)?)?);
    }
    left.resize(left.len().next_multiple_of(4), 0);
    Some(left)
}

fn named(json: &mut Value, each: Each) -> HashSet<usize> {
    let mut found = HashSet::new();
    each(json, &mut |index| {
        found.extend(index.as_u64().map(|i| i as usize))
    });
    found
}

fn drop_unused(json: &mut Value, key: &str, before: &HashSet<usize>, each: Each) -> Option<()> {
    let after = named(json, each);
    drop(json, key, &(before - &after), each)
}

/// Drops items of a list, and gives the rest their new numbers wherever they are named.
fn drop(json: &mut Value, key: &str, gone: &HashSet<usize>, each: Each) -> Option<()> {
    let items = json.get_mut(key)?.as_array_mut()?;
    let mut numbers = Vec::with_capacity(items.len());
    let mut next = 0;
    for old in 0..items.len() {
        numbers.push(next);
        next += usize::from(!gone.contains(&old));
    }
    let mut old = 0..;
    items.retain(|_| old.next().is_some_and(|old| !gone.contains(&old)));
    each(json, &mut |index| {
        let new = index.as_u64().and_then(|i| numbers.get(i as usize));
        if let Some(&new) = new {
            *index = new.into();
        }
    });
    Some(())
}

fn each_node(json: &mut Value, at: &mut dyn FnMut(&mut Value)) {
    items(json, "scenes").for_each(|scene| items(scene, "nodes").for_each(&mut *at));
    items(json, "nodes").for_each(|node| items(node, "children").for_each(&mut *at));
    for skin in items(json, "skins") {
        items(skin, "joints").for_each(&mut *at);
        skin.get_mut("skeleton").into_iter().for_each(&mut *at);
    }
    for animation in items(json, "animations") {
        let channels = items(animation, "channels");
        channels
            .filter_map(|channel| channel.pointer_mut("/target/node"))
            .for_each(&mut *at);
    }
}

fn each_mesh(json: &mut Value, at: &mut dyn FnMut(&mut Value)) {
    items(json, "nodes")
        .filter_map(|node| node.get_mut("mesh"))
        .for_each(at);
}
