//! Terms in closed form, for texels that nothing stands above.
//!
//! A shading normal may lean against the geometric plane. In production shading a direction below the plane sees what
//! its mirror image sees, here the sky: all terms are those of a flat surface with the shading normal. In exact shading
//! the horizon is the geometric plane. Visibility, diffuse and bent normal have closed forms at any lean. The specular
//! term then has one where the surface is flat, for any eye, and where V = N, so that the lobe stands on the shading
//! normal; seen from an eye over a leaning normal its region has three sides, and directions are drawn instead.

use super::estimate::variance_of_mean;
use super::task::Task;
use super::terms::{AnyView, Directional, Terms, uniform_light};
use crate::labels;
use crate::options::{Model, Shading, View};
use crate::survey::Texel;
use ambient::Estimate;
use ambient::any_view::Coefficients;
use ambient::closed_form::{
    phong_open, tilted_bent, tilted_diffuse, tilted_mean, tilted_visibility,
};
use glam::DVec3;

/// Points over the footprint: closed forms hold at a point, so they are averaged.
const POINTS: u32 = 64;

/// Independent sets of them.
const REPLICATES: u32 = 4;

/// True where the specular term of an open texel has a closed form.
pub(super) fn has_specular(task: &Task<'_>, texel: &Texel) -> bool {
    let along = task.model == Model::Phong && task.view == View::Normal;
    task.shading == Shading::Production || along || !texel.tilted
}

/// The terms of an open texel under a uniform sky. `specular` asks for the specular term, which must have a closed
/// form.
pub(super) fn terms(task: &Task<'_>, texel: &Texel, specular: bool) -> Terms {
    let sky = DVec3::from(task.sky.floor());
    let with_light = |terms: Terms| Terms {
        irradiance: uniform_light(sky, terms.diffuse),
        reflection: uniform_light(sky, terms.specular),
        white: terms.specular.value,
        ..terms
    };
    // Nothing is blocked but what leans away; such texels are not closed where any view is asked for.
    let any_view = task.any_view.map(|_| {
        Box::new(AnyView {
            coefficients: Coefficients::OPEN,
            std_err: 0.0,
        })
    });
    let is_flat = task.shading == Shading::Production || !texel.tilted;
    if is_flat && task.view == View::Normal {
        return with_light(Terms {
            visibility: Estimate::exact(1.0),
            diffuse: Estimate::exact(1.0),
            specular: Estimate::exact(f64::from(u8::from(specular))),
            directional: Directional::open(sky, texel.normal),
            any_view,
            ..Terms::default()
        });
    }
    let mut means = [[0.0; REPLICATES as usize]; 3];
    let mut directions = [DVec3::ZERO; 2];
    let points = POINTS / REPLICATES;
    for replicate in 0..REPLICATES {
        let stream = task.stream(texel.x, texel.y, labels::HEMISPHERE, replicate);
        for index in 0..points {
            let [_, _, p0, p1] = stream.point(index);
            let sample = texel.sample([p0, p1]);
            let plane = match task.shading {
                Shading::Production => sample.normal,
                Shading::Exact => sample.geometric,
            };
            let tilt = plane
                .cross(sample.normal)
                .length()
                .atan2(plane.dot(sample.normal));
            let lobe = match specular {
                false => 0.0,
                // Nothing of a lobe whose surface stands above its horizon is hidden.
                true if task.model == Model::Ggx => 1.0,
                true => {
                    let axis = task.mirrored_view(sample.position, sample.normal);
                    let (cos, sin) = (plane.dot(axis), plane.cross(axis).length());
                    phong_open(texel.material.exponent, cos, sin)
                }
            };
            let values = [tilted_diffuse(tilt), tilted_visibility(tilt), lobe];
            for (mean, value) in means.iter_mut().zip(values) {
                mean[replicate as usize] += value / f64::from(points);
            }
            directions[0] += tilted_bent(sample.normal, plane) / f64::from(POINTS);
            directions[1] += tilted_mean(sample.normal, plane) / f64::from(POINTS);
        }
    }
    let [diffuse, visibility, specular] = means.map(|means| Estimate {
        value: means.iter().sum::<f64>() / means.len() as f64,
        std_err: variance_of_mean(&means).sqrt(),
    });
    with_light(Terms {
        diffuse,
        visibility,
        specular,
        directional: Directional {
            bent: directions[0],
            light: Directional::even(sky, 0.5 * visibility.value, directions[1]),
        },
        any_view,
        ..Terms::default()
    })
}
