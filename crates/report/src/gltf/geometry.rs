//! The vertices of a primitive in the order of the layout: seams split vertices, dropped triangles are left out.

use super::Reason;
use super::accessor::gather;
use super::document::Document;
use super::material::{self, Uses};
use super::places::index;
use atlas::{MeshLayout, Placement};
use glam::{Vec2, Vec3};
use scene::Mesh;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, HashMap};

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
        if mesh.tangents.is_empty() {
            // Those that the file has are none, and viewers make their own.
            attributes.shift_remove("TANGENT");
        }
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
        let mut targets = primitive.get("targets").cloned();
        let of_targets = targets.as_mut().and_then(Value::as_array_mut);
        let of_targets = of_targets.into_iter().flatten();
        let mut maps = vec![&mut attributes];
        maps.extend(of_targets.filter_map(Value::as_object_mut));
        // What a primitive can do without and cannot be had is left out: a viewer would refuse the file for it.
        for map in maps.iter_mut().filter(|_| !laid_out) {
            let expected = whole.then_some(vertices);
            map.retain(|_, accessor| is_sound(document, accessor, expected, &in_file));
        }
        let mut gathered = HashMap::new();
        for map in maps.into_iter().filter(|_| !stays) {
            gather_all(document, map, &in_file, &mut gathered)?;
        }
        let is_lightmap =
            as_placed && has_lightmap(document, primitive, mesh, layout, laid_out, &in_file);
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

/// Whether an attribute has the elements `vertices`, and `expected` of them where the loader read them whole.
fn is_sound(
    document: &Document,
    accessor: &Value,
    expected: Option<usize>,
    vertices: &[u32],
) -> bool {
    let last = vertices.iter().max().map_or(0, |&v| v as usize + 1);
    let accessor = accessor.as_u64().map(|accessor| accessor as usize);
    let count = accessor.and_then(|accessor| Some(document.original(accessor).ok()?.count));
    count.is_some_and(|count| count >= last && expected.is_none_or(|expected| count == expected))
}

/// Replaces every accessor of an attribute map by its elements in the order `vertices`. `gathered` holds those made so
/// far: what is one accessor in the file is one here.
fn gather_all(
    document: &mut Document,
    attributes: &mut Map<String, Value>,
    vertices: &[u32],
    gathered: &mut HashMap<usize, usize>,
) -> Result<(), Reason> {
    for (semantic, accessor) in attributes {
        let source = accessor.as_u64().ok_or("an attribute is not an index")? as usize;
        let own = match gathered.get(&source) {
            Some(&own) => own,
            None => {
                let elements = document.original(source)?;
                let bounds = semantic == "POSITION";
                gather(document, source, &elements, vertices, bounds)?
            }
        };
        gathered.insert(source, own);
        *accessor = own.into();
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
) -> bool {
    let Some(accessor) = index(&primitive["attributes"], "TEXCOORD_1") else {
        return false;
    };
    if laid_out {
        let set = mesh.uv_sets.get(1);
        let at = |v: u32| set?.get(v as usize).map(Vec2::to_array);
        return holds(layout, &layout.source_vertices, at);
    }
    // Not the loaded set: there a coordinate that is not finite has been repaired.
    let Ok(own) = document.original(accessor) else {
        return false;
    };
    let at = |v: u32| Some(own.numbers(v as usize)?.map(|number| number as f32));
    let whole = mesh.source_vertices.is_empty();
    (!whole || own.count == mesh.positions.len()) && holds(layout, in_file, at)
}

/// Whether the layout's coordinates are those of the UV set `at`, which knows them by the numbers `vertices`.
fn holds(layout: &MeshLayout, vertices: &[u32], at: impl Fn(u32) -> Option<[f32; 2]>) -> bool {
    let same = |(&vertex, uv): (&u32, &Vec2)| at(vertex) == Some(uv.to_array());
    vertices.len() == layout.uvs.len() && vertices.iter().zip(&layout.uvs).all(same)
}

/// Moves `TEXCOORD_1` behind the last UV set, or to where it stands a second time, and returns its new number.
fn move_texcoord_1(attributes: &mut Map<String, Value>) -> Option<u64> {
    let old = attributes.shift_remove("TEXCOORD_1")?;
    let same = attributes.iter().filter(|(_, other)| **other == old);
    let same = same.filter_map(|(name, _)| set_number(name)).max();
    if same.is_some_and(|same| same > 1) {
        return same;
    }
    let next = last_set(attributes).max(1) + 1;
    attributes.insert(format!("TEXCOORD_{next}"), old);
    Some(next)
}

/// The number of a UV set.
fn set_number(attribute: &str) -> Option<u64> {
    attribute.strip_prefix("TEXCOORD_")?.parse().ok()
}

/// The largest number of a UV set; 0 where there is none.
fn last_set(attributes: &Map<String, Value>) -> u64 {
    let numbers = attributes.keys().filter_map(|name| set_number(name));
    numbers.max().unwrap_or(0)
}

/// Gives the UV set 1 of every primitive one more number, the same for all, where an extension of the document, of a
/// node or of a mesh reads it, and leads that there: what primitives share cannot follow each to a number of its own.
pub fn share_texcoord_1(document: &mut Document) {
    let mut last = 1;
    each_attributes(&mut document.json, |attributes| {
        last = last.max(last_set(attributes));
    });
    let to = last + 1;
    let mut found = lead(&mut document.json, to);
    let lists = document.json.as_object_mut().into_iter().flatten();
    // Each primitive has materials of its own.
    for (_, list) in lists.filter(|(key, _)| *key != "materials") {
        let items = list.as_array_mut().into_iter().flatten();
        found |= items.fold(false, |found, item| lead(item, to) | found);
    }
    if found {
        each_attributes(&mut document.json, |attributes| {
            if let Some(own) = attributes.get("TEXCOORD_1").cloned() {
                let missing = last_set(attributes) + 1..=to;
                attributes.extend(missing.map(|n| (format!("TEXCOORD_{n}"), own.clone())));
            }
        });
    }
}

/// Leads what the extensions of an element read of UV set 1 to the set `to`; true where there was something.
fn lead(element: &mut Value, to: u64) -> bool {
    let extensions = element.get_mut("extensions");
    let extensions = extensions.and_then(Value::as_object_mut);
    extensions.is_some_and(|extensions| material::redirect(extensions, to))
}

/// Shows the attributes of every primitive.
fn each_attributes(json: &mut Value, mut see: impl FnMut(&mut Map<String, Value>)) {
    fn parts<'a>(value: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
        let list = value.get_mut(key).and_then(Value::as_array_mut);
        list.into_iter().flatten()
    }
    for primitive in parts(json, "meshes").flat_map(|mesh| parts(mesh, "primitives")) {
        let attributes = primitive.get_mut("attributes");
        attributes.and_then(Value::as_object_mut).map(&mut see);
    }
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
        // One that stands behind the others already stays there.
        let mut twice =
            json!({ "TEXCOORD_0": 7, "TEXCOORD_1": 7, "TEXCOORD_2": 7, "TEXCOORD_3": 9 });
        let attributes = twice.as_object_mut().unwrap();
        assert_eq!(move_texcoord_1(attributes), Some(2));
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
