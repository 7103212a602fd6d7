//! Frames shaded from reflection maps, by the built program.

use crate::support::{files, load_image, run, run_well, save_image, scene};
use std::fs;
use std::path::Path;

/// A map of one colour, or of what a function gives for each texel.
fn write_map(path: &Path, width: usize, of: impl Fn(usize) -> [f32; 3]) {
    let image = environment::Image {
        width,
        height: width / 2,
        pixels: (0..width * width / 2).map(of).collect(),
    };
    save_image(path, &image);
}

/// D and S of a map by the program, as the value of `--maps`.
fn reflect(folder: &Path, map: &Path, more: &[&str]) -> String {
    let at = |name: &str| folder.join(name).display().to_string();
    let (input, d, s) = (map.display().to_string(), at("D.exr"), at("S.exr"));
    run_well([&["map", "diffuse", &input, "-o", &d, "--quiet"], more].concat());
    let specular = ["map", "specular", &input, "-o", &s, "--exponent", "20"];
    run_well([&specular[..], &["--size", "64x32", "--quiet"], more].concat());
    format!("{d},{s}")
}

/// A picture of the globe, 40 pixels wide and high.
fn globe(path: &Path, more: &[&str]) -> Vec<[f32; 3]> {
    let (scene, path) = (
        scene("ball.obj").display().to_string(),
        path.display().to_string(),
    );
    let common = "--size 40x40 --eye 0,0,4 --look 0,0,0 --samples 2 --quiet";
    let arguments: Vec<&str> = ["render", &scene, "-o", &path]
        .into_iter()
        .chain(common.split(' '))
        .chain(more.iter().copied())
        .collect();
    run_well(arguments);
    match fs::metadata(&path) {
        Ok(_) => load_image(&path).pixels,
        Err(_) => Vec::new(),
    }
}

#[test]
fn a_uniform_environment_makes_an_even_globe_in_both_normalisations() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    write_map(&at("I.exr"), 64, |_| [1.0; 3]);
    for (normalise, exact) in [("radiance", 0.5 + 0.25), ("seed", 0.5 / 4.0 + 0.25 / 42.0)] {
        let maps = reflect(folder.path(), &at("I.exr"), &["--normalise", normalise]);
        let colors = ["--albedo", "0.5,0.5,0.5", "--specular", "0.25,0.25,0.25"];
        for lookup in ["nearest", "bilinear", "recursive", "quad", "summed"] {
            let more = [&["--maps", &maps, "--lookup", lookup][..], &colors].concat();
            let pixels = globe(&at("x.exr"), &more);
            let middle = pixels[20 * 40 + 20];
            assert!(
                (middle[1] - exact as f32).abs() < 1e-6,
                "{lookup}: {middle:?}"
            );
            assert_eq!(pixels[0], [0.0; 3], "black behind without an environment");
        }
    }
}

#[test]
fn a_sequence_has_numbered_frames_that_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    write_map(&at("I.exr"), 64, |k| {
        [(k % 64) as f32 / 32.0, (k / 64) as f32 / 32.0, 0.5]
    });
    let maps = reflect(folder.path(), &at("I.exr"), &[]);
    let environment = at("I.exr").display().to_string();
    let common = [
        "--maps",
        &maps,
        "--environment",
        &environment,
        "--specular",
        "1,1,1",
    ];
    let frames = ["--frames", "3", "--turn-deg", "5", "--lookup", "summed"];
    for threads in ["1", "2"] {
        let more = [&common[..], &frames, &["--threads", threads]].concat();
        globe(&at(&format!("t{threads}.exr")), &more);
    }
    let bytes = |name: String| fs::read(at(&name)).expect("a frame");
    for frame in 0..3 {
        assert!(bytes(format!("t1.000{frame}.exr")) == bytes(format!("t2.000{frame}.exr")));
    }
    // Keys of a path are met, and a path from the fixed eye gives the fixed picture.
    fs::write(at("path.csv"), "# eye, look\n0,0,4, 0,0,0\n4,0,0, 0,0,0\n").expect("a file");
    let path = at("path.csv").display().to_string();
    let scene = scene("ball.obj").display().to_string();
    let moving = at("p.exr").display().to_string();
    let size = ["--size", "40x40", "--samples", "2", "--quiet"];
    run_well(
        [
            &["render", &scene, "-o", &moving, "--path", &path][..],
            &common,
            &size,
        ]
        .concat(),
    );
    let still = globe(&at("still.exr"), &common);
    let first = load_image(at("p.0000.exr")).pixels;
    assert_eq!(first, still);
    assert!(at("p.0001.exr").exists() && !at("p.0002.exr").exists());
}

