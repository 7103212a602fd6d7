//! Small files that could take much time or memory: what they take grows with them, and not with their squares.

use crate::support::{BOX_SIDES, report, run_well};
use serde_json::json;
use std::path::{Path, PathBuf};

/// A scene of one kind: corners and triangles by mesh, and the nodes.
#[derive(Default)]
struct Made {
    meshes: Vec<Part>,
    nodes: Vec<serde_json::Value>,
    materials: usize,
}

/// Numbers of 0 to 1, the same in every run.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f32 {
        let state = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = state.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn point(&mut self, size: f32) -> [f32; 3] {
        [(); 3].map(|()| size * (self.roll() - 0.5))
    }
}

type Part = (Vec<[f32; 3]>, Vec<[u32; 3]>);

fn cube(middle: [f32; 3], half: f32) -> Part {
    let corner = |k: usize| {
        std::array::from_fn(|axis| middle[axis] + if k >> axis & 1 == 1 { half } else { -half })
    };
    let halves = BOX_SIDES.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    ((0..8).map(corner).collect(), halves.concat())
}

/// A level rectangle that looks up.
fn level([x, y, z]: [f32; 3], [wide, deep]: [f32; 2]) -> Part {
    let corners = [
        [x, y, z],
        [x, y, z + deep],
        [x + wide, y, z + deep],
        [x + wide, y, z],
    ];
    (corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
}

/// Everything in one mesh.
fn one(parts: impl Iterator<Item = Part>) -> Made {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for (own, faces) in parts {
        let first = corners.len() as u32;
        corners.extend(own);
        triangles.extend(faces.into_iter().map(|t| t.map(|k| first + k)));
    }
    Made {
        meshes: vec![(corners, triangles)],
        nodes: vec![json!({"mesh": 0})],
        materials: 1,
    }
}

/// A mesh at many places.
fn many(mesh: Part, places: impl Iterator<Item = [f32; 3]>) -> Made {
    Made {
        meshes: vec![mesh],
        nodes: places
            .map(|at| json!({"mesh": 0, "translation": at}))
            .collect(),
        materials: 1,
    }
}

/// Where something of a row of rows goes.
fn spot(number: u32, count: u32, apart: f32) -> [f32; 3] {
    let edge = f64::from(count).sqrt().ceil() as u32;
    [
        apart * (number % edge) as f32,
        0.0,
        apart * (number / edge) as f32,
    ]
}

/// The cliffs.
const KINDS: [&str; 13] = [
    "touching",
    "coplanar",
    "coincident",
    "nested",
    "boxes",
    "slivers",
    "cards",
    "tiny",
    "tiles",
    "materials",
    "nodes",
    "deep",
    "huge",
];

fn made(kind: &str, count: u32) -> Made {
    let mut dice = Dice(1);
    let mut blade = |from: [f32; 3], wide: f32| -> Part {
        let (tip, side) = (dice.point(2.0), dice.point(wide));
        let far = std::array::from_fn(|axis| tip[axis] + side[axis]);
        (vec![from, tip, far], vec![[0, 1, 2]])
    };
    let mut other = Dice(2);
    match kind {
        "touching" => one((0..count).map(|_| blade([0.0; 3], 0.08))),
        "slivers" => one((0..count).map(|_| blade(other.point(2.0), 0.002))),
        "coplanar" => one((0..count).map(|_| {
            let [x, _, z] = other.point(1.0);
            level([x, 0.0, z], [1.5, 1.5])
        })),
        "coincident" => many(cube([0.0; 3], 1.0), (0..count).map(|_| [0.0; 3])),
        "nested" => Made {
            meshes: (0..count)
                .map(|k| cube([0.0; 3], 1.0 + 1e-3 * k as f32))
                .collect(),
            nodes: (0..count).map(|k| json!({"mesh": k})).collect(),
            materials: 1,
        },
        "boxes" => one((0..count).map(|k| cube(spot(k, count, 3.0), 1.0))),
        "cards" => one((0..count).map(|_| {
            let size = (count as f32).cbrt();
            level(other.point(size), [0.6, 0.4])
        })),
        "tiny" => one((0..count)
            .map(|_| cube(other.point(1.0), 1e-4))
            .chain([level([-9.0, -1.0, -9.0], [18.0; 2])])),
        "tiles" => many(
            level([0.0; 3], [2.0; 2]),
            (0..count).map(|k| spot(k, count, 2.0)),
        ),
        "materials" => Made {
            meshes: (0..count).map(|k| cube(spot(k, count, 3.0), 1.0)).collect(),
            nodes: (0..count).map(|k| json!({"mesh": k})).collect(),
            materials: count as usize,
        },
        "nodes" => {
            let mut made = many(cube([0.0; 3], 1.0), std::iter::once([0.0; 3]));
            made.nodes.extend((0..16 * count).map(|_| json!({})));
            made
        }
        "deep" => {
            let mut made = many(cube([0.0; 3], 1.0), std::iter::once([0.0; 3]));
            let chain =
                (1..count).map(|k| json!({"children": [k - 1], "translation": [1e-3, 0, 0]}));
            made.nodes.extend(chain);
            made
        }
        _ => {
            let edge = f64::from(8 * count).sqrt() as u32;
            let corner = |k: u32| {
                let [x, y] = [k % (edge + 1), k / (edge + 1)].map(|k| k as f32 / edge as f32);
                [x, 0.05 * (9.0 * x).sin() * (7.0 * y).cos(), y]
            };
            let quads = (0..edge * edge).map(|k| k % edge + k / edge * (edge + 1));
            let halves =
                quads.flat_map(|k| [[k, k + edge + 1, k + edge + 2], [k, k + edge + 2, k + 1]]);
            one(std::iter::once((
                (0..(edge + 1).pow(2)).map(corner).collect(),
                halves.collect(),
            )))
        }
    }
}

/// Writes a scene as glTF with a file of numbers beside it.
fn write(folder: &Path, name: &str, made: &Made) -> PathBuf {
    let mut bytes: Vec<u8> = Vec::new();
    let (mut views, mut accessors, mut meshes) = (Vec::new(), Vec::new(), Vec::new());
    let mut add = |part: Vec<u8>, accessor: serde_json::Value| {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": part.len()}));
        bytes.extend(part);
        accessors.push(accessor);
        accessors.len() - 1
    };
    for (number, (corners, triangles)) in made.meshes.iter().enumerate() {
        let limit = |pick: fn(f32, f32) -> f32, from: f32| -> [f32; 3] {
            std::array::from_fn(|axis| corners.iter().fold(from, |m, p| pick(m, p[axis])))
        };
        let (low, high) = (
            limit(f32::min, f32::INFINITY),
            limit(f32::max, f32::NEG_INFINITY),
        );
        let view = number * 2;
        let floats = corners.iter().flatten().flat_map(|x| x.to_le_bytes());
        let position = add(
            floats.collect(),
            json!({"bufferView": view, "componentType": 5126, "count": corners.len(), "type": "VEC3", "min": low,
                "max": high}),
        );
        let numbers = triangles.iter().flatten().flat_map(|k| k.to_le_bytes());
        let indices = add(
            numbers.collect(),
            json!({"bufferView": view + 1, "componentType": 5125, "count": 3 * triangles.len(), "type": "SCALAR"}),
        );
        meshes.push(json!({"primitives": [{
            "attributes": {"POSITION": position}, "indices": indices, "material": number % made.materials,
        }]}));
    }
    let is_child = |k: usize| k + 1 < made.nodes.len() && made.nodes[k + 1]["children"][0] == k;
    let roots: Vec<usize> = (0..made.nodes.len()).filter(|&k| !is_child(k)).collect();
    let materials: Vec<_> = (0..made.materials)
        .map(|k| json!({"pbrMetallicRoughness": {"baseColorFactor": [0.5, k as f64 / made.materials as f64, 0.5, 1]}}))
        .collect();
    let text = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": roots}], "nodes": made.nodes, "meshes": meshes,
        "materials": materials, "accessors": accessors, "bufferViews": views,
        "buffers": [{"uri": format!("{name}.bin"), "byteLength": bytes.len()}],
    });
    std::fs::write(folder.join(format!("{name}.bin")), bytes).expect("a file");
    let path = folder.join(format!("{name}.gltf"));
    std::fs::write(&path, text.to_string()).expect("a file");
    path
}

