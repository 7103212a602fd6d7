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

    /// Whether it is of a body that hides what its silhouette hides.
    fn is_convex(&self) -> bool {
        self.object.starts_with("convex")
    }
}

/// A scene: all faces in the file's order.
pub struct Mesh {
    pub faces: Vec<Face>,
    bodies: Vec<Body>,
}

/// A body named `convex…`: what its silhouette from a point is made of.
struct Body {
    /// A point and the normal of each face.
    planes: Vec<(DVec3, DVec3)>,
    /// Two corners of an edge, the face on whose boundary they follow each other, and the one beyond.
    edges: Vec<([usize; 2], usize, Option<usize>)>,
    corners: HashMap<usize, DVec3>,
}

impl Body {
    fn new(faces: &[&Face]) -> Self {
        let mut edges: HashMap<[usize; 2], usize> = HashMap::new();
        let mut corners = HashMap::new();
        for (number, face) in faces.iter().enumerate() {
            for (k, &id) in face.ids.iter().enumerate() {
                edges.insert([id, face.ids[(k + 1) % face.ids.len()]], number);
                corners.insert(id, face.points[k]);
            }
        }
        let beyond = |[a, b]: [usize; 2]| edges.get(&[b, a]).copied();
        Self {
            planes: faces.iter().map(|f| (f.points[0], f.normal())).collect(),
            edges: edges
                .iter()
                .map(|(&e, &face)| (e, face, beyond(e)))
                .collect(),
            corners,
        }
    }

    /// The loop between the faces that look at `point` and those that do not; none from inside.
    fn silhouette(&self, point: DVec3) -> Vec<DVec3> {
        let faces = self.planes.iter();
        let looks: Vec<bool> = faces
            .map(|(on, normal)| normal.dot(point - *on) > 0.0)
            .collect();
        let free = self.edges.iter();
        let free =
            free.filter(|(_, face, beyond)| looks[*face] && !beyond.is_some_and(|k| looks[k]));
        let next: HashMap<usize, usize> = free.map(|([a, b], ..)| (*a, *b)).collect();
        follow(&next).iter().map(|id| self.corners[id]).collect()
    }
}

/// The one loop of corners that each are followed by the next.
fn follow(next: &HashMap<usize, usize>) -> Vec<usize> {
    let Some(&start) = next.keys().min() else {
        return Vec::new();
    };
    let mut loop_ = vec![start];
    while next[&loop_[loop_.len() - 1]] != start {
        loop_.push(next[&loop_[loop_.len() - 1]]);
    }
    assert_eq!(loop_.len(), next.len(), "the rim is one loop");
    loop_
}

impl Mesh {
    /// A scene of these faces.
    pub fn new(faces: Vec<Face>) -> Self {
        let mut convex: HashMap<&str, Vec<&Face>> = HashMap::new();
        for face in faces.iter().filter(|face| face.is_convex()) {
            convex.entry(&face.object).or_default().push(face);
        }
        let bodies = convex.values().map(|faces| Body::new(faces)).collect();
        Self { faces, bodies }
    }

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
        Self::new(faces)
    }

    /// Loops that cover, without overlap, what blocks the sky of `point` on the front of a receiver.
    ///
    /// Bodies named `convex…` block by their silhouette; every other face blocks by itself.
    pub fn blockers(&self, point: DVec3) -> Vec<Vec<DVec3>> {
        let mut loops = Vec::new();
        for face in self.faces.iter().filter(|face| !face.is_convex()) {
            // A face seen edge-on hides nothing; the receiver's own plane is among these.
            let away = face.points.iter().map(|p| (*p - point).length());
            let reach = away.fold(0.0, f64::max);
            if face.normal().dot(point - face.points[0]).abs() > 1e-6 * reach.min(1.0) {
                loops.push(face.points.iter().map(|p| *p - point).collect());
            }
        }
        for body in &self.bodies {
            loops.push(body.silhouette(point).iter().map(|p| *p - point).collect());
        }
        loops
    }

    /// The one closed loop of edges that belong to a single face: the rim of an open shell.
    pub fn rim(&self) -> Vec<DVec3> {
        let shell = Body::new(&self.faces.iter().collect::<Vec<_>>());
        let free = shell.edges.iter().filter(|(.., beyond)| beyond.is_none());
        let next = free.map(|([a, b], ..)| (*a, *b)).collect();
        follow(&next).iter().map(|id| shell.corners[id]).collect()
    }
}
