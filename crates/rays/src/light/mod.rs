//! Suns, point lights, luminous balls and panels on a surface: albedo over π, clamped cosine.
//!
//! The diffuse part is the Lambertian model of the diffuse-shading chapter (Scratchapixel): `albedo / π · E · max(N·L,
//! 0)`, which reflects no more than arrives. The specular part is equation (7) of X. Zhang, Y. Gao, ICIP 2009, in the
//! normalisation of the ambient term, so that a sky full of lights gives that term: `(n+1)/2π (R·L)ⁿ E`.

#[cfg(test)]
mod tests;

use crate::material::PhongMaterial;
use ambient::closed_form::ball;
use ambient::convention::{PROJECTED_HEMISPHERE, lobe_scale};
use glam::DVec3;
use scene::LightKind;
use std::f64::consts::TAU;

/// A light that no ray meets. Strengths are linear RGB.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// So far away that its rays are parallel.
    Distant {
        /// Unit vector to the light.
        toward: DVec3,
        /// Irradiance of a surface that faces it, W·m⁻².
        irradiance: DVec3,
    },
    /// At a point; what arrives falls with the square of the distance.
    Point {
        /// World position.
        position: DVec3,
        /// Radiant intensity, W·sr⁻¹: irradiance times distance squared.
        intensity: DVec3,
        /// Whither it shines; `None` for every direction.
        cone: Option<Cone>,
        /// Distance from which on it lights nothing; infinite for none. Toward it light falls by `1 - (distance /
        /// range)⁴` more.
        range: f64,
    },
    /// A ball that sends the same radiance from all of its surface. Within it is no light.
    Sphere {
        /// World position of its middle.
        position: DVec3,
        /// Its radius in scene units, above 0.
        radius: f64,
        /// W·m⁻²·sr⁻¹.
        radiance: DVec3,
    },
    /// A rectangle, or a parallelogram, that sends the same radiance from all of one side.
    Rect {
        /// World position of a corner.
        corner: DVec3,
        /// The sides from there. It shines where their cross product points to.
        sides: [DVec3; 2],
        /// W·m⁻²·sr⁻¹.
        radiance: DVec3,
    },
}

/// The cone of a spot light: all of its light within the inner angle, none beyond the outer one.
///
/// Between them it falls as section "Inner and Outer Cone Angles" of the glTF extension KHR_lights_punctual has it: by
/// the square of what
/// the cosine has left to go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Unit vector along which it shines.
    pub axis: DVec3,
    /// Cosines of the inner and the outer angle, the first at least the second.
    pub cosines: [f64; 2],
}

impl Cone {
    /// The share of the light that goes in a unit direction, 0..=1.
    pub fn share(&self, direction: DVec3) -> f64 {
        /// Cones with a sharper border than this have this one.
        const LEAST: f64 = 0.001;
        let [inner, outer] = self.cosines;
        let part = (self.axis.dot(direction) - outer) / (inner - outer).max(LEAST);
        part.clamp(0.0, 1.0).powi(2)
    }
}

/// Light that arrives at a point, or an estimate of it by one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// Unit vector to the light, or to the point of it that was drawn.
    pub toward: DVec3,
    /// Distance to it; infinite for a distant light.
    pub distance: f64,
    /// Irradiance of a surface that faces it, linear RGB; of a light with extent what it would be if all came
    /// from that direction, whose mean over all draws, each with its own cosine, is exact.
    pub irradiance: DVec3,
}

impl Light {
    /// A distant light in a direction of any length, with the irradiance of a surface that faces it. No direction, no
    /// unit vector.
    pub fn sun(direction: [f64; 3], irradiance: [f64; 3]) -> Self {
        Self::Distant {
            toward: DVec3::from(direction).normalize_or_zero(),
            irradiance: irradiance.into(),
        }
    }

    /// A point light of so much radiant intensity.
    pub fn point(position: [f64; 3], intensity: [f64; 3]) -> Self {
        Self::Point {
            position: position.into(),
            intensity: intensity.into(),
            cone: None,
            range: f64::INFINITY,
        }
    }

    /// A ball of this radius that sends this radiance.
    pub fn sphere(position: [f64; 3], radius: f64, radiance: [f64; 3]) -> Self {
        Self::Sphere {
            position: position.into(),
            radius,
            radiance: radiance.into(),
        }
    }

    /// A rectangle with a corner here and these sides, which shines where their cross product points to.
    pub fn rect(corner: [f64; 3], sides: [[f64; 3]; 2], radiance: [f64; 3]) -> Self {
        Self::Rect {
            corner: corner.into(),
            sides: sides.map(DVec3::from),
            radiance: radiance.into(),
        }
    }

    /// A place that it lights; `None` where it is distant.
    pub fn place(&self) -> Option<DVec3> {
        match *self {
            Self::Distant { .. } => None,
            Self::Point { position, .. } | Self::Sphere { position, .. } => Some(position),
            // Before the side that shines: it may lie in a wall.
            Self::Rect {
                corner,
                sides: [a, b],
                ..
            } => {
                let before = 0.01 * a.length().max(b.length());
                let toward = a.cross(b).normalize_or_zero();
                Some(corner + 0.5 * (a + b) + before * toward)
            }
        }
    }

    /// True where the direction to it depends on what is drawn.
    pub fn has_extent(&self) -> bool {
        matches!(self, Self::Sphere { .. } | Self::Rect { .. })
    }

