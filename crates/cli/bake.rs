//! `ambake bake`: scene in, lightmaps out.

use crate::Outcome;
use crate::args::Bake as Args;
use crate::checkpoint::Saved;
use crate::progress::watch;
use crate::stop::Stop;
use crate::summary::summary;
use crate::{host, options, say};
use ::bake::{Bake, BakedPage, Denoise, Options, Pattern, Plan, Progress, Sky};
use anyhow::{Context, bail};
use atlas::Atlas;
use layers::Layer;
use rays::RayBackend;
use report::{BakeReport, DecisionReport, Encoding, Output, PageHeader, PageReport, PhaseReport};
use scene::Scene;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// The sentence about normalisation that every output carries.
pub const CONVENTION: &str = "terms are normalised so that an unoccluded texel is 1 under the uniform sky at normal \
     view: visibility = open solid angle / 2 pi; diffuse = (1/pi) integral of V cos; \
     specular = ((n+1)/2 pi) integral of V (R.V)^n; linear values; row 0 is v = 0";

/// Wall time of each phase.
#[derive(Default)]
pub struct Phases(Vec<PhaseReport>);

impl Phases {
    /// Runs and times one phase.
    pub fn time<R>(&mut self, phase: &str, job: impl FnOnce() -> R) -> R {
        let started = Instant::now();
        let result = job();
        self.0.push(PhaseReport {
            phase: phase.into(),
            seconds: started.elapsed().as_secs_f64(),
        });
        result
    }
}

/// Everything that stands between loading and the first ray.
pub struct Prepared {
    pub scene: Arc<Scene>,
    pub stem: String,
    pub options: Options,
    /// What outputs say of the sky.
    pub sky: Value,
    pub atlas: Atlas,
    pub plan: Plan,
    pub world: rays::World,
    pub backend: Box<dyn RayBackend>,
}

/// Loads, plans, lays out and builds.
pub fn prepare(
    file: &Path,
    job: &crate::args::Job,
    common: &crate::args::Common,
    phases: &mut Phases,
) -> anyhow::Result<Prepared> {
    let threads = host::set_threads(common.threads)?;
    let (sky, described_sky) = crate::sky::load(&job.sky)?;
    let options = options::bake_options(job, common, sky);
    if options.denoise == Denoise::Regression && options.pattern == Pattern::Tiled {
        bail!("--denoise regression needs independent errors: leave out --pattern tiled");
    }
    if options.denoise == Denoise::Regression && matches!(options.sky, Sky::Map(_)) {
        bail!("--denoise regression works under a uniform sky: leave it out with --sky FILE");
    }
    let kind = options::backend(job);
    let scene = Arc::new(phases.time("load", || scene::load(file))?);
    let (plan, world) = phases.time("plan", || Plan::of(&scene, &options))?;
    let atlas = phases
        .time("atlas", || {
            atlas::layout(&scene, &options::atlas_options(job), &|| false)
        })
        .with_context(|| format!("{}", file.display()))?;
    let backend = phases.time("build", || rays::build(kind, &world, threads))?;
    let stem = file
        .file_stem()
        .map_or_else(|| "scene".into(), |s| s.to_string_lossy().into_owned());
    Ok(Prepared {
        scene,
        stem,
        options,
        sky: described_sky,
        atlas,
        plan,
        world,
        backend,
    })
}

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let started = Instant::now();
    let stop = Stop::listen()?;
    let mut output = Output::create(&args.output)?;
    let mut phases = Phases::default();
    let prepared = prepare(&args.scene, &args.job, &args.common, &mut phases)?;
    let described = options::describe(&args.job, &prepared.options, &prepared.sky);
    let key = json!({
        "version": host::VERSION,
        "options": described,
        "scene": prepared.scene.content_hash,
        "backend": prepared.backend.describe(),
    });
    let saved = Saved {
        dir: &args.output,
        stem: &prepared.stem,
        key: &key,
    };
    let Some(baked) = bake_pages(
        args,
        &prepared,
        &saved,
        &stop,
        &mut output,
        &described,
        &mut phases,
    )?
    else {
        let signal = stop.signal().unwrap_or(signal_hook::consts::SIGINT);
        if !args.common.quiet {
            eprintln!("ambake: stopped; continue with the same command and --resume");
        }
        return Ok(Outcome::Stopped(signal));
    };
    phases.time("gltf", || {
        let pngs: Vec<Vec<u8>> = baked.iter().map(|page| page.occlusion.clone()).collect();
        write_gltf(&prepared, &pngs, &mut output)
    })?;
    let mut names = output.names();
    names.push("bake.json".into());
    let report = report_of(&prepared, &described, &baked, names, phases, started);
    output.stage_bytes("bake.json", report.to_json().as_bytes())?;
    let files = output.publish()?;
    saved.clear(prepared.atlas.page_count);
    if args.common.json {
        say(&(report.to_json() + "\n"))?;
    } else if !args.common.quiet {
        say(&summary(
            &report,
            args.common.verbose,
            files.len(),
            &args.output,
        ))?;
    }
    Ok(Outcome::Done)
}

