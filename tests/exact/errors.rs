//! What ambake says of its own errors, held against exact values.

use super::footprint::{Point, averages};
use super::mesh::Mesh;
use super::{View, error_layer, exact, pick};
use crate::support::{bake, bake_kept, report, run, scene};
use glam::DVec3;

/// Scenes with their page edges: every texel of their receivers has a known value.
const SCENES: [(&str, usize); 6] = [
    ("wall_finite.obj", 16),
    ("groove_60.obj", 16),
    ("corner.obj", 16),
    ("rectangle_overhead.obj", 32),
    ("triangle_overhead.obj", 32),
    ("trench.obj", 32),
];

/// The quantile of Student's t that 95 % of errors stay below, with 25 degrees of freedom: twenty-five texels pool the
/// spread of two replicates each.
const QUANTILE: f64 = 2.060;

/// (error, standard error) of every texel and term of a bake, and rays per texel.
fn errors(terms: &[&str], arguments: &[&str], seeds: std::ops::Range<u32>) -> (Vec<[f64; 2]>, f64) {
    let (mut found, mut rays) = (Vec::new(), 0.0);
    for (name, size) in SCENES {
        let receivers = Mesh::read(&scene(name));
        let texels = averages(&receivers, size, &|point| {
            exact(&receivers, point, View::Normal, 5)
        });
        for seed in seeds.clone() {
            let (edge, seed) = (size.to_string(), seed.to_string());
            let only = "diffuse,visibility,error,error.visibility,rays";
            let mut all = vec!["--size", &edge, "--seed", &seed, "--only", only];
            all.extend(["--seams", "off"]);
            all.extend(arguments);
            let (_folder, page) = bake_kept(&scene(name), &all);
            for (&(x, y), texel) in &texels {
                let at = y * size + x;
                for term in terms {
                    let error = f64::from(page.plane(term)[at]) - pick(&texel.mean, term);
                    found.push([error, f64::from(page.plane(error_layer(term))[at])]);
                }
                rays += f64::from(page.plane("rays")[at]) / texels.len() as f64;
            }
        }
    }
    let bakes = (SCENES.len() * seeds.len()) as f64;
    (found, rays / bakes)
}

