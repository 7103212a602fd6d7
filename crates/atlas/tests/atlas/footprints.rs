//! Area-true texel footprints.

use crate::scenes::laid_out;
use ambake_atlas::{
    Atlas, Footprint, Options, PageRaster, SurfacePoint, Tile, UvMode, layout, triangle_uv,
};
use glam::DVec2;
use scene::Scene;

/// Every tile of page 0.
fn tiles(scene: &Scene, atlas: &Atlas) -> Vec<Tile> {
    let raster = PageRaster::new(scene, atlas, 0);
    (0..raster.tiles().len()).map(|i| raster.tile(i)).collect()
}

/// Area in texels of all triangles.
fn exact_area(scene: &Scene, atlas: &Atlas) -> f64 {
    let size = f64::from(atlas.page_size);
    let area = |t: u32| {
        let (uv, _) = triangle_uv(scene, atlas, 0, t);
        let [a, b, c] = uv.map(|v| v.as_dvec2() * size);
        0.5 * (b - a).perp_dot(c - a).abs()
    };
    (0..scene.meshes[0].triangles.len() as u32).map(area).sum()
}

fn covered(tiles: &[Tile]) -> f64 {
    let area = |t: &Tile| t.footprints.iter().map(|f| t.area(f)).sum::<f64>();
    tiles.iter().map(area).sum()
}

/// Position on the page, in texels, of a sample.
fn position(scene: &Scene, atlas: &Atlas, point: &SurfacePoint) -> DVec2 {
    let (uv, _) = triangle_uv(scene, atlas, point.instance, point.triangle);
    let corners = uv.map(|v| v.as_dvec2() * f64::from(atlas.page_size));
    (0..3).map(|k| corners[k] * point.weights[k]).sum()
}

/// Deterministic numbers in 0..1 (splitmix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Every sample lies in its texel's square and in its triangle, up to the rounding of positions of this size.
fn samples_stay_inside(scene: &Scene, atlas: &Atlas, tile: &Tile, footprint: &Footprint) {
    let slack = 1e-9;
    for u in [0.0, 0.25, 0.5, 0.75, 1.0 - f64::EPSILON] {
        for v in [0.0, 0.3, 0.6, 1.0 - f64::EPSILON] {
            let point = tile.sample(footprint, [u, v]);
            assert!(point.weights.iter().all(|&w| w >= 0.0), "{point:?}");
            let sum: f64 = point.weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-14, "weights sum to {sum}");
            let p = position(scene, atlas, &point);
            let d = p - DVec2::new(f64::from(footprint.x), f64::from(footprint.y));
            assert!(
                d.min_element() >= -slack && d.max_element() <= 1.0 + slack,
                "{p} is outside texel {} {}",
                footprint.x,
                footprint.y
            );
        }
    }
}

/// A random mesh without overlaps: a jittered grid of `n * n` quads over a part of the page.
fn jittered_grid(n: u32, low: f64, high: f64, size: u32) -> (Scene, Atlas) {
    let mut numbers = Numbers(1);
    let step = (high - low) / f64::from(n);
    let mut points = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let inside = i % n != 0 && j % n != 0;
            let room = if inside { 0.4 * step } else { 0.0 };
            let mut jitter = || (numbers.next() - 0.5) * room;
            points.push([
                low + f64::from(i) * step + jitter(),
                low + f64::from(j) * step + jitter(),
            ]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            triangles.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
    }
    laid_out(&points, triangles, size)
}

#[test]
fn coverage_sums_to_the_area_of_the_triangles() {
    for (n, size) in [(3, 64), (40, 64), (200, 128)] {
        let (scene, atlas) = jittered_grid(n, 3.1, f64::from(size) - 3.7, size);
        let tiles = tiles(&scene, &atlas);
        let (exact, sum) = (exact_area(&scene, &atlas), covered(&tiles));
        assert!((sum / exact - 1.0).abs() < 1e-9, "{n}: {sum} for {exact}");
        for tile in &tiles {
            for f in &tile.footprints {
                assert!(f.coverage > 0.0 && f.coverage <= 1.0, "{f:?}");
                assert!(tile.area(f) <= 1.0 + 1e-9, "{} in {f:?}", tile.area(f));
                samples_stay_inside(&scene, &atlas, tile, f);
            }
        }
    }
}

