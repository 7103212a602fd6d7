//! `ambake probes`: what its files hold, read back by other code than wrote them.

use crate::support::{Page, ambake, bake, exr_layer, node, run, run_well, scene, skip};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Runs `probes` on a scene; its folder and its report.
fn probes(name: &str, arguments: &[&str]) -> (tempfile::TempDir, Value) {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let mut command = ambake();
    command.args(["probes", "--quiet", "-o"]).arg(folder.path());
    let output = command.arg(scene(name)).args(arguments).output();
    let output = output.expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let stem = Path::new(name)
        .file_stem()
        .expect("a stem")
        .to_string_lossy();
    let text = fs::read_to_string(folder.path().join(format!("{stem}.probes.json")));
    let report = serde_json::from_str(&text.expect("a report")).expect("JSON");
    (folder, report)
}

/// The triples of numbers under a name of a probe.
fn triples(value: &Value) -> Vec<[f64; 3]> {
    serde_json::from_value(value.clone()).expect("triples")
}

/// E / π toward a normal by the formula of R. Ramamoorthi and P. Hanrahan (2001), equation 13, with their constants.
pub fn matt(light: &[[f64; 3]], [x, y, z]: [f64; 3], c: usize) -> f64 {
    let l = |k: usize| light[k][c];
    let (c1, c2, c3, c4, c5) = (0.429043, 0.511664, 0.743125, 0.886227, 0.247708);
    let e = c1 * l(8) * (x * x - y * y) + c3 * l(6) * z * z + c4 * l(0) - c5 * l(6)
        + 2.0 * c1 * (l(4) * x * y + l(7) * x * z + l(5) * y * z)
        + 2.0 * c2 * (l(3) * x + l(1) * y + l(2) * z);
    e / std::f64::consts::PI
}

/// Width, height, depth and the numbers of a KTX2 volume of half floats.
fn volume(path: &Path) -> ([usize; 3], Vec<[f64; 3]>) {
    let container = ktx2::Reader::new(fs::read(path).expect("written")).expect("a KTX2 container");
    let header = container.header();
    assert_eq!(header.format, Some(ktx2::Format::R16G16B16A16_SFLOAT));
    assert_eq!(
        (header.level_count, header.face_count, header.layer_count),
        (1, 1, 0)
    );
    let size = [header.pixel_width, header.pixel_height, header.pixel_depth].map(|n| n as usize);
    let level = container.levels().next().expect("a level");
    let half = |at: usize| {
        let bytes = [level.data[at], level.data[at + 1]];
        half::f16::from_le_bytes(bytes).to_f64()
    };
    let texels = 0..size.iter().product::<usize>();
    let texels = texels.map(|texel| [0, 1, 2].map(|c| half(8 * texel + 2 * c)));
    (size, texels.collect())
}

const GRID: [&str; 4] = [
    "--grid=5x3x4",
    "--rays=128",
    "--tried=50",
    "--sun=1,2,0.5,2",
];

