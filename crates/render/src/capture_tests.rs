//! Captured maps against answers known on paper.

use crate::fixture::{Sheet, white, world};
use crate::{Direct, Lamps, Light, PointForm, add_points, capture};
use environment::{IlluminationMap, Image, Projection, Sky};
use glam::{DVec3, Vec3};
use maps::{Lobe, Normalise, Request, convolve};
use rays::{RayBackend, Surfaces};
use std::f64::consts::PI;

/// Black under a black sky, but for lamps and lights.
fn direct<'a>(
    surfaces: &'a Surfaces<'a>,
    backend: &'a dyn RayBackend,
    lamps: &'a Lamps,
    lights: &'a [Light],
) -> Direct<'a> {
    Direct {
        rays: 16,
        sky: Sky::BLACK,
        lights,
        ..Direct::new(surfaces, backend, lamps)
    }
}

/// A lamp of these radiances and reflectance.
fn lamp(place: [Vec3; 3], emission: Vec3, albedo: f32) -> Sheet {
    Sheet {
        emission,
        albedo: Vec3::splat(albedo),
        ..white(place)
    }
}

/// The inside of the cube -1..1.
fn room(emission: Vec3, albedo: f32) -> Vec<Sheet> {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let side = |axis: usize, sign: f32| {
        let [a, b, c] = [0, 1, 2].map(|k: usize| axes[(axis + k) % 3]);
        lamp([a * sign - b - c, b * 2.0, c * 2.0], emission, albedo)
    };
    (0..6).map(|n| side(n / 2, [-1.0, 1.0][n % 2])).collect()
}

/// Six pictures.
fn cube(direct: &Direct<'_>, at: DVec3, face: usize, grid: usize) -> IlluminationMap {
    capture(direct, at, Projection::Cube, (face, 6 * face), grid, &()).unwrap()
}

/// D for the normals +x -x +y -y +z -z, 1/π ∫ I cos.
fn lit(map: &IlluminationMap) -> [f64; 6] {
    let request = Request {
        lobe: Lobe::Lambert,
        normalise: Normalise::Radiance,
        projection: Projection::Cube,
        size: (1, 6),
    };
    let d = convolve(map, &[request]).unwrap();
    std::array::from_fn(|face| f64::from(d[0].image().pixels[face][0]))
}

#[test]
fn inside_a_luminous_box_the_map_is_its_radiance_everywhere() {
    let emission = Vec3::new(0.75, 2.0, 0.1);
    let (world, backend) = world(&room(emission, 0.0));
    let surfaces = Surfaces::new(&world);
    let lamps = Lamps::of(&world);
    let direct = direct(&surfaces, backend.as_ref(), &lamps, &[]);
    for at in [DVec3::ZERO, DVec3::new(0.9, -0.3, 0.2)] {
        for projection in Projection::all() {
            let size = projection.size(32);
            let map = capture(&direct, at, projection, size, 3, &()).unwrap();
            for (texel, pixel) in map.image().pixels.iter().enumerate() {
                let shown = projection.solid_angle(size, texel % size.0, texel / size.0) > 0.0;
                let exact = if shown { emission } else { Vec3::ZERO };
                assert_eq!(*pixel, exact.to_array(), "{projection:?} {texel}");
            }
        }
        for d in lit(&cube(&direct, at, 8, 1)) {
            assert!((d - 0.75).abs() < 1e-6, "{d}");
        }
    }
}

