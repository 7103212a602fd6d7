//! Lights without extent, with and without light that bounces, against closed forms.

use crate::bounces::{SMALL, bowl, mean, obj, with};
use crate::quads::{self, Quad};
use crate::support::{Page, bake, report, run_well, scene};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::path::Path;

#[test]
fn suns_and_point_lights_shine_straight_with_hard_shadows() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let materials = "newmtl matte\nKd 0.5 0.5 0.5\nnewmtl coat\nKd 0 0 0\nKs 0.5 0.5 0.5\nNs 8\n";
    let floor = "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\no floor\n";
    let wall = "v 0 0 -9\nv 0 0 9\nv 0 9 9\nv 0 9 -9\no wall\nusemtl matte\nf 5 6 7 8\nf 8 7 6 5\n";
    let lights = |path: &Path, more: &[&str]| {
        let dark = ["--sky", "0,0,0", "--denoise", "off"];
        let all = [&SMALL[..], &dark[..], more].concat();
        bake(path, &all).1
    };
    // A floor under nothing: every texel is exact, though no ray of the sky is cast for it.
    let path = obj(
        folder.path(),
        materials,
        &format!("{floor}usemtl coat\nf 4 3 2 1\n"),
    );
    let layers = [
        "--only",
        "irradiance,direct,phong,error.irradiance,position",
    ];
    let pi = PI;
    let page = lights(&path, &[&layers[..], &["--sun", "0,0.8,0.6,2"]].concat());
    // (n + 1)/2pi (R·L)^n E with R the normal.
    let lobe = 0.5 * 9.0 / (2.0 * pi) * 0.8_f64.powi(8) * 2.0;
    for (channel, exact) in [
        ("irradiance.G", 0.8 * 2.0 / pi),
        ("direct.R", 0.8 * 2.0 / pi),
        ("phong.G", lobe),
    ] {
        let (found, worst) = mean(&page, channel);
        assert!(
            (found - exact).abs() < 1e-6 && worst < 1e-6,
            "{channel}: {found}, not {exact}"
        );
    }
    let page = lights(
        &path,
        &[&layers[..], &["--point=-1,2,0.5,3,1.5,0"]].concat(),
    );
    let at = |channel: &str, texel: usize| f64::from(page.plane(channel)[texel]);
    let covered = |texel: &usize| at("coverage", *texel) == 1.0;
    let texels: Vec<usize> = (0..page.plane("coverage").len()).filter(covered).collect();
    assert!(texels.len() > 1000);
    for texel in texels {
        let (x, z) = (at("position.X", texel), at("position.Z", texel));
        let square = (x + 1.0).powi(2) + 4.0 + (z - 0.5).powi(2);
        let exact = 3.0 * 2.0 / square.powf(1.5) / pi;
        for (channel, share) in [("R", 1.0), ("G", 0.5), ("B", 0.0)] {
            let found = at(&format!("irradiance.{channel}"), texel);
            // A texel is a mean over its area.
            assert!(
                (found - share * exact).abs() <= 2e-3 * share * exact,
                "{channel}: {found}, not {exact}"
            );
        }
    }
    // A wall through the middle hides the sun from half of the floor.
    let path = obj(
        folder.path(),
        materials,
        &format!("{floor}usemtl coat\nf 4 3 2 1\n{wall}"),
    );
    let only = [
        "--only",
        "irradiance,error.irradiance,position",
        "--include",
        "floor",
    ];
    let page = lights(&path, &[&only[..], &["--sun", "0.6,0.8,0,2"]].concat());
    for (texel, found) in page.plane("irradiance.B").iter().enumerate() {
        let x = page.plane("position.X")[texel];
        if page.plane("coverage")[texel] == 1.0 && x.abs() > 0.1 {
            let exact = if x > 0.0 { 1.6 / pi } else { 0.0 };
            assert!((f64::from(*found) - exact).abs() < 1e-6, "{found} at {x}");
        }
    }
}

