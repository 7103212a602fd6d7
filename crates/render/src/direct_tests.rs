//! Direct pictures against answers known on paper.

use crate::fixture::{Sheet, ground, see_through, white, world};
use crate::{Camera, Direct, Lamps, Light, Model, Sample, Weight, picture};
use ambient::closed_form::phong_open;
use ambient::ggx::Ggx;
use environment::{IlluminationMap, Image, Projection, Sky, SkyMap};
use glam::{DVec3, Vec3};
use rays::{RayBackend, Surfaces};
use std::f64::consts::PI;
use std::sync::Arc;

static DARK: Lamps = Lamps::NONE;

fn direct<'a>(surfaces: &'a Surfaces<'a>, backend: &'a dyn RayBackend, model: Model) -> Direct<'a> {
    Direct {
        model,
        rays: 1024,
        ..Direct::new(surfaces, backend, &DARK)
    }
}

fn seen(eye: DVec3, target: DVec3, pixel: u32) -> Sample {
    Sample {
        pixel,
        number: 0,
        eye,
        direction: (target - eye).normalize(),
    }
}

/// Mean and standard error over independent pixels.
fn mean(direct: &Direct<'_>, eye: DVec3, target: DVec3) -> (f64, f64) {
    let values: Vec<f64> = (0..64)
        .map(|pixel| direct.radiance(&seen(eye, target, pixel)).x)
        .collect();
    let mean = values.iter().sum::<f64>() / 64.0;
    let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, (square / 63.0 / 64.0).sqrt())
}

#[test]
fn an_open_plane_shows_the_sky_by_its_albedo_in_the_diffuse_models() {
    let mut sheet = ground();
    sheet.albedo = Vec3::new(0.5, 0.25, 1.0);
    let (world, backend) = world(&[sheet]);
    let surfaces = Surfaces::new(&world);
    for model in [Model::Traditional, Model::Lambert] {
        let shader = direct(&surfaces, backend.as_ref(), model);
        let value = shader.radiance(&seen(DVec3::new(3.0, 2.0, 1.0), DVec3::ZERO, 0));
        assert_eq!(value, DVec3::new(0.5, 0.25, 1.0), "{model:?}");
    }
}

#[test]
fn a_wall_darkens_the_floor_as_its_closed_forms_say() {
    let wall = white([Vec3::new(0.0, 0.0, -4096.0), Vec3::Y, Vec3::Z * 8192.0]);
    let (world, backend) = world(&[ground(), wall]);
    let surfaces = Surfaces::new(&world);
    let (d, eye) = (0.5_f64, DVec3::new(3.0, 2.0, 0.3));
    let angle = (1.0 / d).atan();
    for (model, exact) in [
        (Model::Traditional, 1.0 - angle / PI),
        (Model::Lambert, 0.5 * (1.0 + angle.cos())),
    ] {
        let shader = direct(&surfaces, backend.as_ref(), model);
        let (value, error) = mean(&shader, eye, DVec3::new(d, 0.0, 0.3));
        // The far ends of the wall miss less than 1e-4 of the hemisphere.
        assert!(
            (value - exact).abs() < 5.0 * error + 1e-4,
            "{model:?}: {value} ± {error} for {exact}"
        );
    }
}

#[test]
fn a_white_microfacet_plane_returns_all_that_it_receives_at_every_roughness_and_angle() {
    for (albedo, specular) in [(0.0, 1.0), (0.96, 0.04)] {
        for exponent in [0.0, 1.0, 30.0, 5000.0] {
            let mut sheet = ground();
            sheet.albedo = Vec3::splat(albedo);
            sheet.specular = Vec3::splat(specular);
            sheet.exponent = exponent;
            let (world, backend) = world(&[sheet]);
            let surfaces = Surfaces::new(&world);
            let shader = direct(&surfaces, backend.as_ref(), Model::Ggx);
            for theta in [0.0, 0.8, 1.5_f64] {
                let eye = DVec3::new(4.0 * theta.sin(), 4.0 * theta.cos(), 0.0);
                let value = shader.radiance(&seen(eye, DVec3::ZERO, 0)).x;
                // Albedos are rounded to 32 bits.
                assert!(
                    (value - 1.0).abs() < 1e-6,
                    "{specular} n {exponent}, {theta}: {value}"
                );
            }
        }
    }
}

