//! `--layers sh,bent`: whence the light of a texel comes, against closed forms.

use crate::support::{Page, bake, save_image};
use environment::Image;
use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::{Path, PathBuf};

const AXES: [&str; 4] = ["0", "x", "y", "z"];

/// A floor of 1 x 1 facing +y and, if asked, a wall in the plane x = 0 that reaches so far up, down and to both sides.
fn floor(folder: &Path, wall: Option<f64>) -> PathBuf {
    let mut text = "o floor\nv 0.001 0 1\nv 1 0 1\nv 1 0 0\nv 0.001 0 0\nf 1 2 3 4\n".to_owned();
    if let Some(r) = wall {
        text +=
            &format!("o wall\nv 0 -{r} -{r}\nv 0 -{r} {r}\nv 0 {r} {r}\nv 0 {r} -{r}\nf 8 7 6 5\n");
    }
    let path = folder.join("floor.obj");
    fs::write(&path, text).expect("written");
    path
}

/// The harmonics of a texel: mean and the three axes, of one colour.
fn harmonics(page: &Page, texel: usize, colour: &str) -> [f32; 4] {
    AXES.map(|axis| page.plane(&format!("sh.{axis}.{colour}"))[texel])
}

fn covered(page: &Page) -> Vec<usize> {
    let coverage = page.plane("coverage").iter().enumerate();
    coverage
        .filter(|(_, c)| **c > 0.0)
        .map(|(i, _)| i)
        .collect()
}

fn bent(page: &Page, texel: usize) -> [f32; 3] {
    ["X", "Y", "Z"].map(|axis| page.plane(&format!("bent.{axis}"))[texel])
}

fn far(found: &[f32], exact: &[f64]) -> f64 {
    let squares = found
        .iter()
        .zip(exact)
        .map(|(f, e)| (f64::from(*f) - e).powi(2));
    squares.sum::<f64>().sqrt()
}

#[test]
fn light_of_an_open_plane_and_beside_a_wall_is_that_of_closed_forms() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    // The quarter of the sphere between wall and floor: (N + Ng) / 8 about the wall's side and the floor.
    let quarter = [0.25, 0.125, 0.125, 0.0];
    let corner = [2.0 / (3.0 * PI), 1.0 / 3.0, 0.0];
    let length = corner.iter().map(|v| v * v).sum::<f64>().sqrt();
    for (wall, exact, direction, most) in [
        (None, [0.5, 0.0, 0.25, 0.0], [0.0, 1.0, 0.0], 1e-6),
        // 64 rays a texel, denoised over 144 texels.
        (Some(1e5), quarter, corner.map(|v| v / length), 0.01),
    ] {
        for denoise in ["regression", "off"] {
            let flags = ["--size=16", "--rays=64", "--include=floor", "--sky=0.5,1,3"];
            let flags = [&flags[..], &["--layers=sh,bent", "--denoise", denoise]].concat();
            let (_bake, page) = bake(&floor(folder.path(), wall), &flags);
            let most = if denoise == "off" { 4.0 * most } else { most };
            for texel in covered(&page) {
                for (colour, sky) in [("R", 0.5), ("G", 1.0), ("B", 3.0)] {
                    let found = harmonics(&page, texel, colour);
                    let exact = exact.map(|value| value * sky);
                    assert!(far(&found, &exact) <= most * sky, "{found:?} {exact:?}");
                }
                let found = bent(&page, texel);
                assert!(
                    far(&found, &direction) <= 4.0 * most,
                    "{found:?} {direction:?}"
                );
            }
        }
    }
}

#[test]
fn light_of_a_map_is_its_integral_over_the_open_hemisphere() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let (width, height) = (64, 32);
    let direction = |i: usize| {
        let turn = ((i % width) as f64 + 0.5) / width as f64 * TAU - PI;
        let polar = ((i / width) as f64 + 0.5) / height as f64 * PI;
        [
            polar.sin() * turn.sin(),
            polar.cos(),
            polar.sin() * turn.cos(),
        ]
    };
    let radiance = |[x, y, z]: [f64; 3]| match 0.8 * x + 0.6 * y > 0.99 {
        true => [90.0, 80.0, 60.0],
        false => [0.5, 0.75 + 0.25 * z, 1.0 + 0.5 * y].map(|v| v as f32),
    };
    let pixels: Vec<[f32; 3]> = (0..width * height)
        .map(|i| radiance(direction(i)))
        .collect();
    let mut exact = [[0.0; 4]; 3];
    for (i, pixel) in pixels.iter().enumerate().take(width * height / 2) {
        let edge = |row: usize| (row as f64 / height as f64 * PI).cos();
        let row = i / width;
        let share = (edge(row) - edge(row + 1)) / (2.0 * width as f64);
        let [x, y, z] = direction(i);
        for (exact, value) in exact.iter_mut().zip(pixel) {
            for (sum, axis) in exact.iter_mut().zip([1.0, x, y, z]) {
                *sum += f64::from(*value) * share * axis;
            }
        }
    }
    let sky = folder.path().join("sky.exr");
    let image = Image {
        width,
        height,
        pixels,
    };
    save_image(&sky, &image);
    let sky = sky.to_str().expect("UTF-8").to_owned();
    let flags = ["--size=16", "--rays=256", "--layers=sh", "--sky", &sky];
    let (_bake, page) = bake(&floor(folder.path(), None), &flags);
    let texels = covered(&page);
    for (colour, exact) in ["R", "G", "B"].into_iter().zip(exact) {
        let mut mean = [0.0; 4];
        for &texel in &texels {
            let found = harmonics(&page, texel, colour);
            let [zero, x, y, z] = found;
            assert!(x.hypot(y).hypot(z) <= zero * 1.000_001, "{found:?}");
            mean.iter_mut()
                .zip(found)
                .for_each(|(m, f)| *m += f / texels.len() as f32);
        }
        // The map's texels are areas of one radiance: directions within them differ by 0.05 at most.
        assert!(
            far(&mean, &exact) <= 0.01 * exact[0],
            "{colour}: {mean:?} {exact:?}"
        );
    }
}

