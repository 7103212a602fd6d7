//! Lost work and wrong answers that an attack found: each of these was a hole.

use crate::saved::wait_for;
use crate::support::{ambake, backends, bake, report, save_image, scene, shell};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A floor, a ceiling 0.1 above it that is 20 times as large, and the same mesh once more with `third`.
fn floor_and_ceiling(folder: &Path, third: &Value) -> PathBuf {
    let mut bytes: Vec<u8> = [0u16, 2, 1, 0, 3, 2]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect();
    for corner in [[-1f32, 0., -1.], [1., 0., -1.], [1., 0., 1.], [-1., 0., 1.]] {
        bytes.extend(corner.iter().flat_map(|x| x.to_le_bytes()));
    }
    let mut nodes = json!([{ "mesh": 0, "name": "floor" },
        { "mesh": 0, "name": "ceiling", "translation": [0, 0.1, 0], "scale": [20, 20, 20], "rotation": [1, 0, 0, 0] },
        { "mesh": 0, "name": "third" }]);
    for (key, value) in third.as_object().into_iter().flatten() {
        nodes[2][key] = value.clone();
    }
    let document = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2] }], "nodes": nodes,
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 1 }, "indices": 0 }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5123, "count": 6, "type": "SCALAR" },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -1],
            "max": [1, 0, 1] }],
        "bufferViews": [{ "buffer": 0, "byteLength": 12 }, { "buffer": 0, "byteOffset": 12, "byteLength": 48 }],
        "buffers": [{ "byteLength": 60, "uri": "a.bin" }],
    });
    std::fs::write(folder.join("a.bin"), bytes).expect("the folder is writable");
    let path = folder.join("a.gltf");
    std::fs::write(&path, document.to_string()).expect("the folder is writable");
    path
}

#[test]
fn an_instance_that_rays_cannot_be_carried_into_costs_no_other_its_shadow() {
    let folder = tempfile::tempdir().expect("a folder");
    let at =
        |scale: f64, x: f64| json!({ "scale": [scale, scale, scale], "translation": [x, 0, 0] });
    for third in [
        at(1e-9, 1e9),
        at(1e-6, 1e12),
        at(1e-11, 1e7),
        at(1.0, 9.5e17),
        at(1e13, 0.0),
        json!({ "scale": [1, 1e-14, 1], "translation": [5, 0, 0] }),
        json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 1, 1e-8, 1e-8, 0, 5, 0, 0, 1] }),
    ] {
        let path = floor_and_ceiling(folder.path(), &third);
        for backend in backends() {
            let words = [
                "--size",
                "16",
                "--rays",
                "16",
                "--include",
                "floor",
                "--backend",
                backend,
                "--only",
                "visibility",
            ];
            let (_out, page) = bake(&path, &words);
            let coverage = page.plane("coverage").iter();
            let open = coverage
                .zip(page.plane("visibility"))
                .filter(|(c, _)| **c > 0.0)
                .map(|(_, v)| *v);
            let (texels, sum) = open.fold((0, 0.0), |(n, sum), v| (n + 1, sum + v));
            // Seen from the floor's middle, the ceiling's rim stands 0.3 degrees above the horizon: sin 0.3 = 0.005.
            assert!(
                texels > 100 && sum / (texels as f32) < 0.01,
                "{third} on {backend}: {sum} over {texels}"
            );
        }
    }
}

