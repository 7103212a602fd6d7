//! Fig. 1 of X. Zhang, Y. Gao, ICIP 2009: the specular ambient term of an open surface against view angle and exponent.

use ambient::closed_form::phong_open_angle;
use ambient::convention::lobe_scale;
use glam::DVec3;
use layers::Progress;
use render::{Direct, Error, Sample};
use std::fmt::Write;

/// Exponents of the curves.
pub(super) const EXPONENTS: [u32; 8] = [1, 2, 5, 10, 20, 50, 100, 200];

/// View angles of the points that are integrated with rays, in degrees.
const ANGLES_DEG: [f64; 10] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0];

/// Independent estimates of a point.
const ESTIMATES: u32 = 16;

/// A point of the figure. Values are J / (i_a k_s), in steradians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fig1Point {
    /// Lobe exponent.
    pub exponent: u32,
    /// View angle in degrees.
    pub angle_deg: f64,
    /// Equation (15) by its closed form.
    pub exact: f64,
    /// The same from rays.
    pub rays: f64,
    /// Standard error of `rays`, from the spread of the independent estimates. Where all agree, the rule of three: 1.5
    /// over the number of rays.
    pub std_err: f64,
}

/// Every point, integrated by `direct` at the origin of a scene whose surface there is open and faces +y. Its model
/// must be Phong under a white sky; its overrides are replaced. `progress` hears of points.
///
/// # Errors
/// [`Error::Cancelled`].
pub fn fig1(direct: &mut Direct<'_>, progress: &dyn Progress) -> Result<Vec<Fig1Point>, Error> {
    let total = (EXPONENTS.len() * ANGLES_DEG.len()) as u64;
    let mut points = Vec::new();
    for exponent in EXPONENTS {
        direct.overrides.albedo = Some([0.0; 3]);
        direct.overrides.specular = Some([1.0; 3]);
        direct.overrides.exponent = Some(f64::from(exponent));
        let raw = 1.0 / lobe_scale(f64::from(exponent));
        for angle_deg in ANGLES_DEG {
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
            let (sin, cos) = f64::sin_cos(angle_deg.to_radians());
            let view = DVec3::new(sin, cos, 0.0);
            let estimates: Vec<f64> = (0..ESTIMATES)
                .map(|number| {
                    let sample = Sample {
                        pixel: points.len() as u32,
                        number,
                        eye: view,
                        direction: -view,
                    };
                    direct.radiance(&sample).x
                })
                .collect();
            let count = f64::from(ESTIMATES);
            let share = estimates.iter().sum::<f64>() / count;
            let squares: f64 = estimates.iter().map(|e| (e - share).powi(2)).sum();
            let spread = (squares / (count * (count - 1.0))).sqrt();
            let floor = 1.5 / (count * f64::from(direct.rays));
            points.push(Fig1Point {
                exponent,
                angle_deg,
                exact: raw * phong_open_angle(f64::from(exponent), angle_deg.to_radians()),
                rays: raw * share,
                std_err: raw * if spread > 0.0 { spread } else { floor },
            });
            progress.advance(points.len() as u64, total);
        }
    }
    Ok(points)
}

/// The points as CSV with a head.
pub fn fig1_csv(points: &[Fig1Point]) -> String {
    let mut text = String::from("exponent,view_deg,exact_sr,rays_sr,standard_error_sr\n");
    for p in points {
        let Fig1Point {
            exponent,
            angle_deg,
            exact,
            rays,
            std_err,
        } = p;
        let _ = writeln!(text, "{exponent},{angle_deg},{exact},{rays},{std_err}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    use rays::{BackendKind, Surfaces, TreeKind, World, WorldOptions, build};
    use render::{Lamps, Model};
    use std::sync::Arc;

    #[test]
    fn points_by_rays_scatter_about_the_closed_form_by_their_errors() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/plane.obj");
        let scene = scene::load(file.as_ref()).expect("an authored scene");
        let options = WorldOptions::default();
        let world = World::new(Arc::new(scene), options).expect("the plane fits");
        let backend = build(BackendKind::Obvhs(TreeKind::Cwbvh), &world, 0).expect("no library");
        let (surfaces, lamps) = (Surfaces::new(&world), Lamps::NONE);
        let mut direct = Direct {
            model: Model::Phong,
            rays: 1024,
            ..Direct::new(&surfaces, backend.as_ref(), &lamps)
        };
        let points = fig1(&mut direct, &()).expect("nothing cancels it");
        assert_eq!(points.len(), 80);
        let deviations: Vec<f64> = points
            .iter()
            .map(|p| (p.rays - p.exact) / p.std_err)
            .collect();
        for (point, deviation) in points.iter().zip(&deviations) {
            // Student's t with 15 degrees of freedom: one of 80 beyond 6 once in 500 figures.
            assert!(deviation.abs() < 6.0, "{point:?}");
        }
        // Where rays can miss, the deviations have the size that the errors state: neither a third of it nor three
        // times.
        let scattered: Vec<f64> = points
            .iter()
            .zip(&deviations)
            .filter(|(point, _)| {
                (point.rays / (1.0 / lobe_scale(point.exponent.into())) - 1.0).abs() > 1e-3
            })
            .map(|(_, deviation)| deviation * deviation)
            .collect();
        let rms = (scattered.iter().sum::<f64>() / scattered.len() as f64).sqrt();
        assert!(
            (0.6..1.6).contains(&rms),
            "{rms} over {} points",
            scattered.len()
        );
        // The paper's n = 2 seen at 60 degrees.
        let found = points
            .iter()
            .find(|p| (p.exponent, p.angle_deg) == (2, 60.0));
        assert!((found.expect("drawn").exact - 1.684_938_5).abs() < 1e-7);
    }
}
