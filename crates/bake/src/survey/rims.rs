//! Footprints end where a thin wall cuts a rim off from their surface that is thinner than an eighth of a texel, of
//! a flat sheet a whole one, and begin rays above a thin layer that lies just over them.
//!
//! Such a rim cannot be shown beside the rest, and may see the other side of the wall. So it does not matter
//! whether somebody sees it. What the layer covers is dark, and a texel that its edge crosses cannot show that
//! beside what is not covered. With its rays above the layer it has the light of the surface without the layer.
//! What a closed layer covers is buried, as it would be if that stood on it: footprints end there too.

use atlas::Piece;
use glam::DVec3;
use rays::{Cover, Covers, NUDGE, Patch, Rim, around};

/// The cosine of the angle between a surface and the wall that ends it, at most.
const UPRIGHT: f64 = 0.5;

/// How far before the wall a footprint ends, in tested points' distances from their surfaces: as far as from an edge.
const AWAY: f64 = 8.0;

/// Parts below this share of a piece are rounding.
const LEAST: f64 = 1e-9;

/// Over a piece with more triangles than these its parts are this many times this many for each triangle of it, and
/// their middles tell: exact borders would take a time that grows with the square.
const CROWDED: usize = 8;
const ACROSS: u32 = 4;

/// What may end footprints on a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ends<'a> {
    pub rims: &'a [Rim],
    pub covers: Option<Covers<'a>>,
    /// How far above the surface a layer may lie, in scene units; `None` for [`Rim::THIN`] of a texel.
    pub under: Option<f64>,
}

/// A convex polygon of a triangle, of which rays begin so far above it. Where layers are neither near nor far, several
/// are in one place, with a share each.
struct Part {
    corners: Vec<DVec3>,
    lift: f64,
    share: f64,
}

impl Part {
    /// Triangles that fill it.
    fn split(&self) -> impl Iterator<Item = Part> {
        let fan = self.corners[1..].windows(2);
        fan.flat_map(move |pair| {
            let [a, b, c] = [self.corners[0], pair[0], pair[1]];
            let at = move |i: u32, j: u32| {
                let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(ACROSS));
                a + (b - a) * u + (c - a) * v
            };
            let rows = (0..ACROSS).flat_map(|i| (0..ACROSS - i).map(move |j| [i, j]));
            rows.flat_map(move |[i, j]| {
                let lower = [at(i, j), at(i + 1, j), at(i, j + 1)];
                let upper = [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                let has_upper = i + j + 1 < ACROSS;
                [Some(lower), has_upper.then_some(upper)]
            })
            .flatten()
            .map(|corners| Part {
                corners: corners.to_vec(),
                ..*self
            })
        })
    }
}

impl Ends<'_> {
    /// True where there is nothing.
    pub fn are_none(&self) -> bool {
        self.rims.is_empty() && self.covers.is_none()
    }
}

/// Hands over the parts of a piece of so much area in texels that no rim takes and no closed layer buries, with their
/// areas and with how far above the surface their rays begin. What comes back is the area that is buried.
pub(super) fn without(
    (patch, ends): (&Patch, Ends),
    piece: &Piece,
    area: f64,
    mut take: impl FnMut(&Piece, f64, f64),
) -> f64 {
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
    for rim in ends.rims {
        let is_thin = rim.depth <= rim.most * texel;
        if is_thin && patch.geometric.dot(rim.inward).abs() <= UPRIGHT {
            let reach = whole.iter().map(|&w| at(w).abs().max_element());
            let margin = AWAY * NUDGE * reach.fold(0.0, f64::max);
            left = cut(&left, |w| rim.height(at(w)) - margin);
        }
    }
    let mut buried = if left.len() > 2 { world(&left) } else { 0.0 };
    let mut parts = vec![Part {
        corners: left,
        lift: 0.0,
        share: 1.0,
    }];
    if let Some(covers) = ends.covers.filter(|_| parts[0].corners.len() > 2) {
        let under = ends.under.unwrap_or(Rim::THIN * texel);
        parts = lifted(&covers, patch, parts, under);
    }
    if parts.len() == 1 && parts[0].corners == whole && parts[0].share == 1.0 {
        take(piece, area, parts[0].lift);
        return 0.0;
    }
    for part in &parts {
        let corners = &part.corners;
        for pair in corners.get(1..).unwrap_or_default().windows(2) {
            let corners = [corners[0], pair[0], pair[1]];
            let kept = part.share * world(&corners);
            buried -= kept;
            let share = kept / before;
            if share > LEAST {
                let piece = Piece {
                    square: false,
                    corners,
                    ..*piece
                };
                take(&piece, area * share, part.lift);
            }
        }
    }
    let share = buried / before;
    if share > LEAST { area * share } else { 0.0 }
}

