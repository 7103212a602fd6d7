//! `ambake probes`: what its files hold, read back by other code than wrote them.

use crate::support::{Page, ambake, bake, exr_layer, run, run_well, scene};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Runs `probes` on a scene; its folder and its report.
pub fn probes(name: &str, arguments: &[&str]) -> (tempfile::TempDir, Value) {
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
pub fn triples(value: &Value) -> Vec<[f64; 3]> {
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
        (
            &["--grid=2x2x2", "--for=three,gltf"],
            "add --reflections X,Y,Z",
        ),
        (&["--at=0,1,0", "--for=blender"], "add --reflections X,Y,Z"),
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
pub fn cube(path: &Path) -> (usize, Vec<Vec<u8>>) {
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
