//! How many pages a layout takes, and who has which share of them.

use crate::layouts::{apart, assert_clean, auto, options};
use crate::scenes::{ball, cube, laid_out, mesh, moved, scaled, scene};
use ambake_atlas::{
    Atlas, Error, Options, PageRaster, Pages, SurfacePoint, UvMode, layout, layout_seen,
    roomy_size, triangle_uv,
};
use glam::{DAffine3, Vec2, Vec3};
use scene::Mesh;

#[test]
fn a_density_is_met_on_as_many_pages_as_needed() {
    let copies: Vec<_> = (0..10)
        .map(|i| (0, i, moved(f64::from(i), 0.0, 0.0)))
        .collect();
    let scene = scene(vec![cube()], &copies);
    for mode in [UvMode::Keep, UvMode::Unwrap] {
        let atlas = layout(&scene, &options(mode, 128, Some(32.0)), &|| false).unwrap();
        assert!(atlas.page_count > 1, "{mode:?}: {}", atlas.page_count);
        assert!(
            (atlas.density / 32.0 - 1.0).abs() < 1e-5,
            "{mode:?}: {}",
            atlas.density
        );
        assert_clean(&atlas);
    }
}

#[test]
fn charts_that_one_page_cannot_hold_go_on_more_or_are_refused() {
    let copies: Vec<_> = (0..40)
        .map(|i| (0, i, moved(f64::from(i), 0.0, 0.0)))
        .collect();
    let scene = scene(vec![cube()], &copies);
    for mode in [UvMode::Keep, UvMode::Unwrap] {
        let auto = options(mode, 32, None);
        let atlas = layout(&scene, &auto, &|| false).unwrap();
        assert!(atlas.page_count > 1, "{mode:?}: {}", atlas.page_count);
        assert_clean(&atlas);
        assert!(apart(&scene, &atlas) > 4, "{}", apart(&scene, &atlas));
        let one = Options {
            pages: Pages::Most(1),
            ..auto
        };
        let error = layout(&scene, &one, &|| false).unwrap_err();
        assert!(
            matches!(error, Error::PagesFull { pages: 1, size: 32 }),
            "{error}"
        );
    }
    let error = layout(&scene, &options(UvMode::Unwrap, 16, Some(100.0)), &|| false).unwrap_err();
    assert!(
        matches!(error, Error::ChartTooLarge { size: 16, .. }),
        "{error}"
    );
}

/// So many unit squares in rows of a hundred, none of which touches another.
fn squares(count: u32) -> Mesh {
    let corner = |i: u32| Vec3::new(3.0 * (i % 100) as f32, 3.0 * (i / 100) as f32, 0.0);
    let square =
        |i: u32| [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y].map(|p| p + corner(i));
    let positions = (0..count).flat_map(square).collect();
    let triangles =
        (0..count).flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]);
    mesh("loose", positions, triangles.collect())
}

#[test]
fn a_mesh_that_must_stay_on_one_page_is_refused_where_it_needs_two() {
    // Thirty loose squares of 16 texels: nine on a page of 64 with their gutters.
    let loose = squares(30);
    let one = scene(vec![loose.clone()], &[(0, 0, DAffine3::IDENTITY)]);
    let spread = options(UvMode::Unwrap, 64, Some(16.0));
    let atlas = layout(&one, &spread, &|| false).unwrap();
    assert!(atlas.page_count > 1, "{}", atlas.page_count);
    assert_clean(&atlas);
    let together = Options {
        one_page_per_mesh: true,
        ..spread
    };
    let error = layout(&one, &together, &|| false).unwrap_err();
    assert!(
        matches!(error, Error::PagesFull { size: 64, .. }),
        "{error}"
    );
    // Three meshes that each fit have a page each, and none is on two.
    let halves = Options {
        density: Some(5.0),
        ..together
    };
    let away = |z| moved(0.0, 0.0, z);
    let meshes = vec![loose.clone(), loose.clone(), loose];
    let three = scene(
        meshes,
        &[(0, 0, away(0.0)), (1, 1, away(9.0)), (2, 2, away(18.0))],
    );
    let atlas = layout(&three, &halves, &|| false).unwrap();
    assert_clean(&atlas);
    assert!(atlas.page_count > 1, "{}", atlas.page_count);
    let mut pages = vec![std::collections::BTreeSet::new(); 3];
    for page in 0..atlas.page_count {
        let raster = PageRaster::new(&three, &atlas, page);
        for tile in 0..raster.tiles().len() {
            for piece in &raster.tile(tile).pieces {
                pages[piece.instance as usize].insert(page);
            }
        }
    }
    assert!(pages.iter().all(|on| on.len() == 1), "{pages:?}");
}

