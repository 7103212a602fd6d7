//! What `ambake bench --texels` counts on a scene.

use crate::support::{run_well, scene};
use serde_json::Value;

#[test]
fn the_figures_of_a_town_name_its_ground_and_its_seams() {
    let file = scene("town.gltf");
    let file = file.to_str().expect("a UTF-8 path");
    let arguments = [
        "bench", "--texels", file, "--size", "512", "--rays", "4", "--json",
    ];
    let json: Value = serde_json::from_str(&run_well(arguments)).expect("JSON");
    let facts = &json["facts"];
    let share = |value: &Value| {
        let number = value.as_f64().expect("a number");
        assert!((0.0..=1.0).contains(&number), "{facts}");
        number
    };
    assert!(share(&facts["largest"]["share"]) > 0.0 && share(&facts["page_use"]) > 0.0);
    assert!(share(&facts["buried"]) < 0.5 && share(&facts["seams"]["share_visible"]) < 1.0);
    let edges = facts["seams"]["edges"].as_u64().expect("a count");
    assert!(
        edges > 100,
        "a smooth wall in two charts is a seam: {facts}"
    );
}
