//! Light that bounces, against closed forms of the radiosity equation.

use crate::quads::{self, Quad};
use crate::support::{Page, bake, files, report, run, run_well};
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// An OBJ file with its materials, in `folder`.
pub fn obj(folder: &Path, materials: &str, text: &str) -> PathBuf {
    std::fs::write(folder.join("a.mtl"), materials).expect("a file");
    let path = folder.join("a.obj");
    std::fs::write(&path, format!("mtllib a.mtl\n{text}")).expect("a file");
    path
}

/// The mean of a channel by covered area, and how far its texels stray from it at most.
pub fn mean(page: &Page, channel: &str) -> (f64, f64) {
    let texels = || page.plane(channel).iter().zip(page.plane("coverage"));
    let (mut sum, mut area) = (0.0, 0.0);
    for (value, coverage) in texels() {
        sum += f64::from(*value) * f64::from(*coverage);
        area += f64::from(*coverage);
    }
    let mean = sum / area;
    let covered = texels().filter(|(_, coverage)| **coverage > 0.0);
    let worst = covered.map(|(value, _)| (f64::from(*value) - mean).abs());
    (mean, worst.fold(0.0, f64::max))
}

/// A ball of radius 1 seen from inside, in rings from the south pole to the latitude of the sine `top`; faces whose
/// middle lies below the sine `lamp` are of material `lamp`.
pub fn bowl(top: f64, lamp: f64) -> String {
    const RINGS: usize = 16;
    const TURNS: usize = 32;
    let mut text = String::new();
    let height = |ring: usize| -1.0 + (top + 1.0) * ring as f64 / RINGS as f64;
    for ring in 0..=RINGS {
        let (y, r) = (height(ring), (1.0 - height(ring).powi(2)).max(0.0).sqrt());
        for turn in 0..TURNS {
            let (s, c) = (std::f64::consts::TAU * turn as f64 / TURNS as f64).sin_cos();
            writeln!(text, "v {} {y} {}", r * c, r * s).expect("text");
        }
    }
    for ring in 0..RINGS {
        let is_lamp = (height(ring) + height(ring + 1)) / 2.0 < lamp;
        writeln!(text, "usemtl {}", if is_lamp { "lamp" } else { "wall" }).expect("text");
        for turn in 0..TURNS {
            let at = |ring: usize, turn: usize| ring * TURNS + turn % TURNS + 1;
            let [a, b, c, d] = [
                at(ring, turn),
                at(ring, turn + 1),
                at(ring + 1, turn + 1),
                at(ring + 1, turn),
            ];
            writeln!(text, "f {a} {b} {c} {d}").expect("text");
        }
    }
    text
}

pub const SMALL: [&str; 4] = ["--size", "64", "--rays", "64"];

pub fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&SMALL[..], more].concat()
}

/// The report states the root mean square of the page's errors.
fn assert_stated(folder: &Path, page: &Page) {
    let texels = page.plane("error.irradiance").iter();
    let texels = texels.zip(page.plane("coverage")).filter(|t| *t.1 > 0.0);
    let squares: Vec<f64> = texels.map(|t| f64::from(*t.0).powi(2)).collect();
    let expected = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let stated = report(folder)["pages"][0]["irradiance_rmse"].clone();
    let stated = stated.as_f64().expect("an error of the irradiance");
    assert!(
        stated > 0.0 && (stated / expected - 1.0).abs() < 1e-3,
        "{stated} {expected}"
    );
}

#[test]
fn bowl_under_the_sky_is_the_closed_form_of_a_diffuse_cavity() {
    // Half of what any point of a hemisphere sees is sky, the other half is the hemisphere: E = 1/2 + albedo E/2.
    let folder = tempfile::tempdir().expect("a temporary directory");
    let materials = "newmtl wall\nKd 0.8 0.4 0\nnewmtl lamp\nKd 0 0 0\n";
    let path = obj(folder.path(), materials, &bowl(0.0, -9.0));
    let more = [
        "--layers",
        "irradiance,error.irradiance",
        "--bounces",
        "auto",
    ];
    let (folder, page) = bake(&path, &with(&more));
    for (channel, albedo) in [
        ("irradiance.R", 0.8),
        ("irradiance.G", 0.4),
        ("irradiance.B", 0.0),
    ] {
        let exact = 0.5 / (1.0 - 0.5 * albedo);
        let (found, _) = mean(&page, channel);
        // Sixteen flat rings lie within 1 % of the ball's area and light.
        assert!(
            (found - exact).abs() < 0.012 * exact,
            "{channel}: {found}, not {exact}"
        );
    }
    let (diffuse, _) = mean(&page, "diffuse");
    assert!(
        (diffuse - 0.5).abs() < 0.006,
        "diffuse stays geometry: {diffuse}"
    );
    let bounces = &report(folder.path())["bounces"];
    let gathers = bounces["gathers"].as_u64().expect("a number");
    assert!((4..12).contains(&gathers), "{bounces}");
    assert!(
        bounces["missing"].as_f64() <= Some(1.0 / 512.0),
        "{bounces}"
    );
    for (lambert, light, albedo) in [
        ("lambert.R", "irradiance.R", 0.8),
        ("phong.G", "irradiance.G", 0.4),
    ] {
        let pairs = page.plane(lambert).iter().zip(page.plane(light));
        let worst = pairs
            .map(|(l, e)| (l - albedo * e).abs())
            .fold(0.0, f32::max);
        assert!(worst < 1e-6, "{lambert} follows the irradiance: {worst}");
    }
}