#[test]
fn charts_that_nobody_sees_leave_their_texels_to_the_others() {
    let scene = scene(vec![cube()], &[(0, 0, DAffine3::IDENTITY)]);
    let options = options(UvMode::Unwrap, 256, None);
    let area = |atlas: &Atlas, triangle: usize| {
        let layout = &atlas.meshes[0];
        let [a, b, c] = layout.triangles[triangle].map(|v| layout.uvs[v as usize] * 256.0);
        0.5 * (b - a).perp_dot(c - a).abs()
    };
    let whole = layout(&scene, &options, &|| false).unwrap();
    // The first face alone, triangles 0 and 1.
    let seen = |points: &[SurfacePoint]| points[0].triangle < 2;
    let atlas = layout_seen(&scene, &options, Some(&seen), &()).unwrap();
    assert_clean(&atlas);
    assert!(
        area(&atlas, 0) > 3.0 * area(&whole, 0),
        "{} texels",
        area(&atlas, 0)
    );
    for triangle in 2..12 {
        let texels = area(&atlas, triangle);
        assert!(
            texels > 0.0 && texels <= 0.501,
            "triangle {triangle} has {texels} texels"
        );
    }
    // Nothing seen is still a layout.
    let none = layout_seen(&scene, &options, Some(&|_| false), &()).unwrap();
    assert_clean(&none);
}

#[test]
fn an_object_that_nobody_sees_asks_for_no_pages() {
    // A speck in something closed, on a page where it has a quarter of a texel across.
    let ground = scaled(100.0, 100.0, 100.0);
    let scene = scene(
        vec![cube(), cube()],
        &[(0, 0, ground), (1, 1, scaled(0.1, 0.1, 0.1))],
    );
    let options = options(UvMode::Unwrap, 256, None);
    let seen = |points: &[SurfacePoint]| points[0].instance == 0;
    let atlas = layout_seen(&scene, &options, Some(&seen), &()).unwrap();
    assert_clean(&atlas);
    assert_eq!(atlas.page_count, 1);
    // The layout says so, however many texels it took.
    let facts = ambake_atlas::facts(&scene, &atlas);
    let [ground, speck] = &facts.objects[..] else {
        panic!("{facts:?}")
    };
    assert!(ground.density > 0.0 && speck.texels > 0.0, "{facts:?}");
    assert_eq!((speck.density, speck.across), (0.0, 0.0));
    assert_eq!(facts.small_triangles, 0, "none that somebody sees");
}

