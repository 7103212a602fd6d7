//! Techniques side by side: the error of a bake against the CPU seconds that it takes, interleaved in one run.

use crate::Subject;
use crate::clock::time;
use bake::{BakedPage, Denoise, Effort, Options, PointSet, Sky};
use layers::Layer;
use rays::{BackendKind, Coherence, Ray, RayBackend, RayPacket, SurfaceHit, TreeKind};
use serde::Serialize;

/// Rays of the reference that errors are measured against, and its seed.
pub(crate) const REFERENCE_RAYS: u32 = 16_384;
const REFERENCE_SEED: u64 = 0x5eed;

/// One way to bake.
#[derive(Debug, Clone, Copy)]
pub struct Technique {
    /// Its name in tables.
    pub name: &'static str,
    /// Which library answers.
    pub backend: BackendKind,
    /// Rays go one by one instead of in packets of 16.
    pub single: bool,
    /// See [`Options::points`].
    pub points: PointSet,
    /// See [`Options::denoise`]. What denoises is left out under an illumination map.
    pub denoise: Denoise,
    /// See [`Options::draw_sky`]. What does not is left out under a uniform sky.
    pub draw_sky: bool,
    /// Efforts in rising order.
    pub efforts: &'static [Effort],
}

// Rays rise by factors of two at most, in all of them: fixed costs bend a curve, and a straight line over a factor of
// four is up to 7 % above it, which would count against the technique that has fewer efforts.
const FEW: &[Effort] = &[
    Effort::Rays(16),
    Effort::Rays(32),
    Effort::Rays(64),
    Effort::Rays(128),
    Effort::Rays(256),
];
const MANY: &[Effort] = &[
    Effort::Rays(16),
    Effort::Rays(32),
    Effort::Rays(64),
    Effort::Rays(128),
    Effort::Rays(256),
    Effort::Rays(512),
    Effort::Rays(1024),
];
const TARGETS: &[Effort] = &[
    target(0.02),
    target(0.014),
    target(0.01),
    target(0.007),
    target(0.005),
];

const fn target(error: f64) -> Effort {
    Effort::Target {
        error,
        relative: 0.0,
        max_rays: 16_384,
    }
}

/// All techniques; the first is what a bake does by itself.
pub const TECHNIQUES: [Technique; 9] = {
    let plain = Technique {
        name: "embree packets, owen-sobol",
        backend: BackendKind::Embree,
        single: false,
        points: PointSet::Sobol,
        denoise: Denoise::Off,
        draw_sky: true,
        efforts: MANY,
    };
    let cwbvh = BackendKind::Obvhs(TreeKind::Cwbvh);
    [
        plain,
        Technique {
            name: "the same, --denoise regression",
            denoise: Denoise::Regression,
            efforts: MANY,
            ..plain
        },
        Technique {
            name: "the same, no directions from the map",
            draw_sky: false,
            efforts: MANY,
            ..plain
        },
        Technique {
            name: "the same, --target-error",
            efforts: TARGETS,
            ..plain
        },
        Technique {
            name: "embree packets, lattice",
            points: PointSet::Lattice,
            efforts: FEW,
            ..plain
        },
        Technique {
            name: "embree packets, random",
            points: PointSet::Random,
            efforts: FEW,
            ..plain
        },
        Technique {
            name: "embree single rays",
            single: true,
            efforts: FEW,
            ..plain
        },
        Technique {
            name: "obvhs cwbvh",
            backend: cwbvh,
            efforts: FEW,
            ..plain
        },
        Technique {
            name: "obvhs bvh2",
            backend: BackendKind::Obvhs(TreeKind::Bvh2),
            efforts: FEW,
            ..plain
        },
    ]
};

/// The name of an effort in rows: `rays 64` or `target 0.01`.
pub(crate) fn effort_name(effort: Effort) -> String {
    match effort {
        Effort::Rays(rays) => format!("rays {rays}"),
        Effort::Target { error, .. } => format!("target {error}"),
    }
}

/// What errors are of under these options: the irradiance under an illumination map, else the diffuse term.
pub fn quantity(options: &Options) -> &'static str {
    match options.sky {
        Sky::Map(_) => "irradiance (mean of its channels)",
        Sky::Uniform(_) => "diffuse term",
    }
}

/// One bake.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Name of the technique.
    pub technique: &'static str,
    /// `rays 64` or `target 0.01`.
    pub effort: String,
    /// Which of the repeats, from 0; also the seed.
    pub repeat: u32,
    /// Root mean square error over covered texels of the diffuse term, or of the irradiance, mean of its channels,
    /// under an illumination map.
    pub rmse: f64,
    /// What the layer of its error says of it.
    pub estimated_rmse: f64,
    /// CPU seconds of the bake, without building the ray scene and without writing.
    pub cpu_seconds: f64,
    /// Wall seconds of the same.
    pub wall_seconds: f64,
    /// Rays cast.
    pub rays: u64,
    /// Texels baked.
    pub texels: u64,
}

/// Answers packets ray by ray.
struct Single<'a>(&'a dyn RayBackend);

