//! Balls in the light of probes: in pictures, as they are baked, and as three.js shows them.

use crate::probes::{cube, matt, probes, triples};
use crate::support::{Page, bake, node, run, run_well, scene, skip};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A ball of 32 by 16 faces in the words of an OBJ file, of the material `white_ball`.
fn ball(name: &str, center: [f64; 3], radius: f64) -> String {
    use std::f64::consts::{PI, TAU};
    let mut text = format!("o {name}\nusemtl white_ball\n");
    let (columns, rows) = (32, 16);
    for row in 0..=rows {
        for column in 0..columns {
            let (s, y) = (PI * f64::from(row) / f64::from(rows)).sin_cos();
            let (z, x) = (TAU * f64::from(column) / f64::from(columns)).sin_cos();
            let normal = [s * x, y, s * z];
            let [a, b, c] = [0, 1, 2].map(|k| center[k] + radius * normal[k]);
            text += &format!("v {a} {b} {c}\nvn {} {y} {}\n", s * x, s * z);
        }
    }
    let total = (rows + 1) * columns;
    for row in 0..rows {
        for column in 0..columns {
            // Counted from the last vertex, which is -1.
            let at = |row: i32, column: i32| row * columns + column % columns - total;
            let (a, b) = (at(row, column), at(row, column + 1));
            let (c, d) = (at(row + 1, column + 1), at(row + 1, column));
            let upper = (row > 0).then_some([a, b, c]);
            let lower = (row + 1 < rows).then_some([a, c, d]);
            for [a, b, c] in upper.into_iter().chain(lower) {
                text += &format!("f {a}//{a} {b}//{b} {c}//{c}\n");
            }
        }
    }
    text
}

#[test]
fn a_picture_shows_balls_in_the_light_of_their_places() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let floor = folder.path().join("floor.obj");
    let text = "o floor\nv -1e5 0 -1e5\nv -1e5 0 1e5\nv 1e5 0 1e5\nv 1e5 0 -1e5\nf 1 2 3 4\n";
    fs::write(&floor, text).expect("written");
    let [floor, picture] = [floor, folder.path().join("ball.exr")].map(|p| p.display().to_string());
    let middle = |flags: &str| {
        let words = [
            "render",
            &floor,
            "-o",
            &picture,
            "--size=9x9",
            "--samples=1",
            "--fov-deg=2",
            "--look=0,1,0",
            "-q",
        ];
        // A picture of a bake casts none.
        let rays = (!flags.contains("--bake")).then_some("--rays=1");
        run_well(words.into_iter().chain(rays).chain(flags.split(' ')));
        let page = Page::read(Path::new(&picture));
        ["R", "G", "B"].map(|name| page.plane(name)[4 * 9 + 4])
    };
    // Half of all directions show a sky of 1: E / pi is (1 + cos) / 2, which two harmonics hold; nothing is reflected
    // without a bake.
    for (eye, up, exact) in [("0,5,0", "0,0,1", 1.0), ("0,1,5", "0,1,0", 0.5)] {
        let found = middle(&format!(
            "--probe-ball=0,1,0,0.5 --sky=1,2,0.5 --eye={eye} --up={up}"
        ));
        for (found, sky) in found.into_iter().zip([1.0, 2.0, 0.5]) {
            assert!((found - exact * sky).abs() < 0.01 * sky, "{eye}: {found}");
        }
    }
    // The same from a volume, and the nearer of two balls.
    let out = folder.path().join("out").display().to_string();
    let flags = "--within=-1,0.1,-1:1,2,1 --grid=2x2x2 --bounces=0 --rays=4096 --tried=0 -q";
    run_well(
        ["probes", &floor, "-o", &out]
            .into_iter()
            .chain(flags.split(' ')),
    );
    let balls = "--probe-ball=0,1,0,0.5;0,1,-3,2";
    let found = middle(&format!(
        "--probes={out}/floor.probes.json {balls} --eye=0,1,5"
    ));
    assert!((found[0] - 0.5).abs() < 0.02, "{found:?}");
    // In a bake the white floor sends on what it takes of the sky.
    let baked = folder.path().join("baked").display().to_string();
    let flags = "--size=16 --rays=16 -q";
    run_well(
        ["bake", &floor, "-o", &baked]
            .into_iter()
            .chain(flags.split(' ')),
    );
    let found = middle(&format!(
        "--bake={baked} --probe-ball=0,1,0,0.5 --eye=0,1,5"
    ));
    assert!((found[0] - 1.0).abs() < 0.02, "{found:?}");
    let at = ["probes", &floor, "-o", &out, "--at=0,1,0", "-q"];
    run_well(at);
    for (words, told) in [
        ("--probe-ball=0,1", "X,Y,Z"),
        ("--probe-ball=0,1,0,0", "above 0"),
        ("--probes=nowhere", "--probe-ball"),
        ("--mirror-ball=0,1,0 --reflection=nowhere.exr", "nowhere"),
        ("--reflection=nowhere.exr", "--mirror-ball"),
        ("--probe-ball=0,1,0 --probes=nowhere", "nowhere"),
        (
            &format!("--probe-ball=0,1,0 --probes={out}/floor.probes.json"),
            "--grid",
        ),
    ] {
        let output = run(["render", &floor, "-o", &picture]
            .into_iter()
            .chain(words.split(' ')));
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(
            !output.status.success() && text.contains(told),
            "{words}: {text}"
        );
    }
}

