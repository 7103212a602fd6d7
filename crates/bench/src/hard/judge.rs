//! Bakes the cases and judges what came out.

use super::cases::{Bound, Case, Expected, cases};
use super::setup::{SIZE, Setup};
use super::{Error, input};
use crate::Subject;
use bake::{BakedPage, Choice, Denoise, Effort, Options, Pattern, Plan, PointSet, View};
use layers::Layer;
use rays::{BackendKind, Layout, Overrides};
use serde::Serialize;
use std::sync::Arc;

/// Rays a texel; the mean over the page has 256 times as many.
const RAYS: u32 = 1024;

/// One term of one case on one backend.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The case.
    pub case: String,
    /// What is compared: a term's layer, or what is counted.
    pub term: String,
    /// `embree`, `obvhs`, or `load` for what the loader decides.
    pub backend: String,
    /// The exact value.
    pub expected: f64,
    /// The mean over the page; for an exact case the texel farthest off.
    pub baked: f64,
    /// Absolute difference.
    pub off: f64,
    /// The largest difference that passes.
    pub bound: f64,
    /// The verdict.
    pub status: Status,
    /// What the bound is made of.
    pub why: String,
    /// Hash of the bits of every texel, for comparing libraries; 0 where nothing is baked.
    pub bits: u64,
}

/// The verdict on a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Within its bound.
    Holds,
    /// Off by more than sampling explains, within the bound that single precision is given and the row names.
    SingleLimit,
    /// Beyond its bound.
    Fails,
}

/// Every case on every backend of this build, in the current pool of threads.
///
/// # Errors
/// See [`Error`].
pub fn run() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (kind, backend) in backends() {
        for case in cases() {
            let page = bake(&case.setup, case.name, kind)?;
            rows.extend(
                case.expected
                    .iter()
                    .map(|e| judge(&case, e, &page, backend)),
            );
        }
        rows.extend(equal_bits(kind, backend)?);
    }
    rows.extend(input::rows()?);
    Ok(rows)
}

fn backends() -> Vec<(BackendKind, &'static str)> {
    let mut all = vec![(BackendKind::Obvhs(Layout::default()), "obvhs")];
    if embree::header_version().is_some() {
        all.insert(0, (BackendKind::Embree, "embree"));
    }
    all
}

fn bake(setup: &Setup, case: &str, kind: BackendKind) -> Result<BakedPage, Error> {
    let (scene, atlas) = setup.scene();
    let mut layers = vec![Layer::Visibility, Layer::Diffuse];
    layers.extend([Layer::ErrorVisibility, Layer::Error]);
    if setup.exponent.is_some() {
        layers.extend([Layer::Specular, Layer::ErrorSpecular]);
    }
    let options = Options {
        effort: Effort::Rays(RAYS),
        pattern: Pattern::Independent,
        points: PointSet::default(),
        denoise: Denoise::Off,
        seed: 0,
        sky: bake::Sky::Uniform([1.0; 3]),
        draw_sky: true,
        view: setup
            .view
            .map_or(View::Normal, |v| View::Eye(setup.centre() + v * 1e6)),
        max_distance: None,
        layers,
        overrides: Overrides {
            exponent: setup.exponent,
            ..Overrides::default()
        },
        switched_off: vec![Choice::Open],
    };
    let fail = |source| Error::Bake {
        case: case.into(),
        source,
    };
    let (plan, world) = Plan::of(&Arc::new(scene), &options).map_err(fail)?;
    let backend = rays::build(kind, &world, 0).map_err(fail)?;
    let subject = Subject {
        world: &world,
        plan: &plan,
        atlas: &atlas,
    };
    Ok(subject.bake(backend.as_ref(), &options))
}

fn plane(page: &BakedPage, layer: Layer) -> &[f32] {
    let plane = page.planes.iter().find(|plane| plane.layer == layer);
    &plane.expect("every judged layer is asked for").values
}

