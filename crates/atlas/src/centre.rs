//! Footprints drawn together into one point: what programs bake that sample the centres of texels.

use crate::footprint::{Piece, Tile, barycentric};
use glam::{DVec2, DVec3};

/// Draws each footprint of a tile together into its point nearest to the texel's centre. `corners`: those of a triangle
/// of an instance, in texels of the page.
pub(crate) fn draw_together(tile: &mut Tile, corners: impl Fn(u32, u32) -> [DVec2; 3]) {
    let pieces = std::mem::take(&mut tile.pieces);
    for footprint in &mut tile.footprints {
        let centre = DVec2::new(f64::from(footprint.x) + 0.5, f64::from(footprint.y) + 0.5);
        let own = &pieces[footprint.parts.start as usize..footprint.parts.end as usize];
        let points = own.iter().map(|piece| {
            let page = corners(piece.instance, piece.triangle);
            let at = |w: DVec3| page[0] * w.x + page[1] * w.y + page[2] * w.z;
            let weights = match piece.square {
                true => 0.5 * (piece.corners[1] + piece.corners[2]),
                false => {
                    let share = nearest(piece.corners.map(at), centre);
                    let [a, b, c] = piece.corners;
                    a * share.x + b * share.y + c * share.z
                }
            };
            (at(weights).distance_squared(centre), piece, weights)
        });
        // The first of equals.
        let best = points.reduce(|a, b| if b.0 < a.0 { b } else { a });
        let (_, piece, weights) =
            best.unwrap_or_else(|| unreachable!("a footprint is never empty"));
        let start = tile.pieces.len() as u32;
        tile.pieces.push(Piece {
            square: false,
            corners: [weights; 3],
            cumulative: own[own.len() - 1].cumulative,
            ..*piece
        });
        footprint.parts = start..start + 1;
    }
}

/// Weights of the corners of a triangle at its point nearest to `p`.
fn nearest([a, b, c]: [DVec2; 3], p: DVec2) -> DVec3 {
    if let Some(inside) = barycentric([a, b, c], p)
        && inside.min_element() >= 0.0
    {
        return inside;
    }
    let sides = [(a, b, [0, 1]), (b, c, [1, 2]), (c, a, [2, 0])];
    let on_side = sides.map(|(from, to, ids): (DVec2, DVec2, [usize; 2])| {
        let along = to - from;
        let t = (p - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        let t = t.clamp(0.0, 1.0);
        let mut weights = DVec3::ZERO;
        weights[ids[0]] = 1.0 - t;
        weights[ids[1]] = t;
        ((from + along * t).distance_squared(p), weights)
    });
    let best = on_side
        .into_iter()
        .reduce(|a, b| if b.0 < a.0 { b } else { a });
    best.map_or(DVec3::X, |(_, weights)| weights)
}