impl RayBackend for Single<'_> {
    fn occluded16(&self, packet: &RayPacket<16>, active: u32, _: Coherence) -> u32 {
        (0..16)
            .filter(|lane| active >> lane & 1 == 1)
            .filter(|&lane| self.0.occluded(&packet.get(lane)))
            .fold(0, |blocked, lane| blocked | 1 << lane)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.0.occluded(ray)
    }

    fn closest(&self, ray: &Ray) -> Option<SurfaceHit> {
        self.0.closest(ray)
    }

    fn closest_that(&self, ray: &Ray, stops: rays::Stops) -> Option<SurfaceHit> {
        self.0.closest_that(ray, stops)
    }

    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn describe(&self) -> String {
        self.0.describe()
    }

    fn memory_bytes(&self) -> u64 {
        self.0.memory_bytes()
    }
}

/// Bakes page 0 with every technique and effort, `repeats` times in turn. Techniques whose backend is not built in are
/// left out. `tell` hears of every row.
///
/// # Errors
/// A backend could not be built.
pub fn speed(
    subject: Subject<'_>,
    options: &Options,
    repeats: u32,
    mut tell: impl FnMut(&Row),
) -> Result<Vec<Row>, rays::Error> {
    let build = |kind| rays::build(kind, subject.world, 0);
    let by_map = matches!(options.sky, Sky::Map(_));
    let mut options = options.clone();
    if by_map && !options.layers.contains(&Layer::Irradiance) {
        options.layers.push(Layer::Irradiance);
    }
    if !options.layers.contains(&Layer::Validity) {
        options.layers.push(Layer::Validity);
    }
    let techniques = TECHNIQUES
        .iter()
        .filter(|t| t.backend != BackendKind::Embree || embree::header_version().is_some())
        .filter(|t| match by_map {
            true => t.denoise == Denoise::Off,
            false => t.draw_sky,
        });
    let mut built = Vec::new();
    for technique in techniques {
        built.push((technique, build(technique.backend)?));
    }
    let reference = subject.bake(
        built[0].1.as_ref(),
        &Options {
            effort: Effort::Rays(REFERENCE_RAYS),
            seed: REFERENCE_SEED,
            // Its own noise is known; what a denoiser leaves is not.
            denoise: Denoise::Off,
            ..options.clone()
        },
    );
    let mut rows = Vec::new();
    for repeat in 0..repeats {
        for (technique, backend) in &built {
            let single = Single(backend.as_ref());
            let backend: &dyn RayBackend = if technique.single {
                &single
            } else {
                backend.as_ref()
            };
            for &effort in technique.efforts {
                let options = Options {
                    effort,
                    points: technique.points,
                    denoise: technique.denoise,
                    draw_sky: technique.draw_sky,
                    seed: u64::from(repeat),
                    ..options.clone()
                };
                let (page, spent) = time(|| subject.bake(backend, &options));
                let row = Row {
                    technique: technique.name,
                    effort: effort_name(effort),
                    repeat,
                    rmse: rmse(&page, &reference, by_map),
                    estimated_rmse: match by_map {
                        true => page.stats.irradiance_rmse(),
                        false => page.stats.rmse(),
                    },
                    cpu_seconds: spent.cpu,
                    wall_seconds: spent.wall,
                    rays: page.stats.rays,
                    texels: page.stats.texels,
                };
                tell(&row);
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

/// Root mean square difference of the diffuse term, or of the mean of irradiance's channels, over covered texels that
/// something can see: what is buried holds what its neighbours have.
fn rmse(page: &BakedPage, reference: &BakedPage, by_map: bool) -> f64 {
    let layer = match by_map {
        true => Layer::Irradiance,
        false => Layer::Diffuse,
    };
    let values = |page: &BakedPage, layer| page.layer(layer).unwrap_or_default().to_vec();
    let (coverage, validity) = (
        values(page, Layer::Coverage),
        values(reference, Layer::Validity),
    );
    let counts = |&texel: &usize| coverage[texel] > 0.0 && validity[texel] > 0.0;
    let (own, other) = (values(page, layer), values(reference, layer));
    let channels = layer.channels().len();
    let (mut squares, mut count) = (0.0, 0.0);
    for texel in (0..page.texels()).filter(counts) {
        let difference: f64 = (0..channels)
            .map(|channel| channel * page.texels() + texel)
            .map(|at| f64::from(own[at] - other[at]) / channels as f64)
            .sum();
        squares += difference * difference;
        count += 1.0;
    }
    if count > 0.0 {
        f64::sqrt(squares / count)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn efforts_of_every_technique_rise() {
        for technique in &TECHNIQUES {
            let rises = |pair: &[Effort]| match (pair[0], pair[1]) {
                (Effort::Rays(a), Effort::Rays(b)) => a < b,
                (Effort::Target { error: a, .. }, Effort::Target { error: b, .. }) => a > b,
                _ => false,
            };
            let efforts = technique.efforts;
            assert!(
                efforts.windows(2).all(rises),
                "{}: {efforts:?}",
                technique.name
            );
        }
    }
}
