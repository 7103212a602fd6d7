//! What a finished bake writes: EXR pages, PNG previews, a GLB and `bake.json`.

use crate::any_view;
use crate::baked::Baked;
use crate::dome::enclosed;
use crate::error::Error;
use crate::host::{REVISION, VERSION, peak_memory};
use crate::interior::Brightness;
use crate::job::Job;
use crate::lit::LitScene;
use crate::parts::Kind;
use crate::resume::Saved;
use crate::state::{self, Head};
use crate::update::Tracker;
use crate::vertices::Fit;
use ::bake::{BakedPage, BounceStats, Bounces, Fingerprint, LayerPlanes, SeamStats};
use layers::Layer;
use rayon::prelude::*;
use report::{
    BakeReport, Engine, LightSource, LightmapReport, Output, PageHeader, PageLight, PageReport,
    PhaseReport, ScenePictures, SeamReport, Shades, UpdateReport,
};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The sentence about normalisation that every output carries.
const CONVENTION: &str = "terms are normalised so that an unoccluded texel is 1 under the uniform sky at normal \
     view: visibility = open solid angle / 2 pi; diffuse = (1/pi) integral of V cos; \
     specular = ((n+1)/2 pi) integral of V (R.V)^n; linear values; row 0 is v = 0";

/// What a bake into a directory left there.
#[derive(Debug)]
#[non_exhaustive]
pub struct Written {
    /// The content of `bake.json`.
    pub report: BakeReport,
    /// Every file that was written.
    pub files: Vec<PathBuf>,
}

/// Stages the files of a bake page by page.
pub(crate) struct Writer<'a> {
    job: &'a Job,
    described: Value,
    /// [`report::layout_hash`].
    layout: String,
    stem: String,
    output: Output,
    pages: Vec<PageReport>,
    seams: SeamStats,
    brightness: Brightness,
    lit: LitScene,
    lightmaps: Vec<LightmapReport>,
    /// One picture of the light that leaves surfaces a page, where an engine wants them.
    scene_pictures: ScenePictures,
    /// One picture of the diffuse term a page; `None` where the bake has no such layer.
    pictures: Option<Vec<Vec<u8>>>,
    /// The diffuse term at vertices, where it was asked for.
    vertices: Option<Fit<'a>>,
    /// The ray library that baked, where it was another process.
    backend: Option<String>,
    /// What is kept for later updates, and what this one kept.
    state: Option<(Head, Option<UpdateReport>)>,
}

impl<'a> Writer<'a> {
    /// A writer into an output directory.
    ///
    /// # Errors
    /// A name that will be written stands for an input, or for a scene that no earlier bake wrote.
    pub fn new(job: &'a Job, mut output: Output) -> Result<Self, Error> {
        let stem = job.scene().stem();
        output.protect(job.inputs());
        let (engines, layers) = (&job.options().engines, &job.options().layers);
        let compress = job.options().compress;
        let any_view = job.baker_options().any_view().is_some();
        let mut names = names_of_bake(&stem, engines, any_view);
        for page in 0..job.atlas().page_count {
            names.extend(names_of_page(&stem, page, engines, layers, compress));
        }
        check_length(output.dir(), &Kind::Bake.state_name(&stem, None))?;
        for name in names {
            check_length(output.dir(), &name)?;
            output.check(&name)?;
        }
        let earlier = report::read_record(output.dir(), &stem);
        for name in [glb_name(&stem), vertex_glb_name(&stem)] {
            let path = output.dir().join(&name);
            let is_own = earlier.as_ref().is_some_and(|of| of.files.contains(&name));
            if path.is_file() && !is_own {
                return Err(report::Error::ReplacesScene { path }.into());
            }
        }
        Ok(Self {
            job,
            described: job.options().describe(),
            layout: report::layout_hash(job.atlas()),
            stem,
            output,
            pages: Vec::new(),
            seams: SeamStats::default(),
            brightness: Brightness::default(),
            lit: LitScene::default(),
            lightmaps: Vec::new(),
            scene_pictures: ScenePictures::new(engines),
            pictures: Some(Vec::new()),
            vertices: (job.options().vertices).then(|| Fit::of(job, Layer::Diffuse)),
            backend: None,
            state: None,
        })
    }

