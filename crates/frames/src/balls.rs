//! One body in six materials in one environment: mirror, glossy, diffuse, varnished, retro-reflective, refracting.

use crate::Error;
use crate::{GBuffer, Index, Lookup, Shader, Surfel, Table, Turn, View, backdrop};
use environment::{IlluminationMap, Image, Projection};
use glam::DVec3;
use layers::Progress;
use maps::{Lobe, Normalise, Request};
use render::{Camera, Part};

/// The tables that the six materials need.
#[derive(Debug)]
pub struct Balls {
    diffuse: Table,
    specular: Table,
    environment: Table,
}

/// Exponent of the lobe of the second material.
const EXPONENT: f64 = 100.0;

/// Refractive index of the refracting body.
const GLASS: f32 = 1.5;

impl Balls {
    /// The names of the materials, row by row.
    pub const NAMES: [&'static str; 6] = [
        "mirror",
        "glossy",
        "diffuse",
        "varnished",
        "retro-reflective",
        "refracting",
    ];

    /// Tables of an environment, which is a polar map.
    ///
    /// # Errors
    /// [`environment::Error::Shape`] for another projection.
    pub fn of(environment: &IlluminationMap) -> Result<Balls, Error> {
        let table = Table::new(environment)?;
        let request = |lobe, size| Request {
            lobe,
            normalise: Normalise::Radiance,
            projection: Projection::Polar,
            size,
        };
        let requests = [
            request(Lobe::Lambert, (72, 36)),
            request(Lobe::Phong(EXPONENT), (512, 256)),
        ];
        let maps = maps::convolve(environment, &requests)?;
        Ok(Balls {
            diffuse: Table::new(&maps[0])?,
            specular: Table::new(&maps[1])?,
            environment: table,
        })
    }

    /// Shader and reflectances kd and ks of each material.
    fn materials(&self) -> [(Shader<'_>, DVec3, DVec3); 6] {
        let (d, s, i) = (
            Some(&self.diffuse),
            Some(&self.specular),
            Some(&self.environment),
        );
        let indexed = |index, specular| Shader {
            index,
            ..Shader::of(None, specular)
        };
        let varnished = Shader {
            coat: i,
            ..Shader::of(d, None)
        };
        let grey = DVec3::splat;
        [
            (Shader::of(None, i), grey(0.0), grey(1.0)),
            (Shader::of(None, s), grey(0.0), grey(1.0)),
            (Shader::of(d, None), grey(0.5), grey(0.0)),
            (varnished, DVec3::new(0.5, 0.12, 0.04), grey(0.0)),
            (indexed(Index::Retro, s), grey(0.0), grey(0.5)),
            (
                indexed(Index::Refraction(1.0 / GLASS), i),
                grey(0.0),
                grey(1.0),
            ),
        ]
    }

    /// Width and height of one of the six pictures in a sheet of this size.
    pub fn picture_size([width, height]: [u32; 2]) -> [u32; 2] {
        [(width / 3).max(1), (height / 2).max(1)]
    }

    /// Three columns and two rows of pictures by `camera`, before the environment. `progress` hears of pixels.
    ///
    /// # Errors
    /// [`render::Error::Cancelled`].
    pub fn sheet(
        &self,
        camera: &Camera,
        samples: u32,
        lookup: Lookup,
        progress: &dyn Progress,
        hit: impl Fn(DVec3, DVec3) -> Option<Surfel> + Sync,
    ) -> Result<Image, render::Error> {
        let [width, height] = camera.size.map(|n| n as usize);
        let behind = backdrop(camera, Some(&self.environment));
        let mut sheet = Image::filled(3 * width, 2 * height, [0.0; 3]);
        let turn = Turn {
            centre: DVec3::ZERO,
            axis: DVec3::Y,
            angle: 0.0,
        };
        let view = View {
            camera,
            turn,
            samples,
            corners: lookup.needs_corners(),
        };
        for (number, (shader, albedo, specular)) in self.materials().iter().enumerate() {
            let part = Part {
                whole: progress,
                index: number as u64,
                count: Balls::NAMES.len() as u64,
            };
            let buffer = GBuffer::take(&view, &part, |eye, direction| {
                let surfel = hit(eye, direction)?;
                Some(Surfel {
                    albedo: *albedo,
                    specular: *specular,
                    ..surfel
                })
            })?;
            let mut picture = behind.clone();
            shader.frame(&buffer, lookup, &mut picture);
            let (left, top) = (number % 3 * width, number / 3 * height);
            for (y, row) in picture.pixels.chunks_exact(width).enumerate() {
                let start = (top + y) * sheet.width + left;
                sheet.pixels[start..start + width].copy_from_slice(row);
            }
        }
        Ok(sheet)
    }
}
