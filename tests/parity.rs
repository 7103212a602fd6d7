//! Both backends answer alike: every scene of this repository and, where present, the real models.

use crate::support::{has_embree, model, scene};
use bake::{BakedPage, Baker, Effort, Options, Plan};
use bench::parity::{Answer, BothBackends, ParityReport, TestRays, parity};
use glam::Vec3;
use layers::Layer;
use rays::{BackendKind, Overrides, RayBackend, TreeKind, World, WorldOptions, build};
use std::path::PathBuf;
use std::sync::Arc;

// Run with `-- --nocapture` to see the table.

/// Rays a scene through the default layout; the other gets an eighth.
const RAYS: u64 = 250_000;
/// Disagreements, all within rounding, that a million generic rays may show.
const ALLOWED_A_MILLION: u64 = 2;

const MODELS: [&str; 7] = [
    "boeing_787/scene.gltf",
    "cornell_box/CornellBox.glb",
    "flight_helmet/FlightHelmet.gltf",
    "game_level_zdm2.glb",
    "gazebo/gazebo.obj",
    "oak_small_alphamask.glb",
    "suzi.glb",
];

/// Models that take long to load and to lay out.
const LARGE: [&str; 3] = [
    "flight_helmet/FlightHelmet.gltf",
    "game_level_zdm2.glb",
    "suzi.glb",
];

fn scenes() -> Vec<PathBuf> {
    let is_scene = |path: &PathBuf| {
        path.extension()
            .is_some_and(|ending| ending == "obj" || ending == "gltf" || ending == "glb")
    };
    let entries = std::fs::read_dir(scene("")).expect("scenes/ is there");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let mut files: Vec<PathBuf> = paths.filter(is_scene).collect();
    files.sort();
    files.extend(MODELS.into_iter().filter_map(model));
    files
}

/// One line of the table, and what is wrong with it.
fn check(name: &str, what: &str, report: &ParityReport, faults: &mut Vec<String>) {
    let unexplained = report.unexplained();
    let open = 100.0 * (1.0 - report.occluded as f64 / report.rays as f64);
    println!(
        "{name:<28} {what:<16} {:>9} rays {open:>5.1} % open {:>4} disagree {:>4} explained",
        report.rays,
        report.disagreements.len(),
        report.disagreements.len() - unexplained,
    );
    for disagreement in report.disagreements.iter().take(5) {
        let question = if matches!(disagreement.a, Answer::Occluded(_)) {
            "occlusion"
        } else {
            "closest"
        };
        println!(
            "    {question}, explained {}: {disagreement:?}",
            disagreement.explained()
        );
    }
    let allowed = (ALLOWED_A_MILLION * report.rays).div_ceil(1_000_000) as usize;
    if unexplained > 0 || report.disagreements.len() > allowed {
        faults.push(format!(
            "{name}, {what}: {} disagree, {unexplained} unexplained",
            report.disagreements.len()
        ));
    }
}

