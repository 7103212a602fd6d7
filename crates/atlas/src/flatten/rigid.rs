//! A surface laid flat so that each triangle keeps its shape as well as it can (as rigid as possible: Liu, Zhang, Xu,
//! Gotsman and Gortler 2008, section 4).
//!
//! The energy is the sum over triangles of A |J - R|²: A is the area, J the gradient of the flat coordinates, R the
//! rotation nearest to J. It is lowered in turns: the rotations are found for given coordinates, then the coordinates
//! for given rotations. The second is a linear system whose matrix never changes, so it is factored once.

use super::cholesky::{Factor, Symmetric};
use glam::{DVec2, DVec3};

/// Turns that are taken: more change coordinates by less than a hundredth of a triangle on smooth surfaces.
const TURNS: usize = 10;
/// What holds the place of the whole and of corners without area, relative to the mean of the diagonal.
const HOLD: f64 = 1e-9;

/// A triangle in its own plane.
struct Element {
    area: f64,
    /// Gradients of the three corners' hat functions.
    gradients: [DVec2; 3],
}

impl Element {
    /// `None` for a triangle without area.
    fn new([a, b, c]: [DVec3; 3]) -> Option<Self> {
        let (e, f) = (b - a, c - a);
        let (along, twice) = (e.length(), e.cross(f).length());
        let across = twice / along;
        if !(twice > 0.0 && across > 0.0) {
            return None;
        }
        let x = f.dot(e) / along;
        let second = DVec2::new(1.0 / along, -x / twice);
        let third = DVec2::new(0.0, 1.0 / across);
        let gradients = [-second - third, second, third];
        let finite = gradients.iter().all(|g| g.is_finite());
        finite.then_some(Self {
            area: 0.5 * twice,
            gradients,
        })
    }

    /// The rotation nearest to the gradient of `flat`, as its cosine and sine.
    fn rotation(&self, flat: [DVec2; 3]) -> DVec2 {
        let terms = flat.iter().zip(&self.gradients);
        let fit: DVec2 = terms
            .map(|(p, g)| DVec2::new(p.x * g.x + p.y * g.y, p.y * g.x - p.x * g.y))
            .sum();
        fit.try_normalize().unwrap_or(DVec2::X)
    }
}

/// Moves the `flat` places of `corners`, which are connected by `triangles` and face the same way in both. `flat` stays
/// as it is where the triangles give no system that can be solved.
pub(super) fn relax(corners: &[DVec3], triangles: &[[u32; 3]], flat: &mut [DVec2]) {
    let elements: Vec<([usize; 3], Element)> = triangles
        .iter()
        .filter_map(|t| {
            let t = t.map(|v| v as usize);
            Some((t, Element::new(t.map(|v| corners[v]))?))
        })
        .collect();
    let mut diagonal = vec![0.0; corners.len()];
    let mut entries = Vec::with_capacity(3 * elements.len());
    for (t, element) in &elements {
        for i in 0..3 {
            let j = (i + 1) % 3;
            let g = element.gradients;
            diagonal[t[i]] += element.area * g[i].length_squared();
            entries.push((t[i] as u32, t[j] as u32, element.area * g[i].dot(g[j])));
        }
    }
    let hold = HOLD * diagonal.iter().sum::<f64>() / corners.len() as f64;
    diagonal.iter_mut().for_each(|d| *d += hold);
    let Some(factor) = Factor::new(&Symmetric::new(diagonal, &entries), flat) else {
        return;
    };
    drop(entries);
    let mut moved = flat.to_vec();
    for _ in 0..TURNS {
        let mut right: Vec<DVec2> = moved.iter().map(|p| *p * hold).collect();
        for (t, element) in &elements {
            let turn = element.rotation(t.map(|v| moved[v]));
            for (&v, g) in t.iter().zip(element.gradients) {
                // What a rotated triangle's gradient gives: the rotation applied to g.
                right[v] += element.area * turn.rotate(g);
            }
        }
        factor.solve(&mut right);
        moved = right;
    }
    if moved.iter().all(|p| p.is_finite()) {
        flat.copy_from_slice(&moved);
    }
}