#[test]
fn every_surface_type_has_its_value_under_a_uniform_environment() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    write_map(&at("I.exr"), 64, |_| [2.0; 3]);
    let maps = reflect(folder.path(), &at("I.exr"), &[]);
    let environment = at("I.exr").display().to_string();
    let lit = ["--environment", &environment];
    let colors = ["--albedo", "0.5,0.5,0.5", "--specular", "0.25,0.25,0.25"];
    let tables = ["--maps", maps.as_str()];
    for (name, maps, exact) in [
        ("phong", &tables[..], 1.5),
        ("retro", &tables, 1.5),
        ("varnish", &tables, 2.5),
        ("mirror", &[], 0.5),
        ("refraction", &[], 0.5),
        ("luminous", &[], 1.0),
    ] {
        let more = [&["--shader", name], &lit[..], &colors, maps].concat();
        let pixels = globe(&at("x.exr"), &more);
        let middle = pixels[20 * 40 + 20][0];
        assert!((middle - exact as f32).abs() < 2e-6, "{name}: {middle}");
        assert_eq!(pixels[0], [2.0; 3], "{name}: the environment is behind");
    }
    // Half at normal view by a table of weights.
    fs::write(at("w.txt"), "0 1\n1 0.5 # at normal view\n").expect("a file");
    let weight = at("w.txt").display().to_string();
    let more = [
        &["--shader", "mirror", "--specular-weight", &weight],
        &lit[..],
        &colors,
    ]
    .concat();
    let middle = globe(&at("x.exr"), &more)[20 * 40 + 20][0];
    assert!((middle - 0.25).abs() < 1e-3, "{middle}");
}

#[test]
fn objects_have_shaders_of_their_own_and_traced_mirrors_show_what_stands_before_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let text = |name: &str| at(name).display().to_string();
    write_map(&at("I.exr"), 64, |_| [1.0; 3]);
    // A floor, a wall at its far end, and a ceiling that nobody names.
    let scene = "o floor\nv -4 0 -4\nv 4 0 -4\nv 4 0 4\nv -4 0 4\nf 4 3 2 1\n\
                 o wall.far\nv -4 0 -4\nv 4 0 -4\nv 4 2 -4\nv -4 2 -4\nf 5 6 7 8\n";
    fs::write(at("room.obj"), scene).expect("a file");
    let (room, environment, out) = (text("room.obj"), text("I.exr"), text("x.exr"));
    let render = |more: &[&str]| {
        let fixed = "--size 9x40 --eye 0,3,6 --look 0,0,-1 --samples 1 --albedo 0.25,0.25,0.25 \
            --specular 0.75,0.75,0.75";
        let all = [
            "render",
            &room,
            "-o",
            &out,
            "--environment",
            &environment,
            "--quiet",
        ];
        run([&all[..], &fixed.split(' ').collect::<Vec<_>>(), more].concat())
    };
    let column = |more: &[&str]| {
        let output = render(more);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{more:?}: {errors}");
        let image = load_image(at("x.exr"));
        (0..40).map(|y| image.at(4, y)[0]).collect::<Vec<f32>>()
    };
    let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
    let lit = ["--shader", "traced", "--shader-of", "wall*=luminous"];
    let traced = column(&lit);
    let mirror = column(&[&lit[..], &["--shader-of", "floor=mirror"]].concat());
    let (mut walls, mut seen, mut sky) = (0, 0, 0);
    for (y, (traced, mirror)) in traced.into_iter().zip(mirror).enumerate() {
        match mirror {
            m if near(m, 1.0) => assert!(near(traced, 1.0), "{y}: behind"),
            m if near(m, 0.25) => {
                walls += 1;
                assert!(near(traced, 0.25), "{y}: the wall");
            }
            m => {
                assert!(near(m, 0.75), "{y}: {m}");
                // The wall in the floor, or the sky.
                assert!(
                    near(traced, 0.75 * 0.25) || near(traced, 0.75),
                    "{y}: {traced}"
                );
                seen += usize::from(near(traced, 0.75 * 0.25));
                sky += usize::from(near(traced, 0.75));
            }
        }
    }
    assert!(walls > 3 && seen > 3 && sky > 3, "{walls} {seen} {sky}");
    for (more, status, word) in [
        (
            ["--shader", "traced", "--shader-of", "door=mirror"],
            1,
            "door",
        ),
        (
            ["--shader", "traced", "--shader-of", "wall*=phong"],
            1,
            "--maps",
        ),
        (
            ["--shader", "traced", "--shader-of", "wall*=glass"],
            2,
            "varnish",
        ),
        (
            ["--shader", "traced", "--shader-of", "mirror"],
            2,
            "NAME=TYPE",
        ),
    ] {
        let output = render(&more);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{more:?}: {errors}");
        assert!(errors.contains(word), "{more:?}: {errors}");
    }
}

