//! The microfacet model: furnaces, and a wall against a quadrature of its own.

use crate::support::{Page, bake, report, run, scene};
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// A scene of squares of one glTF material: each is its corner and two edges, whose cross product is its normal. The
/// first is called `floor`, the others `wall`.
fn squares(folder: &Path, material: Value, squares: &[[[f32; 3]; 3]]) -> PathBuf {
    let mut bytes: Vec<u8> = [0u16, 1, 2, 0, 2, 3]
        .iter()
        .flat_map(|i| i.to_le_bytes())
        .collect();
    let (mut accessors, mut meshes, mut nodes) = (
        vec![json!({ "bufferView": 0, "componentType": 5123, "count": 6, "type": "SCALAR" })],
        vec![],
        vec![],
    );
    for (number, [corner, a, b]) in squares.iter().enumerate() {
        let corners = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]]
            .map(|[s, t]| [0, 1, 2].map(|c: usize| corner[c] + a[c] * s + b[c] * t));
        let bound = |pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|c| corners.iter().map(|p| p[c]).reduce(pick).expect("a corner"))
        };
        accessors.push(
            json!({ "bufferView": 1, "byteOffset": 48 * number, "componentType": 5126, "count": 4,
            "type": "VEC3", "min": bound(f32::min), "max": bound(f32::max) }),
        );
        bytes.extend(corners.iter().flatten().flat_map(|c| c.to_le_bytes()));
        let name = if number == 0 { "floor" } else { "wall" };
        meshes.push(json!({ "name": name,
            "primitives": [{ "attributes": { "POSITION": number + 1 }, "indices": 0, "material": 0 }] }));
        nodes.push(json!({ "name": name, "mesh": number }));
    }
    std::fs::write(folder.join("a.bin"), &bytes).expect("a file");
    let json = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "uri": "a.bin", "byteLength": bytes.len() }],
        "bufferViews": [{ "buffer": 0, "byteLength": 12 },
                        { "buffer": 0, "byteOffset": 12, "byteLength": bytes.len() - 12 }],
        "accessors": accessors,
        "meshes": meshes,
        "scenes": [{ "nodes": (0..squares.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "materials": [material],
    });
    let path = folder.join("a.gltf");
    std::fs::write(&path, json.to_string()).expect("a file");
    path
}

fn pbr(base: [f64; 3], metallic: f64, roughness: f64) -> Value {
    json!({ "pbrMetallicRoughness": { "baseColorFactor": [base[0], base[1], base[2], 1],
        "metallicFactor": metallic, "roughnessFactor": roughness } })
}

/// The mean of a channel over the covered texels that lie at the height `y = 0`, and the largest distance from it.
fn floor(page: &Page, channel: &str) -> (f64, f64) {
    let values = page
        .plane(channel)
        .iter()
        .zip(page.plane("coverage"))
        .zip(page.plane("position.Y"));
    let values: Vec<f64> = values
        .filter(|((_, coverage), y)| **coverage > 0.0 && **y == 0.0)
        .map(|((value, _), _)| f64::from(*value))
        .collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (
        mean,
        values
            .iter()
            .fold(0.0, |worst, v| f64::max(worst, (v - mean).abs())),
    )
}

const FLOOR: [[f32; 3]; 3] = [[1., 0., 0.], [0., 0., 1.], [1., 0., 0.]];

#[test]
fn white_surfaces_return_all_that_they_receive_at_every_roughness_and_view() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    for (metallic, roughness, view) in [
        (1.0, 0.0, "normal"),
        (1.0, 0.5, "normal"),
        (1.0, 1.0, "normal"),
        (0.0, 0.3, "normal"),
        (0.5, 1.0, "normal"),
        (1.0, 0.7, "200,40,0.5"),
        (0.0, 0.3, "200,20,0.5"),
    ] {
        let path = squares(folder.path(), pbr([1.0; 3], metallic, roughness), &[FLOOR]);
        let words = [
            "--size", "8", "--model", "ggx", "--layers", "position", "--view", view,
        ];
        let (_folder, page) = bake(&path, &words);
        assert!(!page.names().contains(&"phong.R"), "{:?}", page.names());
        let (specular, _) = floor(&page, "specular");
        let (found, spread) = floor(&page, "ggx.G");
        let place = format!("metallic {metallic}, roughness {roughness}, view {view}");
        assert_eq!(specular, 1.0, "{place}");
        assert!(
            (found - 1.0).abs() < 1e-6 && spread < 1e-6,
            "{place}: {found} ± {spread}"
        );
    }
}

