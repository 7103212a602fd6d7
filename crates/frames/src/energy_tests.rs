//! What a mirroring globe shows of a sun of one texel, by each look-up: a far eye sees π/4 L of a sun of solid angle π,
//! from everywhere.

use super::*;
use crate::tests::view;
use environment::{IlluminationMap, Image, Projection};
use glam::DVec3;
use render::Camera;

/// The nearest hit of a ray on the unit sphere at the origin, which mirrors all.
fn globe(eye: DVec3, direction: DVec3) -> Option<Surfel> {
    // About the point that is nearest to the middle: the eye is far away.
    let along = eye.dot(direction);
    let nearest = eye - direction * along;
    let rest = 1.0 - nearest.length_squared();
    (rest > 0.0).then(|| Surfel {
        normal: nearest - direction * rest.sqrt(),
        albedo: DVec3::ZERO,
        specular: DVec3::ONE,
        ..Surfel::default()
    })
}

/// Light of the sun in the picture over what is exact, from `count` sides: mean and standard deviation.
fn energy(lookup: Lookup, width: usize, sun: [usize; 2], size: u32, count: usize) -> [f64; 2] {
    let mut sky = Image::filled(width, width / 2, [0.0; 3]);
    sky.pixels[sun[1] * width + sun[0]] = [1e6; 3];
    let omega = Projection::Polar.solid_angle((width, width / 2), 0, sun[1]);
    let place = sun.map(|k| k as f64 + 0.5);
    let toward = Projection::Polar.direction((width, width / 2), place[0], place[1]);
    let toward = DVec3::from(toward.expect("a direction"));
    let table = Table::new(&IlluminationMap::new(sky, Projection::Polar).expect("a map"));
    let table = table.expect("polar");
    let shader = Shader::of(None, Some(&table));
    let far = 1000.0;
    let half = 1.05;
    let mut ratios = vec![];
    for k in 0..2 * count {
        // Even places of the eye on a sphere; not straight behind the globe, where its rim cuts the sun.
        let y = 1.0 - (2 * k + 1) as f64 / (2 * count) as f64;
        let (s, c) = (2.399_963_229_728_653 * k as f64).sin_cos();
        let r = (1.0 - y * y).sqrt();
        let eye = DVec3::new(r * c, y, r * s);
        if eye.dot(toward) < -0.5 || ratios.len() == count {
            continue;
        }
        let fov = 2.0 * f64::atan(half / far);
        let up = eye.any_orthonormal_vector();
        let up = (up + 0.37 * eye.cross(up)).normalize();
        let camera = Camera::new(eye * far, DVec3::ZERO, up, fov, [size; 2]).expect("a camera");
        let view = view(&camera, 1);
        let buffer = GBuffer::take(&view, &(), globe).expect("a buffer");
        let mut picture = Image::filled(size as usize, size as usize, [0.0; 3]);
        shader.frame(&buffer, lookup, &mut picture);
        let sum: f64 = picture.pixels.iter().map(|p| f64::from(p[1])).sum();
        let pixel = (2.0 * half / f64::from(size)).powi(2);
        ratios.push(sum * pixel / (1e6 * omega / 4.0));
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    let square = ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>();
    [mean, (square / (ratios.len() - 1) as f64).sqrt()]
}

#[test]
fn a_sun_of_one_texel_keeps_its_light_in_the_summed_table_from_twenty_sides() {
    for (width, sun) in [(64, [20, 9]), (512, [100, 70]), (512, [300, 20])] {
        let [mean, deviation] = energy(Lookup::Summed, width, sun, 64, 20);
        println!("{width} {sun:?}: {mean:.3} ± {deviation:.3}");
        // One rectangle a pixel gave 0.98 ± 0.41 for the second of these.
        assert!(
            (mean - 1.0).abs() < 0.03 && deviation < 0.05,
            "{width} {sun:?}: {mean} ± {deviation}"
        );
    }
}
