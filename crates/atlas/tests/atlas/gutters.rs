//! Dilation, and gutters wide enough for mip levels and blocks.

use crate::scenes::{ball, cube, moved, scene};
use ambake_atlas::{Dilation, Options, PageRaster, UvMode, gutter, layout};
use glam::DAffine3;

/// A page with a chart of a few shapes: 1 inside, 0 elsewhere.
fn coverage(size: usize) -> Vec<f32> {
    let mut c = vec![0.0; size * size];
    for y in 10..20 {
        for x in 12..30 {
            c[y * size + x] = if x == 12 { 0.001 } else { 1.0 };
        }
    }
    c[40 * size] = 0.5; // on the page's edge
    c[size * size - 1] = 1.0; // in its corner
    c
}

#[test]
fn every_void_texel_within_two_of_a_chart_is_filled_and_no_void_leaks() {
    let size = 64;
    let coverage = coverage(size);
    let mut plane: Vec<f32> = coverage
        .iter()
        .map(|&c| if c > 0.0 { 3.0 } else { f32::NAN })
        .collect();
    Dilation::new(&coverage, size as u32, 2).apply(&mut plane);
    for y in 0..size as i64 {
        for x in 0..size as i64 {
            let near = (-2..=2).any(|dy: i64| {
                (-2..=2).any(|dx: i64| {
                    let (u, v) = (x + dx, y + dy);
                    let on = 0..size as i64;
                    on.contains(&u)
                        && on.contains(&v)
                        && coverage[(v * size as i64 + u) as usize] > 0.0
                })
            });
            let value = plane[(y * size as i64 + x) as usize];
            if near {
                assert_eq!(value, 3.0, "texel {x} {y}");
            } else {
                assert!(value.is_nan(), "texel {x} {y} is {value}");
            }
        }
    }
}

#[test]
fn covered_texels_stay_and_a_ring_reads_only_the_rings_before() {
    let size = 8usize;
    let mut coverage = vec![0.0; 64];
    let mut plane = vec![-1e30; 64];
    for (at, value) in [(3 * size + 3, 1.0), (3 * size + 4, 5.0)] {
        coverage[at] = 1.0;
        plane[at] = value;
    }
    Dilation::new(&coverage, size as u32, 2).apply(&mut plane);
    assert_eq!(plane[3 * size + 3], 1.0);
    assert_eq!(plane[3 * size + 4], 5.0);
    // First ring: above both; left of the first only.
    assert_eq!(plane[2 * size + 3], 3.0);
    assert_eq!(plane[3 * size + 2], 1.0);
    assert_eq!(plane[2 * size + 2], 1.0);
    assert_eq!(plane[2 * size + 4], 3.0);
    assert_eq!(plane[2 * size + 5], 5.0);
    // Second ring: (3, 1) sees (2, 2), (3, 2) and (4, 2).
    assert_eq!(plane[size + 3], ((1.0 + 3.0 + 3.0) / 3.0f64) as f32);
    assert_eq!(plane[0], -1e30);
}

#[test]
fn an_empty_page_and_a_full_page_have_no_fills() {
    assert!(Dilation::new(&[0.0; 16], 4, 4).targets().is_empty());
    assert!(Dilation::new(&[1.0; 16], 4, 4).targets().is_empty());
    assert_eq!(Dilation::new(&[], 0, 4).targets().len(), 0);
}

/// Coverage of an unwrapped page with a ball and cubes on it.
fn unwrapped(size: u32, gutter: u32) -> Vec<f32> {
    let instances = [
        (0, 0, DAffine3::IDENTITY),
        (1, 1, moved(3.0, 0.0, 0.0)),
        (2, 2, moved(6.0, 0.0, 0.0)),
    ];
    let scene = scene(vec![ball(12), cube(), cube()], &instances);
    let options = Options {
        uv: UvMode::Unwrap,
        page_size: size,
        gutter,
        ..Options::default()
    };
    let atlas = layout(&scene, &options, &|| false).unwrap();
    let raster = PageRaster::new(&scene, &atlas, 0);
    let mut coverage = vec![0.0; (size * size) as usize];
    for tile in 0..raster.tiles().len() {
        for footprint in raster.tile(tile).footprints {
            coverage[(footprint.y * size + footprint.x) as usize] = footprint.coverage;
        }
    }
    coverage
}