/// Where white balls stand in the courtyard: in the open, before walls, and in a corner of the arcade.
const BALLS: [[f64; 3]; 5] = [
    [0.0, 1.5, 3.0],
    [3.0, 1.0, -1.0],
    [-2.0, 2.0, 2.0],
    [5.0, 2.5, 5.0],
    [-4.5, 1.2, -4.5],
];
const RADIUS: f64 = 0.05;

/// What a screen shows, 0..=255.
fn shown(v: f64) -> f64 {
    match v.clamp(0.0, 1.0) {
        v if v <= 0.003_130_8 => 255.0 * 12.92 * v,
        v => 255.0 * (1.055 * v.powf(1.0 / 2.4) - 0.055),
    }
}

/// The directions of the texels of a cube as OpenGL lays out its faces, and their solid angles.
fn cube_directions(edge: usize) -> Vec<([f64; 3], f64)> {
    let texel = |texel: usize| {
        let [column, row] = [texel % edge, texel / edge % edge];
        let [u, v] = [column, row].map(|k| 2.0 * (k as f64 + 0.5) / edge as f64 - 1.0);
        let [x, y, z] = match texel / (edge * edge) {
            0 => [1.0, -v, -u],
            1 => [-1.0, -v, u],
            2 => [u, 1.0, v],
            3 => [u, -1.0, -v],
            4 => [u, -v, 1.0],
            _ => [-u, -v, -1.0],
        };
        let length = (1.0 + u * u + v * v).sqrt();
        let angle = (2.0 / edge as f64).powi(2) / length.powi(3);
        ([x, y, z].map(|k| k / length), angle)
    };
    (0..6 * edge * edge).map(texel).collect()
}

/// The courtyard with white balls in it, as a scene in this folder.
fn courtyard_with_balls(folder: &Path, radius: f64) -> std::path::PathBuf {
    let path = folder.join("courtyard.obj");
    let read = |name: &str| fs::read_to_string(scene(name)).expect("a scene");
    let white = "\nnewmtl white_ball\nKd 1 1 1\nKs 0 0 0\n";
    fs::write(folder.join("courtyard.mtl"), read("courtyard.mtl") + white).expect("written");
    let balls = BALLS.iter().enumerate();
    let balls = balls.map(|(k, &center)| ball(&format!("probe_ball{k}"), center, radius));
    fs::write(
        &path,
        read("courtyard.obj") + "\n" + &balls.collect::<String>(),
    )
    .expect("written");
    path
}

/// A bake of the balls in the light that probes are compared with.
fn bake_with_balls(path: &Path, asked: &[&str]) -> (tempfile::TempDir, Page) {
    let light = [
        "--size=512",
        "--rays=64",
        // More than auto takes: what it leaves out is a hundredth of the light in the dark corner.
        "--bounces=12",
        "--denoise",
        "regression",
    ];
    bake(path, &[&light, asked].concat())
}

