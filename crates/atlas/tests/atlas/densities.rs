//! How far apart the densities of objects are: a factor of four at most.

use crate::layouts::{assert_clean, crowded_cube, options};
use crate::scenes::{cube, moved, scaled, scene};
use ambake_atlas::{Atlas, Options, SurfacePoint, UvMode, UvSource, facts, layout_seen};
use scene::Scene;

/// How many times the least density the greatest is, over objects of 16 texels or more.
fn apart(scene: &Scene, atlas: &Atlas) -> f64 {
    let facts = facts(scene, atlas);
    let counted = facts.objects.iter().filter(|o| o.texels >= 16.0);
    let densities = || counted.clone().map(|o| o.density);
    densities().fold(0.0, f64::max) / densities().fold(f64::INFINITY, f64::min)
}

#[test]
fn what_nobody_sees_of_a_file_s_charts_takes_nothing_from_the_rest() {
    // A floor, a thin wall on it whose lower end and one side touch others, and a small box: each face has a sixth of
    // the coordinates, so what is hidden of the wall is a third of them and a twentieth of its surface.
    let places = [
        scaled(18.0, 0.1, 10.0),
        moved(4.0, 0.1, 1.0) * scaled(0.15, 3.0, 3.0),
        moved(9.0, 0.1, 1.0) * scaled(0.3, 0.3, 0.3),
    ];
    let is_seen = |points: &[SurfacePoint]| {
        let [point, ..] = points else { return true };
        point.instance != 1 || ![4, 5, 8, 9].contains(&point.triangle)
    };
    let alone = scene(
        vec![crowded_cube(); 3],
        &[(0, 0, places[0]), (1, 1, places[1]), (2, 2, places[2])],
    );
    let options = options(UvMode::Auto, 512, None);
    let atlas = layout_seen(&alone, &options, Some(&is_seen), &()).unwrap();
    assert_eq!(atlas.source, UvSource::Apart { set: 0 });
    assert_clean(&atlas);
    assert!(atlas.meshes[1].hidden.contains(&true));
    let times = apart(&alone, &atlas);
    assert!(times <= 4.001, "{times} times apart");
    // Copies of one mesh with a thin edge each, of which the same two faces are hidden: narrow ones of the first, a
    // wide one of the second.
    let places = [places[1], moved(9.0, 0.1, 1.0) * scaled(3.0, 0.15, 3.0)];
    let copies = scene(
        vec![crowded_cube()],
        &[(0, 0, places[0]), (0, 1, places[1])],
    );
    let is_seen = |points: &[SurfacePoint]| ![4, 5, 8, 9].contains(&points[0].triangle);
    let atlas = layout_seen(&copies, &options, Some(&is_seen), &()).unwrap();
    assert_clean(&atlas);
    let times = apart(&copies, &atlas);
    assert!(times <= 1.001, "{times} times apart as copies");
}

#[test]
fn a_copy_is_as_fine_as_it_would_be_without_the_larger_ones() {
    let places = [0.3, 0.29, 0.27, 0.25]
        .map(|edge| moved(edge * 100.0, 1.0, 0.0) * scaled(edge, edge, edge));
    let mut instances = vec![(0, 0, scaled(18.0, 0.1, 10.0))];
    instances.extend((1..).zip(places).map(|(node, place)| (1, node, place)));
    let scene = scene(vec![cube(), cube()], &instances);
    for even in [false, true] {
        let options = Options {
            even,
            ..options(UvMode::Unwrap, 512, None)
        };
        let atlas = layout_seen(&scene, &options, None, &()).unwrap();
        assert_clean(&atlas);
        let (times, most) = (apart(&scene, &atlas), if even { 1.0 } else { 4.0 });
        assert!(times <= 1.0001 * most, "{times} times apart, even: {even}");
    }
}
