//! Denoising from outside: what is done by default, and what each word of `--denoise` means.

use crate::support::{Page, ambake, backends, bake, page_path, report, run, run_well, scene};

/// Bakes without a word about denoising.
fn by_default(name: &str, arguments: &[&str]) -> (tempfile::TempDir, Page) {
    let (folder, path) = (tempfile::tempdir().expect("a folder"), scene(name));
    let out = folder.path().display().to_string();
    let path_text = path.display().to_string();
    run_well([&["bake", &path_text, "-o", &out, "--quiet"][..], arguments].concat());
    let page = Page::read(&page_path(folder.path(), &path, 0));
    (folder, page)
}

#[test]
fn bakes_are_denoised_unless_a_single_ray_leaves_nothing_to_compare() {
    let few = ["--size", "48", "--rays", "8", "--only", "diffuse,error"];
    let (folder, default) = by_default("trench.obj", &few);
    let (_folder, asked) = bake(
        &scene("trench.obj"),
        &[&few[..], &["--denoise", "regression"]].concat(),
    );
    let (_folder, plain) = bake(&scene("trench.obj"), &few);
    assert_eq!(report(folder.path())["options"]["denoise"], "regression");
    assert_eq!(default.plane("diffuse"), asked.plane("diffuse"));
    assert_ne!(default.plane("diffuse"), plain.plane("diffuse"));
    let (folder, _) = by_default("plane.obj", &["--size", "16", "--rays", "1"]);
    assert_eq!(report(folder.path())["options"]["denoise"], "off");
}

#[test]
fn no_rim_of_grain_stays_along_buried_texels() {
    let few = [
        "--size",
        "512",
        "--rays",
        "16",
        "--only",
        "diffuse,validity",
    ];
    let (_folder, plain) = bake(&scene("interior.gltf"), &few);
    let (_folder, smooth) = by_default("interior.gltf", &few);
    // How far texels of which nothing is seen stand from the mean of the neighbours that carry them.
    let rough = |page: &Page| {
        let [values, valid, covered] = ["diffuse", "validity", "coverage"].map(|l| page.plane(l));
        let size = page.size;
        let (mut squares, mut count) = (0.0, 0.0);
        for i in size..size * (size - 1) {
            let beside = [i - size, i - 1, i + 1, i + size];
            let seen: Vec<_> = beside.into_iter().filter(|&j| valid[j] > 0.99).collect();
            if covered[i] > 0.0 && valid[i] == 0.0 && !seen.is_empty() {
                let mean = seen.iter().map(|&j| values[j]).sum::<f32>() / seen.len() as f32;
                squares += f64::from(values[i] - mean).powi(2);
                count += 1.0;
            }
        }
        assert!(count > 50.0, "{count} buried texels");
        (squares / count).sqrt()
    };
    let (plain, smooth) = (rough(&plain), rough(&smooth));
    assert!(smooth < 0.7 * plain, "{smooth} of {plain}");
}

#[test]
fn a_missing_library_is_one_line_that_says_how_to_get_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let output = ambake()
        .args([
            "bake".as_ref(),
            scene("plane.obj").as_os_str(),
            "-o".as_ref(),
        ])
        .args([out.as_os_str(), "--denoise".as_ref(), "oidn".as_ref()])
        .env("OIDN_DIR", folder.path())
        .output()
        .expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert_eq!(errors.trim().lines().count(), 1, "{errors}");
    assert!(
        errors.contains("pyoidn") && errors.contains("OIDN_DIR"),
        "{errors}"
    );
    assert!(!out.join("bake.json").exists());
}

#[test]
fn most_rays_beside_a_fixed_number_are_refused() {
    let path = scene("plane.obj").display().to_string();
    let output = run(["plan", &path, "--rays", "16", "--max-rays", "64"]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("--max-rays"), "{errors}");
}

