//! Exact answers of shading from tables: section 4 of the vectors, on spheres with exact normals.

use super::*;
use environment::{IlluminationMap, Image, Projection};
use glam::DVec3;
use maps::{Lobe, Normalise, Request};
use render::{Camera, Weight};

/// The nearest hit of a ray on the unit sphere at the origin.
fn sphere(eye: DVec3, direction: DVec3) -> Option<Surfel> {
    let b = eye.dot(direction);
    let discriminant = b * b - eye.length_squared() + 1.0;
    let t = -b - discriminant.max(0.0).sqrt();
    (discriminant >= 0.0 && t > 0.0).then(|| Surfel {
        normal: (eye + direction * t).normalize(),
        albedo: DVec3::new(0.5, 0.25, 1.0),
        specular: DVec3::new(0.25, 0.5, 0.0),
        ..Surfel::default()
    })
}

/// What a camera sees of a scene that stands still.
pub(super) fn view(camera: &Camera, samples: u32) -> View<'_> {
    let turn = Turn {
        centre: DVec3::ZERO,
        axis: DVec3::Y,
        angle: 0.0,
    };
    View {
        camera,
        turn,
        samples,
        corners: true,
    }
}

/// A buffer of the sphere, `size` pixels wide and high.
pub(super) fn buffer(size: u32, samples: u32) -> (Camera, GBuffer) {
    let eye = DVec3::new(1.0, 0.75, 2.5);
    let camera = Camera::new(eye, DVec3::ZERO, DVec3::Y, 0.9, [size, size]).unwrap();
    let view = view(&camera, samples);
    (camera, GBuffer::take(&view, &(), sphere).unwrap())
}

/// A polar map from a function of the direction, `64 x 32` texels by default.
pub(super) fn polar(width: usize, of: impl Fn([f64; 3]) -> [f32; 3]) -> IlluminationMap {
    let size = (width, width / 2);
    let pixels = (0..size.0 * size.1).map(|at| {
        let (x, y) = ((at % width) as f64 + 0.5, (at / width) as f64 + 0.5);
        of(Projection::Polar.direction(size, x, y).unwrap())
    });
    let image = Image {
        width,
        height: width / 2,
        pixels: pixels.collect(),
    };
    IlluminationMap::new(image, Projection::Polar).unwrap()
}

/// A map without symmetry.
fn uneven(width: usize) -> IlluminationMap {
    polar(width, |[x, y, z]| {
        let wave = 2.0 + x + 0.5 * (5.0 * y + 3.0 * z).sin() + (7.0 * x * z).cos();
        [wave as f32, (wave * wave) as f32, (1.0 + z) as f32]
    })
}

pub(super) const LOOKUPS: [Lookup; 5] = [
    Lookup::Nearest,
    Lookup::Bilinear,
    Lookup::Recursive,
    Lookup::Quad,
    Lookup::Summed,
];

#[test]
fn a_uniform_environment_of_one_gives_kd_plus_ks_everywhere_by_every_look_up() {
    let sky = polar(64, |_| [1.0; 3]);
    let d = Table::new(&maps::diffuse(&sky, (72, 36)).unwrap()).unwrap();
    let s = Table::new(&maps::specular(&sky, 50.0, (64, 32)).unwrap()).unwrap();
    let (_, buffer) = buffer(40, 2);
    for lookup in LOOKUPS {
        let mut picture = Image::filled(40, 40, [0.75; 3]);
        Shader::of(Some(&d), Some(&s)).frame(&buffer, lookup, &mut picture);
        for (k, place) in buffer.places().enumerate() {
            // The environment is as bright as the sphere, so a pixel that it covers in part shows the same.
            let share = buffer.coverage[k];
            for (found, exact) in picture.pixels[place].into_iter().zip([0.75, 0.75, 1.0]) {
                let exact = share * exact + (1.0 - share) * 0.75;
                // Three roundings of the tables, whose values are 1 within one.
                assert!(
                    (found - exact).abs() < 5e-7,
                    "{lookup:?}: {found} for {exact}"
                );
            }
        }
    }
}

