//! Decodes what normal maps keep of their files, and pictures for whoever writes files of a scene.

use crate::image::{Budget, Failure, TOO_LARGE, decode};
use crate::input::short;
use crate::{Error, Image, Packed, PackedImage};

/// Counts the images that are files by what their headers declare.
pub(crate) fn check<'a>(
    images: impl Iterator<Item = &'a PackedImage>,
    mut budget: Budget,
) -> Result<(), Error> {
    for packed in images {
        if let Packed::File(bytes) = &packed.content {
            let taken = budget.take(bytes, &packed.name);
            taken.map_err(|problem| failed(packed, problem))?;
        }
    }
    Ok(())
}

/// The image in the bytes of a file.
pub(crate) fn decoded(packed: &PackedImage, bytes: &[u8]) -> Result<Image, Error> {
    let fail = |problem: String| failed(packed, problem);
    let pixels = decode(bytes, &packed.name).map_err(|failure| match failure {
        Failure::Unsupported(format) => fail(format!(
            "{format} is not read; convert it to PNG or leave out --normal-maps"
        )),
        Failure::Broken(problem) => fail(format!(
            "{}; repair the image or leave out --normal-maps",
            short(&problem)
        )),
        Failure::TooLarge => fail(TOO_LARGE.into()),
    })?;
    Ok(Image {
        name: packed.name.clone(),
        width: pixels.width,
        height: pixels.height,
        pixels: pixels.pixels,
    })
}

/// The picture in the bytes of a PNG, JPEG, WebP or BMP file; `None` for any other, for a broken one, and for one that
/// takes more than 1 GiB.
pub fn picture(bytes: &[u8]) -> Option<Image> {
    let pixels = decode(bytes, "").ok()?;
    Some(Image {
        name: String::new(),
        width: pixels.width,
        height: pixels.height,
        pixels: pixels.pixels,
    })
}

fn failed(packed: &PackedImage, problem: String) -> Error {
    Error::Invalid {
        path: packed.file.clone(),
        place: format!("normal map `{}`", short(&packed.name)),
        problem,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_maps_are_counted_before_they_are_decoded() {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let image = image::RgbImage::new(300, 200);
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        let packed = PackedImage {
            name: "bumps.png".into(),
            content: Packed::File(bytes.into_inner()),
            file: "a.gltf".into(),
        };
        let two = || [&packed; 2].into_iter();
        assert!(check(two(), Budget::of(2 * 4 * 300 * 200)).is_ok());
        let error = check(two(), Budget::of(4 * 300 * 200))
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("a.gltf: normal map `bumps.png`: "),
            "{error}"
        );
    }
}
