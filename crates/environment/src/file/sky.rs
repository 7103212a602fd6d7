//! The file of an illumination map as a sky.

use super::image_file::ImageFile;
use super::picture::{bytes, decode};
use crate::{Error, IlluminationMap, MapLayout, Orientation, Projection, SkyMap, convert_image};
use std::path::Path;

/// A sky with what identifies it.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyFile {
    /// BLAKE3 hash of the file's bytes, 64 hexadecimal digits.
    pub hash: String,
    /// What it shows.
    pub map: SkyMap,
}

/// The sky in the picture at `path`, of any format that [`crate::read`] reads and in the layout that its header says,
/// else polar. A picture that is not polar is converted with as many texels about the equator, its energy kept. The
/// file is read once.
///
/// ```
/// use ambake_environment::{Format, Image, Labels, encode, read_sky};
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("dusk.hdr");
/// let dusk = Image::filled(64, 32, [1.0, 0.5, 0.25]);
/// std::fs::write(&path, encode(&dusk, Format::Hdr, &Labels::new())?)?;
/// let sky = read_sky(&path)?;
/// assert_eq!(sky.map.size(), (64, 32));
/// assert_eq!(sky.map.mean(), [1.0, 0.5, 0.25]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`Error::Read`] and [`Error::Pixel`] as [`crate::read`], [`Error::Header`] and [`Error::Layout`] as
/// [`ImageFile::layout`].
pub fn read_sky(path: &Path) -> Result<SkyFile, Error> {
    let bytes = bytes(path)?;
    let file = decode(path, &bytes)?;
    file.image.check(path)?;
    let from = file.layout(path, None, None)?;
    let texels = from.projection.texels(from.size);
    let polar = MapLayout {
        projection: Projection::Polar,
        orientation: Orientation::Ambake,
        size: (texels, texels / 2),
    };
    let ImageFile { image, .. } = file;
    let image = convert_image(&image, from, polar)?;
    let map = IlluminationMap::new(image, Projection::Polar)?;
    Ok(SkyFile {
        hash: blake3::hash(&bytes).to_hex().to_string(),
        map: SkyMap::new(&map)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Format, Image, Labels, encode};

    /// A file of a picture with its header.
    fn write(path: &Path, image: &Image, labels: &[(&str, &str)]) -> Vec<u8> {
        let label = |(name, word): &(&str, &str)| (name.to_string(), word.to_string());
        let labels: Labels = labels.iter().map(label).collect();
        let bytes = encode(image, Format::Exr, &labels).unwrap();
        std::fs::write(path, &bytes).unwrap();
        bytes
    }

    #[test]
    fn a_cross_becomes_a_polar_sky_of_its_mean_and_is_named_by_its_own_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("room.exr");
        let mut image = Image::filled(32, 24, [0.0; 3]);
        for j in 0..24 {
            for i in 0..32 {
                image.pixels[32 * j + i] = [(i + j) as f32, 1.0, 0.5];
            }
        }
        let bytes = write(&path, &image, &[("ambakeProjection", "cross")]);
        let sky = read_sky(&path).unwrap();
        assert_eq!(sky.map.size(), (32, 16));
        assert_eq!(sky.hash, blake3::hash(&bytes).to_hex().as_str());
        let cross = IlluminationMap::new(image, Projection::Cross).unwrap();
        for (mean, integral) in sky.map.mean().iter().zip(cross.integral()) {
            let exact = integral / ambient::convention::SPHERE;
            // Texels are f32, each rounded by at most 6e-8.
            assert!((mean / exact - 1.0).abs() < 1e-7, "{mean} for {exact}");
        }
    }

    #[test]
    fn a_header_of_an_unknown_projection_or_a_negative_texel_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("room.exr");
        let mut image = Image::filled(8, 4, [1.0; 3]);
        write(&path, &image, &[("ambakeProjection", "mercator")]);
        let error = read_sky(&path).unwrap_err();
        assert!(matches!(error, Error::Header { .. }), "{error}");
        image.pixels[9] = [1.0, -2.0, 1.0];
        write(&path, &image, &[]);
        let error = read_sky(&path).unwrap_err();
        assert!(matches!(error, Error::Pixel { x: 1, y: 1, .. }), "{error}");
    }
}
