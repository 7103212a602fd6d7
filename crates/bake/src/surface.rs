//! Points on surfaces: position, normals, and a ray origin that cannot meet its own surface.
//!
//! **Ray origins.** No bias is set by a user. A sample's origin is moved along the geometric normal by a bound on the
//! rounding that a ray query can suffer, so that the own triangle and its coplanar neighbours are missed, and by no
//! more. The bound follows the arithmetic of a Plücker test as Embree and our obvhs test do it: corners are
//! translated to the origin, `T = v0 . (e1 x e2)` decides on which side the plane lies. With unit roundoff u = 2^-24,
//! edges no longer than the triangle's box (X, Y, Z), standard running error analysis (Higham, *Accuracy and Stability
//! of Numerical Algorithms*, 2002, section 3) gives `|error(T)| <= 78 u X Y Z`, so a distance of `78 u XYZ / |e1 x e2|`.
//! For an axis-aligned triangle the box is flat and the bound is exactly 0: the origin lies in the plane, where the
//! open end of the ray interval excludes it. Rounding of the origin itself adds `|n_i| ulp(o_i)` on the axes in which
//! the triangle has extent, and an instance's transform adds its own rounding.

use crate::world::World;
use glam::DVec3;

/// Unit roundoff of f32.
const UNIT_ROUNDOFF: f64 = 1.0 / 16_777_216.0;

/// Factor of the running error bound of `T`, see the head of this file.
const PLANE_ERROR: f64 = 78.0;

/// One triangle of an object, in world space, with what sampling it needs.
#[derive(Debug, Clone)]
pub(crate) struct Patch {
    pub instance: u32,
    pub triangle: u32,
    pub corners: [DVec3; 3],
    /// Corner shading normals; `None` shades flat.
    normals: Option<[DVec3; 3]>,
    /// Unit geometric normal, right-hand rule of the winding.
    geometric: DVec3,
    low: DVec3,
    high: DVec3,
    /// Rounding bound of the plane test as a distance, over this triangle and its neighbours.
    plane_error: f64,
    transform_error: f64,
}

/// A sample point of a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub position: DVec3,
    /// Unit shading normal.
    pub normal: DVec3,
    /// Unit geometric normal, on the side of the shading normal.
    pub geometric: DVec3,
    /// Ray origin in f32.
    pub origin: [f32; 3],
}

/// Per-vertex bounds of the plane test over the incident triangles, for every geometry of a world.
#[derive(Debug)]
pub(crate) struct PlaneErrors(Vec<Vec<f32>>);

impl PlaneErrors {
    /// Bounds of all vertices. Neighbours are those that share a vertex index.
    pub fn of(world: &World) -> Self {
        Self(
            world
                .geometries
                .iter()
                .map(|geometry| {
                    let mut bounds = vec![0.0f32; geometry.positions.len()];
                    for triangle in geometry.triangles() {
                        let corners = triangle.map(|v| geometry.positions[v as usize].as_dvec3());
                        let bound = box_over_area(&corners) as f32;
                        for &vertex in triangle {
                            let slot = &mut bounds[vertex as usize];
                            *slot = slot.max(bound);
                        }
                    }
                    bounds
                })
                .collect(),
        )
    }
}

/// Box volume over twice the area: the length that scales a triangle's plane error. 0 for a triangle without area.
fn box_over_area(corners: &[DVec3; 3]) -> f64 {
    let twice_area = (corners[1] - corners[0])
        .cross(corners[2] - corners[0])
        .length();
    let extent = extent(corners);
    let volume = extent.x * extent.y * extent.z;
    if volume > 0.0 && twice_area > 0.0 {
        volume / twice_area
    } else {
        0.0
    }
}

fn extent(corners: &[DVec3; 3]) -> DVec3 {
    corners[0].max(corners[1]).max(corners[2]) - corners[0].min(corners[1]).min(corners[2])
}