/// What remains of a page after its files are staged.
struct DonePage {
    report: PageReport,
    occlusion: Vec<u8>,
}

/// Bakes and stages every page; `None` where a signal stopped it and the state was saved.
fn bake_pages(
    args: &Args,
    prepared: &Prepared,
    saved: &Saved<'_>,
    stop: &Stop,
    output: &mut Output,
    described: &Value,
    phases: &mut Phases,
) -> anyhow::Result<Option<Vec<DonePage>>> {
    let Prepared {
        atlas,
        plan,
        world,
        backend,
        options,
        ..
    } = prepared;
    let bake = Bake::new(world, plan, backend.as_ref(), atlas, options);
    let progress = Progress::default();
    let mut done = Vec::new();
    let (mut baking, mut writing) = (0.0, 0.0);
    for number in 0..atlas.page_count {
        let mut page = bake.start(number);
        if args.resume && saved.restore(&mut page)? {
            progress
                .texels
                .fetch_add(page.stats.texels, Ordering::Relaxed);
        }
        let clock = Instant::now();
        if !page.finished {
            watch(
                atlas.audit.texels,
                args.common.quiet,
                stop,
                &progress,
                || bake.run(&mut page, &progress),
            );
        }
        baking += clock.elapsed().as_secs_f64();
        if !page.finished || atlas.page_count > 1 {
            saved.write(&page)?;
        }
        if !page.finished {
            return Ok(None);
        }
        let clock = Instant::now();
        page.keep_asked(options);
        done.push(stage_page(prepared, page, output, described)?);
        writing += clock.elapsed().as_secs_f64();
    }
    phases.0.push(PhaseReport {
        phase: "bake".into(),
        seconds: baking,
    });
    phases.0.push(PhaseReport {
        phase: "write".into(),
        seconds: writing,
    });
    Ok(Some(done))
}

fn stage_page(
    prepared: &Prepared,
    page: BakedPage,
    output: &mut Output,
    described: &Value,
) -> anyhow::Result<DonePage> {
    let (number, stats) = (page.page, page.stats);
    let header = PageHeader {
        version: host::VERSION.into(),
        options: described.to_string(),
        seed: prepared.options.seed,
        convention: CONVENTION.into(),
        view: options::view_rule(&prepared.options),
        scene_hash: prepared.scene.content_hash.clone(),
        page: number,
    };
    let page = to_report(page);
    let stem = &prepared.stem;
    output.stage(&format!("{stem}.{number}.exr"), |file| {
        report::write_page_exr(file, &page, &header)
    })?;
    for layer in &page.layers {
        if let Some(encoding) = Encoding::of(layer) {
            let png = report::preview_png(page.size, layer, encoding);
            output.stage_bytes(&format!("{stem}.{number}.{}.png", layer.name), &png)?;
        }
    }
    let occlusion = if page.layer(Layer::Diffuse.name()).is_some() {
        report::occlusion_png(&page)?
    } else {
        Vec::new()
    };
    let texels = stats.texels.max(1) as f64;
    Ok(DonePage {
        occlusion,
        report: PageReport {
            page: number,
            texels: stats.texels,
            coverage_used: stats.coverage / f64::from(page.size).powi(2),
            mean_error: stats.error_sum / texels,
            max_error: stats.error_max,
            worst_texel: stats.worst,
            rmse: stats.rmse(),
            rmse_bound: stats.rmse_bound(),
            irradiance_rmse: match prepared.options.sky {
                Sky::Uniform(_) => None,
                Sky::Map(_) => Some(stats.irradiance_rmse()),
            },
            rays: stats.rays,
            seconds: stats.seconds,
            rays_per_second: stats.rays as f64 / stats.seconds.max(1e-9),
        },
    })
}

