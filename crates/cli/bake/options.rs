//! What the flags of a bake mean.

use super::args::{self, Job};
use crate::common::{Backend, Common};
use ambake::{Bake, Buried, Denoise, Effort, Footprint, Model, Options, Seams, Shading, Uv};

/// The bake that was asked for.
pub fn bake(scene: &ambake::Scene, job: &Job, common: &Common) -> Result<Bake, ambake::Error> {
    let mut options = Options::default();
    options.size = job.size;
    match job.density {
        Some(args::Density::Of(density)) => options.density = Some(density),
        Some(args::Density::Even) => options.even_density = true,
        None => {}
    }
    options.density_of = job.density_of.clone();
    options.include = job.include.clone();
    options.exclude = job.exclude.clone();
    options.no_cast = job.no_cast.clone();
    for eyes in &job.seen_from {
        match eyes {
            args::Eyes::Within => options.seen_from_within = true,
            args::Eyes::At(places) => options.seen_from.extend(places),
        }
    }
    options.pages = job.pages;
    options.one_page_per_mesh = job.one_page_per_mesh;
    options.uv = match job.uv {
        args::Uv::Auto => Uv::Auto,
        args::Uv::Keep => Uv::Keep,
        args::Uv::Unwrap => Uv::Unwrap,
    };
    options.gutter = job.gutter;
    options.mips = job.mips;
    options.align = job.align;
    options.effort = match job.target_error {
        None => Effort::Rays(job.rays),
        Some(error) => Effort::Target {
            error,
            relative: job.target_relative.unwrap_or(0.0),
            max_rays: job.max_rays,
        },
    };
    options.footprint = match job.footprint {
        args::Footprint::Texel => Footprint::Texel,
        args::Footprint::Centre => Footprint::Centre,
    };
    options.denoise = job.denoise.map(|denoise| match denoise {
        args::Denoise::Off => Denoise::Off,
        args::Denoise::Regression => Denoise::Regression,
        args::Denoise::Oidn => Denoise::Oidn,
    });
    options.seams = match job.seams {
        args::Seams::Off => Seams::Off,
        args::Seams::Object => Seams::Object,
        args::Seams::Scene => Seams::Scene,
    };
    options.seed = common.seed;
    options.sky = job.sky.load()?;
    options.view = job.view;
    options.shading = match job.shading {
        args::Shading::Production => Shading::Production,
        args::Shading::Exact => Shading::Exact,
    };
    let buried = |typed: args::Buried| match typed {
        args::Buried::Drop => Buried::Drop,
        args::Buried::Keep => Buried::Keep,
    };
    options.buried = buried(job.buried);
    let of = job.buried_of.iter();
    options.buried_of = of.map(|(name, of)| (name.clone(), buried(*of))).collect();
    options.under = job.under;
    options.max_distance = job.max_distance.map(|d| d as f32);
    options.model = job.model.map(|model| match model {
        args::Model::Phong => Model::Phong,
        args::Model::Ggx => Model::Ggx,
    });
    options.bounces = job.bounces;
    options.lights = job.shining.lights(glam::DVec3::ZERO);
    options.file_lights = job.lights.map(|lights| lights == args::Lights::File);
    options.normal_maps = job.normal_maps;
    options.ambient_coefficient = job.ambient_coefficient.unwrap_or_default();
    options.albedo = job.albedo;
    options.specular = job.specular;
    options.exponent = job.exponent;
    options.plan_off = job.plan_off.clone();
    let mut bake = Bake::new(scene)
        .options(options)
        .backend(Backend::chosen(job.backend));
    if let Some(bytes) = job.max_memory {
        bake = bake.max_memory(bytes);
    }
    Ok(match job.only.is_empty() {
        true => bake.layers(job.layers.iter().copied()),
        false => bake.only(job.only.iter().copied()),
    })
}
