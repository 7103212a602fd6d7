//! `bake --sky FILE`: an illumination map in place of the uniform sky, against closed forms and against the maps
//! convolved from it.

use crate::support::{Page, backends, bake, load_image, run, run_well, save_image, scene};
use environment::{IlluminationMap, Image, Projection};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A polar map by a function of the unit direction at each texel's middle, written as an EXR.
fn sky(folder: &Path, width: usize, radiance: impl Fn([f64; 3]) -> [f32; 3]) -> PathBuf {
    let height = width / 2;
    let pixels = (0..width * height).map(|i| {
        let turn = ((i % width) as f64 + 0.5) / width as f64 * TAU - PI;
        let polar = ((i / width) as f64 + 0.5) / height as f64 * PI;
        radiance([
            polar.sin() * turn.sin(),
            polar.cos(),
            polar.sin() * turn.cos(),
        ])
    });
    let image = Image {
        width,
        height,
        pixels: pixels.collect(),
    };
    let path = folder.join("sky.exr");
    save_image(&path, &image);
    path
}

/// Horizon to zenith in blue, a dark ground, and a sun a thousand times as bright.
fn day([x, y, z]: [f64; 3]) -> [f32; 3] {
    let sun = 0.6 * x + 0.64 * y + 0.48 * z > 0.998;
    let up = y.max(0.0) as f32;
    if sun {
        [1000.0, 900.0, 700.0]
    } else if y > 0.0 {
        [0.4 + 0.2 * up, 0.5 + 0.5 * up, 0.6 + 1.4 * up]
    } else {
        [0.2, 0.15, 0.1]
    }
}

/// Red, green and blue of a layer.
fn rgb<'a>(page: &'a Page, layer: &str) -> [&'a [f32]; 3] {
    ["R", "G", "B"].map(|c| page.plane(&format!("{layer}.{c}")))
}

/// A sphere of 320 flat triangles, an icosahedron divided twice, and its normals.
fn flat_sphere(folder: &Path) -> (PathBuf, Vec<[f64; 3]>) {
    let g = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners: Vec<[f64; 3]> = Vec::new();
    for (a, b) in [(1.0, g), (1.0, -g), (-1.0, g), (-1.0, -g)] {
        corners.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
    }
    let close = |a: [f64; 3], b: [f64; 3]| {
        let square: f64 = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum();
        (square - 4.0).abs() < 1e-9
    };
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in 0..i {
            for k in 0..j {
                let [a, b, c] = [corners[i], corners[j], corners[k]];
                if close(a, b) && close(b, c) && close(a, c) {
                    triangles.push([a, b, c]);
                }
            }
        }
    }
    let middle = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| a[c] + b[c]) };
    let unit = |v: [f64; 3]| v.map(|c| c / v.iter().map(|x| x * x).sum::<f64>().sqrt());
    for _ in 0..2 {
        triangles = triangles
            .into_iter()
            .flat_map(|t| {
                let [a, b, c] = t.map(unit);
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| unit(middle(p, q)));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let mut text = String::new();
    let mut normals = Vec::new();
    for (i, [a, b, c]) in triangles.iter().enumerate() {
        let u: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
        let v: [f64; 3] = std::array::from_fn(|k| c[k] - a[k]);
        let cross = [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ];
        let outward = (0..3).map(|k| cross[k] * a[k]).sum::<f64>() > 0.0;
        normals.push(unit(if outward { cross } else { cross.map(|c| -c) }));
        for p in if outward { [a, b, c] } else { [a, c, b] } {
            writeln!(text, "v {} {} {}", p[0], p[1], p[2]).expect("a string");
        }
        writeln!(text, "f {} {} {}", 3 * i + 1, 3 * i + 2, 3 * i + 3).expect("a string");
    }
    let path = folder.join("sphere.obj");
    std::fs::write(&path, text).expect("a file");
    (path, normals)
}

#[test]
fn a_constant_map_bakes_the_bytes_of_a_uniform_sky() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = sky(folder.path(), 16, |_| [0.5, 1.0, 2.0]);
    let common = ["--size", "64", "--rays", "16", "--exponent", "20"];
    let with = |sky: &str| {
        bake(
            &scene("trench.obj"),
            &[&common[..], &["--sky", sky]].concat(),
        )
    };
    let (_a, uniform) = with("0.5,1,2");
    let (_b, map) = with(path.to_str().expect("UTF-8"));
    for (name, values) in [uniform.names()]
        .concat()
        .iter()
        .map(|n| (n, uniform.plane(n)))
    {
        assert_eq!(values, map.plane(name), "{name}");
    }
}

