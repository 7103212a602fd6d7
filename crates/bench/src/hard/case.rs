//! What a case is, and how one is made from its scene, its exact values and its bounds.

use super::setup::Setup;
use crate::exact::Open;
use glam::DVec3;
use layers::Layer;

/// One scene with what it must give.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its name.
    pub name: &'static str,
    /// The scene.
    pub setup: Setup,
    /// One entry a term.
    pub expected: Vec<Expected>,
}

/// The exact value of a term.
#[derive(Debug, Clone, Copy)]
pub struct Expected {
    /// Its layer.
    pub term: Layer,
    /// The value on paper.
    pub value: f64,
    /// How far a bake may be off.
    pub(super) bound: Bound,
    /// What the bound is made of, in a few words.
    pub why: &'static str,
    /// Where the table of hard cases holds the value.
    pub table: Option<TableEntry>,
}

/// A line of the table of hard cases, which holds a value or its complement to 1.
#[derive(Debug, Clone, Copy)]
pub struct TableEntry {
    /// First column.
    pub case: &'static str,
    /// Start of the second column.
    pub quantity: &'static str,
    /// The table holds 1 minus the value.
    pub complement: bool,
}

/// How far a bake may be off.
#[derive(Debug, Clone, Copy)]
pub(super) enum Bound {
    /// Not at all, on any texel.
    EveryTexel,
    /// By sampling, and by what the triangles differ from the shape on paper.
    Sampling { shape: f64 },
    /// By sampling where f32 can hold the case; by `limit` where it cannot.
    Single { limit: f64 },
    /// As `Single` with its limit beside sampling, on the column of texels farthest off: each has its own value.
    Columns { exact: fn(f64) -> f64, limit: f64 },
}

const HALVES: [Layer; 2] = [Layer::Visibility, Layer::Diffuse];

/// What a bound of sampling alone is made of.
pub(super) const SAMPLING: &str = "4 stated standard errors + 6/N";
/// The same where triangles stand for a shape on paper.
pub(super) const TRIANGLES: &str = "4 stated standard errors + 6/N + triangles against formula";

/// A case of both hemisphere terms. `table` is its line in the table of hard cases and whether
/// complements stand there.
pub(super) fn both(
    name: &'static str,
    setup: Setup,
    open: Open,
    bounds: [Bound; 2],
    why: &'static str,
    table: Option<(&'static str, bool)>,
) -> Case {
    let values = [open.visibility, open.diffuse];
    let expected = (0..2).map(|i| Expected {
        term: HALVES[i],
        value: values[i],
        bound: bounds[i],
        why,
        table: table.map(|(case, complement)| TableEntry {
            case,
            quantity: match (complement, i) {
                (false, 0) => "AO_uniform",
                (false, _) => "AO_cos",
                (true, 0) => "1-AO_uniform",
                (true, _) => "1-AO_cos",
            },
            complement,
        }),
    });
    Case {
        name,
        expected: expected.collect(),
        setup,
    }
}

/// A case that its triangles hold up to a difference that the polygon formulas give.
pub(super) fn shaped(
    name: &'static str,
    setup: Setup,
    open: Open,
    convex: bool,
    table: Option<(&'static str, bool)>,
) -> Case {
    let held = setup.on_triangles(convex);
    let bounds = [
        held.visibility - open.visibility,
        held.diffuse - open.diffuse,
    ]
    .map(|shape| Bound::Sampling { shape: shape.abs() });
    both(name, setup, open, bounds, TRIANGLES, table)
}

/// A case of the specular term on a chart so small that the value at its middle stands for all of it.
pub(super) fn lobe(
    name: &'static str,
    setup: Setup,
    value: f64,
    table: Option<TableEntry>,
) -> Case {
    Case {
        name,
        setup,
        expected: vec![Expected {
            term: Layer::Specular,
            value,
            bound: Bound::Sampling { shape: 1e-6 },
            why: "4 stated standard errors + 6/N + chart of 2e-4 (1e-6)",
            table,
        }],
    }
}

/// The direction `zenith` off +z, leaning to +x.
pub(super) fn leaning(zenith: f64) -> DVec3 {
    DVec3::new(zenith.sin(), 0.0, zenith.cos())
}
