//! Suns, point lights, luminous balls and panels on a surface: albedo over π, clamped cosine.
//!
//! The diffuse part is the Lambertian model of the diffuse-shading chapter (Scratchapixel): `albedo / π · E · max(N·L,
//! 0)`, which reflects no more than arrives. The specular part is equation (7) of X. Zhang, Y. Gao, ICIP 2009, in the
//! normalisation of the ambient term, so that a sky full of lights gives that term: `(n+1)/2π (R·L)ⁿ E`.

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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_facing_light_of_irradiance_pi_shows_the_albedo() {
        let albedo = DVec3::new(0.5, 0.25, 1.0);
        let sun = Light::Distant {
            toward: DVec3::Z,
            irradiance: DVec3::splat(PI),
        };
        let arrival = sun.at(DVec3::ZERO, [0.5; 2]);
        assert_eq!(arrival.diffuse(DVec3::Z, albedo), albedo);
        assert_eq!(arrival.diffuse(DVec3::NEG_Z, albedo), DVec3::ZERO);
        assert_eq!(arrival.diffuse(DVec3::X, albedo), DVec3::ZERO);
        let slant = DVec3::new(0.8, 0.0, 0.6);
        assert_eq!(arrival.diffuse(slant, albedo), albedo * 0.6);
    }

    #[test]
    fn a_point_light_falls_with_the_square_of_the_distance() {
        let lamp = Light::point([0.0, 0.0, 4.0], [8.0, 4.0, 0.0]);
        let arrival = lamp.at(DVec3::ZERO, [0.5; 2]);
        assert_eq!(arrival.irradiance, DVec3::new(0.5, 0.25, 0.0));
        assert_eq!(arrival.distance, 4.0);
        assert_eq!(
            lamp.at(DVec3::new(0.0, 0.0, 4.0), [0.5; 2]).irradiance,
            DVec3::ZERO
        );
    }

    /// The mean over all draws of what a surface of this unit normal at the origin receives.
    fn received(light: &Light, normal: DVec3) -> f64 {
        const CELLS: usize = 400;
        let middle = |k: usize| (k as f64 + 0.5) / CELLS as f64;
        let of = |cell: usize| {
            let u = [middle(cell / CELLS), middle(cell % CELLS)];
            let arrival = light.at(DVec3::ZERO, u);
            arrival.irradiance.x * normal.dot(arrival.toward).max(0.0)
        };
        (0..CELLS * CELLS).map(of).sum::<f64>() / (CELLS * CELLS) as f64
    }

    #[test]
    fn a_ball_above_the_horizon_brings_pi_times_the_square_of_its_sine_times_the_cosine() {
        for (distance, radius, degrees) in [
            (2.0, 1.0, 0.0),
            (2.0, 1.0, 50.0),
            (1.001, 1.0, 0.0),
            (1e4, 0.5, 80.0_f64),
        ] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let place = [distance * sine, 0.0, distance * cosine];
            let ball = Light::sphere(place, radius, [3.0; 3]);
            let exact = PI * 3.0 * (radius / distance).powi(2) * cosine;
            let found = received(&ball, DVec3::Z);
            assert!(
                (found / exact - 1.0).abs() < 1e-5,
                "{distance} {degrees}: {found}, not {exact}"
            );
        }
        // Half below the horizon, by J. R. Howell's catalogue of configuration factors.
        let half = Light::sphere([2.0, 0.0, 0.0], 1.0, [1.0; 3]);
        let (h, root) = (2.0_f64, 3.0_f64.sqrt());
        let exact = (1.0 / root).atan() - root / (h * h);
        let found = received(&half, DVec3::Z);
        assert!((found / exact - 1.0).abs() < 1e-4, "{found}, not {exact}");
        // The way ends on the ball, and within it is no light.
        let arrival = Light::sphere([0.0, 0.0, 4.0], 1.0, [1.0; 3]).at(DVec3::ZERO, [0.0, 0.0]);
        assert!((arrival.distance - 3.0).abs() < 1e-12, "{arrival:?}");
        let within = Light::sphere([0.1, 0.0, 0.0], 1.0, [1.0; 3]);
        assert_eq!(within.at(DVec3::ZERO, [0.5; 2]).irradiance, DVec3::ZERO);
        let found = within.open(DVec3::ZERO, DVec3::X);
        assert_eq!(found, Some(DVec3::ZERO));
        let ball = Light::sphere([0.0, 0.0, 4.0], 1.0, [3.0; 3]);
        let found = ball.open(DVec3::ZERO, DVec3::Z).expect("a ball").x;
        assert!((found - 3.0 / 16.0).abs() < 1e-12, "{found}");
    }

    #[test]
    fn lights_of_a_file_are_taken_at_their_strength_and_shine_where_it_says() {
        let light = |kind| scene::Light {
            name: String::new(),
            kind,
            strength: DVec3::new(3.0, 2.0, 1.0),
            range: 5.0,
            position: DVec3::new(0.0, 0.0, 2.0),
            direction: DVec3::NEG_Z,
        };
        let sun = Light::from(&light(LightKind::Directional));
        let exact = Light::sun([0.0, 0.0, 1.0], [3.0, 2.0, 1.0]);
        assert_eq!(sun, exact);
        let (inner, outer) = (0.2, 0.6);
        let spot = Light::from(&light(LightKind::Spot { inner, outer }));
        // Below it at a distance of 2 of 5: a quarter of its candela, less the share of the range.
        let found = spot.at(DVec3::ZERO, [0.5; 2]).irradiance;
        let exact = DVec3::new(3.0, 2.0, 1.0) / 4.0 * (1.0 - (2.0f64 / 5.0).powi(4));
        assert!(found.abs_diff_eq(exact, 1e-12), "{found}, not {exact}");
        let above = DVec3::new(0.0, 0.0, 3.0);
        assert_eq!(spot.at(above, [0.5; 2]).irradiance, DVec3::ZERO);
    }

    #[test]
    fn a_rectangle_brings_its_form_factor_and_nothing_behind_itself() {
        // One corner straight above, at height 1.5: a parallel rectangle of 2 by 1.
        let (height, a, b) = (1.5, 2.0, 1.0);
        let sides = [[0.0, b, 0.0], [a, 0.0, 0.0]];
        let panel = Light::rect([0.0, 0.0, height], sides, [2.0; 3]);
        let part = |x: f64, y: f64| x / x.hypot(1.0) * (y / x.hypot(1.0)).atan();
        let (x, y) = (a / height, b / height);
        let exact = 2.0 * 0.5 * (part(x, y) + part(y, x));
        let found = received(&panel, DVec3::Z);
        assert!((found / exact - 1.0).abs() < 1e-5, "{found}, not {exact}");
        let turned = Light::rect([0.0, 0.0, height], [sides[1], sides[0]], [2.0; 3]);
        assert_eq!(received(&turned, DVec3::Z), 0.0);
        assert_eq!(received(&panel, DVec3::NEG_Z), 0.0);
    }

    #[test]
    fn a_spot_has_all_of_its_light_inside_and_none_outside() {
        let spot = |inner: f64, outer: f64, range| Light::Point {
            position: DVec3::ZERO,
            intensity: DVec3::splat(9.0),
            cone: Some(Cone {
                axis: DVec3::NEG_Z,
                cosines: [inner.cos(), outer.cos()],
            }),
            range,
        };
        let at = |light: &Light, angle: f64, distance: f64| {
            let (sine, cosine) = angle.sin_cos();
            light
                .at(distance * DVec3::new(sine, 0.0, -cosine), [0.5; 2])
                .irradiance
                .x
        };
        let light = spot(0.3, 0.7, f64::INFINITY);
        // I/r², times the square of where the cosine stands between those of both angles.
        let between = (0.5f64.cos() - 0.7f64.cos()) / (0.3f64.cos() - 0.7f64.cos());
        for (angle, share) in [
            (0.0, 1.0),
            (0.29, 1.0),
            (0.5, between.powi(2)),
            (0.71, 0.0),
            (3.0, 0.0),
        ] {
            let found = at(&light, angle, 3.0);
            assert!(
                (found - share).abs() < 1e-12,
                "{angle}: {found}, not {share}"
            );
        }
        // Angles that are alike make a border, not a division by 0.
        let sharp = spot(0.5, 0.5, f64::INFINITY);
        assert!((at(&sharp, 0.49, 3.0) - 1.0).abs() < 1e-12);
        assert_eq!(at(&sharp, 0.51, 3.0), 0.0);
        // Halfway to its range a sixteenth is missing.
        let near = spot(0.3, 0.7, 6.0);
        assert!((at(&near, 0.0, 3.0) - 15.0 / 16.0).abs() < 1e-12);
        assert!(at(&near, 0.0, 6.0) < 1e-12 && at(&near, 0.0, 7.0) == 0.0);
    }

    #[test]
    fn all_that_a_lambertian_surface_reflects_is_its_albedo_times_what_arrives() {
        // Radiance L in every direction is a flux of π L per area: the energy bound of the chapter, with equality.
        let (albedo, cosine) = (DVec3::ONE, 0.6);
        let sun = Light::Distant {
            toward: DVec3::new(0.8, 0.0, cosine),
            irradiance: DVec3::splat(2.0),
        };
        let radiance = sun.at(DVec3::ZERO, [0.5; 2]).diffuse(DVec3::Z, albedo);
        assert!((PI * radiance.x - cosine * 2.0).abs() < 1e-15);
    }

    #[test]
    fn a_sky_full_of_lights_gives_the_open_phong_term() {
        // Equation (7) summed over even light is equation (14). Midpoints of 512 x 512 cells of equal solid angle.
        const CELLS: usize = 512;
        for (exponent, degrees) in [(0.0, 40.0), (5.0, 0.0), (5.0, 75.0), (20.0, 60.0_f64)] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let mirror = DVec3::new(-sine, 0.0, cosine);
            let material = PhongMaterial {
                specular: DVec3::ONE,
                exponent,
                ..PhongMaterial::default()
            };
            let of = |cell: usize| {
                let (row, column) = (cell / CELLS, cell % CELLS);
                let z = (row as f64 + 0.5) / CELLS as f64;
                let (y, x) = (2.0 * PI * (column as f64 + 0.5) / CELLS as f64).sin_cos();
                let r = (1.0 - z * z).sqrt();
                let sun = Light::Distant {
                    toward: DVec3::new(r * x, r * y, z),
                    irradiance: DVec3::splat(2.0 * PI / (CELLS * CELLS) as f64),
                };
                let arrival = sun.at(DVec3::ZERO, [0.5; 2]);
                arrival.specular(DVec3::Z, mirror, &material).x
            };
            let sum: f64 = (0..CELLS * CELLS).map(of).sum();
            let exact = ambient::closed_form::phong_open_angle(exponent, degrees.to_radians());
            // The step of the clamped lobe and of the horizon crosses cells.
            assert!(
                (sum - exact).abs() < 1e-4,
                "{exponent} {degrees}: {sum}, not {exact}"
            );
        }
    }
}