#[test]
fn a_picture_under_a_map_is_that_of_its_light_with_either_seed() {
    let folder = tempfile::tempdir().expect("a folder");
    let even = sky(folder.path(), 16, |_| [0.5, 1.0, 2.0]);
    let shot = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        let path = path.to_str().expect("UTF-8");
        let courtyard = scene("courtyard.obj");
        let courtyard = courtyard.to_str().expect("UTF-8");
        let common = [
            "render",
            courtyard,
            "-o",
            path,
            "--size",
            "48x27",
            "--samples",
            "2",
            "-q",
        ];
        run_well([&common[..], more].concat());
        load_image(path).pixels
    };
    let even = even.to_str().expect("UTF-8");
    let map = shot("a.exr", &["--rays", "8", "--sky", even]);
    assert_eq!(map, shot("b.exr", &["--rays", "8", "--sky", "0.5,1,2"]));
    // One texel of 256 x 128 holds two thirds of the light.
    let sun = sky(folder.path(), 256, |[x, y, z]| {
        [1.0 + 1e4 * f32::from(u8::from(0.6 * x + 0.64 * y + 0.48 * z > 0.9998)); 3]
    });
    let sun = [
        "--sky",
        sun.to_str().expect("UTF-8"),
        "--background",
        "0,0,0",
    ];
    for model in ["lambert", "phong", "ggx"] {
        let mean = |seed: &str| {
            let more = ["--rays", "64", "--model", model, "--seed", seed];
            let pixels = shot("c.exr", &[&sun[..], &more].concat());
            pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / pixels.len() as f64
        };
        let [a, b] = [mean("0"), mean("1")];
        assert!((a / b - 1.0).abs() < 0.005, "{model}: {a} and {b}");
    }
    let folder = folder.path().join("d.png");
    let output = run([
        "render".as_ref(),
        scene("courtyard.obj").as_os_str(),
        "-o".as_ref(),
        folder.as_os_str(),
        "--sky".as_ref(),
        "night.hdr".as_ref(),
    ]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && said.contains("cannot read night.hdr"),
        "{said}"
    );
}