fn rmse(errors: &[[f64; 2]]) -> f64 {
    (errors.iter().map(|e| e[0] * e[0]).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn ninety_five_percent_intervals_cover_as_many_errors() {
    for rays in ["64", "256"] {
        let terms = ["diffuse", "visibility"];
        let (errors, _) = errors(&terms, &["--rays", rays], 0..3);
        let inside = errors
            .iter()
            .filter(|[error, standard]| error.abs() <= QUANTILE * standard)
            .count();
        let share = inside as f64 / errors.len() as f64;
        let stated = (errors.iter().map(|e| e[1] * e[1]).sum::<f64>() / errors.len() as f64).sqrt();
        let ratio = stated / rmse(&errors);
        println!(
            "{rays} rays: {share:.4} of {} covered, stated / true RMSE {ratio:.3}",
            errors.len()
        );
        assert!((0.93..=0.97).contains(&share), "{rays} rays: {share}");
        assert!((0.95..=1.05).contains(&ratio), "{rays} rays: {ratio}");
    }
}

#[test]
fn asked_errors_are_met_without_waste() {
    for target in ["0.02", "0.01", "0.005", "0.002"] {
        let (errors, rays) = errors(&["diffuse"], &["--target-error", target], 0..1);
        let ratio = rmse(&errors) / target.parse::<f64>().expect("a number");
        let bias = errors.iter().map(|e| e[0]).sum::<f64>() / errors.len() as f64;
        println!(
            "asked {target}: RMSE {:.5}, {ratio:.2} of it, mean {bias:+.6}, {rays:.0} rays a texel",
            rmse(&errors)
        );
        assert!(
            (0.7..=1.1).contains(&ratio),
            "asked {target}: {ratio} of it"
        );
        assert!(
            bias.abs() < 0.1 * rmse(&errors),
            "asked {target}: mean {bias}"
        );
    }
}

#[test]
fn a_share_of_the_value_is_enough_where_it_is_more() {
    let asked = |more: &[&str]| {
        // Seams move values after errors are counted.
        let base = ["--size", "32", "--seams", "off", "--target-error", "0.005"];
        let only = ["--only", "diffuse,error,rays"];
        bake_kept(&scene("trench.obj"), &[&base[..], &only, more].concat())
    };
    let (_folder, strict) = asked(&[]);
    let (folder, eased) = asked(&["--target-relative", "0.04"]);
    let (mut fewer, mut met, mut covered) = (0, 0, 0);
    for i in (0..32 * 32).filter(|&i| eased.plane("rays")[i] > 0.0) {
        let [value, error] = ["diffuse", "error"].map(|name| eased.plane(name)[i]);
        covered += 1;
        // Errors are stated from 3 x 3 texels and stop by 5 x 5: half as much again covers the difference.
        met += usize::from(error <= 1.5 * f32::max(0.005, 0.04 * value));
        fewer += usize::from(eased.plane("rays")[i] < strict.plane("rays")[i]);
    }
    assert!(covered > 100 && fewer > covered / 2, "{fewer} of {covered}");
    assert!(met * 100 > covered * 95, "{met} of {covered}");
    let stated = report(folder.path())["pages"][0]["worst_relative"].as_f64();
    let worst = (0..32 * 32)
        .filter(|&i| eased.plane("diffuse")[i] >= 1.0 / 255.0)
        .map(|i| f64::from(eased.plane("error")[i] / eased.plane("diffuse")[i]))
        .filter(|share| share.is_finite())
        .fold(0.0, f64::max);
    assert!(
        (stated.unwrap_or(0.0) / worst - 1.0).abs() < 1e-3,
        "{stated:?} is not {worst}"
    );
}

#[test]
fn a_texel_sampled_at_its_centre_has_the_value_of_that_point() {
    let receivers = Mesh::read(&scene("wall_finite.obj"));
    let only = "diffuse,error,position,normal";
    let arguments = ["--size", "16", "--rays", "4096", "--footprint", "centre"];
    let (_folder, page) = bake_kept(
        &scene("wall_finite.obj"),
        &[&arguments[..], &["--only", only]].concat(),
    );
    let texels = averages(&receivers, 16, &|point| {
        exact(&receivers, point, View::Normal, 5)
    });
    let mut apart = 0.0f64;
    for (&(x, y), texel) in &texels {
        let at = y * 16 + x;
        let vector = |name: &str| {
            DVec3::from(
                ["X", "Y", "Z"].map(|axis| f64::from(page.plane(&format!("{name}.{axis}"))[at])),
            )
        };
        let (position, normal) = (vector("position"), vector("normal"));
        let point = Point {
            position,
            normal,
            geometric: normal,
        };
        let value = exact(&receivers, &point, View::Normal, 5);
        let error = f64::from(page.plane("diffuse")[at]) - pick(&value, "diffuse");
        let allowed = 5.0 * f64::from(page.plane("error")[at]) + 1e-3;
        assert!(
            error.abs() < allowed,
            "texel {x}, {y}: {error:+} beyond {allowed}"
        );
        apart = apart.max((pick(&value, "diffuse") - pick(&texel.mean, "diffuse")).abs());
    }
    assert!(apart > 0.002, "centres and means are only {apart} apart");
}

#[test]
fn halves_of_the_rays_differ_by_what_the_error_says() {
    let only = "diffuse,visibility,error,error.visibility,half.diffuse,half.visibility";
    let arguments = [
        "--size", "64", "--rays", "30", "--seams", "off", "--only", only,
    ];
    let (_folder, page) = bake_kept(&scene("trench.obj"), &arguments);
    for (half, error) in [
        ("half.diffuse", "error"),
        ("half.visibility", "error.visibility"),
    ] {
        let square = |name: &str| {
            page.plane(name)
                .iter()
                .map(|v| f64::from(v * v))
                .sum::<f64>()
        };
        let ratio = square(half) / square(error);
        // A variance from one half difference each of 3,600 texels: 2.4 % of it, and the pooled error has a floor.
        assert!((0.9..1.1).contains(&ratio), "{half}: {ratio} of {error}");
    }
}

#[test]
fn the_denoiser_lowers_errors_and_states_those_that_are_left() {
    let terms = ["diffuse", "visibility"];
    let (plain, _) = errors(&terms, &["--rays", "64"], 0..2);
    let (denoised, _) = errors(&terms, &["--rays", "64", "--denoise", "regression"], 0..2);
    let inside = denoised
        .iter()
        .filter(|[error, standard]| error.abs() <= QUANTILE * standard)
        .count();
    let share = inside as f64 / denoised.len() as f64;
    let stated = rmse(&denoised.iter().map(|e| [e[1], 0.0]).collect::<Vec<_>>());
    let ratio = stated / rmse(&denoised);
    println!(
        "RMSE {:.5} denoised to {:.5}, stated / true {ratio:.3}, {share:.4} covered",
        rmse(&plain),
        rmse(&denoised)
    );
    assert!(rmse(&denoised) < 0.5 * rmse(&plain));
    // Pages of so few texels tell no bias from noise to less than a fifth of the variance: the statement errs to the
    // safe side.
    assert!((0.9..=1.3).contains(&ratio), "stated / true RMSE {ratio}");
    assert!(share > 0.92, "{share} covered");
}

#[test]
fn denoised_pages_hold_what_was_asked_and_compose_from_denoised_terms() {
    let arguments = ["--size", "256", "--rays", "8", "--denoise", "regression"];
    let (_folder, page) = bake(
        &scene("courtyard.obj"),
        &[&arguments[..], &["--layers", "albedo"]].concat(),
    );
    assert!(!page.names().contains(&"reflectance") && !page.names().contains(&"position.X"));
    for i in (0..256 * 256).filter(|&i| page.plane("coverage")[i] > 0.0) {
        let expected = page.plane("albedo.R")[i] * page.plane("diffuse")[i];
        let found = page.plane("lambert.R")[i];
        assert!(
            (found - expected).abs() <= 1e-6,
            "texel {i}: {found}, not {expected}"
        );
    }
    let file = scene("courtyard.obj");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let all = [
        "bake",
        &file.to_string_lossy(),
        "-o",
        &folder.path().to_string_lossy(),
    ]
    .into_iter()
    .chain(arguments)
    .chain(["--rays", "1"])
    .map(String::from)
    .collect::<Vec<_>>();
    let output = run(&all);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("compares two halves of the rays"),
        "{message}"
    );
}

#[test]
fn a_page_states_its_rmse_a_bound_and_its_worst_texel() {
    let (folder, page) = bake_kept(
        &scene("trench.obj"),
        &["--size", "32", "--rays", "64", "--seams", "off"],
    );
    let stated = &report(folder.path())["pages"][0];
    let number = |key: &str| stated[key].as_f64().unwrap_or(f64::NAN);
    let covered: Vec<usize> = (0..32 * 32)
        .filter(|&i| page.plane("coverage")[i] > 0.0)
        .collect();
    let squares: f64 = covered
        .iter()
        .map(|&i| f64::from(page.plane("error")[i]).powi(2))
        .sum();
    let rmse = (squares / covered.len() as f64).sqrt();
    assert!(
        (number("rmse") / rmse - 1.0).abs() < 1e-6,
        "{} is not {rmse}",
        number("rmse")
    );
    assert!(number("rmse_bound") > number("rmse") && number("rmse_bound") < 2.0 * number("rmse"));
    let [x, y] =
        [0, 1].map(|k: usize| stated["worst_texel"][k].as_u64().unwrap_or(u64::MAX) as usize);
    assert!((f64::from(page.plane("error")[y * 32 + x]) - number("max_error")).abs() < 1e-7);
}