#[test]
fn gutters_are_no_brighter_than_what_their_page_shows() {
    let words = ["--size", "256", "--rays", "16", "--model", "ggx"];
    let more = ["--specular", "0.5,0.5,0.5", "--layers", "reflection"];
    let (_folder, page) = bake(&scene("courtyard.obj"), &[&words[..], &more].concat());
    let largest = |is_gutter: bool| {
        let values = page
            .plane("reflection.G")
            .iter()
            .zip(page.plane("coverage"));
        let values = values.filter(|(_, coverage)| (**coverage == 0.0) == is_gutter);
        values.fold(0.0f32, |most, (value, _)| most.max(*value))
    };
    // Seams give way to each other by a tenth at most.
    let [gutters, texels] = [true, false].map(largest);
    assert!(gutters <= texels + 0.1, "{gutters} beside {texels}");
}

/// J of the half space x > 0 by a midpoint rule over directions: D, G2 and F as the books print them.
fn half_space(f0: f64, roughness: f64, cos: f64) -> f64 {
    let alpha2 = roughness.powi(4);
    let v = [(1.0 - cos * cos).sqrt(), cos, 0.0];
    let lambda = |c: f64| 0.5 * ((1.0 + alpha2 * (1.0 / (c * c) - 1.0)).sqrt() - 1.0);
    let (rows, columns) = (700, 700);
    let (mut blocked, mut all, mut white) = (0.0, 0.0, 0.0);
    for row in 0..rows {
        for column in 0..columns {
            let theta = PI / 2.0 * (f64::from(row) + 0.5) / f64::from(rows);
            let phi = 2.0 * PI * (f64::from(column) + 0.5) / f64::from(columns);
            let l = [
                theta.sin() * phi.cos(),
                theta.cos(),
                theta.sin() * phi.sin(),
            ];
            let h = [0, 1, 2].map(|c| l[c] + v[c]);
            let length = h.iter().map(|c| c * c).sum::<f64>().sqrt();
            let (nh, vh) = (
                h[1] / length,
                (0..3).map(|c| v[c] * h[c]).sum::<f64>() / length,
            );
            let d = alpha2 / (PI * (nh * nh * (alpha2 - 1.0) + 1.0).powi(2));
            let g2 = 1.0 / (1.0 + lambda(cos) + lambda(l[1]));
            let step = theta.sin() * PI / 2.0 / f64::from(rows) * 2.0 * PI / f64::from(columns);
            let value = d * g2 / (4.0 * cos) * step;
            let f = f0 + (1.0 - f0) * (1.0 - vh).powi(5);
            white += value;
            all += value * f;
            if l[0] < 0.0 {
                blocked += value * f;
            }
        }
    }
    (all - blocked) * (1.0 + f0 * (1.0 / white - 1.0))
}

#[test]
fn lobe_beside_a_wall_is_the_integral_over_the_open_half_space() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    // A wall in the plane x = 0 without end, as the floor sees it; the eye is far away on the open side, so the lobe
    // leans to the wall.
    let wall = [[0., 0., -1e4], [0., 1e4, 0.], [0., 0., 2e4]];
    let base = [1.0, 0.77, 0.34];
    for (roughness, view, cos) in [
        (0.5, "normal", 1.0),
        (0.5, "5e5,5e5,0.5", 0.5_f64.sqrt()),
        (0.9, "8e5,6e5,0.5", 0.6),
    ] {
        let path = squares(folder.path(), pbr(base, 1.0, roughness), &[FLOOR, wall]);
        let words = [
            "--size",
            "16",
            "--rays",
            "256",
            "--model",
            "ggx",
            "--exclude",
            "wall",
            "--view",
            view,
        ];
        let words = [&words[..], &["--layers", "position,error.reflection"]].concat();
        let (_folder, page) = bake(&path, &words);
        for (channel, f0) in ["ggx.R", "ggx.G", "ggx.B"].into_iter().zip(base) {
            let exact = half_space(f0, roughness, cos);
            let (found, _) = floor(&page, channel);
            let (std_err, _) = floor(&page, "error.reflection");
            // The wall's own albedo sends nothing: no bounces were asked for.
            assert!(
                (found - exact).abs() < 3.0 * std_err + 1e-3,
                "{roughness} {view} {channel}: {found}, not {exact} ± {std_err}"
            );
        }
    }
}

/// The open share of the lobe, without colour, seen along the normal: a midpoint rule over directions (x, y, z), y up.
fn open_share(roughness: f64, open: impl Fn([f64; 3]) -> bool) -> f64 {
    let alpha2 = roughness.powi(4);
    let (rows, columns) = (500, 1000);
    let (mut seen, mut all) = (0.0, 0.0);
    for row in 0..rows {
        let theta = PI / 2.0 * (f64::from(row) + 0.5) / f64::from(rows);
        let (sin, cos) = theta.sin_cos();
        // H is half-way to the normal.
        let nh = (0.5 * theta).cos();
        let d = alpha2 / (PI * (nh * nh * (alpha2 - 1.0) + 1.0).powi(2));
        let lambda = 0.5 * ((1.0 + alpha2 * (1.0 / (cos * cos) - 1.0)).sqrt() - 1.0);
        let value = d / (1.0 + lambda) * sin;
        for column in 0..columns {
            let (s, c) = (2.0 * PI * (f64::from(column) + 0.5) / f64::from(columns)).sin_cos();
            all += value;
            if open([sin * c, cos, sin * s]) {
                seen += value;
            }
        }
    }
    seen / all
}

