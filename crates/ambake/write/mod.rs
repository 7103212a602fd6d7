//! What a finished bake writes: EXR pages, PNG previews, a GLB and `bake.json`.

mod made;
pub(crate) mod names;
mod record;

use crate::any_view;
use crate::baked::Baked;
use crate::dome::enclosed;
use crate::error::Error;
use crate::hidden::is_hidden;
use crate::host::VERSION;
use crate::interior::Brightness;
use crate::job::Job;
use crate::lit::LitScene;
use crate::parts::Kind;
use crate::resume::Saved;
use crate::shell::{Look, Shell};
use crate::shut::is_in_cupboard;
use crate::state::{self, Head};
use crate::update::Tracker;
use crate::vertices::Fit;
use ::bake::{BakedPage, BounceStats, Fingerprint, LayerPlanes, SeamStats};
use layers::Layer;
use made::{glb, page_light, vertex_glb};
use names::{
    check_length, glb_name, leftovers, lit_name, names_of_bake, names_of_page, page_name,
    preview_name, vertex_glb_name,
};
use rayon::prelude::*;
use record::{
    CONVENTION, bounce_report, edited, light_is_missing, page_report, report_of, scene_file,
    seam_report,
};
use report::{
    BakeReport, LightmapReport, Output, PageHeader, PageReport, PhaseReport, PictureReport,
    ScenePictures, UpdateReport,
};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::Instant;

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
        self.brightness.add(self.job, page);
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
        let mut picture = None;
        if let Some((png, camera)) = self.lit.picture() {
            self.output.stage_bytes(&lit_name(&self.stem), &png)?;
            picture = Some(PictureReport {
                eye: (camera.eye + self.job.world().origin()).into(),
                forward: camera.forward.into(),
                fov_deg: 2.0 * camera.slope.atan().to_degrees(),
                aspect: f64::from(camera.size[0]) / f64::from(camera.size[1]),
            });
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
        report.picture = picture;
        report.update = update;
        let texels = report.pages.iter().map(|page| page.texels).sum();
        report.seams = seam_report(&self.seams, texels);
        report.bounces = bounces.map(bounce_report);
        report.any_view = any_view;
        report.lightmaps = self.lightmaps;
        let has_outsides = report.warnings.iter().any(|of| of.kind == "outsides");
        let interior = self.job.within(|| {
            let shell = has_outsides.then(|| Shell::of(self.job.world(), self.job.backend()));
            let shell = shell.flatten();
            let (world, backend) = (self.job.world(), self.job.backend());
            self.brightness.interior(
                self.job.options(),
                self.job.has_lamps(),
                |point| shell.as_ref().is_some_and(|shell| shell.hides(point)),
                |point| {
                    let look = Look::at(world, backend, *point);
                    look.is_some_and(|look| is_hidden(world, backend, &look))
                },
                |point| is_in_cupboard(world, backend, point),
                self.job.atlas().audit.texels,
            )
        });
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