#[test]
fn volumes_hold_the_light_of_the_report_where_engines_look_for_it() {
    let options = [&GRID[..], &["--for=bevy,three,unity,godot"]].concat();
    let (folder, report) = probes("courtyard.obj", &options);
    let all = report["probes"].as_array().expect("probes");
    assert_eq!(all.len(), 60);
    let (bevy_size, bevy) = volume(&folder.path().join("courtyard.probes.bevy.ktx2"));
    assert_eq!(bevy_size, [5, 2 * 3, 3 * 4]);
    let (three_size, three) = volume(&folder.path().join("courtyard.probes.three.ktx2"));
    assert_eq!(three_size, [5, 3, 9 * 4]);
    let text = fs::read_to_string(folder.path().join("courtyard.probes.unity.json"));
    let unity: Value = serde_json::from_str(&text.expect("written")).expect("JSON");
    let text = fs::read_to_string(folder.path().join("courtyard.probes.three.json"));
    let objects: Value = serde_json::from_str(&text.expect("written")).expect("JSON");
    for (index, probe) in all.iter().enumerate() {
        if probe.get("invalid").is_some() {
            continue;
        }
        let light = triples(&probe["sh"]);
        let [x, y, z] = [index % 5, index / 5 % 3, index / 15];
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                // As Bevy's shader reads it: slabs of x, y and z along z, the negative side in the upper half of y.
                let row = y + if sign < 0.0 { 3 } else { 0 };
                let texel = bevy[x + 5 * (row + 6 * (z + 4 * axis))];
                for (c, found) in texel.into_iter().enumerate() {
                    let exact = matt(&light, normal, c).max(0.0);
                    assert!(
                        (found - exact).abs() < 1e-3 * (1.0 + exact),
                        "{index} {normal:?}: {found} {exact}"
                    );
                }
            }
        }
        // The shader of the volume, and Unity's with x turned over, for a normal in no axis.
        let n = [0.48, -0.6, 0.64];
        let terms = |[x, y, z]: [f64; 3]| {
            [
                1.0,
                y,
                z,
                x,
                x * y,
                y * z,
                3.0 * z * z - 1.0,
                x * z,
                x * x - y * y,
            ]
        };
        let exact = matt(&light, n, 1);
        let slabs = terms(n).into_iter().enumerate();
        let found: f64 = slabs
            .map(|(k, term)| term * three[x + 5 * (y + 3 * (z + 4 * k))][1])
            .sum();
        assert!(
            (found - exact).abs() < 4e-3 * (1.0 + exact),
            "{index}: {found} {exact}"
        );
        let coefficients = unity[index]["coefficients"]
            .as_array()
            .expect("coefficients");
        assert_eq!(coefficients.len(), 27);
        let mirrored = terms([-n[0], n[1], n[2]]).into_iter().enumerate();
        let found: f64 = mirrored
            .map(|(k, term)| term * coefficients[9 + k].as_f64().unwrap_or(f64::NAN))
            .sum();
        assert!(
            (found - exact).abs() < 1e-5 * (1.0 + exact),
            "{index}: {found} {exact}"
        );
        let sh: Vec<f64> =
            serde_json::from_value(objects[index]["object"]["sh"].clone()).expect("numbers");
        let flat: Vec<f64> = light.concat();
        assert!(
            sh.iter().zip(&flat).all(|(a, b)| (a - b).abs() < 1e-6),
            "{index}"
        );
    }
    let nodes = fs::read_to_string(folder.path().join("courtyard.probes.tscn")).expect("written");
    let valid = all
        .iter()
        .filter(|probe| probe.get("invalid").is_none())
        .count();
    assert_eq!(nodes.matches("type=\"LightmapProbe\"").count(), valid);
}

#[test]
fn pictures_hold_the_report_and_the_bytes_are_those_of_any_number_of_threads() {
    let folders: Vec<_> = ["1", "2"]
        .iter()
        .map(|threads| {
            probes(
                "courtyard.obj",
                &[&GRID[..], &["--threads", threads, "--parts"]].concat(),
            )
        })
        .collect();
    for name in ["probes.json", "probes.exr", "probes.distance.exr"] {
        let read = |of: &tempfile::TempDir| fs::read(of.path().join(format!("courtyard.{name}")));
        let [a, b] =
            [read(&folders[0].0), read(&folders[1].0)].map(|bytes| bytes.expect("written"));
        assert!(a == b, "{name} differs");
    }
    let (folder, report) = &folders[0];
    let picture = Page::read(&folder.path().join("courtyard.probes.exr"));
    let plane = picture.plane("sh.3.G");
    for (index, probe) in report["probes"]
        .as_array()
        .expect("probes")
        .iter()
        .enumerate()
    {
        let light = triples(&probe["sh"]);
        assert!((f64::from(plane[index]) - light[3][1]).abs() < 1e-6);
        let parts = ["sky", "lights", "surfaces"].map(|part| triples(&probe[part])[3][1]);
        assert!(
            (parts.iter().sum::<f64>() - light[3][1]).abs() < 1e-4,
            "{parts:?}"
        );
    }
    let layer = exr_layer(&folder.path().join("courtyard.probes.distance.exr"));
    assert_eq!(
        (layer.size.0, layer.size.1),
        (64, 64),
        "8 x 8 tiles of 8 x 8"
    );
}

#[test]
fn a_refined_volume_gathers_the_same_probes_where_light_is_uneven_and_mixes_the_others() {
    let grid = ["--grid=13x7x11", "--rays=256", "--tried=200"];
    let refined = [&grid[..], &["--refine=0.05", "--for=godot,bevy"]].concat();
    let (_whole, all) = probes("courtyard.obj", &grid);
    let (folder, some) = probes("courtyard.obj", &refined);
    let list = |report: &Value| report["probes"].as_array().expect("probes").clone();
    let (all, some_of) = (list(&all), list(&some));
    let mut between = 0;
    for (whole, own) in all.iter().zip(&some_of) {
        if own["interpolated"] == true {
            assert_eq!(own["rays"], 0);
            // Neither beside a wall nor in it.
            assert!(
                whole["invalid"].is_null() && whole["asked"].is_null(),
                "{whole}"
            );
            between += 1;
        } else {
            assert_eq!(whole, own);
        }
    }
    assert!(
        between > all.len() / 10 && between < all.len() * 7 / 8,
        "{between}"
    );
    // Every second one along x, y and z.
    assert!(
        some_of
            .iter()
            .step_by(2)
            .take(7)
            .all(|probe| probe["interpolated"].is_null())
    );
    let nodes = fs::read_to_string(folder.path().join("courtyard.probes.tscn")).expect("a scene");
    let valid = some_of
        .iter()
        .filter(|probe| probe["invalid"].is_null())
        .count();
    assert_eq!(
        nodes.matches("[node name=\"Probe").count() - 1,
        valid - between
    );
    assert_eq!(
        volume(&folder.path().join("courtyard.probes.bevy.ktx2")).0,
        [13, 14, 33]
    );
    let one = [&refined[..], &["--threads=1"]].concat();
    assert_eq!(probes("courtyard.obj", &one).1, some);
}