/// Root mean square of what texels are off by and of what they state; `exact` by the place along x.
fn off_and_stated(page: &Page, exact: impl Fn(f64) -> f64) -> [f64; 2] {
    let plane = |name: &str| page.plane(name).iter().map(|&v| f64::from(v));
    let on_floor = plane("coverage").zip(plane("position.Y"));
    let texels = plane("specular")
        .zip(plane("error.specular"))
        .zip(plane("position.X"))
        .zip(on_floor)
        .filter(|(_, (coverage, y))| *coverage > 0.0 && *y == 0.0)
        .map(|(texel, _)| texel);
    let (mut sums, mut count) = ([0.0; 2], 0.0);
    for ((found, stated), x) in texels {
        sums[0] += (found - exact(x)).powi(2);
        sums[1] += stated * stated;
        count += 1.0;
    }
    assert!(count > 1000.0, "{count} texels");
    sums.map(|sum: f64| (sum / count).sqrt())
}

const PLAIN: [&str; 14] = [
    "--size",
    "64",
    "--rays",
    "64",
    "--model",
    "ggx",
    "--exclude",
    "wall",
    "--denoise",
    "off",
    "--seams",
    "off",
    "--footprint",
    "centre",
];

#[test]
fn hemisphere_rays_lower_the_error_of_lobes_and_what_is_stated_stays_true() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let wall = [[0., 0., -1e4], [0., 1e4, 0.], [0., 0., 2e4]];
    // At 0.4 and 1 the points of the lobe alone follow the edge of the wall, and have half of the error that they
    // have otherwise (docs/microfacets.md).
    for (roughness, most) in [(0.4, 2.1), (0.6, 0.95), (0.8, 0.95), (1.0, 1.3)] {
        let path = squares(folder.path(), pbr([1.0; 3], 1.0, roughness), &[FLOOR, wall]);
        let exact = open_share(roughness, |l| l[0] > 0.0);
        let rms = |flags: &[&str]| {
            let (_folder, page) = bake(&path, &[&PLAIN[..], flags].concat());
            off_and_stated(&page, |_| exact)
        };
        let [both, stated] = rms(&["--layers", "position,error.specular"]);
        // Without a layer that needs the hemisphere there are no rays over it.
        let [alone, _] = rms(&["--only", "specular,position,error.specular"]);
        println!("roughness {roughness}: {both:.5} for {alone:.5}, stated {stated:.5}");
        assert!(both < most * alone, "{roughness}: {both} for {alone}");
        // Four thousand texels whose errors come from two replicates: within 3 % but for one case in twenty.
        assert!(
            (both / stated - 1.0).abs() < 0.1,
            "{roughness}: {both} where {stated} is stated"
        );
    }
}

#[test]
fn lobes_below_a_lid_are_right_where_hemisphere_rays_are_guided() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    // A lid at height 0.2 that ends over the far edge of the floor, at x = 2.
    let lid = [[-100., 0.2, -100.], [102., 0., 0.], [0., 0., 200.]];
    let roughness = 0.8;
    let path = squares(folder.path(), pbr([1.0; 3], 1.0, roughness), &[FLOOR, lid]);
    let layers = ["--layers", "position,error.specular"];
    let (_folder, page) = bake(&path, &[&PLAIN[..], &layers].concat());
    let guided = page
        .plane("rays")
        .iter()
        .filter(|&&rays| rays > 128.0)
        .count();
    assert!(guided > 300, "{guided} texels were baked twice for a guide");
    let known: Vec<f64> = (0..64)
        .map(|k| {
            let slope = 0.2 / (1.0 - (f64::from(k) + 0.5) / 64.0);
            open_share(roughness, |l| l[0] > 0.0 && l[1] < slope * l[0])
        })
        .collect();
    let exact = |x: f64| {
        let place = (64.0 * (x - 1.0) - 0.5).clamp(0.0, 63.0);
        let at = (place as usize).min(62);
        known[at] + (place - at as f64) * (known[at + 1] - known[at])
    };
    let [off, stated] = off_and_stated(&page, exact);
    assert!(
        (off / stated - 1.0).abs() < 0.15,
        "{off} where {stated} is stated"
    );
    // The mean has no noise to hide a bias in.
    let mut sums = [0.0; 2];
    for (at, &coverage) in page.plane("coverage").iter().enumerate() {
        if coverage > 0.0 && page.plane("position.Y")[at] == 0.0 {
            sums[0] += f64::from(page.plane("specular")[at])
                - exact(f64::from(page.plane("position.X")[at]));
            sums[1] += 1.0;
        }
    }
    let mean = sums[0] / sums[1];
    assert!(
        mean.abs() < 4.0 * stated / sums[1].sqrt() + 3e-4,
        "{mean} in the mean"
    );
}