#[test]
fn the_figure_of_six_materials_has_their_values_under_a_uniform_environment() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    write_map(&folder.path().join("I.exr"), 64, |_| [1.0; 3]);
    let ball = scene("ball.obj").display().to_string();
    let view = "--figure balls --size 60x40 --eye 0,0,4 --look 0,0,0 --samples 1";
    let (environment, figure) = (at("I.exr"), at("figure"));
    let mut arguments = vec![
        "render",
        &ball,
        "--environment",
        &environment,
        "-o",
        &figure,
    ];
    arguments.extend(view.split(' '));
    run_well(arguments);
    assert_eq!(files(Path::new(&figure)), ["balls.exr", "balls.png"]);
    let sheet = load_image(Path::new(&figure).join("balls.exr"));
    let middle = |k: usize| sheet.at(20 * (k % 3) + 10, 20 * (k / 3) + 10);
    // Mirror, glossy, diffuse of 1/2, varnished (red), retro-reflective of 1/2, refracting.
    for (k, exact) in [1.0f32, 1.0, 0.5, 1.0, 0.5, 1.0].into_iter().enumerate() {
        assert!((middle(k)[0] - exact).abs() < 1e-6, "{k}: {:?}", middle(k));
    }
}

#[test]
fn a_measured_surface_shows_its_reflectance_by_incidence_colour_and_exponent() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    write_map(&folder.path().join("I.exr"), 64, |_| [1.0, 1.0, 2.0]);
    let d = path("D.exr");
    run_well(["map", "diffuse", &path("I.exr"), "-o", &d, "--quiet"]);
    // A lobe from v down to 0 behind, linear in the cosine, reflects 2 pi v; twice as much at 60 degrees.
    for (exponent, v) in [("4", 0.02), ("16", 0.05)] {
        let table = format!(
            "incidence degrees red green blue\n\
             0 0 {v} {w} 0\n0 180 0 0 0\n60 0 {w} {w} {v}\n60 180 0 0 0\n",
            w = 2.0 * v
        );
        fs::write(path("table.txt"), table).expect("a file");
        let (s, table) = (path(&format!("S_{exponent}.exr")), path("table.txt"));
        let words = ["map", "specular", &path("I.exr"), "-o", &s, "--quiet"];
        let kernel = [
            "--kernel",
            "reflectance",
            "--table",
            &table,
            "--size",
            "64x32",
        ];
        run_well([&words[..], &kernel].concat());
    }
    let square = "mtllib m.mtl\nusemtl m\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n";
    fs::write(path("square.obj"), square).expect("a file");
    let material = "newmtl m\nKd 0 0 0\nKs 0.5 0.5 0.5\nNs 8\n";
    fs::write(path("m.mtl"), material).expect("a file");
    let maps = format!("{d},{}", path("S.exr"));
    let share = (9f64.ln() - 5f64.ln()) / (17f64.ln() - 5f64.ln());
    let v = 0.5 * std::f64::consts::TAU * (0.02 + share * 0.03);
    for (angle, exact) in [
        (0.0f64, [v, 2.0 * v, 0.0]),
        (60.0, [2.0 * v, 2.0 * v, 2.0 * v]),
        // Half-way in the cosine, and beyond the last incidence.
        (0.75f64.acos().to_degrees(), [1.5 * v, 2.0 * v, v]),
        (80.0, [2.0 * v, 2.0 * v, 2.0 * v]),
    ] {
        let (sin, cos) = angle.to_radians().sin_cos();
        let (eye, out) = (format!("{},0,{}", 4.0 * sin, 4.0 * cos), path("x.exr"));
        let scene = path("square.obj");
        let words = ["render", &scene, "-o", &out, "--maps", &maps, "--quiet"];
        let tables = ["--exponents", "4,16", "--incidences", "0,60"];
        let view = [
            "--eye",
            &eye,
            "--look",
            "0,0,0",
            "--size",
            "3x3",
            "--samples",
            "1",
        ];
        run_well([&words[..], &tables, &view].concat());
        let middle = load_image(&out).pixels[4];
        for c in 0..3 {
            let found = f64::from(middle[c]);
            assert!(
                (found - exact[c]).abs() < 2e-6,
                "{angle} {c}: {found} {exact:?}"
            );
        }
    }
}