    /// Says which ray library baked, where it was not this process's.
    pub fn baked_with(&mut self, backend: &str) {
        self.backend = Some(backend.into());
    }

    /// Stages the tiles of a page that has all of them and is not finished, for later updates.
    pub fn tiles(
        &mut self,
        page: &BakedPage,
        key: &Value,
        tiles: &[(u32, Fingerprint)],
    ) -> Result<(), Error> {
        let name = state::tiles_name(&self.stem, page.page);
        self.output
            .stage(&name, |file| state::write_tiles(file, key, page, tiles))?;
        Ok(())
    }

    /// Takes what later updates need, and what this one has to say.
    pub fn tracked(&mut self, tracker: Tracker<'_>) -> Result<(), Error> {
        self.state = Some((tracker.head()?, tracker.report()));
        Ok(())
    }

    /// Stages the files of a finished page; pages come in order.
    pub fn page(&mut self, page: &BakedPage) -> Result<(), Error> {
        let options = self.job.options();
        let header = PageHeader {
            version: VERSION.into(),
            options: self.described.to_string(),
            seed: options.seed,
            convention: CONVENTION.into(),
            view: options.view_rule(),
            scene_hash: self.job.scene().content_hash.clone(),
            layout: self.layout.clone(),
            page: page.page,
        };
        let mut channels = Vec::new();
        for planes in &page.planes {
            let values = planes.values.chunks(page.texels()).enumerate();
            channels.extend(values.map(|(c, values)| (planes.layer.channel_name(c), values)));
        }
        let preview = |planes: &LayerPlanes| {
            report::preview_png(page.size, planes.layer, &planes.values)
                .map(|png| (preview_name(&self.stem, page.page, planes.layer), png))
        };
        let diffuse = page.layer(Layer::Diffuse);
        let mut occlusion = None;
        let (written, previews) = rayon::join(
            || {
                self.output
                    .stage(&page_name(&self.stem, page.page), |file| {
                        report::write_page_exr(file, page.size, &channels, &header)
                    })
            },
            || -> Vec<(String, Vec<u8>)> {
                occlusion = diffuse.map(|diffuse| report::occlusion_png(page.size, diffuse));
                page.planes.par_iter().filter_map(preview).collect()
            },
        );
        written?;
        for (name, png) in previews {
            self.output.stage_bytes(&name, &png)?;
        }
        self.lit.add(self.job, page);
        if !options.engines.is_empty() {
            let light = page_light(self.job, page)?;
            self.lightmaps.extend(report::stage_engines(
                &mut self.output,
                &self.stem,
                &light,
                &options.engines,
                options.compress,
            )?);
            self.scene_pictures.add(&light);
        }
        if let (Some(diffuse), Some(coverage)) = (diffuse, page.layer(Layer::Coverage)) {
            self.brightness.add(diffuse, coverage);
        }
        self.pictures = self
            .pictures
            .take()
            .zip(occlusion)
            .map(|(mut pictures, picture)| {
                pictures.push(picture);
                pictures
            });
        if let Some(fit) = &mut self.vertices {
            fit.add(page);
        }
        self.pages.push(page_report(self.job, page));
        self.seams.append(&page.stats.seams);
        Ok(())
    }

