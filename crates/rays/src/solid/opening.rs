//! Openings of surfaces: windows and doors of a room that is modelled as one surface.

use glam::{DVec3, Vec3};
use std::collections::BTreeMap;

/// How far a flat border's corners may lie off its plane, in sizes of the border.
const FLAT: f64 = 1e-3;
/// Nobody looks through an opening at less than this sine of the angle to its plane: at what is let into its wall.
const GRAZING: f64 = 0.1;

/// An opening with a flat border.
#[derive(Debug, Clone)]
pub(super) struct Opening {
    /// Triangles that fill it. Their front faces go with those of the surface.
    pub panes: Vec<[[f32; 3]; 3]>,
    middle: DVec3,
    /// The unit normal of the panes.
    front: DVec3,
    slack: f64,
    /// The box of its border.
    low: DVec3,
    high: DVec3,
}

impl Opening {
    /// What a border encloses whose corners are given in their order; `None` where it is not flat.
    fn of(border: &[Vec3]) -> Option<Self> {
        let middle = border.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / border.len() as f64;
        let next = border.iter().cycle().skip(1);
        let front = (border.iter().zip(next))
            .map(|(a, b)| (a.as_dvec3() - middle).cross(b.as_dvec3() - middle))
            .sum::<DVec3>()
            .try_normalize()?;
        let off = |p: &Vec3| p.as_dvec3() - middle;
        let size = border.iter().map(|p| off(p).length()).fold(0.0, f64::max);
        let slack = FLAT * size;
        let is_flat = border.iter().all(|p| off(p).dot(front).abs() <= slack);
        let fan = border[1..].windows(2);
        let panes = fan.map(|pair| [border[0], pair[0], pair[1]].map(|p| p.to_array()));
        is_flat.then(|| Self {
            panes: panes.collect(),
            middle,
            front,
            slack,
            low: (border.iter()).fold(DVec3::INFINITY, |low, p| low.min(p.as_dvec3())),
            high: (border.iter()).fold(DVec3::NEG_INFINITY, |high, p| high.max(p.as_dvec3())),
        })
    }

    /// The unit normal of the panes: outward where the surface looks outward.
    pub fn front(&self) -> DVec3 {
        self.front
    }

    /// True where its border's box meets this one.
    pub fn meets(&self, low: DVec3, high: DVec3) -> bool {
        self.low.cmple(high).all() && self.high.cmpge(low).all()
    }

    /// True for a point beyond its plane, from the side of the panes' front, and false for one before it; `None` where
    /// it lies in the plane.
    pub fn is_beyond(&self, point: DVec3) -> Option<bool> {
        let beyond = (self.middle - point).dot(self.front);
        (beyond.abs() > self.slack).then_some(beyond > 0.0)
    }

    /// True where one may look through it at a point, from the side of the panes' front: beyond its plane, and not all
    /// but along it.
    pub fn shows(&self, point: DVec3) -> bool {
        let beyond = self.slack - (point - self.middle).dot(self.front);
        let nearest = point.clamp(self.low, self.high);
        beyond > 0.0 && beyond > GRAZING * (point - nearest).length()
    }
}

/// The openings that directed edges run around; `None` where one is not flat. `at` gives the place of a corner.
pub(super) fn openings(edges: &[[u32; 2]], at: impl Fn(u32) -> Vec3) -> Option<Vec<Opening>> {
    let mut onward: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &[from, to] in edges {
        onward.entry(from).or_default().push(to);
    }
    let mut found = Vec::new();
    while let Some((&first, _)) = onward.first_key_value() {
        let mut border = Vec::new();
        let mut corner = first;
        loop {
            let next = onward.get_mut(&corner)?;
            let to = next.pop()?;
            if next.is_empty() {
                onward.remove(&corner);
            }
            border.push(at(corner));
            corner = to;
            if corner == first {
                break;
            }
        }
        found.push(Opening::of(&border)?);
    }
    Some(found)
}

/// Triangles that fill what directed edges run around, flat or not, each loop from its middle. A loop ends where it
/// comes back to one of its corners, so that holes that touch are filled one by one.
pub(super) fn caps(edges: &[[u32; 2]], at: impl Fn(u32) -> Vec3) -> Vec<Vec<[[f32; 3]; 3]>> {
    let mut onward: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &[from, to] in edges {
        onward.entry(from).or_default().push(to);
    }
    let mut found = Vec::new();
    // As many edges end at a corner as start there, so a way ends only where it began.
    while let Some((&first, _)) = onward.first_key_value() {
        let mut way = vec![first];
        while let Some(&corner) = way.last() {
            let Some(next) = onward.get_mut(&corner) else {
                break;
            };
            let to = next.pop();
            if next.is_empty() {
                onward.remove(&corner);
            }
            let Some(to) = to else {
                break;
            };
            let Some(start) = way.iter().position(|&known| known == to) else {
                way.push(to);
                continue;
            };
            found.push(fan(&way[start..], &at));
            way.truncate(start + 1);
        }
    }
    found
}

/// Triangles from the middle of a loop to its edges.
fn fan(border: &[u32], at: impl Fn(u32) -> Vec3) -> Vec<[[f32; 3]; 3]> {
    let border: Vec<Vec3> = border.iter().map(|&corner| at(corner)).collect();
    if let [a, b, c] = border[..] {
        return vec![[a, b, c].map(|p| p.to_array())];
    }
    let sum: DVec3 = border.iter().map(|p| p.as_dvec3()).sum();
    let middle = (sum / border.len() as f64).as_vec3();
    let edges = border.iter().zip(border.iter().cycle().skip(1));
    edges
        .map(|(&a, &b)| [middle, a, b].map(|p| p.to_array()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_looks_out_of_an_opening_from_within_and_not_along_its_wall() {
        let border = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let opening = Opening::of(&border).expect("it is flat");
        let side = opening.front.z;
        assert_eq!(side.abs(), 1.0);
        let shows = |x: f64, depth: f64| opening.shows(DVec3::new(x, 0.5, depth * side));
        assert!(shows(0.5, -0.5) && shows(3.0, -2.0));
        assert!(!shows(0.5, 0.5) && !shows(3.0, 2.0));
        // At a twentieth of the way to its side.
        assert!(!shows(3.0, -0.1));
        let bent = [border[0], border[1], border[2] + Vec3::Z, border[3]];
        assert!(Opening::of(&bent).is_none());
    }
}
