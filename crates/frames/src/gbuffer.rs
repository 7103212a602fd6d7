//! What a camera sees of an object, in memory: everything that shading needs and no light.

use crate::encoded::NormalCode;
use crate::surfel::{Mirrored, Reflected, Surfel};
use crate::table::LANES;
use glam::{DQuat, DVec3};
use layers::Progress;
use render::{Camera, Error, each};
use std::collections::HashMap;

/// How far the object is turned. The environment stays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// A point that stays.
    pub centre: DVec3,
    /// Unit axis.
    pub axis: DVec3,
    /// Radians, counter-clockwise seen from the tip of the axis.
    pub angle: f64,
}

/// What is taken.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// From where.
    pub camera: &'a Camera,
    /// With the object turned this far.
    pub turn: Turn,
    /// Rays of a pixel: a regular grid of `samples` by `samples`, at least 1. They find its coverage, and the mean
    /// normal, view and reflectances of one object.
    pub samples: u32,
    /// Also take the normals at the corners of pixels, which antialiased look-ups need.
    pub corners: bool,
}

/// The pixels that an object covers, row by row.
#[derive(Debug, Clone)]
pub struct GBuffer {
    pub(super) camera: Camera,
    /// First entry of each row, and the end of the last.
    pub(super) rows: Vec<usize>,
    pub(super) columns: Vec<u16>,
    pub(super) coverage: Vec<f32>,
    /// Unit normals and views, x, y and z apart; [`LANES`] more entries than pixels.
    pub(super) normal: [Vec<f32>; 3],
    pub(super) view: [Vec<f32>; 3],
    /// Index into `palette`; [`LANES`] more entries than pixels.
    pub(super) material: Vec<u32>,
    /// kd and ks; the fourth numbers are 0.
    pub(super) palette: Vec<[[f32; 4]; 2]>,
    /// Exponents of the same materials.
    pub(super) exponents: Vec<f64>,
    /// Numbers of their shaders.
    pub(super) shaders: Vec<u32>,
    /// What the rays mirrored by traced surfaces meet, in the order of the pixels.
    pub(super) mirrored: Vec<Glimpse>,
    /// Normals and views at the corners of pixels, rows of `width + 1`; normals are 0 where the object is not. Empty
    /// where they were not asked for.
    pub(super) corners: Vec<[[f32; 3]; 2]>,
    /// Objects at the corners and in the pixels.
    pub(super) corner_objects: Vec<u32>,
    pub(super) objects: Vec<u32>,
}

/// What one mirrored ray shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Glimpse {
    /// Number of the pixel among those of the buffer.
    pub pixel: u32,
    /// Share of the pixel's mirrored rays.
    pub share: f32,
    pub met: Mirrored,
}

/// A pixel on its way into the buffer.
pub(super) struct Pixel {
    pub column: u16,
    pub coverage: f32,
    pub normal: DVec3,
    pub view: DVec3,
    pub material: [[f32; 4]; 2],
    pub exponent: f64,
    pub object: u32,
    pub shader: u32,
    pub mirrored: Vec<Mirrored>,
}

impl GBuffer {
    /// What `hit` finds for rays from the eye in unit directions, both in the axes of the object before it was turned.
    /// `progress` hears of pixels.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    ///
    /// # Panics
    /// Where `view` has no samples.
    pub fn take(
        view: &View,
        progress: &dyn Progress,
        hit: impl Fn(DVec3, DVec3) -> Option<Surfel> + Sync,
    ) -> Result<GBuffer, Error> {
        assert!(view.samples > 0, "a pixel has samples");
        let [width, height] = view.camera.size;
        let turn = DQuat::from_axis_angle(view.turn.axis, view.turn.angle);
        let eye = turn.inverse() * (view.camera.eye - view.turn.centre) + view.turn.centre;
        let cast = |x: f64, y: f64| {
            let direction = view.camera.direction(x, y);
            let mut surfel = hit(eye, turn.inverse() * direction)?;
            surfel.mirrored = surfel.mirrored.map(|met| turned(met, turn));
            Some((surfel, turn * surfel.normal, -direction))
        };
        let cast = &cast;
        let row = |y: usize| -> Vec<Pixel> {
            (0..width)
                .filter_map(|x| pixel(x, y as u32, view.samples, cast))
                .collect()
        };
        let rows = each(height as usize, width as usize, progress, row)?;
        let corner = |at: usize| {
            let (x, y) = (at as u32 % (width + 1), at as u32 / (width + 1));
            let (surfel, normal, view) = cast(f64::from(x), f64::from(y)).unwrap_or_default();
            (
                [normal, view].map(|v| v.as_vec3().to_array()),
                surfel.object,
            )
        };
        let count = match view.corners {
            true => (width as usize + 1) * (height as usize + 1),
            false => 0,
        };
        let (corners, corner_objects) = each(count, 0, progress, corner)?.into_iter().unzip();
        let mut buffer = GBuffer {
            corners,
            corner_objects,
            ..GBuffer::empty(*view.camera)
        };
        buffer.fill(rows);
        Ok(buffer)
    }

    /// One without pixels.
    pub(super) fn empty(camera: Camera) -> GBuffer {
        GBuffer {
            camera,
            rows: vec![0],
            columns: Vec::new(),
            coverage: Vec::new(),
            normal: Default::default(),
            view: Default::default(),
            material: Vec::new(),
            palette: Vec::new(),
            exponents: Vec::new(),
            shaders: Vec::new(),
            mirrored: Vec::new(),
            corners: Vec::new(),
            corner_objects: Vec::new(),
            objects: Vec::new(),
        }
    }

