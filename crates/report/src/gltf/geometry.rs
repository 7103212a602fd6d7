//! The vertices of a primitive in the order of the layout: seams split vertices, dropped triangles are left out.

use super::Reason;
use super::accessor::gather;
use super::document::{Document, index};
use super::material::{self, Uses};
use atlas::{MeshLayout, Placement};
use glam::{Vec2, Vec3};
use scene::Mesh;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// One primitive's new attributes, shared by all its objects and pages.
pub struct Geometry {
    attributes: Map<String, Value>,
    targets: Option<Value>,
    /// Where the file's own `TEXCOORD_1` went.
    pub moved: Option<u64>,
    /// The file's own `TEXCOORD_1` where it is the lightmap set already.
    own_lightmap: Option<usize>,
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
    /// `as_placed`: its layout coordinates are those on the page.
    pub fn build(
        document: &mut Document,
        primitive: &Value,
        mesh: &Mesh,
        layout: &MeshLayout,
        laid_out: bool,
        as_placed: bool,
    ) -> Result<Geometry, Reason> {
        let name = &mesh.name;
        assert_eq!(
            layout.triangles.len(),
            mesh.triangles.len(),
            "the layout of {name} has every triangle"
        );
        let mut attributes = object(primitive, "attributes")?.clone();
        let vertices = mesh.positions.len();
        let whole = mesh.source_vertices.is_empty();
        let stays = laid_out
            || whole
                && layout.source_vertices.len() == vertices
                && layout
                    .source_vertices
                    .iter()
                    .enumerate()
                    .all(|(i, &v)| i == v as usize);
        // The layout's vertices by their numbers in the file's arrays.
        let in_file: Vec<u32> = match whole {
            true => layout.source_vertices.clone(),
            false => {
                let number = |&v: &u32| mesh.source_vertices[v as usize];
                layout.source_vertices.iter().map(number).collect()
            }
        };
        let expected = whole.then_some(vertices);
        let is_lightmap =
            as_placed && has_lightmap(document, primitive, mesh, layout, laid_out, &in_file)?;
        let mut targets = primitive.get("targets").cloned();
        if !stays {
            gather_all(document, &mut attributes, expected, &in_file, name)?;
            for target in targets
                .as_mut()
                .and_then(Value::as_array_mut)
                .into_iter()
                .flatten()
            {
                let target = target
                    .as_object_mut()
                    .ok_or("a morph target is not an object")?;
                gather_all(document, target, expected, &in_file, name)?;
            }
        }
        let own_lightmap = attributes
            .get("TEXCOORD_1")
            .and_then(Value::as_u64)
            .filter(|_| is_lightmap)
            .map(|accessor| accessor as usize);
        let moved = match own_lightmap {
            Some(_) => None,
            None => move_texcoord_1(&mut attributes),
        };

        let list = primitive.get("mode").and_then(Value::as_u64).unwrap_or(4) == 4;
        let same = laid_out
            || list
                && whole
                && mesh.source_triangles.is_empty()
                && layout.triangles == mesh.triangles;
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
            own_lightmap,
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
            if let Some(to) = self.moved {
                material::redirect(extensions, to);
            }
            if extensions.is_empty() {
                primitive.shift_remove("extensions");
            }
        }
        Ok(Value::Object(primitive))
    }
}

/// The accessor of one object's lightmap coordinates: the file's own, or the layout's, carried onto its page.
pub fn lightmap(
    document: &mut Document,
    geometry: &Geometry,
    layout: &MeshLayout,
    placement: &Placement,
) -> Result<usize, Reason> {
    if let Some(own) = geometry.own_lightmap {
        return Ok(own);
    }
    let ([su, sv], [ou, ov]) = (placement.scale, placement.offset);
    let uvs: Vec<[f32; 2]> = layout
        .uvs
        .iter()
        .map(|uv| [uv.x * su + ou, uv.y * sv + ov])
        .collect();
    document.push_floats(&uvs, false)
}

