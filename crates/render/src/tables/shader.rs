//! Line 9 of the 1984 algorithm for every pixel of a buffer.

use super::antialias::Lookup;
use super::gbuffer::GBuffer;
use super::index::{Index, combine, dot};
use super::table::{LANES, Lanes, Table};
use super::weight::Weight;
use crate::Camera;
use maps::Image;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// A surface type: which tables are looked up by which directions, and what each counts.
///
/// Radiance toward the eye is `Wd kd D[N] + Ws ks S[index] + ½ I[R]`, each term where its table is given. With tables in
/// radiance normalisation a constant environment of 1 gives `Wd kd + Ws ks + ½`. Self-luminous is a constant D.
#[derive(Debug, Clone)]
pub struct Shader<'a> {
    /// D, indexed by N.
    pub diffuse: Option<&'a Table>,
    /// S.
    pub specular: Option<&'a Table>,
    /// What indexes S.
    pub index: Index,
    /// I of a clear coat of varnish that mirrors half of what meets it, section 6.2 (3).
    pub coat: Option<&'a Table>,
    /// Wd.
    pub diffuse_weight: Weight,
    /// Ws.
    pub specular_weight: Weight,
}

/// Share that a coat of varnish mirrors.
const COAT: f32 = 0.5;

impl Shader<'_> {
    /// Radiance toward `view` of a point with reflectances `[kd, ks]`, by bilinear look-up. Unit vectors.
    pub fn point(&self, normal: [f32; 3], view: [f32; 3], material: [[f32; 3]; 2]) -> [f32; 3] {
        let read = |table: Option<&Table>, direction| {
            table.map_or([0.0; 3], |table| table.bilinear(direction))
        };
        let values = [
            read(self.diffuse, normal),
            read(self.specular, self.index.direction(normal, view)),
            read(self.coat, Index::Mirror.direction(normal, view)),
        ];
        self.compose(dot(normal, view), values, material)
    }

    /// Shades the pixels of `buffer` over what `picture` holds behind them.
    ///
    /// # Panics
    /// Where the picture has another size, or an antialiased look-up meets a buffer without corners.
    pub fn frame(&self, buffer: &GBuffer, lookup: Lookup, picture: &mut Image) {
        let [width, height] = buffer.camera.size.map(|n| n as usize);
        assert_eq!((picture.width, picture.height), (width, height));
        let antialiased = lookup.needs_corners();
        assert!(!antialiased || !buffer.corners.is_empty(), "no corners");
        let arch = Arch::new();
        let row = |(y, pixels): (usize, &mut [[f32; 3]])| {
            if antialiased {
                self.antialiased_row(buffer, lookup, y, pixels);
            } else {
                let nearest = lookup == Lookup::Nearest;
                arch.dispatch(Row {
                    shader: self,
                    buffer,
                    nearest,
                    y,
                    pixels,
                });
            }
        };
        let rows = picture.pixels.par_chunks_exact_mut(width).enumerate();
        rows.with_min_len(8).for_each(row);
    }

    fn antialiased_row(&self, buffer: &GBuffer, lookup: Lookup, y: usize, pixels: &mut [[f32; 3]]) {
        for k in buffer.rows[y]..buffer.rows[y + 1] {
            let x = usize::from(buffer.columns[k]);
            let corners = buffer.footprint(k, x, y);
            let read = |table: Option<&Table>, direction: &dyn Fn([[f32; 3]; 2]) -> [f32; 3]| {
                table.map_or([0.0; 3], |table| lookup.read(table, corners.map(direction)))
            };
            let values = [
                read(self.diffuse, &|[n, _]| n),
                read(self.specular, &|[n, e]| self.index.direction(n, e)),
                read(self.coat, &|[n, e]| Index::Mirror.direction(n, e)),
            ];
            let [n, e] = buffer.at(k);
            let material = buffer.palette[buffer.material[k] as usize];
            let color = self.compose(dot(n, e), values, material.map(|[r, g, b, _]| [r, g, b]));
            over(&mut pixels[x], color, buffer.coverage[k]);
        }
    }

    #[inline(always)]
    fn compose(&self, cosine: f32, values: [[f32; 3]; 3], [kd, ks]: [[f32; 3]; 2]) -> [f32; 3] {
        let [d, s, coat] = values;
        let wd = self.diffuse_weight.at(cosine);
        let ws = self.specular_weight.at(cosine);
        std::array::from_fn(|c| wd * kd[c] * d[c] + ws * ks[c] * s[c] + COAT * coat[c])
    }
}