#[test]
fn light_of_a_bake_is_that_which_is_followed() {
    let (folder, _) = bake(
        &scene("courtyard.obj"),
        &[
            "--size=256",
            "--rays=64",
            "--bounces=auto",
            "--sky=1,0.8,0.6",
            "--point=0,4,0,20",
        ],
    );
    let at = ["--at=0,1.5,3;3,1,-1;-2,2,2", "--rays=4096"];
    let dir = folder.path().to_str().expect("UTF-8");
    let (_a, baked) = probes("courtyard.obj", &[&at[..], &["--bake", dir]].concat());
    let lit = ["--sky=1,0.8,0.6", "--point=0,4,0,20"];
    let (_b, followed) = probes("courtyard.obj", &[&at[..], &lit].concat());
    for (a, b) in baked["probes"]
        .as_array()
        .into_iter()
        .flatten()
        .zip(followed["probes"].as_array().into_iter().flatten())
    {
        let [(a, ea), (b, eb)] =
            [a, b].map(|probe| (triples(&probe["sh"]), triples(&probe["std_err"])));
        for k in 0..9 {
            for c in 0..3 {
                let off = (a[k][c] - b[k][c]).abs();
                let error = ea[k][c].hypot(eb[k][c]);
                // The pages of so small a bake are off by themselves, by some hundredths of the light.
                assert!(
                    off < 5.0 * error + 0.03 * a[0][c],
                    "{k} {c}: {} {} ± {error}",
                    a[k][c],
                    b[k][c]
                );
            }
        }
    }
}

#[test]
fn wrong_words_are_one_line_and_leave_no_folder() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let out = folder.path().join("out");
    let courtyard = scene("courtyard.obj");
    let base = [
        "probes".as_ref(),
        courtyard.as_os_str(),
        "-o".as_ref(),
        out.as_os_str(),
    ];
    for (words, told) in [
        (&[][..], "--spacing"),
        (&["--spacing=0"], "above 0"),
        (&["--spacing=1e-6"], "--within"),
        (&["--grid=4x4"], "8x4x8"),
        (&["--at=1,2"], "three numbers"),
        (&["--at=0,1,0", "--for=bevy"], "--grid"),
        (&["--grid=2x2x2", "--for=unreal"], "takes no probes"),
        (&["--grid=2x2x2", "--rays=8"], "64"),
        (&["--grid=2x2x2", "--refine=0"], "above 0"),
        (&["--at=0,1,0", "--refine=0.1"], "--refine"),
        (&["--grid=2x2x2", "--refine=0.1", "--shard=1/2"], "--refine"),
        (&["--grid=2x2x2", "--bake=/nowhere"], "/nowhere"),
        (&["--grid=2x2x2", "--sky=nowhere.hdr"], "nowhere.hdr"),
        (&["--grid=2x2x2", "--sky=1e20,1,1"], "1e12"),
        (&["--grid=2x2x2", "--point=0,2,0,1e30"], "1e12"),
    ] {
        let output = run(base
            .iter()
            .copied()
            .chain(words.iter().map(|word| word.as_ref())));
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success(), "{words:?}");
        assert!(
            text.lines().count() == 1 && text.contains(told),
            "{words:?}: {text}"
        );
        assert!(!out.exists(), "{words:?}");
    }
    run_well([
        "probes",
        courtyard.to_str().expect("UTF-8"),
        "-o",
        out.to_str().expect("UTF-8"),
        "--at=0,1,0",
        "-q",
    ]);
    assert!(out.join("courtyard.probes.json").exists());
}

/// The faces of the levels of a KTX2 cube, and its edge.
fn cube(path: &Path) -> (usize, Vec<Vec<u8>>) {
    let container = ktx2::Reader::new(fs::read(path).expect("written")).expect("a KTX2 container");
    let header = container.header();
    assert_eq!(
        (header.face_count, header.layer_count, header.pixel_depth),
        (6, 0, 0)
    );
    assert_eq!(header.pixel_width, header.pixel_height);
    let levels = container.levels().map(|level| level.data.to_vec());
    (header.pixel_width as usize, levels.collect())
}

