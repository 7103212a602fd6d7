//! Layouts: kept, repacked, unwrapped.

use crate::scenes::{ball, cube, mesh, moved, scaled, scene};
use ambake_atlas::{Atlas, Error, Options, PageRaster, UvMode, UvSource, Why, layout, layout_seen};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use layers::Progress;
use scene::{Mesh, Scene};
use std::sync::Mutex;

pub fn options(uv: UvMode, page_size: u32, density: Option<f64>) -> Options {
    Options {
        uv,
        page_size,
        density,
        ..Options::default()
    }
}

pub fn auto(scene: &Scene, page_size: u32) -> Atlas {
    layout(scene, &options(UvMode::Auto, page_size, None), &|| false).unwrap()
}

/// Nothing overlaps, is missing or lies outside.
pub fn assert_clean(atlas: &Atlas) {
    let a = atlas.audit;
    assert_eq!((a.overlaps, a.missing, a.outside), (0, 0, 0), "{a:?}");
    assert!(a.texels > 0);
}

/// Smallest Chebyshev distance, in texels, between texels of different objects.
pub fn apart(scene: &Scene, atlas: &Atlas) -> i64 {
    let size = atlas.page_size as usize;
    let mut least = i64::MAX;
    for page in 0..atlas.page_count {
        let raster = PageRaster::new(scene, atlas, page);
        let mut owner = vec![u32::MAX; size * size];
        for i in 0..raster.tiles().len() {
            let tile = raster.tile(i);
            for f in &tile.footprints {
                owner[f.y as usize * size + f.x as usize] = tile.pieces_of(f)[0].instance;
            }
        }
        for y in 0..size as i64 {
            for x in 0..size as i64 {
                let mine = owner[(y * size as i64 + x) as usize];
                for dy in -6..=6i64 {
                    for dx in -6..=6i64 {
                        let (u, v) = (x + dx, y + dy);
                        let on = 0..size as i64;
                        if mine == u32::MAX || !on.contains(&u) || !on.contains(&v) {
                            continue;
                        }
                        let other = owner[(v * size as i64 + u) as usize];
                        if other != u32::MAX && other != mine {
                            least = least.min(dx.abs().max(dy.abs()));
                        }
                    }
                }
            }
        }
    }
    least
}

#[test]
fn a_usable_set_is_kept_as_it_stands() {
    let cube = cube();
    let uvs = cube.uv_sets[0].clone();
    let scene = scene(vec![cube], &[(0, 0, DAffine3::IDENTITY)]);
    let atlas = auto(&scene, 128);
    assert_eq!(atlas.source, UvSource::Kept { set: 0 });
    assert_eq!(atlas.meshes[0].uvs, uvs);
    assert!(atlas.notes.is_empty());
    assert_eq!(atlas.chart_count, 6);
    assert_clean(&atlas);
    // Every face of area 1 takes 0.3 by 0.45 of 128 texels.
    let expected = (0.3f64 * 0.45).sqrt() * 128.0;
    assert!(
        (atlas.density / expected - 1.0).abs() < 1e-6,
        "{}",
        atlas.density
    );
}

#[test]
fn charts_of_a_file_that_touch_are_told_of_and_gaps_are_not() {
    let of = |cube: Mesh| {
        let scene = scene(vec![cube], &[(0, 0, DAffine3::IDENTITY)]);
        let atlas = layout(&scene, &options(UvMode::Keep, 96, None), &|| false).unwrap();
        assert_eq!(atlas.source, UvSource::Kept { set: 0 });
        ambake_atlas::touching(&scene, &atlas)
    };
    assert_eq!(of(cube()), None);
    // Along two lines down the page and one across, which are borders of tiles too, a texel on either side has a
    // neighbour of another face, those in the corners twice.
    let count = 2 * (2 * 96 + 96) - 4 * 2;
    assert_eq!(of(crowded_cube()), Some((count, 0)));
}

/// A cube of which each face fills its sixth of the page: of 96 texels 32 x 48.
pub fn crowded_cube() -> Mesh {
    let mut full = cube();
    for (k, uv) in full.uv_sets[0].iter_mut().enumerate() {
        let [column, row] = [k / 4 % 3, k / 12].map(|cell| cell as f32);
        let [right, up] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][k % 4];
        *uv = Vec2::new((column + right) / 3.0, (row + up) / 2.0);
    }
    full
}