    /// Writes the GLB and `bake.json` and gives every file its name.
    pub fn finish(
        mut self,
        mut phases: Vec<PhaseReport>,
        bounces: Option<BounceStats>,
    ) -> Result<Written, Error> {
        let clock = Instant::now();
        let bytes = glb(self.job, self.pictures.as_deref())?;
        self.output.stage_bytes(&glb_name(&self.stem), &bytes)?;
        let engines = &self.job.options().engines;
        if let Some(fit) = self.vertices.take() {
            let bytes = vertex_glb(self.job, fit)?;
            (self.output).stage_bytes(&vertex_glb_name(&self.stem), &bytes)?;
        }
        let pictures = &self.scene_pictures;
        let scenes = pictures.stage(&mut self.output, &self.stem, &bytes, engines)?;
        self.lightmaps.extend(scenes);
        phases.push(PhaseReport {
            phase: "gltf".into(),
            seconds: clock.elapsed().as_secs_f64(),
            ..PhaseReport::default()
        });
        if let Some(picture) = self.lit.picture() {
            self.output.stage_bytes(&lit_name(&self.stem), &picture)?;
        }
        phases.push(PhaseReport {
            phase: "lit".into(),
            seconds: self.lit.seconds(),
            ..PhaseReport::default()
        });
        let mut update = None;
        if let Some((head, report)) = self.state.take() {
            let name = state::head_name(&self.stem);
            self.output.stage(&name, |file| head.write(file))?;
            update = report;
        }
        let any_view = any_view::stage(self.job, &mut self.output, &self.stem)?;
        let mut report = report_of(self.job, &self.described, self.pages, phases);
        report.scene.file = scene_file(self.job, self.output.dir());
        if let Some(backend) = self.backend {
            report.versions.backend_version = backend;
        }
        report.update = update;
        let texels = report.pages.iter().map(|page| page.texels).sum();
        report.seams = seam_report(&self.seams, texels);
        report.bounces = bounces.map(bounce_report);
        report.any_view = any_view;
        report.lightmaps = self.lightmaps;
        let outsides = report.warnings.iter().find(|of| of.kind == "outsides");
        let interior = self.brightness.interior(
            self.job.options(),
            self.job.has_lamps(),
            outsides.map_or(0, |of| of.count),
        );
        report.warnings.extend(enclosed(self.job));
        report.warnings.extend(interior);
        let missing = bounces.and_then(|stats| light_is_missing(self.job, &stats));
        report.warnings.extend(missing);
        report.warnings.extend(edited(self.job));
        let earlier = leftovers(self.output.dir(), &self.stem, &report);
        self.output.supersede(earlier);
        report::stage_report(&mut self.output, &mut report, &self.stem)?;
        let files = self.output.publish()?;
        Ok(Written { report, files })
    }
}

impl Baked {
    /// The light of a page as an engine uploads it, without a file: the page, then as many smaller levels as `mips`
    /// keeps charts apart on. It is what engines' files hold, E / pi without albedo.
    ///
    /// ```
    /// # fn main() -> Result<(), ambake::Error> {
    /// # let scene = ambake::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/wall_long.obj"))?;
    /// let baked = ambake::Bake::new(&scene).size(64).rays(16).mips(2).run(&())?;
    /// for level in baked.light(0)? {
    ///     let texels: Vec<[u16; 4]> = level.half_floats();    // RGBA16F, row 0 on top
    ///     assert_eq!(texels.len(), (level.size * level.size) as usize);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// The bake has no layer `diffuse`, or no layer `irradiance` where light varies.
    ///
    /// # Panics
    /// Where there is no such page.
    pub fn light(&self, number: usize) -> Result<Vec<report::LightLevel>, Error> {
        let light = page_light(self.job(), &self.page(number).0)?;
        Ok(report::light_levels(&light))
    }

    /// Writes everything that the command line writes: EXR pages, PNG previews, a GLB and `bake.json`. The directory is
    /// made where it is absent. Files appear together once all are complete.
    ///
    /// # Errors
    /// The directory cannot be written, or an output would replace an input.
    pub fn write(&self, dir: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
        let mut writer = Writer::new(self.job(), Output::create(dir.as_ref())?)?;
        for page in self.pages() {
            writer.page(&page.0)?;
        }
        Ok(writer
            .finish(self.job().phases().to_vec(), self.bounces().copied())?
            .files)
    }

    /// Writes the scene as a GLB file: lightmap coordinates as `TEXCOORD_1` and, where diffuse was baked, the diffuse
    /// term as `occlusionTexture`.
    ///
    /// # Errors
    /// The file cannot be written, or it would replace an input.
    pub fn write_gltf(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let mut output = Output::for_file(path.as_ref())?;
        output.protect(self.job().inputs());
        let diffuse = self.pages().map(|page| page.0.layer(Layer::Diffuse));
        let pictures: Option<Vec<Vec<u8>>> = diffuse
            .map(|values| Some(report::occlusion_png(self.page(0).size(), values?)))
            .collect();
        let name = path.as_ref().file_name().unwrap_or_default();
        let bytes = glb(self.job(), pictures.as_deref())?;
        output.stage_bytes(&name.to_string_lossy(), &bytes)?;
        output.publish()?;
        Ok(())
    }
}

