//! Folds: faces whose smooth normals point behind them, though they are wound as the faces around them are.
//!
//! The normals of a coarse sheet are means over the faces about a corner, and those of an overhang may all point behind
//! it. A face that is wound the wrong way by mistake has such normals too, and so has one whose normals are turned
//! round. Its neighbours tell them apart. The face of a fold runs through the edges that it shares with them the other
//! way than they do, as those of one sheet must; a face that is wound wrongly runs the same way. The normals of a fold
//! look to the front of its neighbours, those that are turned round do not.

use super::Solids;
use super::inward::{Lean, by_mesh};
use super::topology::{Surface, corners, edges_of};
use super::weld::{Face, weld};
use scene::Sets;
use std::collections::HashMap;

impl Solids {
    /// Triangles of each mesh, ascending, that keep the side of their winding as their lit one wherever they are
    /// placed, though all of their normals point to the other: those of folds of surfaces most of whose normals agree
    /// with their winding.
    pub fn folds(&self) -> Vec<(u32, Vec<u32>)> {
        let leans = self.all_leans();
        if leans.is_empty() {
            return Vec::new();
        }
        let mut of_shape: HashMap<u32, Vec<Vec<bool>>> = HashMap::new();
        let instances = self.scene.instances.iter().zip(&self.instances);
        let marks = instances.map(|(instance, &(shape, number, _))| {
            // Copies of one shape may have normals of their own: the first ones' say which faces are of folds.
            let of = of_shape
                .entry(shape)
                .or_insert_with(|| self.folds_of(shape, &leans));
            (instance.mesh, of[number as usize].clone())
        });
        by_mesh(marks)
    }

    /// Whether each face of a shape is of a fold, by the number of its mesh.
    fn folds_of(&self, shape: u32, leans: &HashMap<u32, Vec<Lean>>) -> Vec<Vec<bool>> {
        let of = &self.shapes[shape as usize];
        let none = |mesh: &u32| vec![false; self.scene.meshes[*mesh as usize].triangles.len()];
        let mut found: Vec<Vec<bool>> = of.meshes.iter().map(none).collect();
        let place: HashMap<u32, usize> = of.meshes.iter().copied().zip(0..).collect();
        for surface in &of.surfaces {
            for face in self.folded(surface, leans) {
                found[place[&face.mesh]][face.triangle as usize] = true;
            }
        }
        found
    }

    /// The faces of a surface whose normals lean behind them, in parts that hang together. More of a part's border is
    /// with faces that are wound as it is, whose own normals do not, and to whose front those of the part look, than
    /// with others.
    fn folded(&self, surface: &Surface, leans: &HashMap<u32, Vec<Lean>>) -> Vec<Face> {
        let lean = |face: &Face| {
            let of_mesh = leans.get(&face.mesh);
            of_mesh.map_or(1.0, |of| of[face.triangle as usize].area)
        };
        let is_behind: Vec<bool> = surface.faces.iter().map(|face| lean(face) < 0.0).collect();
        if !is_behind.contains(&true) || surface.faces.iter().map(lean).sum::<f64>() <= 0.0 {
            return Vec::new();
        }
        // As the file has them, not as their body would be right.
        let faces = surface.faces.iter();
        let faces: Vec<Face> = faces.map(|of| Face::of(of.mesh, of.triangle)).collect();
        let edges = edges_of(&weld(&self.scene, &faces));
        let shared = || {
            edges
                .chunk_by(|a, b| a.0 == b.0)
                .filter(|run| run.len() == 2)
        };
        let ends = |run: &[(u64, u32)]| [0, 1].map(|k| run[k].1 >> 1);
        let is_alike = |run: &[(u64, u32)]| (run[0].1 ^ run[1].1) & 1 == 1;
        let behind = |face: u32| is_behind[face as usize];
        let mut parts = Sets::new(faces.len());
        for run in shared().filter(|run| is_alike(run)) {
            let [a, b] = ends(run);
            if behind(a) && behind(b) {
                parts.join(a, b);
            }
        }
        let mut border: HashMap<u32, f64> = HashMap::new();
        for run in shared() {
            let [a, b] = ends(run);
            if behind(a) != behind(b) {
                let (own, other) = if behind(a) { (a, b) } else { (b, a) };
                let (length, is_smooth) =
                    self.common_edge(faces[own as usize], faces[other as usize]);
                let sign = match is_alike(run) && is_smooth {
                    true => 1.0,
                    false => -1.0,
                };
                *border.entry(parts.root(own)).or_default() += sign * f64::from(length);
            }
        }
        let mut is_fold =
            |face: u32| behind(face) && border.get(&parts.root(face)).is_some_and(|sum| *sum > 0.0);
        let found = (0..).zip(&faces).filter(|(number, _)| is_fold(*number));
        found.map(|(_, face)| *face).collect()
    }

    /// The length of the edge that a face shares with another, and whether its normals at both ends look to the front
    /// of that.
    fn common_edge(&self, own: Face, other: Face) -> (f32, bool) {
        let [at, beside] = [own, other].map(|face| corners(&self.scene, face));
        let front = (beside[1] - beside[0]).cross(beside[2] - beside[0]);
        let mesh = &self.scene.meshes[own.mesh as usize];
        let vertices = mesh.triangles[own.triangle as usize];
        let looks_to_front = |vertex: u32| {
            let normal = mesh.normals.get(vertex as usize);
            normal.is_some_and(|normal| normal.dot(front) > 0.0)
        };
        let shared: Vec<usize> = (0..3).filter(|k| beside.contains(&at[*k])).collect();
        match shared[..] {
            [a, b, ..] => {
                let is_smooth = [a, b].iter().all(|k| looks_to_front(vertices[*k]));
                (at[a].distance(at[b]), is_smooth)
            }
            _ => (0.0, false),
        }
    }
}
