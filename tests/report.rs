//! `STEM.lit.png`, `report.html` and what opens it: `ambake view` and `bake --report`.

use crate::support::{BOX_SIDES, bake, files, node, page_path, report, run, run_well, say, scene};
use serde_json::Value;
use std::fs;
use std::path::Path;

fn bytes(path: &Path) -> Vec<u8> {
    let image = image::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    image.to_rgb8().into_raw()
}

#[test]
fn every_bake_ends_with_a_picture_that_render_makes_again() {
    let (folder, _) = bake(
        &scene("interior.gltf"),
        &[
            "--size",
            "128",
            "--rays",
            "64",
            "--exclude",
            "chair_2",
            "--sky",
            "3,3,3",
        ],
    );
    let lit = folder.path().join("interior.lit.png");
    let listed = report(folder.path())["files"].to_string();
    assert!(listed.contains("\"interior.lit.png\""), "{listed}");
    let again = folder.path().join("again.png").display().to_string();
    let bake = folder.path().display().to_string();
    let interior = scene("interior.gltf").display().to_string();
    let words = "--size 320x180 --samples 4 --quiet";
    run_well(
        ["render", &interior, "--bake", &bake, "-o", &again]
            .into_iter()
            .chain(words.split(' ')),
    );
    let (lit, again) = (bytes(&lit), bytes(Path::new(&again)));
    assert_eq!(lit.len(), again.len());
    // Where surfaces end the picture has 16 samples a pixel too, which are exposed before their mean is taken. The GLB
    // holds its page coordinates in f32, and an excluded chair, which fills less than 1 % of the picture, is integrated
    // with other rays.
    let far = lit
        .iter()
        .zip(&again)
        .filter(|(a, b)| a.abs_diff(**b) > 2)
        .count();
    assert!(far * 100 < lit.len(), "{far} of {} bytes differ", lit.len());
    let mean = lit.iter().map(|&v| f64::from(v)).sum::<f64>() / lit.len() as f64;
    assert!(
        (20.0..235.0).contains(&mean),
        "an interior that can be seen: {mean}"
    );
}

/// Writes a closed room with thick walls and a block in it as an OBJ file.
fn thick_room(folder: &Path) -> std::path::PathBuf {
    let mut text = String::new();
    for (number, (half, inward)) in [(1.2, false), (1.0, true), (0.3, false)]
        .into_iter()
        .enumerate()
    {
        text += &format!("o box{number}\n");
        for k in 0..8 {
            let at = [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { half } else { -half });
            text += &format!("v {} {} {}\n", at[0], at[1], at[2]);
        }
        for side in BOX_SIDES {
            let mut corners = side.map(|corner| (8 * number as u32 + corner + 1).to_string());
            if inward {
                corners.reverse();
            }
            text += &format!("f {}\n", corners.join(" "));
        }
    }
    let path = folder.join("thick.obj");
    fs::write(&path, text).expect("a file");
    path
}

#[test]
fn a_picture_that_would_be_black_from_within_is_taken_from_outside() {
    let folder = tempfile::tempdir().expect("a folder");
    let (out, _) = bake(
        &thick_room(folder.path()),
        &["--size", "128", "--rays", "16"],
    );
    let lit = bytes(&out.path().join("thick.lit.png"));
    let bright = lit
        .chunks(3)
        .filter(|pixel| pixel.iter().all(|v| *v > 200))
        .count();
    // A white box before a pale blue sky, of which red is below 200.
    assert!(30 * bright > lit.len() / 3, "{bright} of {}", lit.len() / 3);
    let report = report(out.path());
    let warnings = report["warnings"].as_array().expect("a list");
    let told = warnings.iter().find(|of| of["kind"] == "interior");
    let line = told.map_or("", |of| of["message"].as_str().expect("a text"));
    assert!(line.contains("all is closed"), "{warnings:?}");
}

