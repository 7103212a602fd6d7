//! Which borders are seams of mirrored objects and of files that repeat vertices, and what is counted over pages.

use super::{Across, LIGHTS, Scope, SeamStats, Seams, moved, page, panel, sphere};
use glam::DVec3;
use scene::{Scene, authored};

/// How many points of seams the page of these meshes has.
fn points(meshes: Vec<authored::Mesh>) -> usize {
    let page = page(Scene::from_meshes(meshes, vec![]).unwrap(), LIGHTS[0], 0.0);
    let across = Across::default();
    Seams::find(&page.world, &page.atlas, 0, Scope::Scene, &across)
        .points
        .len()
}

/// The floor at -1 < x < 0, 20 texels along z.
fn floor(at: [f64; 2]) -> authored::Mesh {
    panel(-DVec3::X, DVec3::Z * 2.0, DVec3::X, at)
}

#[test]
fn a_floor_goes_on_in_its_mirror_image() {
    let mut mirrored = floor([2.0, 20.0]);
    mirrored.transform[0][0] = -1.0;
    // Two points a texel.
    assert_eq!(points(vec![floor([2.0, 2.0]), mirrored]), 40);
}

#[test]
fn a_diagonal_whose_vertices_are_repeated_is_no_border() {
    let mut floor = floor([2.0, 2.0]);
    let corners = floor.triangles.concat();
    floor.positions = corners
        .iter()
        .map(|&k| floor.positions[k as usize])
        .collect();
    floor.uvs = corners.iter().map(|&k| floor.uvs[k as usize]).collect();
    floor.triangles = vec![[0, 1, 2], [3, 4, 5]];
    assert_eq!(points(vec![floor]), 0);
}

#[test]
fn pages_add_up_and_the_largest_step_is_that_of_any() {
    let page = |points: u64, step: f64| SeamStats {
        points,
        squares_before: 4.0 * step,
        squares_after: step,
        max_before: 2.0 * step,
        max_after: step,
        squares_moved: 3.0 * step,
    };
    let mut all = SeamStats::default();
    for (points, step) in [(3, 0.25), (5, 0.5), (7, 0.125)] {
        all.append(&page(points, step));
    }
    let expected = SeamStats {
        points: 15,
        squares_before: 3.5,
        squares_after: 0.875,
        max_before: 1.0,
        max_after: 0.5,
        squares_moved: 2.625,
    };
    assert_eq!(all, expected);
}

#[test]
fn steps_that_noise_alone_may_make_are_closed_however_large() {
    let page = page(sphere(false), |_| 0.5, 0.2);
    let stats = moved(&page, &page.values, 0.2, None).stats;
    let rms = (stats.squares_after / stats.points as f64).sqrt();
    // Half a level of a picture of eight bits.
    assert!(stats.max_before > 0.2 && rms <= 0.5 / 255.0, "{stats:?}");
}
