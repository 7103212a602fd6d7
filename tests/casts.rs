//! Objects that block no light.

use crate::bounces::{mean, obj};
use crate::quads::{self, Quad};
use crate::support::{Page, backends, bake, report, run_well};
use serde_json::{Value, json};

const SMALL: [&str; 6] = [
    "--size",
    "64",
    "--rays",
    "16",
    "--only",
    "diffuse,object,validity",
];

/// The mean of a channel over the texels of an object.
fn of_object(page: &Page, object: f32, channel: &str) -> f64 {
    let texels = page.plane("object").iter().zip(page.plane(channel));
    let own: Vec<f64> = texels
        .filter(|(number, _)| **number == object)
        .map(|(_, value)| f64::from(*value))
        .collect();
    assert!(own.len() > 50, "{} texels", own.len());
    own.iter().sum::<f64>() / own.len() as f64
}

#[test]
fn what_casts_nothing_hides_nothing_and_takes_texels() {
    let folder = tempfile::tempdir().expect("a folder");
    // A roof of the floor's size over it, and a box that is sunk into it by half.
    let text = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 1 -1\nv 1 1 -1\nv 1 1 1\nv -1 1 1\n\
        v -.5 -.5 -.5\nv .5 -.5 -.5\nv .5 -.5 .5\nv -.5 -.5 .5\nv -.5 .5 -.5\nv .5 .5 -.5\nv .5 .5 .5\nv -.5 .5 .5\n\
        o floor\nf 4 3 2 1\no roof\nf 8 7 6 5\n\
        o box\nf 9 10 11 12\nf 16 15 14 13\nf 9 13 14 10\nf 10 14 15 11\nf 11 15 16 12\nf 12 16 13 9\n";
    let path = obj(folder.path(), "", text);
    for backend in backends() {
        let with =
            |more: &[&str]| bake(&path, &[&SMALL[..], &["--backend", backend], more].concat()).1;
        let plain = with(&[]);
        assert!(of_object(&plain, 0.0, "diffuse") < 0.8);
        assert!(
            of_object(&plain, 0.0, "validity") < 0.9,
            "the box buries a quarter of the floor"
        );
        let open = with(&["--no-cast", "roof", "--no-cast", "b?x"]);
        assert_eq!(of_object(&open, 0.0, "diffuse"), 1.0);
        assert_eq!(of_object(&open, 0.0, "validity"), 1.0);
        assert_eq!(
            of_object(&open, 1.0, "diffuse"),
            1.0,
            "nothing stands above the roof"
        );
        // The floor goes on hiding the sky from the lower half of the box, whose top sees all of it.
        let of_box = of_object(&open, 2.0, "diffuse");
        assert!(of_box > 0.1 && of_box < 0.9, "{of_box}");
    }
}

#[test]
fn a_file_says_by_its_extras_what_casts_nothing() {
    for (list, said, open) in [
        ("nodes", json!(false), true),
        ("meshes", json!(false), true),
        ("nodes", json!(true), false),
    ] {
        let folder = quads::write(&[Quad::level(0.0, 2.0), Quad::level(0.5, 2.0)], json!({}));
        let path = folder.path().join("scene.gltf");
        let text = std::fs::read_to_string(&path).expect("the scene");
        let mut document: Value = serde_json::from_str(&text).expect("JSON");
        document["materials"] = json!([{}]);
        document[list][1]["extras"] = json!({ "ambake": { "cast": said } });
        std::fs::write(&path, document.to_string()).expect("a file");
        let (_folder, page) = bake(&path, &SMALL);
        let floor = of_object(&page, 0.0, "diffuse");
        assert_eq!(floor == 1.0, open, "{list} {said}: {floor}");
    }
}

/// Bakes two level quads of which a file says something; the report, and the page.
fn told(change: impl Fn(&mut Value)) -> (Value, Page) {
    let folder = quads::write(&[Quad::level(0.0, 2.0), Quad::level(0.5, 2.0)], json!({}));
    let path = folder.path().join("scene.gltf");
    let text = std::fs::read_to_string(&path).expect("the scene");
    let mut document: Value = serde_json::from_str(&text).expect("JSON");
    document["materials"] = json!([{}]);
    change(&mut document);
    std::fs::write(&path, document.to_string()).expect("a file");
    let (folder, page) = bake(&path, &SMALL);
    (report(folder.path()), page)
}

