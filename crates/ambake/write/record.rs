//! What `bake.json` says of a bake: its pages, seams, bounces and warnings.

use crate::host::{REVISION, VERSION, peak_memory};
use crate::job::Job;
use ::bake::{BakedPage, BounceStats, Bounces, SeamStats};
use layers::Layer;
use report::{BakeReport, PageReport, PhaseReport, SeamReport};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// The sentence about normalisation that every output carries.
pub(super) const CONVENTION: &str = "terms are normalised so that an unoccluded texel is 1 under the uniform sky at \
     normal view: visibility = open solid angle / 2 pi; diffuse = (1/pi) integral of V cos; \
     specular = ((n+1)/2 pi) integral of V (R.V)^n; linear values; row 0 is v = 0";

/// Says that the scene's files are no longer what was baked.
pub(super) fn edited(job: &Job) -> Option<report::WarningReport> {
    job.scene().was_edited().then(|| report::WarningReport {
        kind: "edited-scene".into(),
        place: job.scene().path.display().to_string(),
        count: 1,
        message: "the scene's files were edited or removed during the bake; the results are those of the scene as it \
                  was read"
            .into(),
    })
}

/// The scene's file as seen from `dir`; `None` where it has none.
pub(super) fn scene_file(job: &Job, dir: &Path) -> Option<String> {
    let scene = job.scene();
    let has_file = !scene.inputs.is_empty();
    has_file.then(|| report::scene_file(dir, &scene.path))?
}

/// The mean of the irradiance over covered texels and channels, as a radiance; `None` where it is not baked.
fn irradiance_mean(page: &BakedPage) -> Option<f64> {
    let covered = page.channel(Layer::Coverage, 0)?;
    let (mut sum, mut count) = (0.0, 0u64);
    for channel in 0..3 {
        let light = page.channel(Layer::Irradiance, channel)?;
        for (light, _) in light.iter().zip(covered).filter(|(_, share)| **share > 0.0) {
            sum += f64::from(*light);
            count += 1;
        }
    }
    Some(sum / count.max(1) as f64)
}

pub(super) fn page_report(job: &Job, page: &BakedPage) -> PageReport {
    let stats = &page.stats;
    let varies = job.options().light_varies();
    PageReport {
        page: page.page,
        texels: stats.texels,
        coverage_used: stats.coverage / f64::from(page.size).powi(2),
        buried: report::BuriedReport {
            texels: stats.buried,
            share: stats.buried_area / stats.coverage.max(f64::MIN_POSITIVE),
        },
        mean_error: stats.shown().sum / stats.seen().max(1) as f64,
        max_error: stats.shown().max,
        worst_texel: stats.shown().worst,
        worst_relative: stats.shown().relative,
        rmse: stats.rmse(),
        rmse_rays: stats.rmse_rays(),
        rmse_bound: stats.rmse_bound(),
        irradiance_rmse: varies.then(|| stats.irradiance_rmse()),
        irradiance_mean: varies.then(|| irradiance_mean(page)).flatten(),
        rays: stats.rays,
        seconds: stats.seconds,
        rays_per_second: stats.rays as f64 / stats.seconds.max(1e-9),
    }
}

/// A warning where gathers that should have gone on until nothing is missing were stopped before.
pub(super) fn light_is_missing(job: &Job, stats: &BounceStats) -> Option<report::WarningReport> {
    let percent = 100.0 * stats.missing;
    let is_much = job.options().bounces == Bounces::Auto && percent > 1.0;
    is_much.then(|| report::WarningReport {
        kind: "light-missing".into(),
        place: job.scene().path.display().to_string(),
        count: 1,
        message: format!(
            "after {} gathers {percent:.0} % of the light is still missing: nearly white surfaces send it on and on; \
             give them less albedo with --albedo, or a number of gathers with --bounces",
            stats.gathers
        ),
    })
}

pub(super) fn bounce_report(stats: BounceStats) -> report::BounceReport {
    report::BounceReport {
        gathers: stats.gathers,
        change: stats.change,
        missing: stats.missing,
        rays: stats.rays,
    }
}

pub(super) fn seam_report(seams: &SeamStats, texels: u64) -> Option<SeamReport> {
    let mean = |squares: f64| (squares / seams.points as f64).sqrt();
    (seams.points > 0).then(|| SeamReport {
        points: seams.points,
        rms_before: mean(seams.squares_before),
        rms_after: mean(seams.squares_after),
        max_before: seams.max_before,
        max_after: seams.max_after,
        rms_moved: (seams.squares_moved / texels.max(1) as f64).sqrt(),
    })
}

pub(super) fn report_of(
    job: &Job,
    described: &Value,
    pages: Vec<PageReport>,
    phases: Vec<PhaseReport>,
) -> BakeReport {
    let (scene, options) = (job.scene(), job.options());
    let mut described = described.as_object().cloned().unwrap_or_default();
    // They change no value, so that no page's header and no saved state has them.
    let engines: Vec<&str> = options.engines.iter().map(|engine| engine.name()).collect();
    described.insert("for".into(), json!(engines));
    described.insert("compress".into(), json!(options.compress));
    let to = if options.vertices {
        "vertices"
    } else {
        "pages"
    };
    described.insert("to".into(), json!(to));
    BakeReport {
        schema_version: report::BAKE_SCHEMA_VERSION,
        versions: report::Versions {
            ambake: VERSION.into(),
            git_revision: Some(REVISION.into()).filter(|r: &String| !r.is_empty()),
            backend: job.backend().name().into(),
            backend_version: job.backend().describe(),
        },
        scene: report::SceneReport::of(scene),
        options: described,
        seed: options.seed,
        view: options.view_rule(),
        convention: CONVENTION.into(),
        plan: job.decisions(),
        atlas: report::AtlasReport::of(job.atlas()),
        layout: job.layout_report().clone(),
        rays: pages.iter().map(|page| page.rays).sum(),
        buried: report::BuriedReport::of(&pages),
        pages,
        seams: None,
        bounces: None,
        picture: None,
        update: None,
        any_view: None,
        objects: report::object_reports(scene, job.atlas()),
        seconds: phases.iter().map(|phase| phase.seconds).sum(),
        timings: phases,
        peak_memory_bytes: peak_memory(),
        warnings: job.warnings(),
        notes: job.atlas().notes.clone(),
        lightmaps: Vec::new(),
        files: Vec::new(),
        hashes: BTreeMap::new(),
    }
}