#[test]
fn layers_of_one_model_are_refused_under_the_other() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = squares(folder.path(), pbr([1.0; 3], 1.0, 0.5), &[FLOOR]);
    let out = folder.path().join("out");
    for (model, layer) in [("phong", "ggx"), ("ggx", "difference.phong")] {
        let words = [
            "bake",
            path.to_str().expect("UTF-8"),
            "-o",
            out.to_str().expect("UTF-8"),
        ];
        let output = run(words
            .into_iter()
            .chain(["--model", model, "--layers", layer]));
        assert_eq!(output.status.code(), Some(1));
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains("--model"), "{text}");
    }
}

#[test]
fn a_scene_bakes_and_renders_by_the_model_that_its_file_is_made_for() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let gltf = squares(folder.path(), pbr([0.5; 3], 1.0, 0.5), &[FLOOR]);
    let obj = scene("plane.obj");
    let cases: [(&Path, &[&str], &str); 8] = [
        (&gltf, &[], "ggx"),
        (&gltf, &["--layers", "base"], "ggx"),
        (&gltf, &["--model", "phong"], "phong"),
        (&gltf, &["--only", "phong"], "phong"),
        (&gltf, &["--layers", "difference.phong"], "phong"),
        (&gltf, &["--exponent", "20"], "phong"),
        (&obj, &[], "phong"),
        (&obj, &["--only", "ggx"], "ggx"),
    ];
    for (path, words, model) in cases {
        let options: Vec<&str> = ["--size", "8"]
            .into_iter()
            .chain(words.iter().copied())
            .collect();
        let (out, page) = bake(path, &options);
        let other = if model == "ggx" { "phong.R" } else { "ggx.R" };
        let names = page.names();
        assert!(
            names.contains(&&*format!("{model}.R")),
            "{words:?}: {names:?}"
        );
        assert!(!names.contains(&other), "{words:?}: {names:?}");
        assert_eq!(report(out.path())["options"]["model"], model, "{words:?}");
        // The picture finds the layer that the bake has, without being told.
        let picture = out.path().join("a.exr");
        let output = run([
            "render".as_ref(),
            path.as_os_str(),
            "--bake".as_ref(),
            out.path().as_os_str(),
            "--size".as_ref(),
            "8x8".as_ref(),
            "-o".as_ref(),
            picture.as_os_str(),
        ]);
        assert!(
            output.status.success(),
            "{words:?}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
}

#[test]
fn a_target_is_met_and_a_relative_one_where_it_is_looser() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let wall = [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    let path = squares(folder.path(), pbr([0.8; 3], 1.0, 0.6), &[FLOOR, wall]);
    let target = |relative: &[&str]| {
        let words = [
            "--size=32",
            "--model=ggx",
            "--only=specular,error.specular,rays,position",
            "--target-error=0.004",
            "--max-rays=4096",
            "--view=200,60,0.5",
        ];
        let (_folder, page) = bake(&path, &[&words[..], relative].concat());
        page
    };
    let tight = target(&[]);
    let loose = target(&["--target-relative", "0.06"]);
    let texels = |page: &Page| -> Vec<[f64; 3]> {
        let planes = ["specular", "error.specular", "rays"].map(|name| page.plane(name).to_vec());
        let covered = page.plane("coverage").to_vec();
        (0..covered.len())
            .filter(|&i| covered[i] > 0.0 && planes[2][i] > 0.0)
            .map(|i| [0, 1, 2].map(|k: usize| f64::from(planes[k][i])))
            .collect()
    };
    for (page, relative) in [(&tight, 0.0), (&loose, 0.06)] {
        let all = texels(page);
        assert!(all.len() > 40, "{}", all.len());
        let square = |t: &[f64; 3]| (t[1] / f64::max(0.004, relative * t[0])).powi(2);
        let rms = (all.iter().map(square).sum::<f64>() / all.len() as f64).sqrt();
        // Of what it may be; few texels tell what it will be.
        assert!((0.4..1.2).contains(&rms), "{rms}");
    }
    let rays = |page: &Page| texels(page).iter().map(|t| t[2]).sum::<f64>();
    assert!(
        rays(&loose) < 0.5 * rays(&tight),
        "{} {}",
        rays(&loose),
        rays(&tight)
    );
}
