//! `ambake map`: exact answers, labels, chains and bad input, by the built program.

use crate::support::{model, run, run_well, scene};
use environment::{Format, Image, Labels};
use std::fs;
use std::path::{Path, PathBuf};

/// Writes a picture with a pixel by column and row.
fn picture(path: &Path, size: (usize, usize), pixel: impl Fn(usize, usize) -> [f32; 3]) {
    let mut image = Image::filled(size.0, size.1, [0.0; 3]);
    for (at, value) in image.pixels.iter_mut().enumerate() {
        *value = pixel(at % size.0, at / size.0);
    }
    let format = Format::of(path).expect("a picture's ending");
    let bytes = environment::encode(&image, format, &Labels::new()).expect("it can be encoded");
    fs::write(path, bytes).expect("it is written");
}

fn read(path: &Path) -> environment::ImageFile {
    environment::read(path).expect("a picture")
}

/// Runs `map` with words in which `IN` and `OUT` stand for files in the folder.
fn map(folder: &Path, words: &str) -> Vec<String> {
    let word = |word: &str| match word.strip_prefix('@') {
        Some(name) => folder.join(name).display().to_string(),
        None => word.to_owned(),
    };
    let words = words.split(' ').map(word);
    std::iter::once("map".to_owned()).chain(words).collect()
}

#[test]
fn every_kernel_of_a_constant_map_has_its_exact_value() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    picture(&at("one.exr"), (64, 32), |_, _| [1.0, 0.5, 0.0]);
    // A lobe of 1 within 60 degrees and 0 from 61 on, in the seed's scale: the mean of the cosine's line over the
    // sphere.
    fs::write(at("cap.csv"), "degrees,value\n0,1\n60,1\n61,0\n180,0\n").expect("a table");
    fs::write(at("line.csv"), "# x^1\ncosine value\n0 0\n1 1\n").expect("a table");
    let cap = 0.5 * (1.0 - 0.5 * (60f64.to_radians().cos() + 61f64.to_radians().cos()));
    for (words, exact) in [
        ("diffuse @one.exr -o @out.exr", 1.0),
        ("diffuse @one.exr -o @out.exr --normalise seed", 0.25),
        ("diffuse @one.exr -o @out.exr --kernel luminous", 1.0),
        (
            "specular @one.exr -o @out.exr --exponent 0 --size 64x32",
            1.0,
        ),
        (
            "specular @one.exr -o @out.exr --exponent 49 --normalise seed --size 64x32",
            0.01,
        ),
        (
            "specular @one.exr -o @out.exr --exponent 2.5 --size 64x32",
            1.0,
        ),
        (
            "specular @one.exr -o @out.exr --exponent 1e5 --size 64x32",
            1.0,
        ),
        (
            "specular @one.exr -o @out.exr --kernel mirror --size 32x16",
            1.0,
        ),
        (
            "specular @one.exr -o @out.exr --kernel varnish --exponent 9 --normalise seed",
            0.55,
        ),
        (
            "specular @one.exr -o @out.exr --kernel ggx --roughness 0.5 --size 64x32",
            1.0,
        ),
        (
            "specular @one.exr -o @out.exr --kernel table --table @cap.csv --normalise seed",
            cap,
        ),
        (
            "specular @one.exr -o @out.exr --kernel table --table @line.csv --normalise seed",
            0.25,
        ),
    ] {
        run_well(map(folder.path(), words));
        for [r, g, b] in read(&at("out.exr")).image.pixels {
            let (r, g) = (f64::from(r), f64::from(g));
            assert!(
                (r - exact).abs() < 1e-6 && (g - 0.5 * exact).abs() < 1e-6,
                "{words}: {r} {g}"
            );
            assert_eq!(b, 0.0, "{words}");
        }
    }
}

#[test]
fn a_chain_of_exponents_is_one_file_each_and_a_label_says_what_it_holds() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    picture(&at("sky.hdr"), (64, 32), |x, y| [x as f32, y as f32, 1.0]);
    let chain = "specular @sky.hdr -o @s.exr --exponent 10,100 --to octahedral --size 32x32 --normalise seed";
    run_well(map(folder.path(), chain));
    run_well(map(
        folder.path(),
        "specular @sky.hdr -o @one.exr --exponent 100 --to octahedral --size 32x32 --normalise seed --threads 1",
    ));
    let labels = read(&at("s_100.exr")).labels;
    assert_eq!(labels["ambakeProjection"], "octahedral");
    assert_eq!(labels["ambakeNormalisation"], "seed");
    assert_eq!(labels["ambakeOrientation"], "ambake");
    assert!(labels["ambakeAxes"].contains("octahedron"));
    assert!(fs::read(at("s_100.exr")).expect("a file") == fs::read(at("one.exr")).expect("a file"));
    assert!(at("s_10.exr").exists());
    // The header tells the next reader.
    let json = run_well(map(folder.path(), "stats @s_10.exr --json"));
    assert!(json.contains("octahedral"), "{json}");
}

