//! Normal maps bend the shading normal: a constant map on a lone level square, whose terms are known on paper.

use crate::quads::{self, Quad};
use crate::support::{load_image, run, run_well, save_image};
use ambake::{Bake, Layer, Scene, Shading, Uv};
use glam::Vec3;
use serde_json::{Value, json};
use std::path::Path;
use tempfile::TempDir;

/// A map whose every normal leans by 30 degrees toward the right of the picture, and a little toward its top.
const CODE: [u8; 4] = [182, 166, 237, 255];

/// The normal of the code on a surface with these directions of the picture's right and top, and this normal.
fn bent(scale: f32, right: Vec3, top: Vec3, normal: Vec3) -> Vec3 {
    let [x, y, z] = [0, 1, 2].map(|i: usize| f32::from(CODE[i]) / 127.5 - 1.0);
    (right * x * scale + top * y * scale + normal * z).normalize()
}

fn material(texture: Value) -> Value {
    json!({
        "materials": [{ "normalTexture": texture }],
        "textures": [{ "source": 0 }],
        "images": [{ "uri": "normals.png" }],
    })
}

fn loaded(quad: Quad, texture: Value) -> (TempDir, Scene) {
    let folder = quads::write(&[quad], material(texture));
    quads::picture(&folder, "normals.png", [2, 2], &[CODE; 4]);
    let scene = ambake::load(folder.path().join("scene.gltf")).expect("the scene loads");
    (folder, scene)
}

/// The page of a bake has one normal, and the terms of an open surface that it shades.
fn assert_bent(scene: &Scene, expected: Vec3, case: &str) {
    let bake = Bake::new(scene).size(16).rays(16).uv(Uv::Unwrap);
    let baked = bake
        .normal_maps(true)
        .shading(Shading::Exact)
        .layers([Layer::Normal])
        .run(&())
        .expect("it bakes");
    let page = baked.page(0);
    let coverage = page.layer(Layer::Coverage);
    let diffuse = page.layer(Layer::Diffuse);
    let visibility = page.layer(Layer::Visibility);
    let cos = f64::from(expected.y.abs());
    // What the plane of the square leaves of a hemisphere that leans, as of scenes/tilted_normal.obj.
    let exact = [0.5 * (1.0 + cos), 1.0 - cos.acos() / std::f64::consts::PI];
    for texel in (0..coverage.len()).filter(|&texel| coverage[texel] > 0.0) {
        let normal = Vec3::from([0, 1, 2].map(|c| page.channel(Layer::Normal, c)[texel]));
        assert!(
            (normal - expected).length() < 1e-5,
            "{case}: {normal} for {expected}"
        );
        let found = [diffuse[texel], visibility[texel]].map(f64::from);
        for (found, exact) in found.iter().zip(exact) {
            assert!((found - exact).abs() < 1e-5, "{case}: {found} for {exact}");
        }
    }
}

#[test]
fn tangents_follow_the_picture_on_the_surface() {
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    let square = || Quad::level(0.0, 2.0).with("NORMAL", &[0.0, 1.0, 0.0]);
    // The picture's right is +x, its top -z.
    let plain = || json!({ "index": 0 });
    let (_folder, scene) = loaded(square(), plain());
    assert_bent(&scene, bent(1.0, x, -z, y), "made tangents");

    let (_folder, scene) = loaded(Quad::level(0.0, 2.0), plain());
    assert_bent(&scene, bent(1.0, x, -z, y), "a flat mesh");

    let (_folder, scene) = loaded(square(), json!({ "index": 0, "scale": 0.5 }));
    assert_bent(&scene, bent(0.5, x, -z, y), "half the scale");

    let mut mirrored = square();
    mirrored.uvs[0] = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]];
    let (_folder, scene) = loaded(mirrored, plain());
    assert_bent(&scene, bent(1.0, -x, -z, y), "mirrored coordinates");

    let mut turned = square();
    turned.uvs[1] = [[0.0, 1.0], [0.0, -1.0], [1.0, 0.0]];
    let (_folder, scene) = loaded(turned, json!({ "index": 0, "texCoord": 1 }));
    assert_bent(&scene, bent(1.0, z, x, y), "the second set, turned");

    // A quarter turn counter-clockwise of the coordinates turns the picture clockwise: its right points to +z, its top
    // to +x.
    let transform = json!({ "KHR_texture_transform": { "rotation": std::f64::consts::FRAC_PI_2 } });
    let (_folder, scene) = loaded(square(), json!({ "index": 0, "extensions": transform }));
    assert_bent(&scene, bent(1.0, z, x, y), "a turned texture");
}

