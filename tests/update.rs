//! `--update`: what a change cannot reach is kept, and the result is that of a whole bake, byte for byte.

use crate::support::{ambake, files, report, run, run_well, scene};
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A box of a scene.
#[derive(Clone)]
struct Prop {
    name: &'static str,
    at: [f32; 3],
    size: f32,
    material: &'static str,
}

fn prop(name: &'static str, x: f32, z: f32) -> Prop {
    Prop {
        name,
        at: [x, 0.1, z],
        size: 1.0,
        material: "grey",
    }
}

/// Four boxes in a row.
fn row() -> Vec<Prop> {
    vec![
        prop("first 50%", 1.0, 1.0),
        prop("second", 4.0, 1.0),
        prop("third", 7.0, 1.0),
        prop("fourth", 10.0, 1.0),
    ]
}

/// Writes boxes on a floor into `folder`, the floor's red channel given, and returns the scene's path.
fn write(folder: &Path, red: f32, props: &[Prop]) -> PathBuf {
    let mut text = String::from("mtllib row.mtl\n");
    let mut first = 1;
    let mut object = |name: &str, material: &str, corners: &[[f32; 3]], faces: &[[usize; 4]]| {
        writeln!(text, "o {name}\nusemtl {material}").expect("memory");
        for [x, y, z] in corners {
            writeln!(text, "v {x} {y} {z}").expect("memory");
        }
        for [a, b, c, d] in faces.iter().map(|face| face.map(|v| v + first)) {
            writeln!(text, "f {a} {b} {c} {d}").expect("memory");
        }
        first += corners.len();
    };
    let floor = [[0., 0., 0.], [0., 0., 3.], [12., 0., 3.], [12., 0., 0.]];
    object("floor", "floor", &floor, &[[0, 1, 2, 3]]);
    for Prop {
        name,
        at: [x, y, z],
        size,
        material,
    } in props
    {
        let corner = |k: u8| {
            let step = |bit: u8| f32::from(k >> bit & 1) * size;
            [x + step(2), y + step(1), z + step(0)]
        };
        let corners: Vec<_> = (0..8).map(corner).collect();
        let sides = [
            [0, 1, 3, 2],
            [4, 6, 7, 5],
            [0, 4, 5, 1],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 5, 7, 3],
        ];
        object(name, material, &corners, &sides);
    }
    let materials = format!("newmtl floor\nKd {red} 0.5 0.5\nnewmtl grey\nKd 0.5 0.5 0.5\n");
    std::fs::create_dir_all(folder).expect("a folder");
    std::fs::write(folder.join("row.mtl"), materials).expect("a file");
    let path = folder.join("row.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

const SMALL: &[&str] = &["--size", "96", "--rays", "8", "--max-distance", "1"];

fn bake(scene: &Path, folder: &Path, more: &[&str]) {
    let mut words = vec![
        "bake".into(),
        scene.display().to_string(),
        "-o".into(),
        folder.display().to_string(),
        "--quiet".into(),
    ];
    words.extend(more.iter().map(|word| String::from(*word)));
    run_well(words);
}

/// Updates `old` into `new`, trying what was kept; what `bake.json` says of it.
fn update(scene: &Path, old: &Path, new: &Path, more: &[&str]) -> Value {
    let old = old.display().to_string();
    let own = ["--update", &old, "--verify"];
    bake(scene, new, &[more, &own].concat());
    report(new)["update"].clone()
}

/// Both folders hold the same files, and all but `bake.json` have the same bytes.
fn assert_same(a: &Path, b: &Path) {
    assert_eq!(files(a), files(b));
    for name in files(a).iter().filter(|name| *name != "bake.json") {
        let read = |folder: &Path| std::fs::read(folder.join(name)).expect("it is there");
        assert!(read(a) == read(b), "{name} differs");
    }
}

/// Bakes `before`, updates it to `after`, bakes all of `after` in the same layout, and compares; what the update says.
fn compare(before: (f32, &[Prop]), after: (f32, &[Prop]), more: &[&str]) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let old = write(&at("a"), before.0, before.1);
    let new = write(&at("b"), after.0, after.1);
    compare_files(folder.path(), [&old, &new], more)
}

