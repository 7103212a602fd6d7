use super::*;
use crate::told::Told;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A grid of `n` by `m` squares over the unit square, each cut in two.
fn grid(n: u32, m: u32, at: impl Fn(f64, f64) -> DVec3) -> Welded {
    let corners = (0..=n)
        .flat_map(|i| {
            (0..=m).map(move |j| [f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)])
        })
        .map(|[u, v]| at(u, v))
        .collect();
    let square = |i: u32, j: u32| {
        let [a, b] = [i * (m + 1) + j, (i + 1) * (m + 1) + j];
        [[a, b, b + 1], [a, b + 1, a + 1]]
    };
    let triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|i| (0..m).flat_map(move |j| square(i, j)))
        .collect();
    Welded::new(corners, triangles.clone(), &triangles)
}

fn flat(surface: &Welded) -> Vec<Piece> {
    let count = surface.triangles.len();
    let each: Vec<u32> = (0..count as u32).collect();
    let told = Told::new(&(), count);
    flatten(surface, &each, &vec![true; count], &told.mesh(count))
}

/// Lengths of all edges in the plane over those in space, at one scale for the piece.
fn stretches(surface: &Welded, piece: &Piece) -> Vec<f64> {
    let edges = |t: usize| {
        let (flat, corners) = (
            piece.places(t),
            surface.triangles[piece.triangles[t] as usize],
        );
        let solid = corners.map(|c| surface.corners[c as usize]);
        (0..3).map(move |k| {
            let l = (k + 1) % 3;
            [flat[k].distance(flat[l]), solid[k].distance(solid[l])]
        })
    };
    let all: Vec<[f64; 2]> = (0..piece.local.len()).flat_map(edges).collect();
    let scale = all.iter().map(|e| e[1]).sum::<f64>() / all.iter().map(|e| e[0]).sum::<f64>();
    all.iter().map(|e| scale * e[0] / e[1]).collect()
}

fn check(surface: &Welded, pieces: &[Piece]) {
    let mut seen = vec![false; surface.triangles.len()];
    for piece in pieces {
        for (t, &of) in piece.triangles.iter().enumerate() {
            assert!(
                !std::mem::replace(&mut seen[of as usize], true),
                "triangle {of} twice"
            );
            let [a, b, c] = piece.places(t);
            assert!(
                (b - a).perp_dot(c - a) > 0.0,
                "triangle {of} is turned over"
            );
            let corners = piece.local[t].map(|v| piece.corners[v as usize]);
            assert_eq!(corners, surface.triangles[of as usize]);
        }
        assert!(
            !overlaps(&piece.local, &piece.flat),
            "a piece covers a place twice"
        );
    }
}

#[test]
fn a_quarter_of_a_cylinder_unrolls_without_stretch() {
    let bent = |u: f64, v: f64| {
        let (sin, cos) = ((u - 0.5) * FRAC_PI_2).sin_cos();
        DVec3::new(sin, v, cos)
    };
    let surface = grid(60, 40, bent);
    let pieces = flat(&surface);
    check(&surface, &pieces);
    assert_eq!(pieces.len(), 1);
    assert_eq!(pieces[0].triangles.len(), surface.triangles.len());
    // Seen from above, the edges at the rim would be shorter by a factor of 0.71.
    for s in stretches(&surface, &pieces[0]) {
        assert!((s - 1.0).abs() < 2e-3, "{s}");
    }
}

#[test]
fn a_spiral_ramp_comes_apart_where_it_lies_over_itself() {
    let ramp = |u: f64, v: f64| {
        let (sin, cos) = (u * 4.0 * TAU).sin_cos();
        let radius = 4.0 - 2.0 * v;
        DVec3::new(radius * cos, radius * sin, 8.0 * u)
    };
    let surface = grid(600, 8, ramp);
    let pieces = flat(&surface);
    check(&surface, &pieces);
    assert!((4..=12).contains(&pieces.len()), "{} pieces", pieces.len());
    let whole: usize = pieces.iter().map(|p| p.triangles.len()).sum();
    assert_eq!(whole, surface.triangles.len());
}

#[test]
fn a_rough_ball_is_covered_almost_whole() {
    // The corners of a ball are moved in and out by a fifth of an edge, which turns facets by tens of degrees.
    let n = 120;
    let rough = |u: f64, v: f64| {
        let (theta, phi) = (0.2 + u * 2.6, v * 5.0);
        let hash = ((u * 1234.5 + v * 987.6) * 43758.5).sin();
        let direction = DVec3::new(
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
            theta.cos(),
        );
        direction * (1.0 + 0.004 * hash)
    };
    let surface = grid(n, 2 * n, rough);
    let pieces = flat(&surface);
    check(&surface, &pieces);
    let area = |t: &u32| surface.areas[*t as usize];
    let covered: f64 = pieces.iter().flat_map(|p| &p.triangles).map(area).sum();
    let share = covered / surface.areas.iter().sum::<f64>();
    assert!(share > 0.98, "{share}");
    assert!(pieces.len() <= 12, "{} pieces", pieces.len());
}

#[test]
fn folds_and_hard_edges_are_borders() {
    // A roof of 45 degrees on both sides: one surface unless the file parts the normals at its ridge.
    let roof = |u: f64, v: f64| DVec3::new(u, 0.4 * v, -0.4 * (u - 0.5).abs());
    let surface = grid(20, 20, roof);
    assert_eq!(flat(&surface).len(), 1);
    let apart = |t: &[u32; 3], middle: f64| {
        let beyond = t
            .iter()
            .map(|&c| surface.corners[c as usize].x)
            .sum::<f64>()
            > middle;
        t.map(|c| c + if beyond { 1_000_000 } else { 0 })
    };
    let shading: Vec<[u32; 3]> = surface.triangles.iter().map(|t| apart(t, 1.5)).collect();
    let parted = Welded::new(surface.corners.clone(), surface.triangles.clone(), &shading);
    assert_eq!(flat(&parted).len(), 2);
    // Parted normals on a flat part are the file's habit, no edge.
    let shading: Vec<[u32; 3]> = surface.triangles.iter().map(|t| apart(t, 0.6)).collect();
    let other = Welded::new(surface.corners.clone(), surface.triangles.clone(), &shading);
    assert_eq!(flat(&other).len(), 1);
    // A gable of 130 degrees is folded.
    let steep = |u: f64, v: f64| DVec3::new(u, 0.4 * v, -2.2 * (u - 0.5).abs());
    assert_eq!(flat(&grid(20, 20, steep)).len(), 2);
}

#[test]
fn what_has_no_area_is_in_no_piece() {
    let line = |u: f64, _: f64| DVec3::new(u, 0.0, 0.0);
    assert!(flat(&grid(20, 20, line)).is_empty());
}