#[test]
fn lit_cap_of_a_ball_lights_all_of_it_alike() {
    // From any point of a sphere to any part of it the form factor is the part's share of the sphere, here a quarter
    // that shines at 2.
    let folder = tempfile::tempdir().expect("a temporary directory");
    let materials = "newmtl wall\nKd 0.6 0.6 0.6\nnewmtl lamp\nKd 0.6 0.6 0.6\nKe 2 1 0\n";
    let path = obj(folder.path(), materials, &bowl(1.0, -0.5));
    let share = 0.25;
    for (gathers, sum) in [("1", 1.0), ("2", 1.6), ("auto", 2.5)] {
        let more = [
            "--only",
            "irradiance,error.irradiance,diffuse",
            "--bounces",
            gathers,
        ];
        let (folder, page) = bake(&path, &with(&more));
        assert_stated(folder.path(), &page);
        for (channel, light) in [("irradiance.R", 2.0), ("irradiance.G", 1.0)] {
            let exact = light * share * sum;
            let (found, worst) = mean(&page, channel);
            assert!(
                (found - exact).abs() < 0.015 * exact,
                "{gathers}: {found}, not {exact}"
            );
            let (std_err, _) = mean(&page, "error.irradiance");
            // Facets see a little more or less of the cap than points of a sphere.
            assert!(
                worst < 0.05 * exact + 6.0 * light * std_err,
                "{gathers}: {worst}, {std_err}"
            );
        }
        assert_eq!(mean(&page, "irradiance.B").0, 0.0);
        assert_eq!(mean(&page, "diffuse").0, 0.0, "no sky enters");
    }
}

#[test]
fn facing_squares_exchange_their_view_factor() {
    // Unit squares at distance 1: F = 0.199825 (J. R. Howell, "A Catalog of Radiation Heat Transfer Configuration
    // Factors", C-11).
    let folder = tempfile::tempdir().expect("a temporary directory");
    let materials = "newmtl lamp\nKd 0 0 0\nKe 1 1 1\nnewmtl wall\nKd 0.5 0.5 0.5\n";
    let text = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\n\
                o floor\nusemtl wall\nf 4 3 2 1\no ceiling\nusemtl lamp\nf 5 6 7 8\n";
    let path = obj(folder.path(), materials, text);
    let more = [
        "--only",
        "irradiance,object",
        "--sky",
        "0,0,0",
        "--bounces",
        "3",
    ];
    let (_folder, page) = bake(&path, &with(&more));
    let floor = |of: &[f32]| -> f64 {
        let objects = page.plane("object").iter().zip(of);
        let own = objects
            .zip(page.plane("coverage"))
            .filter(|((object, _), _)| **object == 0.0);
        let (mut sum, mut area) = (0.0, 0.0);
        for ((_, value), coverage) in own {
            sum += f64::from(value * coverage);
            area += f64::from(*coverage);
        }
        sum / area
    };
    let found = floor(page.plane("irradiance.G"));
    assert!((found - 0.199_825).abs() < 5e-4, "{found}");
}