#[test]
fn a_target_is_met_by_what_is_denoised_and_takes_fewer_rays_for_it() {
    let few = ["--size", "128", "--only", "diffuse,error,rays"];
    let asked = ["--target-error", "0.006", "--seams", "off"];
    let arguments = [&few[..], &asked].concat();
    let (_folder, smooth) = by_default("resting_sphere.obj", &arguments);
    let (_folder, plain) = bake(&scene("resting_sphere.obj"), &arguments);
    let more = ["--rays", "4096", "--seed", "3", "--seams", "off"];
    let (_folder, exact) = bake(&scene("resting_sphere.obj"), &[&few[..], &more].concat());
    let cast: Vec<usize> = (0..128 * 128)
        .filter(|&i| exact.plane("rays")[i] > 0.0)
        .collect();
    let mean = |page: &Page, of: &dyn Fn(&Page, usize) -> f64| {
        cast.iter().map(|&i| of(page, i)).sum::<f64>() / cast.len() as f64
    };
    let rays = |page: &Page, i: usize| f64::from(page.plane("rays")[i]);
    let [all, fewer] = [&plain, &smooth].map(|page| mean(page, &rays));
    assert!(fewer < 0.5 * all, "{fewer} rays a texel of {all}");
    let square = |page: &Page, i: usize| {
        let [own, exact] = [page, &exact].map(|page| f64::from(page.plane("diffuse")[i]));
        (own - exact).powi(2)
    };
    let stated = |page: &Page, i: usize| f64::from(page.plane("error")[i]).powi(2);
    // With some twenty rays a texel what is stated of one bake is off: four together tell.
    let others = ["1", "2", "3"].map(|seed| {
        let words = [&arguments[..], &["--seed", seed]].concat();
        by_default("resting_sphere.obj", &words).1
    });
    let sum = |of: &dyn Fn(&Page, usize) -> f64| -> f64 {
        let all = others.iter().chain([&smooth]);
        all.map(|page| mean(page, of)).sum()
    };
    let ratio = (sum(&square) / sum(&stated)).sqrt();
    assert!((0.8..1.2).contains(&ratio), "true over stated {ratio}");
    let [of_smooth, of_plain] = [&smooth, &plain].map(|page| mean(page, &stated).sqrt());
    assert!((0.003..=0.0063).contains(&of_smooth), "{of_smooth} stated");
    assert!((0.003..=0.0063).contains(&of_plain), "{of_plain} stated");
}

#[test]
fn the_error_that_a_report_states_is_that_of_the_texels_that_are_seen() {
    let few = "--size 128 --rays 16 --seams off --only diffuse,error,validity";
    let words: Vec<&str> = few.split(' ').collect();
    let (folder, page) = by_default("vehicles.gltf", &words);
    let [error, valid, covered] = ["error", "validity", "coverage"].map(|l| page.plane(l));
    let texels = (0..covered.len()).filter(|&i| covered[i] > 0.0);
    let (seen, buried): (Vec<usize>, Vec<usize>) = texels.partition(|&i| valid[i] > 0.0);
    assert!(buried.len() > 100, "{} buried texels", buried.len());
    let errors = || seen.iter().map(|&i| f64::from(error[i]));
    let of = &report(folder.path())["pages"][0];
    let close = |name: &str, exact: f64| {
        let stated = of[name].as_f64().expect("a number");
        assert!(
            (stated / exact - 1.0).abs() < 1e-6,
            "{name}: {stated}, not {exact}"
        );
    };
    close("mean_error", errors().sum::<f64>() / seen.len() as f64);
    close(
        "rmse",
        (errors().map(|e| e * e).sum::<f64>() / seen.len() as f64).sqrt(),
    );
    close("max_error", errors().fold(0.0, f64::max));
}

