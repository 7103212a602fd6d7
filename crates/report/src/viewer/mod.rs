//! `report.html`: a finished bake to look at in a browser, in one file that needs no network.
//!
//! The page's own code stands beside this file as HTML, CSS and plain JavaScript over WebGL 2. What it shows is
//! embedded: a JSON head, the geometry, and every page's layers as 16-bit floats, deflated and in base64. Names cannot
//! end the script element that they stand in, because the head has no `<`.

mod balls;
mod cutouts;
mod embed;

pub use balls::EmbeddedProbes;
pub use embed::EmbeddedPage;

use cutouts::Cutouts;
use embed::blob;
use glam::{DAffine3, DVec3};
use scene::Scene;
use serde_json::{Value, json};

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("style.css");
const SCRIPT: [&str; 9] = [
    include_str!("data.js"),
    include_str!("colors.js"),
    include_str!("camera.js"),
    include_str!("live.js"),
    include_str!("gl.js"),
    include_str!("balls.js"),
    include_str!("main.js"),
    include_str!("plot.js"),
    include_str!("input.js"),
];

/// A finished bake as the viewer takes it.
pub struct Viewer<'a> {
    /// What is written above it.
    pub title: &'a str,
    /// The scene with its page coordinates as the second UV set.
    pub scene: &'a Scene,
    /// Page of each mesh; `None` for one without texels.
    pub page_of: &'a [Option<u32>],
    /// Every page in order.
    pub pages: &'a [EmbeddedPage],
    /// Where the first view is taken from, and the point that is looked at.
    pub view: [DVec3; 2],
    /// Its vertical field of view in radians.
    pub fov: f64,
    /// Stops by which it is brightened.
    pub stops: i32,
    /// The content of `bake.json`.
    pub bake: &'a Value,
    /// What the harmonics of the pages are evaluated with, where they hold any.
    pub kernel: Option<Kernel>,
    /// Probes of the scene, where some stand beside the bake.
    pub probes: Option<EmbeddedProbes<'a>>,
    /// The rows of a benchmark that stands beside the bake, as its `bench.csv` has them.
    pub bench: Option<&'a str>,
}

/// The kernels of harmonics for any view.
pub struct Kernel {
    /// Their largest order, 4 or 8.
    pub order: u32,
    /// Width of their picture.
    pub columns: usize,
    /// Its values, row after row.
    pub values: Vec<f32>,
}

impl Viewer<'_> {
    /// The whole file. The bytes are a function of the fields.
    pub fn html(&self) -> String {
        let origin = self.view[1];
        let centres: Vec<DVec3> = self.scene.meshes.iter().map(centre).collect();
        let cutouts = Cutouts::of(self.scene);
        let mut geometry = Vec::new();
        for (mesh, &centre) in self.scene.meshes.iter().zip(&centres) {
            push_mesh(&mut geometry, mesh, centre);
            geometry.extend(cutouts.vertices(mesh));
        }
        let mut radius = 0.0f64;
        let instances: Vec<Value> = self
            .scene
            .instances
            .iter()
            .map(|instance| {
                let mesh = instance.mesh as usize;
                let place = DAffine3::from_translation(-origin)
                    * instance.transform
                    * DAffine3::from_translation(centres[mesh]);
                for position in &self.scene.meshes[mesh].positions {
                    let at = instance.transform.transform_point3(position.as_dvec3());
                    radius = radius.max((at - origin).length());
                }
                let [x, y, z] = [
                    place.matrix3.x_axis,
                    place.matrix3.y_axis,
                    place.matrix3.z_axis,
                ];
                let at = place.translation;
                let columns = [(x, 0.0), (y, 0.0), (z, 0.0), (at, 1.0)];
                let matrix: Vec<f64> = columns
                    .iter()
                    .flat_map(|(v, w)| [v.x, v.y, v.z, *w])
                    .collect();
                json!({
                    "name": instance.name,
                    "mesh": mesh,
                    "matrix": matrix,
                    "mirrored": place.matrix3.determinant() < 0.0,
                })
            })
            .collect();
        let meshes = self.scene.meshes.iter().zip(self.page_of);
        let meshes: Vec<Value> = meshes
            .map(|(mesh, page)| {
                json!({
                    "vertices": mesh.positions.len(),
                    "triangles": mesh.triangles.len(),
                    "page": page.map_or(-1, i64::from),
                    "cutout": cutouts.head(mesh),
                })
            })
            .collect();
        let pages: Vec<Value> = self
            .pages
            .iter()
            .map(|page| {
                json!({ "size": page.size, "texels": page.texels, "planes": page.planes,
                    "harmonics": page.harmonics })
            })
            .collect();
        let (alphas, alpha_texts): (Vec<Value>, Vec<String>) =
            cutouts.pictures().into_iter().unzip();
        let head = json!({
            "title": self.title,
            "origin": origin.to_array(),
            "radius": radius,
            "camera": {
                "eye": (self.view[0] - origin).to_array(),
                "look": [0.0, 0.0, 0.0],
                "fov": self.fov,
            },
            "stops": self.stops,
            "meshes": meshes,
            "instances": instances,
            "alphas": alphas,
            "pages": pages,
            "layers": self.pages.first().map_or(&[][..], |page| &page.layers),
            "kernel": self.kernel.as_ref().map(|kernel| json!({ "order": kernel.order, "columns": kernel.columns })),
            "probes": self.probes.as_ref().map(|probes| probes.head(origin, radius)),
            "bake": self.bake,
            "bench": self.bench,
        });
        let mut data = format!(
            "<script type=\"application/json\" id=\"head\">{}</script>\n",
            harmless(&head)
        );
        data += &element("geometry", &blob(&geometry));
        if let Some(kernel) = &self.kernel {
            let bytes: Vec<u8> = kernel.values.iter().flat_map(|v| v.to_le_bytes()).collect();
            data += &element("kernel", &blob(&bytes));
        }
        if let Some(probes) = &self.probes {
            data += &element("probes", &probes.blob(origin));
        }
        for (number, text) in alpha_texts.iter().enumerate() {
            data += &element(&format!("a{number}"), text);
        }
        for (number, page) in self.pages.iter().enumerate() {
            data += &element(&format!("c{number}"), &page.coverage);
            for (plane, text) in page.texts.iter().enumerate() {
                data += &element(&format!("p{number}.{plane}"), text);
            }
        }
        let live = self
            .kernel
            .as_ref()
            .map_or(String::new(), |kernel| crate::any_view::glsl(kernel.order));
        let script = format!("\"use strict\";\n{}", SCRIPT.concat()).replace("{{anyView}}", &live);
        // The data comes last, so that nothing in it is taken for a place to fill.
        let parts = PAGE.split_once("{{data}}").unwrap_or((PAGE, ""));
        let fill = |part: &str| {
            part.replace("{{style}}", STYLE)
                .replace("{{script}}", &script)
        };
        [fill(parts.0), data, fill(parts.1)].concat()
    }
}