#[test]
fn closed_furnace_is_the_geometric_sum_under_both_models() {
    // All of the inside shines at 1 and reflects half: 1 arrives from the lamps, 1/2, 1/4, … after bounces, in every
    // direction alike.
    let folder = tempfile::tempdir().expect("a temporary directory");
    let materials =
        "newmtl wall\nKd 0.5 0.5 0.5\nKe 1 1 1\nKs 0.25 0.25 0.25\nNs 12\nnewmtl lamp\nKd 0 0 0\n";
    let path = obj(folder.path(), materials, &bowl(1.0, -9.0));
    for (model, gathers, sum) in [
        ("phong", "auto", 2.0),
        ("ggx", "auto", 2.0),
        ("ggx", "2", 1.5),
    ] {
        let more = [
            "--size",
            "48",
            "--rays",
            "32",
            "--model",
            model,
            "--bounces",
            gathers,
            "--only",
            "irradiance,reflection",
        ];
        let (_folder, page) = bake(&path, &more);
        for (channel, most) in [("irradiance.R", 0.01), ("reflection.R", 0.02)] {
            let (found, _) = mean(&page, channel);
            // `auto` leaves out less than 1/512; where facets meet, rays of smooth normals leave the ball now and then.
            assert!(
                (found / sum - 1.0).abs() < most,
                "{model} {gathers} {channel}: {found}, not {sum}"
            );
        }
    }
}

