//! The tables of a picture, read from their files, and what each type of surface looks up in them.

use super::index::Index;
use super::shader::Shader;
use super::table::Table;
use super::weight::Weight;
use crate::Error;
use maps::{Lobe, Normalise, PolarFile, Projection, Request};
use std::path::Path;

/// What a surface does with the tables D, S and I.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SurfaceType {
    /// Wd kd D(N) + Ws ks S(R).
    Phong,
    /// Ws ks I(R).
    Mirror,
    /// As Phong, under a clear coat that adds half of I(R).
    Varnish,
    /// Wd kd D(N) + Ws ks S(E): light goes back where it comes from.
    Retro,
    /// Ws ks I(T), refracted at one surface of this refractive index.
    Refraction(f64),
    /// kd times the mean of I.
    Luminous,
}

/// The tables that are there.
#[derive(Debug, Default)]
pub struct TableSet {
    /// D.
    pub diffuse: Option<Table>,
    /// S.
    pub specular: Option<Table>,
    /// I.
    pub environment: Option<Table>,
    /// By what the header of D or S says it is normalised.
    pub normalisation: Option<String>,
}

impl TableSet {
    /// The tables in the files of D and S and of I, which are polar maps. A luminous surface gets the mean of I as its D.
    ///
    /// # Errors
    /// A file cannot be read or is not polar, or D and S differ in their normalisation ([`Error::Tables`]).
    pub fn read(
        surface: SurfaceType,
        maps: Option<[&Path; 2]>,
        environment: Option<&Path>,
    ) -> Result<TableSet, Error> {
        let mut set = TableSet::default();
        if let Some(paths) = maps {
            let [d, s] = paths.map(maps::read_polar);
            let (d, s) = (d?, s?);
            check_normalisation(paths, [&d, &s])?;
            set.diffuse = Some(Table::new(&d.map)?);
            set.specular = Some(Table::new(&s.map)?);
            set.normalisation = d.normalisation.or(s.normalisation);
        }
        if let Some(path) = environment {
            let environment = maps::read_polar(path)?.map;
            set.environment = Some(Table::new(&environment)?);
            if surface == SurfaceType::Luminous {
                let mean = Request {
                    lobe: Lobe::Luminous,
                    normalise: Normalise::Radiance,
                    projection: Projection::Polar,
                    size: (2, 1),
                };
                let mean = maps::convolve(&environment, &[mean])?;
                set.diffuse = Some(Table::new(&mean[0])?);
            }
        }
        Ok(set)
    }

    /// What shades a surface of this type with the weights Wd and Ws. Terms whose tables are absent are left out.
    pub fn shader(&self, surface: SurfaceType, [wd, ws]: [Weight; 2]) -> Shader<'_> {
        let (d, s) = (self.diffuse.as_ref(), self.specular.as_ref());
        let i = self.environment.as_ref();
        let (diffuse, specular, coat) = match surface {
            SurfaceType::Phong | SurfaceType::Retro => (d, s, None),
            SurfaceType::Varnish => (d, s, i),
            SurfaceType::Mirror | SurfaceType::Refraction(_) => (None, i, None),
            SurfaceType::Luminous => (d, None, None),
        };
        Shader {
            diffuse,
            specular,
            index: match surface {
                SurfaceType::Retro => Index::Retro,
                SurfaceType::Refraction(ior) => Index::Refraction((1.0 / ior) as f32),
                _ => Index::Mirror,
            },
            coat,
            diffuse_weight: wd,
            specular_weight: ws,
        }
    }
}

/// D and S add up only where both are normalised alike; maps of other tools do not say.
fn check_normalisation([d, s]: [&Path; 2], files: [&PolarFile; 2]) -> Result<(), Error> {
    match files.map(|file| file.normalisation.as_deref()) {
        [Some(of_d), Some(of_s)] if of_d != of_s => Err(Error::Tables(format!(
            "{} is normalised by `{of_d}`, {} by `{of_s}`; make both with one --normalise",
            d.display(),
            s.display()
        ))),
        _ => Ok(()),
    }
}
