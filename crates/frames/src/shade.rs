//! Pictures from tables: a buffer shaded row by row, and what stands behind it.

use crate::antialias::Lookup;
use crate::gbuffer::GBuffer;
use crate::row::Row;
use crate::shader::Shader;
use crate::table::Table;
use environment::Image;
use pulp::Arch;
use rayon::prelude::*;
use render::Camera;

impl Shader<'_> {
    /// Shades the pixels of `buffer` over what `picture` holds behind them.
    ///
    /// # Panics
    /// Where the picture has another size, or an antialiased look-up meets a buffer without corners.
    pub fn frame(&self, buffer: &GBuffer, lookup: Lookup, picture: &mut Image) {
        frame(std::slice::from_ref(self), buffer, lookup, picture);
    }
}

/// Shades each pixel of `buffer` by the shader of its surface, over what `picture` holds behind it.
///
/// # Panics
/// Where the picture has another size, an antialiased look-up meets a buffer without corners, or a surface names a
/// shader that is not there.
pub fn frame(shaders: &[Shader<'_>], buffer: &GBuffer, lookup: Lookup, picture: &mut Image) {
    let [width, height] = buffer.camera.size.map(|n| n as usize);
    assert_eq!((picture.width, picture.height), (width, height));
    let cornered = !buffer.corners.is_empty();
    assert!(cornered || !lookup.needs_corners(), "no corners");
    let arch = Arch::new();
    let of = buffer.exponents.iter().zip(&buffer.shaders);
    let shares = of.map(|(exponent, number)| shaders[*number as usize].shares(*exponent));
    let shares: Vec<Vec<f32>> = shares.collect();
    let row = |(y, pixels): (usize, &mut [[f32; 3]])| {
        arch.dispatch(Row {
            shaders,
            buffer,
            lookup,
            shares: &shares,
            y,
            pixels,
        });
    };
    let rows = picture.pixels.par_chunks_exact_mut(width).enumerate();
    rows.with_min_len(8).for_each(row);
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