/// The same of two scene files of one name, in a folder of its own.
pub fn compare_files(folder: &Path, [old, new]: [&Path; 2], more: &[&str]) -> Value {
    let at = |name: &str| folder.join(name);
    bake(old, &at("old"), more);
    let said = update(new, &at("old"), &at("new"), more);
    // Another seed keeps the layout and nothing else.
    bake(old, &at("layout"), &[more, &["--seed", "9"]].concat());
    let layout = at("layout").display().to_string();
    bake(new, &at("whole"), &[more, &["--update", &layout]].concat());
    assert_eq!(report(&at("whole"))["update"]["kept"], 0);
    assert_same(&at("whole"), &at("new"));
    said
}

#[test]
fn a_moved_object_costs_what_it_reaches_and_nothing_else() {
    let (before, mut after) = (row(), row());
    after[3].at[0] += 0.25;
    let said = compare((0.5, &before), (0.5, &after), SMALL);
    let share = said["share"].as_f64().expect("a share");
    assert!(share > 0.0 && share < 0.6, "{said}");
    assert_eq!(said["changed"], serde_json::json!(["fourth"]), "{said}");
    assert_eq!(said["reason"], Value::Null, "{said}");
    assert!(said["verified"].as_u64() > Some(0), "{said}");
    let texels = said["baked"].as_u64().expect("texels") + said["kept"].as_u64().expect("texels");
    assert!(texels > 1000, "{said}");
}

#[test]
fn what_is_no_longer_rooted_in_the_floor_is_baked_again() {
    let mut before = row();
    before[0].at[1] = -0.3;
    // Under the first box, and half as large: no ray comes there, but the floor no longer buries the foot of the box.
    // It is no ground any more, so all that it reached is baked again.
    let mut below = prop("below", 1.2, 1.2);
    (below.at[1], below.size) = (-0.85, 0.6);
    let after = [&before[..], &[below]].concat();
    let said = compare((0.5, &before), (0.5, &after), SMALL);
    assert!(said["baked"].as_u64() > Some(1000), "{said}");
    let same = compare((0.5, &before), (0.5, &before), SMALL);
    assert_eq!(same["baked"], 0, "{same}");
}