#[test]
fn what_a_node_says_holds_below_it_unless_that_says_otherwise() {
    for (own, open) in [(json!({}), true), (json!({ "cast": true }), false)] {
        let (_, page) = told(|document| {
            document["nodes"][1]["extras"] = json!({ "ambake": own });
            let group = json!({ "children": [1], "extras": { "ambake": { "cast": false } } });
            document["nodes"]
                .as_array_mut()
                .expect("a list")
                .push(group);
            document["scenes"][0]["nodes"] = json!([0, 2]);
        });
        let floor = of_object(&page, 0.0, "diffuse");
        assert_eq!(floor == 1.0, open, "{own}: {floor}");
    }
}

#[test]
fn a_file_says_what_takes_no_texels_and_a_misspelt_name_is_told() {
    let (report, page) = told(|document| {
        document["nodes"][1]["extras"] = json!({ "ambake": { "bake": false, "casts": false } });
    });
    let objects = page.plane("object").iter().zip(page.plane("coverage"));
    assert!(
        objects
            .filter(|(_, c)| **c > 0.0)
            .all(|(object, _)| *object == 0.0)
    );
    assert!(
        of_object(&page, 0.0, "diffuse") < 0.9,
        "it still blocks light"
    );
    let warnings = report["warnings"].as_array().expect("a list").iter();
    let told: Vec<_> = warnings.filter(|w| w["kind"] == "unknown-extras").collect();
    assert!(
        told.len() == 1
            && told[0]["message"]
                .as_str()
                .is_some_and(|m| m.contains("`casts`")),
        "{told:?}"
    );
}

#[test]
fn what_stands_around_everything_in_the_dark_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\n\
        v -5 -5 -5\nv 5 -5 -5\nv 5 -5 5\nv -5 -5 5\nv -5 5 -5\nv 5 5 -5\nv 5 5 5\nv -5 5 5\n\
        o floor\nf 4 3 2 1\no dome\nf 8 7 6 5\nf 9 10 11 12\nf 6 10 9 5\nf 7 11 10 6\nf 8 12 11 7\nf 5 9 12 8\n";
    let path = obj(folder.path(), "", text);
    let small = ["--size", "64", "--rays", "4", "--only", "diffuse"];
    let (baked, page) = bake(&path, &small);
    assert_eq!(mean(&page, "diffuse").0, 0.0);
    let told = |report: &Value| -> Vec<String> {
        let warnings = report["warnings"].as_array().expect("a list").iter();
        let own = warnings.filter(|warning| warning["kind"] == "enclosed");
        own.map(|warning| format!("{}: {}", warning["place"], warning["message"]))
            .collect()
    };
    let said = told(&report(baked.path()));
    assert!(
        said.len() == 1 && said[0].contains("dome") && said[0].contains("--no-cast"),
        "{said:?}"
    );
    let without = [&small[..], &["--no-cast", "dome", "--exclude", "dome"]].concat();
    let (baked, page) = bake(&path, &without);
    assert_eq!(mean(&page, "diffuse").0, 1.0);
    assert!(told(&report(baked.path())).is_empty());
    // A dome that looks outward is a solid, and what is in it lies in that.
    let turn = |line: &str| match line.strip_prefix("f ") {
        Some(corners) => format!(
            "f {}\n",
            corners.split(' ').rev().collect::<Vec<_>>().join(" ")
        ),
        None => format!("{line}\n"),
    };
    let (floor, dome) = text.split_once("o dome\n").expect("two objects");
    let turned: String = dome.lines().map(turn).collect();
    let path = obj(folder.path(), "", &format!("{floor}o dome\n{turned}"));
    let (baked, _) = bake(&path, &small);
    let said = told(&report(baked.path()));
    assert!(
        said.len() == 1 && said[0].contains("dome") && said[0].contains("solid"),
        "{said:?}"
    );
    let (baked, page) = bake(&path, &without);
    assert_eq!(mean(&page, "diffuse").0, 1.0);
    assert!(told(&report(baked.path())).is_empty());
}