#[test]
fn the_files_own_tangents_are_taken_with_their_sign() {
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    for (sign, top) in [(1.0, x), (-1.0, -x)] {
        let quad = Quad::level(0.0, 2.0)
            .with("NORMAL", &[0.0, 1.0, 0.0])
            .with("TANGENT", &[0.0, 0.0, 1.0, sign]);
        let (_folder, scene) = loaded(quad, json!({ "index": 0 }));
        // y x z = x.
        assert_bent(&scene, bent(1.0, z, top, y), "tangents of the file");
    }
}

#[test]
fn relief_is_mirrored_and_stretched_with_the_instance() {
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    let square = |scale| Quad {
        scale,
        ..Quad::level(0.0, 2.0).with("NORMAL", &[0.0, 1.0, 0.0])
    };
    let (_folder, scene) = loaded(square([-1.0, 1.0, 1.0]), json!({ "index": 0 }));
    assert_bent(&scene, bent(1.0, -x, -z, y), "a mirrored instance");
    // Flattened to half its height, relief leans half as much.
    let (_folder, scene) = loaded(square([1.0, 0.5, 1.0]), json!({ "index": 0 }));
    assert_bent(&scene, bent(0.5, x, -z, y), "a flattened instance");
}

#[test]
fn a_texel_has_the_mean_normal_of_the_relief_within_it() {
    // Ridges: the left half of the picture leans left, the right half right. A texel holds a part of one, or many.
    let (left, right) = ([64, 128, 238, 255], [191, 128, 238, 255]);
    let lean = |repeats: f32| {
        let mut square = Quad::level(0.0, 2.0);
        square.uvs[0] = [[0.0, 0.0], [repeats, 0.0], [0.0, repeats]];
        let folder = quads::write(&[square], material(json!({ "index": 0 })));
        let ridges: Vec<[u8; 4]> = (0..32).map(|i| if i < 16 { left } else { right }).collect();
        quads::picture(&folder, "normals.png", [32, 1], &ridges);
        let scene = ambake::load(folder.path().join("scene.gltf")).expect("the scene loads");
        let bake = Bake::new(&scene).size(32).rays(16).uv(Uv::Unwrap);
        let baked = bake.normal_maps(true).layers([Layer::Normal]).run(&());
        let baked = baked.expect("it bakes");
        let page = baked.page(0);
        let leans = page.channel(Layer::Normal, 0).iter();
        let leans = leans.zip(page.layer(Layer::Coverage));
        let leans: Vec<f32> = leans.filter(|(_, c)| **c > 0.0).map(|(x, _)| *x).collect();
        let squares = leans.iter().map(|x| x * x).sum::<f32>() / leans.len() as f32;
        let most = leans.iter().fold(0.0f32, |most, x| most.max(x.abs()));
        [most, squares.sqrt()]
    };
    // sin 30 degrees where a texel lies on one side of a ridge. Where it holds many, sixteen places that know nothing
    // of each other leave a quarter of that.
    let ([one, _], [_, many]) = (lean(1.0), lean(640.0));
    assert!((one - 0.5).abs() < 0.005, "{one}");
    assert!(many < 0.125, "{many}");
}

