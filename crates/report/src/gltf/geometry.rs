//! The vertices of a primitive in the order of the layout: seams split vertices, dropped triangles are left out.

use super::Reason;
use super::accessor::{count, gather};
use super::document::{Document, index};
use super::material::{self, Uses};
use atlas::{MeshLayout, Placement};
use scene::Mesh;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// One primitive's new attributes, shared by all its objects and pages.
pub struct Geometry {
    attributes: Map<String, Value>,
    targets: Option<Value>,
    /// Where the file's own `TEXCOORD_1` went.
    moved: Option<u64>,
    /// One for each page the triangles lie on.
    pub parts: Vec<Part>,
}

/// The triangles of a primitive that lie on one page.
pub struct Part {
    /// Page relative to the placement's.
    pub page: u16,
    indices: Indices,
}

enum Indices {
    /// The primitive's own, or none.
    Kept,
    Accessor(usize),
}

impl Geometry {
    /// The geometry of `primitive`, which `mesh` was loaded from. `laid_out`: its vertices are the layout's already.
    pub fn build(
        document: &mut Document,
        primitive: &Value,
        mesh: &Mesh,
        layout: &MeshLayout,
        laid_out: bool,
    ) -> Result<Geometry, Reason> {
        let name = &mesh.name;
        assert_eq!(
            layout.triangles.len(),
            mesh.triangles.len(),
            "the layout of {name} has every triangle"
        );
        let mut attributes = object(primitive, "attributes")?.clone();
        let vertices = mesh.positions.len();
        let stays = laid_out
            || layout.source_vertices.len() == vertices
                && layout
                    .source_vertices
                    .iter()
                    .enumerate()
                    .all(|(i, &v)| i == v as usize);
        let mut targets = primitive.get("targets").cloned();
        if !stays {
            gather_all(
                document,
                &mut attributes,
                vertices,
                &layout.source_vertices,
                name,
            )?;
            for target in targets
                .as_mut()
                .and_then(Value::as_array_mut)
                .into_iter()
                .flatten()
            {
                let target = target
                    .as_object_mut()
                    .ok_or("a morph target is not an object")?;
                gather_all(document, target, vertices, &layout.source_vertices, name)?;
            }
        }
        let moved = move_texcoord_1(&mut attributes);

        let list = primitive.get("mode").and_then(Value::as_u64).unwrap_or(4) == 4;
        let same = laid_out
            || list && mesh.source_triangles.is_empty() && layout.triangles == mesh.triangles;
        let mut by_page: BTreeMap<u16, Vec<[u32; 3]>> = BTreeMap::new();
        if layout.triangle_pages.iter().all(|&page| page == 0) {
            by_page.insert(0, Vec::new());
        } else {
            for (&page, &triangle) in layout.triangle_pages.iter().zip(&layout.triangles) {
                by_page.entry(page).or_default().push(triangle);
            }
        }
        let one = by_page.len() == 1;
        let mut parts = Vec::new();
        for (page, triangles) in by_page {
            let indices = match (one, same) {
                (true, true) => Indices::Kept,
                (true, false) => {
                    Indices::Accessor(document.push_indices(&layout.triangles, layout.uvs.len())?)
                }
                (false, _) => {
                    Indices::Accessor(document.push_indices(&triangles, layout.uvs.len())?)
                }
            };
            parts.push(Part { page, indices });
        }
        Ok(Geometry {
            attributes,
            targets,
            moved,
            parts,
        })
    }

