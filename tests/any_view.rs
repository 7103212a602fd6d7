//! One bake for every view, against bakes for each view.

use crate::support::{Page, bake, files, report, run, scene};
use ambient::any_view::{COUNT, Coefficients, Lobe, count};
use glam::{DQuat, DVec3, EulerRot};
use std::path::{Path, PathBuf};

/// The numbers of a texel, its normal and its place.
fn texel(page: &Page, layer: &str, numbers: usize, at: usize) -> (Coefficients, DVec3, DVec3) {
    let mut coefficients = Coefficients::default();
    for k in 0..numbers {
        coefficients.0[k] = f64::from(page.plane(&format!("{layer}.{k:02}"))[at]);
    }
    let three = |layer: &str| {
        DVec3::from(
            ["X", "Y", "Z"].map(|axis| f64::from(page.plane(&format!("{layer}.{axis}"))[at])),
        )
    };
    (coefficients, three("normal"), three("position"))
}

fn covered(page: &Page) -> Vec<usize> {
    let coverage = page.plane("coverage");
    (0..coverage.len())
        .filter(|&at| coverage[at] > 0.0)
        .collect()
}

/// Three squares that meet in a corner, turned so that no normal lies along an axis.
fn turned_corner(folder: &Path, turn: DQuat) -> PathBuf {
    let corners = [0, 1, 2, 3, 4, 5, 6].map(|k: u32| {
        let at = DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
        let DVec3 { x, y, z } = turn * at;
        format!("v {x} {y} {z}\n")
    });
    let path = folder.join("corner.obj");
    let faces = "f 1 5 6 2\nf 1 3 7 5\nf 1 2 4 3\n";
    std::fs::write(&path, corners.concat() + faces).expect("the folder is writable");
    path
}

#[test]
fn one_bake_is_thirty_bakes_of_single_views() {
    let written = tempfile::tempdir().expect("a folder");
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.5, 0.7, 0.3);
    let scene = turned_corner(written.path(), turn);
    let small = [
        "--size",
        "32",
        "--rays",
        "128",
        "--seams",
        "off",
        "--exponent",
        "20",
        "--specular",
        "1,1,1",
    ];
    let more = [
        "--only",
        "any-view.8,error.any-view,normal,position,visibility",
    ];
    let (folder, page) = bake(&scene, &[&small[..], &more[..]].concat());
    let texels = covered(&page);
    let (mut squares, mut stated, mut views) = (0.0, 0.0, 0);
    for view in 0..30 {
        let theta = 80f64.to_radians() * (f64::from(view) + 0.5) / 30.0;
        let (s, c) = (2.4 * f64::from(view)).sin_cos();
        let eye = 1e4 * (turn * DVec3::new(theta.sin() * c, theta.cos(), theta.sin() * s));
        let eye_text = format!("{},{},{}", eye.x, eye.y, eye.z);
        let (_folder, single) = bake(
            &scene,
            &[
                &small[..],
                &["--only", "specular,error.specular", "--view", &eye_text],
            ]
            .concat(),
        );
        for &at in texels.iter().step_by(23) {
            let (numbers, normal, position) = texel(&page, "any-view.8", count(8), at);
            let direction = (eye - position).normalize();
            if direction.dot(normal) <= 0.1 {
                continue;
            }
            let found = numbers.specular(8, Lobe::Phong(20.0), normal, direction);
            squares += (found - f64::from(single.plane("specular")[at])).powi(2);
            stated += f64::from(page.plane("error.any-view")[at]).powi(2);
            stated += f64::from(single.plane("error.specular")[at]).powi(2);
            views += 1;
        }
    }
    assert!(views > 300, "{views}");
    let [rms, stated] = [squares, stated].map(|sum| f64::sqrt(sum / f64::from(views)));
    println!("rms {rms:.4} where {stated:.4} is stated");
    assert!(rms < 0.07, "{rms}");
    assert!(
        rms < 1.3 * stated && stated < 4.0 * rms,
        "{rms}: {stated} is stated"
    );
    let held = &report(folder.path())["any_view"];
    assert_eq!(
        (held["order"].as_u64(), held["numbers"].as_u64()),
        (Some(8), Some(45))
    );
    let names = files(folder.path());
    for name in [
        "corner.any-view.exr",
        "corner.any-view.glsl",
        "corner.any-view.wgsl",
    ] {
        assert!(
            names.iter().any(|found| found.ends_with(name)),
            "{name} of {names:?}"
        );
    }
}

