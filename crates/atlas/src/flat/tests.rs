//! Which quads of a wall are one face, and which stay apart.

use super::*;

/// Upright quads of a wall over z = 0 from their lowest to their highest corners, turned in space and about 1 in
/// size.
fn wall(quads: &[[f64; 4]]) -> Welded {
    let turn = glam::DQuat::from_axis_angle(DVec3::new(0.2, 0.3, 1.0).normalize(), 0.31);
    let mut corners: Vec<DVec3> = Vec::new();
    let mut number = |x: f64, y: f64| {
        let at = turn * DVec3::new(x, y, 0.0) / 8.0;
        let known = corners.iter().position(|p| *p == at);
        let number = known.unwrap_or(corners.len());
        if known.is_none() {
            corners.push(at);
        }
        number as u32
    };
    let mut triangles = Vec::new();
    for &[x0, y0, x1, y1] in quads {
        let [a, b] = [number(x0, y0), number(x1, y0)];
        let [c, d] = [number(x1, y1), number(x0, y1)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    Welded::new(corners, triangles.clone(), &triangles)
}

/// Triangles of each loose face, after a look at the lengths of their edges.
fn loose(surface: &Welded) -> Vec<Vec<u32>> {
    let faces = Faces::of(surface);
    for face in &faces.loose {
        for (&t, places) in face.triangles.iter().zip(&face.places) {
            for k in 0..3 {
                let length = places[k].distance(places[(k + 1) % 3]);
                let solid = surface.length(t as usize, k);
                assert!((length - solid).abs() < 1e-6, "{length} {solid}");
            }
            assert_eq!(faces.of[t as usize], face.triangles[0]);
        }
    }
    let triangles = faces.loose.into_iter().map(|face| face.triangles);
    triangles.collect()
}

#[test]
fn a_wall_with_t_junctions_is_one_face_as_it_lies() {
    // Above one quad three, and bricks that share no corner with what they lie on.
    let parts = [
        [0.0, 0.0, 6.0, 2.0],
        [0.0, 2.0, 1.5, 3.0],
        [1.5, 2.0, 4.0, 3.0],
        [4.0, 2.0, 6.0, 3.0],
        [0.5, 3.0, 3.0, 4.0],
    ];
    assert_eq!(loose(&wall(&parts)), [Vec::from_iter(0..10)]);
    // What shares whole edges is left to the unwrapper.
    let grid = [[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 2.0, 1.0]];
    assert!(loose(&wall(&grid)).is_empty());
    let faces = Faces::of(&wall(&grid)).of;
    assert!(faces.iter().all(|&face| face == faces[0]), "{faces:?}");
}

#[test]
fn quads_that_share_an_edge_with_two_more_are_one_face() {
    // The tops of two boxes side by side: their inner sides end at the same edge.
    let mut surface = wall(&[[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 2.0, 1.0]]);
    let normal = surface.normals[0];
    let ends = [1, 2].map(|k| surface.triangles[0][k]);
    let below = ends.map(|end| surface.corners[end as usize] - normal / 8.0);
    let first = surface.corners.len() as u32;
    surface.corners.extend(below);
    let mut triangles = surface.triangles;
    triangles.extend([[ends[1], ends[0], first], [ends[0], ends[1], first + 1]]);
    let surface = Welded::new(surface.corners, triangles.clone(), &triangles);
    assert_eq!(loose(&surface), [Vec::from_iter(0..4)]);
}

#[test]
fn what_lies_over_a_face_is_no_part_of_it() {
    let quads = [
        [0.0, 0.0, 6.0, 2.0],
        [0.0, 2.0, 3.0, 3.0],
        [3.0, 2.0, 6.0, 3.0],
        // Over the second one, from the middle of the first's edge on.
        [1.0, 2.0, 2.0, 2.5],
    ];
    assert_eq!(loose(&wall(&quads)), [Vec::from_iter(0..6)]);
}

#[test]
fn a_frame_that_is_mostly_empty_stays_in_parts() {
    let frame = |wide: f64| {
        [
            [0.0, 0.0, 8.0, wide],
            [0.0, wide, wide, 8.0],
            [8.0 - wide, wide, 8.0, 8.0],
            [2.0 * wide, 8.0 - wide, 8.0 - wide, 8.0],
        ]
    };
    assert_eq!(loose(&wall(&frame(1.0)))[0].len(), 8);
    assert!(loose(&wall(&frame(0.1))).is_empty());
}

#[test]
fn the_narrowest_box_has_a_side_along_the_hull() {
    let turn = DVec2::from_angle(0.4);
    let points = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (0.0, 1.0), (1.0, 0.5)];
    let points = points.map(|(x, y)| turn.rotate(DVec2::new(x, y)));
    let hull = hull(points.to_vec());
    assert_eq!(hull.len(), 4);
    assert!((narrowest(&hull).1 - 3.0).abs() < 1e-12);
}