fn bake(scene: &Path, folder: &Path, flags: &[&str]) -> Value {
    let fixed = ["--size", "16", "--rays", "16", "--json", "-o"];
    let mut arguments = vec!["bake".into(), scene.as_os_str().to_owned()];
    arguments.extend(fixed.iter().map(Into::into));
    arguments.push(folder.as_os_str().to_owned());
    arguments.extend(flags.iter().map(Into::into));
    serde_json::from_str(&run_well(arguments)).expect("JSON")
}

#[test]
fn maps_are_counted_where_they_are_not_asked_for() {
    let (folder, _) = loaded(Quad::level(0.0, 2.0), json!({ "index": 0 }));
    let scene = folder.path().join("scene.gltf");
    let counted = |flags: &[&str]| {
        let report = bake(&scene, &folder.path().join("out"), flags);
        let warnings = report["warnings"].as_array().expect("a list").clone();
        let ignored = |warning: &&Value| warning["kind"] == "ignored-normal-maps";
        (warnings.iter().filter(ignored).count(), report)
    };
    let (without, report) = counted(&[]);
    assert_eq!(
        (without, &report["options"]["normal_maps"]),
        (1, &json!(false))
    );
    let (with, report) = counted(&["--normal-maps"]);
    assert_eq!((with, &report["options"]["normal_maps"]), (0, &json!(true)));
}

#[test]
fn obj_statements_give_normals_or_heights() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    quads::picture(&folder, "normals.png", [2, 2], &[CODE; 4]);
    // Heights rise by 32/255 a pixel to the right.
    let ramp: Vec<[u8; 4]> = (0..8u8).map(|i| [32 * i, 32 * i, 32 * i, 255]).collect();
    quads::picture(&folder, "heights.png", [8, 1], &ramp);
    let square = "mtllib a.mtl\nusemtl a\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\n\
                  vt 0.4 0\nvt 0.6 0\nvt 0.6 1\nvt 0.4 1\nf 1/1 2/2 3/3 4/4\n";
    std::fs::write(folder.path().join("a.obj"), square).expect("a writable folder");
    let baked = |statement: &str| {
        let library = format!("newmtl a\nKd 1 1 1\n{statement}\n");
        std::fs::write(folder.path().join("a.mtl"), library).expect("a writable folder");
        ambake::load(folder.path().join("a.obj")).expect("the scene loads")
    };
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    for statement in [
        "norm normals.png",
        "map_Bump normals.png",
        "bump -bm 1 normals.png",
    ] {
        assert_bent(&baked(statement), bent(1.0, x, -z, y), statement);
    }
    let half = baked("map_bump -bm 0.5 normals.png");
    assert_bent(&half, bent(0.5, x, -z, y), "half the multiplier");
    let slope = baked("map_Bump -bm 2 heights.png");
    let page = Bake::new(&slope).size(16).rays(16).uv(Uv::Unwrap);
    let baked = page.normal_maps(true).layers([Layer::Normal]).run(&());
    let baked = baked.expect("it bakes");
    let lean = |c| baked.page(0).channel(Layer::Normal, c)[8 * 16 + 8];
    let found = lean(0) / lean(1);
    // Coded in 8 bits.
    assert!((found + 2.0 * 32.0 / 255.0).abs() < 0.01, "{found}");
}