#[test]
fn a_wall_beside_a_microfacet_plane_takes_half_of_what_is_seen_from_above() {
    let mut floor = ground();
    floor.albedo = Vec3::ZERO;
    floor.specular = Vec3::ONE;
    floor.exponent = 2.0;
    let wall = white([Vec3::new(0.0, 0.0, -4096.0), Vec3::Y, Vec3::Z * 8192.0]);
    let (world, backend) = world(&[floor, wall]);
    let surfaces = Surfaces::new(&world);
    let shader = direct(&surfaces, backend.as_ref(), Model::Ggx);
    let target = DVec3::new(0.001, 0.0, 0.3);
    let (value, error) = mean(&shader, target + DVec3::Y * 0.5, target);
    // The wall ends a thousandth of a radian from the zenith.
    assert!(
        (value - 0.5).abs() < 5.0 * error + 1e-3,
        "{value} ± {error}"
    );
}

#[test]
fn a_sun_above_a_microfacet_mirror_shows_the_peak_of_its_lobe() {
    // Toward = view = normal: D = 1/(π α²), G2 = 1, F = F0.
    let (alpha, f0) = (0.1_f64, 0.5);
    let mut sheet = ground();
    sheet.albedo = Vec3::ZERO;
    sheet.specular = Vec3::splat(f0);
    sheet.exponent = 0.5 * (1.0 / (alpha * alpha) - 1.0);
    let (world, backend) = world(&[sheet]);
    let surfaces = Surfaces::new(&world);
    let sun = [Light::Distant {
        toward: DVec3::Y,
        irradiance: DVec3::splat(2.0),
    }];
    let shader = Direct {
        rays: 0,
        lights: &sun,
        ..direct(&surfaces, backend.as_ref(), Model::Ggx)
    };
    let value = shader.radiance(&seen(DVec3::Y * 3.0, DVec3::ZERO, 0)).x;
    let gain = Ggx::new(alpha, 1.0).open().gain(DVec3::splat(0.5)).x;
    let exact = gain * 2.0 * f64::from(f0) / (4.0 * PI * alpha * alpha);
    // The mean over 64 points stands for the integral: one of them counts 1/64 of it, times F0.
    assert!(
        (value / exact - 1.0).abs() < f64::from(f0) / 64.0,
        "{value} for {exact}"
    );
}

#[test]
fn the_closed_baseline_is_the_closed_form_of_the_open_plane_times_visibility() {
    let mut floor = ground();
    (floor.albedo, floor.specular) = (Vec3::splat(0.25), Vec3::splat(0.5));
    floor.exponent = 5.0;
    let wall = white([Vec3::new(0.0, 0.0, -4096.0), Vec3::Y, Vec3::Z * 8192.0]);
    let (world, backend) = world(&[floor, wall]);
    let surfaces = Surfaces::new(&world);
    let shader = direct(&surfaces, backend.as_ref(), Model::TraditionalClosed);
    let target = DVec3::new(0.5, 0.0, 0.3);
    let (sin, cos) = f64::sin_cos(0.7);
    let (value, error) = mean(&shader, target + DVec3::new(sin, cos, 0.0), target);
    let open = 1.0 - 2.0_f64.atan() / PI;
    let exact = open * (0.25 + 0.5 * phong_open(5.0, cos, sin));
    assert!(
        (value - exact).abs() < 5.0 * error + 1e-4,
        "{value} ± {error} for {exact}"
    );
}

