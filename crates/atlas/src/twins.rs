//! Which meshes are one shape: the columns of a hall are written out one by one, and unwrapped once.

use glam::DVec3;
use std::collections::HashMap;

/// Smaller meshes are unwrapped faster than compared.
const WORTH: usize = 100;
/// How far corners of one shape may lie apart, as a share of its size, because files round them. In a chart as wide as
/// a page of 8192 texels this is a twelfth of a texel.
const APART: f64 = 1e-5;

/// The corners of a mesh, as it is unwrapped.
pub(crate) struct Shape<'a> {
    pub triangles: &'a [[u32; 3]],
    pub corners: Vec<DVec3>,
    /// Corners that are one, by the first of them: hard edges are none.
    pub welded: Vec<u32>,
}

/// For each mesh, of which the numbers of vertices and triangles are given, the place of the first one of its shape,
/// which may be itself. `shape` gives what is compared.
pub(crate) fn firsts<'a>(
    sizes: &[[usize; 2]],
    shape: &dyn Fn(usize) -> Option<Shape<'a>>,
) -> Vec<usize> {
    let mut alike: HashMap<[usize; 2], Vec<usize>> = HashMap::new();
    for (i, &size) in sizes.iter().enumerate() {
        if size[1] >= WORTH {
            alike.entry(size).or_default().push(i);
        }
    }
    let mut firsts: Vec<usize> = (0..sizes.len()).collect();
    for group in alike.into_values().filter(|group| group.len() > 1) {
        let mut known: Vec<(usize, Turned)> = Vec::new();
        for i in group {
            let Some(shape) = shape(i) else { continue };
            match known.iter().find(|(_, turned)| turned.matches(&shape)) {
                Some(&(first, _)) => firsts[i] = first,
                None => known.extend(Turned::new(shape).map(|turned| (i, turned))),
            }
        }
    }
    firsts
}

/// A shape with its corners as seen from three of them, which no move and no turn changes.
struct Turned<'a> {
    shape: Shape<'a>,
    base: [u32; 3],
    size: f64,
}

impl<'a> Turned<'a> {
    /// `None` where all corners lie on one line.
    fn new(mut shape: Shape<'a>) -> Option<Self> {
        let used = || shape.triangles.iter().flatten().copied();
        let at = |v: u32| shape.corners[v as usize];
        let farthest = |distance: &dyn Fn(DVec3) -> f64| {
            used().max_by(|&v, &w| distance(at(v)).total_cmp(&distance(at(w))))
        };
        let origin = used().next()?;
        let end = farthest(&|p| p.distance_squared(at(origin)))?;
        let axis = at(end) - at(origin);
        let side = farthest(&|p| axis.cross(p - at(origin)).length_squared())?;
        let base = [origin, end, side];
        let size = axis.length();
        shape.corners = turned(&shape.corners, base)?;
        Some(Self { shape, base, size })
    }

    fn matches(&self, other: &Shape) -> bool {
        let own = &self.shape;
        if own.triangles != other.triangles || own.welded != other.welded {
            return false;
        }
        let near = |(a, b): (&DVec3, &DVec3)| a.distance(*b) <= APART * self.size;
        turned(&other.corners, self.base)
            .is_some_and(|corners| own.corners.iter().zip(&corners).all(near))
    }
}

/// The corners along axes that `base` spans: the first to the second, and to the side of the third.
fn turned(corners: &[DVec3], base: [u32; 3]) -> Option<Vec<DVec3>> {
    let [origin, end, side] = base.map(|v| corners[v as usize]);
    let x = (end - origin).try_normalize()?;
    let z = x.cross(side - origin).try_normalize()?;
    let y = z.cross(x);
    let turn = |p: &DVec3| DVec3::new(x.dot(*p - origin), y.dot(*p - origin), z.dot(*p - origin));
    Some(corners.iter().map(turn).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DQuat};

    /// A bent sheet of 128 triangles that is no mirror image of itself.
    fn sheet() -> (Vec<[u32; 3]>, Vec<DVec3>) {
        let at = |v: u32| f64::from(v);
        let corner = |v: u32| {
            let (x, y) = (at(v % 9), at(v / 9));
            DVec3::new(x, y, 0.1 * x * x + 0.03 * x * y * y)
        };
        let quad = |v: u32| [[v, v + 1, v + 9], [v + 1, v + 10, v + 9]];
        let quads = (0..72).filter(|v| v % 9 < 8);
        (
            quads.flat_map(quad).collect(),
            (0..81).map(corner).collect(),
        )
    }

    type Made<'a> = (&'a dyn Fn(DVec3) -> DVec3, u32);

    /// Which shape each of the sheets is, given what became of its corners and the first of its welded ones.
    fn firsts_of(made: &[Made<'_>]) -> Vec<usize> {
        let (triangles, corners) = sheet();
        let shape = |i: usize| {
            Some(Shape {
                triangles: &triangles,
                corners: corners.iter().map(|&p| made[i].0(p)).collect(),
                welded: vec![made[i].1; corners.len()],
            })
        };
        firsts(&vec![[corners.len(), triangles.len()]; made.len()], &shape)
    }

    #[test]
    fn moved_and_turned_copies_are_one_shape_though_files_round_them() {
        let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 2.0);
        let round = |p: DVec3| (p * 1e5).round() / 1e5;
        let copy = |p: DVec3| round(turn * p + DVec3::new(300.0, -20.0, 7.0));
        assert_eq!(
            firsts_of(&[(&|p| p, 0), (&copy, 0), (&|p| p, 0)]),
            [0, 0, 0]
        );
    }

    #[test]
    fn mirrored_scaled_dented_and_cut_copies_are_others() {
        let mirror = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
        let dent = |p: DVec3| p + DVec3::Z * if p.x == 4.0 && p.y == 4.0 { 1e-3 } else { 0.0 };
        let made: [Made<'_>; 6] = [
            (&|p| p, 0),
            (&|p| mirror * p, 0),
            (&|p| p * 1.001, 0),
            (&dent, 0),
            (&|p| p, 1),
            (&|p| p * 1.001 + DVec3::X, 0),
        ];
        assert_eq!(firsts_of(&made), [0, 1, 2, 3, 4, 2]);
    }

    #[test]
    fn what_has_no_extent_is_like_nothing() {
        let flat = |p: DVec3| DVec3::X * p.x;
        assert_eq!(firsts_of(&[(&flat, 0), (&flat, 0)]), [0, 1]);
    }
}
