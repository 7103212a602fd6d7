//! T3: a box sunk half-way in the floor. Texels under it must not draw a ring around it, dark or bright.

use super::scene;
use crate::exact::polygon_form_factor;
use crate::texels::Error;
use crate::texels::bake::{Baked, Lab, PER_EDGE, STEP, Texels, largest, score, targets};
use crate::texels::best::best_errors;
use crate::texels::build::{Place, faces, invert, level, material, mesh, quad, sheet};
use crate::texels::points::Point;
use crate::texels::row::Row;
use glam::{DQuat, DVec2, DVec3};

const SIZE: u32 = 64;
/// The floor's chart: 4 x 4 units at 8 texels a unit, off the grid by 0.37 of a texel.
const CHART: [f64; 4] = [4.37, 4.37, 36.37, 36.37];
const FLOOR: f64 = 2.0;
/// The ring: this far around the box, two texels.
const RING: f64 = 0.25;
const HALF: f64 = 0.5;

/// What the surface of the box is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// Faces look outward and have a back.
    Plain,
    /// Faces look inward.
    Inverted,
    /// Faces have no back.
    DoubleSided,
}

fn turn() -> DQuat {
    DQuat::from_rotation_z(17f64.to_radians())
}

/// The scene.
pub(super) fn bake(lab: &Lab, kind: Kind, place: Place) -> Result<Baked, Error> {
    let corners = level([-FLOOR, FLOOR], [-FLOOR, FLOOR], 0.0);
    let mut floor = sheet("floor", SIZE, corners, CHART);
    let mut body = mesh("box");
    for (k, face) in faces(DVec3::splat(HALF)).into_iter().enumerate() {
        let (x, y) = (40.0 + 11.0 * (k / 3) as f64, 4.0 + 11.0 * (k % 3) as f64);
        quad(
            &mut body,
            SIZE,
            face.map(|p| turn() * p),
            [x, y, x + 8.0, y + 8.0],
        );
    }
    if kind == Kind::Inverted {
        invert(&mut body);
    }
    place.put(&mut floor);
    place.put(&mut body);
    let materials = vec![material(kind == Kind::DoubleSided)];
    lab.bake(
        "T3",
        scene("T3", vec![floor, body], materials)?,
        Texels::Authored(SIZE),
    )
}

/// The diffuse term of a point whose place at home is given, `None` where it is inside the box or below the floor.
///
/// The box takes from the floor the form factors of its upright faces that look at the point; the floor takes its own
/// from the upper half of the box. Neither is behind anything else.
pub(super) fn truth(kind: Kind, point: &Point, home: DVec3) -> Option<f64> {
    let own = turn().inverse() * home;
    if point.instance == 0 {
        let outside = own.abs().truncate().max_element() > HALF;
        return outside.then(|| {
            let upright = &faces(DVec3::splat(HALF))[..4];
            let facing = upright
                .iter()
                .filter(|f| (f[1] - f[0]).cross(f[2] - f[0]).dot(own - f[0]) > 0.0);
            let blocked = facing.map(|f| polygon_form_factor(&f.map(|p| p - own), DVec3::Z));
            1.0 - blocked.sum::<f64>()
        });
    }
    // The front of an inverted box looks into it, where nobody stands.
    (kind != Kind::Inverted && own.z > 0.0).then(|| {
        let outward = turn() * point_normal(own);
        let floor = level([-FLOOR, FLOOR], [-FLOOR, FLOOR], 0.0);
        1.0 - polygon_form_factor(&floor.map(|p| p - home), outward)
    })
}

/// Outward normal at a point of the unturned box's surface.
fn point_normal(own: DVec3) -> DVec3 {
    let size = own.abs();
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    DVec3::AXES[axis] * own[axis].signum()
}

/// True for a point of the floor within two texels of the box, but not of its corners: there the exact value depends on
/// the side that one comes from, and no texel can hold it.
fn in_ring(point: &Point) -> bool {
    let own = (turn().inverse() * point.position).abs().truncate();
    let near = (own - HALF).max(DVec2::ZERO).length() < RING;
    point.instance == 0 && near && (own - HALF).length() > RING
}

pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (variant, kind) in [
        ("box", Kind::Plain),
        ("inverted box", Kind::Inverted),
        ("double-sided box", Kind::DoubleSided),
    ] {
        let baked = bake(lab, kind, Place::HOME)?;
        let judged = baked.judge(PER_EDGE, |point| truth(kind, point, point.position));
        let best = best_errors(SIZE, &targets(&judged));
        let limit = judged
            .iter()
            .zip(&best)
            .filter(|(j, _)| in_ring(&j.point))
            .fold(0.0f64, |limit, (_, error)| limit.max(error.abs()));
        rows.push(lab.row(
            "T3",
            variant,
            score(&judged),
            (
                "ring error above what the best texels leave there: 1/255 at 4,096 rays",
                largest(&judged, |j| in_ring(&j.point)) - limit,
                Some(lab.noise(STEP)),
            ),
        ));
    }
    Ok(rows)
}