#[test]
fn page_use_counts_charts_with_their_gutters() {
    let mut square = mesh(
        "square",
        vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    // From 16.64 to 47.36 texels, so that it touches 32 of them.
    let uvs = [(0.26, 0.26), (0.74, 0.26), (0.74, 0.74), (0.26, 0.74)];
    square.uv_sets = vec![uvs.map(|(u, v)| Vec2::new(u, v)).to_vec()];
    let scene = scene(vec![square], &[(0, 0, DAffine3::IDENTITY)]);
    for gutter in [0, 2, 5] {
        let options = Options {
            gutter,
            ..options(UvMode::Keep, 64, None)
        };
        let atlas = layout(&scene, &options, &|| false).unwrap();
        let facts = ambake_atlas::facts(&scene, &atlas);
        let edge = f64::from(32 + 2 * gutter) / 64.0;
        assert!(
            (facts.page_use - edge * edge).abs() < 1e-9,
            "{}",
            facts.page_use
        );
        assert!(
            (facts.covered - 0.48 * 0.48).abs() < 1e-6,
            "{}",
            facts.covered
        );
        let square = &facts.objects[0];
        assert!((square.texels - 30.72 * 30.72).abs() < 0.01 && square.share == 1.0);
        assert!((square.density - 30.72).abs() < 0.01, "{}", square.density);
        assert!((square.across - 30.72).abs() < 0.01, "{}", square.across);
    }
}

#[test]
fn pages_that_would_be_mostly_gutters_become_more() {
    // Ten thousand loose squares: on the fewest pages that take them they would be a texel wide in gutters of four.
    let scene = scene(vec![squares(10_000)], &[(0, 0, DAffine3::IDENTITY)]);
    let atlas = auto(&scene, 256);
    let facts = ambake_atlas::facts(&scene, &atlas);
    assert!(atlas.page_count > 1);
    assert!(
        facts.covered >= 0.25,
        "{} on {} pages",
        facts.covered,
        atlas.page_count
    );
}

#[test]
fn a_roomy_page_leaves_room_for_gutters() {
    let quad = [[8.0, 8.0], [40.0, 8.0], [40.0, 40.0], [8.0, 40.0]];
    let (scene, atlas) = laid_out(&quad, vec![[0, 1, 2], [0, 2, 3]], 64);
    // With a page of edge s the quad has 64 s² / 256 texels, and 5 (2 * 8) s / 16 + 25 about it: more than 0.9 s² in
    // all up to 8.
    assert_eq!(roomy_size(&scene, &atlas), Some(16));
}

#[test]
fn an_object_that_is_left_out_asks_for_no_pages() {
    let scene = scene(
        vec![cube()],
        &[(0, 0, DAffine3::IDENTITY), (0, 1, moved(3.0, 0.0, 0.0))],
    );
    let options = Options {
        exclude: vec!["node 1".into()],
        ..options(UvMode::Unwrap, 128, None)
    };
    let atlas = layout(&scene, &options, &|| false).unwrap();
    assert_clean(&atlas);
    assert_eq!(atlas.page_count, 1);
    assert!(atlas.placements[0].is_somewhere() && !atlas.placements[1].is_somewhere());
}

#[test]
fn what_is_hidden_of_a_scaled_object_counts_by_its_size_in_the_scene() {
    let grown = |by: f32| {
        let mut mesh = cube();
        mesh.positions.iter_mut().for_each(|p| *p *= by);
        mesh
    };
    // Of both cubes the first face alone is seen. With all six they would be held to their share beside so small a
    // ball.
    let densities = |meshes: Vec<Mesh>, cubes: [(u32, f64); 2]| {
        let ball_mesh = meshes.len() as u32;
        let [(large, by), (small, less)] = cubes;
        let placed = [
            (large, 0, scaled(by, by, by)),
            (small, 1, moved(50.0, 0.0, 0.0) * scaled(less, less, less)),
            (ball_mesh, 2, moved(40.0, 0.0, 0.0)),
        ];
        let scene = scene([meshes, vec![ball(16)]].concat(), &placed);
        let seen = |points: &[SurfacePoint]| points[0].instance == 2 || points[0].triangle < 2;
        let options = options(UvMode::Unwrap, 256, None);
        let atlas = layout_seen(&scene, &options, Some(&seen), &()).unwrap();
        assert_clean(&atlas);
        let length = |instance: u32, triangle: u32| {
            let (uv, _) = triangle_uv(&scene, &atlas, instance, triangle);
            f64::from((uv[1] - uv[0]).length()) * 256.0
        };
        [length(0, 0), length(1, 0), length(2, 100)]
    };
    let shared = densities(vec![cube()], [(0, 30.0), (0, 15.0)]);
    let apart = densities(vec![grown(30.0), grown(15.0)], [(0, 1.0), (1, 1.0)]);
    for (shared, apart) in shared.into_iter().zip(apart) {
        assert!(
            (shared / apart - 1.0).abs() < 0.02,
            "{shared} and {apart} texels"
        );
    }
}