#[test]
fn what_bounces_has_the_irradiance_of_its_own_and_no_side() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let scene = floor(folder.path(), Some(2.0));
    let flags = ["--size=16", "--rays=16", "--layers=sh,irradiance,normal"];
    let (_a, dark) = bake(&scene, &flags);
    let (_b, lit) = bake(
        &scene,
        &[&flags[..], &["--bounces=1", "--albedo=0.5,0.5,0.5"]].concat(),
    );
    let mut most = 0.0f32;
    for texel in covered(&lit) {
        let irradiance = |page: &Page| page.plane("irradiance.G")[texel];
        let added = irradiance(&lit) - irradiance(&dark);
        let [before, after] = [&dark, &lit].map(|page| harmonics(page, texel, "G"));
        let normal = ["X", "Y", "Z"].map(|axis| lit.plane(&format!("normal.{axis}"))[texel]);
        assert!((after[0] - before[0] - 0.5 * added).abs() < 1e-5);
        for a in 0..3 {
            let expected = 0.25 * added * normal[a];
            assert!((after[1 + a] - before[1 + a] - expected).abs() < 1e-5);
        }
        most = most.max(added);
    }
    assert!(most > 0.01, "{most}");
}

/// A square of 1 x 1, a corner of it near the origin, with texture coordinates along two of its sides, and a wall
/// beside it on request.
fn square(folder: &Path, sides: [[f64; 3]; 2], uvs: Option<[[f64; 2]; 4]>, wall: bool) -> PathBuf {
    let [a, b] = sides;
    let corner = |x: f64, y: f64| [0, 1, 2].map(|k| x * a[k] + y * b[k]);
    let mut text = "o floor\n".to_owned();
    for p in [(0.001, 0.0), (1.0, 0.0), (1.0, 1.0), (0.001, 1.0)].map(|(x, y)| corner(x, y)) {
        text += &format!("v {} {} {}\n", p[0], p[1], p[2]);
    }
    for [u, v] in uvs.into_iter().flatten() {
        text += &format!("vt {u} {v}\n");
    }
    text += if uvs.is_some() {
        "f 1/1 2/2 3/3 4/4\n"
    } else {
        "f 1 2 3 4\n"
    };
    if wall {
        text += "o wall\nv 0 -1e5 -1e5\nv 0 -1e5 1e5\nv 0 1e5 1e5\nv 0 1e5 -1e5\nf 8 7 6 5\n";
    }
    let path = folder.join("square.obj");
    fs::write(&path, text).expect("written");
    path
}

#[test]
fn bent_normals_in_tangent_frames_are_those_of_a_normal_map_with_green_up() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let local = |page: &Page, texel| {
        ["X", "Y", "Z"].map(|axis| page.plane(&format!("bent.tangent.{axis}"))[texel])
    };
    // OBJ's v grows upward.
    let upright = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let tilted = [[0.6, 0.8, 0.0], [0.0, 0.0, -1.0]];
    let flags = [
        "--size=16",
        "--rays=64",
        "--include=floor",
        "--denoise",
        "regression",
    ];
    for uvs in [Some(upright), None] {
        let open = square(folder.path(), tilted, uvs, false);
        let (_bake, page) = bake(&open, &[&flags[..], &["--layers=bent.tangent"]].concat());
        for texel in covered(&page) {
            let found = local(&page, texel);
            assert!(far(&found, &[0.0, 0.0, 1.0]) < 1e-5, "{found:?}");
        }
        assert!(!page.names().contains(&"bent.X"), "asked for nowhere");
    }
    // Beside an endless wall in the plane x = 0 the floor's bent normal leans toward +x.
    let level = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]];
    let (across, up) = (2.0 / (3.0 * PI), 1.0 / 3.0);
    let length = f64::hypot(across, up);
    let (x, z) = (across / length, up / length);
    let turn = |f: fn([f64; 2]) -> [f64; 2]| Some(upright.map(f));
    for (uvs, exact) in [
        (Some(upright), [x, 0.0, z]),
        (turn(|[u, v]| [v, u]), [0.0, x, z]),
        (turn(|[u, v]| [1.0 - u, v]), [-x, 0.0, z]),
        (turn(|[u, v]| [v, 1.0 - u]), [0.0, -x, z]),
    ] {
        let beside = square(folder.path(), level, uvs, true);
        let (_bake, page) = bake(
            &beside,
            &[&flags[..], &["--layers=bent.tangent,bent"]].concat(),
        );
        for texel in covered(&page) {
            let found = local(&page, texel);
            assert!(far(&found, &exact) < 0.04, "{found:?} {exact:?}");
            // The frame is flat: only axes change their names.
            let own = bent(&page, texel);
            assert!((found[2] - own[1]).abs() < 1e-5, "{found:?} {own:?}");
        }
    }
}