    /// The primitive of one part with the accessor `lightmap` as its `TEXCOORD_1`. `material` gives the clone of a
    /// material that shows the part's page.
    pub fn primitive(
        &self,
        original: &Value,
        part: &Part,
        lightmap: usize,
        mut material: impl FnMut(Uses) -> Result<usize, Reason>,
    ) -> Result<Value, Reason> {
        let mut primitive = original
            .as_object()
            .ok_or("a primitive is not an object")?
            .clone();
        let mut attributes = self.attributes.clone();
        attributes.insert("TEXCOORD_1".into(), lightmap.into());
        // The format wants the numbers of UV sets without a gap.
        attributes
            .entry("TEXCOORD_0")
            .or_insert_with(|| lightmap.into());
        primitive.insert("attributes".into(), Value::Object(attributes));
        if let Some(targets) = &self.targets {
            primitive.insert("targets".into(), targets.clone());
        }
        if let Indices::Accessor(indices) = part.indices {
            primitive.insert("indices".into(), indices.into());
            primitive.shift_remove("mode"); // triangles, also where the file had a strip or a fan
        }
        let uses = Uses {
            original: index(original, "material"),
            moved: self.moved,
        };
        primitive.insert("material".into(), material(uses)?.into());
        if let Some(extensions) = primitive
            .get_mut("extensions")
            .and_then(Value::as_object_mut)
        {
            // It would speak of the vertices before the split; the uncompressed fallback is what was loaded.
            extensions.shift_remove("KHR_draco_mesh_compression");
            material::each_variant(extensions, |original| {
                material(Uses {
                    original: Some(original),
                    moved: self.moved,
                })
            })?;
            if extensions.is_empty() {
                primitive.shift_remove("extensions");
            }
        }
        Ok(Value::Object(primitive))
    }
}

/// Appends the layout coordinates of one object, carried onto its page, and returns the accessor.
pub fn push_lightmap(
    document: &mut Document,
    layout: &MeshLayout,
    placement: &Placement,
) -> Result<usize, Reason> {
    let ([su, sv], [ou, ov]) = (placement.scale, placement.offset);
    let uvs: Vec<[f32; 2]> = layout
        .uvs
        .iter()
        .map(|uv| [uv.x * su + ou, uv.y * sv + ov])
        .collect();
    document.push_floats(&uvs, false)
}

/// Replaces every accessor of an attribute map by its elements in the order `vertices`.
fn gather_all(
    document: &mut Document,
    attributes: &mut Map<String, Value>,
    expected: usize,
    vertices: &[u32],
    name: &str,
) -> Result<(), Reason> {
    for (semantic, accessor) in attributes {
        let source = accessor.as_u64().ok_or("an attribute is not an index")? as usize;
        let count = count(document, source)?;
        if count != expected {
            return Err(format!(
                "{semantic} of {name} has {count} vertices, {expected} were loaded"
            ));
        }
        *accessor = gather(document, source, vertices, semantic == "POSITION")?.into();
    }
    Ok(())
}

/// Moves `TEXCOORD_1` behind the last UV set and returns its new number.
fn move_texcoord_1(attributes: &mut Map<String, Value>) -> Option<u64> {
    let old = attributes.shift_remove("TEXCOORD_1")?;
    let number = |name: &String| name.strip_prefix("TEXCOORD_")?.parse::<u64>().ok();
    let next = attributes
        .keys()
        .filter_map(number)
        .max()
        .unwrap_or(0)
        .max(1)
        + 1;
    attributes.insert(format!("TEXCOORD_{next}"), old);
    Some(next)
}

fn object<'a>(value: &'a Value, key: &str) -> Result<&'a Map<String, Value>, Reason> {
    value
        .get(key)
        .and_then(Value::as_object)
        .ok_or_else(|| format!("a primitive has no {key}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_files_second_uv_set_moves_behind_the_last() {
        let mut attributes = json!({ "TEXCOORD_1": 7, "TEXCOORD_0": 3, "TEXCOORD_2": 9 });
        let attributes = attributes.as_object_mut().unwrap();
        assert_eq!(move_texcoord_1(attributes), Some(3));
        assert_eq!(
            Value::Object(attributes.clone()),
            json!({ "TEXCOORD_0": 3, "TEXCOORD_2": 9, "TEXCOORD_3": 7 })
        );
        assert_eq!(move_texcoord_1(attributes), None);
    }
}
