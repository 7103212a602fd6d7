//! How much of a scene a picture tells.

use super::room::Room;
use super::subject::normal;
use crate::{Camera, Framing};
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

/// Rays across a picture.
const ACROSS: u32 = 40;
/// Cells of a grid along the longest side of a scene, in each of which a piece of surface is of one body.
const CELLS: f64 = 16.0;

/// What a picture tells, in bits: the entropy of the pieces of surface whose fronts it shows. Backs tell nothing. A
/// piece is what lies in one cell of a grid over the scene and faces one of six ways, so that a fine mesh tells no more
/// than a coarse one. P.-P. Vázquez, M. Feixas, M. Sbert, W. Heidrich, "Viewpoint Selection using Viewpoint Entropy"
/// (2001), whose pieces are the triangles, without what lies behind the scene.
pub(super) fn told(room: &Room, camera: &Camera) -> f64 {
    let cell = (room.focus.max - room.focus.min).max_element() / CELLS;
    let [width, height] = camera.size.map(f64::from);
    let hits = (0..ACROSS * ACROSS).filter_map(|index| {
        let part = |k: u32| (f64::from(k) + 0.5) / f64::from(ACROSS);
        let [x, y] = [width * part(index % ACROSS), height * part(index / ACROSS)];
        let toward = camera.direction(x, y);
        let hit = room.first(camera.eye, toward)?;
        let at = camera.eye + f64::from(hit.t) * toward - room.focus.min;
        let normal = normal(&room.world.corners(hit.instance, hit.triangle));
        let axis = normal.abs().max_position();
        let place = (at / cell).floor().as_i64vec3().to_array();
        Some((hit.front, (place, axis, normal[axis] > 0.0)))
    });
    let hits: Vec<_> = hits.collect();
    let fronts = hits.iter().filter(|hit| hit.0);
    let mut fronts: Vec<_> = fronts.map(|hit| hit.1).collect();
    fronts.sort_unstable();
    let share = |same: &[_]| same.len() as f64 / hits.len() as f64;
    let shares = fronts.chunk_by(|a, b| a == b).map(share);
    shares.map(|share| -share * share.log2()).sum()
}

/// The view from one of some eyes that looks farthest: of twelve directions around, by the mean logarithm of the
/// distance of the fronts that are met; things close to the eye count nothing.
pub(super) fn farthest(
    room: &Room,
    eyes: impl Iterator<Item = DVec3>,
    lens: &Framing,
) -> Option<Camera> {
    let near = 0.03 * (room.focus.max - room.focus.min).length();
    let up = lens.up.normalize_or(DVec3::Y);
    let ahead = up.any_orthonormal_vector();
    let mut best: Option<(f64, [DVec3; 2])> = None;
    for eye in eyes {
        for step in 0..12 {
            let turn = DQuat::from_axis_angle(up, TAU * f64::from(step) / 12.0);
            let forward = turn * ahead - 0.15 * up;
            let right = forward.cross(up).normalize_or(DVec3::X);
            let mut sum = 0.0;
            for index in 0..9 * 5 {
                let [x, y] = [index % 9 - 4, index / 9 - 2].map(f64::from);
                let toward = forward + right * (0.2 * x) + up * (0.2 * y);
                if let Some(hit) = room.first(eye, toward).filter(|hit| hit.front) {
                    sum += (f64::from(hit.t) * toward.length() / near).max(1.0).ln();
                }
            }
            if sum > best.map_or(0.0, |(most, _)| most) {
                best = Some((sum, [eye, eye + forward]));
            }
        }
    }
    lens.camera_at(best?.1).ok()
}