#[test]
fn a_map_that_cannot_be_read_is_absent_and_told_of_where_it_is_asked_for() {
    let (folder, _) = loaded(Quad::level(0.0, 2.0), json!({ "index": 0 }));
    let picture = folder.path().join("normals.png");
    let missing = |bake: &Bake| -> Vec<String> {
        let warnings = bake.prepare().expect("it is ready").warnings();
        let missing = warnings
            .into_iter()
            .filter(|w| w.kind == "missing-textures");
        missing.map(|warning| warning.message).collect()
    };
    for broken in [true, false] {
        match broken {
            true => {
                std::fs::write(&picture, b"no picture").expect("a writable folder");
                let at = |name: &str| folder.path().join(name).display().to_string();
                let (from, to) = (at("scene.gltf"), at("out.png"));
                let words = "--normal-maps --size 8x8 --samples 1 --rays 4".split(' ');
                let drawn = run(["render", &from, "-o", &to].into_iter().chain(words));
                let told = String::from_utf8_lossy(&drawn.stderr);
                let ends = told
                    .lines()
                    .any(|line| line.ends_with("normals stand alone"));
                assert!(drawn.status.success() && ends, "{told}");
            }
            false => std::fs::remove_file(&picture).expect("the picture"),
        }
        let scene = ambake::load(folder.path().join("scene.gltf")).expect("it loads");
        let bake = Bake::new(&scene).size(16).rays(16).uv(Uv::Unwrap);
        assert_eq!(missing(&bake), [""; 0], "broken: {broken}");
        let bake = bake.normal_maps(true).layers([Layer::Normal]);
        let found = missing(&bake);
        assert_eq!(found.len(), 1, "broken: {broken}: {found:?}");
        assert!(found[0].ends_with("the mesh's normals stand alone") && !found[0].contains('\n'));
        let baked = bake.run(&()).expect("it bakes");
        let up = |c| baked.page(0).channel(Layer::Normal, c)[8 * 16 + 8];
        assert_eq!([up(0), up(1), up(2)], [0.0, 1.0, 0.0], "broken: {broken}");
    }
}

#[test]
fn pictures_show_relief_by_integration_and_from_tables() {
    let square = Quad::level(0.0, 2.0).with("NORMAL", &[0.0, 1.0, 0.0]);
    let (folder, _) = loaded(square, json!({ "index": 0 }));
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (scene, out) = (at("scene.gltf"), at("out.exr"));
    // From straight above, the whole picture within the square.
    let view = "--eye 0,1,0 --look 0,0,0 --up 0,0,-1 --size 8x8 --samples 1 --albedo 0.5,0.5,0.5 --specular 0,0,0";
    let shot = |more: &[&str]| -> Vec<[f32; 3]> {
        let words = ["render", &scene, "-o", &out, "-q"];
        let words: Vec<&str> = words.into_iter().chain(view.split(' ')).collect();
        run_well([&words[..], more].concat());
        load_image(&out).pixels
    };
    let normal = bent(1.0, Vec3::X, -Vec3::Z, Vec3::Y);
    let sun = Vec3::new(1.0, 2.0, 0.5).normalize();
    let lit = ["--model", "lambert", "--rays", "0", "--sun", "1,2,0.5,3"];
    for (more, normal) in [(&[][..], Vec3::Y), (&["--normal-maps"], normal)] {
        let exact = 0.5 * 3.0 / std::f32::consts::PI * normal.dot(sun);
        for pixel in shot(&[&lit[..], more].concat()) {
            assert!((pixel[0] - exact).abs() < 1e-4, "{pixel:?} for {exact}");
        }
    }
    // D whose texel at a direction is that direction, moved into 0..1.
    let (width, height) = (256, 128);
    let texel = |at: usize| {
        let turn = ((at % width) as f32 + 0.5) / width as f32 * std::f32::consts::TAU
            - std::f32::consts::PI;
        let polar = ((at / width) as f32 + 0.5) / height as f32 * std::f32::consts::PI;
        let toward = [
            polar.sin() * turn.sin(),
            polar.cos(),
            polar.sin() * turn.cos(),
        ];
        toward.map(|v| 0.5 + 0.5 * v)
    };
    let image = environment::Image {
        width,
        height,
        pixels: (0..width * height).map(texel).collect(),
    };
    save_image(at("D.exr"), &image);
    let tables = [at("D.exr"), at("D.exr")].join(",");
    for pixel in shot(&["--maps", &tables, "--normal-maps"]) {
        // Bilinear between texels of 1.4 degrees: 0.5 (half a step)^2 / 2.
        let expected = (0.5 + 0.5 * normal) * 0.5;
        let off = (Vec3::from(pixel) - expected).abs().max_element();
        assert!(off < 5e-4, "{pixel:?} for {expected}");
    }
}