impl Job {
    /// The error of a file that could not be written; `kept`: there is a saved state to go on from.
    pub(crate) fn unwritten(&self, error: Error, kept: bool) -> Error {
        match error {
            Error::Output(source @ report::Error::Write { .. }) if kept => Error::Unwritten {
                source,
                needed: self.room().peak().div_ceil(1 << 20),
            },
            error => error,
        }
    }

    /// The same of state that could not be saved: what was saved before stays.
    pub(crate) fn unsaved(&self, saved: &Saved) -> impl Fn(Error) -> Error {
        let kept = saved.is_begun();
        move |error| self.unwritten(error, kept)
    }
}

/// Checks that the file system takes a file of that name.
pub(crate) fn check_length(dir: &Path, name: &str) -> Result<(), Error> {
    let path = dir.join(name);
    match std::fs::symlink_metadata(&path) {
        Err(error) if error.kind() == ErrorKind::InvalidFilename => Err(Error::LongName {
            path: path.display().to_string(),
        }),
        _ => Ok(()),
    }
}

/// Says that the scene's files are no longer what was baked.
fn edited(job: &Job) -> Option<report::WarningReport> {
    job.scene().was_edited().then(|| report::WarningReport {
        kind: "edited-scene".into(),
        place: job.scene().path.display().to_string(),
        count: 1,
        message: "the scene's files were edited or removed during the bake; the results are those of the scene as it was read".into(),
    })
}

/// What engine files are made of: the same numbers that an export reads from the page's file.
pub(crate) fn page_light<'a>(job: &Job, page: &'a BakedPage) -> Result<PageLight<'a>, Error> {
    let options = job.options();
    let plane = |layer: Layer, channel| page.channel(layer, channel).map(Cow::Borrowed);
    let layer = |layer: Layer| {
        let missing = || report::Error::MissingLayer {
            layer: layer.name().into(),
        };
        plane(layer, 0).ok_or_else(missing)
    };
    let light = match [0, 1, 2].map(|c| plane(Layer::Irradiance, c)) {
        [Some(r), Some(g), Some(b)] => Some([r, g, b]),
        _ => None,
    };
    let source = match options.sky.light {
        environment::Sky::Uniform(sky) if !options.light_varies() => LightSource::Uniform(sky),
        _ => LightSource::Irradiance,
    };
    let diffuse = layer(Layer::Diffuse)?;
    Ok(PageLight {
        page: page.page,
        size: page.size,
        rings: job.baker_options().rings,
        mips: options.mips,
        coverage: layer(Layer::Coverage)?,
        light: source.light(light, &diffuse)?,
        lit: match [0, 1, 2].map(|c| plane(Layer::Lambert, c)) {
            [Some(r), Some(g), Some(b)] => Some([r, g, b]),
            _ => None,
        },
        sh: page.layer(Layer::Sh).map(|values| {
            let planes = values.chunks(page.texels());
            planes.map(Cow::Borrowed).collect()
        }),
        diffuse,
    })
}

/// The scene's file as seen from `dir`; `None` where it has none.
fn scene_file(job: &Job, dir: &Path) -> Option<String> {
    let scene = job.scene();
    let has_file = !scene.inputs.is_empty();
    has_file.then(|| report::scene_file(dir, &scene.path))?
}

/// What an earlier bake of the same scene file listed in `dir` and may have left: names that no bake of a scene of this
/// stem makes are nobody's to remove, whoever listed them.
fn leftovers(dir: &Path, stem: &str, now: &BakeReport) -> Vec<(String, String)> {
    let earlier = report::read_record(dir, stem);
    let same = earlier.filter(|of| of.scene.file.is_some() && of.scene.file == now.scene.file);
    let hashes = same.map(|earlier| earlier.hashes).unwrap_or_default();
    hashes
        .into_iter()
        .filter(|(name, _)| is_made(stem, name))
        .collect()
}

/// True for the name of a file that some bake of a scene of this stem makes.
fn is_made(stem: &str, name: &str) -> bool {
    let number = || {
        let (number, _) = name
            .strip_prefix(stem)?
            .strip_prefix('.')?
            .split_once('.')?;
        number.parse().ok()
    };
    let (engines, layers): (Vec<_>, Vec<_>) = (Engine::all().collect(), Layer::all().collect());
    let of_bake = names_of_bake(stem, &engines, true);
    let of_page = |compress| {
        let of_page = number().map(|page| names_of_page(stem, page, &engines, &layers, compress));
        of_page.unwrap_or_default()
    };
    let of_pages = [of_page(false), of_page(true)].concat();
    of_bake.into_iter().chain(of_pages).any(|made| made == name)
}

