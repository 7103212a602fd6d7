//! Normal maps of materials: kept as their files' bytes or as pixels, decoded only for a bake that bends normals.

#[cfg(feature = "files")]
use crate::image::Budget;
#[cfg(feature = "files")]
use crate::packed;
use crate::{Error, Image, Scene, TextureRef};
use glam::{Vec2, Vec3};
use std::path::PathBuf;

/// A normal map of a material (glTF `normalTexture`; MTL `norm`, `map_Bump`, `bump`).
#[derive(Debug, Clone)]
pub struct NormalMap {
    /// The use of the image; its number indexes [`Scene::packed_images`].
    pub texture: TextureRef,
    /// Multiplies the normal's components along the surface (glTF `scale`, MTL `-bm`); finite.
    pub scale: f32,
    /// A grey image holds heights, one unit for the edge of a pixel, rather than normals (MTL `map_Bump` and `bump`).
    pub heights: bool,
}

/// An image that waits for a bake that asks for it.
#[derive(Debug, Clone)]
pub struct PackedImage {
    /// Name for messages.
    pub name: String,
    /// What is there of it.
    pub content: Packed,
    /// The file that messages name.
    pub file: PathBuf,
}

/// What is there of an image that is not yet asked for.
#[derive(Debug, Clone)]
pub enum Packed {
    /// The bytes of its file, not decoded.
    #[cfg(feature = "files")]
    File(Vec<u8>),
    /// The pixels of an image that was handed over in memory.
    Pixels(Image),
}

impl PackedImage {
    /// The bytes that decide the image: those of its file or its pixels.
    pub fn bytes(&self) -> &[u8] {
        match &self.content {
            #[cfg(feature = "files")]
            Packed::File(bytes) => bytes,
            Packed::Pixels(image) => image.pixels.as_flattened(),
        }
    }
}

impl Scene {
    /// Judges by their headers whether the images of normal maps may be decoded together. The bound is that of the
    /// other pictures of a scene: 4 GiB, and 64 bytes for each byte of their files.
    ///
    /// * `images`: numbers of [`Scene::packed_images`], each once; others are passed over.
    ///
    /// # Errors
    /// They would take more; the error names the first that is too much.
    pub fn check_normal_images(
        &self,
        images: impl IntoIterator<Item = usize>,
    ) -> Result<(), Error> {
        let packed = images.into_iter().filter_map(|i| self.packed_images.get(i));
        #[cfg(feature = "files")]
        packed::check(packed, Budget::default())?;
        // What is in memory already is not counted.
        #[cfg(not(feature = "files"))]
        drop(packed);
        Ok(())
    }

    /// The image of a normal map, decoded: red, green and blue are the coded normals, also of a map of heights.
    ///
    /// # Errors
    /// The image is broken or in a format that is not read; the error names it.
    pub fn normal_image(&self, map: &NormalMap) -> Result<Image, Error> {
        let packed = &self.packed_images[map.texture.image as usize];
        let image = match &packed.content {
            #[cfg(feature = "files")]
            Packed::File(bytes) => packed::decoded(packed, bytes)?,
            Packed::Pixels(image) => image.clone(),
        };
        let grey = |p: &[u8; 4]| p[0] == p[1] && p[1] == p[2];
        if map.heights && image.pixels.iter().all(grey) {
            return Ok(from_heights(&image));
        }
        Ok(image)
    }
}

impl NormalMap {
    /// The unit normal at a mesh's UV in tangent space: x to the right of the image, y to its top, z off the surface.
    /// Codes are filtered as the texture asks, then decoded as the glTF specification says (section 3.9.3).
    ///
    /// * `image`: of [`Scene::normal_image`].
    pub fn normal(&self, image: &Image, uv: Vec2) -> Vec3 {
        let code = self.texture.data(image, uv);
        let along = Vec3::new(self.scale, self.scale, 1.0);
        ((code * 2.0 - 1.0) * along)
            .try_normalize()
            .unwrap_or(Vec3::Z)
    }
}

/// Normals of an image of heights 0..=1 that repeats, one unit for the edge of a pixel, by central differences.
fn from_heights(heights: &Image) -> Image {
    let (width, height) = (i64::from(heights.width), i64::from(heights.height));
    let at = |x: i64, y: i64| {
        let index = y.rem_euclid(height) * width + x.rem_euclid(width);
        f32::from(heights.pixels[index as usize][0]) / 255.0
    };
    let normal = |index: i64| {
        let (x, y) = (index % width, index / width);
        // Row 0 is on top.
        let right = 0.5 * (at(x + 1, y) - at(x - 1, y));
        let up = 0.5 * (at(x, y - 1) - at(x, y + 1));
        let code = Vec3::new(-right, -up, 1.0).normalize() * 127.5 + 127.5;
        let [r, g, b] = code.round().to_array().map(|c| c as u8);
        [r, g, b, 255]
    };
    Image {
        name: heights.name.clone(),
        width: heights.width,
        height: heights.height,
        pixels: (0..width * height).map(normal).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_of_heights_leans_against_its_rise() {
        // Rises to the right by 51/255 = 0.2 a pixel, in the middle of the picture.
        let pixels = (0..15u8).map(|i| [51 * (i % 5); 4]).collect();
        let image = Image {
            name: "ramp".into(),
            width: 5,
            height: 3,
            pixels,
        };
        let [r, g, b, _] = from_heights(&image).pixels[7];
        let expected = Vec3::new(-0.2, 0.0, 1.0).normalize();
        let found = Vec3::new(f32::from(r), f32::from(g), f32::from(b)) / 127.5 - 1.0;
        assert!((found - expected).length() < 0.01, "{found} for {expected}");
    }
}