#[test]
fn charts_of_a_file_that_touch_are_packed_apart_in_their_own_shapes() {
    let places = [(0, 0, DAffine3::IDENTITY), (0, 1, moved(3.0, 0.0, 0.0))];
    for places in [&places[..1], &places] {
        let scene = scene(vec![crowded_cube()], places);
        let atlas = auto(&scene, 128);
        assert_eq!(
            atlas.source,
            UvSource::Apart { set: 0 },
            "{:?}",
            atlas.notes
        );
        assert!(atlas.notes[0].contains("packed apart"), "{:?}", atlas.notes);
        assert_clean(&atlas);
        assert_eq!(ambake_atlas::touching(&scene, &atlas), None);
        assert_eq!(atlas.chart_count, 6);
        // Faces of 2 by 3, of one size, as they stand or turned.
        let (own, scale) = (&atlas.meshes[0], Vec2::from(atlas.placements[0].scale));
        let at = |v: u32| own.uvs[v as usize] * scale;
        let side = |a: u32, b: u32| at(a).distance(at(b));
        for face in own.triangles.chunks(2) {
            let [a, b, c] = face[0];
            let mut sides = [side(a, b), side(b, c)];
            sides.sort_by(f32::total_cmp);
            assert!((sides[1] / sides[0] - 1.5).abs() < 1e-4, "{sides:?}");
        }
    }
}

/// The sharp end of a leaf in the coordinates of its author: of two triangles with a common edge one is the other way
/// round. They overlap by less than a texel of his page, and by many where they are packed as they lie.
#[test]
fn what_overlaps_where_it_is_packed_apart_is_unwrapped() {
    let positions = [
        [-0.0492, -4.9701, 0.9952],
        [-0.0451, -4.9936, 0.9935],
        [-0.0492, -4.9936, 0.9952],
        [-0.0451, -4.9701, 0.9935],
        [-0.0409, -4.9701, 0.9952],
        [-0.0409, -4.9936, 0.9952],
        [-0.0392, -4.9936, 0.9994],
    ];
    let texels = [
        [1.371, 1.462],
        [0.872, 1.641],
        [0.836, 1.525],
        [1.479, 1.451],
        [1.477, 1.344],
        [1.302, 0.747],
        [1.143, 0.819],
    ];
    let mut leaf = mesh(
        "leaf",
        positions.map(Vec3::from).to_vec(),
        vec![[0, 1, 2], [3, 4, 5], [4, 6, 5]],
    );
    let uv = |[u, v]: [f32; 2]| (Vec2::new(11.0, 14.0) + Vec2::new(u, v)) / 512.0;
    leaf.uv_sets = vec![texels.map(uv).to_vec()];
    let scene = scene(vec![leaf], &[(0, 0, DAffine3::IDENTITY)]);
    let atlas = auto(&scene, 512);
    assert_eq!(atlas.source, UvSource::Unwrapped, "{:?}", atlas.notes);
    assert!(atlas.notes[0].contains("overlap"), "{:?}", atlas.notes);
    assert_clean(&atlas);
}

#[test]
fn the_second_set_goes_before_the_first() {
    let mut cube = cube();
    cube.uv_sets.insert(0, vec![Vec2::splat(7.0); 24]);
    let scene = scene(vec![cube], &[(0, 0, DAffine3::IDENTITY)]);
    assert_eq!(auto(&scene, 128).source, UvSource::Kept { set: 1 });
}

#[test]
fn objects_that_share_the_square_get_rectangles_of_their_own() {
    let scene = scene(
        vec![cube()],
        &[
            (0, 0, DAffine3::IDENTITY),
            (0, 1, moved(3.0, 0.0, 0.0)),
            (0, 2, scaled(2.0, -2.0, 2.0)),
            (0, 3, moved(6.0, 0.0, 0.0)),
        ],
    );
    for mode in [UvMode::Auto, UvMode::Keep] {
        let atlas = layout(&scene, &options(mode, 256, None), &|| false).unwrap();
        assert_eq!(atlas.source, UvSource::Repacked { set: 0 });
        assert_clean(&atlas);
        assert!(apart(&scene, &atlas) > 4, "{}", apart(&scene, &atlas));
        let edge = |i: usize| atlas.placements[i].scale[0];
        assert!(
            (edge(2) / edge(0) - 2.0).abs() < 1e-6,
            "{:?}",
            atlas.placements
        );
        assert_eq!(atlas.notes.len(), 1);
    }
}