#[test]
fn embree_and_obvhs_answer_alike_on_every_scene() {
    let options = WorldOptions::default();
    let mut faults = Vec::new();
    for file in scenes() {
        let name = file
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let scene = scene::load(&file).expect("the scene loads");
        let world = World::new(Arc::new(scene), options).expect("the scenes fit single precision");
        let made =
            |layout| build(BackendKind::Obvhs(layout), &world, 0).expect("obvhs has no errors");
        let wide = made(TreeKind::Cwbvh);
        let rays = TestRays::new(&world, 1);
        let ask = |a: &dyn RayBackend, b: &dyn RayBackend, count| {
            parity(&world, a, b, |n| rays.packet(n), count)
        };
        let narrow = made(TreeKind::Bvh2);
        if has_embree() {
            let embree = build(BackendKind::Embree, &world, 0).expect("this build has Embree");
            for (what, obvhs, rays) in [
                ("embree, cwbvh", &wide, RAYS),
                ("embree, bvh2", &narrow, RAYS / 8),
            ] {
                check(&name, what, &ask(&*embree, &**obvhs, rays), &mut faults);
            }
        } else {
            let report = ask(&*narrow, &*wide, RAYS / 8);
            check(&name, "bvh2, cwbvh", &report, &mut faults);
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Every layer that a texel's own rays decide (errors are pooled over neighbours), and where the texel lies.
const LAYERS: [Layer; 8] = [
    Layer::Coverage,
    Layer::Visibility,
    Layer::Diffuse,
    Layer::Specular,
    Layer::Phong,
    Layer::Rays,
    Layer::Bent,
    Layer::Position,
];

fn bake_page(
    world: &World,
    plan: &Plan,
    atlas: &atlas::Atlas,
    options: &Options,
    backend: &dyn RayBackend,
) -> BakedPage {
    let baker = Baker::new(world, plan, backend, atlas, options);
    let mut page = baker.start(0);
    baker.run(&mut page, &());
    page
}

/// Texels with coverage whose values differ: their positions, and how far the next texel's is.
fn differing(a: &BakedPage, b: &BakedPage) -> Vec<(Vec3, f32)> {
    let position = |i: usize| {
        let axis = |c| {
            let plane = a.channel(Layer::Position, c);
            plane.expect("the layer was asked for")[i]
        };
        Vec3::new(axis(0), axis(1), axis(2))
    };
    let covered = |i: usize| a.planes[0].values.get(i).is_some_and(|&c| c > 0.0);
    (0..a.texels())
        .filter(|&i| covered(i))
        .filter(|&i| {
            a.planes.iter().zip(&b.planes).any(|(a_planes, b_planes)| {
                (0..a_planes.layer.channels().len())
                    .map(|c| c * a.texels() + i)
                    .any(|at| a_planes.values[at].to_bits() != b_planes.values[at].to_bits())
            })
        })
        .map(|i| {
            let size = a.size as usize;
            let next = [i.wrapping_sub(1), i + 1, i.wrapping_sub(size), i + size]
                .into_iter()
                .filter(|&j| covered(j))
                .map(|j| position(j).distance(position(i)));
            (position(i), next.fold(0.0, f32::max))
        })
        .collect()
}

#[test]
fn baked_layers_differ_only_where_a_listed_ray_explains_it() {
    let mut options = Options {
        seed: 3,
        layers: LAYERS.to_vec(),
        overrides: Overrides {
            exponent: Some(8.0),
            ..Overrides::default()
        },
        ..Options::default()
    };
    let layout = |page_size| atlas::Options {
        page_size,
        ..atlas::Options::default()
    };
    let mut faults = Vec::new();
    for file in scenes() {
        // Ray by ray they are compared above; here they would only take longer.
        if LARGE.iter().any(|large| file.ends_with(large)) {
            continue;
        }
        let name = file
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let scene = Arc::new(scene::load(&file).expect("the scene loads"));
        let (plan, world) = Plan::of(&scene, &options).expect("the scenes fit single precision");
        // A model of many charts needs a larger page, whose texels get fewer rays.
        let atlas = [128, 256, 512, 1024]
            .into_iter()
            .find_map(|size| atlas::layout(&scene, &layout(size), &|| false).ok())
            .unwrap_or_else(|| panic!("{name} fits on no page of 1024 texels"));
        options.effort = Effort::Rays((32 * 128 * 128 / atlas.page_size.pow(2)).max(4));
        let wide =
            build(BackendKind::Obvhs(TreeKind::Cwbvh), &world, 0).expect("obvhs has no errors");
        let kind = if has_embree() {
            BackendKind::Embree
        } else {
            BackendKind::Obvhs(TreeKind::Bvh2)
        };
        let other = build(kind, &world, 0).expect("this build has the backend");
        let both = BothBackends::new(&world, &*other, &*wide);
        let a = bake_page(&world, &plan, &atlas, &options, &both);
        let b = bake_page(&world, &plan, &atlas, &options, &*wide);
        let listed = both.disagreements();
        let texels = differing(&a, &b);
        println!(
            "{name:<28} {:>7} texels {:>9} rays {:>3} rays differ {:>3} texels differ",
            a.stats.texels,
            a.stats.rays,
            listed.len(),
            texels.len()
        );
        let texel = 2.0 / atlas.density as f32;
        let lost = texels.iter().filter(|(position, next)| {
            !listed
                .iter()
                .any(|ray| position.distance(Vec3::from(ray.ray.origin)) <= texel.max(*next))
        });
        let (lost, unexplained) = (
            lost.count(),
            listed.iter().filter(|ray| !ray.explained()).count(),
        );
        if lost > 0 || unexplained > 0 || texels.len() > listed.len() {
            faults.push(format!(
                "{name}: {lost} texels differ without a ray, {unexplained} rays unexplained: \
                 {listed:?}"
            ));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