#[test]
fn energy_survives_a_chain_of_projections_with_tools_between() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    picture(&at("a.exr"), (96, 48), |x, y| {
        [(x * x % 7) as f32, (y % 5) as f32 * 1e4, 1.0]
    });
    for words in [
        "convert @a.exr -o @b.exr --to cube --size 40x40 --orientation openexr",
        "convert @b.exr -o @c.exr --from cube --to angular --size 64x64",
        "convert @c.exr -o @d.exr --to cross --size 96x72 --orientation gltf",
        "convert @d.exr -o @e.exr --to ortho --size 80x40",
        "convert @e.exr -o @f.exr --to polar --size 96x48 --orientation blender",
    ] {
        run_well(map(folder.path(), words));
    }
    let integral = |name: &str| {
        let text = run_well(map(folder.path(), &format!("stats @{name} --json")));
        let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        [0, 1, 2].map(|c| json["integral"][c].as_f64().expect("a number"))
    };
    let (before, after) = (integral("a.exr"), integral("f.exr"));
    for c in 0..3 {
        assert!(
            (after[c] / before[c] - 1.0).abs() < 1e-6,
            "{before:?} {after:?}"
        );
    }
}

/// Files in a folder by name.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<_> = entries.map(|e| e.expect("an entry").path()).collect();
    paths.sort();
    paths
}

#[test]
fn bad_input_gets_one_line_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    for name in ["good.hdr", "good.exr"] {
        picture(&at(name), (64, 32), |x, y| [(x * y) as f32, 0.3, x as f32]);
    }
    for (good, cut) in [("good.hdr", "cut.hdr"), ("good.exr", "cut.exr")] {
        let bytes = fs::read(at(good)).expect("a file");
        fs::write(at(cut), &bytes[..bytes.len() / 2]).expect("it is written");
    }
    fs::write(at("empty.hdr"), "").expect("it is written");
    fs::write(
        at("zero.hdr"),
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 0\n",
    )
    .expect("it is written");
    fs::write(at("falls.csv"), "0.5 1\n0.2 1\n").expect("it is written");
    fs::write(at("words.csv"), "0.5 1\nhalf one\n").expect("it is written");
    fs::write(at("turn.csv"), "degrees value\n0 1\n200 1\n").expect("it is written");
    for (name, value) in [
        ("nan.exr", f32::NAN),
        ("inf.exr", f32::INFINITY),
        ("minus.exr", -1.0),
    ] {
        // The encoder refuses what is not finite.
        raw_exr(&at(name), value);
    }
    picture(&at("square.exr"), (32, 32), |_, _| [1.0; 3]);
    let odd = Labels::from([("ambakeProjection".into(), "mercator".into())]);
    let odd = environment::encode(&Image::filled(8, 4, [1.0; 3]), Format::Exr, &odd);
    fs::write(at("odd.exr"), odd.expect("it is finite")).expect("it is written");
    for face in ["px", "nx", "py", "ny", "pz", "nz"] {
        let side = if face == "nz" { 16 } else { 8 };
        picture(&at(&format!("sizes_{face}.exr")), (side, side), |_, _| {
            [1.0; 3]
        });
        if face != "py" {
            picture(&at(&format!("five_{face}.exr")), (8, 8), |_, _| [1.0; 3]);
        }
    }
    let before = files(folder.path());
    for (words, reasons) in [
        (
            "diffuse @cut.hdr -o @out.exr",
            &["cut.hdr", "scanline", "export it again"][..],
        ),
        ("diffuse @cut.exr -o @out.exr", &["cut.exr", "damaged"]),
        ("stats @cut.exr", &["cut.exr", "damaged"]),
        (
            "convert @empty.hdr -o @out.exr --to cube",
            &["empty.hdr", "empty"],
        ),
        (
            "convert @zero.hdr -o @out.exr --to cube",
            &["zero.hdr", "0 x 0"],
        ),
        ("convert @none.hdr -o @out.exr --to cube", &["none.hdr"]),
        (
            "diffuse @nan.exr -o @out.exr",
            &["nan.exr", "(1, 0)", "NaN"],
        ),
        (
            "specular @inf.exr -o @out.exr --exponent 9",
            &["inf.exr", "(1, 0)", "inf"],
        ),
        (
            "convert @minus.exr -o @out.hdr --to ball",
            &["minus.exr", "(1, 0)", "-1"],
        ),
        (
            "diffuse @square.exr -o @out.exr",
            &["square.exr", "twice as wide"],
        ),
        (
            "stats @five.exr",
            &["five.exr", "five_px.exr", "--from cube"],
        ),
        (
            "stats @five_px.exr",
            &["five_px.exr", "twice as wide", "five.exr with --from cube"],
        ),
        (
            "stats @square.exr",
            &["square.exr", "--from ball, angular or octahedral"],
        ),
        (
            "stats @odd.exr",
            &["odd.exr", "ambakeProjection", "\"mercator\"", "--from"],
        ),
        (
            "diffuse @five.exr --from cube -o @out.exr",
            &["five_py.exr", "missing"],
        ),
        (
            "diffuse @sizes.exr --from cube -o @out.exr",
            &["sizes_nz.exr", "16", "8"],
        ),
        ("diffuse @good.hdr -o @out.exr --size 10x10", &["10 x 10"]),
        ("diffuse @good.hdr -o @out.png", &["out.png", ".exr"]),
        ("diffuse @good.hdr -o @nowhere/deep/out.txt", &["out.txt"]),
        ("specular @good.hdr -o @out.exr", &["--exponent"]),
        (
            "specular @good.hdr -o @out.exr --exponent 1e6",
            &["1000000", "1e5"],
        ),
        (
            "specular @good.hdr -o @out.exr --kernel ggx --roughness 0",
            &["roughness 0"],
        ),
        (
            "specular @good.hdr -o @out.exr --kernel table --table @falls.csv",
            &["falls.csv", "ascending"],
        ),
        (
            "specular @good.hdr -o @out.exr --kernel table --table @words.csv",
            &["words.csv", "line 2"],
        ),
        (
            "specular @good.hdr -o @out.exr --kernel table --table @turn.csv",
            &["turn.csv", "200"],
        ),
        (
            "convert @good.hdr -o @out.exr --to ball --orientation blender",
            &["blender", "ball"],
        ),
    ] {
        let output = run(map(folder.path(), words));
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{words}\n{text}");
        assert_eq!(text.lines().count(), 1, "{words}\n{text}");
        for reason in reasons {
            assert!(text.contains(reason), "{words}: {reason} is not in {text}");
        }
        assert_eq!(files(folder.path()), before, "{words}");
    }
}