#[test]
fn on_an_unoccluded_sphere_the_bake_and_both_reflection_maps_agree() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = sky(folder.path(), 256, day);
    let image = load_image(&path);
    let map = IlluminationMap::new(image, Projection::Polar).expect("polar");
    // Bilinear look-up errs by n h^2 / 8 of the peak: 4e-5 and 5e-5.
    let diffuse = maps::diffuse(&map, (360, 180)).expect("D");
    let specular = maps::specular(&map, 20.0, (1440, 720)).expect("S");
    let arguments = "--size 64 --rays 16384 --exponent 20 --uv unwrap --seams off --layers \
                     irradiance,reflection,error.irradiance,error.reflection,normal --sky";
    let mut arguments: Vec<&str> = arguments.split_whitespace().collect();
    arguments.push(path.to_str().expect("UTF-8"));
    let (sphere, facets) = flat_sphere(folder.path());
    let (folder, page) = bake(&sphere, &arguments);
    let report = std::fs::read_to_string(folder.path().join("bake.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    let lit = (0..page.size * page.size).filter(|&texel| page.plane("coverage")[texel] > 0.0);
    let squares: Vec<f64> = lit
        .map(|texel| f64::from(page.plane("error.irradiance")[texel]).powi(2))
        .collect();
    let stated = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let reported = report["pages"][0]["irradiance_rmse"]
        .as_f64()
        .expect("a number");
    assert!(
        (reported / stated - 1.0).abs() < 1e-6,
        "{reported} for {stated}"
    );
    let normals = ["X", "Y", "Z"].map(|c| page.plane(&format!("normal.{c}")));
    for (layer, exact) in [("irradiance", &diffuse), ("reflection", &specular)] {
        let values = rgb(&page, layer);
        let errors = page.plane(&format!("error.{layer}"));
        let (mut squares, mut stated, mut count, mut within) = (0.0, 0.0, 0.0, 0.0);
        let mut mean = 0.0;
        for texel in 0..page.size * page.size {
            // A texel of several triangles has a mean normal, which is that of no triangle, or one that knows nothing
            // of a triangle at its border: those count about which all is one facet.
            let normal = normals.map(|n| f64::from(n[texel]));
            let is_facet = |at: usize, facet: &[f64; 3]| {
                (0..3).all(|c| (facet[c] - f64::from(normals[c][at])).abs() < 1e-6)
            };
            let (x, y) = (texel % page.size, texel / page.size);
            let is_inner = (1..page.size - 1).contains(&x) && (1..page.size - 1).contains(&y);
            let near = [texel, texel + 1, texel + page.size];
            let is_amid = |facet: &[f64; 3]| {
                let beside = [texel - 1, texel - page.size];
                near.iter().chain(&beside).all(|&at| is_facet(at, facet))
            };
            if !is_inner || !facets.iter().any(is_amid) {
                continue;
            }
            let expected = exact.bilinear(normal);
            let sum = |v: [f32; 3]| v.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
            let difference = sum(values.map(|v| v[texel])) - sum(expected);
            let error = f64::from(errors[texel]);
            squares += difference * difference;
            stated += error * error;
            within += f64::from(u8::from(difference.abs() <= 2.05 * error));
            mean += sum(expected);
            count += 1.0;
        }
        let rmse = f64::sqrt(squares / count) / (mean / count);
        println!(
            "{layer}: {count} texels, RMSE {rmse:.2e} of the mean, stated over true {:.2}, {:.1} % within 2.05 errors",
            f64::sqrt(stated / squares),
            100.0 * within / count
        );
        // Rays of 16,384: 2.3e-4 and 2.8e-4.
        assert!(rmse < 5e-4, "{layer}: {rmse}");
        // Student's t for nine pooled texels is 2.05 at 95 %. Facets of other brightness pool their variances too,
        // which understates the errors of the bright ones: 88 to 92 % by seed.
        assert!(within > 0.87 * count, "{layer}: {within} of {count}");
    }
}

#[test]
fn the_generated_sky_lights_an_open_plane_as_its_upper_half_says() {
    let path = scene("sky.hdr");
    let image = load_image(&path);
    let (width, height) = (image.width as f64, image.height as f64);
    // (1/pi) times the integral of cos over the texels above the horizon, y up.
    let mut exact = [0.0; 3];
    for (i, pixel) in image.pixels.iter().enumerate().take(image.pixels.len() / 2) {
        let row = (i / image.width) as f64;
        let [top, bottom] = [row, row + 1.0].map(|y| (y / height * PI).sin().powi(2));
        let weight = TAU / width * (bottom - top) / 2.0 / PI;
        for (sum, value) in exact.iter_mut().zip(pixel) {
            *sum += f64::from(*value) * weight;
        }
    }
    let arguments = "--size 16 --rays 4096 --layers irradiance,error.irradiance --sky";
    let mut arguments: Vec<&str> = arguments.split(' ').collect();
    arguments.push(path.to_str().expect("UTF-8"));
    let (_folder, page) = bake(&scene("plane.obj"), &arguments);
    let error = page.plane("error.irradiance");
    for (values, exact) in rgb(&page, "irradiance").into_iter().zip(exact) {
        for (value, error) in values.iter().zip(error) {
            // 256 texels: five stated errors, and what a scattered error may understate itself by.
            let off = (f64::from(*value) - exact).abs();
            assert!(
                off < 5.0 * f64::from(*error) + 1e-3 * exact,
                "{value} +- {error} for {exact}"
            );
        }
    }
}

#[test]
fn light_from_one_half_of_the_sky_is_blocked_by_the_wall_on_that_side_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    for backend in backends() {
        let common =
            "--size 64 --rays 1024 --layers irradiance,error.irradiance,position --seams off";
        let with = |sky: &str| {
            let arguments = [common, "--backend", backend, "--sky", sky].join(" ");
            bake(
                &scene("trench.obj"),
                &arguments.split_whitespace().collect::<Vec<_>>(),
            )
        };
        let (_all, all) = with("1,1,1");
        let path = sky(folder.path(), 64, |d| [f32::from(u8::from(d[0] > 0.0)); 3]);
        let (_east, east) = with(path.to_str().expect("UTF-8"));
        let path = sky(folder.path(), 64, |d| [f32::from(u8::from(d[0] < 0.0)); 3]);
        let (_west, west) = with(path.to_str().expect("UTF-8"));
        let (mut outside, mut texels) = (0, 0);
        for texel in 0..all.size * all.size {
            if all.plane("coverage")[texel] == 0.0 {
                continue;
            }
            let value = |page: &Page| f64::from(page.plane("irradiance.R")[texel]);
            let error = |page: &Page| f64::from(page.plane("error.irradiance")[texel]);
            let difference = value(&east) + value(&west) - value(&all);
            let sigma = error(&east).hypot(error(&west)).hypot(error(&all));
            outside += u32::from(difference.abs() > 4.0 * sigma);
            texels += 1;
        }
        // Pooled errors of normal values exceed four once in 16,000; edges of shadow are not normal.
        assert!(outside * 200 < texels, "{backend}: {outside} of {texels}");
    }
}

