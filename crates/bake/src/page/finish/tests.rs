//! The order of the last steps, by what each leaves behind.

use super::*;
use crate::options::{Effort, Seams as Joins};
use crate::page::Baker;
use crate::seams::SeamPoint;
use glam::DVec2;
use scene::Scene;
use scene::authored::Mesh;
use std::collections::BTreeSet;
use std::sync::Arc;

const SIZE: u32 = 64;

/// A mesh of quads, counter-clockwise seen from the front.
fn quads(name: &str, positions: Vec<[f32; 3]>, quads: &[[u32; 4]]) -> Mesh {
    let mut mesh = Mesh::default();
    (mesh.name, mesh.positions) = (name.into(), positions);
    mesh.triangles = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    mesh
}

/// Two halves of a floor that abut, with a box sunk into both.
fn floor() -> Scene {
    let half = |name, x: [f32; 2]| {
        let [low, high] = x;
        let corners = [[low, -2.0], [high, -2.0], [high, 2.0], [low, 2.0]];
        let positions = corners.map(|[x, y]| [x, y, 0.0]).into();
        quads(name, positions, &[[0, 1, 2, 3]])
    };
    let corner = |k: usize| {
        let pick = |bit: usize, ends: [f32; 2]| ends[k >> bit & 1];
        [
            pick(0, [-0.4, 0.7]),
            pick(1, [-0.3, 0.5]),
            pick(2, [-0.5, 0.6]),
        ]
    };
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let sunk = quads("box", (0..8).map(corner).collect(), &faces);
    let meshes = vec![half("left", [-2.0, 0.0]), half("right", [0.0, 2.0]), sunk];
    Scene::from_meshes(meshes, Vec::new()).expect("a scene")
}

/// The page of that floor, and the points on its seams.
fn baked(denoise: Denoise, seams: Joins) -> (BakedPage, Vec<SeamPoint>) {
    let layers = [
        Layer::Diffuse,
        Layer::Validity,
        Layer::Position,
        Layer::Normal,
        Layer::Object,
    ];
    let options = Options {
        effort: Effort::Rays(16),
        layers: layers.to_vec(),
        denoise,
        seams,
        ..Options::default()
    };
    page_of(floor(), &options, SIZE)
}

/// The page of this edge of a scene, and the points on its seams.
fn page_of(scene: Scene, options: &Options, size: u32) -> (BakedPage, Vec<SeamPoint>) {
    let scene = Arc::new(scene);
    let (plan, world) = Plan::of(&scene, options).expect("a plan");
    let layout = atlas::Options {
        page_size: size,
        ..Default::default()
    };
    let atlas = atlas::layout(&scene, &layout, &|| false).expect("a layout");
    let kind = rays::BackendKind::Obvhs(rays::TreeKind::default());
    let backend = rays::build(kind, &world, 0).expect("a backend");
    let baker = Baker::new(&world, &plan, backend.as_ref(), &atlas, options);
    let mut page = baker.start(0);
    baker.run(&mut page, &());
    assert!(page.finished);
    let seams = Seams::find(&world, &atlas, 0, options.seams, baker.site().across);
    (page, seams.points().to_vec())
}

fn diffuse(page: &BakedPage) -> &[f32] {
    fact(page, Layer::Diffuse, 0)
}

/// The texels that a bilinear look-up reads at a place in texels, with their weights.
fn taps(at: DVec2) -> [(usize, f64); 4] {
    let corner = (at - 0.5).floor();
    let share = at - 0.5 - corner;
    [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(dx, dy)| {
        let weight = |part: f64, far: f64| if far > 0.0 { part } else { 1.0 - part };
        let texel = (corner.y + dy) * f64::from(SIZE) + corner.x + dx;
        (texel as usize, weight(share.x, dx) * weight(share.y, dy))
    })
}

#[test]
fn what_is_buried_carries_on_what_was_denoised() {
    let (plain, _) = baked(Denoise::Off, Joins::Off);
    let (page, _) = baked(Denoise::Regression, Joins::Off);
    assert!(diffuse(&plain) != diffuse(&page));
    let buried = fact(&page, Layer::Validity, 0).iter();
    let covered = fact(&page, Layer::Coverage, 0);
    let buried = buried.zip(covered).filter(|(v, c)| **v == 0.0 && **c > 0.0);
    assert!(buried.count() > 20);
    let mut again = diffuse(&page).to_vec();
    Mends::of_unseen(&surface(&page)).apply(&mut again, 0.0, 1.0);
    assert!(again == diffuse(&page));
}