/// JSON that can stand in a script element: `<` is written as its escape, which only strings can hold.
fn harmless(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

fn element(id: &str, text: &str) -> String {
    format!("<script type=\"application/octet-stream\" id=\"{id}\">{text}</script>\n")
}

/// The middle of a mesh's box; its positions are written from there.
fn centre(mesh: &scene::Mesh) -> DVec3 {
    let at = |fold: fn(glam::Vec3, glam::Vec3) -> glam::Vec3| {
        mesh.positions
            .iter()
            .copied()
            .reduce(fold)
            .unwrap_or_default()
    };
    0.5 * (at(glam::Vec3::min).as_dvec3() + at(glam::Vec3::max).as_dvec3())
}

/// Positions as f32, page coordinates as 16-bit shares, vertex indices as u32; each begins at a multiple of four bytes.
fn push_mesh(bytes: &mut Vec<u8>, mesh: &scene::Mesh, centre: DVec3) {
    for position in &mesh.positions {
        let from = (position.as_dvec3() - centre).as_vec3().to_array();
        bytes.extend(from.iter().flat_map(|x| x.to_le_bytes()));
    }
    let none = Vec::new();
    let uvs = mesh.uv_sets.get(1).unwrap_or(&none);
    for vertex in 0..mesh.positions.len() {
        let uv = uvs.get(vertex).map_or([0.0; 2], |uv| uv.to_array());
        let share = |x: f32| (f64::from(x).clamp(0.0, 1.0) * 65_535.0).round() as u16;
        bytes.extend(uv.iter().flat_map(|&x| share(x).to_le_bytes()));
    }
    let corners = mesh.triangles.iter().flatten();
    bytes.extend(corners.flat_map(|corner| corner.to_le_bytes()));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Page, PageLayer};

    #[test]
    fn no_name_can_end_the_element_that_it_stands_in() {
        let mut floor = scene::authored::Mesh::default();
        floor.name = "</script><script>alert(1)</script> {{script}} <!--".into();
        floor.positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        floor.triangles = vec![[0, 1, 2]];
        let scene = Scene::from_meshes(vec![floor], vec![]).unwrap();
        let page = Page {
            size: 2,
            layers: vec![
                PageLayer::scalar("coverage", vec![1.0; 4]),
                PageLayer::scalar("diffuse", vec![0.5; 4]),
            ],
        };
        let viewer = Viewer {
            title: "a</title>",
            scene: &scene,
            page_of: &[None],
            pages: &[EmbeddedPage::of(&page, 1)],
            view: [DVec3::ONE, DVec3::ZERO],
            fov: 0.7,
            stops: 0,
            kernel: None,
            probes: None,
            bake: &json!({ "warnings": ["</script>"] }),
            bench: Some("technique\n</script>\n"),
        };
        let html = viewer.html();
        assert_eq!(html, viewer.html());
        assert!(!html.contains("alert(1)</script>") && !html.contains("a</title>"));
        assert!(html.contains("\\u003c/script>\\u003cscript>alert(1)"));
        // The head, geometry, coverage, one layer and the code.
        assert_eq!(html.matches("</script>").count(), 5);
        let braces = html.matches("{{").count();
        assert_eq!(braces, 1, "only the name holds braces");
        for word in ["http://", "https://", "src=", "@import", "fetch("] {
            assert!(!html.contains(word), "{word}");
        }
    }
}