#[test]
fn a_sun_of_one_texel_lights_without_fireflies() {
    let folder = tempfile::tempdir().expect("a folder");
    // The sun's texel: column 10, row 4 of 64 x 32.
    let (top, bottom) = (4.0 / 32.0 * PI, 5.0 / 32.0 * PI);
    let path = sky(folder.path(), 64, |d| {
        let column = ((d[0].atan2(d[2]) / TAU + 0.5) * 64.0) as u32;
        let row = (d[1].acos() / PI * 32.0) as u32;
        let sun = (column, row) == (10, 4);
        [if sun { 1e6 } else { 0.0 }; 3]
    });
    // (1/pi) times the integral of cos over the texel, y up.
    let exact = 1e6 / PI * (TAU / 64.0) * (bottom.sin().powi(2) - top.sin().powi(2)) / 2.0;
    let arguments = [
        "--size",
        "64",
        "--rays",
        "64",
        "--layers",
        "irradiance",
        "--sky",
    ];
    let arguments = [&arguments[..], &[path.to_str().expect("UTF-8")]].concat();
    let (_plane, plane) = bake(&scene("plane.obj"), &arguments);
    let (_trench, trench) = bake(&scene("trench.obj"), &arguments);
    for page in [&plane, &trench] {
        let largest = page
            .plane("irradiance.G")
            .iter()
            .copied()
            .fold(0.0, f32::max);
        let least = page
            .plane("irradiance.G")
            .iter()
            .copied()
            .fold(0.0, f32::min);
        assert!(
            f64::from(largest) < exact * 1.6 && least == 0.0,
            "{least} to {largest}"
        );
    }
    for (texel, &coverage) in plane.plane("coverage").iter().enumerate() {
        if coverage > 0.0 {
            let value = f64::from(plane.plane("irradiance.G")[texel]);
            assert!((value / exact - 1.0).abs() < 0.01, "{value} for {exact}");
        }
    }
}

#[test]
fn bytes_are_the_same_at_any_thread_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = sky(folder.path(), 64, day);
    let with = |more: &[&str]| {
        let mut arguments = "--size 64 --exponent 9 --layers irradiance,reflection --sky"
            .split(' ')
            .collect::<Vec<_>>();
        arguments.push(path.to_str().expect("UTF-8"));
        arguments.extend(more);
        let (folder, _) = bake(&scene("trench.obj"), &arguments);
        std::fs::read(folder.path().join("trench.0.exr")).expect("a page")
    };
    for effort in [["--rays", "33"], ["--target-error", "0.02"]] {
        let one = with(&[&effort[..], &["--threads", "1"]].concat());
        let seven = with(&[&effort[..], &["--threads", "7"]].concat());
        assert!(one == seven, "{effort:?}");
    }
}

#[test]
fn under_a_black_sky_every_reflection_is_0() {
    // Its charts have seams, and nothing by which their differences could be measured.
    let sky = ["--size", "64", "--rays", "16", "--sky", "0,0,0"];
    let (_folder, page) = bake(&scene("palm.gltf"), &sky);
    assert!(page.plane("ggx.R").iter().all(|&value| value == 0.0));
    assert!(page.plane("visibility").iter().any(|&value| value > 0.1));
}

#[test]
fn a_bad_sky_is_one_line_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let good = sky(folder.path(), 16, day).display().to_string();
    std::fs::write(
        at("cut.hdr"),
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\nabc",
    )
    .expect("a file");
    std::fs::write(at("sky.txt"), b"1 1 1").expect("a file");
    for (words, status, hint) in [
        (vec!["--sky", &at("absent.hdr")], 1, "absent.hdr"),
        (vec!["--sky", &at("cut.hdr")], 1, "cut.hdr"),
        (vec!["--sky", &at("sky.txt")], 1, "sky.txt"),
        (vec!["--sky", "1,1"], 2, "--sky"),
        (
            vec!["--sky", &good, "--rays", "1", "--denoise", "regression"],
            1,
            "--denoise",
        ),
    ] {
        let (scene, out) = (scene("plane.obj").display().to_string(), at("out"));
        let arguments = [&["bake", &scene, "-o", &out][..], &words].concat();
        let output = run(&arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{words:?}: {errors}");
        assert!(errors.contains(hint), "{words:?}: {errors}");
        assert!(
            status == 2 || errors.trim().lines().count() == 1,
            "{errors}"
        );
        let left = std::fs::read_dir(at("out")).map_or(0, |dir| dir.count());
        assert_eq!(left, 0, "{words:?}");
    }
}
