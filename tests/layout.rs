//! Where the texels go: the default rule, names, pages.

use crate::support::{BOX_SIDES, run, run_well, scene};
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Boxes on a large ground: houses of 10 and crates of 1 on 2,000 units.
fn town(folder: &Path) -> PathBuf {
    let mut obj = String::from(
        "o ground\nv -1000 0 -1000\nv -1000 0 1000\nv 1000 0 1000\nv 1000 0 -1000\nf 1 2 3 4\n",
    );
    let mut first = 5;
    let mut put = |name: String, [x, z]: [f64; 2], edge: f64| {
        writeln!(obj, "o {name}").expect("memory");
        for corner in 0..8 {
            let at = |bit: u32| if corner >> bit & 1 == 1 { edge } else { 0.0 };
            writeln!(obj, "v {} {} {}", x + at(0), at(1), z + at(2)).expect("memory");
        }
        for face in BOX_SIDES {
            let [a, b, c, d] = face.map(|k| first + k);
            writeln!(obj, "f {a} {b} {c} {d}").expect("memory");
        }
        first += 8;
    };
    for k in 0..20 {
        let along = 15.0 * f64::from(k);
        put(format!("house_{k}"), [along, 0.0], 10.0);
        put(format!("crate_{k}"), [along, 20.0], 1.0);
    }
    let file = folder.join("town.obj");
    std::fs::write(&file, obj).expect("a scene file");
    file
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a UTF-8 path")
}

/// The `layout` that `ambake plan --json` prints.
fn planned(arguments: &[&str]) -> Value {
    let printed = run_well([&["plan", "--json", "--rays=1"], arguments].concat());
    let plan: Value = serde_json::from_str(&printed).expect("JSON");
    plan["layout"].clone()
}

fn object<'a>(layout: &'a Value, name: &str) -> &'a Value {
    let objects = layout["objects"].as_array().expect("a list of objects");
    objects
        .iter()
        .find(|o| o["name"] == name)
        .unwrap_or_else(|| panic!("{name} is not in {layout}"))
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn houses_and_crates_on_a_large_ground_have_four_times_its_density() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let layout = planned(&[text(&town(folder.path()))]);
    let density = |name: &str| number(&object(&layout, name)["density"]);
    for name in ["house_0", "crate_0", "crate_19"] {
        let times = density(name) / density("ground");
        assert!((times / 4.0 - 1.0).abs() < 0.02, "{name}: {times}");
    }
    assert!(number(&layout["page_use"]) > 0.85, "{}", layout["page_use"]);
    let spread = &layout["texels_per_unit"];
    assert_eq!(
        number(&spread["min"]),
        number(&object(&layout, "ground")["density"])
    );
    assert!(number(&spread["median"]) <= number(&spread["max"]));
    assert_eq!(number(&layout["triangles_under_one_texel"]), 0.0);
}

#[test]
fn a_density_by_name_is_law() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let file = town(folder.path());
    let layout = planned(&[
        text(&file),
        "--density-of=house_*=3",
        "--density-of=house_1?=2",
        "--density-of=ground=0.05",
    ]);
    for (name, asked) in [("house_0", 3.0), ("house_13", 2.0), ("ground", 0.05)] {
        let density = number(&object(&layout, name)["density"]);
        assert!((density / asked - 1.0).abs() < 1e-3, "{name}: {density}");
    }
    let layout = planned(&[text(&file), "--density=0.4", "--size=1024"]);
    for name in ["ground", "house_0", "crate_0"] {
        let density = number(&object(&layout, name)["density"]);
        assert!((density / 0.4 - 1.0).abs() < 1e-3, "{name}: {density}");
    }
}

#[test]
fn a_density_in_the_extras_of_a_node_or_its_mesh_holds_until_a_flag_says_another() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let given = std::fs::read_to_string(scene("instances.gltf")).expect("a scene");
    let given: Value = serde_json::from_str(&given).expect("JSON");
    let density = |value: Value| serde_json::json!({"ambake": {"density": value}});
    let file = folder.path().join("dense.gltf");
    let write = |node: Value| {
        let mut gltf = given.clone();
        // Six nodes show the second mesh; one of them has a say of its own.
        gltf["meshes"][1]["extras"] = density(9.into());
        let turned = gltf["nodes"].as_array_mut().expect("nodes");
        let turned = turned.iter_mut().find(|node| node["name"] == "turned");
        turned.expect("a node")["extras"] = density(node);
        std::fs::write(&file, gltf.to_string()).expect("a scene file");
    };
    write(15.into());
    let of = |flags: &[&str], name: &str| {
        let layout = planned(&[&[text(&file), "--size=512"], flags].concat());
        number(&object(&layout, name)["density"])
    };
    let holds = |found: f64, asked: f64| assert!((found / asked - 1.0).abs() < 1e-3, "{found}");
    holds(of(&[], "plain"), 9.0);
    holds(of(&[], "turned"), 15.0);
    holds(of(&["--density-of=turned=12"], "turned"), 12.0);
    holds(of(&["--density-of=turned=12"], "plain"), 9.0);
    for wrong in [0.into(), Value::from(-3), "many".into()] {
        write(wrong.clone());
        let output = run(["plan", text(&file)]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{wrong}: {errors}");
        assert_eq!(errors.lines().count(), 1, "{errors}");
        assert!(
            errors.contains("turned") && errors.contains(&wrong.to_string()),
            "{errors}"
        );
    }
}

