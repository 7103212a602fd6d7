//! How other tools place directions in their pictures.
//!
//! Directions are ambake's (glTF's): right-handed, +y up. An orientation says at which direction of ambake's own picture a
//! tool looks for a direction. All are signed exchanges of axes, so texels keep their solid angles.

use crate::{Direction, Error, Image, Projection};

/// Whose pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// ambake: polar with +z in the middle and +x to its right; cube faces as OpenGL's.
    Ambake,
    /// glTF viewers and the image-based light extension: polar with +x in the middle and +z to its right; cube as OpenGL's.
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

/// Every orientation with its name.
const NAMES: [(Orientation, &str); 6] = [
    (Orientation::Ambake, "ambake"),
    (Orientation::Gltf, "gltf"),
    (Orientation::Three, "three.js"),
    (Orientation::Blender, "blender"),
    (Orientation::Filament, "filament"),
    (Orientation::OpenExr, "openexr"),
];

impl Orientation {
    /// Its name on the command line and in file headers.
    pub fn name(self) -> &'static str {
        NAMES[self as usize].1
    }

    /// The orientation of this name.
    pub fn from_name(name: &str) -> Option<Orientation> {
        let found = NAMES.into_iter().find(|(_, other)| *other == name);
        found.map(|(orientation, _)| orientation)
    }

    /// Every orientation.
    pub fn all() -> impl Iterator<Item = Orientation> {
        NAMES.into_iter().map(|(orientation, _)| orientation)
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

    /// Exchanges the last two faces where the tool stores them the other way round: OpenEXR's picture of +z is ambake's of
    /// -z with z reversed. Twice is nothing.
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