#[test]
fn differences_are_the_traditional_model_less_the_other_and_gutters_continue_charts() {
    let words = [
        "--size",
        "64",
        "--rays",
        "4",
        "--gutter",
        "6",
        "--uv",
        "unwrap",
        "--seams",
        "off",
        "--layers",
        "difference.phong,difference.lambert,normal",
    ];
    let (_out, page) = bake(&scene("resting_sphere.obj"), &words);
    let (size, coverage) = (page.size, page.plane("coverage"));
    let mut largest = 0f32;
    for c in ["R", "G", "B"] {
        for model in ["phong", "lambert"] {
            let (difference, other) = (format!("difference.{model}.{c}"), format!("{model}.{c}"));
            let (traditional, difference) = (
                page.plane(&format!("traditional.{c}")),
                page.plane(&difference),
            );
            for (t, &d) in difference
                .iter()
                .enumerate()
                .filter(|(t, _)| coverage[*t] > 0.0)
            {
                let expected = traditional[t] - page.plane(&other)[t];
                // Three numbers, each rounded to f32, none above 2.
                assert!(
                    (d - expected).abs() < 5e-7,
                    "{model} at {t}: {d} for {expected}"
                );
                largest = largest.max(expected.abs());
            }
        }
    }
    assert!(largest > 0.05, "the models differ: {largest}");
    let normal = |t: usize| ["X", "Y", "Z"].map(|c| page.plane(&format!("normal.{c}"))[t]);
    let filled = |t: usize| normal(t) != [0.0; 3];
    // Chebyshev distance to the charts, ring by ring.
    let mut ring: Vec<usize> = coverage
        .iter()
        .map(|&c| if c > 0.0 { 0 } else { usize::MAX })
        .collect();
    let around = |t: usize| {
        let (x, y) = ((t % size) as i64, (t / size) as i64);
        let near = (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        let inside = 0..size as i64;
        near.filter(move |(x, y)| inside.contains(x) && inside.contains(y))
            .map(move |(x, y)| y as usize * size + x as usize)
    };
    for k in 1..size {
        let next: Vec<usize> = (0..size * size)
            .filter(|&t| ring[t] == usize::MAX && around(t).any(|n| ring[n] == k - 1))
            .collect();
        next.into_iter().for_each(|t| ring[t] = k);
    }
    let mut seen = 0;
    for t in (0..size * size).filter(|&t| ring[t] > 0) {
        assert_eq!(
            filled(t),
            ring[t] <= 6,
            "ring {} of 6 at texel {t}",
            ring[t]
        );
        if filled(t) {
            let length = normal(t).iter().map(|x| x * x).sum::<f32>().sqrt();
            assert!(
                (length - 1.0).abs() < 1e-6,
                "a normal of length {length} at {t}"
            );
            // It is the direction of the mean of the ring before it.
            let mut mean = [0f32; 3];
            for n in around(t).filter(|&n| ring[n] + 1 == ring[t]) {
                (0..3).for_each(|c| mean[c] += normal(n)[c]);
            }
            let norm = mean.iter().map(|x| x * x).sum::<f32>().sqrt();
            let along: f32 = (0..3).map(|c| mean[c] / norm * normal(t)[c]).sum();
            if norm > 1e-3 && ring[t] == 1 {
                assert!(along > 0.9999, "texel {t} points elsewhere: {along}");
            }
            seen += 1;
        }
    }
    assert!(seen > 50, "{seen} gutter texels");
}

#[test]
fn an_edit_during_the_bake_is_a_warning_and_the_result_is_of_what_was_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.obj");
    let original = std::fs::read_to_string(scene("courtyard.obj")).expect("it is there");
    std::fs::copy(scene("courtyard.mtl"), folder.path().join("courtyard.mtl"))
        .expect("it is there");
    std::fs::write(&path, &original).expect("the folder is writable");
    let out = folder.path().join("out");
    let words = |out: &Path| {
        let mut command = ambake();
        command.args([
            "bake".as_ref(),
            path.as_os_str(),
            "-o".as_ref(),
            out.as_os_str(),
        ]);
        command.args([
            "--size", "64", "--rays", "64", "--only", "diffuse", "--quiet",
        ]);
        command
    };
    let mut child = words(&out).spawn().expect("the program starts");
    // Its folder is made before the scene is read; until it has ended it reads the scene once.
    wait_for("the folder", || out.exists());
    std::thread::sleep(Duration::from_millis(150));
    std::fs::write(&path, format!("{original}\n# edited\n")).expect("the folder is writable");
    assert!(child.wait().expect("a status").success());
    let edited = report(&out);
    let warned = edited["warnings"]
        .as_array()
        .expect("a list")
        .iter()
        .any(|w| w["kind"] == "edited-scene");
    std::fs::write(&path, &original).expect("the folder is writable");
    let fresh = folder.path().join("fresh");
    assert!(words(&fresh).status().expect("it runs").success());
    // On a slow machine the edit may come before the load; then nothing was edited during the bake.
    if edited["scene"]["hash"] == report(&fresh)["scene"]["hash"] {
        assert!(warned, "{:#}", edited["warnings"]);
        let glb = |dir: &Path| std::fs::read(dir.join("a.glb")).expect("it is there");
        assert!(glb(&out) == glb(&fresh), "the GLB is of what was read");
    }
}

#[cfg(unix)]
#[test]
fn closed_and_full_streams_are_no_panic_and_control_characters_never_reach_a_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    let status = |line: &str| {
        let mut command = shell(line);
        command.args([scene("plane.obj"), folder.path().join("out")]);
        command.status().expect("sh runs").code()
    };
    for line in [
        r#"ambake bake gone.obj -o "$2" 2>&-"#,
        r#"ambake bake gone.obj -o "$2" 2>/dev/full"#,
        r#"ambake plan "$1" --size 16 --rays 1 >/dev/full 2>/dev/full"#,
    ] {
        assert_eq!(status(line), Some(1), "{line}");
    }
    let done = r#"ambake bake "$1" -o "$2" --size 16 --rays 1 >&- 2>&-"#;
    assert_eq!(status(done), Some(0));
    // A saved state that is no journal is told of in a line that names it, and is baked anew, whether or not anybody
    // can read that.
    let odd = folder.path().join("o\u{1b}[31mdd.obj");
    std::fs::copy(scene("plane.obj"), &odd).expect("the folder is writable");
    let resume = |stderr: &str| {
        let out = folder.path().join("resumed");
        std::fs::create_dir_all(&out).expect("the folder is writable");
        std::fs::write(out.join(".o\u{1b}[31mdd.ambake-resume"), "no journal").expect("a file");
        let line = format!(r#"ambake bake "$1" -o "$2" --size 16 --rays 1 --resume {stderr}"#);
        let output = shell(&line).args([&odd, &out]).output().expect("sh runs");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stderr).expect("UTF-8")
    };
    let told = resume("");
    assert!(
        told.contains("starting over") && !told.contains('\u{1b}'),
        "{told:?}"
    );
    resume("2>/dev/full");
    let name = "a\u{1b}[31m\rb";
    let obj = folder.path().join("c.obj");
    let square = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\no {name}\nmtllib \u{1b}x.mtl\nf 1 2 3\n");
    for (text, words) in [
        (square.clone(), vec!["plan"]),
        (square.replace("v 0 1 0", "v 0 1 \u{1b}"), vec!["plan"]),
    ] {
        std::fs::write(&obj, text).expect("the folder is writable");
        let mut command = ambake();
        let output = command
            .args(words)
            .arg(&obj)
            .args(["--size", "16", "--rays", "1"])
            .output()
            .expect("it runs");
        let all = [output.stdout, output.stderr].concat();
        let all = String::from_utf8(all).expect("UTF-8");
        assert!(!all.contains(['\u{1b}', '\r']), "{all:?}");
    }
    let escape = folder.path().join("\u{1b}[2Jgone.obj");
    let output = ambake().arg("plan").arg(&escape).output().expect("it runs");
    let line = String::from_utf8_lossy(&output.stderr);
    assert!(
        line.contains("\\u{1b}[2Jgone.obj") && !line.contains('\u{1b}'),
        "{line:?}"
    );
}