#[test]
fn a_point_light_amid_a_ball_lights_all_of_it_by_the_geometric_sum() {
    // E = I/R², all of which comes back to the wall that sends it on.
    let folder = tempfile::tempdir().expect("a temporary directory");
    let materials = "newmtl wall\nKd 0.6 0.6 0.6\nnewmtl lamp\nKd 0 0 0\n";
    let path = obj(folder.path(), materials, &bowl(1.0, -9.0));
    for (gathers, sum) in [("0", 1.0), ("1", 1.6), ("2", 1.96), ("auto", 2.5)] {
        let more = [
            "--only",
            "irradiance,direct,error.irradiance",
            "--point",
            "0,0,0,2",
        ];
        let more = [&more[..], &["--bounces", gathers]].concat();
        let (_folder, page) = bake(&path, &with(&more));
        let (found, _) = mean(&page, "irradiance.R");
        let once = 2.0 / PI;
        let exact = once * sum;
        // The facets of the ball lie a little nearer than its points.
        assert!(
            (found / exact - 1.0).abs() < 0.025,
            "{gathers}: {found}, not {exact}"
        );
        let (direct, _) = mean(&page, "direct.R");
        assert!(
            (direct / once - 1.0).abs() < 0.025,
            "{gathers}: {direct}, not {once}"
        );
    }
}

/// A level floor of edge 4 with these lights, each on a node of these properties.
fn lit_floor(lights: Value, nodes: &[Value]) -> tempfile::TempDir {
    let material = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0 } });
    let extra = json!({
        "materials": [material],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": lights } },
    });
    let folder = quads::write(&[Quad::level(0.0, 4.0)], extra);
    let path = folder.path().join("scene.gltf");
    let text = std::fs::read_to_string(&path).expect("the scene");
    let mut document: Value = serde_json::from_str(&text).expect("JSON");
    for (number, node) in nodes.iter().enumerate() {
        let mut node = node.clone();
        node["extensions"] = json!({ "KHR_lights_punctual": { "light": number } });
        let list =
            |value: &mut Value, item: Value| value.as_array_mut().expect("a list").push(item);
        list(&mut document["nodes"], node);
        list(&mut document["scenes"][0]["nodes"], json!(1 + number));
    }
    std::fs::write(&path, document.to_string()).expect("a file");
    folder
}

/// Turned so that what looks along -z looks down.
fn down() -> Value {
    json!([-FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2])
}

