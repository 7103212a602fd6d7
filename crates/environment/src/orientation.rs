//! How other tools place directions in their pictures.
//!
//! Directions are ambake's (glTF's): right-handed, +y up. An orientation says at which direction of ambake's own
//! picture a tool looks for a direction. All are signed exchanges of axes, so texels keep their solid angles.

use crate::{Direction, Error, Image, Projection};

/// Whose pictures.
///
/// ```
/// use ambake_environment::{Orientation, Projection};
/// // Blender looks for glTF's +x in the middle of a polar picture, where ambake has +z.
/// let found = Orientation::Blender.look_up(Projection::Polar, [1.0, 0.0, 0.0]);
/// assert_eq!(found, [0.0, 0.0, 1.0]);
/// assert!(Orientation::Blender.check(Projection::Cube).is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// ambake: polar with +z in the middle and +x to its right; cube faces as OpenGL's.
    Ambake,
    /// glTF viewers and the image-based light extension: polar with +x in the middle and +z to its right; cube as
    /// OpenGL's.
    Gltf,
    /// three.js: polar as glTF; cube textures are looked up with x reversed.
    Three,
    /// Blender's world texture: +X in the middle, -Y to its right, Z up in Blender, where -Y is glTF's +z and Z its +y.
    Blender,
    /// Input of Filament's cmgen, which mirrors what it reads: x reversed.
    Filament,
    /// OpenEXR's environment maps: polar with +z in the middle and +x to its left; faces as seen from inside.
    OpenExr,
}

impl Orientation {
    /// Every orientation with its name.
    pub(crate) const NAMES: [(Orientation, &str); 6] = [
        (Orientation::Ambake, "ambake"),
        (Orientation::Gltf, "gltf"),
        (Orientation::Three, "three.js"),
        (Orientation::Blender, "blender"),
        (Orientation::Filament, "filament"),
        (Orientation::OpenExr, "openexr"),
    ];