#[test]
fn reflections_are_cubes_whose_levels_are_blurred_and_bevy_gets_them_turned() {
    let (folder, report) = probes(
        "courtyard.obj",
        &[
            "--reflections=0,1.5,3;2,1,2",
            "--reflection-size=32",
            "--for=bevy,three",
        ],
    );
    let reflections = report["reflections"].as_array().expect("reflections");
    assert_eq!(reflections.len(), 2);
    assert!(
        !folder.path().join("courtyard.probes.exr").exists(),
        "no probes were asked for"
    );
    let path = |name: &str| folder.path().join(format!("courtyard.reflection.0.{name}"));
    let (edge, levels) = cube(&path("specular.ktx2"));
    let lengths: Vec<usize> = levels.iter().map(|level| level.len() / 8 / 6).collect();
    assert_eq!((edge, &lengths[..]), (32, &[32 * 32, 16 * 16, 8 * 8][..]));
    let told = reflections[0]["levels"].as_array().expect("levels");
    assert_eq!(told.len(), 3);
    assert!(
        told.iter()
            .all(|level| level["error"].as_f64().is_some_and(|e| e > 0.0 && e < 0.2))
    );
    // Rougher surfaces show less contrast, and all of the light.
    let value = |level: &[u8], texel: usize| {
        half::f16::from_le_bytes([level[8 * texel + 2], level[8 * texel + 3]]).to_f64()
    };
    let of = |level: &[u8]| {
        let count = level.len() / 8;
        let mean = (0..count).map(|k| value(level, k)).sum::<f64>() / count as f64;
        let spread = (0..count)
            .map(|k| (value(level, k) - mean).powi(2))
            .sum::<f64>();
        (mean, (spread / count as f64).sqrt())
    };
    let [a, b, c] = [0, 1, 2].map(|k| of(&levels[k]));
    assert!(a.1 > b.1 && b.1 > c.1, "{a:?} {b:?} {c:?}");
    assert!((a.0 / c.0 - 1.0).abs() < 0.1, "{a:?} {c:?}");
    // Faces as OpenGL has them: +x -x +y -y +z -z; z reversed swaps the last two and mirrors all.
    let (_, bevy) = cube(&path("bevy.specular.ktx2"));
    for row in 0..edge {
        for column in 0..edge {
            let at = |face: usize, row: usize, column: usize| (face * edge + row) * edge + column;
            let mirrored = edge - 1 - column;
            for (face, from, row_from, column_from) in [
                (0, 0, row, mirrored),
                (1, 1, row, mirrored),
                (2, 2, edge - 1 - row, column),
                (3, 3, edge - 1 - row, column),
                (4, 5, row, mirrored),
                (5, 4, row, mirrored),
            ] {
                let turned = value(&bevy[0], at(face, row, column));
                assert_eq!(
                    turned,
                    value(&levels[0], at(from, row_from, column_from)),
                    "{face}"
                );
            }
        }
    }
    // The sky is above: the matt cube is brighter upward.
    let (small, diffuse) = cube(&path("diffuse.ktx2"));
    let middle = |face: usize| value(&diffuse[0], (face * small + small / 2) * small + small / 2);
    assert!(middle(2) > 1.5 * middle(3), "{} {}", middle(2), middle(3));
    assert!(path("three.exr").exists());
    // Beside places, which make no volume for Bevy, its cubes are there all the same.
    let (folder, _) = probes(
        "courtyard.obj",
        &[
            "--at=0,1,0",
            "--reflections=0,1.5,3",
            "--reflection-size=8",
            "--for=bevy",
        ],
    );
    let has = |name: &str| folder.path().join(name).exists();
    assert!(has("courtyard.reflection.0.bevy.specular.ktx2") && has("courtyard.probes.exr"));
    assert!(!has("courtyard.probes.bevy.ktx2"));
}

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

#[test]
fn a_lamp_that_no_bake_takes_lights_no_probe() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let lamp = folder.path().join("lamp.obj");
    fs::write(
        &lamp,
        "mtllib lamp.mtl\nusemtl lamp\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .expect("written");
    fs::write(folder.path().join("lamp.mtl"), "newmtl lamp\nKe 1e13 0 0\n").expect("written");
    let out = folder.path().join("out");
    let output = run([
        "probes".as_ref(),
        lamp.as_os_str(),
        "-o".as_ref(),
        out.as_os_str(),
        "--at=0,0,1".as_ref(),
    ]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && text.contains("emission of 1e13"),
        "{text}"
    );
    assert!(!out.exists());
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
        serde_json::json!({ "center": center, "radius": 0.15, "eye": eye, "fov": fov, "size": [width, height], "wanted": wanted })
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
