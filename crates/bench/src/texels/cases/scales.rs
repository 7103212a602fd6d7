//! T8: the wall and the sunk box again, scaled and moved far away, and a box of a centimetre on ten kilometres of
//! ground. A fixed offset or tolerance is wrong at one end or the other.

use super::{scene, sunk_box, wall};
use crate::exact::polygon_form_factor;
use crate::texels::Error;
use crate::texels::bake::{Baked, Judged, Lab, PER_EDGE, Texels, largest, score};
use crate::texels::build::{Place, faces, mesh, polygon, quad};
use crate::texels::points::Point;
use crate::texels::row::Row;
use glam::{DVec2, DVec3};

const PLACES: [(&str, Place); 4] = [
    ("at home", Place::HOME),
    ("scaled by 0.001", scaled(1e-3)),
    ("scaled by 10,000", scaled(1e4)),
    (
        "moved by 1e5, -3e4, 2e4",
        Place {
            scale: 1.0,
            shift: DVec3::new(1e5, -3e4, 2e4),
        },
    ),
];

const fn scaled(scale: f64) -> Place {
    Place {
        scale,
        shift: DVec3::ZERO,
    }
}

/// Bakes a scene at a place.
type Bake = fn(&Lab, Place) -> Result<Baked, Error>;
/// The exact value of a point whose place at home is given.
type Truth = fn(&Point, DVec3) -> Option<f64>;

pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, Error> {
    let scenes: [(&str, Bake, Truth); 2] = [
        (
            "wall",
            |lab, place| wall::bake(lab, 16.0, place),
            wall::truth,
        ),
        (
            "sunk box",
            |lab, place| sunk_box::bake(lab, sunk_box::Kind::Plain, place),
            |point, home| sunk_box::truth(sunk_box::Kind::Plain, point, home),
        ),
    ];
    let mut rows = Vec::new();
    for (name, bake, truth) in scenes {
        let mut first: Vec<Judged> = Vec::new();
        for (variant, place) in PLACES {
            let baked = bake(lab, place)?;
            let judged = baked.judge(PER_EDGE, |p| truth(p, place.home(p.position)));
            if first.is_empty() {
                first = judged;
                continue;
            }
            let change = first
                .iter()
                .zip(&judged)
                .map(|(a, b)| (a.value - b.value).abs());
            let change = change.fold(f64::NAN, f64::max);
            rows.push(lab.row(
                "T8",
                format!("{name}, {variant}"),
                score(&judged),
                (
                    "change against home: 0.003 at 4,096 rays",
                    if judged.len() == first.len() {
                        change
                    } else {
                        f64::NAN
                    },
                    Some(lab.noise(0.003)),
                ),
            ));
        }
    }
    rows.push(giant(lab)?);
    Ok(rows)
}

/// A box of edge 0.01 on a triangle of 10,000.
fn giant(lab: &Lab) -> Result<Row, Error> {
    const SIZE: u32 = 64;
    const HALF: f64 = 0.005;
    let ground = [[-5e3, -4e3, 0.0], [5e3, -4e3, 0.0], [0.0, 6e3, 0.0]].map(DVec3::from);
    let mut plane = mesh("ground");
    let places = [[4.0, 4.0], [34.0, 4.0], [19.0, 34.0]].map(DVec2::from);
    polygon(&mut plane, SIZE, &ground, &places);
    let mut body = mesh("box");
    for (k, face) in faces(DVec3::splat(HALF)).into_iter().take(5).enumerate() {
        let (x, y) = (40.0 + 11.0 * (k / 3) as f64, 4.0 + 11.0 * (k % 3) as f64);
        quad(&mut body, SIZE, face, [x, y, x + 8.0, y + 8.0]);
    }
    let raised = Place {
        scale: 1.0,
        shift: HALF * DVec3::Z,
    };
    raised.put(&mut body);
    let baked = lab.bake(
        "T8",
        scene("T8", vec![plane, body], vec![])?,
        Texels::Authored(SIZE),
    )?;
    let judged = baked.judge(PER_EDGE, |point| match point.instance {
        // A metre away the box takes less than 1e-6 of a hemisphere.
        0 => (point.position.length() > 1.0).then_some(1.0),
        _ => Some(1.0 - polygon_form_factor(&ground.map(|p| p - point.position), point.geometric)),
    });
    let criterion = (
        "largest error: 0.003 at 4,096 rays",
        largest(&judged, |_| true),
        Some(lab.noise(0.003)),
    );
    Ok(lab.row(
        "T8",
        "box of 0.01 on a ground of 10,000",
        score(&judged),
        criterion,
    ))
}
