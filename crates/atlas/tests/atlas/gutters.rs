//! Dilation.

use ambake_atlas::Dilation;

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
