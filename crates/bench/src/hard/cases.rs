//! The cases: how each scene is built, its exact value and what bounds the difference.

use super::setup::{SIZE, Setup};
use crate::exact::{Open, round, shapes, tilted_phong};
use ambient::closed_form::{phong_open_angle, tilted_diffuse, tilted_visibility};
use glam::DVec3;
use layers::Layer;
use std::f64::consts::{FRAC_PI_4, PI, TAU};

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
const SAMPLING: &str = "4 stated standard errors + 6/N";
const TRIANGLES: &str = "4 stated standard errors + 6/N + triangles against formula";

/// A case of both hemisphere terms. `names` are its line in the table and whether complements stand there.
fn both(
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
fn shaped(
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

/// Every case, in the order of the table.
pub fn cases() -> Vec<Case> {
    let mut all = walls();
    all.extend(overhead());
    all.extend(closed());
    all.extend(round_ones());
    all.extend(scales());
    all.extend(lobes());
    all.extend(tilted());
    all
}

fn walls() -> Vec<Case> {
    let wall = |name, x: f64, height: f64, table| {
        let setup = Setup::at(x, 0.25 * x).wall(height, 1e4 * x.max(height));
        shaped(
            name,
            setup,
            shapes::wall(x, height),
            false,
            Some((table, false)),
        )
    };
    let groove = |name, opening: f64, table| {
        // The other face leans over the receiver from the crease at x = 0.
        let (x, z) = (1e4 * opening.cos(), 1e4 * opening.sin());
        let setup = Setup::at(1.0, 1e-4).quad([
            [0.0, -1e4, 0.0],
            [0.0, 1e4, 0.0],
            [x, 1e4, z],
            [x, -1e4, z],
        ]);
        let exact = shapes::groove(opening);
        both(
            name,
            setup,
            exact,
            [Bound::Sampling {
                shape: 2e-4 * opening,
            }; 2],
            "4 stated standard errors + 6/N + faces end at 1e4",
            Some((table, false)),
        )
    };
    let touching = |name, far: f64, table| {
        let setup = Setup::over([0.0, far], 0.5 * far).wall(1.0, 1e4);
        let open = shapes::wall_average(0.0, far, 1.0);
        let bounds = [Bound::Sampling { shape: 1e-8 }; 2];
        both(name, setup, open, bounds, SAMPLING, Some((table, false)))
    };
    vec![
        wall(
            "texels 1e-6 from a wall",
            1e-6,
            1.0,
            "infinite wall d=1e-6 h=1",
        ),
        wall(
            "texels 1e-3 from a wall",
            1e-3,
            1.0,
            "infinite wall d=1e-3 h=1",
        ),
        wall("wall 1e-6 high", 1.0, 1e-6, "infinite wall d=1 h=1e-6"),
        wall("wall 1e6 high", 1.0, 1e6, "infinite wall d=1 h=1e6"),
        touching(
            "texels that touch a wall",
            0.01,
            "infinite wall h=1, texel average d in [0,0.01]",
        ),
        groove(
            "groove of 1e-3 rad",
            1e-3,
            "V-groove, opening 1e-3 rad, infinite faces",
        ),
        groove(
            "groove of 0.1 rad",
            0.1,
            "V-groove, opening 0.1 rad, infinite faces",
        ),
    ]
}

fn overhead() -> Vec<Case> {
    let square = [-1.0, 1.0];
    let plate = |z: f64| Setup::at(0.0, 1e-4 * z.max(1e-4)).plate(square, square, z);
    let above = |z| shapes::rectangle_above(square, square, z);
    let strip = |name, width: f64, table| {
        let setup = Setup::at(0.0, 1e-4).plate([-1000.0, 1000.0], [1.0, 1.0 + width], 1.0);
        let open = shapes::rectangle_above([-1000.0, 1000.0], [1.0, 1.0 + width], 1.0);
        shaped(name, setup, open, false, table)
    };
    let huge = [
        [-1000.0, -1000.0, 1.0],
        [2500.0, -1000.0, 1.0],
        [-1000.0, 1000.0, 1.0],
    ]
    .map(DVec3::from);
    let tiny = 2f64.powi(-13);
    let tiny = [
        [1.0, 1.0, 0.5],
        [1.0 + tiny, 1.0, 0.5],
        [1.0, 1.0 + tiny, 0.5],
    ]
    .map(DVec3::from);
    let with = |triangles: &[[DVec3; 3]]| {
        let mut setup = Setup::at(0.0, 1e-4);
        setup.blockers = triangles.to_vec();
        setup
    };
    let under_huge = with(&[huge]).on_triangles(false);
    let aligned = with(&[huge, tiny]);
    let flat = both(
        "coplanar plate",
        Setup::at(0.0, 0.5).plate(square, square, 0.0),
        Open::FULL,
        [Bound::EveryTexel; 2],
        "exact: a plane hides nothing of itself",
        None,
    );
    let turned = both(
        "turned plate 1e-6 above",
        Setup::at(0.0, 0.5).plate(square, square, 1e-6).turned(),
        above(1e-6),
        [Bound::Single { limit: 1.0 }; 2],
        "1e-6 is below the rounding of a turned unit plane (1.4e-6): reads as open",
        None,
    );
    vec![
        shaped(
            "plate 1e-2 above",
            plate(1e-2),
            above(1e-2),
            false,
            Some(("plate [-1,1]^2 at height 1e-2 over the point", false)),
        ),
        shaped(
            "plate 1e-6 above",
            plate(1e-6),
            above(1e-6),
            false,
            Some(("plate [-1,1]^2 at height 1e-6 over the point", false)),
        ),
        turned,
        flat,
        strip(
            "strip 2000 x 1e-3",
            1e-3,
            Some(("strip 2000 x 1e-3 at (y=1,z=1)", true)),
        ),
        strip(
            "strip 2000 x 1e-6",
            1e-6,
            Some(("strip 2000 x 1e-6 at (y=1,z=1)", true)),
        ),
        shaped(
            "huge triangle, tiny one below it",
            aligned,
            under_huge,
            false,
            None,
        ),
    ]
}

fn closed() -> Vec<Case> {
    let (x, y) = ([-1.0, 1.0], [-1.0, 1.0]);
    let side = |setup: Setup, splits: usize| {
        (0..splits).fold(setup, |setup, i| {
            let cut = |i: usize| -1.0 + 2.0 * i as f64 / splits as f64;
            let (a, b) = (cut(i), cut(i + 1));
            setup
                .quad([
                    [-1.0, a, 0.0],
                    [-1.0, b, 0.0],
                    [-1.0, b, 1.5],
                    [-1.0, a, 1.5],
                ])
                .quad([[1.0, a, 0.0], [1.0, a, 1.5], [1.0, b, 1.5], [1.0, b, 0.0]])
                .quad([
                    [a, -1.0, 0.0],
                    [a, -1.0, 1.5],
                    [b, -1.0, 1.5],
                    [b, -1.0, 0.0],
                ])
                .quad([[a, 1.0, 0.0], [b, 1.0, 0.0], [b, 1.0, 1.5], [a, 1.0, 1.5]])
        })
    };
    let box_of = |splits| side(Setup::over(x, 1.0), splits);
    let simple = || box_of(1).plate(x, y, 1.5);
    // 12 panels round, cut at thirds, and 4 above, cut at halves: corners meet edges.
    let panels = || {
        let halves = [[-1.0, 0.0], [0.0, 1.0]];
        let quarters = halves.iter().flat_map(|&x| halves.map(|y| (x, y)));
        quarters.fold(box_of(3), |setup, (x, y)| setup.plate(x, y, 1.5))
    };
    let dark = Open {
        visibility: 0.0,
        diffuse: 0.0,
    };
    let exact = |name, setup| {
        let why = "exact: watertight traversal, samples kept off edges";
        both(name, setup, dark, [Bound::EveryTexel; 2], why, None)
    };
    vec![
        exact("closed box", simple()),
        exact("closed box, turned", simple().turned()),
        exact("closed box of 16 panels", panels()),
        both(
            "closed box of 16 panels, turned",
            panels().turned(),
            dark,
            [Bound::Single { limit: 1e-5 }; 2],
            "corners that meet edges leave gaps of an ulp (1e-7 by 14 units of edge)",
            None,
        ),
    ]
}

fn round_ones() -> Vec<Case> {
    let pinhole = |name, radius: f64, table| {
        const SIDES: usize = 512;
        let at = |i: usize, r: f64, z: f64| {
            let (y, x) = (TAU * (i % SIDES) as f64 / SIDES as f64).sin_cos();
            [r * x, r * y, z]
        };
        let setup = (0..SIDES).fold(Setup::at(0.0, 1e-2 * radius), |setup, i| {
            setup
                .quad([
                    at(i, radius, 1.0),
                    at(i, 2.0, 1.0),
                    at(i + 1, 2.0, 1.0),
                    at(i + 1, radius, 1.0),
                ])
                .quad([
                    at(i, 2.0, -1.0),
                    at(i + 1, 2.0, -1.0),
                    at(i + 1, 2.0, 1.0),
                    at(i, 2.0, 1.0),
                ])
        });
        let tangent = radius;
        let cosine2 = 1.0 / (1.0 + tangent * tangent);
        let open = Open {
            visibility: tangent * tangent * cosine2 / (1.0 + cosine2.sqrt()),
            diffuse: tangent * tangent * cosine2,
        };
        shaped(name, setup, open, false, Some((table, false)))
    };
    let resting = |name, rho: f64, table| {
        const SECTORS: usize = 192;
        let mut angles = vec![0.0];
        angles.extend(
            (0..)
                .map(|k| 1e-5 * 1.1f64.powi(k))
                .take_while(|&a| a < 3.0),
        );
        angles.push(PI);
        let at = |a: f64, i: usize| {
            let (y, x) = (TAU * (i % SECTORS) as f64 / SECTORS as f64).sin_cos();
            let half = (0.5 * a).sin();
            DVec3::new(a.sin() * x, a.sin() * y, 2.0 * half * half)
        };
        let mut setup = Setup::at(rho, 1e-2 * rho);
        for ring in angles.windows(2) {
            for i in 0..SECTORS {
                let [a, b, c, d] = [
                    at(ring[0], i),
                    at(ring[0], i + 1),
                    at(ring[1], i + 1),
                    at(ring[1], i),
                ];
                if ring[0] > 0.0 {
                    setup.blockers.push([a, c, b]);
                }
                if ring[1] < PI {
                    setup.blockers.push([a, d, c]);
                }
            }
        }
        shaped(
            name,
            setup,
            round::resting_sphere(1.0, rho),
            true,
            Some((table, false)),
        )
    };
    vec![
        pinhole(
            "pinhole of radius 0.1",
            0.1,
            "closed box with round hole radius 1e-1 overhead at height 1",
        ),
        pinhole(
            "pinhole of radius 1e-3",
            1e-3,
            "closed box with round hole radius 1e-3 overhead at height 1",
        ),
        resting(
            "resting sphere, rho 1e-2",
            1e-2,
            "unit sphere resting, rho=1e-2",
        ),
        resting(
            "resting sphere, rho 1e-3",
            1e-3,
            "unit sphere resting, rho=1e-3",
        ),
    ]
}

fn scales() -> Vec<Case> {
    let wall = || Setup::over([0.9375, 1.0625], 0.0625).wall(1.0, 1e3);
    let open = shapes::wall_average(0.9375, 1.0625, 1.0);
    let scaled = |name, factor: f64| {
        // The wall ends at 1e3; its corners round to 6e-8 of themselves.
        let bounds = [Bound::Sampling { shape: 1e-6 }; 2];
        both(
            name,
            wall().map(|p| p * factor),
            open,
            bounds,
            TRIANGLES,
            None,
        )
    };
    vec![
        scaled("scaled by 1e-4", 1e-4),
        scaled("scaled by 1e5", 1e5),
        both(
            "moved by 1e6",
            wall().map(|p| p + DVec3::splat(1e6)),
            open,
            [
                Bound::Columns {
                    exact: |u| moved(u).visibility,
                    limit: 0.004_896_7,
                },
                Bound::Columns {
                    exact: |u| moved(u).diffuse,
                    limit: 0.005_396_9,
                },
            ],
            "worst column of texels; ray origins round to 1/16: half of that in d, + 4 stated standard errors + 6/N",
            None,
        ),
    ]
}

/// The moved wall at a column of texels that begins at the share `u` of the chart.
fn moved(u: f64) -> Open {
    let near = 0.9375 + 0.125 * u;
    shapes::wall_average(near, near + 0.125 / f64::from(SIZE), 1.0)
}

fn lobe(name: &'static str, setup: Setup, value: f64, table: Option<TableEntry>) -> Case {
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
fn leaning(zenith: f64) -> DVec3 {
    DVec3::new(zenith.sin(), 0.0, zenith.cos())
}

fn lobes() -> Vec<Case> {
    let open = |name, exponent: f64, degrees: f64, case| {
        let mut setup = Setup::at(0.0, 1e-4);
        setup.view = Some(leaning(degrees.to_radians()));
        setup.exponent = Some(exponent);
        let value = phong_open_angle(exponent, degrees.to_radians());
        let table = TableEntry {
            case,
            quantity: "G=",
            complement: false,
        };
        lobe(name, setup, value, Some(table))
    };
    let silhouette = |name, exponent: f64| {
        let mut setup = Setup::at(1.0, 1e-4).wall(1.0, 1e4);
        setup.view = Some(leaning(FRAC_PI_4));
        setup.exponent = Some(exponent);
        let hidden = 0.5 - phong_open_angle(exponent, 3.0 * FRAC_PI_4);
        lobe(
            name,
            setup,
            phong_open_angle(exponent, FRAC_PI_4) - hidden,
            None,
        )
    };
    vec![
        open(
            "n = 100 seen at 89 deg",
            100.0,
            89.0,
            "open plane Phong n=100 theta=89",
        ),
        open(
            "n = 1e4 seen at 89.99 deg",
            1e4,
            89.99,
            "open plane Phong n=1e4 theta=89.99",
        ),
        open(
            "n = 1e6 seen at 0 deg",
            1e6,
            0.0,
            "open plane Phong n=1e6 theta=0",
        ),
        open(
            "n = 1e6 seen at 89.9 deg",
            1e6,
            89.9,
            "open plane Phong n=1e6 theta=89.9",
        ),
        open(
            "n = 1e6 seen at 90 deg",
            1e6,
            90.0,
            "open plane Phong n=1e6 theta=90",
        ),
        open(
            "n = 1e6 from below, 90.01 deg",
            1e6,
            90.01,
            "open plane Phong n=1e6 theta=90.01",
        ),
        open(
            "n = 1e6 from below, 90.1 deg",
            1e6,
            90.1,
            "open plane Phong n=1e6 theta=90.1",
        ),
        open(
            "n = 1e6 from below, 91 deg",
            1e6,
            91.0,
            "open plane Phong n=1e6 theta=91",
        ),
        open(
            "n = 1 from below, 91 deg",
            1.0,
            91.0,
            "open plane Phong n=1 theta=91",
        ),
        silhouette("n = 10, axis on a silhouette", 10.0),
        silhouette("n = 1000, axis on a silhouette", 1000.0),
        silhouette("n = 1e5, axis on a silhouette", 1e5),
    ]
}

fn tilted() -> Vec<Case> {
    let mut all = Vec::new();
    let plain = [
        (
            "shading normal tilted 10 deg",
            "plane, shading normal tilted 10 deg",
            10.0f64,
        ),
        (
            "shading normal tilted 30 deg",
            "plane, shading normal tilted 30 deg",
            30.0,
        ),
        (
            "shading normal tilted 60 deg",
            "plane, shading normal tilted 60 deg",
            60.0,
        ),
    ];
    for (name, line, degrees) in plain {
        let delta = degrees.to_radians();
        let mut setup = Setup::at(0.0, 0.5);
        setup.normal = Some(leaning(delta));
        let open = Open {
            visibility: tilted_visibility(delta),
            diffuse: tilted_diffuse(delta),
        };
        // The normal itself rounds to f32.
        let bounds = [Bound::Sampling { shape: 1e-7 }; 2];
        all.push(both(
            name,
            setup,
            open,
            bounds,
            SAMPLING,
            Some((line, false)),
        ));
    }
    let seen = [
        (
            "tilted 10 deg, seen at 80 deg from behind",
            "  view 80 deg az 180, Ns tilt 10",
            10.0f64,
            -80.0f64,
        ),
        (
            "tilted 30 deg, seen at 60 deg from behind",
            "  view 60 deg az 180, Ns tilt 30",
            30.0,
            -60.0,
        ),
        (
            "tilted 60 deg, seen at 60 deg",
            "  view 60 deg az 0, Ns tilt 60",
            60.0,
            60.0,
        ),
    ];
    for (name, case, tilt, view) in seen {
        let (normal, view) = (leaning(tilt.to_radians()), leaning(view.to_radians()));
        let mut setup = Setup::at(0.0, 1e-4);
        (setup.normal, setup.view, setup.exponent) = (Some(normal), Some(view), Some(20.0));
        let mirror = 2.0 * normal.dot(view) * normal - view;
        let value = tilted_phong(normal, DVec3::Z, mirror, 20.0);
        let table = TableEntry {
            case,
            quantity: "norm. Phong",
            complement: false,
        };
        all.push(lobe(name, setup, value, Some(table)));
    }
    all
}
