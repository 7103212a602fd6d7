//! The second baseline: the closed form of an open texel times the visibility.

use crate::support::{bake, files, run_well, scene};
use ambient::closed_form::phong_open_angle;
use glam::DVec3;

const SMALL: [&str; 10] = [
    "--size",
    "32",
    "--rays",
    "16",
    "--seams",
    "off",
    "--exponent",
    "8",
    "--specular",
    "0.4,0.2,0",
];

#[test]
fn second_baseline_is_the_closed_form_times_the_visibility() {
    let eye = DVec3::new(3.0, 2.0, 1.0);
    let more = [
        "--albedo",
        "0.5,0.5,0.5",
        "--view",
        "3,2,1",
        "--layers",
        "traditional.closed,specular.open,position,normal",
    ];
    let (folder, page) = bake(&scene("wall_long.obj"), &[&SMALL[..], &more].concat());
    let mut texels = 0;
    for at in 0..page.size * page.size {
        let three = |layer: &str| {
            DVec3::from(["X", "Y", "Z"].map(|c| f64::from(page.plane(&format!("{layer}.{c}"))[at])))
        };
        if page.plane("coverage")[at] == 0.0 {
            continue;
        }
        let toward = (eye - three("position")).normalize();
        let open = phong_open_angle(8.0, three("normal").dot(toward).clamp(-1.0, 1.0).acos());
        let visibility = f64::from(page.plane("visibility")[at]);
        for (channel, specular) in [("R", 0.4), ("G", 0.2), ("B", 0.0)] {
            let found = f64::from(page.plane(&format!("traditional.closed.{channel}"))[at]);
            let exact = visibility * (0.5 + specular * open);
            assert!(
                (found - exact).abs() < 1e-5,
                "{channel}: {found}, not {exact}"
            );
        }
        texels += 1;
    }
    assert!(texels > 100);
    let words = run_well(["compare", &folder.path().display().to_string(), "--json"]);
    assert!(words.contains("traditional.closed"), "{words}");
    let names = files(folder.path());
    assert!(
        names
            .iter()
            .any(|name| name.ends_with("wall_long.0.difference.traditional.closed-phong.png")),
        "{names:?}"
    );
}

#[test]
fn open_surfaces_leave_nothing_between_the_second_baseline_and_the_model() {
    let more = ["--layers", "traditional.closed", "--view", "0.5,2,0.3"];
    for model in ["phong", "ggx"] {
        let (_folder, page) = bake(
            &scene("plane.obj"),
            &[&SMALL[..], &more, &["--model", model]].concat(),
        );
        let pairs = page
            .plane("traditional.closed.R")
            .iter()
            .zip(page.plane(&format!("{model}.R")));
        let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        // The model is a mean over the texel, the baseline the value at its middle.
        assert!(worst < 2e-3, "{model}: {worst}");
    }
}