#[test]
fn keep_names_the_mesh_the_set_and_the_count() {
    let fails =
        |scene: &Scene| layout(scene, &options(UvMode::Keep, 144, None), &|| false).unwrap_err();
    let one = |mesh| scene(vec![mesh], &[(0, 0, DAffine3::IDENTITY)]);
    let unusable = |why| {
        let mesh = "cube".into();
        Error::Unusable { mesh, set: 0, why }
    };
    let mut none = cube();
    none.uv_sets.clear();
    assert_eq!(fails(&one(none)), unusable(Why::Absent));

    let mut outside = cube();
    outside.uv_sets[0][3].x = 1.5;
    outside.uv_sets[0][4].y = f32::NAN;
    assert_eq!(fails(&one(outside)), unusable(Why::Outside(2)));

    let mut flat = cube();
    flat.uv_sets[0][1] = flat.uv_sets[0][0];
    assert_eq!(fails(&one(flat)), unusable(Why::NoArea(1)));

    // One face on another; the page has 144 texels, so that a face has 43.2 x 64.8 and no border meets a sample point.
    let mut stacked = cube();
    for v in 0..4 {
        stacked.uv_sets[0][v] = stacked.uv_sets[0][v + 4];
    }
    let points = match fails(&one(stacked)) {
        Error::Unusable {
            why: Why::Overlap { points, size: 144 },
            ..
        } => points,
        other => panic!("{other}"),
    };
    // 172 or 173 columns and 259 rows of points, less those on the diagonal.
    assert!((172 * 258..=173 * 260).contains(&points), "{points}");

    let mut crowded = cube();
    for face in crowded.uv_sets[0].chunks_mut(4) {
        face.copy_from_slice(&[Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    }
    let error = fails(&one(crowded));
    assert_eq!(error, unusable(Why::Crowded(6.0)));
    assert_eq!(
        error.to_string(),
        "mesh `cube`: TEXCOORD_0 covers its page 6.00 times: use `--uv auto` or `--uv unwrap`"
    );
}

#[test]
fn a_ball_is_unwrapped_with_clear_gutters() {
    let scene = scene(
        vec![ball(24), cube()],
        &[(0, 0, DAffine3::IDENTITY), (1, 1, scaled(1.0, 0.1, 5.0))],
    );
    let atlas = layout(&scene, &options(UvMode::Unwrap, 256, None), &|| false).unwrap();
    assert_eq!(atlas.source, UvSource::Unwrapped);
    assert_eq!((atlas.page_count, atlas.page_size), (1, 256));
    assert_clean(&atlas);
    assert!(apart(&scene, &atlas) > 4, "{}", apart(&scene, &atlas));
    let layout = &atlas.meshes[0];
    for (made, given) in layout.triangles.iter().zip(&scene.meshes[0].triangles) {
        assert_eq!(made.map(|v| layout.source_vertices[v as usize]), *given);
    }
}

#[test]
fn instances_share_charts_and_own_their_rectangles() {
    let mut copies: Vec<_> = (0..10)
        .map(|i| (0, i, moved(f64::from(i) * 3.0, 0.0, 0.0)))
        .collect();
    copies.push((0, 10, scaled(-2.0, 2.0, 2.0)));
    copies.push((0, 11, scaled(1.0, 1.0, 0.1)));
    let scene = scene(vec![ball(8)], &copies);
    let atlas = auto(&scene, 256);
    assert_eq!(atlas.source, UvSource::Unwrapped);
    assert_eq!(atlas.meshes.len(), 1);
    assert_eq!(atlas.placements.len(), 12);
    assert_clean(&atlas);
    assert!(apart(&scene, &atlas) > 4, "{}", apart(&scene, &atlas));
    let edge = |i: usize| atlas.placements[i].scale[0];
    assert!(
        (edge(10) / edge(0) - 2.0).abs() < 1e-3,
        "{} {}",
        edge(10),
        edge(0)
    );
}

#[test]
fn instances_of_very_different_size_share_a_page() {
    let grown = |i: i32| 10f64.powf(f64::from(i) / 10.0 - 1.0);
    let copies: Vec<_> = (0..20u32)
        .map(|i| {
            (
                0,
                i,
                scaled(grown(i as i32), grown(i as i32), grown(i as i32)),
            )
        })
        .collect();
    let scene = scene(vec![ball(12)], &copies);
    let atlas = auto(&scene, 256);
    assert_clean(&atlas);
    assert!(apart(&scene, &atlas) > 4, "{}", apart(&scene, &atlas));
}

#[test]
fn one_small_copy_takes_no_texels_from_the_others() {
    let density = |sizes: &[f64]| {
        let copies: Vec<_> = (0..)
            .zip(sizes)
            .map(|(i, &size)| (0, i, scaled(size, size, size)))
            .collect();
        let scene = scene(vec![ball(12)], &copies);
        f64::from(auto(&scene, 256).placements[0].scale[0])
    };
    let alike = density(&[1.0; 8]);
    for small in [0.3, 0.1, 0.01, 1e-6, 1e-19] {
        let mut sizes = [1.0; 8];
        sizes[7] = small;
        let found = density(&sizes);
        assert!(found > 0.97 * alike, "{small}: {found} for {alike}");
    }
}

#[test]
fn triangles_too_thin_to_unwrap_are_not_missing() {
    let mut ball = ball(12);
    let n = ball.positions.len() as u32;
    // A sliver with a neighbour, and one that stands alone.
    ball.positions
        .push(ball.positions[2] + Vec3::new(1e-7, 1e-7, 0.0));
    ball.positions.extend([
        Vec3::new(3.0, 0.0, 0.0),
        Vec3::new(3.0, 1.0, 0.0),
        Vec3::new(3.0, 0.5, 1e-7),
    ]);
    ball.triangles.extend([[2, 3, n], [n + 1, n + 2, n + 3]]);
    // A cube so small beside a ground so large that 32 bits would flatten it at one density.
    let ground = mesh(
        "ground",
        [
            [-5e3, 0.0, -5e3],
            [5e3, 0.0, -5e3],
            [5e3, 0.0, 5e3],
            [-5e3, 0.0, 5e3],
        ]
        .map(Vec3::from)
        .to_vec(),
        vec![[0, 2, 1], [0, 3, 2]],
    );
    let thin = scene(vec![ball], &[(0, 0, DAffine3::IDENTITY)]);
    let small = scene(
        vec![ground, cube()],
        &[(0, 0, DAffine3::IDENTITY), (1, 1, scaled(1e-4, 1e-4, 1e-4))],
    );
    for (scene, specks) in [(thin, 2), (small, 0)] {
        let atlas = layout(&scene, &options(UvMode::Unwrap, 256, None), &|| false).unwrap();
        assert_clean(&atlas);
        assert_eq!(atlas.audit.specks, specks, "{:?}", atlas.audit);
        // Each triangle has a piece somewhere.
        let mut seen: Vec<Vec<bool>> = scene
            .meshes
            .iter()
            .map(|m| vec![false; m.triangles.len()])
            .collect();
        let raster = PageRaster::new(&scene, &atlas, 0);
        for i in 0..raster.tiles().len() {
            for piece in raster.tile(i).pieces {
                seen[scene.instances[piece.instance as usize].mesh as usize]
                    [piece.triangle as usize] = true;
            }
        }
        assert!(seen.iter().flatten().all(|&s| s));
    }
}

#[test]
fn bad_options_and_cancelling_are_errors() {
    let scene = scene(vec![cube()], &[(0, 0, DAffine3::IDENTITY)]);
    let run = |size, density, stop: bool| {
        layout(&scene, &options(UvMode::Unwrap, size, density), &|| stop).unwrap_err()
    };
    assert_eq!(run(0, None, false), Error::PageSize(0));
    assert_eq!(run(20_000, None, false), Error::PageSize(20_000));
    assert_eq!(run(64, Some(0.0), false), Error::Density(0.0));
    assert_eq!(run(64, None, true), Error::Cancelled);
    let empty = crate::scenes::scene(vec![cube()], &[]);
    let error = layout(&empty, &options(UvMode::Auto, 64, None), &|| false).unwrap_err();
    assert_eq!(error, Error::Empty);
}

#[test]
fn a_listener_hears_of_every_triangle_of_distinct_meshes() {
    #[derive(Default)]
    struct Heard(Mutex<Vec<(String, u64, u64)>>);
    impl Progress for Heard {
        fn phase(&self, name: &str) {
            self.0.lock().unwrap().push((name.into(), 0, 0));
        }
        fn advance(&self, done: u64, total: u64) {
            let mut heard = self.0.lock().unwrap();
            let last = heard.last_mut().expect("a phase comes before its work");
            assert!(done <= total, "{done} of {total}");
            (last.1, last.2) = (last.1.max(done), total);
        }
    }
    let (ball, cube) = (ball(32), cube());
    let triangles = (ball.triangles.len() + cube.triangles.len()) as u64;
    let scene = scene(
        vec![ball, cube],
        &[
            (0, 0, DAffine3::IDENTITY),
            (1, 1, DAffine3::IDENTITY),
            (1, 1, DAffine3::from_translation(DVec3::X)),
        ],
    );
    let heard = Heard::default();
    layout_seen(&scene, &options(UvMode::Unwrap, 256, None), None, &heard).unwrap();
    let heard = heard.0.into_inner().unwrap();
    let expected = [("making charts", triangles), ("packing charts", 0)];
    assert_eq!(heard, expected.map(|(name, all)| (name.into(), all, all)));
}

#[test]
fn a_layout_is_the_same_at_any_thread_count() {
    let scene = scene(
        vec![ball(32), cube()],
        &[(0, 0, DAffine3::IDENTITY), (1, 1, DAffine3::IDENTITY)],
    );
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| layout(&scene, &options(UvMode::Unwrap, 256, None), &|| false).unwrap())
    };
    let (one, three) = (with(1), with(3));
    assert_eq!(one.audit, three.audit);
    for (a, b) in one.meshes.iter().zip(&three.meshes) {
        assert_eq!(a.uvs, b.uvs);
        assert_eq!(a.triangles, b.triangles);
    }
}