/// Writes a floor and two closed boxes of one mesh whose faces look inward, with a rug in the first or without.
fn write_inward(folder: &Path, rug: bool) -> PathBuf {
    let corners = (0..8u8).map(|k| [2, 1, 0].map(|bit| f32::from(k >> bit & 1) - 0.5));
    let sheet = [
        [-0.5, 0.0, -0.5],
        [-0.5, 0.0, 0.5],
        [0.5, 0.0, 0.5],
        [0.5, 0.0, -0.5],
    ];
    let sides: [[u16; 4]; 6] = [
        [2, 3, 1, 0],
        [5, 7, 6, 4],
        [1, 5, 4, 0],
        [6, 7, 3, 2],
        [4, 6, 2, 0],
        [3, 7, 5, 1],
    ];
    let fan = |[a, b, c, d]: [u16; 4]| [a, b, c, a, c, d];
    let mut bytes: Vec<u8> = corners
        .chain(sheet)
        .flatten()
        .flat_map(f32::to_le_bytes)
        .collect();
    let numbers = sides.into_iter().flat_map(fan).chain(fan([0, 1, 2, 3]));
    bytes.extend(numbers.flat_map(u16::to_le_bytes));
    std::fs::create_dir_all(folder).expect("a folder");
    std::fs::write(folder.join("inward.bin"), &bytes).expect("a file");
    let points = |at: u64, count: u64, high: [f32; 3]| {
        let low = high.map(|x| -x);
        serde_json::json!({"bufferView": 0, "byteOffset": at, "componentType": 5126, "count": count, "type": "VEC3",
            "min": low, "max": high})
    };
    let indices = |at: u64, count: u64| {
        serde_json::json!({"bufferView": 1, "byteOffset": at, "componentType": 5123, "count": count,
            "type": "SCALAR"})
    };
    let node = |name: &str, mesh: u32, at: [f32; 3], scale: f32| {
        serde_json::json!({"name": name, "mesh": mesh, "translation": at,
            "scale": [scale, scale, scale]})
    };
    let mut nodes = vec![
        node("floor", 1, [0.0; 3], 6.0),
        node("first", 0, [-1.5, 0.7, 0.0], 1.0),
        node("second", 0, [1.5, 0.7, 0.0], 1.0),
    ];
    nodes.extend(rug.then(|| node("rug", 2, [-1.5, 0.7, 0.0], 0.3)));
    let roots: Vec<usize> = (0..nodes.len()).collect();
    let mesh = |points: u32| {
        serde_json::json!({"primitives": [{"attributes": {"POSITION": points},
            "indices": points + 1, "material": 0}]})
    };
    let text = serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": roots}], "nodes": nodes,
        "materials": [{"doubleSided": true, "pbrMetallicRoughness": {"metallicFactor": 0}}],
        "meshes": [mesh(0), mesh(2), mesh(2)],
        "accessors": [points(0, 8, [0.5; 3]), indices(0, 36), points(96, 4, [0.5, 0.0, 0.5]), indices(72, 6)],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 144},
            {"buffer": 0, "byteOffset": 144, "byteLength": 84},
        ],
        "buffers": [{"uri": "inward.bin", "byteLength": bytes.len()}],
    });
    let path = folder.join("inward.gltf");
    std::fs::write(&path, text.to_string()).expect("a file");
    path
}

#[test]
fn the_twin_of_a_body_that_becomes_a_room_is_baked_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let [old, new] =
        [("a", false), ("b", true)].map(|(name, rug)| write_inward(&folder.path().join(name), rug));
    // The twin's sides see as far as a unit: the rug is farther away.
    let said = compare_files(folder.path(), [&old, &new], SMALL);
    assert!(said["kept"].as_u64() > Some(0), "{said}");
    let turned = |name: &str| {
        let report = report(&folder.path().join(name));
        let warnings = report["warnings"].as_array().expect("a list").clone();
        warnings
            .iter()
            .any(|warning| warning["kind"] == "turned-over")
    };
    assert!(turned("old") && !turned("new"));
}

#[test]
fn whole_pages_are_finished_anew_with_bounces_denoiser_and_map() {
    let (before, mut after) = (row(), row());
    after[0].at[1] = 0.3;
    let sky = scene("sky.hdr").display().to_string();
    for more in [
        &["--denoise", "regression"][..],
        &["--bounces", "2"],
        &["--sky", &sky, "--view", "3,4,5", "--exponent", "20"],
    ] {
        let said = compare((0.5, &before), (0.5, &after), &[SMALL, more].concat());
        assert!(said["kept"].as_u64() > Some(0), "{more:?}: {said}");
    }
}

#[test]
fn a_material_costs_its_own_texels_and_no_change_costs_none() {
    let row = row();
    let said = compare((0.5, &row), (0.7, &row), SMALL);
    assert_eq!(said["changed"], serde_json::json!(["floor"]));
    let share = said["share"].as_f64().expect("a share");
    assert!(share > 0.1 && share < 0.9, "{said}");
    let said = compare((0.5, &row), (0.5, &row), SMALL);
    assert_eq!(
        (&said["baked"], &said["share"]),
        (&0.into(), &0.0.into()),
        "{said}"
    );
}

#[test]
fn a_new_object_and_one_of_another_shape_go_where_the_pages_are_free() {
    let (before, mut after) = (row(), row());
    after[1].size = 0.5;
    after.remove(3);
    after.insert(0, prop("new", 9.5, 1.5));
    let said = compare((0.5, &before), (0.5, &after), SMALL);
    assert_eq!(said["reason"], Value::Null, "{said}");
    let changed = serde_json::json!(["new", "second", "fourth"]);
    assert_eq!(said["changed"], changed, "{said}");
    assert!(said["kept"].as_u64() > Some(0), "{said}");
}