impl Patch {
    /// The triangle as the rays see it.
    pub fn of(world: &World, errors: &PlaneErrors, instance: u32, triangle: u32) -> Self {
        let corners = world.corners(instance, triangle);
        let normals = world.normals(instance, triangle);
        let (part, geometry) = world.part(instance);
        let indices = geometry.triangles()[triangle as usize];
        let bounds = &errors.0[part.geometry as usize];
        let bound = indices
            .iter()
            .map(|&v| f64::from(bounds[v as usize]))
            .fold(0.0, f64::max);
        let face = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let sense = if part.mirrors() { -1.0 } else { 1.0 };
        let fallback = normals.map_or(DVec3::Z, |n| {
            (n[0] + n[1] + n[2]).try_normalize().unwrap_or(DVec3::Z)
        });
        let geometric = (face * sense).try_normalize().unwrap_or(fallback);
        Self {
            instance,
            triangle,
            corners,
            normals,
            geometric,
            low: corners[0].min(corners[1]).min(corners[2]),
            high: corners[0].max(corners[1]).max(corners[2]),
            plane_error: PLANE_ERROR * UNIT_ROUNDOFF * bound * part.stretch(),
            transform_error: part.rounding(geometric, &corners),
        }
    }

    /// True where the shading normal is the geometric normal all over the triangle.
    pub fn is_flat(&self) -> bool {
        self.normals
            .is_none_or(|normals| normals.iter().all(|n| n.dot(self.geometric) >= 1.0 - 1e-12))
    }

    /// The unit geometric normal on the side of the shading normals.
    pub fn upward(&self) -> DVec3 {
        match self.normals {
            Some(n) if (n[0] + n[1] + n[2]).dot(self.geometric) < 0.0 => -self.geometric,
            _ => self.geometric,
        }
    }

    /// How far above its plane rounding can put a point of this triangle, in scene units.
    pub fn rounding(&self) -> f64 {
        let reach = self.low.abs().max(self.high.abs());
        self.plane_error + self.transform_error + self.origin_rounding(reach)
    }

    fn origin_rounding(&self, position: DVec3) -> f64 {
        let extent = self.high - self.low;
        let mut sum = 0.0;
        for axis in 0..3 {
            if extent[axis] > 0.0 {
                sum += self.geometric[axis].abs() * position[axis].abs();
            }
        }
        UNIT_ROUNDOFF * sum
    }

    /// The point with these corner weights (which sum to 1).
    pub fn sample(&self, weights: [f64; 3]) -> Sample {
        let [a, b, c] = self.corners;
        let position =
            (a * weights[0] + b * weights[1] + c * weights[2]).clamp(self.low, self.high);
        let normal = match self.normals {
            None => self.geometric,
            Some(n) => (n[0] * weights[0] + n[1] * weights[1] + n[2] * weights[2])
                .try_normalize()
                .unwrap_or(self.geometric),
        };
        let geometric = if normal.dot(self.geometric) < 0.0 {
            -self.geometric
        } else {
            self.geometric
        };
        let offset = self.plane_error + self.transform_error + self.origin_rounding(position.abs());
        let lifted = position + geometric * offset;
        let mut origin = [0.0f32; 3];
        for axis in 0..3 {
            let rounded = round_toward(lifted[axis], position[axis], geometric[axis], offset);
            origin[axis] = if lifted[axis] == position[axis] {
                keep_inside(rounded, self.low[axis], self.high[axis])
            } else {
                rounded
            };
        }
        Sample {
            position,
            normal,
            geometric,
            origin,
        }
    }
}

/// `value`, or its neighbour inside `low..high` where it was rounded onto a limit: there a wall may stand whose plane
/// would then hold the origin, and the open end of the ray interval would let rays through it.
fn keep_inside(value: f32, low: f64, high: f64) -> f32 {
    let (up, down) = (value.next_up(), value.next_down());
    if f64::from(value) >= high && f64::from(down) > low {
        down
    } else if f64::from(value) <= low && f64::from(up) < high {
        up
    } else {
        value
    }
}

/// `lifted` in f32, rounded to the nearest where it stands still on this axis and away from the surface otherwise.
fn round_toward(lifted: f64, position: f64, normal: f64, offset: f64) -> f32 {
    let nearest = lifted as f32;
    if offset == 0.0 || lifted == position {
        return nearest;
    }
    if normal > 0.0 && f64::from(nearest) < lifted {
        nearest.next_up()
    } else if normal < 0.0 && f64::from(nearest) > lifted {
        nearest.next_down()
    } else {
        nearest
    }
}
