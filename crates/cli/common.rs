//! Flags that several verbs share, and what they mean.

use crate::parse::{light, rect, sphere, sun};
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
    #[arg(help_heading = "Machine")]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// Seed of the sample points
    #[arg(help_heading = "Rays", hide_short_help = true)]
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Read files that the scene names outside of its folder too, for a scene that you trust
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long)]
    pub allow_outside: bool,
    /// Print nothing but errors
    #[arg(help_heading = "Machine")]
    #[arg(short, long)]
    pub quiet: bool,
    /// Print a machine-readable summary on standard output
    #[arg(help_heading = "Machine", hide_short_help = true)]
    #[arg(long)]
    pub json: bool,
    /// Also print the plan and the time of each phase
    #[arg(help_heading = "Machine", hide_short_help = true)]
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

/// Lights that are typed.
#[derive(ClapArgs, Clone)]
pub struct Shining {
    /// Distant light in the direction X,Y,Z with irradiance E or R,G,B (W/m², facing); may be repeated
    #[arg(help_heading = "Light")]
    #[arg(long, value_name = "X,Y,Z,E|X,Y,Z,R,G,B", allow_hyphen_values = true, value_parser = sun)]
    pub sun: Vec<[f64; 6]>,
    /// Point light at X,Y,Z with intensity E or R,G,B (W/sr: E over distance² arrives); may be repeated
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_name = "X,Y,Z,E|X,Y,Z,R,G,B", allow_hyphen_values = true, value_parser = light)]
    pub point: Vec<[f64; 6]>,
    /// Luminous ball at X,Y,Z of this radius that sends the radiance L or R,G,B; may be repeated
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_name = "X,Y,Z,RADIUS,L|X,Y,Z,RADIUS,R,G,B", allow_hyphen_values = true, value_parser = sphere)]
    pub sphere: Vec<[f64; 7]>,
    /// Luminous rectangle with a corner at X,Y,Z and the sides U and V (three numbers each) that sends the
    /// radiance L or R,G,B to the side to which U x V points; may be repeated
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_name = "X,Y,Z,U,V,L|X,Y,Z,U,V,R,G,B", allow_hyphen_values = true, value_parser = rect)]
    pub rect: Vec<[f64; 12]>,
}

impl Shining {
    /// All of them, where coordinates count from `origin`.
    pub fn lights(&self, origin: DVec3) -> Vec<Light> {
        let suns = self
            .sun
            .iter()
            .map(|&[x, y, z, r, g, b]| Light::sun([x, y, z], [r, g, b]));
        let balls = self
            .sphere
            .iter()
            .map(|&[x, y, z, radius, r, g, b]| Light::sphere([x, y, z], radius, [r, g, b]));
        let panels = self
            .rect
            .iter()
            .map(|&[x, y, z, a, b, c, d, e, f, red, green, blue]| {
                Light::rect([x, y, z], [[a, b, c], [d, e, f]], [red, green, blue])
            });
        let far = suns.map(|light| light.from_origin(origin));
        let wide = balls.chain(panels).map(|light| light.from_origin(origin));
        far.chain(points(&self.point, origin)).chain(wide).collect()
    }

    /// True where there is none.
    pub fn is_dark(&self) -> bool {
        self.lights(DVec3::ZERO).is_empty()
    }
}

/// The lights of `--point`, where coordinates count from `origin`.
pub fn points(points: &[[f64; 6]], origin: DVec3) -> impl Iterator<Item = Light> {
    let light = move |&[x, y, z, r, g, b]: &[f64; 6]| {
        Light::point([x, y, z], [r, g, b]).from_origin(origin)
    };
    points.iter().map(light)
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
