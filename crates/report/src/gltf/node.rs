//! One glTF mesh for each object: lightmap coordinates differ between the users of a mesh, so the mesh is cloned.

use super::accessor::{count, floats};
use super::document::{Document, index};
use super::{Reason, User};
use serde_json::{Map, Value, json};
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
                Some(copies) => copies.len() == copy_count(document, node)?,
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
    let copies = copy_count(document, &parent)?;
    let attributes = instancing(&parent)?.clone();
    let mut properties = Vec::new();
    for (semantic, key, width) in [
        ("TRANSLATION", "translation", 3),
        ("ROTATION", "rotation", 4),
        ("SCALE", "scale", 3),
    ] {
        if let Some(accessor) = attributes.get(semantic).and_then(Value::as_u64) {
            properties.push((key, width, floats(document, accessor as usize, width)?));
        }
    }
    let mut children = Vec::with_capacity(copies);
    for copy in 0..copies {
        let mut child = json!({ "mesh": meshes.get(&copy).copied().unwrap_or(original) });
        if let Some(name) = parent.get("name").and_then(Value::as_str) {
            child["name"] = format!("{name} {copy}").into();
        }
        for (key, width, values) in &properties {
            let value = values
                .get(copy * width..(copy + 1) * width)
                .ok_or("instancing attributes differ in length")?;
            child[*key] = value.into();
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

fn instancing(node: &Value) -> Result<&Map<String, Value>, Reason> {
    let attributes = node
        .get("extensions")
        .and_then(|e| e.get(INSTANCING))
        .and_then(|e| e.get("attributes"));
    attributes
        .and_then(Value::as_object)
        .ok_or_else(|| format!("a node has no {INSTANCING}"))
}

fn copy_count(document: &Document, node: &Value) -> Result<usize, Reason> {
    let any = instancing(node)?.values().next().and_then(Value::as_u64);
    count(
        document,
        any.ok_or("instancing has no attributes")? as usize,
    )
}