#[test]
fn each_face_of_the_map_looks_along_its_axis() {
    let mut walls = room(Vec3::ZERO, 0.0);
    // -x +x -y +y -z +z, as `room` builds them.
    for (number, wall) in walls.iter_mut().enumerate() {
        wall.emission = Vec3::splat(1.0 + number as f32);
    }
    let (world, backend) = world(&walls);
    let surfaces = Surfaces::new(&world);
    let lamps = Lamps::of(&world);
    let direct = direct(&surfaces, backend.as_ref(), &lamps, &[]);
    let faces = cube(&direct, DVec3::ZERO, 1, 4);
    let found: Vec<_> = faces.image().pixels.iter().map(|p| p[0]).collect();
    assert_eq!(found, [2.0, 1.0, 4.0, 3.0, 6.0, 5.0]);
    let polar = capture(&direct, DVec3::ZERO, Projection::Polar, (8, 4), 1, &()).unwrap();
    for (column, row, exact) in [
        (4, 2, 6.0),
        (5, 1, 2.0),
        (2, 2, 1.0),
        (0, 1, 5.0),
        (3, 0, 4.0),
    ] {
        assert_eq!(polar.image().at(column, row)[0], exact, "({column}, {row})");
    }
}

#[test]
fn a_box_that_also_reflects_half_shows_half_as_much_again() {
    let (world, backend) = world(&room(Vec3::ONE, 0.5));
    let surfaces = Surfaces::new(&world);
    let lamps = Lamps::of(&world);
    let direct = direct(&surfaces, backend.as_ref(), &lamps, &[]);
    let map = cube(&direct, DVec3::new(0.2, 0.1, -0.3), 16, 2);
    let values: Vec<f64> = map.image().pixels.iter().map(|p| p[0].into()).collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let error = (square / (count - 1.0) / count).sqrt();
    assert!((mean - 1.5).abs() < 5.0 * error, "{mean} ± {error}");
    assert!(error < 0.002, "{error}");
}

#[test]
fn a_luminous_square_lights_a_facing_surface_by_its_form_factor() {
    for (side, face) in [(2.0f32, 8), (1.0, 32)] {
        let half = 0.5 * side;
        let corner = Vec3::new(-half, -half, 1.0);
        let square = lamp([corner, Vec3::X * side, Vec3::Y * side], Vec3::ONE, 0.0);
        let (world, backend) = world(&[square]);
        let surfaces = Surfaces::new(&world);
        let lamps = Lamps::of(&world);
        let direct = direct(&surfaces, backend.as_ref(), &lamps, &[]);
        let map = cube(&direct, DVec3::ZERO, face, 2);
        // The square covers whole texels.
        let white = map
            .image()
            .pixels
            .iter()
            .filter(|p| **p == [1.0; 3])
            .count();
        let black = map
            .image()
            .pixels
            .iter()
            .filter(|p| **p == [0.0; 3])
            .count();
        assert_eq!(white as f32, (face * face) as f32 * 0.25 * side * side);
        assert_eq!(white + black, 6 * face * face);
        let x = f64::from(half);
        let root = (1.0 + x * x).sqrt();
        let factor = 4.0 / PI * x / root * (x / root).atan();
        let found = lit(&map);
        assert!(
            (found[4] - factor).abs() < 1e-6,
            "{} for {factor}",
            found[4]
        );
        assert_eq!(found[5], 0.0);
        if side == 2.0 {
            assert!((factor - 0.554_126_424_0).abs() < 5e-11);
            for d in &found[..4] {
                assert!((d - 4.0 * 0.027_867_098_5).abs() < 1e-6, "{d}");
            }
        }
    }
}

/// A black map.
fn black(projection: Projection, texels: usize) -> IlluminationMap {
    let (width, height) = projection.size(texels);
    IlluminationMap::new(Image::filled(width, height, [0.0; 3]), projection).unwrap()
}

