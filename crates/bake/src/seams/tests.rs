//! A sphere of six charts that are turned, mirrored and of unlike density, under a smooth light: both sides of each
//! seam must show the same.

mod borders;

use super::solve::Moved;
use super::{Across, Known, SeamStats, Seams};
use crate::options::{Options, Seams as Scope};
use crate::plan::Plan;
use atlas::{Atlas, PageRaster, UvMode};
use glam::{DMat2, DVec2, DVec3};
use rays::World;
use scene::{Scene, authored};
use std::sync::Arc;

const SIZE: u32 = 64;
/// Quads on the edge of each side.
const CUTS: usize = 24;

/// A side of the cube, and how its chart lies on the page: middle and edge in texels, turn, mirror.
const CHARTS: [([f64; 2], f64, f64, bool); 6] = [
    ([10.5, 10.3], 14.0, 0.0, false),
    ([32.4, 11.2], 14.0, 13.0, false),
    ([53.1, 10.7], 13.0, 45.0, false),
    ([11.0, 32.7], 14.0, 90.0, true),
    ([32.0, 33.0], 7.0, 0.0, false),
    ([50.0, 44.0], 21.0, 20.0, false),
];

/// The sphere as one mesh, or with each side a mesh of its own, over the plane y = -1.2.
fn sphere(apart: bool) -> Scene {
    let mut meshes = vec![authored::Mesh::default()];
    for (side, (middle, edge, turn, mirror)) in CHARTS.into_iter().enumerate() {
        if apart && side > 0 {
            meshes.push(authored::Mesh::default());
        }
        let Some(mesh) = meshes.last_mut() else {
            continue;
        };
        let first = mesh.positions.len() as u32;
        let axis = side % 3;
        let sign = if side < 3 { 1.0 } else { -1.0 };
        let turned = DMat2::from_angle(turn.to_radians());
        for row in 0..=CUTS {
            for column in 0..=CUTS {
                let [s, t] = [column, row].map(|k| k as f64 / CUTS as f64 - 0.5);
                // Equal angles, so that texels are nearly square.
                let [a, b] = [s, t].map(|x| (x * std::f64::consts::FRAC_PI_2).tan());
                let mut p = DVec3::ZERO;
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, sign * a, b);
                let p = p.normalize();
                mesh.positions.push(p.as_vec3().to_array());
                mesh.normals.push(p.as_vec3().to_array());
                let local = DVec2::new(if mirror { -s } else { s }, t) * edge;
                let uv = (DVec2::from(middle) + turned * local) / f64::from(SIZE);
                mesh.uvs.push(uv.as_vec2().to_array());
            }
        }
        let at = |row: usize, column: usize| first + (row * (CUTS + 1) + column) as u32;
        for row in 0..CUTS {
            for column in 0..CUTS {
                let [a, b] = [at(row, column), at(row, column + 1)];
                let [c, d] = [at(row + 1, column + 1), at(row + 1, column)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    Scene::from_meshes(meshes, vec![]).unwrap()
}

/// Light over the sphere, in steps of up to 8/255 a texel: waves, by which the weights of the least squares were
/// chosen, and the shadow of something near, which never was.
const LIGHTS: [fn(DVec3) -> f64; 2] = [
    |p| 0.5 + 0.4 * (2.0 * p.y + 0.7 * p.x * p.z).sin(),
    |p| (1.0 - 0.9 / (1.0 + 6.0 * (p - DVec3::new(0.5, 0.6, 0.7)).length_squared())).powi(2),
];

struct Page {
    world: World,
    atlas: Atlas,
    coverage: Vec<f32>,
    values: Vec<f32>,
    /// Points of the surface in texels of the page, with their light.
    truth: Vec<(DVec2, f64)>,
}

/// The page with each texel the mean of the light over its footprint, plus an error of `noise`.
fn page(scene: Scene, light: fn(DVec3) -> f64, noise: f64) -> Page {
    let (_, world) = Plan::of(&Arc::new(scene), &Options::default()).unwrap();
    let options = atlas::Options {
        uv: UvMode::Keep,
        page_size: SIZE,
        ..atlas::Options::default()
    };
    let atlas = atlas::layout(world.scene(), &options, &|| false).unwrap();
    let raster = PageRaster::new(world.scene(), &atlas, 0);
    let mut coverage = vec![0.0; (SIZE * SIZE) as usize];
    let mut values = coverage.clone();
    let mut truth = Vec::new();
    for index in 0..raster.tiles().len() {
        let tile = raster.tile(index);
        for footprint in &tile.footprints {
            let texel = (footprint.y * SIZE + footprint.x) as usize;
            let mut sum = 0.0;
            for k in 0..256u32 {
                let u = [
                    (f64::from(k % 16) + 0.5) / 16.0,
                    (f64::from(k / 16) + 0.5) / 16.0,
                ];
                let point = tile.sample(footprint, u);
                let weights = DVec3::from(point.weights);
                let corners = world.corners(point.instance, point.triangle);
                let value = light((0..3).map(|c| corners[c] * weights[c]).sum());
                sum += value / 256.0;
                if k % 17 == 3 {
                    let (uv, _) =
                        atlas::triangle_uv(world.scene(), &atlas, point.instance, point.triangle);
                    let p: DVec2 = (0..3).map(|c| uv[c].as_dvec2() * weights[c]).sum();
                    truth.push((p * f64::from(SIZE), value));
                }
            }
            // A hash in -1..1: the error needs no law, only no likeness to the neighbours'.
            let hash = (texel as u32).wrapping_mul(2_654_435_761) >> 8;
            let error = noise * (f64::from(hash) / f64::from(1u32 << 23) - 1.0);
            coverage[texel] = footprint.coverage;
            values[texel] = (sum + error) as f32;
        }
    }
    Page {
        world,
        atlas,
        coverage,
        values,
        truth,
    }
}

/// Root mean square of what a bilinear look-up is off, gutters filled from their neighbours.
fn rmse(page: &Page, values: &[f32], gutters: &[(u32, f32)]) -> f64 {
    let mut values = values.to_vec();
    atlas::Dilation::new(&page.coverage, SIZE, 2).apply(&mut values);
    for &(texel, value) in gutters {
        values[texel as usize] = value;
    }
    let squares = page.truth.iter().map(|&(p, light)| {
        let found: f64 = super::solve::taps(p, SIZE)
            .iter()
            .map(|&(texel, weight)| f64::from(values[texel as usize]) * f64::from(weight))
            .sum();
        (found - light).powi(2)
    });
    (squares.sum::<f64>() / page.truth.len() as f64).sqrt()
}

/// The page's seams solved for these values, of which so much is known.
fn moved(page: &Page, values: &[f32], std_err: f32, validity: Option<&[f32]>) -> Moved {
    let across = Across::default();
    let seams = Seams::find(&page.world, &page.atlas, 0, Scope::Scene, &across);
    let raster = PageRaster::new(page.world.scene(), &page.atlas, 0);
    let known = Known {
        tied: Vec::new(),
        values,
        std_errs: &vec![std_err; values.len()],
        unit: 1.0,
        most: 1.0,
    };
    let system = seams.system(&page.world, &raster, SIZE, validity);
    let moved = system.solve(&[known], &page.coverage);
    moved.into_iter().next().expect("a plane")
}

/// What seams leave, and the error of look-ups before and after.
fn solved(apart: bool, light: fn(DVec3) -> f64, noise: f64) -> (SeamStats, [f64; 2]) {
    let page = page(sphere(apart), light, noise);
    let moved = moved(&page, &page.values, noise.max(1e-4) as f32, None);
    let mut values = page.values.clone();
    for &(texel, value) in &moved.values {
        values[texel as usize] = value;
    }
    let errors = [
        rmse(&page, &page.values, &[]),
        rmse(&page, &values, &moved.values),
    ];
    (moved.stats, errors)
}

#[test]
fn both_sides_of_turned_mirrored_and_finer_charts_show_the_same() {
    for light in LIGHTS {
        for (apart, noise) in [(false, 0.0), (false, 0.01), (true, 0.0), (true, 0.01)] {
            let (stats, [before, after]) = solved(apart, light, noise);
            assert!(stats.points > 12 * 20, "{stats:?}");
            assert!(stats.max_before > 4.0 / 255.0, "{stats:?}");
            assert!(stats.max_after <= 1.0 / 255.0, "{stats:?}");
            assert!(after <= before, "{before} -> {after}");
        }
    }
}

/// A contact: dark in a line a fraction of a texel beside a seam, and light a texel away.
fn contact(p: DVec3) -> f64 {
    1.0 - 0.95 * (-(p.x - p.y - 0.03).abs() / 0.04).exp()
}

#[test]
fn whole_texels_do_not_give_way_to_a_contact() {
    let page = page(sphere(false), contact, 0.0);
    let moved = moved(&page, &page.values, 1e-4, None);
    let (mut most, mut count) = (0.0f32, 0);
    for &(texel, value) in &moved.values {
        if page.coverage[texel as usize] > 0.99 {
            most = most.max((value - page.values[texel as usize]).abs());
            count += 1;
        }
    }
    assert!(count > 300 && most < 0.05, "{count} {most}");
}

#[test]
fn no_texel_goes_farther_from_its_mean_than_it_may() {
    let edge = |p: DVec3| if p.x > p.y { 0.75 } else { 0.25 };
    let page = page(sphere(false), edge, 0.0);
    for (std_err, bound) in [(1e-3, 0.1f32), (0.04, 0.14)] {
        let moved = moved(&page, &page.values, std_err, None);
        let covered = moved
            .values
            .iter()
            .filter(|(texel, _)| page.coverage[*texel as usize] > 0.0);
        let far = covered.map(|&(texel, value)| (value - page.values[texel as usize]).abs());
        let most = far.fold(0.0, f32::max);
        assert!(
            most > 0.9 * bound && most < bound + 1e-5,
            "{most} of {bound}"
        );
    }
}

#[test]
fn what_agrees_stays_to_the_last_bit() {
    let page = page(sphere(false), |_| 0.7, 0.0);
    let values: Vec<f32> = page.coverage.iter().map(|&c| 0.7 * c.ceil()).collect();
    let moved = moved(&page, &values, 1e-4, None);
    assert!(moved.values.iter().all(|&(_, value)| value == 0.7));
    assert!(moved.stats.max_after < 1e-15, "{:?}", moved.stats);
}

#[test]
fn planes_solved_together_move_as_alone_with_any_number_of_threads() {
    let page = page(sphere(false), LIGHTS[0], 0.01);
    let across = Across::default();
    let seams = Seams::find(&page.world, &page.atlas, 0, Scope::Scene, &across);
    let raster = PageRaster::new(page.world.scene(), &page.atlas, 0);
    let system = seams.system(&page.world, &raster, SIZE, None);
    let std_errs = vec![0.01; page.values.len()];
    // Light of other units, and planes that end where they would go beyond.
    let unit = |k: i32| 3.0f32.powi(2 * k - 4);
    let planes = (0..6).map(|k| page.values.iter().map(|v| v * unit(k)).collect());
    let planes: Vec<Vec<f32>> = planes.collect();
    let known = |k: usize| Known {
        tied: Vec::new(),
        values: &planes[k],
        std_errs: &std_errs,
        unit: unit(k as i32).into(),
        most: f64::from(unit(k as i32)) * 0.6,
    };
    let on = |threads: usize, planes: &[Known<'_>]| -> Vec<Vec<(u32, f32)>> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let moved = pool
            .expect("a pool")
            .install(|| system.solve(planes, &page.coverage));
        moved.into_iter().map(|moved| moved.values).collect()
    };
    let alone: Vec<_> = (0..6).flat_map(|k| on(1, &[known(k)])).collect();
    let together: Vec<_> = (0..6).map(known).collect();
    assert!(alone[0] != alone[1]);
    assert_eq!(on(1, &together), alone);
    assert_eq!(on(3, &together), alone);
}

#[test]
fn objects_apart_have_no_seams_of_their_own() {
    let page = page(sphere(true), LIGHTS[0], 0.0);
    assert!(
        Seams::find(
            &page.world,
            &page.atlas,
            0,
            Scope::Object,
            &Across::default()
        )
        .is_empty()
    );
    assert!(Seams::find(&page.world, &page.atlas, 0, Scope::Off, &Across::default()).is_empty());
}

#[test]
fn what_is_seen_does_not_give_way_to_what_is_buried() {
    let page = page(sphere(true), LIGHTS[0], 0.0);
    let raster = PageRaster::new(page.world.scene(), &page.atlas, 0);
    // All of the second object is buried.
    let mut validity = vec![1.0; page.values.len()];
    for index in 0..raster.tiles().len() {
        let tile = raster.tile(index);
        for footprint in &tile.footprints {
            if tile.pieces_of(footprint)[0].instance == 1 {
                validity[(footprint.y * SIZE + footprint.x) as usize] = 0.0;
            }
        }
    }
    let seen = |dark: bool| -> Vec<(u32, f32)> {
        let shown = page.values.iter().zip(&validity);
        let values: Vec<f32> = match dark {
            true => shown.map(|(value, validity)| value * validity).collect(),
            false => page.values.clone(),
        };
        let moved = moved(&page, &values, 1e-4, Some(&validity));
        assert!(moved.stats.points > 100, "{:?}", moved.stats);
        let of_seen = |(texel, _): &(u32, f32)| {
            let texel = *texel as usize;
            page.coverage[texel] > 0.0 && validity[texel] > 0.0
        };
        moved.values.into_iter().filter(of_seen).collect()
    };
    assert_eq!(seen(true), seen(false));
}

/// A rectangle from a corner along two edges, ten texels a unit, with its chart's corner on the page.
fn panel(corner: DVec3, along: DVec3, up: DVec3, at: [f64; 2]) -> authored::Mesh {
    let corners = [corner, corner + along, corner + along + up, corner + up];
    let (across, down) = (along.length() * 10.0, up.length() * 10.0);
    let places = [[0.0, 0.0], [across, 0.0], [across, down], [0.0, down]];
    let uv = |place: [f64; 2]| (DVec2::from(place) + DVec2::from(at)) / f64::from(SIZE);
    let mut mesh = authored::Mesh::default();
    mesh.positions = corners.map(|p| p.as_vec3().to_array()).to_vec();
    mesh.uvs = places.map(|p| uv(p).as_vec2().to_array()).to_vec();
    mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
    mesh
}

#[test]
fn light_may_end_where_a_wall_stands_on_a_seam() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    // Two floors that meet at x = 0, 20 texels long, and a wall on half of that: from the floor up, through it, a
    // little beside it.
    let found = |wall: &[authored::Mesh]| {
        let floors = [
            panel(-x, z * 2.0, x, [2.0, 2.0]),
            panel(DVec3::ZERO, z * 2.0, x, [2.0, 20.0]),
        ];
        let scene = Scene::from_meshes([&floors, wall].concat(), vec![]).unwrap();
        let page = page(scene, LIGHTS[0], 0.0);
        let across = Across::default();
        let seams = Seams::find(&page.world, &page.atlas, 0, Scope::Scene, &across);
        seams.points.len()
    };
    let wall = |corner: DVec3| [panel(corner, z, y, [30.0, 40.0])];
    assert_eq!(found(&[]), 40);
    assert_eq!(found(&wall(DVec3::ZERO)), 20);
    assert_eq!(found(&wall(-0.5 * y)), 20);
    assert_eq!(found(&wall(0.02 * x)), 20);
    // A ramp that begins there, as steep as 45 and 20 degrees; what hardly rises lies on the floor.
    for (rise, points) in [(1.0, 20), (0.36, 20), (0.2, 40)] {
        let ramp = [panel(
            DVec3::ZERO,
            z,
            (x + rise * y).normalize(),
            [30.0, 40.0],
        )];
        assert_eq!(found(&ramp), points, "{rise}");
    }
    // What hangs below or stands a texel away parts nothing.
    assert_eq!(found(&wall(-y)), 40);
    assert_eq!(found(&wall(0.1 * x)), 40);
}

#[test]
fn a_kerb_parts_two_floors_whichever_comes_first() {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    // The floor at x > 0 is higher by so much, with a face below its edge or without.
    let found = |step: f64, face: bool, higher_first: bool| {
        let mut meshes = vec![
            panel(-x, z * 2.0, x, [2.0, 2.0]),
            panel(step * y, z * 2.0, x, [2.0, 20.0]),
        ];
        if higher_first {
            meshes.reverse();
        }
        if face {
            meshes.push(panel(DVec3::ZERO, z * 2.0, step * y, [30.0, 40.0]));
        }
        let scene = Scene::from_meshes(meshes, vec![]).unwrap();
        let page = page(scene, LIGHTS[0], 0.0);
        let across = Across::default();
        let seams = Seams::find(&page.world, &page.atlas, 0, Scope::Scene, &across);
        seams.points.len()
    };
    for higher_first in [false, true] {
        // A texel is 0.1 wide.
        assert_eq!(found(0.008, true, higher_first), 0);
        assert_eq!(found(0.008, false, higher_first), 40);
        assert_eq!(found(0.002, true, higher_first), 40);
    }
}
