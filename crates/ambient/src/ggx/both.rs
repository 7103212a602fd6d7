//! What the hemisphere rays of a texel bring to its GGX term, which bakes take from both: visible normals alone,
//! hemisphere rays alone, both by the balance heuristic (E. Veach, L. Guibas 1995). `cargo test -p ambake-ambient
//! hemisphere_rays -- --nocapture` prints the table of docs/microfacets.md.

use super::Ggx;
use crate::sampling::{Mixture, Stream};
use glam::DVec3;

/// Points of each technique.
const POINTS: u32 = 64;

/// Estimates of one case.
const REPEATS: u32 = 400;

/// Points for the answer.
const MANY: u32 = 1 << 18;

type Open = fn(DVec3) -> bool;

/// An endless wall as high as it is far; a groove whose walls lean 30 degrees from the normal.
const SCENES: [(&str, Open); 2] = [
    ("wall", |l| l.x <= 0.0 || l.z >= l.x),
    ("groove", |l| l.x.abs() < 30f64.to_radians().tan() * l.z),
];

/// D G2 / (4 N·V), the density of visible normals at a direction, and that of the hemisphere rays.
fn densities(ggx: &Ggx, direction: DVec3) -> [f64; 3] {
    let visible = ggx.pdf(direction);
    let even = if direction.z > 0.0 {
        Mixture::BALANCED.pdf(direction)
    } else {
        0.0
    };
    [visible * ggx.weight(direction), visible, even]
}

/// Sums of a set of directions: open and all.
fn sums(
    directions: impl Iterator<Item = DVec3>,
    open: Open,
    weight: impl Fn(DVec3) -> f64,
) -> [f64; 2] {
    directions.fold([0.0; 2], |[seen, all], direction| {
        let weight = weight(direction);
        let seen = seen + if open(direction) { weight } else { 0.0 };
        [seen, all + weight]
    })
}

/// Relative errors, root mean square, of the open share: visible normals, hemisphere rays, both.
fn errors(ggx: &Ggx, open: Open) -> [f64; 3] {
    let points = |label: u32, repeat: u32, count: u32| {
        let stream = Stream::new(0, 0, repeat, label, 0);
        (0..count)
            .map(move |k| stream.point(k))
            .map(|[u0, u1, ..]| [u0, u1])
    };
    let drawn = |repeat, count| points(1, repeat, count).map(|u| ggx.sample(u).direction);
    let even = |repeat| points(2, repeat, POINTS).map(|u| Mixture::BALANCED.sample(u));
    let by = |which: fn([f64; 3]) -> f64| {
        move |direction: DVec3| {
            let all = densities(ggx, direction);
            if all[0] > 0.0 {
                all[0] / which(all)
            } else {
                0.0
            }
        }
    };
    let share = |[seen, all]: [f64; 2]| if all > 0.0 { seen / all } else { 0.0 };
    let exact = share(sums(drawn(REPEATS, MANY), open, by(|d| d[1])));
    let mut squares = [0.0; 3];
    for repeat in 0..REPEATS {
        let both = |d: [f64; 3]| d[1] + d[2];
        let (a, b) = (
            sums(drawn(repeat, POINTS), open, by(both)),
            sums(even(repeat), open, by(both)),
        );
        let found = [
            share(sums(drawn(repeat, POINTS), open, by(|d| d[1]))),
            share(sums(even(repeat), open, by(|d| d[2]))),
            share([a[0] + b[0], a[1] + b[1]]),
        ];
        for (square, found) in squares.iter_mut().zip(found) {
            *square += (found / exact - 1.0).powi(2);
        }
    }
    squares.map(|sum| (sum / f64::from(REPEATS)).sqrt())
}

#[test]
fn hemisphere_rays_beside_visible_normals_lower_the_error_at_every_roughness() {
    for (name, open) in SCENES {
        for degrees in [0.0_f64, 60.0] {
            for roughness in [0.2, 0.4, 0.6, 0.8, 1.0] {
                let ggx = Ggx::new(roughness * roughness, degrees.to_radians().cos());
                let [visible, even, both] = errors(&ggx, open);
                println!(
                    "{name}, {degrees} degrees, roughness {roughness}: {visible:.4} by visible normals, {even:.4} by \
                     the hemisphere, {both:.4} by both"
                );
                assert!(both < 0.9 * visible, "{visible} {both}");
                assert!(both < 1.1 * even, "{even} {both}");
            }
        }
    }
}