/// A box whose front is outward, as an object.
fn cuboid(name: &str, low: [f64; 3], high: [f64; 3]) -> String {
    let mut text = format!("o {name}\n");
    for k in 0..8 {
        let [x, y, z] = [0, 1, 2].map(|axis| [low, high][k >> axis & 1][axis]);
        text += &format!("v {x} {y} {z}\n");
    }
    let sides = [
        [1, 3, 4, 2],
        [5, 6, 8, 7],
        [1, 2, 6, 5],
        [3, 7, 8, 4],
        [1, 5, 7, 3],
        [2, 4, 8, 6],
    ];
    for side in sides {
        let corners = side.map(|corner: i32| (corner - 9).to_string());
        text += &format!("f {}\n", corners.join(" "));
    }
    text
}

/// A convex body under the open sky is 1. In the body around it, it is buried, though others stand out of that.
#[test]
fn what_lies_whole_in_a_solid_is_named_with_the_flags_that_mend_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let hull = cuboid("hull", [-2.0; 3], [2.0; 3]);
    let others = ["flag", "mast"].map(|name| {
        let x = if name == "flag" { 400.0 } else { -400.0 };
        cuboid(name, [x, 0.0, 0.0], [x + 2.0, 2.0, 2.0])
    });
    let small = ["--size", "64", "--rays", "4", "--only", "diffuse,object"];
    let told = |within: &str, more: &[&str]| {
        let text = [&hull, within, &others.concat()].concat();
        let path = obj(folder.path(), "", &text);
        let (baked, page) = bake(&path, &[&small[..], more].concat());
        let report = report(baked.path());
        let warnings = report["warnings"].as_array().expect("a list").iter();
        let own = warnings.filter(|warning| warning["kind"] == "enclosed");
        let lines = own.map(|warning| format!("{}: {}", warning["place"], warning["message"]));
        (lines.collect::<Vec<_>>(), page)
    };
    let car = cuboid("car", [-1.0; 3], [1.0; 3]);
    let (lines, _) = told(&car, &[]);
    assert!(
        lines.len() == 1
            && lines[0].contains("object `hull`")
            && lines[0].contains("`car`:")
            && lines[0].contains("`--no-cast hull --exclude hull`")
            && lines[0].contains("`--exclude car`"),
        "{lines:?}"
    );
    let two = car.clone() + &cuboid("wheel", [1.0, -1.0, -1.0], [1.9, 0.0, 0.0]);
    let (lines, _) = told(&two, &["--max-distance", "9"]);
    assert!(
        lines.len() == 1 && lines[0].contains("`car` and of 1 more:"),
        "{lines:?}"
    );
    let (lines, page) = told(&car, &["--no-cast", "hull", "--exclude", "hull"]);
    let light = of_object(&page, 1.0, "diffuse");
    assert!(lines.is_empty() && light > 0.999, "{lines:?}, {light}");
    for (what, within) in [
        (
            "a core of less than a hundredth",
            cuboid("core", [-0.2; 3], [0.2; 3]),
        ),
        ("a half", cuboid("half", [-1.0; 3], [5.0, 1.0, 1.0])),
        (
            "a post through",
            cuboid("post", [-0.5, -3.0, -0.5], [0.5, 3.0, 0.5]),
        ),
    ] {
        assert_eq!(told(&within, &[]).0, [""; 0], "{what}");
    }
    assert_eq!(
        told(&car, &["--exclude", "car"]).0,
        [""; 0],
        "it takes no texels"
    );
}

