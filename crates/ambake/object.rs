//! Where the triangles of each object lie on the pages.

use crate::baked::Baked;
use atlas::{MeshLayout, Placement};

/// The lightmap coordinates of one object, triangle by triangle, in the order in which the scene gave them. `uvs` has
/// them corner by corner; for a mesh that is drawn by indices, `vertices` says which of its vertices to repeat where
/// charts part, `coordinates` what each of these has, and `indices` which of these each triangle uses.
#[derive(Debug, Clone)]
pub struct Object {
    /// Its name; objects may share one.
    pub name: String,
    /// Number of each triangle in the mesh, or the file's primitive, that it came from. Triangles without area have
    /// been left out.
    pub triangles: Vec<u32>,
    /// Page of each triangle.
    pub pages: Vec<u32>,
    /// Coordinates of the corners of each triangle in 0..=1 of its page: v = 0 is the top of row 0.
    pub uvs: Vec<[[f32; 2]; 3]>,
    /// For each vertex of the mesh with lightmap coordinates, the number of the vertex that it repeats, in the mesh or
    /// the file's primitive.
    pub vertices: Vec<u32>,
    /// Lightmap coordinates of each of `vertices`.
    pub coordinates: Vec<[f32; 2]>,
    /// Three of `vertices` for each triangle.
    pub indices: Vec<[u32; 3]>,
}

impl Baked {
    /// The objects of the scene that took texels, in its order. An excluded one is not among them.
    pub fn objects(&self) -> impl Iterator<Item = Object> {
        let (scene, atlas) = (self.job().scene(), self.job().atlas());
        let placed = scene.instances.iter().zip(&atlas.placements);
        let placed = placed.filter(|(_, placement)| placement.is_somewhere());
        placed.map(|(instance, placement)| {
            let number = instance.mesh as usize;
            let layout = &atlas.meshes[number];
            let count = layout.triangles.len() as u32;
            let numbers = &scene.meshes[number].source_triangles;
            let in_file = &scene.meshes[number].source_vertices;
            let in_file = |&vertex: &u32| *in_file.get(vertex as usize).unwrap_or(&vertex);
            let coordinates = coordinates(layout, placement);
            let corners = |t: &[u32; 3]| t.map(|v| coordinates[v as usize]);
            Object {
                name: instance.name.clone(),
                triangles: match numbers.is_empty() {
                    true => (0..count).collect(),
                    false => numbers.clone(),
                },
                pages: (0..count as usize)
                    .map(|t| placement.page + layout.triangle_pages.get(t).map_or(0, |&p| p.into()))
                    .collect(),
                uvs: layout.triangles.iter().map(corners).collect(),
                vertices: layout.source_vertices.iter().map(in_file).collect(),
                indices: layout.triangles.clone(),
                coordinates,
            }
        })
    }
}

fn coordinates(layout: &MeshLayout, placement: &Placement) -> Vec<[f32; 2]> {
    let ([su, sv], [ou, ov]) = (placement.scale, placement.offset);
    let uvs = layout.uvs.iter();
    uvs.map(|uv| [uv.x * su + ou, uv.y * sv + ov]).collect()
}

#[cfg(test)]
mod tests {
    use crate::{Bake, Layer, Mesh, Scene};

    fn square(name: &str, height: f32) -> Mesh {
        let mut mesh = Mesh::default();
        mesh.name = name.into();
        mesh.positions = vec![
            [0.0, height, 0.0],
            [0.0, height, 1.0],
            [1.0, height, 1.0],
            [1.0, height, 0.0],
        ];
        mesh.triangles = vec![[0, 1, 2], [0, 0, 2], [0, 2, 3]]; // the second has no area
        mesh
    }

    #[test]
    fn the_corners_of_every_triangle_lie_on_covered_texels_of_its_page() {
        let scene = Scene::from_meshes(
            vec![square("floor", 0.0), square("lid", 1.0), square("out", 2.0)],
            vec![],
        );
        let bake = Bake::new(&scene.unwrap()).size(32).rays(4).exclude("out");
        let baked = bake.run(&()).unwrap();
        let objects: Vec<_> = baked.objects().collect();
        let names: Vec<_> = objects.iter().map(|o| o.name.as_str()).collect();
        assert_eq!(names, ["floor", "lid"]);
        for object in &objects {
            assert_eq!(object.triangles, [0, 2], "{}", object.name);
            // By indices the same, of the vertices that the mesh has there.
            let given = [[0, 1, 2], [0, 2, 3]];
            for (t, corners) in object.indices.iter().enumerate() {
                let uvs = corners.map(|v| object.coordinates[v as usize]);
                let vertices = corners.map(|v| object.vertices[v as usize]);
                assert_eq!(
                    (uvs, vertices),
                    (object.uvs[t], given[t]),
                    "{}",
                    object.name
                );
            }
            for (triangle, page) in object.uvs.iter().zip(&object.pages) {
                let coverage = baked.page(*page as usize).layer(Layer::Coverage);
                let middle = [0, 1].map(|k| triangle.iter().map(|uv| uv[k]).sum::<f32>() / 3.0);
                let [x, y] = middle.map(|share| (share * 32.0) as usize);
                assert_eq!(coverage[y * 32 + x], 1.0, "{} at {x}, {y}", object.name);
            }
        }
    }
}
