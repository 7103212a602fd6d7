//! Pairs of scenes that must bake to the same bits.

use super::bake::{bake, plane};
use super::error::Error;
use super::row::{Row, count, hash};
use super::setup::{SIZE, Setup};
use layers::Layer;
use rays::BackendKind;

/// One row a pair and term.
pub(super) fn rows(kind: BackendKind, backend: &str) -> Result<Vec<Row>, Error> {
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
