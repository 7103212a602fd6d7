//! Scenes of a few bodies whose hidden parts are known on paper.

use glam::{DVec2, DVec3};
use scene::authored::{AlphaMode, Material, Mesh};
use std::f64::consts::TAU;

/// How far off its surface a point is judged, in metres.
const OFF: f64 = 1e-5;
/// Nearer than this to where it changes a label is not judged, but for what touches exactly.
const UNSURE: f64 = 1e-3;

/// What is right for a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Truth {
    Seen,
    Buried,
    /// Either will do.
    Either,
}

/// Tells how far a point is from a hidden part of space, below 0 in it.
type Distance = Box<dyn Fn(DVec3) -> f64 + Sync + Send>;

/// A part of space that nobody sees.
struct Hidden {
    /// The body whose own surface bounds it, and is not hidden in it.
    owner: Option<usize>,
    distance: Distance,
}

/// A scene with its hidden parts.
#[derive(Default)]
pub(super) struct Made {
    pub meshes: Vec<Mesh>,
    hidden: Vec<Hidden>,
    /// Bodies that are seen wherever they are.
    shown: Vec<usize>,
    /// Bodies of which nothing is judged.
    unjudged: Vec<usize>,
}

impl Made {
    /// Adds a body that hides nothing.
    pub fn open(&mut self, mesh: Mesh) -> usize {
        self.meshes.push(mesh);
        self.meshes.len() - 1
    }

    /// Adds a closed convex body, whose inside is hidden.
    pub fn convex(&mut self, mesh: Mesh) -> usize {
        let planes = planes(&mesh);
        let body = self.open(mesh);
        self.hide(Some(body), move |p| beyond(&planes, p));
        body
    }

    /// Hides a part of space from all bodies but its owner.
    pub fn hide(
        &mut self,
        owner: Option<usize>,
        distance: impl Fn(DVec3) -> f64 + Sync + Send + 'static,
    ) {
        let distance = Box::new(distance);
        self.hidden.push(Hidden { owner, distance });
    }

    /// All of a body is seen.
    pub fn show(&mut self, body: usize) {
        self.shown.push(body);
    }

    /// Judges nothing of a body.
    pub fn spare(&mut self, body: usize) {
        self.unjudged.push(body);
    }

    /// What is right for a point of a body.
    pub fn truth(&self, body: usize, point: DVec3, normal: DVec3) -> Truth {
        if self.unjudged.contains(&body) {
            return Truth::Either;
        }
        if self.shown.contains(&body) {
            return Truth::Seen;
        }
        let point = point + OFF * normal;
        let others = self.hidden.iter().filter(|h| h.owner != Some(body));
        let mut truth = Truth::Seen;
        for hidden in others {
            let distance = (hidden.distance)(point);
            let is_sure = distance.abs() < 2.0 * OFF || distance.abs() > UNSURE;
            match distance < 0.0 {
                true if is_sure => return Truth::Buried,
                _ if !is_sure => truth = Truth::Either,
                _ => (),
            }
        }
        truth
    }
}

/// Unit normals of a mesh's triangles, outward, and where their planes are along them.
pub(super) fn planes(mesh: &Mesh) -> Vec<(DVec3, f64)> {
    let corner = |k: u32| DVec3::from(mesh.positions[k as usize].map(f64::from));
    let plane = |t: &[u32; 3]| {
        let [a, b, c] = t.map(corner);
        let normal = (b - a).cross(c - a).normalize();
        (normal, normal.dot(a))
    };
    mesh.triangles.iter().map(plane).collect()
}

/// How far a point is beyond the farthest of some planes.
pub(super) fn beyond(planes: &[(DVec3, f64)], point: DVec3) -> f64 {
    let heights = planes.iter().map(|(n, at)| n.dot(point) - at);
    heights.fold(f64::NEG_INFINITY, f64::max)
}

/// A mesh of polygons, counter-clockwise seen from their fronts. Equal corners are one.
pub(super) fn polygons(faces: &[Vec<DVec3>]) -> Mesh {
    let mut mesh = Mesh::default();
    for face in faces {
        let number = |p: &DVec3| {
            let p = p.as_vec3().to_array();
            let known = mesh.positions.iter().position(|other| *other == p);
            known.unwrap_or_else(|| {
                mesh.positions.push(p);
                mesh.positions.len() - 1
            }) as u32
        };
        let corners: Vec<u32> = face.iter().map(number).collect();
        let fan = corners[1..].windows(2);
        mesh.triangles
            .extend(fan.map(|pair| [corners[0], pair[0], pair[1]]));
    }
    mesh
}

/// The front faces turned to backs.
pub(super) fn inverted(mut mesh: Mesh) -> Mesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

/// White, of which nothing says that it is drawn from behind too.
pub(super) fn plain() -> Material {
    let mut material = Material::default();
    material.double_sided = false;
    material
}

/// The same, cut out by alpha.
pub(super) fn masked() -> Material {
    let mut material = Material::default();
    material.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    material
}

/// A box by two corners.
pub(super) fn block(low: [f64; 3], high: [f64; 3]) -> Mesh {
    turned_block(low, high, 0.0)
}

