//! Flags that several verbs share.

use super::parse::{light, rect, sphere, sun, whole};
use clap::Args;
use glam::DVec3;
use rays::Light;

#[derive(Args)]
pub struct Common {
    /// Worker threads [default: all cores]
    #[arg(help_heading = "Machine")]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1024))]
    pub threads: Option<u32>,
    /// Seed of the sample points
    #[arg(help_heading = "Rays", hide_short_help = true)]
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = whole::<u64>(0..=u64::MAX))]
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

impl Common {
    /// Where the files may lie that a scene names.
    pub fn files(&self) -> scene::Files {
        match self.allow_outside {
            true => scene::Files::Anywhere,
            false => scene::Files::Inside,
        }
    }
}

/// Lights that are typed.
#[derive(Args, Clone)]
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
