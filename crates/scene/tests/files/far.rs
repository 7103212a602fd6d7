//! Scenes far from the origin: what the text says arrives, and what a file has lost is told of.

use super::support::{Document, Folder};
use ambake_scene::{Scene, WarningKind};
use glam::DVec3;
use serde_json::json;
use std::fmt::Write;

/// UTM and earth-centred coordinates.
const PLACES: [[f64; 3]; 2] = [
    [512_342.678, 123.4, 5_412_342.678],
    [4_201_000.123, 172_000.456, 4_780_000.789],
];

/// The corners of a step of 1.6 by .17 by .28.
fn step() -> Vec<DVec3> {
    let corner = |k: usize| {
        DVec3::new(
            [0.0, 1.6][k & 1],
            [0.0, 0.17][k >> 1 & 1],
            [0.0, 0.28][k >> 2],
        )
    };
    (0..8).map(corner).collect()
}

/// Its faces, by corners.
const FACES: [[usize; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// An OBJ file of steps at these places, each a part, with three decimals a number as programs write them.
fn steps(places: &[DVec3]) -> String {
    let mut text = String::new();
    for (number, place) in places.iter().enumerate() {
        writeln!(text, "o step{number}").unwrap();
        for corner in step() {
            let [x, y, z] = (corner + place).to_array();
            writeln!(text, "v {x:.3} {y:.3} {z:.3}").unwrap();
        }
        for face in FACES {
            let [a, b, c, d] = face.map(|k| k as i32 - 8);
            writeln!(text, "f {a} {b} {c} {d}").unwrap();
        }
    }
    text
}

fn area(scene: &Scene) -> f64 {
    let of = |instance: &ambake_scene::Instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        let corner =
            |v: u32| (instance.transform).transform_point3(mesh.positions[v as usize].as_dvec3());
        let triangles = mesh.triangles.iter();
        triangles
            .map(|t| {
                let [a, b, c] = t.map(corner);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum::<f64>()
    };
    scene.instances.iter().map(of).sum()
}

#[test]
fn obj_keeps_what_its_text_says_wherever_it_lies() {
    for place in PLACES.map(DVec3::from) {
        let scene = Folder::new().load("a.obj", steps(&[place])).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        assert_eq!(scene.meshes[0].triangles.len(), 12, "{place}");
        let mut found: Vec<DVec3> = scene.meshes[0]
            .positions
            .iter()
            .map(|p| scene.instances[0].transform.transform_point3(p.as_dvec3()))
            .collect();
        for corner in step() {
            let written = corner + place;
            let near = found.iter().position(|p| (*p - written).length() < 2e-6);
            found.remove(near.unwrap_or_else(|| panic!("{written} is not in {found:?}")));
        }
        // 2 (1.6 .17 + 1.6 .28 + .17 .28).
        let exact = 1.535_2;
        assert!((area(&scene) - exact).abs() < 1e-5, "{}", area(&scene));
    }
}

#[test]
fn a_scene_near_the_origin_stays_where_it_stands() {
    let home = DVec3::new(3.25, -1.5, 0.75);
    let scene = Folder::new().load("a.obj", steps(&[home])).unwrap();
    assert_eq!(scene.instances[0].transform, glam::DAffine3::IDENTITY);
}

#[test]
fn one_thing_left_at_the_origin_leaves_the_others_their_digits() {
    let place = DVec3::from(PLACES[1]);
    let along = (0..20).map(|k| place + DVec3::X * f64::from(k) * 2.0);
    let places: Vec<DVec3> = [DVec3::ZERO].into_iter().chain(along).collect();
    let scene = Folder::new().load("a.obj", steps(&places)).unwrap();
    let step = scene.meshes.last().unwrap();
    let [low, high] = [f32::min, f32::max].map(|of| {
        let y = step.positions.iter().map(|p| p.y);
        y.reduce(of).unwrap()
    });
    assert!((high - low - 0.17).abs() < 1e-5, "{low} {high}");
    // The one at the origin is now as far away as they were.
    let kinds: Vec<_> = scene.warnings.iter().map(|w| (w.kind, w.count)).collect();
    assert_eq!(kinds, [(WarningKind::FarApart, 1)], "{:?}", scene.warnings);
    assert!(scene.warnings[0].place.contains("step0"));
}

#[test]
fn nodes_of_gltf_stand_where_their_decimals_say() {
    let mut document = Document::triangle();
    let [x, y, z] = PLACES[0];
    // Neighbours of 32 bits are a half apart at 5e6: these would stand at the same place, or .5 apart.
    document.json["nodes"] = json!([
        { "mesh": 0, "translation": [x, y, z] },
        { "mesh": 0, "translation": [x + 0.28, y, z] },
        { "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z + 0.17, 1] },
        { "translation": [x, y, z], "children": [4] },
        { "mesh": 0, "translation": [0.001, 0, 0] },
    ]);
    document.json["scenes"] = json!([{ "nodes": [0, 1, 2, 3] }]);
    let scene = document.load().unwrap();
    let at = |k: usize| scene.instances[k].transform.translation - DVec3::from(PLACES[0]);
    for (k, expected) in [
        DVec3::ZERO,
        DVec3::X * 0.28,
        DVec3::Z * 0.17,
        DVec3::X * 0.001,
    ]
    .into_iter()
    .enumerate()
    {
        assert!((at(k) - expected).length() < 2e-9, "{k}: {}", at(k));
    }
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn what_32_bit_accessors_have_lost_is_told() {
    // Triangles with sides of .28, and of 280, at the same place: at 5.4e6 neighbours are .5 apart.
    for (side, told) in [(0.28, true), (280.0, false)] {
        let mut document = Document::triangle();
        let far = PLACES[0].map(|x| x as f32);
        let corner = |dx: f64, dz: f64| [far[0] + dx as f32, far[1], far[2] + dz as f32];
        let positions = [corner(0.0, 0.0), corner(side, 0.0), corner(0.0, 2.0 * side)].concat();
        let positions = document.floats("VEC3", &positions);
        document.primitive()["attributes"]["POSITION"] = json!(positions);
        document.json["meshes"][0]["name"] = json!("slab");
        let scene = document.load().unwrap();
        let lost = scene
            .warnings
            .iter()
            .find(|w| w.kind == WarningKind::LostDigits);
        assert_eq!(lost.is_some(), told, "{side}: {:?}", scene.warnings);
        if let Some(lost) = lost {
            assert_eq!((lost.count, lost.place.as_str()), (1, "mesh `slab`"));
            assert!(lost.message.contains("5.0e-1 apart"), "{}", lost.message);
        }
    }
}
