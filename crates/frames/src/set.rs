//! The tables of a picture, read from their files, and what each type of surface looks up in them.

use crate::Error;
use crate::index::Index;
use crate::shader::Shader;
use crate::table::Table;
use environment::Projection;
use maps::{Lobe, Normalise, PolarFile, Request};
use render::Weight;
use std::path::{Path, PathBuf};

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
    /// Ws ks times what the mirrored ray meets in the scene, shaded from its own tables; I(R) where it meets nothing.
    Traced,
}

/// The tables that are there.
#[derive(Debug, Default)]
pub struct TableSet {
    /// D.
    pub diffuse: Option<Table>,
    /// S.
    pub specular: Option<Table>,
    /// S for several exponents, ascending, each with a table for every one of `incidences`.
    pub glosses: Vec<(f64, Vec<Table>)>,
    /// Incidences of the view in degrees, descending; empty for one table at all.
    pub incidences: Vec<f64>,
    /// I.
    pub environment: Option<Table>,
    /// The mean of I, in every direction.
    pub mean: Option<Table>,
    /// By what the header of D or S says it is normalised.
    pub normalisation: Option<String>,
}

impl TableSet {
    /// The tables in the files of D and S and of I, which are polar maps, for surfaces of these types.
    ///
    /// * `glosses`: exponents, and incidences in degrees. S stands for the files of [`specular_files`].
    ///
    /// # Errors
    /// A file cannot be read or is not polar; or D and S differ in their normalisation, or two incidences have one
    /// cosine in 32 bits ([`Error::Tables`]).
    pub fn read(
        surfaces: &[SurfaceType],
        maps: Option<[&Path; 2]>,
        glosses: [&[f64]; 2],
        environment: Option<&Path>,
    ) -> Result<TableSet, Error> {
        let mut set = TableSet::default();
        let [exponents, incidences] = glosses.map(|numbers| {
            let mut sorted = numbers.to_vec();
            sorted.sort_by(f64::total_cmp);
            sorted.dedup();
            sorted
        });
        if let Some(pair) = incidences.windows(2).find(|p| cosine(p[0]) == cosine(p[1])) {
            return Err(Error::Tables(format!(
                "the incidences {} and {} are too close to read between; leave one out",
                pair[0], pair[1]
            )));
        }
        set.incidences = incidences;
        set.incidences.reverse();
        if let Some(paths) = maps {
            let d = maps::read_polar(paths[0])?;
            set.diffuse = Some(Table::new(&d.map)?);
            let mut read = |path: &Path| -> Result<Table, Error> {
                let s = maps::read_polar(path)?;
                check_normalisation([paths[0], path], [&d, &s])?;
                let own = d.normalisation.clone();
                set.normalisation = own.or(s.normalisation);
                Ok(Table::new(&s.map)?)
            };
            let files = specular_files(paths[1], &exponents, &set.incidences);
            for (number, files) in files.iter().enumerate() {
                let tables: Result<Vec<Table>, Error> =
                    files.iter().map(|file| read(file)).collect();
                // Without exponents one gloss stands for every material.
                let exponent = exponents.get(number).copied().unwrap_or_default();
                set.glosses.push((exponent, tables?));
            }
        }
        if exponents.is_empty() && set.incidences.is_empty() {
            set.specular = set.glosses.pop().and_then(|(_, mut tables)| tables.pop());
        }
        if let Some(path) = environment {
            let environment = maps::read_polar(path)?.map;
            set.environment = Some(Table::new(&environment)?);
            if surfaces.contains(&SurfaceType::Luminous) {
                let mean = Request {
                    lobe: Lobe::Luminous,
                    normalise: Normalise::Radiance,
                    projection: Projection::Polar,
                    size: (2, 1),
                };
                let mean = maps::convolve(&environment, &[mean])?;
                set.mean = Some(Table::new(&mean[0])?);
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
            SurfaceType::Mirror | SurfaceType::Refraction(_) | SurfaceType::Traced => {
                (None, i, None)
            }
            SurfaceType::Luminous => (self.mean.as_ref(), None, None),
        };
        let glossy = matches!(
            surface,
            SurfaceType::Phong | SurfaceType::Retro | SurfaceType::Varnish
        );
        let glosses = self.glosses.iter().filter(|_| glossy);
        Shader {
            glosses: glosses
                .map(|(n, tables)| (*n, tables.iter().collect()))
                .collect(),
            incidences: self.incidences.iter().map(|a| cosine(*a)).collect(),
            diffuse,
            translucency: 0.0,
            specular,
            index: match surface {
                SurfaceType::Retro => Index::Retro,
                SurfaceType::Traced => Index::Traced,
                SurfaceType::Refraction(ior) => Index::Refraction((1.0 / ior) as f32),
                _ => Index::Mirror,
            },
            coat,
            diffuse_weight: wd,
            specular_weight: ws,
        }
    }
}

/// The files that S stands for, a list for each exponent: `S_16.exr` of `S.exr` for the exponent 16 or the incidence
/// 16, as `ambake map specular` names them, and `S_16_60.exr` for an exponent and an incidence. One list with S itself
/// where there are neither.
pub fn specular_files(path: &Path, exponents: &[f64], incidences: &[f64]) -> Vec<Vec<PathBuf>> {
    let each = |path: &Path, numbers: &[f64]| match numbers {
        [] => vec![path.to_owned()],
        _ => numbers.iter().map(|n| numbered(path, *n)).collect(),
    };
    let glosses = each(path, exponents);
    glosses.iter().map(|path| each(path, incidences)).collect()
}

fn numbered(path: &Path, number: f64) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{number}.{ending}"))
}

fn cosine(degrees: f64) -> f32 {
    degrees.to_radians().cos() as f32
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
