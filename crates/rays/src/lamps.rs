//! Surfaces that shine, and rays aimed at them.
//!
//! Rays over a hemisphere rarely meet a small lamp. As many rays are therefore aimed at points of the luminous
//! triangles, chosen by area times radiance, and both are weighed by the balance heuristic of E. Veach, L. Guibas,
//! "Optimally Combining Sampling Techniques for Monte Carlo Rendering" (1995): neither a small lamp nor a near one is
//! noisy, and nothing is counted twice. A ray whose rounding takes it over its triangle's edge is lost: 1e-7 of the
//! distance from the rim of a lamp.

use crate::backend::SurfaceHit;
use crate::material::mean_emission;
use crate::world::World;
use glam::DVec3;

/// The luminous triangles of a world.
#[derive(Debug, Clone, PartialEq)]
pub struct Lamps {
    /// Radiance of each of the scene's materials, its picture averaged, all channels together.
    radiance: Vec<f64>,
    triangles: Vec<Place>,
    /// Running sum over the triangles of area times radiance, all channels together.
    power: Vec<f64>,
}

/// Instance and triangle.
type Place = (u32, u32);

impl Lamps {
    /// Nothing shines.
    pub const NONE: Lamps = Lamps {
        radiance: Vec::new(),
        triangles: Vec::new(),
        power: Vec::new(),
    };

    /// The triangles of a world whose material shines. Rays are aimed at both sides of them, whether both shine or not.
    pub fn of(world: &World) -> Lamps {
        let scene = world.scene();
        let mut lamps = Lamps {
            radiance: (0..scene.materials.len())
                .map(|material| mean_emission(scene, material as u32).element_sum())
                .collect(),
            ..Lamps::NONE
        };
        let mut total = 0.0;
        for (instance, placed) in scene.instances.iter().enumerate() {
            let mesh = &scene.meshes[placed.mesh as usize];
            let radiance = lamps.radiance[mesh.material as usize];
            if radiance == 0.0 || !placed.casts {
                continue;
            }
            for triangle in 0..mesh.triangles.len() {
                let place = (instance as u32, triangle as u32);
                total += 0.5 * face(world, place).length() * radiance;
                lamps.triangles.push(place);
                lamps.power.push(total);
            }
        }
        lamps
    }

    /// True where nothing shines.
    pub fn is_empty(&self) -> bool {
        self.total() == 0.0
    }

    /// A point of a luminous triangle for a point of the unit square; something must shine.
    pub fn sample(&self, world: &World, u: [f64; 2]) -> (Place, DVec3) {
        let wanted = u[0] * self.total();
        let chosen = self.power.partition_point(|sum| *sum <= wanted);
        let before = chosen.checked_sub(1).map_or(0.0, |last| self.power[last]);
        // The place within the triangle's share is a fresh number.
        let along = (wanted - before) / (self.power[chosen] - before);
        let place = self.triangles[chosen];
        let [a, b, c] = world.corners(place.0, place.1);
        let root = along.sqrt();
        (
            place,
            a * (1.0 - root) + b * (root * (1.0 - u[1])) + c * (root * u[1]),
        )
    }

    /// Probability per steradian that a ray of the unit direction `toward` is aimed at this hit; infinite where it
    /// grazes, 0 where the surface does not shine.
    pub fn pdf(&self, world: &World, hit: &SurfaceHit, toward: DVec3) -> f64 {
        let radiance = self.radiance[world.part(hit.instance).1.mesh().material as usize];
        if radiance == 0.0 {
            return 0.0;
        }
        let normal = face(world, (hit.instance, hit.triangle)).normalize_or_zero();
        let by_area = radiance / self.total();
        by_area * f64::from(hit.t).powi(2) / normal.dot(toward).abs()
    }

    fn total(&self) -> f64 {
        self.power.last().copied().unwrap_or(0.0)
    }
}

/// Normal of a triangle, twice its area long.
fn face(world: &World, (instance, triangle): Place) -> DVec3 {
    let [a, b, c] = world.corners(instance, triangle);
    (b - a).cross(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use glam::Vec3;

    #[test]
    fn points_are_spread_evenly_over_all_that_shines() {
        let mut scene = fixture::scene(vec![fixture::square(2.0), fixture::square(5.0)]);
        scene.materials[0].emission = Vec3::ONE;
        let world = fixture::world(scene);
        let lamps = Lamps::of(&world);
        let across = 128i32;
        let mut quarters = [[0i32; 4]; 2];
        for i in 0..across * across {
            let u = [i % across, i / across].map(|k| (f64::from(k) + 0.5) / f64::from(across));
            let (place, at) = lamps.sample(&world, u);
            assert!((at.z - [2.0, 5.0][place.0 as usize]).abs() < 1e-12, "{at}");
            assert!(
                at.x.abs() <= 1.0 + 1e-12 && at.y.abs() <= 1.0 + 1e-12,
                "{at}"
            );
            quarters[place.0 as usize][usize::from(at.x > 0.0) + 2 * usize::from(at.y > 0.0)] += 1;
        }
        // Two squares of four quarters, and what a quarter's border cuts of 128 points along it.
        let expected = across * across / 8;
        for count in quarters.as_flattened() {
            assert!(
                (count - expected).abs() <= 2 * across,
                "{quarters:?}, not {expected}"
            );
        }
    }

    /// The mean of one over the density, over points that are even over a lamp, is the solid angle that it fills.
    #[test]
    fn the_density_of_a_lamp_is_even_over_the_solid_angle_that_it_fills() {
        for height in [0.5f32, 2.0] {
            let mut scene = fixture::scene(vec![fixture::square(height)]);
            scene.materials[0].emission = Vec3::ONE;
            let world = fixture::world(scene);
            let lamps = Lamps::of(&world);
            let across = 256i32;
            let of_point = |i: i32| {
                let u = [i % across, i / across].map(|k| (f64::from(k) + 0.5) / f64::from(across));
                let ((instance, triangle), at) = lamps.sample(&world, u);
                let hit = SurfaceHit {
                    t: at.length() as f32,
                    instance,
                    triangle,
                    barycentric: [0.0; 2],
                    front: false,
                };
                1.0 / lamps.pdf(&world, &hit, at.normalize())
            };
            let count = across * across;
            let found = (0..count).map(of_point).sum::<f64>() / f64::from(count);
            // A square of the half edge 1 above its middle.
            let square = 1.0 + f64::from(height).powi(2);
            let exact = 4.0 * (1.0 / square).asin();
            assert!((found / exact - 1.0).abs() < 1e-3, "{found}, not {exact}");
        }
    }
}
