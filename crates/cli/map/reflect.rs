//! `ambake map diffuse` and `map specular`: illumination maps convolved to reflection maps.

use super::args::{Common, Diffuse, DiffuseKernel, Input, Specular, SpecularKernel};
use super::file::{Source, Target, picture_size, summary, write};
use crate::common::parsed;
use crate::host;
use ambake::flags::values::Words;
use anyhow::{Context, bail};
use environment::{IlluminationMap, MapLayout, Orientation, Projection};
use maps::{Lobe, Normalise, Reflectance, ReflectionMap, Request};
use std::path::Path;

/// Runs `map diffuse`.
pub fn diffuse(args: &Diffuse) -> anyhow::Result<()> {
    let lobe = match args.kernel {
        DiffuseKernel::Lambert => Lobe::Lambert,
        DiffuseKernel::Luminous => Lobe::Luminous,
    };
    let target = (args.to, args.size);
    reflect(
        &args.input,
        &args.output,
        &Blur::Lobes(vec![(None, lobe)]),
        target,
        args.normalise,
        &args.common,
    )
}

/// Runs `map specular`.
pub fn specular(args: &Specular) -> anyhow::Result<()> {
    let (values, flag) = match args.kernel {
        SpecularKernel::Phong | SpecularKernel::Varnish => (&args.exponent, "--exponent"),
        SpecularKernel::Ggx => (&args.roughness, "--roughness"),
        _ => (&Vec::new(), ""),
    };
    if values.is_empty() && !flag.is_empty() {
        bail!("this kernel needs {flag}");
    }
    let lobe = |value: f64| match args.kernel {
        SpecularKernel::Varnish => Lobe::Varnish(value),
        SpecularKernel::Ggx => Lobe::Ggx(value),
        _ => Lobe::Phong(value),
    };
    let takes_table = matches!(
        args.kernel,
        SpecularKernel::Table | SpecularKernel::Reflectance
    );
    if args.table.is_some() && !takes_table {
        bail!("--table is for `--kernel table` and `--kernel reflectance`");
    }
    let blur = match (args.kernel, &args.table) {
        (SpecularKernel::Mirror, _) => Blur::Lobes(vec![(None, Lobe::Mirror)]),
        (SpecularKernel::Table, Some(path)) => {
            Blur::Lobes(vec![(None, parsed(path, Lobe::parse_table)?)])
        }
        (SpecularKernel::Reflectance, Some(path)) => {
            Blur::Reflectance(parsed(path, Reflectance::parse)?)
        }
        (SpecularKernel::Table | SpecularKernel::Reflectance, None) => {
            bail!("this kernel needs --table")
        }
        _ if values.len() == 1 => Blur::Lobes(vec![(None, lobe(values[0]))]),
        _ => {
            let lobes = values.iter().map(|v| (Some(v.to_string()), lobe(*v)));
            Blur::Lobes(lobes.collect())
        }
    };
    let target = (args.to, args.size);
    reflect(
        &args.input,
        &args.output,
        &blur,
        target,
        args.normalise,
        &args.common,
    )
}

/// What a map is blurred by.
enum Blur {
    /// One map a lobe, with what its file's name ends in.
    Lobes(Vec<(Option<String>, Lobe)>),
    /// One map an incidence.
    Reflectance(Reflectance),
}

impl Blur {
    /// The maps, with what their files' names end in.
    fn of(
        &self,
        map: &IlluminationMap,
        normalise: Normalise,
        (projection, size): (Projection, (usize, usize)),
    ) -> Result<Vec<(Option<String>, ReflectionMap)>, maps::Error> {
        match self {
            Blur::Lobes(lobes) => {
                let request = |lobe: &Lobe| Request {
                    lobe: lobe.clone(),
                    normalise,
                    projection,
                    size,
                };
                let requests: Vec<Request> = lobes.iter().map(|(_, lobe)| request(lobe)).collect();
                let suffixes = lobes.iter().map(|(suffix, _)| suffix.clone());
                Ok(suffixes.zip(maps::convolve(map, &requests)?).collect())
            }
            Blur::Reflectance(table) => {
                let maps = table.convolve(map, normalise, projection, size)?;
                let suffixes = table.incidences().into_iter().map(|a| Some(a.to_string()));
                Ok(suffixes.zip(maps).collect())
            }
        }
    }
}

/// Convolves and writes.
fn reflect(
    input: &Input,
    output: &Path,
    blur: &Blur,
    (projection, size): (Projection, [u32; 2]),
    normalise: Normalise,
    common: &Common,
) -> anyhow::Result<()> {
    host::set_threads(common.threads)?;
    if let Blur::Lobes(lobes) = blur {
        for (_, lobe) in lobes {
            lobe.check()?;
        }
    }
    let size = picture_size(projection, size);
    projection.check(size.0, size.1)?;
    let source = Source::read(input)?;
    let named = || input.input.display().to_string();
    // Reflection maps are written in ambake's own axes.
    let own = MapLayout {
        orientation: Orientation::Ambake,
        ..source.layout
    };
    let image =
        environment::convert_image(&source.image, source.layout, own).with_context(named)?;
    let map = IlluminationMap::new(image, own.projection).with_context(named)?;
    let results = blur
        .of(&map, normalise, (projection, size))
        .with_context(named)?;
    let images: Vec<_> = results
        .iter()
        .map(|(suffix, map)| (suffix.clone(), map.image()))
        .collect();
    let to = MapLayout {
        projection,
        orientation: Orientation::Ambake,
        size,
    };
    let target = Target {
        path: output,
        inputs: &source.inputs,
    };
    let written = write(&target, &images, to, normalise.word())?;
    summary(common, &input.input, &source, &written)
}