    /// Takes the pixels in, row by row from the top.
    pub(super) fn fill(&mut self, rows: Vec<Vec<Pixel>>) {
        let mut known = HashMap::new();
        for row in rows {
            for pixel in row {
                let share = 1.0 / pixel.mirrored.len() as f32;
                let number = self.columns.len() as u32;
                let glimpses = pixel.mirrored.iter().map(|met| Glimpse {
                    pixel: number,
                    share,
                    met: *met,
                });
                self.mirrored.extend(glimpses);
                self.columns.push(pixel.column);
                self.coverage.push(pixel.coverage);
                self.objects.push(pixel.object);
                let (normal, view) = (pixel.normal.as_vec3(), pixel.view.as_vec3());
                for c in 0..3 {
                    self.normal[c].push(normal[c]);
                    self.view[c].push(view[c]);
                }
                let bits = pixel.material.map(|rgb| rgb.map(f32::to_bits));
                let next = self.palette.len() as u32;
                let key = (bits, pixel.exponent.to_bits(), pixel.shader);
                let index = *known.entry(key).or_insert(next);
                if index == next {
                    self.palette.push(pixel.material);
                    self.exponents.push(pixel.exponent);
                    self.shaders.push(pixel.shader);
                }
                self.material.push(index);
            }
            self.rows.push(self.columns.len());
        }
        let padded = self.columns.len() + LANES;
        for c in 0..3 {
            self.normal[c].resize(padded, 0.0);
            self.view[c].resize(padded, 0.0);
        }
        self.material.resize(padded, 0);
    }

    /// Pixels that show some of the object.
    pub fn pixels(&self) -> usize {
        self.columns.len()
    }

    /// Their shares that the object covers, above 0 up to 1, in the order of [`GBuffer::places`].
    pub fn coverage(&self) -> &[f32] {
        &self.coverage
    }

    /// Where they are: `y * width + x`, ascending.
    pub fn places(&self) -> impl Iterator<Item = usize> {
        let width = self.camera.size[0] as usize;
        (0..self.rows.len() - 1).flat_map(move |y| {
            self.columns[self.rows[y]..self.rows[y + 1]]
                .iter()
                .map(move |x| y * width + usize::from(*x))
        })
    }

    /// The buffer as a display of this code holds it: every normal is encoded and decoded.
    pub fn encode(&mut self, code: NormalCode) {
        let axes = [self.camera.right, self.camera.up, -self.camera.forward];
        let stored = |normal: [f32; 3]| {
            let normal = DVec3::from_array(normal.map(f64::from));
            code.decode(code.encode(normal, axes), axes)
                .as_vec3()
                .to_array()
        };
        for k in 0..self.columns.len() {
            let normal = stored([0, 1, 2].map(|c: usize| self.normal[c][k]));
            (0..3).for_each(|c| self.normal[c][k] = normal[c]);
        }
        for [normal, _] in self.corners.iter_mut().filter(|[n, _]| *n != [0.0; 3]) {
            *normal = stored(*normal);
        }
    }
}

/// What a mirrored ray meets, with its object turned.
fn turned(met: Mirrored, turn: DQuat) -> Mirrored {
    match met {
        Mirrored::Environment(direction) => Mirrored::Environment(turn * direction),
        Mirrored::Surface(surface) => Mirrored::Surface(Reflected {
            normal: turn * surface.normal,
            view: turn * surface.view,
            ..surface
        }),
    }
}

/// The mean over the samples of a pixel that meet the object of the first that meets any.
fn pixel(
    x: u32,
    y: u32,
    samples: u32,
    cast: impl Fn(f64, f64) -> Option<(Surfel, DVec3, DVec3)>,
) -> Option<Pixel> {
    let (mut covered, mut count) = (0u32, 0u32);
    let mut first = None;
    let mut sum = [DVec3::ZERO; 4];
    let mut exponents = 0.0;
    let mut mirrored = Vec::new();
    for number in 0..samples * samples {
        let place =
            |at: u32, step: u32| f64::from(at) + (f64::from(step) + 0.5) / f64::from(samples);
        let found = cast(place(x, number % samples), place(y, number / samples));
        if let Some((surfel, normal, view)) = found {
            covered += 1;
            let (_, object, _) = *first.get_or_insert((normal, surfel.object, surfel.shader));
            if object != surfel.object {
                continue;
            }
            count += 1;
            mirrored.extend(surfel.mirrored);
            let values = [normal, view, surfel.albedo, surfel.specular];
            (0..4).for_each(|k| sum[k] += values[k]);
            // As lobes are interpolated.
            exponents += surfel.exponent.ln_1p();
        }
    }
    let (first, object, shader) = first?;
    let [normal, view, albedo, specular] = sum.map(|sum| sum / f64::from(count));
    Some(Pixel {
        column: x as u16,
        coverage: (f64::from(covered) / f64::from(samples * samples)) as f32,
        // Normals that cancel each other leave the first.
        normal: normal.try_normalize().unwrap_or(first),
        object,
        shader,
        mirrored,
        exponent: (exponents / f64::from(count)).exp_m1(),
        view: view.try_normalize()?,
        material: [albedo, specular].map(|rgb| rgb.as_vec3().extend(0.0).to_array()),
    })
}
