//! What the command line means: typed options of the renderer.

use super::args::{Args, View};
use super::tables_args::{ShaderName, Tables, WeightName};
use crate::common::parsed;
use crate::progress::Show;
use ::frames::{Shading, Subject, SurfaceType};
use ::render::{Direct, Framing, Lamps, Light, Model, Weight};
use ambake::Sky;
use ambake::flags::sky::SkyArg;
use anyhow::bail;
use glam::{DVec3, Vec3};
use rays::{Overrides, RayBackend, Surfaces, World};
use scene::Scene;

/// Where the picture is taken from, in coordinates of the world.
pub fn framing(view: &View, world: &World) -> Framing {
    let near = |place: [f64; 3]| DVec3::from(place) - world.origin();
    Framing {
        eye: view.eye.map(near),
        look: view.look.map(near),
        up: view.up.into(),
        fov: view.fov_deg().to_radians(),
        size: view.size,
    }
}

/// The sky that is asked for, read; white where none is.
///
/// # Errors
/// A map that cannot be read.
pub fn sky(args: &Args) -> Result<Sky, ambake::Error> {
    args.sky
        .as_ref()
        .map_or_else(|| Ok(Sky::default()), SkyArg::load)
}

/// What shades camera rays by integration.
pub fn direct<'a>(
    args: &Args,
    model: Model,
    sky: &Sky,
    surfaces: &'a Surfaces<'a>,
    backend: &'a dyn RayBackend,
    lights: &'a [Light],
    lamps: &'a Lamps,
) -> Direct<'a> {
    Direct {
        model,
        rays: args.rays,
        sky: sky.light().clone(),
        background: args.background.map(|rgb| Vec3::from(rgb).as_dvec3()),
        lights,
        max_distance: args.max_distance.map_or(f32::INFINITY, |d| d as f32),
        seed: args.common.seed,
        overrides: overrides(args),
        ..Direct::new(surfaces, backend, lamps)
    }
}

/// What camera rays of a table-shaded picture meet.
pub fn subject<'a>(
    args: &Args,
    surfaces: &'a Surfaces<'a>,
    backend: &'a dyn RayBackend,
    shadings: &'a [Shading],
) -> Subject<'a> {
    Subject {
        surfaces,
        backend,
        overrides: overrides(args),
        shadings,
    }
}

pub fn overrides(args: &Args) -> Overrides {
    Overrides {
        albedo: args.albedo,
        specular: args.specular,
        exponent: args.exponent,
    }
}

/// The types of surfaces that are asked for, the first for all objects without one of their own, and how each instance
/// is shaded.
///
/// # Errors
/// A name that no object has, or a type whose tables are not given.
pub fn surface_types(
    tables: &Tables,
    scene: &Scene,
) -> anyhow::Result<(Vec<SurfaceType>, Vec<Shading>)> {
    let mut types = vec![surface_type(
        tables,
        tables.shader.unwrap_or(ShaderName::Phong),
    )];
    let shading = |types: &[SurfaceType], number: usize| Shading {
        shader: number as u32,
        traced: types[number] == SurfaceType::Traced,
    };
    let mut shadings = vec![shading(&types, 0); scene.instances.len()];
    for (pattern, name) in &tables.shader_of {
        let surface = surface_type(tables, *name);
        let [maps, environment] = lacks(tables, surface);
        if maps || environment {
            let flag = if maps { "--maps" } else { "--environment" };
            bail!("--shader-of {pattern}: such a surface shows tables that {flag} names; give it");
        }
        let known = types.iter().position(|known| *known == surface);
        let number = known.unwrap_or(types.len());
        if known.is_none() {
            types.push(surface);
        }
        for instance in atlas::instances_named(scene, pattern, "--shader-of")? {
            shadings[instance as usize] = shading(&types, number);
        }
    }
    Ok((types, shadings))
}

/// Whether a surface needs D and S, or I, that are not given.
fn lacks(tables: &Tables, surface: SurfaceType) -> [bool; 2] {
    let needs = match surface {
        SurfaceType::Phong | SurfaceType::Retro => [true, false],
        SurfaceType::Varnish => [true, true],
        _ => [false, true],
    };
    let given = [tables.maps.is_some(), tables.environment.is_some()];
    [0, 1].map(|k| needs[k] && !given[k])
}

pub fn surface_type(tables: &Tables, name: ShaderName) -> SurfaceType {
    match name {
        ShaderName::Phong => SurfaceType::Phong,
        ShaderName::Mirror => SurfaceType::Mirror,
        ShaderName::Varnish => SurfaceType::Varnish,
        ShaderName::Retro => SurfaceType::Retro,
        ShaderName::Refraction => SurfaceType::Refraction(tables.ior),
        ShaderName::Luminous => SurfaceType::Luminous,
        ShaderName::Traced => SurfaceType::Traced,
    }
}

/// What weighs the highlights of lights by their incidence.
///
/// # Errors
/// There is nothing to weigh, or its file cannot be read.
pub fn incidence(args: &Args, model: Model) -> anyhow::Result<Weight> {
    let [_, weight] = weights(&args.tables)?;
    let serves = model == Model::Phong && !args.shining.is_dark();
    if weight != Weight::Constant && !serves {
        bail!("--specular-weight: without --maps it weighs lights under --model phong; give both");
    }
    Ok(weight)
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

/// How progress is shown, counted in `unit`.
pub fn show(args: &Args, unit: &'static str) -> Show {
    Show {
        unit,
        quiet: args.common.quiet,
    }
}