/// The picture of an environment alone: bilinear at the middle of each pixel, or black without one.
pub fn backdrop(camera: &Camera, environment: Option<&Table>) -> Image {
    let [width, height] = camera.size.map(|n| n as usize);
    let mut picture = Image::filled(width, height, [0.0; 3]);
    if let Some(environment) = environment {
        let rows = picture.pixels.par_chunks_exact_mut(width).enumerate();
        rows.for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let direction = camera.direction(x as f64 + 0.5, y as f64 + 0.5);
                *pixel = environment.bilinear(direction.as_vec3().to_array());
            }
        });
    }
    picture
}

/// `color` over a pixel.
#[inline(always)]
fn over(pixel: &mut [f32; 3], color: [f32; 3], coverage: f32) {
    *pixel = if coverage == 1.0 {
        color
    } else {
        combine(coverage, color, 1.0 - coverage, *pixel)
    };
}

impl GBuffer {
    /// Normal and view of an entry.
    fn at(&self, k: usize) -> [[f32; 3]; 2] {
        [&self.normal, &self.view].map(|list| [0, 1, 2].map(|c: usize| list[c][k]))
    }

    /// Normals and views at the corners of an entry's pixel, in a turn. Where a corner misses the object, the pixel's own stand.
    fn footprint(&self, k: usize, x: usize, y: usize) -> [[[f32; 3]; 2]; 4] {
        let width = self.camera.size[0] as usize + 1;
        [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(|(x, y)| {
            let corner = self.corners[y * width + x];
            if corner[0] == [0.0; 3] {
                return self.at(k);
            }
            corner
        })
    }
}

/// One row of a picture, [`LANES`] pixels in step.
struct Row<'a, 'b> {
    shader: &'a Shader<'b>,
    buffer: &'a GBuffer,
    nearest: bool,
    y: usize,
    pixels: &'a mut [[f32; 3]],
}

impl NullaryFnOnce for Row<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Row {
            shader,
            buffer,
            nearest,
            y,
            pixels,
        } = self;
        let end = buffer.rows[y + 1];
        let mut start = buffer.rows[y];
        while start < end {
            let count = (end - start).min(LANES);
            block(shader, buffer, nearest, start..start + count, pixels);
            start += count;
        }
    }
}

#[inline(always)]
fn block(
    shader: &Shader,
    buffer: &GBuffer,
    nearest: bool,
    range: std::ops::Range<usize>,
    pixels: &mut [[f32; 3]],
) {
    let start = range.start;
    let load = |lists: &[Vec<f32>; 3]| -> [Lanes; 3] {
        std::array::from_fn(|c| {
            let mut lanes = [0.0; LANES];
            lanes.copy_from_slice(&lists[c][start..start + LANES]);
            lanes
        })
    };
    let (n, e) = (load(&buffer.normal), load(&buffer.view));
    let (mut wd, mut ws) = ([0.0; LANES], [0.0; LANES]);
    for k in 0..LANES {
        let cosine = n[0][k] * e[0][k] + n[1][k] * e[1][k] + n[2][k] * e[2][k];
        wd[k] = shader.diffuse_weight.at(cosine);
        ws[k] = shader.specular_weight.at(cosine);
    }
    let toward = |index: Index| {
        let mut toward = [[0.0; LANES]; 3];
        for k in 0..LANES {
            let found = index.direction([n[0][k], n[1][k], n[2][k]], [e[0][k], e[1][k], e[2][k]]);
            (0..3).for_each(|c| toward[c][k] = found[c]);
        }
        toward
    };
    // Weights times reflectances; `which` is 0 for kd and 1 for ks.
    let factors = |weights: &Lanes, which: usize| {
        let mut factors = [[0.0; 4]; LANES];
        for (k, material) in buffer.material[start..start + LANES].iter().enumerate() {
            let reflectance = buffer.palette[*material as usize][which];
            factors[k] = reflectance.map(|v| weights[k] * v);
        }
        factors
    };
    let mut sums = [[0.0; 4]; LANES];
    if let Some(table) = shader.diffuse {
        table.add(&n, nearest, &factors(&wd, 0), &mut sums);
    }
    if let Some(table) = shader.specular {
        table.add(&toward(shader.index), nearest, &factors(&ws, 1), &mut sums);
    }
    if let Some(table) = shader.coat {
        let mirrored = toward(Index::Mirror);
        table.add(&mirrored, nearest, &[[COAT; 4]; LANES], &mut sums);
    }
    for (at, [r, g, b, _]) in range.zip(sums) {
        let pixel = &mut pixels[usize::from(buffer.columns[at])];
        over(pixel, [r, g, b], buffer.coverage[at]);
    }
}