#[test]
fn a_wrong_request_is_one_line_and_leaves_no_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let input = folder.path().join("in");
    fs::create_dir(&input).expect("a folder");
    let given = |name: &str| input.join(name).display().to_string();
    write_map(&input.join("I.exr"), 64, |_| [1.0; 3]);
    let maps = reflect(&input, &input.join("I.exr"), &[]);
    let seed = given("seed.exr");
    run_well([
        "map",
        "specular",
        &given("I.exr"),
        "-o",
        &seed,
        "--exponent",
        "5",
        "--normalise",
        "seed",
        "--quiet",
    ]);
    let cross = given("cross.exr");
    run_well([
        "map",
        "convert",
        &given("I.exr"),
        "-o",
        &cross,
        "--to",
        "cross",
        "--quiet",
    ]);
    // A file that was cut short.
    let whole = fs::read(given("I.exr")).expect("a map");
    fs::write(given("cut.exr"), &whole[..whole.len() / 2]).expect("a file");
    fs::write(given("path.csv"), "0,0,4,0,0,0\n1,2,3\n").expect("a file");
    fs::write(given("empty.csv"), "# nothing\n").expect("a file");
    fs::write(given("same.csv"), "1,1,1,1,1,1\n").expect("a file");
    fs::write(given("w.txt"), "0.5 1\n0.25 1\n").expect("a file");
    let (d, _) = maps.split_once(',').expect("two maps");
    let [mixed, crossed, cut] = [&seed, &cross, &given("cut.exr")].map(|s| format!("{d},{s}"));
    let with = |more: &[&str]| {
        [&["--maps", &maps], more]
            .concat()
            .iter()
            .map(|w| w.to_string())
            .collect::<Vec<_>>()
    };
    let only = |words: &[&str]| words.iter().map(|w| w.to_string()).collect::<Vec<_>>();
    let (lit, environment) = ("--environment", given("I.exr"));
    let cases = [
        (only(&["--maps", &mixed]), 1, "--normalise"),
        (only(&["--maps", &crossed]), 1, "ambake map convert"),
        (only(&["--maps", &cut]), 1, "cut.exr"),
        (with(&["--path", &given("path.csv")]), 1, "line 2"),
        (with(&["--path", &given("empty.csv")]), 1, "no lines"),
        (with(&["--path", &given("same.csv")]), 1, "frame 0"),
        (with(&["--specular-weight", &given("w.txt")]), 1, "ascend"),
        (with(&["--specular-weight", &given("none")]), 1, "none"),
        (with(&["--incidences", "45"]), 1, "S_45.exr"),
        (with(&["--incidences", "91"]), 2, "0..90"),
        (with(&["--up", "0,0,0"]), 1, "--up"),
        (with(&["--frames", "0"]), 2, "--frames"),
        (with(&["--turn-deg", "3"]), 2, "--frames"),
        (with(&["--rays", "16"]), 2, "--rays"),
        (with(&["--shader", "varnish"]), 2, lit),
        (with(&["--specular-weight", "schlick:2"]), 2, "0..1"),
        (only(&["--maps", "D.exr"]), 2, "D,S"),
        (only(&["--shader", "mirror"]), 2, lit),
        (only(&["--shader", "retro", lit, &environment]), 2, "--maps"),
        (only(&[lit, &environment]), 2, "--maps"),
        (only(&["--figure", "balls"]), 2, lit),
        (only(&["--lookup", "quad"]), 2, "--maps"),
        (
            only(&["--specular-weight", "schlick:0.1"]),
            1,
            "--model phong",
        ),
    ];
    let ball = scene("ball.obj").display().to_string();
    for (more, status, word) in cases {
        let fixed = ["render", &ball, "-o", &path("x.exr"), "--size", "8x8"].map(str::to_owned);
        let output = run(fixed.into_iter().chain(more.clone()));
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{more:?}: {errors}");
        assert!(errors.contains(word), "{more:?}: {errors}");
        assert!(status == 2 || errors.lines().count() == 1, "{errors}");
        assert_eq!(files(folder.path()), ["in"], "{more:?}");
    }
}

