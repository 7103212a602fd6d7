//! Seams, found from the geometry alone: edges of triangles that meet in space and lie apart on the pages.

use super::lit::Lit;
use glam::{DVec2, DVec3};
use serde::Serialize;
use std::collections::HashMap;

/// Corners closer than this share of the scene's diagonal are one.
const WELD: f64 = 1e-6;
/// Surfaces are one where their shading normals agree within 2.6 degrees.
const ALIKE: f64 = 0.999;
/// Places of one edge closer than this, in texels, are no seam.
const SAME_PLACE: f64 = 1e-3;
/// A step that everyone sees.
const VISIBLE: f64 = 25.0 / 255.0;

/// How far the two sides of seams are apart, over all pages.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Seams {
    /// Seam edges.
    pub edges: usize,
    /// Points that were compared.
    pub points: usize,
    /// Root mean square step, weighted by length.
    pub rms: f64,
    /// Largest step.
    pub max: f64,
    /// Share of the length that steps by more than 25/255.
    pub share_visible: f64,
}

/// One triangle's side of an edge.
#[derive(Clone, Copy)]
struct Side {
    page: u32,
    /// Places of the edge's ends, in texels.
    places: [DVec2; 2],
    /// Shading normals at the ends.
    normals: [DVec3; 2],
    ends: [DVec3; 2],
}

/// The steps over every seam at `per_edge` points of each edge, through the bilinear look-up.
///
/// A seam is an edge that two triangles share in space, within rounding, whose shading normals agree at both ends (so
/// that the light on both sides is the same) and whose places on the pages differ. The triangles may be of different
/// objects. Nothing that the baker knows of its charts is used.
pub fn seams(lit: &Lit<'_>, per_edge: u32) -> Seams {
    let mut found = Seams::default();
    let (mut length, mut squares, mut visible) = (0.0, 0.0, 0.0);
    for sides in edges(lit) {
        for (i, a) in sides.iter().enumerate() {
            for b in &sides[i + 1..] {
                if !is_seam(a, b) {
                    continue;
                }
                found.edges += 1;
                let weight = a.ends[0].distance(a.ends[1]) / f64::from(per_edge);
                for k in 0..per_edge {
                    let t = (f64::from(k) + 0.5) / f64::from(per_edge);
                    let value = |s: &Side| lit.diffuse(s.page, s.places[0].lerp(s.places[1], t));
                    let step = (value(a) - value(b)).abs();
                    found.points += 1;
                    found.max = found.max.max(step);
                    length += weight;
                    squares += weight * step * step;
                    visible += if step > VISIBLE { weight } else { 0.0 };
                }
            }
        }
    }
    if length > 0.0 {
        found.rms = (squares / length).sqrt();
        found.share_visible = visible / length;
    }
    found
}

fn is_seam(a: &Side, b: &Side) -> bool {
    let alike = (0..2).all(|k| a.normals[k].dot(b.normals[k]) > ALIKE);
    let apart = a.page != b.page || (0..2).any(|k| a.places[k].distance(b.places[k]) > SAME_PLACE);
    alike && apart
}

/// The sides of every edge that more than one triangle has, in the order of the scene.
fn edges(lit: &Lit<'_>) -> Vec<Vec<Side>> {
    let mut weld = Weld::new(WELD * lit.world.bounds().diagonal());
    let mut known: HashMap<(u32, u32), usize> = HashMap::new();
    let mut all: Vec<Vec<Side>> = Vec::new();
    for (instance, triangle) in lit.triangles() {
        let corners = lit.world.corners(instance, triangle);
        let ids = corners.map(|corner| weld.id(corner));
        let (places, page) = lit.places(instance, triangle);
        let (normals, _) = lit.normals(instance, triangle);
        for k in 0..3 {
            let l = (k + 1) % 3;
            if ids[k] == ids[l] {
                continue;
            }
            let [i, j] = if ids[k] < ids[l] { [k, l] } else { [l, k] };
            let side = Side {
                page,
                places: [places[i], places[j]],
                normals: [normals[i], normals[j]],
                ends: [corners[i], corners[j]],
            };
            let slot = *known.entry((ids[i], ids[j])).or_insert_with(|| {
                all.push(Vec::new());
                all.len() - 1
            });
            all[slot].push(side);
        }
    }
    all.retain(|sides| sides.len() > 1);
    all
}

/// Gives points that lie within a distance of each other the same number.
struct Weld {
    reach: f64,
    points: Vec<DVec3>,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl Weld {
    fn new(reach: f64) -> Self {
        Self {
            reach: reach.max(f64::MIN_POSITIVE),
            points: Vec::new(),
            cells: HashMap::new(),
        }
    }

    fn id(&mut self, point: DVec3) -> u32 {
        let home = (point / self.reach).floor().to_array().map(|c| c as i64);
        for k in 0..27 {
            let cell = [
                home[0] + k % 3 - 1,
                home[1] + k / 3 % 3 - 1,
                home[2] + k / 9 - 1,
            ];
            let near = self.cells.get(&cell).into_iter().flatten();
            for &id in near {
                if self.points[id as usize].distance(point) <= self.reach {
                    return id;
                }
            }
        }
        let id = self.points.len() as u32;
        self.points.push(point);
        self.cells.entry(home).or_default().push(id);
        id
    }
}

#[cfg(test)]
mod tests {
    use super::super::bake::{Lab, Texels};
    use super::super::build::{level, sheet};
    use super::*;
    use layers::Layer;
    use rays::{BackendKind, TreeKind};
    use scene::Scene;

    /// Two abutting squares whose pages are then painted: the left 0.25, the right 0.75.
    #[test]
    fn two_objects_that_abut_step_by_what_their_charts_differ() {
        let left = sheet(
            "left",
            32,
            level([0.0, 1.0], [0.0, 1.0], 0.0),
            [2.0, 2.0, 10.0, 10.0],
        );
        // The shared edge is off by an ulp.
        let edge = 1.0 + f64::from(f32::EPSILON);
        let right = sheet(
            "right",
            32,
            level([edge, 2.0], [0.0, 1.0], 0.0),
            [20.0, 2.0, 28.0, 10.0],
        );
        let up = sheet(
            "up",
            32,
            level([1.0, 2.0], [0.0, 1.0], 1.0),
            [20.0, 20.0, 28.0, 28.0],
        );
        let scene = Scene::from_meshes(vec![left, right, up], Vec::new()).expect("a scene");
        let lab = Lab {
            kind: BackendKind::Obvhs(TreeKind::default()),
            backend: "obvhs",
            rays: 1,
        };
        let mut baked = lab
            .bake("pair", scene, Texels::Authored(32))
            .expect("a bake");
        let page = &mut baked.pages[0];
        let plane = page.planes.iter_mut().find(|p| p.layer == Layer::Diffuse);
        for (texel, value) in plane.expect("diffuse").values.iter_mut().enumerate() {
            *value = if texel % 32 < 16 { 0.25 } else { 0.75 };
        }
        let found = seams(&baked.lit(), 8);
        assert_eq!((found.edges, found.points), (1, 8), "{found:?}");
        assert!((found.max - 0.5).abs() < 1e-6 && (found.rms - 0.5).abs() < 1e-6);
        assert_eq!(found.share_visible, 1.0);
    }
}