#[test]
fn the_phong_lobe_follows_the_eye_on_an_open_plane() {
    let mut sheet = ground();
    sheet.albedo = Vec3::ZERO;
    sheet.specular = Vec3::ONE;
    sheet.exponent = 5.0;
    let (world, backend) = world(&[sheet]);
    let surfaces = Surfaces::new(&world);
    let shader = direct(&surfaces, backend.as_ref(), Model::Phong);
    for theta in [0.0, 0.5, 1.0, 1.4] {
        let (sin, cos) = f64::sin_cos(theta);
        let exact = phong_open(5.0, cos, sin);
        let (value, error) = mean(&shader, DVec3::new(4.0 * sin, 4.0 * cos, 0.0), DVec3::ZERO);
        assert!(
            (value - exact).abs() <= 5.0 * error + 1e-6,
            "{theta}: {value} ± {error} for {exact}"
        );
    }
}

#[test]
fn lights_follow_the_cosine_and_cast_shadows() {
    let roof = white([Vec3::new(1.0, 1.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0]);
    let (world, backend) = world(&[ground(), roof]);
    let surfaces = Surfaces::new(&world);
    let mut shader = direct(&surfaces, backend.as_ref(), Model::Lambert);
    shader.rays = 0;
    let lights = [
        Light::Distant {
            toward: DVec3::new(0.0, 0.6, 0.8),
            irradiance: DVec3::splat(2.0),
        },
        Light::point([0.0, 2.0, 0.0], [8.0; 3]),
    ];
    let eye = DVec3::new(0.0, 0.5, -3.0);
    for (lights, at, exact) in [
        (&lights[..1], DVec3::new(-1.0, 0.0, 0.0), 0.6 * 2.0 / PI),
        (&lights[..1], DVec3::new(2.0, 0.0, -1.0), 0.0),
        (&lights[1..], DVec3::ZERO, 2.0 / PI),
        (&lights[1..], DVec3::new(3.0, 0.0, 0.0), 0.0),
        (
            &lights[1..],
            DVec3::new(-2.0, 0.0, 0.0),
            8.0 / 8.0 * 0.5f64.sqrt() / PI,
        ),
    ] {
        shader.lights = lights;
        let value = shader.radiance(&seen(eye, at, 0)).x;
        // The ray's direction is rounded to f32, which moves the lit point.
        assert!((value - exact).abs() < 1e-6, "{at}: {value} for {exact}");
    }
}

#[test]
fn a_highlight_is_weighed_by_the_incidence_of_its_light() {
    let mut sheet = ground();
    (sheet.albedo, sheet.specular) = (Vec3::splat(0.5), Vec3::splat(0.25));
    sheet.exponent = 3.0;
    let (world, backend) = world(&[sheet]);
    let surfaces = Surfaces::new(&world);
    let lights = [Light::Distant {
        toward: DVec3::new(0.8, 0.6, 0.0),
        irradiance: DVec3::splat(2.0),
    }];
    let mut shader = direct(&surfaces, backend.as_ref(), Model::Phong);
    (shader.rays, shader.lights) = (0, &lights);
    let eye = DVec3::new(-3.0, 4.0, 0.0);
    let seen = |shader: &Direct<'_>| shader.radiance(&seen(eye, DVec3::ZERO, 0));
    let plain = seen(&shader);
    // The mirrored view (0.6, 0.8, 0) and the light are arccos 0.96 apart; (n+1)/2pi E ks cos^n.
    let highlight = 4.0 / (2.0 * PI) * 2.0 * 0.25 * 0.96f64.powi(3);
    let matte = 0.5 * 2.0 * 0.6 / PI;
    assert!((plain.x - matte - highlight).abs() < 1e-6, "{plain}");
    shader.incidence = Weight::Schlick(0.1);
    let share = 0.1 + 0.9 * 0.4f64.powi(5);
    let weighed = seen(&shader);
    assert!(
        (weighed.x - matte - share * highlight).abs() < 1e-6,
        "{weighed}"
    );
    shader.model = Model::Lambert;
    assert!((seen(&shader).x - matte).abs() < 1e-6, "no highlight");
}

#[test]
fn a_luminous_patch_lights_the_floor_by_its_form_factor() {
    let patch = Sheet {
        emission: Vec3::splat(10.0),
        ..white([Vec3::new(0.0, 1.0, 0.0), Vec3::X * 2.0, Vec3::Z])
    };
    let (world, backend) = world(&[ground(), patch]);
    let surfaces = Surfaces::new(&world);
    let mut shader = direct(&surfaces, backend.as_ref(), Model::Lambert);
    let lamps = Lamps::of(&world);
    shader.lamps = &lamps;
    shader.sky = Sky::BLACK;
    // Form factor of a parallel rectangle of 2 by 1 at height 1 over its corner.
    let (a, b) = (5.0f64.sqrt(), 2.0f64.sqrt());
    let factor = (2.0 / a * (1.0 / a).atan() + 1.0 / b * (2.0 / b).atan()) / (2.0 * PI);
    let (value, error) = mean(&shader, DVec3::new(-2.0, 0.5, -2.0), DVec3::ZERO);
    assert!(
        (value - 10.0 * factor).abs() < 5.0 * error,
        "{value} ± {error} for {}",
        10.0 * factor
    );
    let patch = shader.radiance(&seen(
        DVec3::new(1.0, 0.2, 0.5),
        DVec3::new(1.0, 1.0, 0.5),
        0,
    ));
    assert_eq!(patch, DVec3::splat(10.0));
}

#[test]
fn small_and_near_lamps_light_the_floor_without_noise() {
    let square = |side: f32, height: f32| Sheet {
        emission: Vec3::splat((side * side).recip()),
        ..white([Vec3::new(0.0, height, 0.0), Vec3::X * side, Vec3::Z * side])
    };
    for (side, height) in [(0.01f32, 1.0f32), (1.0, 1.0), (4.0, 0.01)] {
        // A floor of this size rounds the lit point to 1e-7.
        let floor = white([Vec3::new(-0.5, 0.0, -0.25), Vec3::Z, Vec3::X]);
        let (world, backend) = world(&[floor, square(side, height)]);
        let surfaces = Surfaces::new(&world);
        let lamps = Lamps::of(&world);
        let mut shader = direct(&surfaces, backend.as_ref(), Model::Lambert);
        (shader.lamps, shader.sky, shader.rays) = (&lamps, Sky::BLACK, 64);
        // Form factor of a parallel square over its corner.
        let x = f64::from(side) / f64::from(height);
        let root = (1.0 + x * x).sqrt();
        let factor = x / root * (x / root).atan() / PI;
        let exact = factor / f64::from(side * side);
        let (value, error) = mean(&shader, DVec3::new(-3.0, 0.005, -3.0), DVec3::ZERO);
        // A direction rounds by 6e-8, which loses a margin of the two triangles, 6.9 sides long.
        let margin = 6.9 * 6e-8 * f64::from(height / side);
        let rounding = (1e-7 / f64::from(height) + margin) * exact;
        assert!(
            (value - exact).abs() < 5.0 * error + rounding,
            "{side}: {value} ± {error} for {exact}"
        );
        // Rays over the hemisphere alone: half a hundred per cent and more for the small lamp.
        assert!(error < 0.005 * exact, "{side}: {value} ± {error}");
    }
}

#[test]
fn a_luminous_ceiling_is_as_good_as_the_sky_to_both_terms() {
    let mut floor = ground();
    (floor.albedo, floor.specular, floor.exponent) = (Vec3::splat(0.5), Vec3::splat(0.25), 20.0);
    let ceiling = Sheet {
        place: ground()
            .place
            .map(|v| if v.x == v.z { v + Vec3::Y } else { v }),
        emission: Vec3::ONE,
        albedo: Vec3::ZERO,
        ..ground()
    };
    let (world, backend) = world(&[floor, ceiling]);
    let surfaces = Surfaces::new(&world);
    let lamps = Lamps::of(&world);
    let mut shader = direct(&surfaces, backend.as_ref(), Model::Phong);
    (shader.lamps, shader.sky) = (&lamps, Sky::BLACK);
    for theta in [0.0, 0.5, 1.0] {
        let (sin, cos) = f64::sin_cos(theta);
        let exact = 0.5 + 0.25 * phong_open(20.0, cos, sin);
        let eye = DVec3::new(0.5 * sin, 0.5 * cos, 0.0);
        let (value, error) = mean(&shader, eye, DVec3::ZERO);
        // Its end is 4096 heights away.
        assert!(
            (value - exact).abs() <= 5.0 * error + 1e-6,
            "{theta}: {value} ± {error} for {exact}"
        );
    }
}

#[test]
fn a_screen_before_half_of_a_lamp_takes_its_light() {
    let lamp = Sheet {
        emission: Vec3::ONE,
        ..white([Vec3::new(-1.0, 1.0, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0])
    };
    let screen = white([Vec3::new(0.0, 0.5, -1.0), Vec3::X, Vec3::Z * 2.0]);
    let (world, backend) = world(&[ground(), lamp, screen]);
    let surfaces = Surfaces::new(&world);
    let lamps = Lamps::of(&world);
    let mut shader = direct(&surfaces, backend.as_ref(), Model::Lambert);
    (shader.lamps, shader.sky) = (&lamps, Sky::BLACK);
    let whole = 4.0 / PI * 0.5f64.sqrt() * 0.5f64.sqrt().atan();
    let (value, error) = mean(&shader, DVec3::new(-3.0, 0.5, 0.0), DVec3::ZERO);
    let exact = 0.5 * whole;
    assert!(
        (value - exact).abs() < 5.0 * error,
        "{value} ± {error} for {exact}"
    );
}

#[test]
fn a_picture_is_the_same_at_any_thread_count() {
    let wall = white([Vec3::new(0.0, 0.0, -8.0), Vec3::Y, Vec3::Z * 16.0]);
    let (world, backend) = world(&[ground(), wall]);
    let surfaces = Surfaces::new(&world);
    let shader = Direct {
        rays: 20,
        ..direct(&surfaces, backend.as_ref(), Model::Phong)
    };
    let eye = DVec3::new(4.0, 3.0, 2.0);
    let camera = Camera::new(eye, DVec3::ZERO, DVec3::Y, 0.7, [40, 30]).unwrap();
    let take = |threads| -> Image {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| picture(&camera, 2, &(), |sample| shader.radiance(sample)).unwrap())
    };
    assert_eq!(take(1), take(3));
}

/// A map of a grey floor and one bright texel; and what it shines on a plane of a model by a sum over 64 x 64 places of
/// that texel.
fn small_sun(reflected: impl Fn(DVec3) -> f64) -> (Sky, f64) {
    let (width, height, row, column) = (256, 128, 21, 77);
    let mut image = Image::filled(width, height, [0.25; 3]);
    image.pixels[row * width + column] = [2e4; 3];
    let map = IlluminationMap::new(image, Projection::Polar).unwrap();
    let step = PI / height as f64;
    let mut sum = 0.0;
    for (i, j) in (0..64 * 64).map(|k| (k % 64, k / 64)) {
        let polar = (row as f64 + (f64::from(i) + 0.5) / 64.0) * step;
        let turn = (column as f64 + (f64::from(j) + 0.5) / 64.0) * step - PI;
        let toward = DVec3::new(
            polar.sin() * turn.sin(),
            polar.cos(),
            polar.sin() * turn.cos(),
        );
        sum += polar.sin() * (step / 64.0).powi(2) * toward.y * reflected(toward);
    }
    let sky = Sky::Map(Arc::new(SkyMap::new(&map).unwrap()));
    (sky, (2e4 - 0.25) * sum)
}

#[test]
fn a_small_sun_in_a_map_lights_all_models_with_little_noise() {
    let (sin, cos) = f64::sin_cos(0.9);
    let eye = 4.0 * DVec3::new(sin, cos, 0.0);
    for (model, roughness) in [
        (Model::Lambert, 1.0_f64),
        (Model::Phong, 0.3),
        (Model::Ggx, 0.9),
        (Model::Ggx, 0.6),
        (Model::Ggx, 0.3),
    ] {
        let exponent = 0.5 * (roughness.powi(-4) - 1.0);
        let mut sheet = ground();
        (sheet.albedo, sheet.specular) = (Vec3::ZERO, Vec3::ONE);
        sheet.exponent = exponent;
        if model == Model::Lambert {
            (sheet.albedo, sheet.specular) = (Vec3::ONE, Vec3::ZERO);
        }
        let (world, backend) = world(&[sheet]);
        let surfaces = Surfaces::new(&world);
        let mirror = DVec3::new(-eye.x, eye.y, 0.0) / 4.0;
        let ggx = Ggx::new(roughness.powi(2), cos);
        let gain = ggx.open().gain(DVec3::ONE).x;
        let frame = ambient::ggx::frame(DVec3::Y, eye / 4.0);
        // Radiance per irradiance on the plane, and what the grey floor of the map adds.
        let (sky, exact) = small_sun(|toward| match model {
            Model::Lambert => 1.0 / PI,
            Model::Phong => {
                (exponent + 1.0) / (2.0 * PI) * mirror.dot(toward).max(0.0).powf(exponent)
                    / toward.y
            }
            _ => {
                let local = frame.to_local(toward);
                gain * ggx.pdf(local) * ggx.weight(local) / toward.y
            }
        });
        let even = match model {
            Model::Phong => 0.25 * phong_open(exponent, cos, sin),
            _ => 0.25,
        };
        let shader = Direct {
            rays: 64,
            sky,
            ..direct(&surfaces, backend.as_ref(), model)
        };
        let (value, error) = mean(&shader, eye, DVec3::ZERO);
        // Of 64 x 64 places, and of albedos that few points stand for.
        assert!(
            (value - even - exact).abs() < 5.0 * error + 2e-3 * (even + exact),
            "{model:?} {roughness}: {value} ± {error} for {}",
            even + exact
        );
        // 64 pixels of 64 rays: a pixel is off by 4 % of the sun's light at most.
        assert!(
            error * 8.0 < 0.04 * (even + exact),
            "{model:?} {roughness}: ± {error} of {exact}"
        );
        // Straight up the map is its floor; toward the texel's middle it is the texel.
        let behind = |x: f64, y: f64, z: f64| shader.sky.seen([x, y, z])[0];
        assert_eq!(behind(0.0, 1.0, 0.0), 0.25);
        let (polar, turn) = (21.5 * PI / 128.0, 77.5 * PI / 128.0 - PI);
        let seen = behind(
            polar.sin() * turn.sin(),
            polar.cos(),
            polar.sin() * turn.cos(),
        );
        assert!((seen / 2e4 - 1.0).abs() < 1e-6, "{seen}");
    }
}

#[test]
fn panes_are_laid_over_one_another_in_every_sample() {
    let sheet = |z: f32| {
        let corner = Vec3::new(-32.0, -32.0, z);
        [corner, Vec3::X * 64.0, Vec3::Y * 64.0]
    };
    let (world, backend) = see_through(&[-1.0, -2.0, -3.0].map(sheet), 0.5);
    let surfaces = Surfaces::new(&world);
    let shader = Direct {
        background: Some(DVec3::new(0.0, 1.0, 3.0)),
        ..direct(&surfaces, backend.as_ref(), Model::FacingRatio)
    };
    for pixel in 0..64 {
        let sample = seen(DVec3::ZERO, -DVec3::Z, pixel);
        // Each stops half of what the ones before it leave and shows a white front; an eighth is what is behind all.
        let exact = 0.875 + 0.125 * DVec3::new(0.0, 1.0, 3.0);
        assert_eq!(shader.radiance(&sample), exact);
        assert_eq!(shader.coverage(&sample), 0.875);
    }
}