#[test]
fn a_point_light_brings_its_energy_by_distance_squared_at_every_size() {
    let far = white([Vec3::new(90.0, 0.0, 0.0), Vec3::Y, Vec3::Z]);
    let (world, backend) = world(&[far]);
    let surfaces = Surfaces::new(&world);
    let lamps = Lamps::NONE;
    // Toward the middle of a face of the cube, which is a texel's centre where the face has an odd side.
    let (axis, slant) = (DVec3::new(0.0, 0.0, 5.0), DVec3::new(1.0, 3.0, -2.0));
    for position in [axis, slant] {
        let lights = [Light::point((position + DVec3::ONE).to_array(), [50.0; 3])];
        let direct = direct(&surfaces, backend.as_ref(), &lamps, &lights);
        let flux = 50.0 / position.length_squared();
        for projection in Projection::all() {
            for texels in [12, 60, 1024] {
                let map = black(projection, texels);
                let map = add_points(map, &direct, DVec3::ONE, PointForm::Radiance).unwrap();
                for integral in map.integral() {
                    let error = (integral / flux - 1.0).abs();
                    assert!(
                        error < 1e-6,
                        "{projection:?} {texels}: {integral} for {flux}"
                    );
                }
            }
        }
        let toward = position.normalize().to_array();
        for texels in [36, 72, 1024] {
            let map = black(Projection::Polar, texels);
            let map = add_points(map, &direct, DVec3::ONE, PointForm::Radiance).unwrap();
            // The light is spread over two texels each way at most. What sees it at the horizon gets an eighth of that
            // width; all else loses half of the variance, 1/6 of a texel's square each way. D itself is good to 1e-6.
            let width = 2.0 * PI / texels as f64;
            for (face, d) in lit(&map).into_iter().enumerate() {
                let cosine = toward[face / 2] * [1.0, -1.0][face % 2];
                let found = d * PI / flux;
                let bound = if cosine.abs() > width {
                    width * width / 3.0 + 1e-6
                } else {
                    width / 4.0
                };
                assert!(
                    (found - cosine.max(0.0)).abs() < bound,
                    "{texels}: {found} for {cosine}"
                );
            }
        }
    }
}

#[test]
fn a_hidden_point_light_brings_nothing_and_the_raw_form_adds_plain_values() {
    let screen = white([Vec3::new(-1.0, -1.0, 1.0), Vec3::X * 2.0, Vec3::Y * 2.0]);
    let (world, backend) = world(&[screen]);
    let surfaces = Surfaces::new(&world);
    let at = |z: f64| [Light::point([0.0, 0.0, z], [9.0; 3])];
    let lamps = Lamps::NONE;
    let map = |z: f64, form| {
        let lights = at(z);
        let direct = direct(&surfaces, backend.as_ref(), &lamps, &lights);
        add_points(black(Projection::Cube, 12), &direct, DVec3::ZERO, form)
    };
    for form in [PointForm::Radiance, PointForm::Raw] {
        assert_eq!(map(3.0, form).unwrap(), black(Projection::Cube, 12));
    }
    // The middle texel of the face -z.
    let raw = map(-3.0, PointForm::Raw).unwrap();
    let lit: Vec<_> = raw
        .image()
        .pixels
        .iter()
        .enumerate()
        .filter(|(_, p)| p[0] > 0.0)
        .collect();
    assert_eq!(lit, [(5 * 9 + 4, &[1.0; 3])]);
    let radiance = map(-3.0, PointForm::Radiance).unwrap();
    let omega = Projection::Cube.solid_angle((3, 18), 1, 16);
    assert_eq!(radiance.image().pixels[49], [(1.0 / omega) as f32; 3]);
    assert!(map(0.0, PointForm::Radiance).is_err());
    assert!(map(1e-30, PointForm::Radiance).is_err());
}

#[test]
fn a_map_is_the_same_at_any_thread_count() {
    let (world, backend) = world(&room(Vec3::ONE, 0.5));
    let surfaces = Surfaces::new(&world);
    let lamps = Lamps::of(&world);
    let direct = direct(&surfaces, backend.as_ref(), &lamps, &[]);
    let take = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build()
            .unwrap()
            .install(|| cube(&direct, DVec3::new(0.3, 0.0, 0.1), 12, 2))
    };
    let one = take(1);
    assert!(one == take(2) && one == take(7));
}