fn judge(case: &Case, expected: &Expected, page: &BakedPage, backend: &str) -> Row {
    let values = plane(page, expected.term);
    let errors = plane(page, error_layer(expected.term));
    let texels = values.len() as f64;
    let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / texels;
    let square: f64 = errors.iter().map(|&e| f64::from(e).powi(2)).sum();
    // No weight of a sample exceeds 2, and none of N says less than 3/N with 95 % certainty; values are f32.
    let resolved = 6.0 / (texels * f64::from(RAYS)) + f64::from(f32::EPSILON);
    let sampling = 4.0 * square.sqrt() / texels + resolved;
    let (value, baked, bound, limit) = match expected.bound {
        Bound::EveryTexel => (expected.value, farthest(values, expected.value), 0.0, None),
        Bound::Sampling { shape } => (expected.value, mean, sampling + shape, None),
        Bound::Single { limit } => (expected.value, mean, sampling, Some(limit)),
        Bound::Columns { exact, limit } => {
            let (value, baked, own) = worst_column(values, errors, exact);
            (value, baked, own, Some(limit + own))
        }
    };
    let off = (baked - value).abs();
    let (status, bound) = match limit {
        _ if off <= bound => (Status::Holds, bound),
        Some(limit) if off <= limit => (Status::SingleLimit, limit),
        Some(limit) => (Status::Fails, limit),
        None => (Status::Fails, bound),
    };
    Row {
        case: case.name.into(),
        term: expected.term.name().into(),
        backend: backend.into(),
        expected: value,
        baked,
        off,
        bound,
        status,
        why: expected.why.into(),
        bits: hash(values),
    }
}

fn error_layer(term: Layer) -> Layer {
    match term {
        Layer::Visibility => Layer::ErrorVisibility,
        Layer::Specular => Layer::ErrorSpecular,
        _ => Layer::Error,
    }
}

/// The value farthest from the expected one.
fn farthest(values: &[f32], expected: f64) -> f64 {
    let distance = |v: f64| (v - expected).abs();
    let values = values.iter().map(|&v| f64::from(v));
    values.fold(
        expected,
        |far, v| {
            if distance(v) > distance(far) { v } else { far }
        },
    )
}

/// The column of texels farthest beyond its own sampling bound: its exact value, its mean and that bound.
fn worst_column(values: &[f32], errors: &[f32], exact: fn(f64) -> f64) -> (f64, f64, f64) {
    let size = f64::from(SIZE);
    let column = |x: u32| {
        let of = |plane: &[f32], f: fn(f64) -> f64| -> f64 {
            let own = plane.iter().skip(x as usize).step_by(SIZE as usize);
            own.map(|&v| f(f64::from(v))).sum()
        };
        let own = 4.0 * of(errors, |e| e * e).sqrt() / size + 6.0 / (size * f64::from(RAYS));
        (exact(f64::from(x) / size), of(values, |v| v) / size, own)
    };
    let beyond = |t: &(f64, f64, f64)| (t.1 - t.0).abs() - t.2;
    (1..SIZE).map(column).fold(column(0), |worst, next| {
        if beyond(&next) > beyond(&worst) {
            next
        } else {
            worst
        }
    })
}

/// FNV-1a over the bits of the values.
fn hash(values: &[f32]) -> u64 {
    values
        .iter()
        .flat_map(|v| v.to_bits().to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
}

/// Pairs of scenes that must bake to the same bits.
fn equal_bits(kind: BackendKind, backend: &str) -> Result<Vec<Row>, Error> {
    let wall = || Setup::at(1.0, 0.25).wall(1.0, 16.0).turned();
    let plates = |count: usize| {
        (0..count).fold(Setup::at(0.0, 0.25), |setup, _| {
            setup.plate([-1.0, 1.0], [-1.0, 1.0], 1.0)
        })
    };
    let scaled = |power: i32| wall().map(|p| p.as_vec3().as_dvec3() * 2f64.powi(power));
    let pairs = [
        ("turned wall, scaled by 2^-10", wall(), scaled(-10)),
        ("turned wall, scaled by 2^20", wall(), scaled(20)),
        ("two coincident plates beside one", plates(1), plates(2)),
    ];
    let mut rows = Vec::new();
    for (case, a, b) in pairs {
        let (a, b) = (bake(&a, case, kind)?, bake(&b, case, kind)?);
        for term in [Layer::Visibility, Layer::Diffuse] {
            let (a, b) = (plane(&a, term), plane(&b, term));
            let differ = a.iter().zip(b).filter(|(a, b)| a != b).count();
            let name = format!("{} texels of {SIZE}² that differ", term.name());
            let mut row = count(case, &name, backend, 0, differ, "bit for bit");
            row.bits = hash(b);
            rows.push(row);
        }
    }
    Ok(rows)
}

/// A row about a number of things, which is exact or wrong.
pub(super) fn count(
    case: &str,
    term: &str,
    backend: &str,
    expected: usize,
    found: usize,
    why: &str,
) -> Row {
    Row {
        case: case.into(),
        term: term.into(),
        backend: backend.into(),
        expected: expected as f64,
        baked: found as f64,
        off: expected.abs_diff(found) as f64,
        bound: 0.0,
        status: if expected == found {
            Status::Holds
        } else {
            Status::Fails
        },
        why: why.into(),
        bits: 0,
    }
}
