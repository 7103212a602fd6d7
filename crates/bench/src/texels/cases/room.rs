//! T4: a closed room of separate panels. Any light inside is a leak.

use super::scene;
use crate::exact::polygon_form_factor;
use crate::texels::Error;
use crate::texels::bake::{Lab, PER_EDGE, STEP, Texels, largest, score};
use crate::texels::build::sheet;
use crate::texels::points::Point;
use crate::texels::row::Row;
use glam::{DAffine3, DQuat, DVec3};
use scene::authored::Mesh;

const SIZE: u32 = 64;
/// Texels a unit.
const DENSITY: f64 = 4.0;
const ROOM: DVec3 = DVec3::new(4.0, 4.0, 2.5);

/// A panel: its corner, and its two edges, whose cross product looks into the room.
type Panel = [DVec3; 3];

/// Four panels of floor and ceiling each, two of every wall.
fn panels() -> Vec<Panel> {
    let mut all = Vec::new();
    for axis in 0..3 {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let edge = |k: usize| if k == 2 { ROOM.z } else { 0.5 * ROOM[k] };
        let (along, up) = (DVec3::AXES[a] * edge(a), DVec3::AXES[b] * edge(b));
        let counts = [a, b].map(|k| if k == 2 { 1 } else { 2 });
        for (i, j) in (0..counts[0]).flat_map(|i| (0..counts[1]).map(move |j| (i, j))) {
            let near = along * f64::from(i) + up * f64::from(j);
            all.push([near, along, up]);
            all.push([near + DVec3::AXES[axis] * ROOM[axis] + along, -along, up]);
        }
    }
    all
}

/// A panel larger by `grow` on every side, in its plane.
fn grown([corner, a, b]: Panel, grow: f64) -> Panel {
    let (da, db) = (a.normalize() * grow, b.normalize() * grow);
    [corner - da - db, a + 2.0 * da, b + 2.0 * db]
}

fn corners([corner, a, b]: Panel) -> [DVec3; 4] {
    [corner, corner + a, corner + a + b, corner + b]
}

/// A panel as an object. Turned panels are unit squares under matrices of their own, so that the corners that meet
/// differ in their last bits.
fn object(number: usize, panel: Panel, turned: bool, phase: f64) -> Mesh {
    let [corner, a, b] = panel;
    let (x, y) = (
        15.0 * (number % 4) as f64 + 3.0 + phase,
        15.0 * (number / 4) as f64 + 3.0 + phase,
    );
    let rect = [x, y, x + a.length() * DENSITY, y + b.length() * DENSITY];
    if !turned {
        return sheet("panel", SIZE, corners(panel), rect);
    }
    let unit = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
    let mut mesh = sheet("panel", SIZE, unit, rect);
    let axes = glam::DMat3::from_cols(a, b, a.cross(b).normalize());
    let place = turn() * DAffine3::from_mat3_translation(axes, corner);
    mesh.transform = glam::Mat4::from(place.as_affine3a()).to_cols_array_2d();
    mesh
}

fn turn() -> DAffine3 {
    DAffine3::from_quat(DQuat::from_axis_angle(
        DVec3::new(0.2, 0.3, 1.0).normalize(),
        0.31,
    ))
}

pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    // How much panels grow, whether they are turned, where charts begin in their texel.
    for (variant, grow, turned, phase) in [
        ("abutting panels", 0.0, false, 0.0),
        ("edges an ulp apart", 0.0, true, 0.0),
        ("charts that end on half texels", 0.0, true, 0.5),
        ("panels overlap by 0.005", 0.0025, true, 0.37),
        ("gaps of 0.001", -0.0005, true, 0.37),
    ] {
        let all: Vec<Panel> = panels().into_iter().map(|p| grown(p, grow)).collect();
        let meshes = all
            .iter()
            .enumerate()
            .map(|(k, &p)| object(k, p, turned, phase));
        let baked = lab.bake(
            "T4",
            scene("T4", meshes.collect(), vec![])?,
            Texels::Authored(SIZE),
        )?;
        let back = if turned {
            turn().inverse()
        } else {
            DAffine3::IDENTITY
        };
        let home = |point: &Point| back.transform_point3(point.position);
        let judged = baked.judge(PER_EDGE, |point| {
            let p = home(point);
            // What a panel of the overlapping variant has outside the room cannot be seen.
            let inside = p.min_element() > -1e-5 && (ROOM - p).min_element() > -1e-5;
            inside.then(|| {
                if grow < 0.0 {
                    gaps(&all, p, back.transform_vector3(point.geometric))
                } else {
                    0.0
                }
            })
        });
        let criterion = if grow < 0.0 {
            let texel = 1.0 / DENSITY;
            let off_gaps = |p: DVec3| all.iter().all(|panel| edge_distance(*panel, p) > texel);
            (
                "error a texel or more off the gaps: 1/255 at 4,096 rays",
                largest(&judged, |j| off_gaps(home(&j.point))),
                Some(lab.noise(STEP)),
            )
        } else if grow > 0.0 {
            // The rims that stand out of the room see the sky, and share texels with the inside.
            (
                "light inside: 1/255",
                largest(&judged, |_| true),
                Some(STEP),
            )
        } else {
            (
                "light inside: exactly 0",
                largest(&judged, |_| true),
                Some(0.0),
            )
        };
        rows.push(lab.row("T4", variant, score(&judged), criterion));
    }
    Ok(rows)
}

/// What the gaps let in: panels on the faces of a convex room do not overlap as seen from inside, so 1 less all of
/// their form factors.
fn gaps(panels: &[Panel], p: DVec3, normal: DVec3) -> f64 {
    let shut = panels
        .iter()
        .map(|&panel| polygon_form_factor(&corners(panel).map(|c| c - p), normal));
    (1.0 - shut.sum::<f64>()).max(0.0)
}

/// Distance of a point from the border of a panel.
fn edge_distance([corner, a, b]: Panel, p: DVec3) -> f64 {
    let [at, along, up] = [p - corner, a.normalize(), b.normalize()];
    let (u, v) = (
        at.dot(along).clamp(0.0, a.length()),
        at.dot(up).clamp(0.0, b.length()),
    );
    let foot = corner + along * u + up * v;
    // From inside its rectangle the way to the border is in the plane.
    let inner = u.min(a.length() - u).min(v).min(b.length() - v);
    (p - foot).length().hypot(inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_panels_look_inward_and_close_the_room() {
        let all = panels();
        assert_eq!(all.len(), 16);
        let (middle, up) = (0.5 * ROOM, DVec3::new(0.1, 0.2, 1.0).normalize());
        for panel in &all {
            let normal = panel[1].cross(panel[2]);
            assert!(normal.dot(middle - panel[0]) > 0.0, "{panel:?}");
        }
        assert!(gaps(&all, middle, up) < 1e-12);
        let apart: Vec<Panel> = all.iter().map(|&p| grown(p, -0.0005)).collect();
        let open = gaps(&apart, middle, up);
        assert!((1e-4..2e-3).contains(&open), "{open}");
    }
}