/// The names of files that a bake makes once.
fn names_of_bake(stem: &str, engines: &[Engine], any_view: bool) -> Vec<String> {
    let mut names = vec![
        report::REPORT_FILE.into(),
        report::record_name(stem),
        report::REPORT_NAME.into(),
        glb_name(stem),
        vertex_glb_name(stem),
        lit_name(stem),
        state::head_name(stem),
    ];
    if any_view {
        names.extend(report::any_view_files(stem));
    }
    names.extend(report::scene_files(stem, engines));
    names
}

/// The names of files that a bake makes for each page.
fn names_of_page(
    stem: &str,
    page: u32,
    engines: &[Engine],
    layers: &[Layer],
    compress: bool,
) -> Vec<String> {
    let directional = layers.contains(&Layer::Sh);
    let mut names = vec![page_name(stem, page), state::tiles_name(stem, page)];
    names.extend(report::engine_files(
        stem,
        page,
        engines,
        directional,
        compress,
    ));
    names.extend(layers.iter().map(|&layer| preview_name(stem, page, layer)));
    names
}

fn glb_name(stem: &str) -> String {
    format!("{stem}.glb")
}

fn vertex_glb_name(stem: &str) -> String {
    format!("{stem}.vertices.glb")
}

fn page_name(stem: &str, page: u32) -> String {
    format!("{stem}.{page}.exr")
}

fn preview_name(stem: &str, page: u32, layer: Layer) -> String {
    format!("{stem}.{page}.{}.png", layer.name())
}

fn lit_name(stem: &str) -> String {
    format!("{stem}.lit.png")
}

/// The scene with its lightmap coordinates and, where there are pictures of it, the diffuse term.
pub(crate) fn glb(job: &Job, pictures: Option<&[Vec<u8>]>) -> Result<Vec<u8>, Error> {
    let none = Shades::new();
    Ok(report::write_gltf(
        job.scene(),
        job.atlas(),
        pictures,
        &none,
    )?)
}

/// The scene with a layer of one channel as vertex colours.
fn vertex_glb(job: &Job, fit: Fit<'_>) -> Result<Vec<u8>, Error> {
    let shades = fit.solved().into_iter();
    let shades = shades.map(|(instance, channels)| (instance, channels.concat()));
    Ok(report::write_gltf(
        job.scene(),
        job.atlas(),
        None,
        &shades.collect(),
    )?)
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

fn page_report(job: &Job, page: &BakedPage) -> PageReport {
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
        mean_error: stats.errors.sum / stats.seen().max(1) as f64,
        max_error: stats.errors.max,
        worst_texel: stats.errors.worst,
        worst_relative: stats.errors.relative,
        rmse: stats.rmse(),
        rmse_bound: stats.rmse_bound(),
        irradiance_rmse: varies.then(|| stats.irradiance_rmse()),
        irradiance_mean: varies.then(|| irradiance_mean(page)).flatten(),
        rays: stats.rays,
        seconds: stats.seconds,
        rays_per_second: stats.rays as f64 / stats.seconds.max(1e-9),
    }
}

/// A warning where gathers that should have gone on until nothing is missing were stopped before.
fn light_is_missing(job: &Job, stats: &BounceStats) -> Option<report::WarningReport> {
    let percent = 100.0 * stats.missing;
    let is_much = job.options().bounces == Bounces::Auto && percent > 1.0;
    is_much.then(|| report::WarningReport {
        kind: "light-missing".into(),
        place: job.scene().path.display().to_string(),
        count: 1,
        message: format!(
            "after {} gathers {percent:.0} % of the light is still missing: nearly white surfaces send it on and on; give them less albedo with \
             --albedo, or a number of gathers with --bounces",
            stats.gathers
        ),
    })
}

fn bounce_report(stats: BounceStats) -> report::BounceReport {
    report::BounceReport {
        gathers: stats.gathers,
        change: stats.change,
        missing: stats.missing,
        rays: stats.rays,
    }
}

fn seam_report(seams: &SeamStats, texels: u64) -> Option<SeamReport> {
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

fn report_of(
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