#[test]
fn the_middle_of_a_whole_texel_is_its_centre_to_the_last_bit() {
    let mut whole = 0;
    for (n, size) in [(1, 64), (3, 64), (40, 64), (200, 128)] {
        let (scene, atlas) = jittered_grid(n, 3.1, f64::from(size) - 3.7, size);
        let raster = PageRaster::new(&scene, &atlas, 0);
        for tile in (0..raster.tiles().len()).map(|index| raster.tile(index)) {
            let [low, high] = [4, size - 4];
            let inner = |f: &&Footprint| (low..high).contains(&f.x) && (low..high).contains(&f.y);
            for f in tile.footprints.iter().filter(inner) {
                let centre = DVec2::new(f64::from(f.x) + 0.5, f64::from(f.y) + 0.5);
                assert_eq!(raster.middle(&tile, f), centre, "{n}: {f:?}");
                whole += 1;
            }
        }
    }
    assert_eq!(whole, 3 * 56 * 56 + 120 * 120);
}

/// The audit counts by sample points where it can, and cuts the rest.
#[test]
fn the_audit_counts_as_many_texels_as_there_are_footprints() {
    for (n, size) in [(1, 64), (9, 64), (90, 128), (150, 64)] {
        let (mut scene, atlas) = jittered_grid(n, 3.1, f64::from(size) - 3.7, size);
        scene.meshes[0].uv_sets = vec![atlas.meshes[0].uvs.clone()];
        let options = Options {
            page_size: size,
            uv: UvMode::Keep,
            ..Options::default()
        };
        let atlas = layout(&scene, &options, &|| false).expect("a usable set");
        let tiles = tiles(&scene, &atlas);
        let footprints: usize = tiles.iter().map(|tile| tile.footprints.len()).sum();
        assert_eq!(atlas.audit.texels, footprints as u64, "{n}");
    }
}

#[test]
fn ten_thousand_sub_texel_triangles_are_all_sampled() {
    let mut numbers = Numbers(2);
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for j in 0..100 {
        for i in 0..100 {
            // Anywhere in its texel's neighbourhood, so that many lie across texel borders.
            let c = DVec2::new(
                f64::from(i) + 1.0 + numbers.next(),
                f64::from(j) + 1.0 + numbers.next(),
            );
            let turn = numbers.next() * 2.0;
            let first = points.len() as u32;
            for k in 0..3 {
                let angle = turn + f64::from(k) * std::f64::consts::TAU / 3.0;
                points.push((c + DVec2::from_angle(angle) * 0.17).to_array());
            }
            triangles.push([first, first + 1, first + 2]);
        }
    }
    let (scene, atlas) = laid_out(&points, triangles, 128);
    let tiles = tiles(&scene, &atlas);
    let mut seen = vec![0.0; 10_000];
    let mut sampled = vec![false; 10_000];
    for tile in &tiles {
        for f in &tile.footprints {
            let pieces = tile.pieces_of(f);
            let mut before = 0.0;
            for piece in pieces {
                seen[piece.triangle as usize] += piece.cumulative - before;
                let middle = 0.5 * (before + piece.cumulative) / tile.area(f);
                let point = tile.sample(f, [middle, 0.5]);
                assert_eq!(point.triangle, piece.triangle);
                sampled[piece.triangle as usize] = true;
                before = piece.cumulative;
            }
            samples_stay_inside(&scene, &atlas, tile, f);
        }
    }
    assert!(sampled.iter().all(|&s| s));
    let exact = exact_area(&scene, &atlas);
    assert!((seen.iter().sum::<f64>() / exact - 1.0).abs() < 1e-9);
}

#[test]
fn needles_thinner_than_a_texel_cover_every_texel_they_cross() {
    // 30 texels long, a hundredth of a texel thin, aslant; and one that lies along a row of texel borders.
    let points = [
        [2.25, 3.25],
        [32.25, 9.5],
        [32.25, 9.515625],
        [40.0, 20.0],
        [60.0, 20.0],
        [60.0, 20.0078125],
    ];
    let (scene, atlas) = laid_out(&points, vec![[0, 1, 2], [3, 4, 5]], 64);
    let tiles = tiles(&scene, &atlas);
    let columns = |triangle: u32| {
        let mut columns: Vec<u32> = tiles
            .iter()
            .flat_map(|t| t.footprints.iter().map(move |f| (t, f)))
            .filter(|(t, f)| t.pieces_of(f)[0].triangle == triangle)
            .map(|(_, f)| f.x)
            .collect();
        columns.sort_unstable();
        columns.dedup();
        columns
    };
    assert_eq!(columns(0), (2..=32).collect::<Vec<_>>());
    assert_eq!(columns(1), (40..60).collect::<Vec<_>>());
    let exact = exact_area(&scene, &atlas);
    assert!((covered(&tiles) / exact - 1.0).abs() < 1e-9);
    for tile in &tiles {
        for f in &tile.footprints {
            samples_stay_inside(&scene, &atlas, tile, f);
        }
    }
}

