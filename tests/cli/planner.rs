//! What the planner leaves out does not change the picture.

use crate::support::{Page, bake, report, scene};

/// The decision `name` of a finished bake.
fn decision(report: &serde_json::Value, name: &str) -> String {
    let all = report["plan"].as_array().expect("a list");
    let found = all
        .iter()
        .find(|entry| entry["decision"] == name)
        .unwrap_or_else(|| panic!("no {name} in {all:?}"));
    found.to_string()
}

/// The largest difference of a channel, and how much of it the two stored standard errors explain: at most 1.
fn apart(a: &Page, b: &Page, term: &str, rays: f32) -> f32 {
    let error = |page: &Page, i: usize| {
        if page.names().contains(&"error") {
            page.plane("error")[i]
        } else {
            0.0
        }
    };
    let mut worst = 0.0f32;
    for i in 0..a.size * a.size {
        // 13 standard errors: one in a thousand texels by Student's t with 3 degrees of freedom; no ray counts less
        // than its share.
        let allowed = 13.0 * (error(a, i).hypot(error(b, i)) + 1.0 / rays);
        worst = worst.max((a.plane(term)[i] - b.plane(term)[i]).abs() / allowed);
    }
    worst
}

#[test]
fn convex_body_needs_no_rays_and_looks_as_with_them() {
    for view in ["normal", "3,4,5"] {
        let common = [
            "--size",
            "64",
            "--rays",
            "256",
            "--exponent",
            "20",
            "--specular",
            "1,1,1",
            "--view",
            view,
        ];
        let (folder, closed) = bake(&scene("convex_body.obj"), &common);
        let json = report(folder.path());
        assert_eq!(json["rays"], 0, "{}", json["plan"]);
        assert!(closed.plane("rays").iter().all(|&rays| rays == 0.0));
        let (folder, cast) = bake(
            &scene("convex_body.obj"),
            &[&common[..], &["--plan-off", "open"]].concat(),
        );
        assert!(
            report(folder.path())["rays"].as_u64() > Some(100_000),
            "{}",
            report(folder.path())["plan"]
        );
        for term in ["visibility", "diffuse", "specular"] {
            let apart = apart(&closed, &cast, term, 256.0);
            assert!(
                apart <= 1.0,
                "{view}: {term} is {apart} of what the error allows"
            );
        }
        for i in (0..64 * 64).filter(|&i| closed.plane("coverage")[i] > 0.0) {
            assert_eq!(
                (closed.plane("visibility")[i], closed.plane("diffuse")[i]),
                (1.0, 1.0)
            );
        }
    }
}

#[test]
fn matt_scene_without_specular_rays_looks_as_with_them() {
    let common = ["--size", "32", "--rays", "64"];
    let (folder, matt) = bake(&scene("wall_long.obj"), &common);
    println!("{}", decision(&report(folder.path()), "specular"));
    let (folder, all) = bake(
        &scene("wall_long.obj"),
        &[&common[..], &["--plan-off", "specular"]].concat(),
    );
    println!("{}", decision(&report(folder.path()), "specular"));
    for channel in [
        "diffuse",
        "visibility",
        "phong.R",
        "phong.G",
        "phong.B",
        "lambert.R",
    ] {
        assert_eq!(matt.plane(channel), all.plane(channel), "{channel}");
    }
}

#[test]
fn diffuse_alone_agrees_with_diffuse_beside_visibility() {
    let common = ["--size", "32", "--rays", "1024", "--only", "diffuse,error"];
    let (_folder, alone) = bake(&scene("trench.obj"), &common);
    let (_folder, beside) = bake(
        &scene("trench.obj"),
        &[&common[..], &["--plan-off", "visibility"]].concat(),
    );
    let apart = apart(&alone, &beside, "diffuse", 1024.0);
    assert!(apart <= 1.0, "{apart} of what the error allows");
}

#[test]
fn scene_without_masks_bakes_the_same_through_the_alpha_test() {
    let common = ["--size", "32", "--rays", "64"];
    let (folder, plain) = bake(&scene("trench.obj"), &common);
    println!("{}", decision(&report(folder.path()), "alpha_test"));
    let (_folder, denoised) = bake(
        &scene("trench.obj"),
        &[&common[..], &["--plan-off", "alpha_test"]].concat(),
    );
    for channel in plain.names() {
        assert_eq!(plain.plane(channel), denoised.plane(channel), "{channel}");
    }
}

#[test]
fn flattened_scene_bakes_as_through_instances() {
    let common = ["--size", "64", "--rays", "256"];
    for name in ["trench.obj", "instances.gltf"] {
        let (folder, plain) = bake(&scene(name), &common);
        println!("{name}: {}", decision(&report(folder.path()), "instances"));
        let (_folder, level) = bake(
            &scene(name),
            &[&common[..], &["--plan-off", "instances"]].concat(),
        );
        for term in ["visibility", "diffuse"] {
            let apart = apart(&plain, &level, term, 256.0);
            assert!(
                apart <= 1.0,
                "{name}: {term} is {apart} of what the error allows"
            );
        }
    }
}
