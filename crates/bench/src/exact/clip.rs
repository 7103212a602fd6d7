//! The part of a polygon on one side of a plane through the point, and its edges in pieces of a quarter turn.

use glam::DVec3;

/// The part of a polygon with `axis · v >= 0`; empty when nothing lies strictly above.
///
/// I. Sutherland, G. Hodgman, "Reentrant Polygon Clipping", 1974. A polygon that is not convex may come back with
/// pieces joined by double edges; they cancel in every boundary integral.
pub(super) fn above(vertices: &[DVec3], axis: DVec3) -> Vec<DVec3> {
    let height: Vec<f64> = vertices.iter().map(|v| axis.dot(*v)).collect();
    if !height.iter().any(|&h| h > 0.0) {
        return Vec::new();
    }
    let mut kept = Vec::with_capacity(vertices.len() + 2);
    for (i, &b) in vertices.iter().enumerate() {
        let before = (i + vertices.len() - 1) % vertices.len();
        let (a, ha, hb) = (vertices[before], height[before], height[i]);
        if (ha < 0.0) != (hb < 0.0) {
            kept.push((a * hb - b * ha) / (hb - ha));
        }
        if hb >= 0.0 {
            kept.push(b);
        }
    }
    kept
}

/// The edges of a polygon, halved until none fills more than a quarter turn: the plane through a longer edge loses
/// digits as its ends become opposite.
pub(super) fn edges(vertices: &[DVec3]) -> Vec<(DVec3, DVec3)> {
    let mut pieces = Vec::with_capacity(2 * vertices.len());
    let after = vertices.iter().cycle().skip(1);
    for (&a, &b) in vertices.iter().zip(after) {
        halve(a, b, HALVINGS, &mut pieces);
    }
    pieces
}

/// Enough for ends 1e18 times as far as the nearest place of the edge; an edge through the point itself stops here.
pub(super) const HALVINGS: u32 = 60;

fn halve(a: DVec3, b: DVec3, depth: u32, pieces: &mut Vec<(DVec3, DVec3)>) {
    if depth == 0 || a.dot(b) >= 0.0 {
        pieces.push((a, b));
    } else {
        let middle = 0.5 * (a + b);
        halve(a, middle, depth - 1, pieces);
        halve(middle, b, depth - 1, pieces);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_fill_at_most_a_quarter_turn_each() {
        let long = [DVec3::new(-3.0, 1.0, 0.0), DVec3::new(1e9, 1.0, 0.0)];
        let pieces = edges(&long);
        assert!(pieces.iter().all(|(a, b)| a.dot(*b) >= 0.0 && a.y == 1.0));
        assert_eq!(
            (pieces[0].0, pieces[pieces.len() - 1].1),
            (long[0], long[0])
        );
        // Through the point itself: halves at the zero vector, and ends.
        assert_eq!(edges(&[DVec3::X, DVec3::NEG_X]).len(), 4);
    }

    #[test]
    fn clipping_keeps_what_is_above_and_drops_the_coplanar() {
        let square = [(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let flat = square.map(|(x, y)| DVec3::new(x, y, 0.0));
        assert!(above(&flat, DVec3::Z).is_empty());
        let upright = square.map(|(y, z)| DVec3::new(2.0, y, z));
        let half = above(&upright, DVec3::Z);
        assert_eq!(half.len(), 4);
        assert!(half.iter().all(|v| v.z >= 0.0 && v.x == 2.0));
        assert_eq!(above(&upright, DVec3::X), upright);
        assert!(above(&upright, DVec3::NEG_X).is_empty());
    }
}