#[test]
fn a_seed_table_of_a_uniform_environment_holds_a_quarter_and_one_over_2n_plus_2() {
    let sky = polar(64, |_| [1.0; 3]);
    let request = |lobe| Request {
        lobe,
        normalise: Normalise::Seed,
        projection: Projection::Polar,
        size: (72, 36),
    };
    let lobes = [request(Lobe::Lambert), request(Lobe::Phong(10.0))];
    let maps = maps::convolve(&sky, &lobes).unwrap();
    let tables = [&maps[0], &maps[1]].map(|map| Table::new(map).unwrap());
    let shader = Shader::of(Some(&tables[0]), Some(&tables[1]));
    let [r, ..] = shader.point([0.0, 0.6, 0.8], [0.0, 0.0, 1.0], [[1.0; 3], [1.0; 3]]);
    assert!((r - (0.25 + 1.0 / 22.0)).abs() < 1e-7, "{r}");
}

#[test]
fn a_half_space_lights_a_sphere_by_its_closed_form_within_the_interpolation_error() {
    // I = 1 above the horizon: D = (1 + cos θ)/2, which the table samples 5 degrees apart.
    let sky = polar(512, |[_, y, _]| [f32::from(u8::from(y > 0.0)); 3]);
    let map = maps::diffuse(&sky, (72, 36)).unwrap();
    let table = Table::new(&map).unwrap();
    let (_, buffer) = buffer(120, 1);
    let mut picture = Image::filled(120, 120, [0.0; 3]);
    Shader::of(Some(&table), None).frame(&buffer, Lookup::Bilinear, &mut picture);
    let h = 5f64.to_radians();
    let mut worst = 0.0f64;
    for (k, place) in buffer.places().enumerate() {
        let exact = 0.5 * (1.0 + f64::from(buffer.normal[1][k]));
        worst = worst.max((f64::from(picture.pixels[place][2]) - exact).abs());
    }
    println!("half-space: {worst} at most, bound {}", 0.5 * h * h / 8.0);
    // n h²/8 with n = 1, for a cosine of amplitude 1/2.
    assert!(worst <= 0.5 * h * h / 8.0 + 1e-6, "{worst}");
    assert!(worst > 1e-5, "the error is that of the table");
}

#[test]
fn the_table_reads_what_the_map_reads() {
    let map = uneven(64);
    let table = Table::new(&map).unwrap();
    let mut worst = 0.0f32;
    for k in 0..20_000 {
        let y = 1.0 - 2.0 * (f64::from(k) + 0.5) / 20_000.0;
        let (sin, cos) = (f64::from(k) * 2.399_963_229_728_653).sin_cos();
        let r = (1.0 - y * y).sqrt();
        let direction = [r * cos, y, r * sin];
        let exact = map.bilinear(direction);
        let found = table.bilinear(direction.map(|v| v as f32));
        (0..3).for_each(|c| worst = worst.max((found[c] - exact[c]).abs()));
    }
    // Places are off by 1e-5 texels, neighbours differ by at most 2.
    assert!(worst < 4e-5, "{worst}");
}

#[test]
fn rectangles_of_the_summed_table_are_direct_sums_bit_for_bit() {
    let map = uneven(32);
    let mut image = map.image().clone();
    image.pixels[77] = [1e6; 3];
    let table = Table::new(&IlluminationMap::new(image, Projection::Polar).unwrap()).unwrap();
    let summed = table.summed();
    let texel = |x: i64, y: usize| summed.rectangle([x, x + 1], [y, y + 1]);
    for (left, right) in [(0i64, 32i64), (3, 19), (-5, 2), (20, 45), (-40, 70), (7, 7)] {
        for (top, bottom) in [(0, 16), (2, 3), (0, 9), (5, 5)] {
            let mut sum = [0u64; 4];
            for y in top..bottom {
                for x in left..right {
                    let part = texel(x, y);
                    (0..4).for_each(|c| sum[c] += part[c]);
                }
            }
            assert_eq!(summed.rectangle([left, right], [top, bottom]), sum);
        }
    }
    // A single texel is its own radiance, beside a sun and not.
    for (x, y) in [(13, 2), (14, 2), (0, 15)] {
        let (fx, fy) = (x as f32, y as f32);
        let mean = summed.mean([fx, fx + 1.0], [fy, fy + 1.0]);
        for (found, exact) in mean.into_iter().zip(table.texel(x, y)) {
            assert!((found - exact).abs() <= 1e-6 * exact, "{found} for {exact}");
        }
    }
}

