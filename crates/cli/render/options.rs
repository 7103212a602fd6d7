//! What the command line means: typed options of the renderer.

use super::args::{Args, ModelName, View};
use super::tables_args::{LookupName, NormalsName, ShaderName, Tables, WeightName};
use crate::common::parsed;
use crate::progress::Show;
use ::render::tables::{Lookup, NormalCode, Subject, SurfaceType, Weight};
use ::render::{Direct, Framing, Lamps, Light, Model};
use glam::Vec3;
use rays::{Overrides, RayBackend, Surfaces};

/// Where the picture is taken from.
pub fn framing(view: &View) -> Framing {
    Framing {
        eye: view.eye.map(Into::into),
        look: view.look.map(Into::into),
        up: view.up.into(),
        fov: view.fov_deg().to_radians(),
        size: view.size,
    }
}

/// The ambient model.
pub fn model(name: ModelName) -> Model {
    match name {
        ModelName::Traditional => Model::Traditional,
        ModelName::TraditionalClosed => Model::TraditionalClosed,
        ModelName::Lambert => Model::Lambert,
        ModelName::Phong => Model::Phong,
        ModelName::Ggx => Model::Ggx,
        ModelName::LommelSeeliger => Model::LommelSeeliger,
        ModelName::FacingRatio => Model::FacingRatio,
    }
}

/// The uniform sky, without a bake.
pub fn sky(args: &Args) -> [f32; 3] {
    args.sky.unwrap_or([1.0; 3])
}

/// What shades camera rays by integration.
pub fn direct<'a>(
    args: &Args,
    surfaces: &'a Surfaces<'a>,
    backend: &'a dyn RayBackend,
    lights: &'a [Light],
    lamps: &'a Lamps,
) -> Direct<'a> {
    let rgb = |rgb: [f32; 3]| Vec3::from(rgb).as_dvec3();
    Direct {
        surfaces,
        backend,
        model: model(args.model),
        rays: args.rays,
        sky: rgb(sky(args)),
        background: rgb(args.background.unwrap_or(sky(args))),
        lights,
        max_distance: args.max_distance.map_or(f32::INFINITY, |d| d as f32),
        seed: args.common.seed,
        overrides: overrides(args),
        lamps,
    }
}

/// What camera rays of a table-shaded picture meet.
pub fn subject<'a>(
    args: &Args,
    surfaces: &'a Surfaces<'a>,
    backend: &'a dyn RayBackend,
) -> Subject<'a> {
    Subject {
        surfaces,
        backend,
        overrides: overrides(args),
    }
}

fn overrides(args: &Args) -> Overrides {
    Overrides {
        albedo: args.albedo,
        specular: args.specular,
        exponent: args.exponent,
    }
}

/// The type of every surface.
pub fn surface_type(tables: &Tables) -> SurfaceType {
    match tables.shader {
        None | Some(ShaderName::Phong) => SurfaceType::Phong,
        Some(ShaderName::Mirror) => SurfaceType::Mirror,
        Some(ShaderName::Varnish) => SurfaceType::Varnish,
        Some(ShaderName::Retro) => SurfaceType::Retro,
        Some(ShaderName::Refraction) => SurfaceType::Refraction(tables.ior),
        Some(ShaderName::Luminous) => SurfaceType::Luminous,
    }
}

/// Wd and Ws, read from their files where they are in files.
pub fn weights(tables: &Tables) -> anyhow::Result<[Weight; 2]> {
    let weight = |name: &WeightName| match name {
        WeightName::Known(weight) => Ok(weight.clone()),
        WeightName::File(path) => parsed(path, Weight::parse),
    };
    Ok([
        weight(&tables.diffuse_weight)?,
        weight(&tables.specular_weight)?,
    ])
}

/// How tables are read.
pub fn lookup(name: LookupName) -> Lookup {
    match name {
        LookupName::Nearest => Lookup::Nearest,
        LookupName::Bilinear => Lookup::Bilinear,
        LookupName::Recursive => Lookup::Recursive,
        LookupName::Quad => Lookup::Quad,
        LookupName::Summed => Lookup::Summed,
    }
}

/// What normals are rounded to.
pub fn normal_code(name: NormalsName) -> NormalCode {
    match name {
        NormalsName::Visible256 => NormalCode::Visible256,
        NormalsName::Oct8 => NormalCode::Octahedral(8),
        NormalsName::Oct10 => NormalCode::Octahedral(10),
        NormalsName::Oct12 => NormalCode::Octahedral(12),
        NormalsName::Oct16 => NormalCode::Octahedral(16),
    }
}

/// How progress is shown, counted in `unit`.
pub fn show(args: &Args, unit: &'static str) -> Show {
    Show {
        unit,
        quiet: args.common.quiet,
    }
}