/// A floor below a slab that hovers over a part of it, beside a wall.
fn under_a_slab(folder: &Path) -> PathBuf {
    let path = folder.join("slab.obj");
    let floor = "v 0 0 0\nv 0 0 2\nv 2 0 2\nv 2 0 0\n";
    let slab = "v 0.8 0.5 0.5\nv 0.8 0.5 1.5\nv 1.8 0.5 1.5\nv 1.8 0.5 0.5\n";
    let wall = "v 0 0.7 0\nv 0 0.7 2\n";
    let faces = "o floor\nf 1 2 3 4\no slab\nf 5 6 7 8\no wall\nf 9 10 2 1\n";
    std::fs::write(&path, [floor, slab, wall, faces].concat()).expect("the folder is writable");
    path
}

#[test]
fn any_view_of_ggx_is_off_by_what_is_stated() {
    // Roughness 0.55: α = 0.3025 = 1 / sqrt(2 n + 1).
    let (alpha, exponent) = (0.3025_f64, "4.964");
    let written = tempfile::tempdir().expect("a folder");
    let scene = under_a_slab(written.path());
    let flags = format!(
        "--size 32 --rays 1024 --seams off --model ggx --exponent {exponent} --specular 1,1,1 --include floor --only"
    );
    let small: Vec<&str> = flags.split(' ').collect();
    let layers = "any-view.4,error.any-view,normal,position";
    let (_folder, page) = bake(&scene, &[&small[..], &[layers]].concat());
    let texels = covered(&page);
    let (mut squares, mut stated, mut count_of) = (0.0, 0.0, 0);
    for view in 0..12 {
        let theta = 80f64.to_radians() * (f64::from(view) + 0.5) / 12.0;
        let (s, c) = (2.4 * f64::from(view)).sin_cos();
        let eye = 1e4 * DVec3::new(theta.sin() * c, theta.cos(), theta.sin() * s);
        let eye_text = format!("{},{},{}", eye.x, eye.y, eye.z);
        let more = ["specular,error.specular", "--view", &eye_text];
        let (_folder, single) = bake(&scene, &[&small[..], &more].concat());
        for &at in texels.iter().step_by(5) {
            let (numbers, normal, position) = texel(&page, "any-view", count(4), at);
            let direction = (eye - position).normalize();
            let found = numbers.specular(4, Lobe::Ggx(alpha), normal, direction);
            squares += (found - f64::from(single.plane("specular")[at])).powi(2);
            stated += f64::from(page.plane("error.any-view")[at]).powi(2);
            stated += f64::from(single.plane("error.specular")[at]).powi(2);
            count_of += 1;
        }
    }
    assert!(count_of > 1000, "{count_of}");
    let [rms, stated] = [squares, stated].map(|sum| f64::sqrt(sum / f64::from(count_of)));
    println!("rms {rms:.4} where {stated:.4} is stated");
    assert!(
        rms < 1.2 * stated && stated < 2.5 * rms,
        "{rms}: {stated} is stated"
    );
}