#[test]
fn other_options_or_a_folder_without_state_bake_everything_and_say_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let row = write(&at("a"), 0.5, &row());
    bake(&row, &at("old"), SMALL);
    let more = [SMALL, &["--seed", "7"]].concat();
    let said = update(&row, &at("old"), &at("new"), &more);
    assert_eq!(said["kept"], 0);
    assert!(
        said["reason"]
            .as_str()
            .is_some_and(|why| why.contains("--seed")),
        "{said}"
    );
    // In place, and without a state.
    for name in ["row.state", "row.0.state"] {
        std::fs::remove_file(at("old").join(name)).expect("it was there");
    }
    let said = update(&row, &at("old"), &at("old"), SMALL);
    assert_eq!(said["kept"], 0);
    assert!(
        said["reason"]
            .as_str()
            .is_some_and(|why| why.contains("row.state")),
        "{said}"
    );
    // The state is there again, and a damaged one is told of.
    let said = update(&row, &at("old"), &at("old"), SMALL);
    assert_eq!(said["baked"], 0, "{said}");
    let state = at("old").join("row.0.state");
    let mut bytes = std::fs::read(&state).expect("it is there");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&state, bytes).expect("it is written");
    let said = update(&row, &at("old"), &at("new"), SMALL);
    assert!(said["baked"].as_u64() > Some(0), "{said}");
}

#[test]
fn an_update_of_nothing_or_in_shards_is_refused_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let row = write(folder.path(), 0.5, &row()).display().to_string();
    let [old, new] = ["old", "new"].map(|name| folder.path().join(name).display().to_string());
    for (more, word) in [
        (&["--update", &old][..], "no finished bake"),
        (&["--update", &old, "--shard", "1/2"], "--shard"),
    ] {
        let words = ["bake", &row, "-o", &new, "--quiet"];
        let output = run(words.iter().chain(more));
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(text.contains(word) && text.lines().count() == 1, "{text}");
    }
}

#[test]
fn watch_bakes_again_on_a_save_survives_a_broken_one_and_ends_on_a_signal() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let mut props = row();
    let path = write(folder.path(), 0.5, &props);
    let words = ["--size", "48", "--rays", "16", "--max-distance", "1"];
    let child = ambake()
        .arg("watch")
        .arg(&path)
        .arg("-o")
        .arg(&out)
        .args(words)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    // Until the bake of all rays is the one in the folder, and `done` holds for it.
    let wait = |what: &str, done: &dyn Fn(&Value) -> bool| {
        let clock = Instant::now();
        loop {
            let text = std::fs::read_to_string(out.join("bake.json")).unwrap_or_default();
            let now: Value = serde_json::from_str(&text).unwrap_or_default();
            if now["options"]["rays"] == 16 && done(&now) && out.join("report.html").is_file() {
                return;
            }
            assert!(
                clock.elapsed() < Duration::from_secs(120),
                "{what} never came"
            );
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    wait("the first bake", &|_| true);
    std::fs::write(&path, "f 1 2 3\n").expect("it is written");
    std::thread::sleep(Duration::from_secs(1));
    props[1].size = 0.5;
    write(folder.path(), 0.5, &props);
    wait("the second bake", &|now| {
        now["update"]["changed"][0] == "second"
    });
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .expect("kill runs");
    assert!(sent.success());
    let output = child.wait_with_output().expect("a status");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{errors}");
    let told = errors
        .lines()
        .filter(|line| line.contains("waiting for the next save"));
    assert_eq!(told.count(), 1, "{errors}");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        said.contains("1 rays:") && said.contains("16 rays:"),
        "{said}"
    );
    assert!(
        !files(&out).iter().any(|name| name.starts_with('.')),
        "{:?}",
        files(&out)
    );
}
