//! Real models, where they are present.

#[path = "../../../../tests/skip.rs"]
pub mod skip;

use ambake_atlas::{Atlas, Options, PageRaster, UvSource, layout};
use rayon::prelude::*;
use scene::Scene;

/// Loads a model and lays it out on a page of 1024 texels; prints a line and returns `None` where it is absent.
fn laid_out(model: &str) -> Option<(Scene, Atlas)> {
    let path = skip::model(model)?;
    let scene = scene::load(&path).unwrap();
    let options = Options {
        page_size: 1024,
        ..Options::default()
    };
    let start = std::time::Instant::now();
    let atlas = layout(&scene, &options, &|| false).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let (charts, audit) = (atlas.chart_count, atlas.audit);
    println!("{model}: {charts} charts, {audit:?}, {seconds:.2} s");
    assert_eq!((audit.overlaps, audit.missing, audit.outside), (0, 0, 0));
    Some((scene, atlas))
}

/// Every triangle of every object has a piece of some footprint; returns the share of the page that is covered.
fn nothing_is_lost(scene: &Scene, atlas: &Atlas) -> f64 {
    let triangles = |i: &scene::Instance| scene.meshes[i.mesh as usize].triangles.len();
    let mut seen: Vec<Vec<bool>> = scene
        .instances
        .iter()
        .map(|i| vec![false; triangles(i)])
        .collect();
    let raster = PageRaster::new(scene, atlas, 0);
    let tiles: Vec<_> = (0..raster.tiles().len())
        .into_par_iter()
        .map(|i| raster.tile(i))
        .collect();
    let mut area = 0.0;
    for tile in &tiles {
        area += tile.footprints.iter().map(|f| tile.area(f)).sum::<f64>();
        for piece in &tile.pieces {
            seen[piece.instance as usize][piece.triangle as usize] = true;
        }
    }
    let lost = seen.iter().flatten().filter(|&&s| !s).count();
    assert_eq!(lost, 0, "triangles without a footprint");
    let size = f64::from(atlas.page_size);
    area / (size * size)
}

#[test]
fn gazebo_keeps_its_own_set() {
    if let Some((scene, atlas)) = laid_out("gazebo/gazebo.obj") {
        assert_eq!(atlas.source, UvSource::Kept { set: 0 });
        nothing_is_lost(&scene, &atlas);
    }
}

#[test]
fn cornell_box_keeps_its_charts_with_a_rectangle_for_each_object() {
    if let Some((scene, atlas)) = laid_out("cornell_box/CornellBox.glb") {
        assert_eq!(atlas.source, UvSource::Repacked { set: 1 });
        nothing_is_lost(&scene, &atlas);
    }
}

#[test]
fn models_without_a_usable_set_are_unwrapped_whole() {
    for model in [
        "spot.obj",
        "suzi.glb",
        "oak_small_alphamask.glb",
        "boeing_787/scene.gltf",
    ] {
        if let Some((scene, atlas)) = laid_out(model) {
            assert_eq!(atlas.source, UvSource::Unwrapped);
            let used = nothing_is_lost(&scene, &atlas);
            println!(
                "  {:.1} % of the page, {:.3} texels a unit",
                100.0 * used,
                atlas.density
            );
            assert!(used > 0.4, "{used}");
        }
    }
}

#[test]
fn pages_of_models_are_used_to_85_percent() {
    for model in ["game_level_zdm2.glb", "flight_helmet/FlightHelmet.gltf"] {
        let Some(path) = skip::model(model) else {
            continue;
        };
        let scene = scene::load(&path).unwrap();
        let options = Options {
            page_size: 2048,
            gutter: 2,
            ..Options::default()
        };
        let atlas = layout(&scene, &options, &|| false).unwrap();
        let facts = ambake_atlas::facts(&scene, &atlas);
        assert!(facts.page_use > 0.85, "{model}: {}", facts.page_use);
    }
}
