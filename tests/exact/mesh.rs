//! Authored OBJ scenes as the exact reference reads them: faces by object, and what each object hides from a point.

use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::path::Path;

/// A planar polygon, counter-clockwise from its front. Numbers are the file's, rounded to f32 as a baker does.
pub struct Face {
    pub object: String,
    pub points: Vec<DVec3>,
    pub ids: Vec<usize>,
    /// Page coordinates in 0..1, v down; empty where the file has none.
    pub uvs: Vec<DVec2>,
    /// Shading normals; empty where the file has none.
    pub normals: Vec<DVec3>,
}

impl Face {
    /// The geometric unit normal.
    pub fn normal(&self) -> DVec3 {
        let p = &self.points;
        (p[1] - p[0]).cross(p[2] - p[0]).normalize()
    }
}

/// A scene: all faces in the file's order.
pub struct Mesh {
    pub faces: Vec<Face>,
}

impl Mesh {
    /// The OBJ file at `path`, of which only `o`, `v`, `vt`, `vn` and `f` with positive indices count.
    pub fn read(path: &Path) -> Self {
        let text =
            std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let (mut v, mut vt, mut vn) = (Vec::new(), Vec::new(), Vec::new());
        let (mut faces, mut object) = (Vec::new(), String::new());
        for line in text.lines() {
            let mut words = line.split_whitespace();
            let kind = words.next().unwrap_or("");
            let words: Vec<&str> = words.collect();
            let number = |k: usize| f64::from(words[k].parse::<f32>().expect("a number"));
            match kind {
                "o" => object = words[0].into(),
                "v" => v.push(DVec3::new(number(0), number(1), number(2))),
                "vt" => vt.push(DVec2::new(number(0), 1.0 - number(1))),
                "vn" => vn.push(DVec3::new(number(0), number(1), number(2)).normalize()),
                "f" => {
                    let column = |k: usize| -> Vec<usize> {
                        let part = |word: &&str| {
                            word.split('/').nth(k)?.parse::<usize>().ok().map(|i| i - 1)
                        };
                        words.iter().filter_map(part).collect()
                    };
                    let ids = column(0);
                    faces.push(Face {
                        object: object.clone(),
                        points: ids.iter().map(|&i| v[i]).collect(),
                        uvs: column(1).iter().map(|&i| vt[i]).collect(),
                        normals: column(2).iter().map(|&i| vn[i]).collect(),
                        ids,
                    });
                }
                _ => {}
            }
        }
        Self { faces }
    }

    /// Loops that cover, without overlap, what blocks the sky of `point` on the front of a receiver.
    ///
    /// Bodies named `convex…` block by their silhouette; every other face blocks by itself.
    pub fn blockers(&self, point: DVec3) -> Vec<Vec<DVec3>> {
        let mut loops = Vec::new();
        let mut bodies: HashMap<&str, Vec<&Face>> = HashMap::new();
        for face in &self.faces {
            if face.object.starts_with("convex") {
                if face.normal().dot(point - face.points[0]) > 0.0 {
                    bodies.entry(&face.object).or_default().push(face);
                }
            } else {
                // A face seen edge-on hides nothing; the receiver's own plane is among these.
                let reach = face
                    .points
                    .iter()
                    .map(|p| (*p - point).length())
                    .fold(0.0, f64::max);
                if face.normal().dot(point - face.points[0]).abs() > 1e-6 * reach.min(1.0) {
                    loops.push(face.points.iter().map(|p| *p - point).collect());
                }
            }
        }
        loops.extend(
            bodies
                .values()
                .map(|faces| rim(faces).iter().map(|p| *p - point).collect::<Vec<_>>()),
        );
        loops
    }

    /// The one closed loop of edges that belong to a single face: the rim of an open shell.
    pub fn rim(&self) -> Vec<DVec3> {
        rim(&self.faces.iter().collect::<Vec<_>>())
    }
}

/// The loop of edges that only one of `faces` has.
fn rim(faces: &[&Face]) -> Vec<DVec3> {
    let mut edges = HashMap::new();
    for face in faces {
        for k in 0..face.ids.len() {
            let next = (k + 1) % face.ids.len();
            edges.insert((face.ids[k], face.ids[next]), face.points[k]);
        }
    }
    let free = edges
        .iter()
        .filter(|((a, b), _)| !edges.contains_key(&(*b, *a)));
    let next: HashMap<usize, (usize, DVec3)> =
        free.map(|((a, b), point)| (*a, (*b, *point))).collect();
    let Some(&start) = next.keys().min() else {
        return Vec::new();
    };
    let mut loop_ = Vec::new();
    let mut at = start;
    loop {
        let (to, point) = next[&at];
        loop_.push(point);
        at = to;
        if at == start {
            break;
        }
    }
    assert_eq!(loop_.len(), next.len(), "the rim is one loop");
    loop_
}