/// A track of 2.4 by 60 in the middle of a tunnel of radius 2 that is open at both ends.
#[test]
fn a_tunnel_with_open_ends_keeps_the_sky_from_no_track() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = |length: f64| {
        let mut text = "o tunnel\n".to_owned();
        for k in 0..24 {
            let (y, x) = (f64::from(k) * std::f64::consts::TAU / 24.0).sin_cos();
            for z in [0.0, -length] {
                text += &format!("v {} {} {z}\n", 2.0 * x, 2.0 + 2.0 * y);
            }
        }
        for k in 0..24 {
            let [a, b] = [k, (k + 1) % 24].map(|k| 2 * k + 1);
            text += &format!("f {b} {} {} {a}\n", b + 1, a + 1);
        }
        text += "o track\n";
        for [x, z] in [[-1.2, 0.0], [1.2, 0.0], [1.2, -length], [-1.2, -length]] {
            text += &format!("v {x} 0.5 {z}\n");
        }
        let path = obj(folder.path(), "", &(text + "f -4 -3 -2 -1\n"));
        let small = ["--size", "64", "--rays", "64", "--only", "diffuse,object"];
        let (baked, page) = bake(&path, &small);
        let report = report(baked.path());
        let mut warnings = report["warnings"].as_array().expect("a list").iter();
        let line = warnings.find(|warning| warning["kind"] == "enclosed");
        (page, line.map(|line| line["message"].to_string()))
    };
    let (page, line) = told(60.0);
    let light = of_object(&page, 1.0, "diffuse");
    assert!(light > 0.02 && line.is_none(), "{light}: {line:?}");
    let line = told(6000.0).1.expect("a line");
    assert!(line.contains("sees next to no sky"), "{line}");
}

/// Two sheets that cross under the open sky: what of each lies below the other is dark, and neither is a dome.
#[test]
fn a_sea_over_the_half_of_a_beach_is_no_dome() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "v -9 -1 -9\nv -9 -1 9\nv 9 1 9\nv 9 1 -9\nv -10 0 -10\nv -10 0 10\nv 10 0 10\nv 10 0 -10\n\
        o sand\nf 1 2 3\nf 1 3 4\no sea\nf 5 6 7\nf 5 7 8\n";
    let path = obj(folder.path(), "", text);
    let (baked, _) = bake(&path, &["--size", "64", "--rays", "4", "--only", "diffuse"]);
    let report = report(baked.path());
    let mut warnings = report["warnings"].as_array().expect("a list").iter();
    assert!(
        warnings.all(|warning| warning["kind"] != "enclosed"),
        "{report}"
    );
}

/// Half a dome of radius 30, its front outward, over a house that stands on a square ground of `reach` to each side.
/// The dome has these rings of 8, from the ground up, and so many of 24 sectors.
fn under_a_dome(reach: u32, rings: std::ops::Range<u32>, sectors: u32) -> String {
    let around = 24;
    let mut text = format!(
        "v -{reach} 0 -{reach}\nv {reach} 0 -{reach}\nv {reach} 0 {reach}\nv -{reach} 0 {reach}\no ground\nf 4 3 2 1\n"
    );
    for [x, y, z] in [[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]] {
        text += &format!("v {x} {y} {z}\nv {x} 2 {z}\n");
    }
    text += "o house\nf 6 12 10 8\nf 5 7 9 11\nf 5 6 8 7\nf 7 8 10 9\nf 9 10 12 11\nf 11 12 6 5\n";
    for ring in 0..=8 {
        let (sin, cos) = (f64::from(ring) / 8.0 * std::f64::consts::FRAC_PI_2).sin_cos();
        for k in 0..around {
            let (s, c) = (f64::from(k) / f64::from(around) * std::f64::consts::TAU).sin_cos();
            text += &format!("v {} {} {}\n", 30.0 * cos * c, 30.0 * sin, 30.0 * cos * s);
        }
    }
    text += "o sky\n";
    for ring in rings {
        for k in 0..sectors {
            let [a, b] = [k, (k + 1) % around].map(|k| 13 + ring * around + k);
            text += &format!("f {a} {} {} {b}\n", a + around, b + around);
        }
    }
    text
}

