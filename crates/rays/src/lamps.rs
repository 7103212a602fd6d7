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

    /// The triangles of a world whose material shines; both sides of them do.
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
            if radiance == 0.0 {
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

    /// Probability per steradian that a ray of the unit direction `toward` is aimed at this hit; infinite where it grazes, 0 where the
    /// surface does not shine.
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
