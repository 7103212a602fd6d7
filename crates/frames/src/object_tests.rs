//! Shaders by object, and mirrors whose rays are traced.

use super::*;
use crate::tests::{LOOKUPS, view};
use environment::{IlluminationMap, Image, Projection};
use glam::DVec3;
use render::{Camera, Weight};

/// A table whose texels all differ.
fn uneven(scale: f32) -> Table {
    let mut image = Image::filled(16, 8, [0.0; 3]);
    for (at, pixel) in image.pixels.iter_mut().enumerate() {
        *pixel = [at as f32, (at * at % 37) as f32, 3.0].map(|v| scale * (1.0 + v));
    }
    Table::new(&IlluminationMap::new(image, Projection::Polar).unwrap()).unwrap()
}

fn camera() -> Camera {
    Camera::new(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y, 0.5, [90, 5]).unwrap()
}

/// Strips of a bent wall, each an object with a number for its shader.
fn strips(direction: DVec3, shader: impl Fn(u32) -> u32) -> Surfel {
    let object = ((direction.x * 20.0).floor() as i64).rem_euclid(3) as u32;
    Surfel {
        normal: DVec3::new(direction.x, direction.y, 1.0).normalize(),
        albedo: DVec3::new(0.5, 0.25, 1.0),
        specular: DVec3::new(0.25, 0.5, 0.75),
        object,
        shader: shader(object),
        ..Surfel::default()
    }
}

#[test]
fn each_object_is_shaded_as_if_all_were_of_its_kind() {
    let (d, s) = (uneven(1.0), uneven(0.1));
    let shaders = [
        Shader::of(Some(&d), Some(&s)),
        Shader {
            coat: Some(&s),
            ..Shader::of(Some(&d), None)
        },
        Shader {
            glosses: vec![(4.0, vec![&s, &d]), (16.0, vec![&d, &s])],
            incidences: vec![0.5, 1.0],
            index: Index::Retro,
            specular_weight: Weight::Schlick(0.2),
            ..Shader::of(None, None)
        },
    ];
    let camera = camera();
    let view = view(&camera, 2);
    let own = GBuffer::take(&view, &(), |_, d| Some(strips(d, |object| object))).unwrap();
    let alike = GBuffer::take(&view, &(), |_, d| Some(strips(d, |_| 0))).unwrap();
    for lookup in LOOKUPS {
        let mut picture = Image::filled(90, 5, [0.0; 3]);
        frame(&shaders, &own, lookup, &mut picture);
        for (number, shader) in shaders.iter().enumerate() {
            let mut single = Image::filled(90, 5, [0.0; 3]);
            shader.frame(&alike, lookup, &mut single);
            for (k, place) in own.places().enumerate() {
                if own.objects[k] as usize == number {
                    assert_eq!(
                        picture.pixels[place], single.pixels[place],
                        "{lookup:?} {k}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_traced_mirror_shows_what_its_rays_meet_turned_with_its_object() {
    let (d, i) = (uneven(1.0), uneven(0.1));
    let wall = Shader::of(Some(&d), None);
    let mirror = Shader {
        index: Index::Traced,
        ..Shader::of(None, Some(&i))
    };
    let shaders = [wall, mirror];
    let angle = 0.7;
    let turn = glam::DQuat::from_axis_angle(DVec3::Y, angle);
    let (there, normal) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.6, -0.8));
    let met = Mirrored::Surface(Reflected {
        normal,
        view: -there,
        reflectances: [DVec3::splat(0.5), DVec3::ONE],
        exponent: 0.0,
        shader: 0,
    });
    let camera = camera();
    let view = View {
        turn: Turn {
            angle,
            ..view(&camera, 1).turn
        },
        ..view(&camera, 1)
    };
    for (met, exact) in [
        (
            Mirrored::Environment(there),
            i.bilinear((turn * there).as_vec3().to_array()),
        ),
        (
            met,
            d.bilinear((turn * normal).as_vec3().to_array())
                .map(|v| 0.5 * v),
        ),
    ] {
        let buffer = GBuffer::take(&view, &(), |_, direction| {
            Some(Surfel {
                mirrored: Some(met),
                ..strips(direction, |_| 1)
            })
        });
        let buffer = buffer.unwrap();
        for lookup in LOOKUPS {
            let mut picture = Image::filled(90, 5, [0.0; 3]);
            frame(&shaders, &buffer, lookup, &mut picture);
            let ks = [0.25, 0.5, 0.75];
            for pixel in &picture.pixels {
                for c in 0..3 {
                    // Rounding of the turn.
                    assert!(
                        (pixel[c] - ks[c] * exact[c]).abs() < 1e-4,
                        "{pixel:?} {exact:?}"
                    );
                }
            }
        }
    }
}
