//! Whether a texel lies inside a closed body.

use super::task::Task;
use crate::labels;
use crate::survey::Texel;
use ambient::Frame;
use ambient::sampling::Mixture;
use rays::{Ray, World};

/// Rays of the `validity` layer.
const VALIDITY_RAYS: u32 = 16;

/// Share of the footprint's upper hemisphere that does not see a back face first: 1 for a texel in the open or in a
/// room, near 0 inside a closed body. Double-sided surfaces have no back.
pub(crate) fn validity(task: &Task<'_>, texel: &Texel, world: &World) -> f64 {
    if texel.open {
        return 1.0;
    }
    let stream = task.stream(texel.x, texel.y, labels::VALIDITY, 0);
    let valid = (0..VALIDITY_RAYS).filter(|&index| {
        let [u0, u1, p0, p1] = stream.point(index);
        let sample = texel.sample([p0, p1]);
        let direction =
            Frame::from_normal(sample.geometric).to_world(Mixture::UNIFORM.sample([u0, u1]));
        let ray = Ray {
            origin: sample.origin,
            direction: direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        task.backend
            .closest(&ray)
            .is_none_or(|hit| hit.front || world.is_double_sided(hit.instance))
    });
    valid.count() as f64 / f64::from(VALIDITY_RAYS)
}
