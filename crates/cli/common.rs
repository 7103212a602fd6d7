//! Flags that several verbs share, and what they mean.

use anyhow::Context;
use clap::{Args as ClapArgs, ValueEnum};
use glam::DVec3;
use rays::{RayBackend, World, WorldOptions};
use render::Light;
use scene::Scene;
use std::path::Path;
use std::sync::Arc;

#[derive(ClapArgs)]
pub struct Common {
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Seed of the sample points
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Read files that the scene names outside of its folder too, for a scene that you trust
    #[arg(long)]
    pub allow_outside: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Print a machine-readable summary on standard output
    #[arg(long)]
    pub json: bool,
    /// Also print the plan and the time of each phase
    #[arg(short = 'v', long)]
    pub verbose: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// Debian's Embree
    Embree,
    /// Pure Rust: obvhs, 8-wide compressed BVH
    Obvhs,
    /// Pure Rust: obvhs, binary BVH
    ObvhsBvh2,
}

impl Backend {
    /// The chosen ray library, or the best one that is built in.
    pub fn chosen(choice: Option<Backend>) -> ambake::Backend {
        match choice {
            Some(Backend::Embree) => ambake::Backend::Embree,
            Some(Backend::Obvhs) => ambake::Backend::Obvhs,
            Some(Backend::ObvhsBvh2) => ambake::Backend::ObvhsBvh2,
            None => ambake::Backend::best(),
        }
    }
}

impl Common {
    /// Where the files may lie that a scene names.
    pub fn files(&self) -> scene::Files {
        match self.allow_outside {
            true => scene::Files::Anywhere,
            false => scene::Files::Inside,
        }
    }
}

/// A scene as camera rays see it. Coordinates count from [`World::origin`].
pub fn build(
    scene: Scene,
    backend: Option<Backend>,
    threads: usize,
) -> anyhow::Result<(World, Box<dyn RayBackend>)> {
    let world = World::near(Arc::new(scene), WorldOptions::default())?;
    let backend = rays::build(Backend::chosen(backend).kind(), &world, threads)?;
    Ok((world, backend))
}

/// The lights of `--sun` and `--point`, where coordinates count from `origin`.
pub fn lights(suns: &[[f64; 6]], points: &[[f64; 6]], origin: DVec3) -> Vec<Light> {
    let of = |make: fn([f64; 3], [f64; 3]) -> Light| {
        move |&[x, y, z, r, g, b]: &[f64; 6]| make([x, y, z], [r, g, b])
    };
    let suns = suns.iter().map(of(Light::sun));
    let all = suns.chain(points.iter().map(of(Light::point)));
    all.map(|light| light.from_origin(origin)).collect()
}

/// The lights of `--sphere` and `--rect`, where coordinates count from `origin`.
pub fn lamps(spheres: &[[f64; 7]], rects: &[[f64; 12]], origin: DVec3) -> Vec<Light> {
    let balls = spheres
        .iter()
        .map(|&[x, y, z, radius, r, g, b]| Light::sphere([x, y, z], radius, [r, g, b]));
    let panels = rects
        .iter()
        .map(|&[x, y, z, a, b, c, d, e, f, red, green, blue]| {
            Light::rect([x, y, z], [[a, b, c], [d, e, f]], [red, green, blue])
        });
    let all = balls.chain(panels);
    all.map(|light| light.from_origin(origin)).collect()
}

/// What a text file holds; errors name it.
pub fn parsed<T, E>(path: &Path, parse: impl FnOnce(&str) -> Result<T, E>) -> anyhow::Result<T>
where
    E: std::error::Error + Send + Sync + 'static,
{
    parse(&text_file(path)?).with_context(|| path.display().to_string())
}

/// The text of a regular file; errors name it.
pub fn text_file(path: &Path) -> anyhow::Result<String> {
    let text = report::check_regular(path).and_then(|()| std::fs::read_to_string(path));
    let text = text.with_context(|| format!("cannot read {}", path.display()))?;
    Ok(text.trim_start_matches('\u{feff}').to_owned())
}