#[test]
fn antialiased_look_ups_of_one_direction_are_bilinear() {
    let table = Table::new(&uneven(64)).unwrap();
    let direction = DVec3::new(0.3, 0.5, -0.7).normalize().as_vec3().to_array();
    let exact = table.bilinear(direction);
    for lookup in [Lookup::Bilinear, Lookup::Recursive, Lookup::Quad] {
        let found = lookup.read(&table, [direction; 4]);
        let close = |c: usize| (found[c] - exact[c]).abs() < 1e-6;
        assert!((0..3).all(close), "{lookup:?} {found:?} {exact:?}");
    }
    // The summed table weighs rows by their solid angles, too.
    let [x, y] = table.place(direction).map(|v| f64::from(v) - 0.5);
    let (i, j) = (x as usize, y as usize);
    let (right, low) = (x.fract(), y.fract());
    let omega = |j| Projection::Polar.solid_angle((64, 32), 0, j);
    let (upper, lower) = ((1.0 - low) * omega(j), low * omega(j + 1));
    let found = Lookup::Summed.read(&table, [direction; 4]);
    for c in 0..3 {
        let texel = |i, j| f64::from(table.texel(i, j)[c]);
        let row = |j| (1.0 - right) * texel(i, j) + right * texel(i + 1, j);
        let exact = (upper * row(j) + lower * row(j + 1)) / (upper + lower);
        assert!(
            (f64::from(found[c]) - exact).abs() < 1e-6 * exact,
            "{found:?} {exact}"
        );
    }
}

#[test]
fn a_quad_that_holds_a_pole_or_the_seam_averages_what_it_holds() {
    let table = Table::new(&polar(64, |[_, y, _]| [y.max(0.0) as f32, 1.0, 0.0])).unwrap();
    let around = |axis: DVec3, half: f64| {
        let (a, b) = axis.any_orthonormal_pair();
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(s, t)| {
            (axis + (a * s + b * t) * half)
                .normalize()
                .as_vec3()
                .to_array()
        })
    };
    for (axis, exact) in [
        (DVec3::Y, 0.93),
        (DVec3::NEG_Y, 0.0),
        (DVec3::new(0.0, 1.0, -1.0).normalize(), 0.67),
        (DVec3::new(0.1, 0.4, -1.0).normalize(), 0.35),
    ] {
        for lookup in [Lookup::Recursive, Lookup::Quad, Lookup::Summed] {
            let found = lookup.read(&table, around(axis, 0.3));
            // A square of 33 degrees; methods differ in its shape by a tenth.
            assert!(
                (f64::from(found[0]) - exact).abs() < 0.06,
                "{lookup:?} {axis}: {found:?}"
            );
            assert!(
                (found[1] - 1.0).abs() < 1e-6,
                "{lookup:?} {axis}: {found:?}"
            );
        }
    }
}

#[test]
fn refraction_without_a_change_of_index_goes_straight_on() {
    for k in 0..100 {
        let (sin, cos) = (0.015 * k as f32).sin_cos();
        let (normal, view) = ([0.0, 1.0, 0.0], [sin, cos, 0.0]);
        assert_eq!(
            Index::Refraction(1.0).direction(normal, view),
            [-sin, -cos, 0.0]
        );
    }
}

#[test]
fn refraction_obeys_snell_and_reflects_totally_beyond_the_critical_angle() {
    let normal = [0.0, 0.0, 1.0];
    for eta in [1.0 / 1.5, 1.5, 1.0 / 2.4] {
        let straight = Index::Refraction(eta).direction(normal, normal);
        assert!(
            (straight[2] + 1.0).abs() < 1e-7,
            "normal incidence: {straight:?}"
        );
        for k in 0..90 {
            let (sin, cos) = (k as f32).to_radians().sin_cos();
            let view = [sin, 0.0, cos];
            let found = Index::Refraction(eta).direction(normal, view);
            if eta * sin > 1.0 {
                assert_eq!(found, Index::Mirror.direction(normal, view));
            } else {
                let length = index::dot(found, found);
                assert!((found[0] + eta * sin).abs() < 1e-6 && found[2] <= 0.0);
                assert!((length - 1.0).abs() < 1e-5, "{eta} {k}: {length}");
            }
        }
    }
}

#[test]
fn retro_reflection_at_normal_view_is_the_mirrored_one() {
    let n = [0.0, 0.0, 1.0];
    assert_eq!(Index::Retro.direction(n, n), Index::Mirror.direction(n, n));
    let table = Table::new(&uneven(64)).unwrap();
    let mirror = Shader::of(None, Some(&table));
    let retro = Shader {
        index: Index::Retro,
        ..mirror.clone()
    };
    let material = [[0.0; 3], [1.0; 3]];
    assert_eq!(retro.point(n, n, material), mirror.point(n, n, material));
    assert_eq!(retro.point([0.0, 0.6, 0.8], n, material), table.bilinear(n));
}

