//! Lights of glTF files.

use super::support::{Document, push};
use ambake_scene::{Light, LightKind, Scene, WarningKind};
use glam::DVec3;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

/// A triangle, and these lights on nodes of these properties.
fn lit(lights: Value, nodes: &[Value]) -> Scene {
    let mut document = Document::triangle();
    document.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    document.json["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    for node in nodes {
        let number = push(&mut document.json["nodes"], node.clone());
        if node.get("child").is_none() {
            push(&mut document.json["scenes"][0]["nodes"], json!(number));
        }
    }
    document.load().unwrap()
}

fn bearing(light: u32) -> Value {
    json!({ "KHR_lights_punctual": { "light": light } })
}

#[test]
fn lights_stand_where_their_nodes_do_and_shine_along_their_negative_z() {
    let lights = json!([
        { "type": "directional", "intensity": 3, "color": [1, 0.5, 0], "name": "sun" },
        { "type": "spot", "intensity": 2.0, "range": 9, "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 } },
        { "type": "point" },
        { "type": "spot" },
    ]);
    // A quarter turn about x takes -z to +y.
    let quarter = json!([FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2]);
    let nodes = [
        json!({ "translation": [1, 2, 3], "scale": [2, 2, 2], "children": [2, 3], "rotation": quarter }),
        json!({ "translation": [1, 0, 0], "extensions": bearing(1), "child": true, "name": "lamp" }),
        json!({ "extensions": bearing(0), "child": true }),
        json!({ "extensions": bearing(2) }),
        json!({ "extensions": bearing(3) }),
        // Hidden, with all below it.
        json!({ "extensions": { "KHR_node_visibility": { "visible": false } }, "children": [7] }),
        json!({ "extensions": bearing(2), "child": true }),
    ];
    let scene = lit(lights, &nodes);
    assert_eq!(scene.warnings, []);
    let light = |name: &str, kind, strength: [f64; 3], range| Light {
        name: name.into(),
        kind,
        strength: strength.into(),
        range,
        position: DVec3::ZERO,
        direction: DVec3::NEG_Z,
    };
    let endless = f64::INFINITY;
    let inner_outer = |inner, outer| LightKind::Spot { inner, outer };
    let exact = [
        Light {
            position: DVec3::new(3.0, 2.0, 3.0),
            direction: DVec3::Y,
            ..light("lamp", inner_outer(0.25, 0.5), [2.0; 3], 9.0)
        },
        Light {
            position: DVec3::new(1.0, 2.0, 3.0),
            direction: DVec3::Y,
            ..light("sun", LightKind::Directional, [3.0, 1.5, 0.0], endless)
        },
        light("light 2", LightKind::Point, [1.0; 3], endless),
        light("light 3", inner_outer(0.0, FRAC_PI_4), [1.0; 3], endless),
    ];
    assert_eq!(scene.lights.len(), exact.len(), "{:?}", scene.lights);
    for (found, exact) in scene.lights.iter().zip(exact) {
        assert!(found.position.distance(exact.position) < 1e-6, "{found:?}");
        assert!(
            found.direction.distance(exact.direction) < 1e-6,
            "{found:?}"
        );
        let (position, direction) = (found.position, found.direction);
        assert_eq!(
            *found,
            Light {
                position,
                direction,
                ..exact
            }
        );
    }
}

#[test]
fn lights_that_cannot_be_read_are_counted_and_left_out() {
    for (light, needle) in [
        (json!({ "type": "area" }), "type"),
        (json!({ "type": "point", "intensity": -1 }), "intensity"),
        (json!({ "type": "point", "color": [1, 2] }), "colour"),
        (json!({ "type": "point", "range": 0 }), "range"),
        (
            json!({ "type": "spot", "spot": { "innerConeAngle": 1, "outerConeAngle": 0.5 } }),
            "angles",
        ),
        (
            json!({ "type": "spot", "spot": { "outerConeAngle": 2 } }),
            "angles",
        ),
        (Value::Null, "not in the file"),
    ] {
        let list = if light.is_null() {
            json!([])
        } else {
            json!([light])
        };
        let scene = lit(list, &[json!({ "extensions": bearing(0), "name": "lamp" })]);
        assert_eq!(scene.lights, []);
        assert_eq!(scene.warned(WarningKind::IgnoredExtensions), 1);
        let warning = &scene.warnings[0];
        assert!(
            warning.message.contains(needle),
            "{needle}: {}",
            warning.message
        );
        assert!(warning.place.contains("light"), "{}", warning.place);
    }
}