/// Processor seconds and peak MiB of a bake.
fn cost(folder: &Path, kind: &str, count: u32) -> [f64; 2] {
    let name = format!("{kind}{count}");
    let (scene, out) = (write(folder, &name, &made(kind, count)), folder.join(&name));
    let fixed = "--size 256 --rays 1 --only diffuse --threads 1 --quiet --denoise off";
    let mut words = vec!["bake".to_owned(), scene.display().to_string()];
    words.extend(["-o".to_owned(), out.display().to_string()]);
    words.extend(fixed.split(' ').map(String::from));
    run_well(words);
    let report = report(&out);
    let phases = report["timings"].as_array().expect("timings").iter();
    let seconds: f64 = phases
        .filter_map(|phase| phase["cpu_seconds"].as_f64())
        .sum();
    let peak = report["peak_memory_bytes"].as_f64().unwrap_or(0.0);
    [seconds, peak / f64::from(1 << 20)]
}

/// Four times as much may take eight times as long, where it takes long at all; what is of the size squared takes
/// sixteen times as long.
#[test]
fn four_times_as_much_of_what_meets_itself_takes_at_most_eight_times_the_time_and_memory() {
    let folder = tempfile::tempdir().expect("a folder");
    let failed: Vec<String> = KINDS
        .iter()
        .filter_map(|kind| {
            let [one, four] = [500, 2000].map(|count| cost(folder.path(), kind, count));
            let is_steep = four[0] > 8.0 * one[0].max(0.25) || four[1] > 4.0 * one[1] + 64.0;
            let line = format!("{kind}: {one:.2?}, then {four:.2?} (processor seconds, MiB)");
            println!("{line}");
            is_steep.then_some(line)
        })
        .collect();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}