    /// Its name on the command line and in file headers.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].1
    }

    /// The orientation of this name.
    pub fn from_name(name: &str) -> Option<Orientation> {
        let found = Self::NAMES.into_iter().find(|(_, other)| *other == name);
        found.map(|(orientation, _)| orientation)
    }

    /// Every orientation.
    pub fn all() -> impl Iterator<Item = Orientation> {
        Self::NAMES.into_iter().map(|(orientation, _)| orientation)
    }

    /// # Errors
    /// [`Error::Shape`] where the tool has no pictures of this projection.
    pub fn check(self, projection: Projection) -> Result<(), Error> {
        let known = match projection {
            Projection::Polar => true,
            Projection::Cube | Projection::Strip => self != Orientation::Blender,
            Projection::Cross => !matches!(self, Orientation::Blender | Orientation::OpenExr),
            _ => self == Orientation::Ambake,
        };
        if known {
            return Ok(());
        }
        Err(Error::Shape(format!(
            "{} has no {} maps; choose another orientation or projection",
            self.name(),
            projection.name()
        )))
    }

    /// Where in ambake's picture of this projection the tool looks for a direction. The map is its own inverse.
    pub fn look_up(self, projection: Projection, [x, y, z]: Direction) -> Direction {
        let polar = projection == Projection::Polar;
        match self {
            Orientation::Ambake => [x, y, z],
            Orientation::Gltf if !polar => [x, y, z],
            Orientation::Gltf | Orientation::Blender => [z, y, x],
            Orientation::Three if polar => [z, y, x],
            Orientation::Three | Orientation::Filament => [-x, y, z],
            Orientation::OpenExr if polar => [-x, y, z],
            Orientation::OpenExr => [x, y, -z],
        }
    }

    /// Exchanges the last two faces where the tool stores them the other way round: OpenEXR's picture of +z is ambake's
    /// of -z with z reversed. Twice is nothing.
    pub(crate) fn exchange_faces(self, projection: Projection, image: &mut Image) {
        if self != Orientation::OpenExr
            || !matches!(projection, Projection::Cube | Projection::Strip)
        {
            return;
        }
        let (width, height) = (image.width, image.height);
        let n = width.min(height);
        for j in 0..n {
            for i in 0..n {
                let at = |face: usize| match width > height {
                    true => j * width + face * n + i,
                    false => (face * n + j) * width + i,
                };
                image.pixels.swap(at(4), at(5));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::texel;
    use crate::{MapLayout, convert_image};
    use std::f64::consts::{PI, TAU};

    /// Where a tool's documentation puts a direction in its polar picture: right and down, 0..1.
    fn on_polar(tool: Orientation, [x, y, z]: Direction) -> (f64, f64) {
        let right = match tool {
            Orientation::Ambake => 0.5 + x.atan2(z) / TAU,
            // three.js, equirectUv; glTF-IBL-Sampler, dirToUV: atan(z, x) / 2π + 1/2.
            Orientation::Gltf | Orientation::Three => 0.5 + z.atan2(x) / TAU,
            // Cycles and EEVEE: 1/2 - atan(Y, X) / 2π; the glTF exporter makes Blender's Y to -z.
            Orientation::Blender => 0.5 - (-z).atan2(x) / TAU,
            // cmgen reads at atan2(x, z) with +z in the middle, then mirrors x unless it is told --no-mirror.
            Orientation::Filament => 0.5 + (-x).atan2(z) / TAU,
            // ImfEnvmap.h: longitude atan2(x, z) is +π at the left, -π at the right.
            Orientation::OpenExr => 0.5 - x.atan2(z) / TAU,
        };
        (right, y.acos() / PI)
    }

    /// The face, and right and down on it in -1..1.
    fn on_cube(tool: Orientation, [x, y, z]: Direction) -> (usize, f64, f64) {
        let openexr = tool == Orientation::OpenExr;
        // "Environment maps used in three.js appear to have px and nx swapped": CubeTexture; cmgen mirrors.
        let x = match tool {
            Orientation::Three | Orientation::Filament => -x,
            _ => x,
        };
        let largest = x.abs().max(y.abs()).max(z.abs());
        // OpenGL 4.6, table 8.19; or ImfEnvmap.cpp, pixelPosition.
        let (face, right, down) = match (x, y, z) {
            _ if x == largest => (0, if openexr { z } else { -z }, -y),
            _ if -x == largest => (1, if openexr { -z } else { z }, -y),
            _ if y == largest => (2, x, if openexr { -z } else { z }),
            _ if -y == largest => (3, x, if openexr { z } else { -z }),
            _ if z == largest => (4, if openexr { -x } else { x }, -y),
            _ => (5, if openexr { x } else { -x }, -y),
        };
        (face, right / largest, down / largest)
    }

    #[test]
    fn every_axis_lands_in_the_pixel_that_the_tool_documents() {
        let from = MapLayout {
            projection: Projection::Polar,
            orientation: Orientation::Ambake,
            size: (128, 64),
        };
        for tool in Orientation::all() {
            for (projection, size) in [(Projection::Polar, (32, 16)), (Projection::Cube, (8, 48))] {
                if tool.check(projection).is_err() {
                    continue;
                }
                let to = MapLayout {
                    projection,
                    orientation: tool,
                    size,
                };
                for axis in 0..6 {
                    // One axis, a little off so that mirror images and turns show.
                    let mut d = [0.3, 0.17, 0.21];
                    d[axis / 2] = if axis % 2 == 0 { 1.0 } else { -1.0 };
                    let at = texel(from.projection, from.size, d);
                    let (x, y) = ((at % 128) as f64 + 0.5, (at / 128) as f64 + 0.5);
                    let d = from.projection.direction(from.size, x, y).unwrap();
                    let mut image = Image::filled(128, 64, [0.0; 3]);
                    image.pixels[at] = [1.0; 3];
                    let picture = convert_image(&image, from, to).unwrap();
                    let (column, row) = match projection {
                        Projection::Polar => {
                            let (right, down) = on_polar(tool, d);
                            ((right * 32.0) as usize, (down * 16.0) as usize)
                        }
                        _ => {
                            let (face, right, down) = on_cube(tool, d);
                            let pixel = |v: f64| (4.0 * (v + 1.0)) as usize;
                            (pixel(right), 8 * face + pixel(down))
                        }
                    };
                    let brightest = (0..picture.pixels.len())
                        .max_by(|a, b| picture.pixels[*a][0].total_cmp(&picture.pixels[*b][0]));
                    assert_eq!(
                        brightest,
                        Some(row * size.0 + column),
                        "{tool:?} {projection:?} {d:?}"
                    );
                    // And back to where it came from, to within the coarser texel.
                    let back = convert_image(&picture, to, from).unwrap();
                    let at = (0..back.pixels.len())
                        .max_by(|a, b| back.pixels[*a][0].total_cmp(&back.pixels[*b][0]));
                    let (x, y) = (at.unwrap() % 128, at.unwrap() / 128);
                    let there =
                        from.projection
                            .direction(from.size, x as f64 + 0.5, y as f64 + 0.5);
                    let cosine = (0..3).map(|k| there.unwrap()[k] * d[k]).sum::<f64>();
                    assert!(
                        cosine > 0.25f64.cos(),
                        "{tool:?} {projection:?} {d:?}: {there:?}"
                    );
                }
            }
        }
    }
}
