//! One glTF mesh for each object: lightmap coordinates differ between the users of a mesh, so the mesh is cloned.

use super::document::Document;
use super::places::index;
use super::{Reason, User};
use scene::Elements;
use serde_json::{Value, json};
use std::collections::{HashMap, HashSet};

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Which of the file's meshes keep a user that was not baked, and which user takes the original's place.
pub struct MeshPlan {
    stays: HashSet<usize>,
    first: HashMap<usize, User>,
}

impl MeshPlan {
    /// The plan for the baked users, in order.
    pub fn of(document: &Document, baked: impl Iterator<Item = User>) -> Result<MeshPlan, Reason> {
        let mut plan = MeshPlan {
            stays: HashSet::new(),
            first: HashMap::new(),
        };
        let mut seen: HashMap<usize, HashSet<Option<usize>>> = HashMap::new();
        for user in baked {
            plan.first
                .entry(plan.mesh_of(document, user.0)?)
                .or_insert(user);
            seen.entry(user.0).or_default().insert(user.1);
        }
        let nodes = document
            .json
            .get("nodes")
            .and_then(Value::as_array)
            .map_or(&[][..], Vec::as_slice);
        for (n, node) in nodes.iter().enumerate() {
            let Some(mesh) = index(node, "mesh") else {
                continue;
            };
            let all = match seen.get(&n) {
                None => false,
                Some(copies) if copies.contains(&None) => true,
                Some(copies) => copies.len() == instancing(document, node)?[0].1.count,
            };
            if !all {
                plan.stays.insert(mesh);
            }
        }
        Ok(plan)
    }

    /// True where the file's mesh must remain as it is for somebody.
    pub fn stays(&self, mesh: usize) -> bool {
        self.stays.contains(&mesh) || !self.first.contains_key(&mesh)
    }

    /// The mesh that a node names in the file.
    pub fn mesh_of(&self, document: &Document, node: usize) -> Result<usize, Reason> {
        index(document.get("nodes", node)?, "mesh")
            .ok_or_else(|| format!("node {node} has no mesh"))
    }

    /// Puts the mesh of `user` in the original's place, or appends it, and returns where it stands.
    pub fn place(
        &self,
        document: &mut Document,
        original: usize,
        user: User,
        mesh: Value,
    ) -> Result<usize, Reason> {
        if !self.stays(original) && self.first.get(&original) == Some(&user) {
            document.list("meshes")?[original] = mesh;
            return Ok(original);
        }
        document.push("meshes", mesh)
    }
}

/// Gives every baked user its mesh. A node with `EXT_mesh_gpu_instancing` gets a child node for each copy instead.
pub fn assign(
    document: &mut Document,
    plan: &MeshPlan,
    placed: &[(User, usize)],
) -> Result<(), Reason> {
    let mut instanced: Vec<(usize, HashMap<usize, usize>)> = Vec::new();
    let mut at: HashMap<usize, usize> = HashMap::new();
    for &((node, copy), mesh) in placed {
        let Some(copy) = copy else {
            document
                .entry("nodes", node)?
                .insert("mesh".into(), mesh.into());
            continue;
        };
        let slot = *at.entry(node).or_insert_with(|| {
            instanced.push((node, HashMap::new()));
            instanced.len() - 1
        });
        instanced[slot].1.insert(copy, mesh);
    }
    for (node, meshes) in instanced {
        expand(document, node, plan.mesh_of(document, node)?, &meshes)?;
    }
    Ok(())
}

/// Turns the copies of one node into children. A copy that was not baked keeps the original mesh.
fn expand(
    document: &mut Document,
    node: usize,
    original: usize,
    meshes: &HashMap<usize, usize>,
) -> Result<(), Reason> {
    let parent = document.get("nodes", node)?.clone();
    let attributes = instancing(document, &parent)?;
    let copies = attributes[0].1.count;
    let mut children = Vec::with_capacity(copies);
    for copy in 0..copies {
        let mut child = json!({ "mesh": meshes.get(&copy).copied().unwrap_or(original) });
        if let Some(name) = parent.get("name").and_then(Value::as_str) {
            child["name"] = format!("{name} {copy}").into();
        }
        for (key, elements) in &attributes {
            let value = match elements.lanes() {
                Some(3) => elements.numbers::<3>(copy).map(Value::from),
                _ => elements.numbers::<4>(copy).map(Value::from),
            };
            child[*key] = value.ok_or("instancing attributes differ in length")?;
        }
        for key in ["skin", "weights"] {
            if let Some(value) = parent.get(key) {
                child[key] = value.clone();
            }
        }
        children.push(Value::from(document.push("nodes", child)?));
    }
    let parent = document.entry("nodes", node)?;
    for key in ["mesh", "skin", "weights"] {
        parent.shift_remove(key);
    }
    let own = parent.entry("children").or_insert_with(|| json!([]));
    own.as_array_mut()
        .ok_or("a node's children are not an array")?
        .extend(children);
    if let Some(extensions) = parent.get_mut("extensions").and_then(Value::as_object_mut) {
        extensions.shift_remove(INSTANCING);
        if extensions.is_empty() {
            parent.shift_remove("extensions");
        }
    }
    Ok(())
}

/// The attributes that place the copies of an instanced node, at least one, by the node property they become.
fn instancing<'a>(
    document: &Document<'a>,
    node: &Value,
) -> Result<Vec<(&'static str, Elements<'a>)>, Reason> {
    let attributes = node
        .get("extensions")
        .and_then(|e| e.get(INSTANCING)?.get("attributes"));
    let mut opened = Vec::new();
    for (semantic, key) in [
        ("TRANSLATION", "translation"),
        ("ROTATION", "rotation"),
        ("SCALE", "scale"),
    ] {
        if let Some(accessor) = attributes.and_then(|a| index(a, semantic)) {
            opened.push((key, document.original(accessor)?));
        }
    }
    match opened.is_empty() {
        true => Err(format!("a node places no copies by {INSTANCING}")),
        false => Ok(opened),
    }
}
