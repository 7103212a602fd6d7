//! What the flags of a bake mean.

use super::args::Job;
use super::values;
use crate::common::{Backend, Common};
use ambake::{Bake, Buried, Denoise, Effort, Footprint, Model, Options, Seams, Shading, Uv};

/// The bake that was asked for.
pub fn bake(scene: &ambake::Scene, job: &Job, common: &Common) -> Result<Bake, ambake::Error> {
    let mut options = Options::default();
    options.size = job.size;
    match job.density {
        Some(values::Density::Of(density)) => options.density = Some(density),
        Some(values::Density::Even) => options.even_density = true,
        None => {}
    }
    options.density_of = job.density_of.clone();
    options.include = job.include.clone();
    options.exclude = job.exclude.clone();
    options.no_cast = job.no_cast.clone();
    for eyes in &job.seen_from {
        match eyes {
            values::Eyes::Within => options.seen_from_within = true,
            values::Eyes::At(places) => options.seen_from.extend(places),
        }
    }
    options.pages = job.pages;
    options.one_page_per_mesh = job.one_page_per_mesh;
    options.uv = match job.uv {
        values::Uv::Auto => Uv::Auto,
        values::Uv::Keep => Uv::Keep,
        values::Uv::Unwrap => Uv::Unwrap,
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
        values::Footprint::Texel => Footprint::Texel,
        values::Footprint::Centre => Footprint::Centre,
    };
    options.denoise = job.denoise.map(|denoise| match denoise {
        values::Denoise::Off => Denoise::Off,
        values::Denoise::Regression => Denoise::Regression,
        values::Denoise::Oidn => Denoise::Oidn,
    });
    options.seams = match job.seams {
        values::Seams::Off => Seams::Off,
        values::Seams::Object => Seams::Object,
        values::Seams::Scene => Seams::Scene,
    };
    options.vertices = job.to == values::To::Vertices;
    options.seed = common.seed;
    options.sky = job.sky.load()?;
    options.view = job.view;
    options.shading = match job.shading {
        values::Shading::Production => Shading::Production,
        values::Shading::Exact => Shading::Exact,
    };
    let buried = |typed: values::Buried| match typed {
        values::Buried::Drop => Buried::Drop,
        values::Buried::Keep => Buried::Keep,
    };
    options.buried = buried(job.buried);
    let of = job.buried_of.iter();
    options.buried_of = of.map(|(name, of)| (name.clone(), buried(*of))).collect();
    options.under = job.under;
    options.max_distance = job.max_distance.map(|d| d as f32);
    options.model = job.model.map(|model| match model {
        values::Model::Phong => Model::Phong,
        values::Model::Ggx => Model::Ggx,
    });
    options.bounces = job.bounces;
    options.lights = job.shining.lights(glam::DVec3::ZERO);
    options.file_lights = job.lights.map(|lights| lights == values::Lights::File);
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
