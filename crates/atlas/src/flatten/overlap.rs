//! Triangles of a flat piece that cover one place twice.

use glam::DVec2;

/// Cells of the grid along an edge, at most.
const MOST: f64 = 1024.0;
/// What triangles may share, relative to the piece: the rounding of coordinates.
const ROUNDING: f64 = 1e-9;

/// Pairs of triangles that overlap, `most` at most.
pub(crate) fn overlaps(triangles: &[[DVec2; 3]], most: usize) -> Vec<[usize; 2]> {
    let bounds: Vec<[DVec2; 2]> = triangles
        .iter()
        .map(|[a, b, c]| [a.min(*b).min(*c), a.max(*b).max(*c)])
        .collect();
    let low = bounds.iter().fold(DVec2::INFINITY, |l, b| l.min(b[0]));
    let size = bounds.iter().fold(DVec2::NEG_INFINITY, |h, b| h.max(b[1])) - low;
    let mean = (size.x * size.y / triangles.len() as f64).sqrt();
    let edge = (2.0 * mean).max(size.max_element() / MOST);
    if !(edge > 0.0 && edge.is_finite()) {
        return Vec::new();
    }
    let across = (size / edge).as_uvec2() + 1;
    let cell = |p: DVec2| ((p - low) / edge).as_uvec2().min(across - 1);
    // The triangles of each cell, one cell after the other.
    let cells = |b: &[DVec2; 2]| {
        let (first, last) = (cell(b[0]), cell(b[1]));
        (first.y..=last.y).flat_map(move |y| (first.x..=last.x).map(move |x| y * across.x + x))
    };
    let mut starts = vec![0usize; (across.x * across.y) as usize + 1];
    for b in &bounds {
        cells(b).for_each(|c| starts[c as usize + 1] += 1);
    }
    for c in 1..starts.len() {
        starts[c] += starts[c - 1];
    }
    let mut next = starts.clone();
    let mut held = vec![0u32; starts[starts.len() - 1]];
    for (t, b) in bounds.iter().enumerate() {
        for c in cells(b) {
            held[next[c as usize]] = t as u32;
            next[c as usize] += 1;
        }
    }
    let slack = ROUNDING * size.max_element();
    let mut found = Vec::new();
    for (range, at) in starts.windows(2).zip(0..) {
        let held = &held[range[0]..range[1]];
        for (k, &a) in held.iter().enumerate() {
            for &b in &held[k + 1..] {
                let (a, b) = (a as usize, b as usize);
                let ([a0, a1], [b0, b1]) = (bounds[a], bounds[b]);
                let near = a0.cmplt(b1).all() && b0.cmplt(a1).all();
                // Each pair once: where the part that both boxes share begins.
                let first = || cell(a0.max(b0));
                if near && first().y * across.x + first().x == at {
                    if meet(&triangles[a], &triangles[b], slack) {
                        found.push([a, b]);
                    }
                    if found.len() == most {
                        return found;
                    }
                }
            }
        }
    }
    found
}

/// True where two triangles that turn left share more than a line.
fn meet(a: &[DVec2; 3], b: &[DVec2; 3], slack: f64) -> bool {
    // No line along an edge of one has the other beyond it.
    let parted = |from: &[DVec2; 3], other: &[DVec2; 3]| {
        (0..3).any(|i| {
            let edge = from[(i + 1) % 3] - from[i];
            let most = slack * edge.length();
            other.iter().all(|p| edge.perp_dot(*p - from[i]) <= most)
        })
    };
    !parted(a, b) && !parted(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(count: usize, at: impl Fn(f64, f64) -> DVec2) -> Vec<[DVec2; 3]> {
        let quads = (0..count).map(|i| (i as f64, i as f64 + 1.0));
        quads
            .flat_map(|(a, b)| {
                let [p, q, r, s] = [at(a, 0.0), at(b, 0.0), at(b, 1.0), at(a, 1.0)];
                [[p, q, r], [p, r, s]]
            })
            .collect()
    }

    #[test]
    fn neighbours_share_nothing() {
        let strip = strip(500, |x, y| DVec2::new(0.1 * x, y));
        assert!(overlaps(&strip, 1).is_empty());
    }

    #[test]
    fn a_ring_is_free_until_it_closes() {
        let ring = |x: f64, y: f64| DVec2::from_angle(0.1 * x) * (2.0 - y);
        let two_pi = std::f64::consts::TAU;
        let quads = (two_pi / 0.1) as usize;
        assert!(overlaps(&strip(quads, ring), 1).is_empty());
        let found = overlaps(&strip(quads + 1, ring), 100);
        assert!(!found.is_empty() && found.len() <= 4, "{found:?}");
        for pair in found {
            // The last quad lies on the first.
            assert_eq!(pair.map(|t| t / 2), [0, quads]);
        }
    }

    #[test]
    fn one_triangle_in_another_is_found() {
        let large = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let small = large.map(|p| p * 0.1 + DVec2::splat(0.2));
        assert_eq!(overlaps(&[large, small], 9), [[0, 1]]);
        let beside = small.map(|p| p + DVec2::splat(0.6));
        assert!(overlaps(&[large, beside], 9).is_empty());
    }
}