/// An uncompressed OpenEXR picture of 2 x 1 pixels of 1 whose second has `value` as green.
fn raw_exr(path: &Path, value: f32) {
    let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, data: &[u8]| {
        for text in [name, kind] {
            bytes.extend(text.bytes().chain([0]));
        }
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(data);
    };
    let mut channels = Vec::new();
    for name in [b'B', b'G', b'R'] {
        channels.extend([name, 0]);
        channels.extend([2u32, 0, 1, 1].map(u32::to_le_bytes).concat());
    }
    channels.push(0);
    let window = [0i32, 0, 1, 0].map(i32::to_le_bytes).concat();
    attribute("channels", "chlist", &channels);
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    bytes.push(0);
    let offset = bytes.len() as u64 + 8;
    bytes.extend(offset.to_le_bytes());
    bytes.extend([0i32, 24].map(i32::to_le_bytes).concat());
    bytes.extend(
        [1.0, 1.0, 1.0, value, 1.0, 1.0]
            .map(f32::to_le_bytes)
            .concat(),
    );
    fs::write(path, bytes).expect("it is written");
}

#[test]
fn environments_keep_their_energy_through_d_and_s() {
    let folder = tempfile::tempdir().expect("a folder");
    // The sky that this repository generates, and a real one with a sun where it is present.
    let all = [scene("sky.hdr")]
        .into_iter()
        .chain(model("hdr/venice_sunset_1k.hdr"));
    for path in all {
        let name = path.display();
        let copy = folder.path().join("in.hdr");
        fs::copy(&path, &copy).expect("it is copied");
        run_well(map(
            folder.path(),
            "diffuse @in.hdr -o @d.exr --size 512x256",
        ));
        run_well(map(
            folder.path(),
            "specular @in.hdr -o @s.exr --exponent 10,1000",
        ));
        let integral = |name: &str| {
            let file = read(&folder.path().join(name));
            let map = environment::IlluminationMap::new(file.image, environment::Projection::Polar);
            map.expect("a polar map").integral()
        };
        let before = integral("in.hdr");
        for file in ["d.exr", "s_10.exr", "s_1000.exr"] {
            let after = integral(file);
            for c in 0..3 {
                // Values at the middles of texels stand for their means: (π/256)² / 24 times the curvature.
                let change = (after[c] / before[c] - 1.0).abs();
                assert!(change < 1e-5, "{name} {file}: {before:?} {after:?}");
            }
        }
    }
}

#[test]
fn a_table_that_no_kernel_reads_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let (table, out) = (folder.path().join("t.csv"), folder.path().join("S.exr"));
    fs::write(&table, "-1,0\n1,1\n").expect("written");
    let sky = scene("sky.hdr");
    let words = [
        "map".as_ref(),
        "specular".as_ref(),
        sky.as_os_str(),
        "--exponent=5".as_ref(),
    ];
    let files = [
        "-o".as_ref(),
        out.as_os_str(),
        "--table".as_ref(),
        table.as_os_str(),
    ];
    let output = run(words.into_iter().chain(files));
    let line = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && line.contains("--kernel table"),
        "{line}"
    );
    assert!(!out.exists());
}
