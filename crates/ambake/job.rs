//! A bake between its plan and its result.

use crate::earlier::Earlier;
use crate::error::Error;
use crate::layout::read;
use crate::memory;
use crate::options::{Backend, Options};
use crate::resume::Widths;
use crate::scene::Scene;
use crate::seen::oracle;
use crate::shell::Shell;
use ::bake::{AmbientCoefficient, Baker, Bounces, Decision, Model, Pilot, Plan};
use atlas::{Atlas, Pages};
use layers::{Layer, Progress};
use rays::{RayBackend, World};
use report::{DecisionReport, LayoutReport, PhaseReport, WarningReport, cpu_seconds};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Makes the backend of a bake over the world that its plan built.
pub(crate) type MakeBackend =
    Arc<dyn Fn(&World) -> Result<Box<dyn RayBackend>, rays::Error> + Send + Sync>;

/// Earlier work that a bake may take up.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Given<'a> {
    /// A layout made before.
    pub layout_file: Option<&'a Path>,
    /// A finished bake of which is kept what still holds.
    pub update: Option<&'a Path>,
    /// Some of what is kept is baked again and compared.
    pub verify: bool,
}

/// A bake that is planned and laid out and whose ray scene is built.
pub struct Job {
    scene: Scene,
    options: Options,
    baker: ::bake::Options,
    plan: Plan,
    world: World,
    atlas: Atlas,
    layout: LayoutReport,
    /// What is updated.
    earlier: Option<Earlier>,
    backend: Box<dyn RayBackend>,
    pool: Option<rayon::ThreadPool>,
    started: Instant,
    phases: Vec<PhaseReport>,
}

/// Share of the texels from which outsides are told of.
const LEAST_OUTSIDE: f64 = 0.1;

impl std::fmt::Debug for Job {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Job")
            .field("scene", &self.scene.path)
            .field("options", &self.options)
            .field("backend", &self.backend.describe())
            .finish_non_exhaustive()
    }
}