#[test]
fn each_pixel_reads_s_of_its_own_exponent() {
    // Three tables of one value each; materials of four exponents side by side.
    let tables = [1.0, 2.0, 4.0].map(|value| Table::new(&polar(8, |_| [value; 3])).unwrap());
    let shader = Shader {
        glosses: [4.0, 16.0, 64.0]
            .into_iter()
            .zip(tables.iter().map(|table| vec![table]))
            .collect(),
        ..Shader::of(None, None)
    };
    let exponents = [2.0, 4.0, 8.0, 63.0, 1000.0];
    let camera = Camera::new(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y, 0.1, [90, 3]).unwrap();
    let view = view(&camera, 1);
    let column = |direction: DVec3| {
        ((direction.dot(camera.right) * 100.0).floor() as i64).rem_euclid(5) as usize
    };
    let hit = |_: DVec3, direction: DVec3| {
        let which = column(direction);
        Some(Surfel {
            normal: DVec3::Z,
            albedo: DVec3::ZERO,
            specular: DVec3::splat(0.5),
            exponent: exponents[which],
            object: which as u32,
            ..Surfel::default()
        })
    };
    let buffer = GBuffer::take(&view, &(), hit).unwrap();
    let between = |n: f64, a: f64, b: f64| (n.ln_1p() - a.ln_1p()) / (b.ln_1p() - a.ln_1p());
    let exact = [
        1.0,
        1.0,
        1.0 + between(8.0, 4.0, 16.0),
        2.0 + 2.0 * between(63.0, 16.0, 64.0),
        4.0,
    ];
    for lookup in LOOKUPS {
        let mut picture = Image::filled(90, 3, [0.0; 3]);
        shader.frame(&buffer, lookup, &mut picture);
        for (k, pixel) in picture.pixels.iter().enumerate() {
            let direction = camera.direction((k % 90) as f64 + 0.5, (k / 90) as f64 + 0.5);
            let exact = 0.5 * exact[column(direction)];
            assert!(
                (f64::from(pixel[1]) - exact).abs() < 1e-6,
                "{lookup:?} {k}: {pixel:?} for {exact}"
            );
        }
    }
}

#[test]
fn leaves_show_the_light_behind_them() {
    // D of a sky that is 1 above the horizon is (1 + y)/2, and a leaf that lets half through is grey from every side.
    let d = polar(512, |[_, y, _]| [(0.5 + 0.5 * y) as f32; 3]);
    let d = Table::new(&d).unwrap();
    let leaf = |translucency| Shader {
        translucency,
        ..Shader::of(Some(&d), None)
    };
    let material = [[1.0; 3], [0.0; 3]];
    for normal in [[0.0, 1.0, 0.0], [0.0, -0.6, 0.8], [0.48, 0.6, 0.64]] {
        for t in [0.0, 0.25, 0.5, 1.0] {
            let found = leaf(t).point(normal, [0.0, 0.0, 1.0], material)[1];
            let exact = 0.5 + 0.5 * (1.0 - 2.0 * t) * normal[1];
            assert!((found - exact).abs() < 1e-4, "{t} {normal:?}: {found}");
        }
    }
    let (_, buffer) = buffer(40, 1);
    let mut picture = Image::filled(40, 40, [0.0; 3]);
    leaf(0.25).frame(&buffer, Lookup::Bilinear, &mut picture);
    for (k, place) in buffer.places().enumerate() {
        let list = |lists: &[Vec<f32>; 3]| [0, 1, 2].map(|c: usize| lists[c][k]);
        let material = buffer.palette[buffer.material[k] as usize].map(|[r, g, b, _]| [r, g, b]);
        let point = leaf(0.25).point(list(&buffer.normal), list(&buffer.view), material);
        assert!((picture.pixels[place][0] - point[0]).abs() < 1e-6);
    }
}