#[test]
fn a_triangle_on_a_texel_border_belongs_to_the_side_it_lies_in() {
    let points = [
        [4.0, 4.0],
        [5.0, 4.0],
        [4.0, 5.0],
        [16.0, 8.0],
        [16.0, 9.0],
        [15.0, 8.0],
    ];
    let (scene, atlas) = laid_out(&points, vec![[0, 1, 2], [3, 4, 5]], 32);
    let tiles = tiles(&scene, &atlas);
    let found: Vec<(u32, u32, f32)> = tiles
        .iter()
        .flat_map(|t| t.footprints.iter().map(|f| (f.x, f.y, f.coverage)))
        .collect();
    assert_eq!(found, [(4, 4, 0.5), (15, 8, 0.5)]);
}

#[test]
fn triangles_without_area_contribute_nothing() {
    let points = [[4.0, 4.0], [9.0, 9.0], [14.0, 14.0]];
    let (scene, atlas) = laid_out(&points, vec![[0, 1, 2], [0, 0, 1]], 32);
    assert!(PageRaster::new(&scene, &atlas, 0).tiles().is_empty());
}

#[test]
fn a_triangle_larger_than_the_page_fills_it_with_whole_squares() {
    let size = 40;
    let points = [[0.0, 0.0], [80.0, 0.0], [0.0, 80.0]];
    let (scene, atlas) = laid_out(&points, vec![[0, 1, 2]], size);
    let tiles = tiles(&scene, &atlas);
    assert_eq!(tiles.len(), 9);
    assert_eq!(
        tiles.iter().map(|t| t.footprints.len()).sum::<usize>(),
        1600
    );
    for tile in &tiles {
        for f in &tile.footprints {
            assert_eq!(f.coverage, 1.0);
            assert!(tile.pieces_of(f)[0].square);
            let p = position(&scene, &atlas, &tile.sample(f, [0.25, 0.75]));
            let expected = DVec2::new(f64::from(f.x) + 0.25, f64::from(f.y) + 0.75);
            assert!((p - expected).length() < 1e-12, "{p} for {expected}");
        }
    }
}

#[test]
fn samples_are_uniform_over_a_polygonal_footprint() {
    // Three triangles share texel (8, 8) and leave a part of it open.
    let points = [
        [7.5, 7.75],
        [9.5, 7.5],
        [8.375, 8.5],
        [8.25, 9.5],
        [9.75, 9.25],
    ];
    let (scene, atlas) = laid_out(&points, vec![[0, 1, 2], [0, 2, 3], [2, 4, 3]], 16);
    let tiles = tiles(&scene, &atlas);
    let tile = &tiles[0];
    let footprint = tile
        .footprints
        .iter()
        .find(|f| (f.x, f.y) == (8, 8))
        .unwrap();
    // Expected: the exact area of the footprint in each cell of an 8x8 grid, by the same triangles on a finer page.
    let fine = laid_out(
        &points.map(|p| [p[0] * 8.0, p[1] * 8.0]),
        vec![[0, 1, 2], [0, 2, 3], [2, 4, 3]],
        128,
    );
    let mut expected = [0.0; 64];
    for t in &self::tiles(&fine.0, &fine.1) {
        for f in &t.footprints {
            if f.x / 8 == 8 && f.y / 8 == 8 {
                expected[(f.y % 8 * 8 + f.x % 8) as usize] = t.area(f);
            }
        }
    }
    let total: f64 = expected.iter().sum();
    assert!((total / 64.0 - tile.area(footprint)).abs() < 1e-12);
    let (mut numbers, count) = (Numbers(3), 200_000);
    let mut histogram = [0u32; 64];
    for _ in 0..count {
        let point = tile.sample(footprint, [numbers.next(), numbers.next()]);
        let p = (position(&scene, &atlas, &point) - DVec2::splat(8.0)) * 8.0;
        let cell = p.floor().clamp(DVec2::ZERO, DVec2::splat(7.0));
        histogram[(cell.y * 8.0 + cell.x) as usize] += 1;
    }
    let (mut chi, mut cells) = (0.0, 0);
    for (&seen, &area) in histogram.iter().zip(&expected) {
        let mean = f64::from(count) * area / total;
        if mean >= 5.0 {
            chi += (f64::from(seen) - mean).powi(2) / mean;
            cells += 1;
        } else {
            assert!(
                f64::from(seen) <= mean + 25.0,
                "{seen} samples where {mean} belong"
            );
        }
    }
    // Mean and standard deviation of chi-square with `cells - 1` degrees of freedom; 4 deviations: 1 in 10,000.
    let freedom = f64::from(cells - 1);
    assert!(
        (chi - freedom).abs() < 4.0 * (2.0 * freedom).sqrt(),
        "chi-square {chi} with {freedom} degrees of freedom"
    );
}