#[test]
fn white_balls_look_in_the_light_of_probes_as_they_are_baked() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = courtyard_with_balls(folder.path(), RADIUS);
    let asked = [
        "--density-of=probe_ball*=160",
        "--layers=normal,irradiance,object",
    ];
    let (baked, page) = bake_with_balls(&path, &asked);
    let places = BALLS.map(|[x, y, z]| format!("{x},{y},{z}")).join(";");
    let (made, report) = probes(
        "courtyard.obj",
        &[
            &format!("--at={places}"),
            &format!("--reflections={places}"),
            "--reflection-size=32",
            "--rays=16384",
        ],
    );
    let objects = crate::support::report(baked.path())["objects"].clone();
    let objects = objects.as_array().expect("objects");
    let (coverage, object) = (page.plane("coverage"), page.plane("object"));
    let directions = cube_directions(32);
    for k in 0..BALLS.len() {
        let light = triples(&report["probes"][k]["sh"]);
        let cube = cube(
            &made
                .path()
                .join(format!("courtyard.reflection.{k}.specular.ktx2")),
        );
        let half =
            |at: usize| f64::from(half::f16::from_le_bytes([cube.1[0][at], cube.1[0][at + 1]]));
        let radiance: Vec<[f64; 3]> = (0..directions.len())
            .map(|texel| [0, 1, 2].map(|c| half(8 * texel + 2 * c)))
            .collect();
        let own = objects
            .iter()
            .position(|of| of["name"] == format!("probe_ball{k}"));
        let own = own.expect("the ball") as f32;
        let texels: Vec<usize> = (0..coverage.len())
            .filter(|&texel| coverage[texel] > 0.5 && object[texel] == own)
            .collect();
        let (mut off, mut missed, mut count) = (0.0, 0.0, 0.0);
        for &texel in texels.iter().step_by(1 + texels.len() / 500) {
            let normal =
                ["X", "Y", "Z"].map(|axis| f64::from(page.plane(&format!("normal.{axis}"))[texel]));
            // E / pi of the light of all directions.
            let mut all = [0.0; 3];
            for ((direction, angle), radiance) in directions.iter().zip(&radiance) {
                let cosine: f64 = (0..3).map(|axis| direction[axis] * normal[axis]).sum();
                let weight = cosine.max(0.0) * angle / std::f64::consts::PI;
                (0..3).for_each(|c| all[c] += weight * radiance[c]);
            }
            for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
                let baked = shown(f64::from(page.plane(&format!("irradiance.{name}"))[texel]));
                let nine = shown(matt(&light, normal, c));
                off += (baked - nine).abs();
                missed += (shown(all[c]) - nine).abs();
                count += 1.0;
            }
        }
        let [off, missed] = [off, missed].map(|sum| sum / count);
        assert!(
            count > 1000.0 && off < 2.0 && missed < 1.0,
            "{:?}: {off} {missed}",
            BALLS[k]
        );
    }
}

#[test]
fn three_js_moves_a_ball_through_a_volume_as_it_is_baked() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = courtyard_with_balls(folder.path(), 0.15);
    let (baked, _) = bake_with_balls(&path, &["--density-of=probe_ball*=100", "--rays=24"]);
    let (made, _) = probes(
        "courtyard.obj",
        &[
            "--within=-6.9,0.1,-6.9:6.9,4.1,6.9",
            "--spacing=0.6",
            "--rays=1024",
            "--tried=0",
            "--for=three",
        ],
    );
    let [width, height] = [48usize, 48];
    let balls = BALLS.map(|center| {
        // Nothing stands between.
        let eye = [center[0] + 0.6, center[1] + 0.3, center[2]];
        let text = |place: [f64; 3]| place.map(|v| v.to_string()).join(",");
        let picture = folder.path().join("view.exr");
        let size = format!("--size={width}x{height}");
        let distance = (0..3).map(|k| (eye[k] - center[k]).powi(2)).sum::<f64>().sqrt();
        let fov = 2.4 * (0.15 / distance).asin().to_degrees();
        let words = [
            "render".into(),
            path.display().to_string(),
            format!("--bake={}", baked.path().display()),
            "--model=lambert".into(),
            format!("-o{}", picture.display()),
            format!("--eye={}", text(eye)),
            format!("--look={}", text(center)),
            format!("--fov-deg={fov}"),
            size,
            "--samples=1".into(),
            "-q".into(),
        ];
        run_well(words);
        let picture = Page::read(&picture);
        let planes = ["R", "G", "B"].map(|name| picture.plane(name));
        // The outermost pixels of the ball are left out: it is a body of flat faces there.
        let shape = |pixel: usize| {
            let [x, y] = [pixel % width, pixel / width].map(|k| 2.0 * (k as f64 + 0.5) / width as f64 - 1.0);
            x.hypot(y) < 0.75
        };
        let wanted: Vec<Value> = (0..width * height)
            .flat_map(|pixel| {
                planes.map(|plane| match shape(pixel) {
                    true => shown(plane[pixel].into()).into(),
                    false => Value::Null,
                })
            })
            .collect();
        serde_json::json!({ "center": center, "radius": 0.15, "eye": eye, "fov": fov, "size": [width, height],
            "wanted": wanted })
    });
    let job = folder.path().join("job.json");
    fs::write(&job, serde_json::to_string(&balls).expect("JSON")).expect("written");
    let args = [
        made.path().as_os_str(),
        "courtyard".as_ref(),
        job.as_os_str(),
    ];
    let found = match node("probes.mjs", &args) {
        Ok(found) => found,
        Err(reason) => return skip(&reason),
    };
    assert_eq!(found["errors"], serde_json::json!([]));
    for ball in found["balls"].as_array().expect("balls") {
        let mean = ball["mean"].as_f64().expect("a number");
        assert!(
            mean <= 2.0 && ball["pixels"].as_u64() > Some(500),
            "{found}"
        );
    }
}
