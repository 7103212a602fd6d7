//! A turning body without symmetry, and its exact pictures by many samples a pixel.

use frames::{Shader, Surfel, Turn};
use glam::DVec3;
use rayon::prelude::*;
use render::Camera;

/// Half axes of the body.
const AXES: DVec3 = DVec3::new(1.0, 0.7, 0.85);

/// Samples on a side of a pixel: 1,024 in all.
const GRID: u32 = 32;

/// What a ray meets on an ellipsoid at the origin whose normals are tilted by waves up to `wrinkles`, about radians.
pub(crate) fn body(wrinkles: f64, eye: DVec3, direction: DVec3) -> Option<Surfel> {
    let (from, along) = (eye / AXES, direction / AXES);
    let (a, b) = (along.length_squared(), from.dot(along));
    let root = b * b - a * (from.length_squared() - 1.0);
    let t = (-b - root.max(0.0).sqrt()) / a;
    if root < 0.0 || t <= 0.0 {
        return None;
    }
    let place = eye + direction * t;
    let smooth = (place / (AXES * AXES)).normalize();
    let waves = DVec3::new(
        (9.0 * place.z).cos(),
        (11.0 * place.x).cos(),
        (10.0 * place.y).cos(),
    );
    let normal = (smooth + waves * wrinkles).normalize();
    // Seen from behind, a tilted normal is turned back to the horizon of the view.
    let normal = match normal.dot(direction) {
        behind if behind > 0.0 => (normal - direction * behind).normalize(),
        _ => normal,
    };
    Some(Surfel {
        normal,
        albedo: DVec3::ZERO,
        specular: DVec3::ONE,
        ..Surfel::default()
    })
}

/// The turn of a frame.
pub(crate) fn turned(angle: f64) -> Turn {
    Turn {
        centre: DVec3::ZERO,
        axis: DVec3::Y,
        angle,
    }
}

/// Mean radiance of what the samples meet in each pixel: ambient light of the other pixels is 0.
pub(crate) fn truth(
    camera: &Camera,
    turn: Turn,
    shader: &Shader,
    hit: impl Fn(DVec3, DVec3) -> Option<Surfel> + Sync,
) -> Vec<[f64; 3]> {
    let [width, height] = camera.size;
    let rotation = glam::DQuat::from_axis_angle(turn.axis, turn.angle);
    let back = rotation.inverse();
    let eye = back * camera.eye;
    let pixel = |at: u32| {
        let (mut sum, mut count) = ([0.0; 3], 0u32);
        for number in 0..GRID * GRID {
            let place =
                |at: u32, step: u32| f64::from(at) + (f64::from(step) + 0.5) / f64::from(GRID);
            let direction = camera.direction(
                place(at % width, number % GRID),
                place(at / width, number / GRID),
            );
            if let Some(surfel) = hit(eye, back * direction) {
                let normal = (rotation * surfel.normal).as_vec3().to_array();
                let material = [surfel.albedo, surfel.specular].map(|rgb| rgb.as_vec3().to_array());
                let value = shader.point(normal, (-direction).as_vec3().to_array(), material);
                sum = [0, 1, 2].map(|c: usize| sum[c] + f64::from(value[c]));
                count += 1;
            }
        }
        sum.map(|v| v / f64::from(count.max(1)))
    };
    (0..width * height).into_par_iter().map(pixel).collect()
}