#[test]
fn a_spot_of_the_file_lights_its_cone_and_falls_to_its_range() {
    let (inner, outer, range) = (0.3_f64, 0.7_f64, 4.0_f64);
    let spot = json!({
        "type": "spot", "name": "lamp", "color": [1, 0.5, 0], "intensity": 3, "range": range,
        "spot": { "innerConeAngle": inner, "outerConeAngle": outer },
    });
    let node = json!({ "rotation": down(), "translation": [0.25, 2, -0.5], "scale": [3, 3, 3] });
    let folder = lit_floor(json!([spot]), &[node]);
    let path = folder.path().join("scene.gltf");
    let only = [
        "--lights",
        "file",
        "--sky",
        "0,0,0",
        "--denoise",
        "off",
        "--only",
        "direct,irradiance,position,lambert",
    ];
    let (baked, page) = bake(&path, &with(&only));
    let at = |channel: &str, texel: usize| f64::from(page.plane(channel)[texel]);
    // The closed form at a place of the floor, from below the lamp.
    let form = |x: f64, z: f64| {
        let square = x * x + 4.0 + z * z;
        let cosine = 2.0 / square.sqrt();
        let part = ((cosine - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
        3.0 * part * part * (1.0 - (square / range.powi(2)).powi(2)) * cosine / square / PI
    };
    let density = report(baked.path())["layout"]["texels_per_unit"]["median"].clone();
    let edge = 1.0 / density.as_f64().expect("a density");
    let place = |k: i32| (f64::from(k) + 0.5) / 16.0 * edge - 0.5 * edge;
    let (mut lit, mut dark) = (0, 0);
    for texel in (0..page.plane("coverage").len()).filter(|&texel| at("coverage", texel) == 1.0) {
        let (x, z) = (
            at("position.X", texel) - 0.25,
            at("position.Z", texel) + 0.5,
        );
        let over = (0..256).map(|k| form(x + place(k % 16), z + place(k / 16)));
        let exact = over.sum::<f64>() / 256.0;
        for (channel, share) in [
            ("direct.R", 1.0),
            ("direct.G", 0.5),
            ("direct.B", 0.0),
            ("irradiance.R", 1.0),
        ] {
            let found = at(channel, texel);
            // 64 rays over a texel in which the light changes by 0.02 at most: the mean of independent ones would be
            // off by 7e-4.
            assert!(
                (found - share * exact).abs() < 7e-4,
                "{channel} at {x}, {z}: {found}, not {exact}"
            );
        }
        lit += usize::from(exact > 0.18);
        dark += usize::from(exact == 0.0);
    }
    assert!(lit > 50 && dark > 500, "{lit} {dark}");
}

#[test]
fn lights_join_the_sky_and_the_models_and_stand_alone_in_direct() {
    // Facing lux counts as W/m²: 2 / pi of each, times the albedo.
    let sun = json!({ "type": "directional", "intensity": 2, "color": [1, 0.5, 0.25] });
    let folder = lit_floor(json!([sun]), &[json!({ "rotation": down() })]);
    let path = folder.path().join("scene.gltf");
    let (baked, page) = bake(
        &path,
        &with(&["--lights", "file", "--sky", "1,2,3", "--model", "phong"]),
    );
    let albedo = mean(&page, "lambert.R").0 / mean(&page, "irradiance.R").0;
    assert!((0.45..0.51).contains(&albedo), "{albedo}");
    for (channel, sky, share) in [("R", 1.0, 1.0), ("G", 2.0, 0.5), ("B", 3.0, 0.25)] {
        let straight = 2.0 * share / PI;
        for (layer, exact) in [
            ("direct", straight),
            ("irradiance", sky + straight),
            ("lambert", albedo * (sky + straight)),
        ] {
            let (found, worst) = mean(&page, &format!("{layer}.{channel}"));
            assert!(
                (found - exact).abs() < 1e-5 && worst < 1e-5,
                "{layer}.{channel}: {found}, not {exact}"
            );
        }
    }
    let (diffuse, _) = mean(&page, "diffuse");
    assert_eq!(diffuse, 1.0, "shares are of the sky alone");
    let report = report(baked.path());
    let sun = &report["options"]["lights"][0];
    assert_eq!(sun["irradiance"], json!([2.0, 1.0, 0.5]), "{sun}");
    assert_eq!(report["bounces"], Value::Null);
    let plan = report["plan"].as_array().expect("decisions").iter();
    let reason = plan
        .filter(|of| of["decision"] == "lights")
        .map(|of| of["reason"].as_str());
    assert!(
        reason.flatten().any(|reason| reason.contains("1 sun")),
        "{}",
        report["plan"]
    );
}

#[test]
fn lights_of_the_file_are_named_until_somebody_decides() {
    let lights = json!([{ "type": "point", "name": "lamp" }, { "type": "point" }]);
    let folder = lit_floor(lights, &[json!({}), json!({})]);
    let path = folder.path().join("scene.gltf");
    for (more, told) in [
        (&[][..], true),
        (&["--lights", "none"], false),
        (&["--lights", "file"], false),
    ] {
        let only = [
            &["--only", "diffuse", "--size", "16", "--rays", "1"][..],
            more,
        ]
        .concat();
        let (baked, _) = bake(&path, &only);
        let report = report(baked.path());
        let warnings = report["warnings"].as_array().expect("a list");
        let found = warnings
            .iter()
            .find(|warning| warning["kind"] == "file-lights");
        assert_eq!(found.is_some(), told, "{more:?}: {warnings:?}");
        if let Some(found) = found {
            assert_eq!(
                (&found["count"], &found["place"]),
                (&json!(2), &json!("light `lamp` and 1 more"))
            );
            assert!(
                found["message"]
                    .as_str()
                    .is_some_and(|text| text.contains("--lights file"))
            );
        }
    }
}

#[test]
fn surfaces_that_shine_are_named_where_they_send_nothing() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let materials = "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl tube\nKe 3 3 3\nnewmtl bulb\nKe 1 0 0\nnewmtl unused\n\
        Ke 1 1 1\n";
    let quad = |name: &str, material: &str, y: f64| {
        let corners = [[-1, -1], [-1, 1], [1, 1], [1, -1]].map(|[x, z]| format!("v {x} {y} {z}\n"));
        format!(
            "o {name}\nusemtl {material}\n{}f -4 -3 -2 -1\n",
            corners.concat()
        )
    };
    let text = [
        ("a", "wall", 0.0),
        ("b", "bulb", 1.0),
        ("c", "tube", 2.0),
        ("d", "tube", 3.0),
    ];
    let path = obj(
        folder.path(),
        materials,
        &text
            .map(|(name, material, y)| quad(name, material, y))
            .concat(),
    );
    let told = |more: &[&str]| {
        let all = [&["--size", "16", "--rays", "1"][..], more].concat();
        let report = report(bake(&path, &all).0.path());
        let warnings = report["warnings"].as_array().expect("a list");
        warnings
            .iter()
            .find(|warning| warning["kind"] == "dark-lamps")
            .cloned()
    };
    let found = told(&[]).expect("a warning");
    assert_eq!(
        (&found["count"], &found["place"]),
        (&json!(2), &json!("material `tube` and 1 more"))
    );
    assert!(
        found["message"]
            .as_str()
            .is_some_and(|text| text.contains("--bounces 1"))
    );
    // Lights of the file are other lights.
    assert!(told(&["--lights", "file"]).is_some());
    for silent in [
        &["--bounces", "1"][..],
        &["--lights", "none"],
        &["--only", "diffuse"],
        &["--no-cast", "b", "--no-cast", "c", "--no-cast", "d"],
    ] {
        assert_eq!(told(silent), None, "{silent:?}");
    }
}

#[test]
fn balls_and_panels_bring_their_form_factors_and_soft_shadows() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let floor = "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\no floor\nusemtl matte\nf 4 3 2 1\n";
    let path = obj(folder.path(), "newmtl matte\nKd 0.5 0.5 0.5\n", floor);
    let only = [
        "--sky",
        "0,0,0",
        "--denoise",
        "off",
        "--only",
        "direct,position",
    ];
    let lit = |path: &Path, light: &[&str]| bake(path, &with(&[&only[..], light].concat())).1;
    // Each texel's mean over 8 x 8 places of it, from the first texel's size.
    let check = |page: &Page, form: &dyn Fn(f64, f64) -> f64, tolerance: f64| {
        let at = |channel: &str, texel: usize| f64::from(page.plane(channel)[texel]);
        let full = |texel: &usize| at("coverage", *texel) == 1.0;
        let texels: Vec<usize> = (0..page.plane("coverage").len()).filter(full).collect();
        assert!(texels.len() > 1000, "{}", texels.len());
        let (mut sum, mut whole) = (0.0, 0.0);
        for &texel in &texels {
            let exact = form(at("position.X", texel), at("position.Z", texel));
            let found = at("direct.R", texel);
            assert!((found - exact).abs() <= tolerance, "{found}, not {exact}");
            assert!((at("direct.B", texel) - 0.25 * found).abs() <= 1e-6 * found);
            (sum, whole) = (sum + found, whole + exact);
        }
        assert!((sum / whole - 1.0).abs() < 2e-3, "{sum}, not {whole}");
    };
    // E / pi = L (R / d)^2 cos.
    let page = lit(&path, &["--sphere", "0.5,1.5,-0.25,0.5,4,2,1"]);
    let ball = |x: f64, z: f64| {
        let square = (x - 0.5_f64).powi(2) + 1.5_f64.powi(2) + (z + 0.25_f64).powi(2);
        4.0 * 0.25 / square * (1.5 / square.sqrt())
    };
    // Exact at every place; a texel's mean differs from its middle by the bend of the falloff.
    check(&page, &ball, 0.002);
    // One that stands half in the plane of the floor, beside it.
    let page = lit(&path, &["--sphere", "3,0.1,0.5,0.5,4,2,1"]);
    let sunk = |x: f64, z: f64| {
        let to = [3.0 - x, 0.1, 0.5 - z];
        let square = to.iter().map(|v| v * v).sum::<f64>();
        4.0 * ambient::closed_form::ball(to[1] / square.sqrt(), 0.25 / square)
    };
    check(&page, &sunk, 0.002);
    // Four rectangles with a corner straight above, with their signs.
    let page = lit(&path, &["--rect=-0.5,1,-0.4,1,0,0,0,0,0.8,4,2,1"]);
    let corner = |x: f64, z: f64| {
        let part = |x: f64, y: f64| x / x.hypot(1.0) * (y / x.hypot(1.0)).atan();
        (part(x, z) + part(z, x)) / (2.0 * PI)
    };
    let panel = |x: f64, z: f64| {
        let ([low, high], [near, far]) = ([-0.5 - x, 0.5 - x], [-0.4 - z, 0.4 - z]);
        4.0 * (corner(high, far) - corner(low, far) - corner(high, near) + corner(low, near))
    };
    check(&page, &panel, 0.06);
    // A wide lid below the lamp hides all of it from what lies beneath.
    let lid = "v -0.2 0.5 -0.2\nv 0.2 0.5 -0.2\nv 0.2 0.5 0.2\nv -0.2 0.5 0.2\no lid\nusemtl matte\nf 5 6 7 8\n";
    let path = obj(
        folder.path(),
        "newmtl matte\nKd 0.5 0.5 0.5\n",
        &format!("{floor}{lid}"),
    );
    let page = lit(&path, &["--include", "floor", "--sphere", "0,1.5,0,0.2,9"]);
    let (mut dark, mut between) = (0, 0);
    for texel in (0..page.plane("coverage").len()).filter(|&t| page.plane("coverage")[t] == 1.0) {
        let [x, z] =
            ["X", "Z"].map(|axis| f64::from(page.plane(&format!("position.{axis}"))[texel]));
        let far = x.abs().max(z.abs());
        let open = 9.0 * 0.04 * 1.5 / (x * x + 2.25 + z * z).powf(1.5);
        let share = f64::from(page.plane("direct.G")[texel]) / open;
        // Umbra to .2 - (.2 - .2) * .5 and penumbra from there to .4, with a texel's width.
        dark += usize::from(share == 0.0);
        between += usize::from((0.1..0.9).contains(&share));
        assert!(
            far < 0.6 || (share - 1.0).abs() < 0.05,
            "{share} at {x}, {z}"
        );
        assert!(far > 0.05 || share == 0.0, "{share} at {x}, {z}");
    }
    assert!(dark >= 1 && between > 20, "{dark} {between}");
}