/// The accessor of one object's vertex colours: the mesh's own times a number of each of its vertices.
pub fn colors(
    document: &mut Document,
    (mesh, shades): (&Mesh, &[f32]),
    layout: &MeshLayout,
) -> Result<usize, Reason> {
    let color = |&vertex: &u32| {
        let vertex = vertex as usize;
        let own = mesh.colors.get(vertex).copied().unwrap_or(Vec3::ONE) * shades[vertex];
        let alpha = mesh.alphas.get(vertex).copied().unwrap_or(1.0);
        own.extend(alpha).to_array()
    };
    let colors: Vec<[f32; 4]> = layout.source_vertices.iter().map(color).collect();
    document.push_floats(&colors, false)
}

/// Replaces every accessor of an attribute map by its elements in the order `vertices`. All must have `expected`
/// elements where the loader read them whole.
fn gather_all(
    document: &mut Document,
    attributes: &mut Map<String, Value>,
    expected: Option<usize>,
    vertices: &[u32],
    name: &str,
) -> Result<(), Reason> {
    for (semantic, accessor) in attributes {
        let source = accessor.as_u64().ok_or("an attribute is not an index")? as usize;
        let elements = document.original(source)?;
        let count = elements.count;
        let last = vertices.iter().max().map_or(0, |&v| v as usize + 1);
        if count < last || expected.is_some_and(|expected| count != expected) {
            return Err(format!(
                "{semantic} of {name} has {count} vertices, its POSITION {}; export the file again",
                expected.unwrap_or(last)
            ));
        }
        *accessor = gather(
            document,
            source,
            &elements,
            vertices,
            semantic == "POSITION",
        )?
        .into();
    }
    Ok(())
}

/// Whether the primitive's `TEXCOORD_1` holds the layout's coordinates, value by value. `in_file`: the layout's
/// vertices by their numbers in the file's arrays.
fn has_lightmap(
    document: &Document,
    primitive: &Value,
    mesh: &Mesh,
    layout: &MeshLayout,
    laid_out: bool,
    in_file: &[u32],
) -> Result<bool, Reason> {
    let Some(accessor) = index(&primitive["attributes"], "TEXCOORD_1") else {
        return Ok(false);
    };
    if laid_out {
        let set = mesh.uv_sets.get(1);
        let at = |v: u32| set?.get(v as usize).map(Vec2::to_array);
        return Ok(holds(layout, &layout.source_vertices, at));
    }
    // Not the loaded set: there a coordinate that is not finite has been repaired.
    let own = document.original(accessor)?;
    let at = |v: u32| Some(own.numbers(v as usize)?.map(|number| number as f32));
    let whole = mesh.source_vertices.is_empty();
    Ok((!whole || own.count == mesh.positions.len()) && holds(layout, in_file, at))
}

/// Whether the layout's coordinates are those of the UV set `at`, which knows them by the numbers `vertices`.
fn holds(layout: &MeshLayout, vertices: &[u32], at: impl Fn(u32) -> Option<[f32; 2]>) -> bool {
    let same = |(&vertex, uv): (&u32, &Vec2)| at(vertex) == Some(uv.to_array());
    vertices.len() == layout.uvs.len() && vertices.iter().zip(&layout.uvs).all(same)
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

    #[test]
    fn a_kept_second_uv_set_is_found_by_its_values() {
        let set = [[0.25, 0.5], [1.0, 0.0], [0.1, 0.7]];
        let at = |v: u32| set.get(v as usize).copied();
        // The layout has the set's last vertex twice and its second nowhere.
        let vertices = [2, 0, 2];
        let mut layout = MeshLayout {
            uvs: vertices.map(|v| Vec2::from(set[v as usize])).to_vec(),
            ..MeshLayout::default()
        };
        assert!(holds(&layout, &vertices, at));
        assert!(!holds(&layout, &[2, 0, 3], at), "beyond the set");
        assert!(!holds(&layout, &[2, 0], at), "fewer vertices");
        layout.uvs[1].y += f32::EPSILON;
        assert!(!holds(&layout, &vertices, at), "another value");
    }
}
