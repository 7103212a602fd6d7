//! What the plan says of each term is what runs.

use crate::support::{bake, report, run_well, scene};
use serde_json::Value;

/// The methods of diffuse, visibility and specular in a list of decisions.
fn methods(plan: &Value) -> [String; 3] {
    ["diffuse", "visibility", "specular"].map(|term| {
        let decisions = plan.as_array().expect("a list");
        let found = decisions.iter().find(|d| d["decision"] == term);
        let method = &found.expect("a decision for each term")["method"];
        method.as_str().expect("a method").to_owned()
    })
}

/// The methods that `plan` and `bake` state, which must be the same.
fn stated(name: &str, arguments: &[&str]) -> [String; 3] {
    let file = scene(name);
    let file = file.to_str().expect("a UTF-8 path");
    let json = run_well([&["plan", file, "--json"], arguments].concat());
    let plan: Value = serde_json::from_str(&json).expect("JSON");
    let (folder, _) = bake(&scene(name), arguments);
    let planned = methods(&plan["plan"]);
    assert_eq!(planned, methods(&report(folder.path())["plan"]), "{name}");
    planned
}

#[test]
fn plan_and_report_state_one_method_for_each_term() {
    let small = ["--size=64", "--rays=16"];
    let with = |more: &[&'static str]| [&small[..], more].concat();
    let closed = "closed_form";
    let cases: [(&str, Vec<&str>, [&str; 3]); 6] = [
        ("plane.obj", with(&[]), [closed, closed, "off"]),
        ("plane.obj", with(&["--exponent=9"]), [closed; 3]),
        (
            "plane.obj",
            with(&["--exponent=9", "--view=1,2,3"]),
            [closed; 3],
        ),
        (
            "ball.obj",
            with(&["--exponent=9", "--view=0,0,9"]),
            [closed, closed, "rays"],
        ),
        (
            "wall_long.obj",
            with(&["--only=diffuse"]),
            ["rays", "off", "off"],
        ),
        (
            "plane.obj",
            with(&["--plan-off=open"]),
            ["rays", "rays", "off"],
        ),
    ];
    for (name, arguments, expected) in cases {
        assert_eq!(stated(name, &arguments), expected, "{name} {arguments:?}");
    }
}

#[test]
fn closed_forms_of_a_smooth_body_are_no_samples() {
    let (folder, page) = bake(
        &scene("ball.obj"),
        &[
            "--size=128",
            "--rays=256",
            "--exponent=9",
            "--view=0,0,9",
            "--layers=bent,normal",
        ],
    );
    let [coverage, visibility, diffuse, errors] =
        ["coverage", "visibility", "diffuse", "error"].map(|name| page.plane(name));
    let covered: Vec<usize> = (0..coverage.len())
        .filter(|&i| coverage[i] == 1.0)
        .collect();
    assert!(covered.len() > 1000, "{} texels", covered.len());
    for &i in &covered {
        // Both are functions of the lean of the normal alone: diffuse = (1 + cos(pi (1 - visibility))) / 2. A texel averages over
        // a few degrees of lean, where the curve is all but straight; 256 samples would miss it by a hundredth.
        let lean = std::f64::consts::PI * (1.0 - f64::from(visibility[i]));
        let expected = 0.5 * (1.0 + lean.cos());
        assert!(
            (f64::from(diffuse[i]) - expected).abs() < 3e-4,
            "texel {i}: {} for {expected}",
            diffuse[i]
        );
        assert!(errors[i] < 2e-3, "texel {i}: stated {}", errors[i]);
    }
    // Counts of 256 rays would be multiples of 1/256 in the sums; closed forms are not.
    let steps = covered
        .iter()
        .filter(|&&i| (diffuse[i] * 1024.0).fract() == 0.0);
    let (steps, all) = (steps.count(), covered.len());
    assert!(
        steps < all / 10,
        "{steps} of {all} values lie on steps of 1/1024"
    );
    assert_eq!(report(folder.path())["rays"], 0, "no ray is cast");
}
