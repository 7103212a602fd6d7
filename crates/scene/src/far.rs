//! Scenes far from the origin: the place that 32-bit coordinates should count from, and what 32 bits have lost.
//!
//! At 100,000 units from the origin neighbouring 32-bit numbers are 1/128 apart, at 5,000,000 half a unit. So
//! the distance is taken off in 64 bits first. It is a multiple of a power of two no less than half of what
//! most of the scene spans, so that 32-bit corners that were modelled far away keep their bits' worth.

use crate::around;
use crate::input::{Input, short};
use crate::{Format, Instance, Mesh, WarningKind};
use glam::{DAffine3, DVec3};

/// What lies farther from the origin than so many times its size is moved.
const FAR: f64 = 8.0;

/// So many points tell where a scene lies, so many triangles how fine a mesh is.
const SAMPLES: usize = 1 << 14;

/// Points in the first or the last sixteenth of all along an axis do not tell where a scene lies: something may
/// have been left at the origin.
const STRAYS: usize = 16;

/// Edges of fewer steps than this, from one 32-bit number to the next, have lost digits: their ends may be off by a
/// 32nd of them.
const STEPS: f64 = 16.0;

/// Evenly spaced ones of so many numbers from 0, enough of them to tell where a scene lies.
pub fn samples(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(SAMPLES).max(1))
}

/// The place that coordinates of these points should count from: 0 where most of them lie near the origin.
///
/// Points that are not finite do not count.
pub fn home(points: impl Iterator<Item = DVec3>) -> DVec3 {
    let points: Vec<DVec3> = points.filter(|point| point.is_finite()).collect();
    let Some(last) = points.len().checked_sub(1) else {
        return DVec3::ZERO;
    };
    let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
    for axis in 0..3 {
        let mut along: Vec<f64> = points.iter().map(|point| point[axis]).collect();
        along.sort_unstable_by(f64::total_cmp);
        low[axis] = along[last / STRAYS];
        high[axis] = along[last - last / STRAYS];
    }
    let (size, middle) = ((high - low).max_element(), 0.5 * (low + high));
    let is_far = middle.abs().max_element() > FAR * size;
    if !(is_far && size > 0.0 && middle.is_finite()) {
        return DVec3::ZERO;
    }
    let step = size.log2().floor().exp2();
    (middle / step).round() * step
}

/// As [`home`], of the vertices of placed meshes.
pub fn home_of<'a>(placed: impl Iterator<Item = (&'a Mesh, &'a DAffine3)>) -> DVec3 {
    let placed: Vec<(&Mesh, &DAffine3)> = placed.collect();
    let ends: Vec<usize> = placed
        .iter()
        .scan(0, |sum, (mesh, _)| {
            *sum += mesh.positions.len();
            Some(*sum)
        })
        .collect();
    let point = |number: usize| {
        let of = ends.partition_point(|&end| end <= number);
        let (mesh, transform) = placed[of];
        let vertex = number + mesh.positions.len() - ends[of];
        transform.transform_point3(mesh.positions[vertex].as_dvec3())
    };
    home(samples(ends.last().copied().unwrap_or(0)).map(point))
}