#[test]
fn varnish_adds_half_of_the_mirrored_environment() {
    let (sky, d) = (polar(64, |_| [3.0; 3]), polar(2, |_| [1.0; 3]));
    let (sky, d) = (Table::new(&sky).unwrap(), Table::new(&d).unwrap());
    let varnished = Shader {
        coat: Some(&sky),
        ..Shader::of(Some(&d), None)
    };
    let value = varnished.point([0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [[0.25; 3], [0.0; 3]]);
    assert_eq!(value, [1.75; 3]);
}

#[test]
fn schlick_and_tables_weigh_by_the_view_angle() {
    let f0 = 0.04;
    assert_eq!(Weight::Schlick(f0).at(1.0), [f0; 3]);
    assert_eq!(Weight::Schlick(f0).at(0.0), [1.0; 3]);
    assert_eq!(Weight::Schlick(0.5).at(0.5), [0.5 + 0.5 / 32.0; 3]);
    let table = Weight::Table(vec![[0.25, 2.0, 4.0, 0.0], [0.75, 1.0, 2.0, 1.0]]);
    let exact = [[2.0, 4.0, 0.0], [1.5, 3.0, 0.5], [1.0, 2.0, 1.0]];
    assert_eq!([0.0, 0.5, 1.0].map(|c| table.at(c)), exact);
}

#[test]
fn blocks_of_pixels_give_what_single_points_give() {
    let (d, s) = (uneven(36), uneven(128));
    let [d, s] = [&d, &s].map(|map| Table::new(map).unwrap());
    for index in [Index::Mirror, Index::Retro, Index::Refraction(0.7)] {
        let shader = Shader {
            index,
            coat: Some(&s),
            diffuse_weight: Weight::Schlick(0.3),
            ..Shader::of(Some(&d), Some(&s))
        };
        let (_, buffer) = buffer(90, 1);
        let mut picture = Image::filled(90, 90, [0.0; 3]);
        shader.frame(&buffer, Lookup::Bilinear, &mut picture);
        for (k, place) in buffer.places().enumerate() {
            let list = |lists: &[Vec<f32>; 3]| [0, 1, 2].map(|c: usize| lists[c][k]);
            let material =
                buffer.palette[buffer.material[k] as usize].map(|[r, g, b, _]| [r, g, b]);
            let point = shader.point(list(&buffer.normal), list(&buffer.view), material);
            assert_eq!(picture.pixels[place], point, "vector width does not show");
        }
    }
}

#[test]
fn a_turned_sphere_is_the_same_and_a_turned_camera_sees_the_environment_turned() {
    let map = uneven(64);
    let table = Table::new(&map).unwrap();
    let (camera, _) = buffer(48, 1);
    let taken = |angle: f64| {
        let turn = Turn {
            centre: DVec3::ZERO,
            axis: DVec3::Y,
            angle,
        };
        let view = View {
            camera: &camera,
            turn,
            samples: 1,
            corners: false,
        };
        let mut picture = backdrop(&camera, Some(&table));
        let buffer = GBuffer::take(&view, &(), sphere).unwrap();
        Shader::of(None, Some(&table)).frame(&buffer, Lookup::Bilinear, &mut picture);
        picture
    };
    let (still, turned) = (taken(0.0), taken(1.0));
    for (a, b) in still.pixels.iter().zip(&turned.pixels) {
        // Normals differ by rounding: 1e-6 of the slope of the map.
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-4), "{a:?} {b:?}");
    }
}

#[test]
fn a_pixel_on_the_edge_of_an_object_reflects_nothing_between_the_objects() {
    // Two walls, each of which mirrors the dark side; the light between is mirrored by neither.
    let light = polar(64, |[_, _, z]| [if z > 0.9 { 100.0 } else { 0.0 }; 3]);
    let table = Table::new(&light).unwrap();
    let eye = DVec3::Z * 5.0;
    let camera = Camera::new(eye, DVec3::ZERO, DVec3::Y, 0.1, [9, 9]).unwrap();
    let turn = Turn {
        centre: DVec3::ZERO,
        axis: DVec3::Y,
        angle: 0.0,
    };
    let view = View {
        camera: &camera,
        turn,
        samples: 2,
        corners: true,
    };
    let buffer = GBuffer::take(&view, &(), |_, direction| {
        let right = direction.x > 0.0;
        Some(Surfel {
            normal: DVec3::new(if right { 0.6 } else { -0.6 }, 0.0, 0.8),
            albedo: DVec3::ZERO,
            specular: DVec3::ONE,
            object: u32::from(right),
            ..Surfel::default()
        })
    })
    .unwrap();
    for lookup in LOOKUPS {
        let mut picture = Image::filled(9, 9, [1.0; 3]);
        Shader::of(None, Some(&table)).frame(&buffer, lookup, &mut picture);
        assert_eq!(picture.pixels, [[0.0; 3]; 81], "{lookup:?}");
    }
}
