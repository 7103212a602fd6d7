//! What the command line means: typed options of the stages.

use super::args::{self, Job, Uv};
use crate::common::{Backend, Common};
use ::bake::{Denoise, Effort, Options, Pattern, PointSet, Sky};
use layers::Layer;
use rays::{BackendKind, Overrides};
use serde_json::{Value, json};

/// The bake's options.
pub fn bake_options(job: &Job, common: &Common, sky: Sky) -> Options {
    let mut layers = if job.only.is_empty() {
        Layer::STANDARD.to_vec()
    } else {
        vec![Layer::Coverage]
    };
    for &layer in job.only.iter().chain(&job.layers) {
        if !layers.contains(&layer) {
            layers.push(layer);
        }
    }
    Options {
        effort: match job.target_error {
            None => Effort::Rays(job.rays),
            Some(error) => Effort::Target {
                error,
                max_rays: job.max_rays,
            },
        },
        pattern: match job.pattern {
            args::Pattern::Independent => Pattern::Independent,
            args::Pattern::Tiled => Pattern::Tiled,
        },
        points: PointSet::default(),
        denoise: match job.denoise {
            args::Denoise::Off => Denoise::Off,
            args::Denoise::Regression => Denoise::Regression,
        },
        seed: common.seed,
        sky,
        draw_sky: true,
        view: job.view,
        max_distance: job.max_distance.map(|d| d as f32),
        layers,
        overrides: Overrides {
            albedo: job.albedo,
            specular: job.specular,
            exponent: job.exponent,
        },
        switched_off: job.plan_off.clone(),
    }
}

/// The atlas's options.
pub fn atlas_options(job: &Job) -> atlas::Options {
    let uv = match job.uv {
        Uv::Auto => atlas::UvMode::Auto,
        Uv::Keep => atlas::UvMode::Keep,
        Uv::Unwrap => atlas::UvMode::Unwrap,
    };
    atlas::Options {
        uv,
        page_size: job.size,
        density: job.density,
    }
}

/// The asked backend, or the best one that is built in.
pub fn backend(job: &Job) -> BackendKind {
    Backend::kind(job.backend)
}

/// Everything that decides the values of a bake, for headers, `bake.json` and the resume key.
pub fn describe(job: &Job, options: &Options, sky: &Value) -> Value {
    let uv = match job.uv {
        Uv::Auto => "auto",
        Uv::Keep => "keep",
        Uv::Unwrap => "unwrap",
    };
    let denoise = match options.denoise {
        Denoise::Off => "off",
        Denoise::Regression => "regression",
    };
    let fixed = match options.effort {
        Effort::Rays(rays) => Some(rays),
        Effort::Target { .. } => None,
    };
    let pattern = match options.pattern {
        Pattern::Independent => "independent",
        Pattern::Tiled => "tiled",
    };
    json!({
        "size": job.size,
        "density": job.density,
        "uv": uv,
        "rays": fixed,
        "target_error": job.target_error,
        "max_rays": job.target_error.map(|_| job.max_rays),
        "pattern": pattern,
        "denoise": denoise,
        "seed": options.seed,
        "sky": sky,
        "view": view_rule(options),
        "max_distance": options.max_distance,
        "layers": options.layers,
        "albedo": options.overrides.albedo,
        "specular": options.overrides.specular,
        "exponent": options.overrides.exponent,
        "plan_off": options.switched_off,
    })
}

/// The view rule as outputs state it.
pub fn view_rule(options: &Options) -> String {
    match options.view {
        ::bake::View::Normal => "normal".into(),
        ::bake::View::Eye(eye) => format!("{},{},{}", eye.x, eye.y, eye.z),
    }
}