/// Tells of meshes whose 32-bit coordinates lie so far from their origin that details are lost, and of objects
/// that lie so far from the others that rays lose them.
pub(crate) fn warn(input: &mut Input, format: Format, meshes: &[Mesh], instances: &[Instance]) {
    let homes = home_of(
        instances
            .iter()
            .map(|instance| (&meshes[instance.mesh as usize], &instance.transform)),
    );
    let fine: Vec<f64> = meshes.iter().map(edge).collect();
    // The text of an OBJ file loses nothing: its coordinates are 32-bit numbers only after the distance is taken off.
    let own = meshes.iter().zip(&fine).filter(|_| format != Format::Obj);
    let mut lost = own.filter_map(|(mesh, &edge)| {
        let reach = reach(mesh, DAffine3::IDENTITY);
        (spacing(reach) * STEPS > edge).then_some((mesh, reach, edge))
    });
    if let Some((mesh, reach, edge)) = lost.next() {
        let message = format!(
            "32-bit coordinates near {reach:.0} are {:.1e} apart, and half of the triangles have an edge under \
             {edge:.1e}: finer digits are lost in the file; export the mesh about its own origin, and let its node \
             stand far away",
            spacing(reach)
        );
        let (place, count) = (
            format!("mesh `{}`", short(&mesh.name)),
            1 + lost.count() as u64,
        );
        input.warn(WarningKind::LostDigits, place, count, message);
    }
    let mut apart = instances.iter().filter_map(|instance| {
        let mesh = &meshes[instance.mesh as usize];
        let mut near = instance.transform;
        near.translation -= homes;
        let m = near.matrix3;
        let scale = m
            .x_axis
            .length()
            .max(m.y_axis.length())
            .max(m.z_axis.length());
        let reach = reach(mesh, near);
        let edge = fine[instance.mesh as usize] * scale;
        (spacing(reach) * STEPS > edge).then_some((instance, reach))
    });
    if let Some((instance, reach)) = apart.next() {
        let message = format!(
            "it lies {reach:.0} units from most of the scene, where rays tell places {:.1e} apart: finer shapes bake \
             as they are rounded; bake what lies so far apart as scenes of their own",
            spacing(reach)
        );
        let (place, count) = (
            format!("object `{}`", short(&instance.name)),
            1 + apart.count() as u64,
        );
        input.warn(WarningKind::FarApart, place, count, message);
    }
}

/// The largest absolute coordinate of a placed mesh, at most.
fn reach(mesh: &Mesh, transform: DAffine3) -> f64 {
    let (low, high) = around(mesh.positions.iter().map(|p| p.as_dvec3()));
    let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let m = transform.matrix3;
    let around = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
    (transform.transform_point3(middle).abs() + around).max_element()
}

/// The median over the triangles of their shortest edge.
fn edge(mesh: &Mesh) -> f64 {
    let mut edges: Vec<f64> = samples(mesh.triangles.len())
        .map(|triangle| {
            let [a, b, c] = mesh.triangles[triangle].map(|v| mesh.positions[v as usize].as_dvec3());
            (b - a).length().min((c - b).length()).min((a - c).length())
        })
        .collect();
    let middle = edges.len() / 2;
    match edges.is_empty() {
        true => 0.0,
        false => *edges.select_nth_unstable_by(middle, f64::total_cmp).1,
    }
}

/// The distance from one 32-bit number to the next.
fn spacing(value: f64) -> f64 {
    let value = value as f32;
    f64::from(value.next_up()) - f64::from(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cluster(at: DVec3, count: usize) -> impl Iterator<Item = DVec3> {
        (0..count).map(move |k| at + DVec3::new((k % 5) as f64, (k % 3) as f64, (k % 7) as f64))
    }

    #[test]
    fn home_is_near_most_points_a_whole_number_of_steps_away() {
        let far = DVec3::new(4.2e6, -3e5, 20.25);
        let found = home(cluster(far, 100));
        assert!((found - far).abs().max_element() <= 6.0, "{found}");
        assert_eq!(found, (found / 4.0).round() * 4.0, "{found}");
        // Few strays do not count, wherever they are, nor does what is no place.
        let strays = cluster(DVec3::ZERO, 5).chain([DVec3::NAN, DVec3::splat(1e30)]);
        let with = home(cluster(far, 100).chain(strays));
        assert!((with - far).abs().max_element() <= 6.0, "{with}");
    }

    #[test]
    fn what_lies_near_the_origin_counts_from_it() {
        assert_eq!(
            home(cluster(DVec3::new(30.0, 1.0, -40.0), 100)),
            DVec3::ZERO
        );
        let half = cluster(DVec3::ZERO, 50).chain(cluster(DVec3::X * 1e6, 50));
        assert_eq!(home(half), DVec3::ZERO);
        assert_eq!(home(std::iter::empty()), DVec3::ZERO);
        assert_eq!(
            home([DVec3::X; 9].into_iter()),
            DVec3::ZERO,
            "it has no size"
        );
    }

    #[test]
    fn samples_are_all_of_few_and_some_of_many() {
        assert_eq!(samples(3).collect::<Vec<_>>(), [0, 1, 2]);
        let many = samples(1_000_000).count();
        assert!((SAMPLES / 2..=SAMPLES).contains(&many), "{many}");
        assert_eq!(samples(0).count(), 0);
    }
}
