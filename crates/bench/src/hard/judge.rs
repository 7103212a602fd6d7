//! Holds what was baked against the exact value.

use super::bake::{RAYS, plane};
use super::case::{Bound, Case, Expected};
use super::row::{Row, Status, hash};
use super::setup::SIZE;
use bake::BakedPage;
use layers::Layer;

/// The verdict on one term of a case that `backend` baked.
pub(super) fn judge(case: &Case, expected: &Expected, page: &BakedPage, backend: &str) -> Row {
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
        Layer::Visibility => Layer::StdErrVisibility,
        Layer::Specular => Layer::StdErrSpecular,
        _ => Layer::StdErrDiffuse,
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
