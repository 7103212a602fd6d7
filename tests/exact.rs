//! Baked authored scenes against the exact value of every texel, averaged over its footprint.
//!
//! Each comparison is judged three ways: the root mean square error is at most 0.002 at 4,096 rays a texel; the mean
//! signed error is within 3 of its own standard errors (no bias); and errors have the size that the stored standard
//! errors promise, for single texels (Student's t) and for all together.

mod footprint;
mod glb;
mod mesh;
mod polygon;
mod scenes;
mod statistics;

use crate::support::bake;
use footprint::{Point, averages};
use glam::DVec3;
use mesh::Mesh;
use polygon::{Setting, Shares, open_shares, shares};
use statistics::{Sample, judge};
use std::path::Path;

const RAYS: f64 = 4096.0;
const EYE: DVec3 = DVec3::new(1.5, 3.0, 2.5);

/// How the specular lobe is viewed.
#[derive(Clone, Copy, PartialEq)]
enum View {
    Normal,
    Eye,
}

/// The exact shares of `point` in `mesh`.
fn exact(mesh: &Mesh, point: &Point, view: View, exponent: i32) -> Shares {
    let at = setting(point, view, exponent);
    let blocked = mesh
        .blockers(point.position)
        .iter()
        .fold(Shares::default(), |sum, one| sum + shares(one, &at));
    open_shares(&at) + blocked * -1.0
}

fn setting(point: &Point, view: View, exponent: i32) -> Setting {
    let eye = match view {
        View::Normal => point.normal,
        View::Eye => (EYE - point.position).normalize(),
    };
    let mirror = 2.0 * point.normal.dot(eye) * point.normal - eye;
    Setting {
        normal: point.normal,
        geometric: point.geometric,
        mirror,
        exponent,
    }
}

/// Bakes `file` at 4,096 rays for n = 5 and 50, seen along the normal and from an eye point, and holds every fully
/// or partly covered texel of its receivers against `truth`.
fn agree_with(
    file: &Path,
    receivers: &Mesh,
    size: usize,
    backend: &str,
    truth: &(dyn Fn(&Point, View, i32) -> Shares + Sync),
) {
    let name = file.file_name().expect("a name").to_string_lossy();
    let mut failures = Vec::new();
    for view in [View::Normal, View::Eye] {
        for exponent in [5, 50] {
            let (size_text, exponent_text) = (size.to_string(), exponent.to_string());
            let eye = format!("{},{},{}", EYE.x, EYE.y, EYE.z);
            let (eye, terms) = match view {
                View::Normal => ("normal", vec!["diffuse", "visibility", "specular"]),
                View::Eye => (eye.as_str(), vec!["specular"]),
            };
            let only = match view {
                View::Normal => {
                    "coverage,diffuse,visibility,specular,error,error.visibility,error.specular"
                }
                View::Eye => "coverage,specular,error.specular",
            };
            #[rustfmt::skip]
            let arguments = [
                "--size", &size_text, "--rays", "4096", "--exponent", &exponent_text, "--specular", "0.5,0.5,0.5",
                "--view", eye, "--only", only, "--backend", backend,
            ];
            let (_folder, page) = bake(file, &arguments);
            let texels = averages(receivers, size, &|point| truth(point, view, exponent));
            assert!(
                texels.len() >= 32,
                "{name}: only {} texels receive",
                texels.len()
            );
            for (&(x, y), texel) in &texels {
                let coverage = f64::from(page.plane("coverage")[y * size + x]);
                // Page coordinates are f32: each of four edges may lie half an ulp off.
                assert!(
                    (coverage - texel.coverage).abs() < size as f64 * 4.0 * 6e-8,
                    "{name}: coverage {coverage} for {}",
                    texel.coverage
                );
            }
            for term in terms {
                let error = if term == "diffuse" {
                    "error".into()
                } else {
                    format!("error.{term}")
                };
                let samples: Vec<Sample> = texels
                    .iter()
                    .map(|(&(x, y), texel)| Sample {
                        error: f64::from(page.plane(term)[y * size + x]) - pick(&texel.mean, term),
                        standard_error: f64::from(page.plane(&error)[y * size + x]),
                    })
                    .collect();
                let verdict = judge(&samples, RAYS);
                let view = if view == View::Normal {
                    "normal"
                } else {
                    "eye"
                };
                let row = format!(
                    "{name:22} {backend:7} {view:6} n {exponent:2} {term:10} texels {:4} rmse {:.6} mean {:+.7} z {:+.2} max {:.6} worst t {:.3} ratio {:.2} +- {:.2}",
                    verdict.texels,
                    verdict.rmse,
                    verdict.mean,
                    verdict.mean_z,
                    verdict.max,
                    verdict.worst,
                    verdict.ratio,
                    verdict.ratio_deviation
                );
                println!("{row}");
                let honest = (verdict.ratio - 1.0).abs() <= 4.0 * verdict.ratio_deviation
                    || verdict.rmse < 1.0 / RAYS;
                let unbiased = verdict.mean_z.abs() <= 3.0 || verdict.mean.abs() < 1e-6;
                if verdict.rmse > 0.002 || !unbiased || verdict.worst < 1e-3 || !honest {
                    failures.push(row);
                }
            }
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

fn pick(shares: &Shares, term: &str) -> f64 {
    match term {
        "visibility" => shares.visibility,
        "diffuse" => shares.diffuse,
        _ => shares.specular,
    }
}