/// The chart of each texel, 0 for void: connected texels, for charts are apart.
fn labels(coverage: &[f32], size: usize) -> (Vec<u32>, u32) {
    let mut labels = vec![0; coverage.len()];
    let mut count = 0;
    for start in 0..coverage.len() {
        if coverage[start] == 0.0 || labels[start] != 0 {
            continue;
        }
        count += 1;
        labels[start] = count;
        let mut open = vec![start];
        while let Some(texel) = open.pop() {
            let (x, y) = (texel % size, texel / size);
            for v in y.saturating_sub(1)..(y + 2).min(size) {
                for u in x.saturating_sub(1)..(x + 2).min(size) {
                    let next = v * size + u;
                    if coverage[next] > 0.0 && labels[next] == 0 {
                        labels[next] = count;
                        open.push(next);
                    }
                }
            }
        }
    }
    (labels, count)
}

/// The page and its box-filtered mip levels.
fn pyramid(plane: &[f32], size: usize, mips: u32) -> Vec<Vec<f32>> {
    let mut levels = vec![plane.to_vec()];
    for level in 1..=mips {
        let (above, edge) = (levels.last().unwrap(), size >> level);
        let texel = |i: usize| {
            let (x, y) = (2 * (i % edge), 2 * (i / edge));
            let at = |x: usize, y: usize| above[y * 2 * edge + x];
            0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
        };
        levels.push((0..edge * edge).map(texel).collect());
    }
    levels
}

/// The 4 x 4 texels of a level that a bicubic look-up reads at a point of the page, clamped at its edge. The middle
/// four are those of a bilinear one.
fn taps(level: &[f32], edge: usize, [x, y]: [f64; 2]) -> [f32; 16] {
    let first = |t: f64| (t - 0.5).floor() as i64 - 1;
    let inside = |i: i64| i.clamp(0, edge as i64 - 1) as usize;
    std::array::from_fn(|i| {
        let (u, v) = (first(x) + i as i64 % 4, first(y) + i as i64 / 4);
        level[inside(v) * edge + inside(u)]
    })
}

#[test]
fn look_ups_on_mip_levels_read_what_a_chart_laid_out_alone_gives() {
    for (size, asked, mips) in [(128, 2, 0), (256, 2, 1), (256, 12, 2), (512, 0, 3)] {
        let needed = gutter::needed(asked, mips, 1);
        let coverage = unwrapped(size, needed);
        let edge = size as usize;
        let (labels, charts) = labels(&coverage, edge);
        assert!(charts > 6, "{charts} charts at a gutter of {needed}");
        let value = |i: usize| (i as u32).wrapping_mul(2_654_435_769) as f32;
        let mut page: Vec<f32> = (0..coverage.len()).map(value).collect();
        Dilation::new(&coverage, size, needed).apply(&mut page);
        let page = pyramid(&page, edge, mips);
        for chart in 1..=charts {
            let own = |i: usize| labels[i] == chart;
            let alone: Vec<f32> = (0..coverage.len())
                .map(|i| if own(i) { coverage[i] } else { 0.0 })
                .collect();
            // Void that was left unfilled would show as NaN.
            let mut plane: Vec<f32> = (0..coverage.len())
                .map(|i| if own(i) { value(i) } else { f32::NAN })
                .collect();
            Dilation::new(&alone, size, needed).apply(&mut plane);
            let plane = pyramid(&plane, edge, mips);
            for texel in (0..coverage.len()).filter(|&i| own(i)) {
                for part in [[0.0, 0.0], [0.999, 0.499], [0.5, 0.999]] {
                    let [x, y] = [
                        (texel % edge) as f64 + part[0],
                        (texel / edge) as f64 + part[1],
                    ];
                    for level in 0..=mips as usize {
                        let scale = 1.0 / f64::from(1u32 << level);
                        let at = [x * scale, y * scale];
                        let on = |levels: &[Vec<f32>]| taps(&levels[level], edge >> level, at);
                        assert_eq!(
                            on(&page),
                            on(&plane),
                            "chart {chart} at {x} {y}, level {level}, gutter {needed}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn no_block_holds_texels_of_two_charts_or_of_their_gutters() {
    for (asked, align) in [(2, 4), (1, 12)] {
        let size = 256;
        let coverage = unwrapped(size, gutter::needed(asked, 0, align));
        let edge = size as usize;
        let (labels, charts) = labels(&coverage, edge);
        assert!(charts > 6, "{charts} charts");
        let mut zones: Vec<f32> = labels.iter().map(|&label| label as f32).collect();
        Dilation::new(&coverage, size, asked).apply(&mut zones);
        let align = align as usize;
        for texel in 0..zones.len() {
            let (x, y) = (texel % edge, texel / edge);
            let (x0, y0) = (x / align * align, y / align * align);
            for v in y0..(y0 + align).min(edge) {
                for u in x0..(x0 + align).min(edge) {
                    let (a, b) = (zones[texel], zones[v * edge + u]);
                    assert!(
                        a == b || a == 0.0 || b == 0.0,
                        "charts {a} and {b} share a block of {align} at {x} {y}"
                    );
                }
            }
        }
    }
}