#[test]
fn an_excluded_object_has_no_texels_but_still_blocks_the_sky() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let out = folder.path().join("out");
    let bake = |more: &[&str]| -> Value {
        let file = scene("instances.gltf");
        let start = [
            "bake",
            text(&file),
            "-o",
            text(&out),
            "--size=128",
            "--rays=16",
            "--json",
        ];
        serde_json::from_str(&run_well([&start, more].concat())).expect("JSON")
    };
    let report = bake(&["--include=receiver_*"]);
    let objects = report["layout"]["objects"].as_array().expect("objects");
    let lit: Vec<&Value> = objects
        .iter()
        .filter(|o| number(&o["texels"]) > 0.0)
        .collect();
    assert_eq!(lit.len(), 1, "{lit:?}");
    assert!(
        report["plan"]
            .to_string()
            .contains("have nothing above them")
            || report["rays"].as_u64() > Some(0)
    );
    // The GLB is whole: the excluded objects have their geometry and no lightmap.
    let again = run(["plan", text(&out.join("instances.glb")), "--rays=1"]);
    assert!(
        again.status.success(),
        "{}",
        String::from_utf8_lossy(&again.stderr)
    );
}

#[test]
fn a_name_that_fits_nothing_is_one_line_that_says_what_there_is() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let file = town(folder.path());
    for flag in ["--include=barn*", "--exclude=barn*", "--density-of=barn*=3"] {
        let output = run(["plan", text(&file), flag]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{flag}: {errors}");
        assert_eq!(errors.lines().count(), 1, "{errors}");
        assert!(
            errors.contains("barn*") && errors.contains("`ground`"),
            "{errors}"
        );
    }
    for flag in [
        "--density-of=ground",
        "--density-of=ground=0",
        "--pages=0",
        "--pages=many",
    ] {
        let output = run(["plan", text(&file), flag]);
        assert_eq!(output.status.code(), Some(2), "{flag}");
    }
}

#[test]
fn pages_are_added_where_one_is_too_small_and_limited_on_demand() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let file = town(folder.path());
    let pages = |arguments: &[&str]| -> u64 {
        let start = ["plan", text(&file), "--json", "--rays=1"];
        let printed = run_well([&start, arguments].concat());
        let plan: Value = serde_json::from_str(&printed).expect("JSON");
        plan["atlas"]["pages"].as_u64().expect("a number of pages")
    };
    assert_eq!(pages(&["--size=256"]), 1);
    assert!(pages(&["--size=64"]) > 1);
    // The ground is one chart, which fills a page; what has four times its density fills no more than another.
    assert_eq!(pages(&["--size=256", "--pages=3"]), 2);
    assert_eq!(
        pages(&["--size=256", "--pages=3", "--density-of=house_*=2.5"]),
        3
    );
    let output = run(["plan", text(&file), "--size=64", "--pages=1"]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains("`--size` or `--pages`"), "{errors}");
}

#[test]
fn what_no_eye_sees_takes_a_texel() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let file = town(folder.path());
    let share = |eye: &str, name: &str| {
        let layout = planned(&[text(&file), "--size=512", &format!("--seen-from={eye}")]);
        number(&object(&layout, name)["share"])
    };
    // Low before the first house, looking along the row: the houses behind it show a side at most.
    let whole = number(&object(&planned(&[text(&file), "--size=512"]), "house_10")["share"]);
    assert!(share("-50,5,5", "house_10") < 0.2 * whole, "{whole}");
    // From inside a house nothing else is seen, and a box around the town sees it all.
    assert!(share("5,5,5", "house_10") < 1e-3);
    assert!(share("-500,0.1,-500:500,100,500", "house_10") > 0.5 * whole);
    for wrong in [
        "--seen-from=1,2",
        "--seen-from=1,2,3;",
        "--seen-from=1,2,3:4",
    ] {
        assert_eq!(
            run(["plan", text(&file), wrong]).status.code(),
            Some(2),
            "{wrong}"
        );
    }
}