#[test]
fn what_a_box_a_millimetre_above_the_floor_seals_is_its_area_in_each_texel() {
    const SIZE: usize = 64;
    // Sides of the box in texels of the floor, one unit each; some lie on the borders of tiles.
    let cases = [[[8.3, 20.7], [10.1, 16.0]], [[15.9, 33.25], [31.5, 48.6]]];
    for [x, z] in cases {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("hovering.obj");
        let mut text = String::from("o floor\n");
        for [u, v] in [[0, 0], [0, SIZE], [SIZE, SIZE], [SIZE, 0]] {
            let [s, t] = [u, v].map(|at| at as f64 / (2 * SIZE) as f64);
            text += &format!("v {u} 0 {v}\nvt {s} {}\n", 1.0 - t);
        }
        text += "f 1/1 2/2 3/3 4/4\no box\n";
        for y in [0.01, 3.0] {
            for [x, z] in [[x[0], z[0]], [x[0], z[1]], [x[1], z[1]], [x[1], z[0]]] {
                text += &format!("v {x} {y} {z}\n");
            }
        }
        let faces = [
            [8, 7, 6, 5],
            [9, 10, 11, 12],
            [5, 6, 10, 9],
            [6, 7, 11, 10],
            [7, 8, 12, 11],
            [8, 5, 9, 12],
        ];
        for (number, face) in faces.iter().enumerate() {
            let left = 0.02 + 0.15 * number as f64;
            for (u, v) in [(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)] {
                text += &format!("vt {} {}\n", left + u, 0.2 + v);
            }
            let corner = |k: usize| format!(" {}/{}", face[k], 5 + 4 * number + k);
            text += &format!("f{}\n", (0..4).map(corner).collect::<String>());
        }
        std::fs::write(&path, text).expect("a file");
        for backend in backends() {
            let size = (2 * SIZE).to_string();
            let flags = [
                "--size",
                &size,
                "--rays",
                "256",
                "--layers",
                "sealed,diffuse",
                "--uv",
                "keep",
                "--backend",
                backend,
            ];
            let (_folder, page) = bake(&path, &flags);
            let overlap = |[low, high]: [f64; 2], at: usize| {
                (high.min(at as f64 + 1.0) - low.max(at as f64)).clamp(0.0, 1.0)
            };
            for (i, &sealed) in page.plane("sealed").iter().enumerate() {
                let [u, v] = [i % (2 * SIZE), i / (2 * SIZE)];
                if u >= SIZE || v >= SIZE {
                    continue;
                }
                let exact = overlap(x, u) * overlap(z, v);
                let off = (f64::from(sealed) - exact).abs();
                // Eight places along an edge of the texel.
                assert!(off < 0.135, "{backend} {u} {v}: {sealed} of {exact}");
            }
        }
    }
}

#[test]
fn what_texels_move_by_at_seams_is_in_their_stated_errors() {
    let few = "--size 256 --buried keep --only diffuse,error,validity";
    let words = |more: &'static str| few.split(' ').chain(more.split(' ')).collect::<Vec<_>>();
    let (folder, page) = by_default("interior.gltf", &words("--rays 64"));
    let (_folder, exact) = bake(
        &scene("interior.gltf"),
        &words("--rays 4096 --seed 5 --seams off"),
    );
    let [values, error, covered] = ["diffuse", "error", "coverage"].map(|l| page.plane(l));
    let texels: Vec<usize> = (0..covered.len()).filter(|&i| covered[i] > 0.0).collect();
    let rms = |of: &dyn Fn(usize) -> f32| {
        let squares = texels.iter().map(|&i| f64::from(of(i)).powi(2));
        (squares.sum::<f64>() / texels.len() as f64).sqrt()
    };
    let stated = rms(&|i| error[i]);
    let report = report(folder.path());
    let number = |of: &serde_json::Value, name: &str| of[name].as_f64().expect("a number");
    let moved = number(&report["seams"], "rms_moved");
    let before = number(&report["pages"][0], "rmse_rays");
    let all = number(&report["pages"][0], "rmse");
    assert!((all / stated - 1.0).abs() < 1e-6, "{all} of {stated}");
    assert!(
        (stated / before.hypot(moved) - 1.0).abs() < 1e-4,
        "{stated} of {before} and {moved}"
    );
    // Far more than the rays leave.
    assert!(moved > 0.5 * before, "{moved} of {before}");
    let truth = rms(&|i| values[i] - exact.plane("diffuse")[i]);
    assert!(
        (0.85..1.15).contains(&(truth / stated)),
        "{truth} of {stated}"
    );
}