#[test]
fn open_texels_hold_one_and_zeros_and_orders_are_nested() {
    let small = ["--size", "32", "--rays", "16", "--seams", "off"];
    let (_folder, page) = bake(
        &scene("plane.obj"),
        &[&small[..], &["--layers", "any-view"]].concat(),
    );
    for at in covered(&page) {
        assert_eq!(page.plane("any-view.00")[at], 1.0);
        for k in 1..count(4) {
            assert_eq!(page.plane(&format!("any-view.{k:02}"))[at], 0.0);
        }
    }
    let layers = ["--layers", "any-view,any-view.8"];
    let (_folder, page) = bake(&scene("wall_long.obj"), &[&small[..], &layers].concat());
    for k in 0..count(4) {
        assert_eq!(
            page.plane(&format!("any-view.{k:02}")),
            page.plane(&format!("any-view.8.{k:02}"))
        );
    }
    // The first number is the visibility, rounded to a half.
    for at in covered(&page) {
        let (first, visibility) = (page.plane("any-view.00")[at], page.plane("visibility")[at]);
        assert!((first - visibility).abs() < 3e-4, "{first} {visibility}");
    }
    assert_eq!(count(8), COUNT);
}

#[test]
fn wide_highlights_beside_narrow_ones_hold_no_more_than_they_need() {
    // A matte wall and a glossy floor: exponents of 3 and of 300.
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let material = |name: &str, exponent: u32| {
        format!("newmtl {name}\nKd 0.5 0.5 0.5\nKs 0.2 0.2 0.2\nNs {exponent}\n")
    };
    let text = material("wide", 3) + &material("narrow", 300);
    std::fs::write(at("two.mtl"), text).expect("a file");
    let corners = "v 0 0 0\nv 2 0 0\nv 2 0 2\nv 0 0 2\nv 0 2 0\nv 2 2 0\n";
    let faces = "o floor\nusemtl narrow\nf 1 4 3 2\no wall\nusemtl wide\nf 1 2 6 5\n";
    let path = at("two.obj");
    std::fs::write(&path, format!("mtllib two.mtl\n{corners}{faces}")).expect("a file");
    let flags = ["--size", "32", "--rays", "64", "--seams", "off"];
    let more = ["--layers", "any-view,error.any-view,exponent"];
    let (_folder, page) = bake(&path, &[&flags[..], &more].concat());
    let upper = |at: usize| {
        let numbers = (count(4)..COUNT).map(|k| page.plane(&format!("any-view.8.{k:02}"))[at]);
        numbers.fold(0.0f32, |most, number| most.max(number.abs()))
    };
    let (mut wide, mut narrow) = (0, 0);
    for at in covered(&page) {
        match page.plane("exponent")[at] {
            3.0 => {
                assert_eq!(upper(at), 0.0);
                wide += 1;
            }
            _ => narrow += usize::from(upper(at) > 0.01),
        }
    }
    assert!(wide > 100 && narrow > 100, "{wide} {narrow}");
}

/// What naga, which is Bevy's and wgpu's compiler of shaders, says against a module.
fn complaint(module: &naga::Module) -> Option<String> {
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    let found = validator.validate(module);
    found.err().map(|error| error.emit_to_string(""))
}

#[test]
fn shaders_compile_as_they_are_written() {
    let small = ["--size", "16", "--rays", "4"];
    for (layer, order) in [("any-view", 4), ("any-view.8", 8)] {
        let flags = [&small[..], &["--layers", layer]].concat();
        let (folder, _) = bake(&scene("plane.obj"), &flags);
        let read = |ending: &str| {
            let path = folder.path().join(format!("plane.any-view.{ending}"));
            std::fs::read_to_string(path).expect("written")
        };
        let wgsl = naga::front::wgsl::parse_str(&read("wgsl"));
        let module = wgsl.unwrap_or_else(|e| panic!("{}", e.emit_to_string(&read("wgsl"))));
        assert_eq!(complaint(&module), None, "WGSL, order {order}");
        let function = module.functions.iter().next().expect("a function").1;
        assert_eq!(function.name.as_deref(), Some("any_view"));

        // Vulkan's GLSL, which alone naga reads, keeps picture and sampler apart; browsers run the file as it is.
        let glsl = read("glsl")
            .replace("sampler2D kernel", "texture2D kernel, sampler linear")
            .replace("(kernel,", "(sampler2D(kernel, linear),");
        let glsl = format!("#version 450\n{glsl}\nvoid main() {{}}\n");
        let options = naga::front::glsl::Options::from(naga::ShaderStage::Fragment);
        let module = naga::front::glsl::Frontend::default().parse(&options, &glsl);
        let module = module.unwrap_or_else(|e| panic!("{}", e.emit_to_string(&glsl)));
        assert_eq!(complaint(&module), None, "GLSL, order {order}");
    }
    let broken = naga::front::wgsl::parse_str("fn f() -> f32 { return 1i; }");
    assert!(!broken.is_ok_and(|module| complaint(&module).is_none()));
}