#[test]
fn nothing_moves_a_seam_once_it_is_solved() {
    let (page, points) = baked(Denoise::Regression, Joins::Scene);
    let validity = fact(&page, Layer::Validity, 0);
    let covered = fact(&page, Layer::Coverage, 0);
    // Where a side lies in the box, nothing is asked of the other.
    let is_seen = |side: DVec2| {
        let taps = taps(side).into_iter().filter(|tap| covered[tap.0] > 0.0);
        taps.into_iter().any(|tap| validity[tap.0] > 0.0)
    };
    let seen: Vec<_> = points
        .iter()
        .filter(|point| point.sides.iter().all(|side| is_seen(*side)))
        .collect();
    let stats = page.stats.seams;
    assert_eq!(stats.points, seen.len() as u64);
    assert!(
        stats.squares_after < 0.1 * stats.squares_before,
        "{stats:?}"
    );
    let step = |point: &&SeamPoint| {
        let read = |tap: (usize, f64)| tap.1 * f64::from(diffuse(&page)[tap.0]);
        let [a, b] = point
            .sides
            .map(|side| taps(side).map(read).iter().sum::<f64>());
        (a - b).powi(2)
    };
    let found: f64 = seen.iter().map(step).sum();
    let told = stats.squares_after;
    assert!(
        (found - told).abs() < 0.01 * told + 1e-9,
        "{found} for {told}"
    );
}

#[test]
fn gutters_are_filled_from_what_seams_left_and_seams_set_those_alone_that_they_read() {
    for denoise in [Denoise::Off, Denoise::Regression] {
        for seams in [Joins::Off, Joins::Scene] {
            let (page, points) = baked(denoise, seams);
            let read = points.iter().flat_map(|point| point.sides).flat_map(taps);
            let read: BTreeSet<usize> = read.map(|tap| tap.0).collect();
            let dilation = Dilation::new(fact(&page, Layer::Coverage, 0), SIZE, atlas::RINGS);
            let mut filled = diffuse(&page).to_vec();
            dilation.apply(&mut filled);
            let targets = dilation.targets().iter().map(|&texel| texel as usize);
            let set: Vec<usize> = targets
                .filter(|&texel| filled[texel] != diffuse(&page)[texel])
                .collect();
            let others = set.iter().filter(|texel| !read.contains(texel)).count();
            assert_eq!(others, 0, "{denoise:?} {seams:?}");
            assert_eq!(set.is_empty(), seams == Joins::Off);
        }
    }
}

/// A box that passes through a roof: along the cut all texels of a wall are alike, whatever tile they are of.
#[test]
fn what_is_sealed_does_not_depend_on_tiles() {
    let corner =
        |k: usize| [0, 1, 2].map(|bit| [[-2.0, 2.0], [-2.0, 2.0], [0.0, 2.0]][bit][k >> bit & 1]);
    let faces = [
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let roof = |y: f32, up: f32| {
        let [low, high] = [[y, 1.7 + up], [0.0, 3.2 + up]];
        [(-2.3, low), (2.3, low), (2.3, high), (-2.3, high)].map(|(x, [y, z])| [x, y, z])
    };
    for step in 0..8 {
        let up = 0.008 * step as f32;
        let walls = quads("walls", (0..8).map(corner).collect(), &faces);
        let sheets = [2.3, -2.3].into_iter().flat_map(|y| roof(y, up)).collect();
        let roofs = quads("roofs", sheets, &[[0, 1, 2, 3], [4, 5, 6, 7]]);
        let scene = Scene::from_meshes(vec![walls, roofs], Vec::new()).expect("a scene");
        let layers = [
            Layer::Diffuse,
            Layer::Sealed,
            Layer::Position,
            Layer::Object,
        ];
        let options = Options {
            effort: Effort::Rays(64),
            layers: layers.to_vec(),
            denoise: Denoise::Off,
            seams: Joins::Off,
            ..Options::default()
        };
        let (page, _) = page_of(scene, &options, 256);
        let at = |channel: usize, texel: usize| fact(&page, Layer::Position, channel)[texel];
        let mut rows: std::collections::BTreeMap<i32, Vec<f32>> = Default::default();
        for texel in 0..page.texels() {
            let is_wall = fact(&page, Layer::Coverage, 0)[texel] == 1.0
                && fact(&page, Layer::Object, 0)[texel] == 0.0
                && (at(1, texel) - 2.0).abs() < 1e-4
                && at(0, texel).abs() < 1.7;
            if is_wall {
                let row = (at(2, texel) * 1000.0).round() as i32;
                rows.entry(row)
                    .or_default()
                    .push(fact(&page, Layer::Sealed, 0)[texel]);
            }
        }
        assert!(rows.values().map(Vec::len).sum::<usize>() > 100);
        for (row, sealed) in rows {
            let count = sealed.iter().filter(|&&sealed| sealed > 0.0).count();
            assert!([0, sealed.len()].contains(&count), "{up} {row}: {sealed:?}");
        }
    }
}
