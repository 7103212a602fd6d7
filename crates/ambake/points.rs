//! Points that are spread evenly over the surface of an object.

use atlas::{ObjectName, SurfacePoint};
use rays::World;

/// Steps that fill a square evenly: the inverse of the plastic ratio, and its square.
pub(crate) const PLASTIC: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

/// The surface of an object, in square scene units.
pub(crate) fn area(world: &World, object: &ObjectName) -> f64 {
    triangles(world, object).map(|of| of.2).sum()
}

/// At most so many points of an object, each for an equal share of its surface; none where that has no area.
pub(crate) fn points_on(world: &World, object: &ObjectName, count: u32) -> Vec<SurfacePoint> {
    let step = area(world, object) / f64::from(count);
    let (mut along, mut points) = (0.0, Vec::new());
    for (instance, triangle, area) in triangles(world, object) {
        along += area;
        while (points.len() as f64 + 0.5) * step < along && points.len() < count as usize {
            // The root makes a triangle of the square.
            let k = points.len() as f64;
            let [u, v] = PLASTIC.map(|by| (0.5 + k * by).fract());
            let root = u.sqrt();
            points.push(SurfacePoint {
                instance,
                triangle,
                weights: [1.0 - root, root * (1.0 - v), root * v],
            });
        }
    }
    points
}

/// Instance, triangle and area of all triangles of an object.
fn triangles<'a>(
    world: &'a World,
    object: &'a ObjectName,
) -> impl Iterator<Item = (u32, u32, f64)> + 'a {
    object.instances.iter().flat_map(move |&instance| {
        let count = world.part(instance).1.triangles().len() as u32;
        (0..count).map(move |triangle| {
            let [a, b, c] = world.corners(instance, triangle);
            (instance, triangle, 0.5 * (b - a).cross(c - a).length())
        })
    })
}