impl Job {
    pub(crate) fn prepare(
        scene: Scene,
        mut options: Options,
        (backend, make_backend): (Backend, Option<MakeBackend>),
        threads: Option<usize>,
        given: Given<'_>,
        limit: memory::Limit,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let started = Instant::now();
        let begin = |phase: &str| match progress.cancelled() {
            true => Err(Error::Cancelled),
            false => {
                progress.phase(phase);
                Ok(())
            }
        };
        begin("planning")?;
        let mut earlier = match given.update {
            Some(dir) => Some(Earlier::open(dir, &scene, given.verify)?),
            None => None,
        };
        let pool = match threads {
            None => None,
            Some(count) => Some(
                rayon::ThreadPoolBuilder::new()
                    .num_threads(count.max(1))
                    .build()?,
            ),
        };
        let mut phases = Vec::new();
        let baker = options.baker().with_order(&scene.0);
        options.layers.clone_from(&baker.layers);
        let (plan, world, atlas, backend) = within(pool.as_ref(), || {
            let (plan, world) = time(&mut phases, "plan", || Plan::of(&scene.0, &baker))?;
            let meshes = scene.0.meshes.iter();
            let triangles = meshes.map(|mesh| mesh.triangles.len() as u64).sum();
            let content = [triangles, scene.0.instances.len() as u64];
            let memory = memory::Memory::of(&baker, &plan);
            memory::check(options.size, &memory, content, limit)?;
            let build = || match &make_backend {
                Some(make) => make(&world),
                None => rays::build(backend.kind(), &world, rayon::current_num_threads()),
            };
            begin("building the ray scene")?;
            let backend = time(&mut phases, "build", build)?;
            let file = || {
                given
                    .layout_file
                    .and_then(|path| read(path, &scene, &options))
            };
            begin("laying out")?;
            let cancelled = || progress.cancelled();
            let layout = || {
                let seen = oracle(&options, &world, backend.as_ref());
                let stable = earlier
                    .as_mut()
                    .and_then(|of| of.layout(&scene, &options, seen.as_deref()));
                match stable.or_else(file) {
                    Some(atlas) => Ok(atlas),
                    None => {
                        atlas::layout_seen(&scene.0, &options.layout(), seen.as_deref(), &cancelled)
                    }
                }
            };
            let atlas = time(&mut phases, "atlas", layout).map_err(|source| match source {
                atlas::Error::Cancelled => Error::Cancelled,
                source => Error::Layout {
                    scene: scene.path.display().to_string(),
                    source,
                },
            })?;
            Ok::<_, Error>((plan, world, atlas, backend))
        })?;
        let layout = LayoutReport::of(&scene, &atlas);
        Ok(Self {
            scene,
            options,
            baker,
            plan,
            world,
            atlas,
            layout,
            earlier,
            backend,
            pool,
            started,
            phases,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The options.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The options as the baker takes them.
    pub fn baker_options(&self) -> &::bake::Options {
        &self.baker
    }

    /// What is modelled and why.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The planner's decisions as `bake.json` carries them.
    pub fn decisions(&self) -> Vec<DecisionReport> {
        let report = |decision: &Decision| DecisionReport {
            decision: decision.choice.name().into(),
            modelled: decision.modelled,
            reason: decision.reason.clone(),
            method: decision.method.map(|method| method.name().into()),
        };
        self.plan.decisions.iter().map(report).collect()
    }

    /// Every file that the bake is made from.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let mut inputs = self.scene().inputs.clone();
        inputs.extend(self.options().sky.file.clone());
        inputs
    }

    /// The triangles as the rays see them. Coordinates count from [`World::origin`].
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Where every texel lies.
    pub fn atlas(&self) -> &Atlas {
        &self.atlas
    }

    /// The bake that this one updates.
    pub(crate) fn earlier(&self) -> Option<&Earlier> {
        self.earlier.as_ref()
    }

    /// Where the texels went.
    pub fn layout_report(&self) -> &LayoutReport {
        &self.layout
    }

    /// Everything that was repaired, ignored or is doubtful before a ray was cast, and matters to this bake.
    pub fn warnings(&self) -> Vec<WarningReport> {
        let ignored = |warning: &&::scene::Warning| {
            let tinted = [Layer::Lambert, Layer::Traditional];
            match warning.kind {
                ::scene::WarningKind::IgnoredNormalMaps => self.options.normal_maps,
                ::scene::WarningKind::AmbientCoefficients => {
                    let options = &self.options;
                    let shown = options.layers.contains(&Layer::Traditional);
                    !shown || options.ambient_coefficient != AmbientCoefficient::Albedo
                }
                // Light without a tint is not black on them.
                ::scene::WarningKind::BlackMetals => !tinted
                    .iter()
                    .any(|layer| self.options.layers.contains(layer)),
                _ => false,
            }
        };
        let layout = self.options.layout();
        let alone = layout.pages == Pages::Auto && !layout.one_page_per_mesh;
        let small_page = (layout.is_shared() && self.atlas.source.is_packed())
            .then(|| self.layout.small_page(&self.scene, &self.atlas, alone));
        let of_scene = self
            .scene
            .warnings
            .iter()
            .filter(|warning| !ignored(warning));
        of_scene
            .map(Into::into)
            .chain(self.layout.warnings())
            .chain(small_page.flatten())
            .chain(self.touching())
            .chain(self.outsides())
            .chain(self.inside_out())
            .chain(self.turned_over())
            .chain(self.too_bright())
            .chain(self.lights_left_out())
            .chain(self.lamps_left_out())
            .collect()
    }

    /// Coefficients given for all surfaces by which the sum of diffuse and highlight is more than arrives.
    fn too_bright(&self) -> Option<WarningReport> {
        let (albedo, specular) = (self.options.albedo?, self.options.specular?);
        let sums = [0, 1, 2].map(|channel| albedo[channel] + specular[channel]);
        let most = sums.into_iter().fold(0.0, f32::max);
        let adds = self.options.model != Some(Model::Ggx);
        (adds && most > 1.0 + 1e-6).then(|| WarningReport {
            kind: "too-bright".into(),
            place: "scene".into(),
            count: 1,
            message: format!(
                "`--albedo` and `--specular` together reflect {} times the light that arrives, and no surface reflects more than all of it; lower \
                 one of them, or take `--model ggx`, which gives the highlight's share to it alone",
                (100.0 * most).round() / 100.0
            ),
        })
    }

    /// Coordinates of the file of which look-ups mix surfaces.
    fn touching(&self) -> Option<WarningReport> {
        let is_kept = !self.atlas.source.is_packed();
        let found = is_kept.then(|| self.within(|| atlas::touching(&self.scene, &self.atlas)));
        let (texels, instance) = found.flatten()?;
        let share = texels as f64 / self.atlas.audit.texels.max(1) as f64;
        (share >= atlas::LEAST_TOUCHING).then(|| WarningReport {
            kind: "touching-charts".into(),
            place: format!("object `{}`", self.scene.instances[instance as usize].name),
            count: texels,
            message: "texels of the file's coordinates stand beside those of other surfaces without a gutter, so that look-ups mix both; give the charts \
                      two empty texels between them, or let `--uv unwrap` make others"
                .into(),
        })
    }

    /// Outsides of rooms that take texels though nobody within sees them.
    fn outsides(&self) -> Option<WarningReport> {
        let options = &self.options;
        let is_asked = options.seen_from_within || !options.seen_from.is_empty();
        if is_asked || !self.atlas.source.is_packed() {
            return None;
        }
        let share =
            self.within(|| Some(Shell::of(&self.world, self.backend())?.share(&self.atlas)))?;
        (share >= LEAST_OUTSIDE).then(|| WarningReport {
            kind: "outsides".into(),
            place: "scene".into(),
            count: (share * self.atlas.audit.texels as f64) as u64,
            message: format!(
                "{:.0} % of the texels lie on outsides of rooms, which nobody within sees; `--seen-from auto` gives each of their charts one \
                 texel, and theirs to what is seen",
                100.0 * share
            ),
        })
    }

    /// Closed surfaces with texels whose backs are lit.
    fn turned_over(&self) -> Option<WarningReport> {
        let (instances, placements) = (&self.scene.instances, &self.atlas.placements);
        let turned = (0..)
            .zip(instances.iter().zip(placements))
            .filter(|(number, of)| of.1.is_somewhere() && self.world.has_turned_over(*number));
        let names: Vec<&str> = turned.map(|(_, of)| of.0.name.as_str()).collect();
        Some(WarningReport {
            kind: "turned-over".into(),
            place: format!("object `{}`", names.first()?),
            count: names.len() as u64,
            message: "faces of a closed surface look inward, where nothing is, and are drawn from both sides; their outside is \
                      baked"
                .into(),
        })
    }

    /// Closed surfaces with texels that are lit from within.
    fn inside_out(&self) -> Option<WarningReport> {
        let mut found = self.world.solids().inside_out();
        found.retain(|&(instance, triangle)| {
            self.atlas.placements[instance as usize].is_somewhere()
                && !self.world.is_turned_over(instance, triangle)
        });
        let first = &self.scene.instances[found.first()?.0 as usize];
        Some(WarningReport {
            kind: "inside-out".into(),
            place: format!("object `{}`", first.name),
            count: found.len() as u64,
            message: "faces of a closed surface look inward, so it is lit from within and dark: turn them over, unless it is an empty room".into(),
        })
    }

    /// Lights of the file that nobody said anything about.
    fn lights_left_out(&self) -> Option<WarningReport> {
        let lights = &self.scene.lights;
        let first = lights
            .first()
            .filter(|_| self.options.file_lights.is_none())?;
        Some(WarningReport {
            kind: "file-lights".into(),
            place: named("light", &first.name, lights.len()),
            count: lights.len() as u64,
            message: "lights of the file are not baked; `--lights file` bakes them, `--lights none` leaves them out".into(),
        })
    }

    /// Surfaces of the file that shine, in a bake in which no light bounces and nobody said that they should not.
    fn lamps_left_out(&self) -> Option<WarningReport> {
        let is_dark = self.options.bounces == Bounces::Off && self.baker.asks_for_light();
        if !is_dark || self.options.file_lights == Some(false) {
            return None;
        }
        let casting = self.scene.instances.iter().filter(|of| of.casts);
        let shines = |&material: &u32| {
            let emission = self.scene.materials[material as usize].emission;
            emission != glam::Vec3::ZERO
        };
        let mut lit: Vec<u32> = casting
            .map(|of| self.scene.meshes[of.mesh as usize].material)
            .filter(shines)
            .collect();
        lit.sort_unstable();
        lit.dedup();
        let first = &self.scene.materials[*lit.first()? as usize];
        Some(WarningReport {
            kind: "dark-lamps".into(),
            place: named("material", &first.name, lit.len()),
            count: lit.len() as u64,
            message: "surfaces that shine (`Ke`, emissiveFactor) send out no light where none bounces; `--bounces 1` bakes what they send, \
                      `--bounces auto` also what others send on, and `--lights none` says that they should stay dark"
                .into(),
        })
    }

    /// What answers rays.
    pub fn backend(&self) -> &dyn RayBackend {
        self.backend.as_ref()
    }

    /// Wall time of what has been done so far.
    pub fn phases(&self) -> &[PhaseReport] {
        &self.phases
    }

    /// Runs something in the bake's own pool of threads, or in the current one.
    pub(crate) fn within<R: Send>(&self, job: impl FnOnce() -> R + Send) -> R {
        within(self.pool.as_ref(), job)
    }

    /// When it was begun.
    pub(crate) fn started(&self) -> Instant {
        self.started
    }

    /// Adds the time of a phase that has just ended.
    pub(crate) fn end_phase(&mut self, phase: &str, seconds: f64) {
        self.phases.push(PhaseReport {
            phase: phase.into(),
            seconds,
            ..PhaseReport::default()
        });
    }

    /// Adds the time of a phase that ran before the job was prepared, such as loading.
    pub fn add_phase(&mut self, phase: &str, seconds: f64) {
        let report = PhaseReport {
            phase: phase.into(),
            seconds,
            ..PhaseReport::default()
        };
        self.phases.insert(0, report);
        self.started -= std::time::Duration::from_secs_f64(seconds);
    }

    /// The memory of its pages.
    pub(crate) fn memory(&self) -> memory::Memory {
        memory::Memory::of(&self.baker, &self.plan)
    }

    /// Bakes about `tiles` tiles spread over the atlas, for estimates of time and rays.
    pub fn pilot(&self, tiles: usize) -> Pilot {
        self.within(|| self.baker().pilot(tiles))
    }

    /// What bakes its pages.
    pub(crate) fn baker(&self) -> Baker<'_> {
        Baker::new(
            &self.world,
            &self.plan,
            self.backend.as_ref(),
            &self.atlas,
            &self.baker,
        )
    }

    /// How many values a texel has while it is baked by `baker`, and while light bounces.
    pub(crate) fn widths(&self, baker: &Baker<'_>) -> Widths {
        let width = |layers: Vec<Layer>| layers.iter().map(|l| l.channels().len()).sum();
        Widths {
            pages: self.atlas.page_count,
            page: width(baker.layers()),
            gather: width(baker.layers_of_gathers()),
        }
    }
}

/// The first of so many things, for a message.
fn named(what: &str, first: &str, count: usize) -> String {
    match count {
        1 => format!("{what} `{first}`"),
        _ => format!("{what} `{first}` and {} more", count - 1),
    }
}

/// Runs a job in the pool, or in the current one.
fn within<R: Send>(pool: Option<&rayon::ThreadPool>, job: impl FnOnce() -> R + Send) -> R {
    match pool {
        Some(pool) => pool.install(job),
        None => job(),
    }
}

/// Runs and times one phase.
fn time<R>(phases: &mut Vec<PhaseReport>, phase: &str, job: impl FnOnce() -> R) -> R {
    let (started, cpu) = (Instant::now(), cpu_seconds());
    let result = job();
    phases.push(PhaseReport {
        phase: phase.into(),
        seconds: started.elapsed().as_secs_f64(),
        cpu_seconds: cpu.and_then(|before| Some(cpu_seconds()? - before)),
    });
    result
}