#[test]
fn an_interior_that_is_lit_in_a_part_is_shown_there_and_not_black() {
    // A dark hall of 10 by 3 by 6, and beside it one without a roof over its middle: all looks inward.
    let quads = [
        [[0, 0, 0], [0, 0, 6], [16, 0, 6], [16, 0, 0]],
        [[0, 0, 0], [0, 3, 0], [0, 3, 6], [0, 0, 6]],
        [[0, 0, 0], [16, 0, 0], [16, 3, 0], [0, 3, 0]],
        [[16, 0, 0], [16, 0, 6], [16, 3, 6], [16, 3, 0]],
        [[0, 0, 6], [0, 3, 6], [16, 3, 6], [16, 0, 6]],
        [[0, 3, 0], [11, 3, 0], [11, 3, 6], [0, 3, 6]],
        [[14, 3, 0], [16, 3, 0], [16, 3, 6], [14, 3, 6]],
        [[10, 0, 0], [10, 0, 6], [10, 3, 6], [10, 3, 0]],
        [[10, 0, 0], [10, 3, 0], [10, 3, 6], [10, 0, 6]],
    ];
    let mut text = String::new();
    for (number, quad) in quads.iter().enumerate() {
        let corners = quad.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
        let [a, b, c, d] = [1, 2, 3, 4].map(|k| 4 * number + k);
        text += &format!("{corners}o wall{number}\nf {a} {b} {c} {d}\n");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("halls.obj");
    fs::write(&path, text).expect("a file");
    let (out, _) = bake(&path, &["--size", "256", "--rays", "16"]);
    let lit = bytes(&out.path().join("halls.lit.png"));
    let shown = |is: fn(&[u8]) -> bool| {
        let pixels = lit.chunks(3).filter(|pixel| is(pixel)).count();
        pixels as f64 / (lit.len() / 3) as f64
    };
    let black = shown(|pixel| pixel.iter().all(|v| *v < 40));
    let sky = shown(|pixel| pixel[2].saturating_sub(pixel[0]) > 20);
    assert!(black < 0.25 && sky < 0.25, "{black} black, {sky} sky");
}

#[test]
fn wires_in_a_duct_make_no_interior_of_a_plane_in_the_light() {
    // A plane of 400 above a duct of 124 that looks inward, and in it a hundred wires of 0.1 each: a quarter of the
    // surface is dark. A wire touches a row of texels.
    let mut text = String::new();
    let mut quad = |name: String, corners: [[f64; 3]; 4]| {
        for [x, y, z] in corners {
            text += &format!("v {x} {y} {z}\n");
        }
        text += &format!("o {name}\nf -4 -3 -2 -1\n");
    };
    let flat = |y: f64, [x, z]: [f64; 2], [right, far]: [f64; 2]| {
        [[x, y, z], [x, y, far], [right, y, far], [right, y, z]]
    };
    quad("plane".into(), flat(0.0, [-10.0; 2], [10.0; 2]));
    for side in BOX_SIDES {
        let corner = |k: u32| {
            let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(f64::from);
            [20.0 * x - 10.0, y - 2.0, 2.0 * z - 1.0]
        };
        let [a, b, c, d] = side.map(corner);
        quad("duct".into(), [d, c, b, a]);
    }
    for k in 0..100 {
        let z = 0.018 * f64::from(k) - 0.9;
        quad(format!("wire{k}"), flat(-1.5, [-9.0, z], [9.0, z + 0.006]));
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wires.obj");
    fs::write(&path, text).expect("a file");
    let (out, _) = bake(&path, &["--size", "128", "--rays", "16"]);
    let baked = report(out.path());
    let warnings = baked["warnings"].as_array().expect("a list");
    let told = warnings.iter().any(|of| of["kind"] == "interior");
    assert!(!told, "{warnings:?}");
}

/// Of 27 cubes side by side two thirds of the faces lie on one another.
#[test]
fn between_cubes_side_by_side_is_no_room() {
    let mut text = String::from("o cubes\n");
    for number in 0..27 {
        let at = [number % 3, number / 3 % 3, number / 9];
        for k in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|axis| at[axis] + (k >> axis & 1));
            text += &format!("v {x} {y} {z}\n");
        }
        for side in BOX_SIDES {
            let [a, b, c, d] = side.map(|corner| 8 * number as u32 + corner + 1);
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cubes.obj");
    fs::write(&path, text).expect("a file");
    let told = |flags: &[&str], kind: &str| {
        let (out, _) = bake(&path, &[&["--size", "128", "--rays", "4"], flags].concat());
        let baked = report(out.path());
        let warnings = baked["warnings"].as_array().expect("a list");
        let found = warnings.iter().find(|of| of["kind"] == kind);
        found.map(|of| of["message"].to_string())
    };
    assert_eq!(told(&[], "interior"), None);
    let line = told(&[], "hidden-faces").expect("a line");
    let share: f64 = line[1..]
        .split(' ')
        .next()
        .map_or(0.0, |share| share.parse().expect("a number"));
    assert!((share - 67.0).abs() < 5.0, "{line}");
    let around = "--seen-from=-9,9,-9;9,-9,9;-9,-9,-9;9,9,9;-9,9,9;9,-9,-9";
    assert_eq!(told(&[around], "hidden-faces"), None);
}

#[test]
fn a_report_is_one_file_that_a_rebake_takes_along() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out dir").display().to_string();
    let wall = scene("wall_long.obj").display().to_string();
    let words = ["bake", &wall, "-o", &out, "--size", "32", "--rays", "1"];
    let said = run_well(words.into_iter().chain(["--report"]));
    let html = Path::new(&out).join("report.html");
    assert!(
        said.trim_end()
            .ends_with(&format!("look at {}", html.display())),
        "{said}"
    );
    let first = fs::read_to_string(&html).expect("the report");
    let size: u64 = ["wall_long.0.exr", "wall_long.glb"]
        .map(|name| fs::metadata(Path::new(&out).join(name)).expect(name).len())
        .iter()
        .sum();
    assert!(
        (first.len() as u64) < size + (1 << 20),
        "{} over {size}",
        first.len()
    );
    // Without --report the file is an earlier bake's and goes; `view` makes it and lists it, so it goes again.
    run_well(words.into_iter().chain(["--quiet"]));
    assert!(!html.exists());
    assert_eq!(
        run_well(["view", &out, "--no-open"]).trim_end(),
        html.display().to_string()
    );
    assert!(
        report(Path::new(&out))["files"]
            .to_string()
            .contains("report.html")
    );
    let once = fs::read(&html).expect("the report");
    run_well(["view", &out, "--no-open", "-q"]);
    let again = fs::read(&html).expect("the report");
    assert!(once == again, "the same bytes again");
    run_well(words.into_iter().chain(["--quiet"]));
    assert!(!html.exists() && !files(Path::new(&out)).contains(&"report.html".into()));
    let none = folder.path().display().to_string();
    let output = run(["view", &none]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(
        errors.contains("bake.json") && errors.lines().count() == 1,
        "{errors}"
    );
}

/// What a browser finds in the report of a bake; `None` with a printed line where a tool is absent.
fn in_browser(folder: &Path) -> Option<Value> {
    let page = folder.join("report.html");
    let found = node("view-report.mjs", &[page.as_os_str()]);
    found.map_err(|reason| say(&reason)).ok()
}

#[test]
fn a_browser_sees_through_the_holes_of_a_cut_out_and_plots_a_benchmark() {
    let options = ["--size", "64", "--rays", "4"];
    let (folder, _) = bake(&scene("masked_card.gltf"), &options);
    fs::create_dir(folder.path().join("bench")).expect("a folder");
    let rows = "technique,effort,repeat,rmse,estimated_rmse,cpu_seconds,wall_seconds,rays,texels\n\
                \"a, <b>\",rays 4,0,0.1,0.1,0.5,0.3,4,1\n\"a, <b>\",rays 16,0,0.05,0.05,2,1,16,1\n";
    fs::write(folder.path().join("bench/bench.csv"), rows).expect("written");
    let place = folder.path().display().to_string();
    run_well(["view", &place, "--no-open", "-q"]);
    let Some(found) = in_browser(folder.path()) else {
        return;
    };
    let plotted = found["benchmark"].as_str().expect("a text");
    assert!(plotted.contains("a, <b>: 0.05 after 2 s"), "{plotted}");
    // The card at height 1 keeps the cells of its 8 x 8 board whose numbers have an even sum; the floor is seen through
    // the others.
    let (mut kept, mut through) = (0, 0);
    for pick in found["grid"].as_array().expect("picks") {
        let [x, y, z] = [0, 1, 2].map(|k| pick["point"][k].as_f64().unwrap_or(f64::NAN));
        if y > 0.5 {
            let cells = [x, z].map(|at| (at + 2.0) / 0.5);
            let edge = cells.iter().any(|cell| (cell - cell.round()).abs() < 0.02);
            let even = cells.map(|cell| cell.floor() as i64).iter().sum::<i64>() % 2 == 0;
            assert!(edge || even, "a hole was hit: {pick}");
            kept += 1;
        } else if y > -0.5 {
            through += 1;
        }
    }
    assert!(
        kept >= 5 && through >= 5,
        "{kept} on the card, {through} through it: {found}"
    );
}

#[test]
fn a_browser_shows_the_report_and_picks_the_texel_that_is_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a b%.obj");
    let text = fs::read_to_string(scene("courtyard.obj")).expect("the courtyard");
    let text = text.replacen("\no ", "\no </script><img_src=x_onerror=alert(1)>", 1);
    fs::write(&file, text.replace("mtllib", "#")).expect("written");
    let (folder, page) = bake(
        &file,
        &[
            "--size", "128", "--rays", "4", "--report", "--layers", "position",
        ],
    );
    let Some(found) = in_browser(folder.path()) else {
        return;
    };
    assert_eq!(found["benchmark"], "", "no benchmark stands beside it");
    assert!(found["colors"].as_u64() > Some(100), "a picture: {found}");
    assert_eq!(found["same"], true, "the first view comes back");
    assert!(
        found["turned"].as_f64() > Some(0.1),
        "keys and pointer turn it"
    );
    for (view, colors) in found["views"].as_object().expect("views") {
        // `rays` is the same everywhere, a flat colour.
        assert!(colors.as_u64() > Some(1), "{view}: {colors}");
    }
    let picks = found["picks"].as_array().expect("picks");
    let densities = &report(folder.path())["layout"]["texels_per_unit"];
    let texel_edge = 1.0 / densities["min"].as_f64().expect("a density");
    let mut good = 0;
    for pick in picks.iter().filter(|pick| pick["page"] == 0) {
        let at = |key: &str, k: usize| pick[key][k].as_f64().expect(key);
        let texel = at("texel", 1) as usize * page.size + at("texel", 0) as usize;
        assert!(page.plane("coverage")[texel] > 0.0, "{pick}");
        let value = pick["values"]["diffuse"][0].as_f64().expect("a value");
        let stored = f64::from(page.plane("diffuse")[texel]);
        assert!(
            (value - stored).abs() <= stored / 1024.0,
            "{value} for {stored}"
        );
        let position = ["position.X", "position.Y", "position.Z"]
            .map(|name| f64::from(page.plane(name)[texel]));
        let apart = (0..3)
            .map(|k| (position[k] - at("point", k)).powi(2))
            .sum::<f64>()
            .sqrt();
        assert!(
            apart < 1.5 * texel_edge,
            "{pick}: the texel lies at {position:?}"
        );
        good += 1;
    }
    assert!(good >= 3, "{picks:?}");
    assert!(page_path(folder.path(), &file, 0).exists());
}

#[test]
fn a_browser_shows_probes_as_balls_in_the_light_that_engines_look_up() {
    let courtyard = scene("courtyard.obj");
    let (folder, _) = bake(&courtyard, &["--size=64", "--rays=4"]);
    let [file, place] = [&courtyard, folder.path()].map(|path| path.display().to_string());
    let flags = "--grid=3x2x3 --within=-6,0.2,-6:6,4,6 --rays=64 --tried=0 -q";
    run_well(
        ["probes", &file, "-o", &place]
            .into_iter()
            .chain(flags.split(' ')),
    );
    run_well(["view", &place, "--no-open", "-q"]);
    let Some(found) = in_browser(folder.path()) else {
        return;
    };
    let balls = &found["balls"];
    assert!(balls["shown"].as_u64() > Some(50), "the probes: {balls}");
    assert!(balls["moved"].as_u64() > Some(50), "the other: {balls}");
    assert_eq!(found["same"], true, "switched off and on again");
    let text = fs::read_to_string(folder.path().join("courtyard.probes.json"));
    let report: Value = serde_json::from_str(&text.expect("probes")).expect("JSON");
    // The mean of E / pi over all normals is the first coefficient over 2 sqrt(pi).
    let mean = |probe: usize| {
        let first = &report["probes"][probe]["sh"][0][1];
        first.as_f64().expect("a number") / (4.0 * std::f64::consts::PI).sqrt()
    };
    let wanted = [mean(0), mean(1 + 3 * 2), 0.5 * (mean(0) + mean(1))];
    for (k, wanted) in wanted.into_iter().enumerate() {
        let light = balls["light"][k][1].as_f64().expect("a number");
        assert!(
            wanted > 0.0 && (light - wanted).abs() < 1e-4 * wanted,
            "{k}: {light} {wanted}"
        );
    }
    // To the right and up on the screen, as far from the eye's plane as before.
    assert_ne!(balls["at"], balls["dragged"]);
    let [before, after] = ["at", "dragged"].map(|name| balls[name][1].as_f64().expect("y"));
    assert!(after > before, "{balls}");
}

#[test]
fn a_browser_turns_the_highlight_as_render_integrates_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shiny.obj");
    let material = "newmtl shiny\nKd 0.3 0.2 0.1\nKs 0.6 0.6 0.6\nNs 12\n";
    let body = "o floor\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nf 1 2 3 4\n\
                o wall\nv -2 0 -2\nv 2 0 -2\nv 2 1.5 -2\nv -2 1.5 -2\nf 5 6 7 8\n";
    fs::write(folder.path().join("shiny.mtl"), material).expect("written");
    fs::write(&path, format!("mtllib shiny.mtl\nusemtl shiny\n{body}")).expect("written");
    let layers = "--layers=any-view.8,normal,exponent,reflectance";
    let (out, _) = bake(&path, &["--size=64", "--rays=256", layers, "--report"]);
    let [width, height] = [96usize; 2];
    let eyes = [[3.0, 2.0, 4.0], [-4.0, 1.0, 3.0], [0.5, 5.0, 3.0]];
    let views = eyes.map(|eye: [f64; 3]| {
        let picture = out.path().join("view.exr");
        let eye_flag = format!("--eye={},{},{}", eye[0], eye[1], eye[2]);
        let size = format!("--size={width}x{height}");
        run_well([
            "render",
            path.to_str().expect("UTF-8"),
            "-o",
            picture.to_str().expect("UTF-8"),
            "--model=phong",
            &eye_flag,
            "--look=0,0,0",
            "--fov-deg=40",
            &size,
            "--samples=1",
            "--rays=64",
            "--background=0,0,77",
            "--quiet",
        ]);
        let picture = crate::support::Page::read(&picture);
        let [r, g, b] = ["R", "G", "B"].map(|c| picture.plane(c));
        let byte = |v: f32| match v.clamp(0.0, 1.0) {
            v if v <= 0.003_130_8 => 255.0 * 12.92 * v,
            v => 255.0 * (1.055 * v.powf(1.0 / 2.4) - 0.055),
        };
        let bytes: Vec<Value> = (0..width * height)
            .flat_map(|i| {
                let empty = b[i] == 77.0;
                [r[i], g[i], b[i]].map(|v| if empty { Value::Null } else { byte(v).into() })
            })
            .collect();
        serde_json::json!({ "eye": eye, "look": [0, 0, 0], "fov": 40, "bytes": bytes })
    });
    let list = out.path().join("views.json");
    fs::write(&list, Value::from(views.to_vec()).to_string()).expect("written");
    let page = out.path().join("report.html");
    let size = [width, height].map(|edge| edge.to_string());
    let args = [
        page.as_os_str(),
        size[0].as_ref(),
        size[1].as_ref(),
        list.as_os_str(),
    ];
    let found = match node("view-live.mjs", &args) {
        Ok(found) => found,
        Err(reason) => return say(&reason),
    };
    assert_eq!(found["complaints"], serde_json::json!([]));
    let views = found["views"]
        .as_array()
        .unwrap_or_else(|| panic!("no live view: {found}"));
    for view in views {
        assert!(view["pixels"].as_u64() > Some(500), "{found}");
        // The numbers are not denoised: 256 rays leave some 2 of 255. What is left on the mean is the order's, 0.01 at
        // exponent 12.
        assert!(view["mean"].as_f64() <= Some(4.0), "{found}");
        let bias = view["bias"].as_f64().expect("a number");
        assert!(bias.abs() <= 0.75, "{found}");
    }
}