#[test]
fn light_that_would_overflow_is_refused_with_its_range_before_the_bake() {
    let folder = tempfile::tempdir().expect("a folder");
    let [lamp, sky, out] = ["lamp.obj", "sky.exr", "out"].map(|name| folder.path().join(name));
    let square = std::fs::read_to_string(scene("plane.obj")).expect("a scene");
    let shines = format!("mtllib lamp.mtl\nusemtl lamp\n{square}");
    std::fs::write(&lamp, shines).expect("a file");
    std::fs::write(lamp.with_extension("mtl"), "newmtl lamp\nKe 1 1e30 1\n").expect("a file");
    let mut image = environment::Image::filled(64, 32, [0.5; 3]);
    image.pixels[70] = [1.0, 1e20, 1.0];
    save_image(&sky, &image);
    let sky = format!("--sky={}", sky.display());
    let plane = scene("plane.obj");
    for (file, words, range) in [
        (&plane, "--sky=1e20,1,1", "from 0 to 1e12"),
        (&plane, sky.as_str(), "from 0 to 1e12"),
        (&plane, "--bounces=1 --sun=0,1,0,1e30", "from 0 to 1e12"),
        (&plane, "--bounces=1 --point=0,1,0,1e30", "from 0 to 1e12"),
        (&plane, "--albedo=1e30,1,1", "from 0 to 1e6"),
        (&plane, "--bounces=1 --albedo=2,1,1", "from 0 to 1"),
        (
            &lamp,
            "--bounces=1",
            "emission of 1e30; it must be from 0 to 1e12",
        ),
    ] {
        let mut command = ambake();
        command.arg("bake").arg(file).arg("-o").arg(&out);
        command
            .args(["--size=32", "--rays=4"])
            .args(words.split(' '));
        let output = command.output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{words}: {said}");
        assert!(
            said.contains(range) && said.lines().count() == 1,
            "{words}: {said}"
        );
        assert!(!out.exists(), "{words}");
    }
    // Light that is not baked is nobody's concern, and the largest radiance bakes.
    for (file, words) in [
        (&lamp, "--bounces=off"),
        (&plane, "--sky=1e12,1e12,1e12 --bounces=2"),
    ] {
        let words = words.split(' ').filter(|word| *word != "--bounces=off");
        let mut command = ambake();
        command.arg("bake").arg(file).arg("-o").arg(&out);
        command
            .args(["--size=32", "--rays=4", "--quiet"])
            .args(words);
        let output = command.output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), &*said), (Some(0), ""));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_name_that_grows_too_long_is_refused_before_the_bake() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    // 255 bytes is the most. `.traditional.png` with the page has 18; a saved state has 15, of a part 22.
    for (length, words, status) in [
        (238, "--only=traditional", 1),
        (237, "--only=traditional", 0),
        (241, "--only=rays", 1),
        (240, "--only=rays", 0),
        (234, "--only=rays --shard=1/1", 1),
    ] {
        let path = folder.path().join("a".repeat(length) + ".obj");
        std::fs::copy(scene("plane.obj"), &path).expect("the folder is writable");
        let mut command = ambake();
        command.arg("bake").arg(&path).arg("-o").arg(&out);
        command
            .args(["--size=32", "--rays=4", "--quiet"])
            .args(words.split(' '));
        let output = command.output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(
            output.status.code(),
            Some(status),
            "{length} {words}: {said}"
        );
        if status == 1 {
            assert!(
                said.contains("shorter one") && said.lines().count() == 1,
                "{said}"
            );
            assert!(!out.exists(), "{length} {words}");
        } else {
            std::fs::remove_dir_all(&out).expect("it is there");
        }
    }
}