#[test]
fn a_dome_is_named_though_its_outside_and_the_ground_beyond_are_lit() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = obj(folder.path(), "", &under_a_dome(50, 0..8, 24));
    let small = ["--size", "64", "--rays", "4", "--only", "diffuse"];
    let warned = |more: &[&str]| {
        let (baked, _) = bake(&path, &[&small[..], more].concat());
        let report = report(baked.path());
        let warnings = report["warnings"].as_array().expect("a list").iter();
        warnings
            .filter(|w| w["kind"] == "enclosed" && w["place"] == "object `sky`")
            .count()
    };
    assert_eq!((warned(&[]), warned(&["--no-cast", "sky"])), (1, 0));
    // Pictures are taken from within it: the ground beyond would be seen from 100 away.
    let (baked, _) = bake(&path, &small[..4]);
    let [scene, of] = [&path, baked.path()].map(|path| path.display().to_string());
    let picture = folder.path().join("x.png").display().to_string();
    let size = ["--size", "16x9", "--samples", "1", "--json"];
    let said = run_well(
        [
            &["render", &scene, "--bake", &of, "-o", &picture],
            &size[..],
        ]
        .concat(),
    );
    let said: Value = serde_json::from_str(&said).expect("JSON");
    let eye = said["options"]["eye"].as_array().expect("an eye").iter();
    let away = eye
        .map(|x| x.as_f64().expect("a number").powi(2))
        .sum::<f64>();
    assert!(away.sqrt() < 30.0, "{said}");
}

/// The bottom of the house lies in the ground, and looks at a sky below it. That is no light that gets in.
#[test]
fn a_dome_that_ends_in_the_plane_of_the_ground_is_named_and_a_tent_and_a_hangar_are_not() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, reach, rings, sectors, expected) in [
        ("a dome", 50, 0..8, 24, 1),
        ("a dome that ends beyond the ground", 20, 0..8, 24, 1),
        ("a dome without a ground", 0, 0..8, 24, 1),
        ("a tent on poles without a ground", 0, 1..8, 24, 0),
        ("a tent on poles", 50, 1..8, 24, 0),
        ("a tent on poles, beyond the ground", 20, 1..8, 24, 0),
        ("a hangar, open by a quarter", 50, 0..8, 18, 0),
        ("a roof", 50, 4..8, 24, 0),
    ] {
        let path = obj(folder.path(), "", &under_a_dome(reach, rings, sectors));
        let (baked, _) = bake(&path, &["--size", "64", "--rays", "4", "--only", "diffuse"]);
        let report = report(baked.path());
        let warnings = report["warnings"].as_array().expect("a list").iter();
        let named = warnings.filter(|w| w["kind"] == "enclosed").count();
        assert_eq!(named, expected, "{name}: {}", report["warnings"]);
    }
}

#[test]
fn bodies_for_collisions_and_navigation_meshes_are_told_of_by_their_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let square = |name: &str, y: usize, first: usize| {
        let corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
        let corners = corners.map(|[x, z]| format!("v {x} {y} {z}\n")).concat();
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| first + k);
        format!("{corners}o {name}\nf {d} {c} {b} {a}\n")
    };
    for (name, expected) in [
        ("UCX_floor", true),
        ("Fence_Collider", true),
        ("floor-convcolonly", true),
        ("floor-col", false),
        ("truck_ucx_", false),
        ("column", false),
        ("Navmesh", true),
        ("nav_mesh.001", true),
        ("NavMesh_Exported_NavMesh", true),
        ("Navigation-Mesh1", true),
        ("NavMeshAgent", false),
        ("canav_mesh", false),
        ("mesh_nav", false),
    ] {
        let text = square("floor", 0, 1) + &square(name, 1, 5);
        let path = obj(folder.path(), "", &text);
        let told = |flags: &[&str]| {
            let small = ["--size=64", "--rays=4", "--only=diffuse"];
            let (baked, _) = bake(&path, &[&small[..], flags].concat());
            let report = report(baked.path());
            let warnings = report["warnings"].as_array().expect("a list").iter();
            let own = warnings.filter(|of| of["kind"] == "collision-bodies");
            own.map(|of| (of["count"].clone(), of["place"].clone()))
                .collect::<Vec<_>>()
        };
        let own = (json!(1), json!(format!("object `{name}`")));
        assert_eq!(
            told(&[]),
            if expected { vec![own] } else { vec![] },
            "{name}"
        );
        assert!(told(&["--exclude", name]).is_empty(), "{name}");
    }
}