#[test]
fn a_picture_of_codes_is_relit_as_its_scene_is_shaded() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let text = |name: &str| at(name).display().to_string();
    let ball = scene("ball.obj").display().to_string();
    let view = "--size 40x40 --eye 1,2,4 --look 0,0,0 --samples 1 --quiet";
    let colors = "--albedo 0.5,0.4,0.3 --specular 0.25,0.25,0.25";
    let shot = |words: &[&str]| {
        let all = words.iter().flat_map(|words| words.split(' '));
        run_well(["render"].into_iter().chain(all));
    };
    for code in ["256", "oct8+8", "oct16+16"] {
        let codes = text("codes.exr");
        shot(&[&ball, "--encode", code, "-o", &codes, view, colors]);
        // Two tables, the picture of codes as it is; each time as the scene is shaded with normals of that code.
        for blue in [0.25, 1.0] {
            write_map(&at("I.exr"), 64, |k| {
                [(k % 64) as f32 / 32.0, (k / 64) as f32 / 32.0, blue]
            });
            let maps = reflect(folder.path(), &at("I.exr"), &[]);
            let environment = text("I.exr");
            let lit = format!("--maps {maps} --environment {environment}");
            let [relit, shaded] = ["relit.exr", "shaded.exr"].map(text);
            shot(&[&codes, "--relight", &lit, "-o", &relit, "--quiet"]);
            shot(&[&ball, &lit, "--normals", code, "-o", &shaded, view, colors]);
            let [relit, shaded] = [relit, shaded].map(|path| load_image(&path));
            assert_eq!(relit.pixels.len(), 1600);
            for (a, b) in relit.pixels.iter().zip(&shaded.pixels) {
                // Views are rounded once more or less.
                let off = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
                assert!(off < 1e-5, "{code}: {a:?} for {b:?}");
            }
        }
    }
    // Other reflectances, and what is no such picture.
    let maps = format!("{},{}", text("D.exr"), text("S.exr"));
    let dark = text("dark.exr");
    let black = "--albedo 0,0,0 --specular 0,0,0 --quiet";
    shot(&[
        &text("codes.exr"),
        "--relight --maps",
        &maps,
        "-o",
        &dark,
        black,
    ]);
    let pixels = load_image(&dark).pixels;
    assert!(pixels.iter().all(|pixel| *pixel == [0.0; 3]));
    for (file, more, says) in [
        (text("I.exr"), &[][..], "--encode"),
        (text("codes.exr"), &["--lookup", "quad"], "--lookup"),
        (text("none.exr"), &[], "none.exr"),
    ] {
        let out = text("wrong.exr");
        let words = ["render", &file, "--relight", "--maps", &maps, "-o", &out];
        let output = run([&words[..], more].concat());
        let line = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && line.contains(says), "{line}");
        assert!(!at("wrong.exr").exists());
    }
}