#[test]
fn tiles_are_the_same_at_any_thread_count() {
    use rayon::prelude::*;
    let (scene, atlas) = jittered_grid(60, 2.0, 126.0, 128);
    let raster = PageRaster::new(&scene, &atlas, 0);
    let cut = |threads: usize| -> Vec<Tile> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            (0..raster.tiles().len())
                .into_par_iter()
                .map(|i| raster.tile(i))
                .collect()
        })
    };
    let (one, four) = (cut(1), cut(4));
    for (a, b) in one.iter().zip(&four) {
        assert_eq!(a.footprints, b.footprints);
        assert_eq!(a.pieces, b.pieces);
    }
}

#[test]
fn centres_are_the_nearest_points_of_their_footprints() {
    // Triangles that share edges inside texels, and one that is thinner than a texel.
    let points = [
        [1.3, 1.7],
        [13.5, 2.5],
        [9.4, 12.5],
        [3.2, 14.9],
        [1.1, 13.2],
        [1.25, 13.3],
    ];
    let (scene, atlas) = laid_out(&points, vec![[0, 1, 2], [0, 2, 3], [0, 5, 4]], 16);
    let raster = PageRaster::new(&scene, &atlas, 0);
    let mut borders = 0;
    for index in 0..raster.tiles().len() {
        let (whole, drawn) = (raster.tile(index), raster.centres(index));
        assert_eq!(whole.footprints.len(), drawn.footprints.len());
        for (footprint, point) in whole.footprints.iter().zip(&drawn.footprints) {
            assert_eq!(footprint.coverage, point.coverage);
            assert_eq!(whole.area(footprint), drawn.area(point));
            let centre = DVec2::new(f64::from(point.x) + 0.5, f64::from(point.y) + 0.5);
            let at = |tile: &Tile, footprint: &Footprint, u| {
                position(&scene, &atlas, &tile.sample(footprint, u))
            };
            let found = at(&drawn, point, [0.3, 0.7]);
            assert!(found.distance(at(&drawn, point, [0.9, 0.1])) < 1e-9);
            let own = found.distance(centre);
            borders += usize::from(own > 1e-9);
            for k in 0..400 {
                let u = [f64::from(k % 20) / 20.0, f64::from(k / 20) / 20.0];
                let other = at(&whole, footprint, u).distance(centre);
                assert!(
                    own <= other + 1e-9,
                    "{own} from the centre, another {other}"
                );
            }
        }
    }
    assert!(borders > 10, "{borders} footprints without their centre");
}

#[test]
fn areas_of_a_tile_are_those_of_its_triangles_or_of_what_their_bounds_leave() {
    let corners = [
        [2.0, 2.0],
        [10.0, 2.0],
        [2.0, 10.0],
        [10.0, 20.0],
        [20.0, 20.0],
        [10.0, 30.0],
    ];
    let (scene, atlas) = laid_out(&corners, vec![[0, 1, 2], [3, 4, 5]], 64);
    let raster = PageRaster::new(&scene, &atlas, 0);
    let mut found: Vec<([u32; 2], f64)> = (0..raster.tiles().len())
        .flat_map(|tile| raster.areas(tile).collect::<Vec<_>>())
        .collect();
    found.sort_by(|a, b| a.partial_cmp(b).unwrap());
    // The second stands in two tiles: 6 x 10 of its bounds in one, which is more than its 50, and 4 x 10 in the other.
    assert_eq!(found, [([0, 0], 32.0), ([0, 1], 40.0), ([0, 1], 50.0)]);
}