    /// The same light where coordinates count from `origin`.
    pub fn from_origin(mut self, origin: DVec3) -> Self {
        match &mut self {
            Self::Distant { .. } => {}
            Self::Point { position, .. }
            | Self::Sphere { position, .. }
            | Self::Rect {
                corner: position, ..
            } => *position -= origin,
        }
        self
    }

    /// E/π that a surface at this point, of this unit normal, receives from the whole light where nothing hides any of
    /// it; `None` where only its directions tell ([`Light::at`]).
    pub fn open(&self, point: DVec3, normal: DVec3) -> Option<DVec3> {
        let Light::Sphere {
            position,
            radius,
            radiance,
        } = *self
        else {
            return None;
        };
        let to = position - point;
        let distance = to.length();
        // Nothing arrives within the ball itself, as in `at`.
        let outside = distance > radius;
        let share = || ball(to.dot(normal) / distance, (radius / distance).powi(2));
        Some(if outside {
            radiance * share()
        } else {
            DVec3::ZERO
        })
    }

    /// What arrives at a point of empty space; no light at the place of a point light itself.
    ///
    /// * `u`: a point of the unit square that draws the direction to a light with extent. Balls are drawn by
    ///   solid angle, rectangles by area.
    pub fn at(&self, point: DVec3, u: [f64; 2]) -> Arrival {
        match *self {
            Light::Sphere {
                position,
                radius,
                radiance,
            } => from_ball(position - point, radius, radiance, u),
            Light::Rect {
                corner,
                sides: [a, b],
                radiance,
            } => {
                let to = corner + a * u[0] + b * u[1] - point;
                let (square, toward) = (to.length_squared(), to.normalize_or_zero());
                let seen = -a.cross(b).dot(toward);
                Arrival {
                    toward,
                    distance: square.sqrt(),
                    irradiance: match square > 0.0 && seen > 0.0 {
                        true => radiance * (seen / square),
                        false => DVec3::ZERO,
                    },
                }
            }
            Light::Distant { toward, irradiance } => Arrival {
                toward,
                distance: f64::INFINITY,
                irradiance,
            },
            Light::Point {
                position,
                intensity,
                cone,
                range,
            } => {
                let to = position - point;
                let (square, toward) = (to.length_squared(), to.normalize_or_zero());
                let near = (1.0 - (square / range.powi(2)).powi(2)).max(0.0);
                let share = cone.map_or(1.0, |cone| cone.share(-toward)) * near;
                Arrival {
                    toward,
                    distance: square.sqrt(),
                    irradiance: match square > 0.0 {
                        true => intensity * (share / square),
                        false => DVec3::ZERO,
                    },
                }
            }
        }
    }
}

/// What arrives from a luminous ball whose middle is at `to`, by one direction of the cone that it fills.
fn from_ball(to: DVec3, radius: f64, radiance: DVec3, u: [f64; 2]) -> Arrival {
    let distance = to.length();
    if distance <= radius {
        return Arrival {
            toward: to.normalize_or_zero(),
            distance,
            irradiance: DVec3::ZERO,
        };
    }
    let axis = to / distance;
    let square = (radius / distance).powi(2);
    // 1 - cos of the cone's half angle, and of the direction's: exact however far the ball is.
    let cone = square / (1.0 + (1.0 - square).sqrt());
    let off = u[0] * cone;
    let (cosine, sine) = (1.0 - off, (off * (2.0 - off)).sqrt());
    let (y, x) = (TAU * u[1]).sin_cos();
    let (a, b) = axis.any_orthonormal_pair();
    let half_chord = (radius.powi(2) - (distance * sine).powi(2)).max(0.0).sqrt();
    Arrival {
        toward: (axis * cosine + (a * x + b * y) * sine).normalize(),
        distance: distance * cosine - half_chord,
        irradiance: radiance * (TAU * cone),
    }
}

/// A light of a file: its lux and candela are taken for W·m⁻² and W·sr⁻¹.
impl From<&scene::Light> for Light {
    fn from(light: &scene::Light) -> Self {
        let cone = match light.kind {
            LightKind::Directional => {
                return Self::Distant {
                    toward: -light.direction,
                    irradiance: light.strength,
                };
            }
            LightKind::Point => None,
            LightKind::Spot { inner, outer } => Some(Cone {
                axis: light.direction,
                cosines: [inner.cos(), outer.cos()],
            }),
        };
        Self::Point {
            position: light.position,
            intensity: light.strength,
            cone,
            range: light.range,
        }
    }
}

impl Arrival {
    /// Radiance that a Lambertian surface of this albedo and unit normal sends in every direction.
    pub fn diffuse(&self, normal: DVec3, albedo: DVec3) -> DVec3 {
        albedo * self.irradiance * (normal.dot(self.toward).max(0.0) / PROJECTED_HEMISPHERE)
    }

    /// Radiance that the Phong lobe about `mirror`, the mirrored view, adds; 0 for a light below the surface, or at
    /// right angles to `mirror` and beyond.
    pub fn specular(&self, normal: DVec3, mirror: DVec3, material: &PhongMaterial) -> DVec3 {
        let along = mirror.dot(self.toward);
        // An exponent of 0 does not make the other half of the sphere shine.
        if normal.dot(self.toward) <= 0.0 || along <= 0.0 {
            return DVec3::ZERO;
        }
        let lobe = along.powf(material.exponent);
        material.specular * self.irradiance * (lobe_scale(material.exponent) * lobe)
    }
}