/// Boxes between these corners, each an object.
fn boxes(path: &Path, all: &[(&str, [f64; 3], [f64; 3])]) {
    let mut obj = String::new();
    for (name, low, high) in all {
        writeln!(obj, "o {name}").expect("memory");
        for corner in 0..8 {
            let at = |axis: usize| [low, high][corner >> axis & 1][axis];
            writeln!(obj, "v {} {} {}", at(0), at(1), at(2)).expect("memory");
        }
        for face in [
            "1 5 7 3", "2 4 8 6", "1 2 6 5", "3 7 8 4", "1 3 4 2", "5 6 8 7",
        ] {
            let corners = face
                .split(' ')
                .map(|k| k.parse::<i32>().expect("a number") - 9);
            let corners: Vec<String> = corners.map(|k| k.to_string()).collect();
            writeln!(obj, "f {}", corners.join(" ")).expect("memory");
        }
    }
    std::fs::write(path, obj).expect("a scene file");
}

#[test]
fn outsides_of_rooms_are_told_of_and_found_without_coordinates() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let room = [
        ("floor", [0.0, -0.2, 0.0], [6.0, 0.0, 6.0]),
        ("ceiling", [0.0, 3.0, 0.0], [6.0, 3.2, 6.0]),
        ("west", [-0.2, -0.2, -0.2], [0.0, 3.2, 6.2]),
        ("east", [6.0, -0.2, -0.2], [6.2, 3.2, 6.2]),
        ("north", [0.0, -0.2, -0.2], [6.0, 3.2, 0.0]),
        ("south", [0.0, -0.2, 6.0], [6.0, 3.2, 6.2]),
        ("table", [2.0, 0.7, 2.0], [4.0, 0.8, 3.0]),
    ];
    let file = folder.path().join("room.obj");
    boxes(&file, &room);
    let plan = |more: &[&str]| -> Value {
        let words = [
            &["plan", "--json", "--rays=1", "--size=256", text(&file)][..],
            more,
        ]
        .concat();
        serde_json::from_str(&run_well(words)).expect("JSON")
    };
    let told = |plan: &Value| {
        let warnings = plan["warnings"].as_array().expect("a list").iter();
        warnings.filter(|w| w["kind"] == "outsides").count()
    };
    let density = |plan: &Value, name: &str| number(&object(&plan["layout"], name)["density"]);
    let (plain, auto) = (plan(&[]), plan(&["--seen-from=auto"]));
    assert_eq!((told(&plain), told(&auto)), (1, 0), "{plain}");
    // Of each slab one large side is seen, and the other is as large: what is seen has nearly twice the texels.
    // The density of an object counts what nobody sees too.
    let more = density(&auto, "table") / density(&plain, "table");
    assert!(more > 1.3, "{more}");
    assert!(density(&auto, "floor") > density(&plain, "floor"));
    // Nobody is inside of a table that stands in the open.
    let file = folder.path().join("open.obj");
    boxes(&file, &room[..1]);
    let plan = |more: &[&str]| planned(&[&["--size=256", text(&file)], more].concat());
    assert_eq!(plan(&["--seen-from=auto"]), plan(&[]));
    let both = run(["plan", text(&file), "--seen-from=auto;1,2,3"]);
    assert_eq!(both.status.code(), Some(1));
}

#[test]
fn an_even_density_is_one_for_all_and_the_largest_that_fits() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let file = town(folder.path());
    let layout = planned(&[text(&file), "--size=512", "--density=even"]);
    let objects = layout["objects"].as_array().expect("objects");
    let densities: Vec<f64> = objects.iter().map(|o| number(&o["density"])).collect();
    let first = densities[0];
    assert!(
        densities.iter().all(|d| (d / first - 1.0).abs() < 1e-4),
        "{densities:?}"
    );
    // They are measured on coordinates of 32 bits. The ground of 2,000 units nearly fills the page with its
    // gutters of 2.
    assert!((0.22..=0.254).contains(&first), "{first}");
    let two = planned(&[text(&file), "--size=512", "--density=even", "--pages=2"]);
    let two = number(&object(&two, "ground")["density"]);
    assert!(two >= first, "{two} on two pages");
    // A density by name stays law.
    let named = planned(&[
        text(&file),
        "--size=512",
        "--density=even",
        "--density-of=house_1=3",
    ]);
    assert!((number(&object(&named, "house_1")["density"]) - 3.0).abs() < 1e-3);
    let others = number(&object(&named, "house_2")["density"]);
    assert!(others < first, "{others}");
}
