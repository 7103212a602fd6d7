//! Footprints end where a thin wall cuts a rim off from their surface that is thinner than an eighth of a texel.
//!
//! Such a rim cannot be shown beside the rest, and may see the other side of the wall. So it does not matter whether somebody sees it.

use atlas::Piece;
use glam::DVec3;
use rays::{NUDGE, Patch, Rim};

/// The cosine of the angle between a surface and the wall that ends it, at most.
const UPRIGHT: f64 = 0.5;

/// How far before the wall a footprint ends, in tested points' distances from their surfaces: as far as from an edge.
const AWAY: f64 = 8.0;

/// Hands over the parts of a piece of so much area in texels that no rim takes, with their areas.
pub(super) fn without(
    (patch, rims): (&Patch, &[Rim]),
    piece: &Piece,
    area: f64,
    mut take: impl FnMut(&Piece, f64),
) {
    let [a, b, c] = piece.corners;
    let d = b + c - a;
    let whole = if piece.square {
        vec![a, b, d, c]
    } else {
        vec![a, b, c]
    };
    let at = |w: DVec3| patch.corners[0] * w.x + patch.corners[1] * w.y + patch.corners[2] * w.z;
    let world = |corners: &[DVec3]| {
        let first = at(corners[0]);
        let fan = corners[1..].windows(2);
        fan.map(|pair| 0.5 * (at(pair[0]) - first).cross(at(pair[1]) - first).length())
            .sum::<f64>()
    };
    let before = world(&whole);
    let texel = (before / area).sqrt();
    let mut left = whole.clone();
    for rim in rims {
        let is_thin = rim.depth <= Rim::THIN * texel;
        if is_thin && patch.geometric.dot(rim.inward).abs() <= UPRIGHT {
            let reach = whole.iter().map(|&w| at(w).abs().max_element());
            let margin = AWAY * NUDGE * reach.fold(0.0, f64::max);
            left = cut(&left, |w| rim.height(at(w)) - margin);
        }
    }
    if left == whole {
        take(piece, area);
        return;
    }
    for pair in left.get(1..).unwrap_or_default().windows(2) {
        let corners = [left[0], pair[0], pair[1]];
        let share = world(&corners) / before;
        if share > 0.0 {
            let part = Piece {
                square: false,
                corners,
                ..*piece
            };
            take(&part, area * share);
        }
    }
}

/// The part of a convex polygon in which a number that is affine over it is not below 0.
fn cut(polygon: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (k, &from) in polygon.iter().enumerate() {
        let to = polygon[(k + 1) % polygon.len()];
        let heights = [height(from), height(to)];
        if heights[0] >= 0.0 {
            left.push(from);
        }
        if (heights[0] > 0.0 && heights[1] < 0.0) || (heights[0] < 0.0 && heights[1] > 0.0) {
            left.push(from.lerp(to, heights[0] / (heights[0] - heights[1])));
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle of a unit square over z = 0, with these normals.
    fn patch(normals: [[f32; 3]; 3]) -> Patch {
        let mut mesh = scene::authored::Mesh::default();
        mesh.positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        mesh.normals = normals.to_vec();
        mesh.triangles = vec![[0, 1, 2]];
        let scene = scene::Scene::from_meshes(vec![mesh], vec![]).unwrap();
        let world = rays::World::new(std::sync::Arc::new(scene), rays::WorldOptions::default());
        let world = world.unwrap();
        Patch::of(&world, &rays::PlaneErrors::of(&world), 0, 0)
    }

    #[test]
    fn a_footprint_ends_at_the_wall_that_cuts_a_thin_rim_off() {
        let patch = patch([[0.0, 0.0, 1.0]; 3]);
        // A square from (0, 0) to (0.5, 0.5), and the triangle under its diagonal; eight texels of area.
        for square in [true, false] {
            let piece = Piece {
                instance: 0,
                triangle: 0,
                square,
                corners: [
                    DVec3::X,
                    DVec3::new(0.5, 0.5, 0.0),
                    DVec3::new(0.5, 0.0, 0.5),
                ],
                cumulative: 0.0,
            };
            let left = |rims: &[Rim]| {
                let (mut parts, mut world) = (0.0, 0.0);
                without((&patch, rims), &piece, 8.0, |piece, area| {
                    let [a, b, c] = piece.corners.map(|w| DVec3::new(w.y, w.z, 0.0));
                    let share = if piece.square { 1.0 } else { 0.5 };
                    world += share * (b - a).cross(c - a).length();
                    parts += area;
                });
                (parts, world)
            };
            let whole = if square { 0.25 } else { 0.125 };
            let wall = |inward: DVec3, at: f64, depth: f64| Rim { inward, at, depth };
            let near = |found: (f64, f64), share: f64| {
                assert!((found.0 - 8.0 * share).abs() < 1e-4, "{found:?} {share}");
                assert!((found.1 - whole * share).abs() < 1e-4, "{found:?} {share}");
            };
            near(left(&[]), 1.0);
            // x < 0.25 is a rim, or x > 0.25.
            let thin = wall(DVec3::X, 0.25, 1e-3);
            let beyond = if square { 0.5 } else { 0.25 };
            near(left(&[thin]), beyond);
            near(left(&[wall(DVec3::NEG_X, -0.25, 1e-3)]), 1.0 - beyond);
            near(
                left(&[thin, wall(DVec3::Y, 0.25, 1e-3)]),
                if square { 0.25 } else { 0.0 },
            );
            // What is not thin, or not upright, cuts nothing off; nothing is left beyond all of it.
            near(left(&[wall(DVec3::X, 0.25, 0.1)]), 1.0);
            near(left(&[wall(DVec3::new(0.6, 0.0, 0.8), 0.15, 1e-3)]), 1.0);
            near(left(&[wall(DVec3::X, 0.75, 1e-3)]), 0.0);
        }
    }
}