/// The baker's planes as the writer's page. Consecutive planes of one layer become its channels.
fn to_report(page: BakedPage) -> report::Page {
    let mut layers: Vec<report::Layer> = Vec::new();
    for plane in page.planes {
        let channel = report::Channel {
            suffix: plane.layer.channels()[plane.channel].into(),
            values: plane.values,
        };
        match layers
            .last_mut()
            .filter(|last| last.name == plane.layer.name())
        {
            Some(last) => last.channels.push(channel),
            None => layers.push(report::Layer {
                name: plane.layer.name().into(),
                channels: vec![channel],
            }),
        }
    }
    report::Page {
        size: page.size,
        layers,
    }
}

/// The scene with its lightmap coordinates and the diffuse term. Without that layer there is nothing to attach.
fn write_gltf(prepared: &Prepared, pngs: &[Vec<u8>], output: &mut Output) -> anyhow::Result<()> {
    if pngs.iter().any(Vec::is_empty) {
        return Ok(());
    }
    let glb = report::write_gltf(&prepared.scene, &prepared.atlas, pngs)?;
    output.stage_bytes(&format!("{}.glb", prepared.stem), &glb)?;
    Ok(())
}

fn report_of(
    prepared: &Prepared,
    described: &Value,
    pages: &[DonePage],
    files: Vec<String>,
    phases: Phases,
    started: Instant,
) -> BakeReport {
    let Prepared {
        scene,
        options,
        atlas,
        plan,
        backend,
        ..
    } = prepared;
    let pages: Vec<PageReport> = pages.iter().map(|page| page.report.clone()).collect();
    BakeReport {
        schema_version: report::BAKE_SCHEMA_VERSION,
        versions: report::Versions {
            ambake: host::VERSION.into(),
            git_revision: Some(host::REVISION.into()).filter(|r: &String| !r.is_empty()),
            backend: backend.name().into(),
            backend_version: backend.describe(),
        },
        scene: report::SceneReport::of(scene),
        options: described.as_object().cloned().unwrap_or_default(),
        seed: options.seed,
        view: options::view_rule(options),
        convention: CONVENTION.into(),
        plan: decisions(plan),
        atlas: report::AtlasReport::of(atlas),
        rays: pages.iter().map(|page| page.rays).sum(),
        pages,
        objects: report::object_reports(scene, atlas),
        timings: phases.0,
        seconds: started.elapsed().as_secs_f64(),
        peak_memory_bytes: host::peak_memory(),
        warnings: warnings(scene),
        notes: atlas.notes.clone(),
        files,
    }
}

/// The planner's decisions as reports carry them.
pub fn decisions(plan: &Plan) -> Vec<DecisionReport> {
    plan.decisions
        .iter()
        .map(|decision| DecisionReport {
            decision: decision.choice.name().into(),
            modelled: decision.modelled,
            reason: decision.reason.clone(),
        })
        .collect()
}

/// The loader's warnings as reports carry them.
pub fn warnings(scene: &Scene) -> Vec<report::WarningReport> {
    let warnings = scene.warnings.iter();
    warnings.map(report::WarningReport::from).collect()
}