#[test]
fn luminous_picture_lights_as_its_mean() {
    // Four texels, two of them dark, over the middle of a small floor, which sees their back: by symmetry each
    // quarter counts alike.
    let shining = |extra: serde_json::Value| {
        let floor = Quad::level(0.0, 0.02);
        let mut card = Quad::level(1.0, 2.0);
        card.material = 1;
        let folder = quads::write(&[floor, card], extra);
        let (lit, dark) = ([255; 4], [0, 0, 0, 255]);
        quads::picture(&folder, "checker.png", [2, 2], &[lit, dark, dark, lit]);
        let words = [
            "--size",
            "32",
            "--rays",
            "256",
            "--sky",
            "0,0,0",
            "--bounces",
            "1",
            "--uv",
            "unwrap",
            "--density-of",
            "node 0=400",
            "--only",
            "irradiance,object",
        ];
        let (_out, page) = bake(&folder.path().join("scene.gltf"), &words);
        let floor = page.plane("irradiance.R").iter().zip(page.plane("object"));
        let floor = floor.zip(page.plane("coverage"));
        let values: Vec<f64> = floor
            .filter(|((_, object), coverage)| **object == 0.0 && **coverage > 0.5)
            .map(|((value, _), _)| f64::from(*value))
            .collect();
        assert!(!values.is_empty());
        values.iter().sum::<f64>() / values.len() as f64
    };
    let textured = shining(json!({
        "materials": [{}, { "doubleSided": true, "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 } }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "samplers": [{ "magFilter": 9728 }],
        "images": [{ "uri": "checker.png" }],
    }));
    let even = shining(
        json!({ "materials": [{}, { "doubleSided": true, "emissiveFactor": [0.5, 0.5, 0.5] }] }),
    );
    // From below the middle of a square of edge 2 at distance 1: 4/π · 1/√2 · atan(1/√2) of the light of a whole
    // hemisphere.
    let root = 0.5_f64.sqrt();
    let exact = 0.5 * 4.0 / std::f64::consts::PI * root * root.atan();
    for found in [textured, even] {
        assert!((found / exact - 1.0).abs() < 0.02, "{found} for {exact}");
    }
}

#[test]
fn backs_and_excluded_objects_send_no_light() {
    // A ceiling whose front looks up sends nothing down, nor does one without texels; a shining one does.
    let folder = tempfile::tempdir().expect("a temporary directory");
    // So does one that is modelled as two sheets back to back, whichever stands first.
    let materials = "newmtl white\nKd 1 1 1\n";
    let (up, down) = ("f 5 8 7 6\n", "f 5 6 7 8\n");
    for (ceiling, more, lit) in [
        (up.to_owned(), vec![], false),
        (down.to_owned(), vec!["--exclude", "ceiling"], false),
        (down.to_owned(), vec![], true),
        (up.to_owned() + down, vec![], true),
        (down.to_owned() + up, vec!["--backend", "obvhs"], true),
        (up.to_owned() + down, vec!["--backend", "obvhs"], true),
    ] {
        let text = format!(
            "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\n\
             usemtl white\no floor\nf 4 3 2 1\no ceiling\n{ceiling}"
        );
        let path = obj(folder.path(), materials, &text);
        let light = |bounces: &str| {
            let mut words = with(&["--include", "*", "--bounces", bounces]);
            words.extend(["--only", "irradiance,object"].iter().chain(&more));
            let (_folder, page) = bake(&path, &words);
            let objects = page.plane("object").iter().zip(page.plane("irradiance.R"));
            objects
                .filter(|(o, _)| **o == 0.0)
                .map(|(_, e)| f64::from(*e))
                .sum::<f64>()
        };
        let (plain, bounced) = (light("0"), light("1"));
        assert_eq!(
            bounced > 1.02 * plain,
            lit,
            "{ceiling} {more:?}: {plain} {bounced}"
        );
        assert!(
            lit || bounced == plain,
            "{ceiling} {more:?}: {plain} {bounced}"
        );
    }
}

#[test]
fn bounced_bytes_do_not_depend_on_threads_and_none_is_a_plain_bake() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let materials = "newmtl wall\nKd 0.7 0.6 0.5\nKs 0.2 0.2 0.2\nNs 20\nnewmtl lamp\nKe 3 3 3\n";
    let path = obj(folder.path(), materials, &bowl(0.5, -0.9));
    let bytes = |more: &[&str]| {
        let common = [
            "--size",
            "48",
            "--rays",
            "16",
            "--layers",
            "reflection",
            "--gutter",
            "1",
        ];
        let (folder, _) = bake(&path, &[&common[..], more].concat());
        let pages = files(folder.path())
            .into_iter()
            .filter(|name| name.ends_with(".png"));
        pages
            .map(|name| std::fs::read(folder.path().join(name)).expect("a file"))
            .collect::<Vec<_>>()
    };
    let bounced = [
        "--bounces",
        "2",
        "--denoise",
        "regression",
        "--density",
        "15",
    ];
    let one = bytes(&[&bounced[..], &["--threads", "1"]].concat());
    let three = bytes(&[&bounced[..], &["--threads", "3"]].concat());
    assert!(one == three, "one thread and three give the same bytes");
    assert!(bytes(&["--bounces", "0"]) == bytes(&[]), "0 is the default");
    assert!(bytes(&["--bounces", "1"]) != bytes(&[]), "one gather shows");
}

#[test]
fn plan_says_why_light_bounces_or_does_not() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let reason = |materials: &str, top: f64, more: &[&str]| -> String {
        let path = obj(folder.path(), materials, &bowl(top, -0.9));
        let mut words = vec![
            "plan",
            path.to_str().expect("UTF-8"),
            "--size",
            "32",
            "--rays",
            "4",
        ];
        words.extend(more);
        let text = run_well(words);
        let line = text.lines().find(|line| line.starts_with("bounces"));
        line.expect("a line on bounces").to_owned()
    };
    let dark = "newmtl wall\nKd 0 0 0\nnewmtl lamp\nKd 0 0 0\n";
    let white = "newmtl wall\nKd 1 1 1\nnewmtl lamp\nKd 0 0 0\nKe 1 1 1\n";
    assert!(reason(white, 0.0, &[]).contains("left out  not asked for"));
    assert!(reason(dark, 0.0, &["--bounces", "2"]).contains("left out  no material"));
    let only = ["--bounces", "2", "--only", "diffuse"];
    assert!(reason(white, 0.0, &only).contains("left out  no asked layer"));
    let lit = reason(white, 0.0, &["--bounces", "auto"]);
    assert!(
        lit.contains("modelled") && lit.contains("1 of 2 materials reflect"),
        "{lit}"
    );
    assert!(lit.contains("1 shine") && lit.contains("--albedo"), "{lit}");
    let wrong = run(["bake", "a.obj", "-o", "b", "--bounces", "many"]);
    assert_eq!(wrong.status.code(), Some(2));
}

#[test]
fn a_plan_counts_the_rays_of_the_gathers_within_30_percent() {
    let folder = tempfile::tempdir().expect("a folder");
    // Half of a ball with walls of albedo 0.7: all that is received comes from the opening.
    let bowl = obj(
        folder.path(),
        "newmtl lamp\nKd 0.7 0.7 0.7\nnewmtl wall\nKd 0.7 0.7 0.7\n",
        &bowl(0.0, -1.0),
    );
    let bowl = bowl.display().to_string();
    for bounces in ["1", "3", "auto"] {
        let words = [&["plan", &bowl, "--json", "--bounces", bounces][..], &SMALL].concat();
        let planned: serde_json::Value = serde_json::from_str(&run_well(words)).expect("JSON");
        let (baked, _) = bake(
            Path::new(&bowl),
            &[&["--bounces", bounces][..], &SMALL].concat(),
        );
        let [planned, took] = [
            planned["estimate"]["rays"].as_f64(),
            report(baked.path())["rays"].as_f64(),
        ]
        .map(|rays| rays.expect("rays"));
        assert!(
            (planned / took - 1.0).abs() < 0.3,
            "{bounces}: {planned} for {took}"
        );
    }
}