#[test]
fn plan_says_what_the_numbers_hold() {
    let path = scene("wall_long.obj");
    let words = |more: &[&str]| {
        let path: &Path = &path;
        let arguments = [
            &["plan", path.to_str().expect("a name"), "--json"][..],
            more,
        ]
        .concat();
        String::from_utf8(run(arguments).stdout).expect("UTF-8")
    };
    let sharp = words(&["--layers", "any-view", "--exponent", "20"]);
    let text = "45 numbers a texel for any view: for the narrowest lobe, n = 20, 15 numbers leave about 0.071 \
        and 45 about 0.009, beside noise of 0.044 at 256 rays";
    assert!(sharp.contains(text), "{sharp}");
    assert!(!words(&[]).contains("any view"));
    // GGX passes on more of high bands than a Phong lobe of the same material.
    let rough = words(&[
        "--layers",
        "any-view",
        "--exponent",
        "7.5",
        "--model",
        "ggx",
    ]);
    let text =
        "for the narrowest lobe, roughness 0.50, 15 numbers leave about 0.044 and 45 about 0.013";
    assert!(rough.contains(text), "{rough}");
    // Wide lobes and few rays need few numbers, and whoever names an order gets it.
    for (layers, exponent, rays, numbers) in [
        ("any-view", "5", "256", "15 numbers"),
        ("any-view", "20", "16", "15 numbers"),
        ("any-view", "6", "1024", "45 numbers"),
        ("any-view.4", "20", "256", "15 numbers"),
        ("any-view.8", "5", "16", "45 numbers"),
        ("any-view,any-view.8", "5", "16", "45 numbers"),
    ] {
        let text = words(&["--layers", layers, "--exponent", exponent, "--rays", rays]);
        assert!(
            text.contains(&format!("{numbers} a texel")),
            "{layers} {exponent} {rays}: {text}"
        );
    }
}

#[test]
fn the_order_that_was_chosen_is_written() {
    let few = [
        "--size",
        "16",
        "--rays",
        "256",
        "--seams",
        "off",
        "--exponent",
        "40",
    ];
    for (layer, stored, other) in [
        ("any-view", "any-view.8.44", "any-view.14"),
        ("any-view.4", "any-view.14", "any-view.4.14"),
    ] {
        let flags = [&few[..], &["--layers", layer]].concat();
        let (folder, page) = bake(&scene("wall_long.obj"), &flags);
        let names = page.names();
        assert!(
            names.contains(&stored) && !names.contains(&other),
            "{names:?}"
        );
        let held = &report(folder.path())["any_view"];
        let numbers = if layer == "any-view" { 45 } else { 15 };
        assert_eq!(held["numbers"].as_u64(), Some(numbers), "{held}");
        assert_eq!(held["exponent"].as_f64(), Some(40.0), "{held}");
        let of = |k: usize| held["truncation"][k].as_f64().expect("a number");
        let noise = held["noise"].as_f64().expect("a number");
        assert!(of(1) < noise && noise < of(0), "{held}");
    }
}