/// Parts of a triangle cut at the borders of the layers over it. Rays begin above those that are at most `under` away.
/// Of twice that and more nothing is lifted, and between the two a share that falls evenly, so that no value jumps
/// where a layer is a little higher. What closed layers would lift is left out.
fn lifted(covers: &Covers, patch: &Patch, mut parts: Vec<Part>, under: f64) -> Vec<Part> {
    let at = |w: DVec3| patch.corners[0] * w.x + patch.corners[1] * w.y + patch.corners[2] * w.z;
    let corners = parts.iter().flat_map(|part| &part.corners).map(|&w| at(w));
    let (low, high) = around(corners);
    let reach = low.abs().max(high.abs()).max_element();
    let over: Vec<_> = covers
        .over(
            (low, high),
            (patch.corners[0], patch.geometric),
            2.0 * under,
        )
        .collect();
    let is_crowded = over.len() > CROWDED;
    if is_crowded {
        parts = parts.iter().flat_map(Part::split).collect();
    }
    for Cover {
        corners: [a, b, c],
        least,
        buries,
    } in over
    {
        let front = (b - a).cross(c - a);
        let steep = front.dot(patch.geometric);
        let height = |w: DVec3| (a - at(w)).dot(front) / steep;
        let beside = |from: DVec3, to: DVec3| {
            let inward = patch.geometric.cross(to - from);
            move |w: DVec3| (at(w) - from).dot(inward)
        };
        let sides: [&dyn Fn(DVec3) -> f64; 5] = [
            &beside(a, b),
            &beside(b, c),
            &beside(c, a),
            &|w| height(w) - least,
            &|w| 2.0 * under - height(w),
        ];
        let mut next = Vec::with_capacity(parts.len());
        for part in parts {
            let middle = part.corners.iter().sum::<DVec3>() / part.corners.len() as f64;
            if is_crowded && sides.iter().any(|side| side(middle) < 0.0) {
                next.push(part);
                continue;
            }
            let mut rest = part.corners.clone();
            let mut left = Vec::new();
            for side in sides.iter().filter(|_| !is_crowded) {
                left.push(cut(&rest, |w| -side(w)));
                rest = cut(&rest, side);
            }
            if rest.len() < 3 {
                next.push(part);
                continue;
            }
            let left = left.into_iter().filter(|corners| corners.len() > 2);
            next.extend(left.map(|corners| Part { corners, ..part }));
            let height = rest.iter().map(|&w| height(w)).fold(0.0, f64::max);
            let share = (2.0 - height / under).clamp(0.0, 1.0);
            let above = Part {
                corners: rest.clone(),
                lift: part.lift.max(height + AWAY * NUDGE * reach),
                share: share * part.share,
            };
            let below = Part {
                corners: rest,
                share: (1.0 - share) * part.share,
                ..part
            };
            let above = Some(above).filter(|_| !buries);
            let both = above.into_iter().chain([below]);
            next.extend(both.filter(|part| part.share > 0.0));
        }
        parts = next;
    }
    parts
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
    use super::super::fixture::patch;
    use super::*;

    #[test]
    fn a_footprint_ends_at_the_wall_that_cuts_a_thin_rim_off() {
        let patch = patch([[0.0, 0.0, 1.0]; 3]);
        // A square from (0, 0) to (0.5, 0.5), and the triangle under its diagonal; eight texels of area.
        for square in [true, false] {
            let piece = Piece {
                instance: 0,
                triangle: 0,
                number: 0,
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
                let ends = Ends {
                    rims,
                    covers: None,
                    under: None,
                };
                without((&patch, ends), &piece, 8.0, |piece, area, _| {
                    let [a, b, c] = piece.corners.map(|w| DVec3::new(w.y, w.z, 0.0));
                    let share = if piece.square { 1.0 } else { 0.5 };
                    world += share * (b - a).cross(c - a).length();
                    parts += area;
                });
                (parts, world)
            };
            let whole = if square { 0.25 } else { 0.125 };
            let wall = |inward: DVec3, at: f64, depth: f64| Rim {
                inward,
                at,
                depth,
                most: 1.0,
            };
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
            // What is wider than a texel, or not upright, cuts nothing off; nothing is left beyond all of it.
            let texel: f64 = if square { 0.177 } else { 0.125 };
            near(left(&[wall(DVec3::X, 0.25, texel - 0.001)]), beyond);
            near(left(&[wall(DVec3::X, 0.25, texel + 0.001)]), 1.0);
            near(left(&[wall(DVec3::new(0.6, 0.0, 0.8), 0.15, 1e-3)]), 1.0);
            near(left(&[wall(DVec3::X, 0.75, 1e-3)]), 0.0);
        }
    }

    /// A world of the unit square's lower half over z = 0, which goes on beyond, and a mark of x and y above 0.25, so far
    /// above it; a closed one where it is so thick.
    fn marked(above: f32, thick: Option<f32>) -> rays::World {
        let mesh = |positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>| {
            let mut mesh = scene::authored::Mesh::default();
            (mesh.positions, mesh.triangles) = (positions, triangles);
            mesh
        };
        let ground = mesh(
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [4.0, 4.0, 0.0]],
            vec![[0, 1, 2], [1, 3, 2]],
        );
        let (a, b) = (0.25, 4.0);
        let corners = |z: f32| [[a, a, z], [b, a, z], [b, b, z], [a, b, z]];
        let top = [[0, 1, 2], [0, 2, 3]];
        let mark = match thick {
            None => mesh(corners(above).to_vec(), top.to_vec()),
            Some(thick) => {
                let sides = (0..4u32).flat_map(|k| {
                    let next = (k + 1) % 4;
                    [[k, k + 4, next + 4], [k, next + 4, next]]
                });
                let bottom = top.map(|[a, b, c]| [a + 4, c + 4, b + 4]);
                let faces = top.into_iter().chain(sides).chain(bottom);
                let positions = [corners(above + thick), corners(above)].concat();
                mesh(positions, faces.collect())
            }
        };
        let scene = scene::Scene::from_meshes(vec![ground, mark], vec![]).unwrap();
        rays::World::new(std::sync::Arc::new(scene), rays::WorldOptions::default()).unwrap()
    }

    /// A texel of half a unit at the origin, of one piece.
    const TEXEL: Piece = Piece {
        instance: 0,
        triangle: 0,
        number: 0,
        square: true,
        corners: [
            DVec3::X,
            DVec3::new(0.5, 0.5, 0.0),
            DVec3::new(0.5, 0.0, 0.5),
        ],
        cumulative: 0.0,
    };

    #[test]
    fn a_footprint_ends_where_a_closed_layer_is_near_however_thick_that_is() {
        for thick in [1e-3, 0.1] {
            // An eighth of the texel is 0.0625.
            for (above, under, share) in [
                (0.06, None, 1.0),
                (1e-5, None, 1.0),
                (0.09375, None, 0.5),
                (0.126, None, 0.0),
                (0.06, Some(0.048), 0.75),
            ] {
                let world = marked(above, Some(thick));
                let patch = Patch::of(&world, &rays::PlaneErrors::of(&world), 0, 0);
                let covers = world.solids().covers(None, (0, 0), || f64::INFINITY);
                let ends = Ends {
                    rims: &[],
                    covers,
                    under,
                };
                let (mut left, mut moment) = (0.0, DVec3::ZERO);
                let buried = without((&patch, ends), &TEXEL, 1.0, |piece, area, lift| {
                    let [a, b, c] = piece.corners;
                    let of = if piece.square {
                        0.5 * (b + c)
                    } else {
                        (a + b + c) / 3.0
                    };
                    assert_eq!(lift, 0.0, "{above} {thick}");
                    left += area;
                    moment += area * DVec3::new(of.y, of.z, 0.0);
                });
                // The mark lies over a quarter of it, about (0.375, 0.375).
                let off = 0.25 * share;
                assert!((buried - off).abs() < 1e-5, "{above} {thick}: {buried}");
                assert!((left - 1.0 + off).abs() < 1e-5, "{above} {thick}: {left}");
                let middle = (0.25 - 0.375 * off) / (1.0 - off);
                let found = moment / left;
                assert!(
                    (found - DVec3::new(middle, middle, 0.0)).length() < 1e-5,
                    "{found}"
                );
            }
        }
    }

    #[test]
    fn rays_begin_above_a_mark_that_lies_over_a_footprint() {
        // A texel is 0.5 wide, of which an eighth is 0.0625. The mark takes a quarter of it, and all that is less than
        // it lies away is lifted; of what lies between once and twice as far, a share that falls evenly.
        for (above, under, share) in [
            (0.06, None, 1.0),
            (0.001, None, 1.0),
            (0.09375, None, 0.5),
            (0.126, None, 0.0),
            (0.06, Some(0.06), 1.0),
            (0.06, Some(0.048), 0.75),
            (0.06, Some(0.04), 0.5),
            (0.06, Some(0.03), 0.0),
        ] {
            let world = marked(above, None);
            let patch = Patch::of(&world, &rays::PlaneErrors::of(&world), 0, 0);
            let covers = world.solids().covers(None, (0, 0), || f64::INFINITY);
            let ends = Ends {
                rims: &[],
                covers,
                under,
            };
            let (mut whole, mut lifted, mut moment) = (0.0, 0.0, DVec3::ZERO);
            without((&patch, ends), &TEXEL, 1.0, |piece, area, lift| {
                let [a, b, c] = piece.corners;
                let middle = if piece.square {
                    0.5 * (b + c)
                } else {
                    (a + b + c) / 3.0
                };
                whole += area;
                if lift > 0.0 {
                    let over = lift - f64::from(above);
                    assert!((0.0..1e-4).contains(&over), "{above}: {lift}");
                    lifted += area;
                    moment += area * DVec3::new(middle.y, middle.z, 0.0);
                }
            });
            assert!((whole - 1.0).abs() < 1e-6, "{above}: {whole}");
            assert!((lifted - 0.25 * share).abs() < 1e-5, "{above}: {lifted}");
            let middle = moment / lifted;
            let expected = DVec3::new(0.375, 0.375, 0.0);
            assert!(share == 0.0 || (middle - expected).length() < 1e-6);
        }
    }
}