/// A box turned about the vertical axis through its middle.
pub(super) fn turned_block(low: [f64; 3], high: [f64; 3], degrees: f64) -> Mesh {
    let (low, high) = (DVec3::from(low), DVec3::from(high));
    let middle = 0.5 * (low + high);
    let turn = DVec2::from_angle(degrees.to_radians());
    let at = |k: usize| {
        let p = DVec3::new(
            if k & 1 == 0 { low.x } else { high.x },
            if k & 2 == 0 { low.y } else { high.y },
            if k & 4 == 0 { low.z } else { high.z },
        ) - middle;
        middle + turn.rotate(p.truncate()).extend(p.z)
    };
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    polygons(&sides.map(|side| side.map(at).to_vec()))
}

/// A level rectangle seen from above.
pub(super) fn level([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> Mesh {
    let corners = [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]];
    polygons(&[corners.map(DVec3::from).to_vec()])
}

/// A rectangle by a corner and two edges, seen from where they turn counter-clockwise.
pub(super) fn sheet(corner: [f64; 3], along: [f64; 3], across: [f64; 3]) -> Mesh {
    let [p, a, b] = [corner, along, across].map(DVec3::from);
    polygons(&[vec![p, p + a, p + a + b, p + b]])
}

/// A closed body of revolution about the vertical axis: radii at heights, in order; radii of 0 close it.
pub(super) fn turned(at: [f64; 2], profile: &[[f64; 2]], sides: usize) -> Mesh {
    let point = |[radius, z]: [f64; 2], k: usize| {
        let angle = TAU * k as f64 / sides as f64;
        (radius * DVec2::from_angle(angle) + DVec2::from(at)).extend(z)
    };
    let mut faces = Vec::new();
    for pair in profile.windows(2) {
        for k in 0..sides {
            let [a, b, c, d] = [
                point(pair[0], k),
                point(pair[0], (k + 1) % sides),
                point(pair[1], (k + 1) % sides),
                point(pair[1], k),
            ];
            match (pair[0][0] == 0.0, pair[1][0] == 0.0) {
                (true, _) => faces.push(vec![a, c, d]),
                (_, true) => faces.push(vec![a, b, c]),
                _ => faces.push(vec![a, b, c, d]),
            }
        }
    }
    polygons(&faces)
}

/// A convex lump about a point, by its radii.
pub(super) fn lump(at: [f64; 3], radius: f64, height: f64) -> Mesh {
    let ring = |k: usize| {
        let angle = std::f64::consts::PI * k as f64 / 6.0;
        [radius * angle.sin(), at[2] - height * angle.cos()]
    };
    let mut profile: Vec<[f64; 2]> = (0..=6).map(ring).collect();
    (profile[0][0], profile[6][0]) = (0.0, 0.0);
    turned([at[0], at[1]], &profile, 11)
}

/// An upright cylinder; `bottom` and `top` close it.
pub(super) fn drum(
    at: [f64; 2],
    radius: f64,
    [low, high]: [f64; 2],
    bottom: bool,
    top: bool,
) -> Mesh {
    let mut profile = vec![[radius, low], [radius, high]];
    if bottom {
        profile.insert(0, [0.0, low]);
    }
    if top {
        profile.push([0.0, high]);
    }
    turned(at, &profile, 14)
}

/// A terrain over a square about the origin.
#[derive(Clone)]
pub(super) struct Terrain {
    half: f64,
    cells: usize,
    heights: Vec<f64>,
}

impl Terrain {
    pub fn new(half: f64, cells: usize, height: impl Fn(f64, f64) -> f64) -> Self {
        let at = |k: usize| -half + 2.0 * half * k as f64 / cells as f64;
        let row = |j| (0..=cells).map(move |i| (i, j));
        let corners = (0..=cells).flat_map(row);
        let heights = corners.map(|(i, j)| f64::from(height(at(i), at(j)) as f32));
        Self {
            half,
            cells,
            heights: heights.collect(),
        }
    }

    fn corner(&self, i: usize, j: usize) -> DVec3 {
        let at = |k: usize| -self.half + 2.0 * self.half * k as f64 / self.cells as f64;
        DVec3::new(at(i), at(j), self.heights[j * (self.cells + 1) + i])
    }

    pub fn mesh(&self) -> Mesh {
        let mut mesh = Mesh::default();
        let row = self.cells as u32 + 1;
        for j in 0..=self.cells {
            let corners = (0..=self.cells).map(|i| self.corner(i, j).as_vec3().to_array());
            mesh.positions.extend(corners);
        }
        for j in 0..self.cells as u32 {
            for i in 0..self.cells as u32 {
                let a = j * row + i;
                mesh.triangles.push([a, a + 1, a + row]);
                mesh.triangles.push([a + 1, a + row + 1, a + row]);
            }
        }
        mesh
    }

    /// How far a point is above it; far beside it.
    pub fn above(&self, p: DVec3) -> f64 {
        let scale = self.cells as f64 / (2.0 * self.half);
        let place = (p.truncate() + self.half) * scale;
        if place.min_element() < 0.0 || place.max_element() > self.cells as f64 {
            return f64::INFINITY;
        }
        let whole = place.floor().min(DVec2::splat(self.cells as f64 - 1.0));
        let (i, j) = (whole.x as usize, whole.y as usize);
        let [s, t] = (place - whole).to_array();
        let height = |i, j| self.corner(i, j).z;
        let surface = match s + t < 1.0 {
            true => (1.0 - s - t) * height(i, j) + s * height(i + 1, j) + t * height(i, j + 1),
            false => {
                (s + t - 1.0) * height(i + 1, j + 1)
                    + (1.0 - s) * height(i, j + 1)
                    + (1.0 - t) * height(i + 1, j)
            }
        };
        p.z - surface
    }
}