#[test]
fn parts_and_shadows_of_lights_are_those_of_a_whole_bake() {
    let file = scene("courtyard.obj");
    // Large enough for one page.
    let light = [
        "--size",
        "256",
        "--rays",
        "4",
        "--sun",
        "0.5,0.8,0.3,2",
        "--point",
        "1,1.5,0,4,0,1",
        "--quiet",
    ];
    let words = |folder: &Path, more: &[&str]| {
        let mut words = vec!["bake".to_owned(), file.display().to_string(), "-o".into()];
        words.push(folder.display().to_string());
        words.extend([&light[..], more].concat().iter().map(ToString::to_string));
        words
    };
    let (whole, parts) = (
        tempfile::tempdir().expect("a folder"),
        tempfile::tempdir().expect("a folder"),
    );
    run_well(words(whole.path(), &[]));
    for shard in ["2/2", "1/2"] {
        run_well(words(parts.path(), &["--shard", shard]));
    }
    run_well([
        "merge".as_ref(),
        parts.path().as_os_str(),
        "--quiet".as_ref(),
    ]);
    let read = |folder: &Path| std::fs::read(folder.join("courtyard.0.exr")).expect("a page");
    assert!(read(whole.path()) == read(parts.path()));
    let page = Page::read(&whole.path().join("courtyard.0.exr"));
    assert!(mean(&page, "direct.R").0 > 0.05);
}
