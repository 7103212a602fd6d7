//! How a picture's directions are laid out: as its user says, as its header says, or polar.

use super::faces::face_hint;
use super::image_file::ImageFile;
use crate::{Error, MapLayout, Orientation, Projection};
use std::path::Path;

impl ImageFile {
    /// The layout of this picture: as `projection` and `orientation` say, else as the header's `ambakeProjection` and
    /// `ambakeOrientation` say, else polar in ambake's axes. `path` is where it was read from, for errors.
    ///
    /// ```
    /// use ambake_environment::{Image, ImageFile, Labels, Projection};
    /// let image = Image::filled(8, 6, [1.0; 3]);
    /// let file = ImageFile { image, labels: Labels::new() };
    /// let error = file.layout("room.exr".as_ref(), None, None).unwrap_err();
    /// assert!(error.to_string().contains("--from cross"));
    /// assert!(file.layout("room.exr".as_ref(), Some(Projection::Cross), None).is_ok());
    /// ```
    ///
    /// # Errors
    /// [`Error::Header`] where the header says a word that is no projection or orientation, [`Error::Layout`] for a
    /// picture whose shape does not fit; where nobody says what it is, the error names the projections that its shape
    /// fits.
    pub fn layout(
        &self,
        path: &Path,
        projection: Option<Projection>,
        orientation: Option<Orientation>,
    ) -> Result<MapLayout, Error> {
        let said = match projection {
            Some(projection) => Some(projection),
            None => self.word(path, "ambakeProjection", "--from", &Projection::NAMES)?,
        };
        let axes = match orientation {
            Some(orientation) => Some(orientation),
            None => self.word(
                path,
                "ambakeOrientation",
                "--from-orientation",
                &Orientation::NAMES,
            )?,
        };
        let layout = MapLayout {
            projection: said.unwrap_or(Projection::Polar),
            orientation: axes.unwrap_or(Orientation::Ambake),
            size: (self.image.width, self.image.height),
        };
        let fail = |reason: String| Error::Layout {
            path: path.to_owned(),
            reason,
        };
        let (width, height) = layout.size;
        if let Err(error) = layout.projection.check(width, height) {
            let reason = match said {
                Some(_) => error.to_string(),
                None => format!(
                    "{width} x {height} pixels are no polar map, which is twice as wide as high; {}",
                    fitting(width, height)
                ),
            };
            return Err(fail(reason + &face_hint(path, layout.size)));
        }
        let known = layout.orientation.check(layout.projection);
        known.map_err(|error| fail(error.to_string()))?;
        Ok(layout)
    }

    /// What a header's word stands for; `None` where the header lacks it.
    fn word<T: Copy>(
        &self,
        path: &Path,
        label: &'static str,
        flag: &'static str,
        names: &[(T, &'static str)],
    ) -> Result<Option<T>, Error> {
        let Some(word) = self.labels.get(label) else {
            return Ok(None);
        };
        match names.iter().find(|(_, name)| name == word) {
            Some((value, _)) => Ok(Some(*value)),
            None => Err(Error::Header {
                path: path.to_owned(),
                label,
                word: word.clone(),
                known: names
                    .iter()
                    .map(|(_, name)| *name)
                    .collect::<Vec<_>>()
                    .join(", "),
                flag,
            }),
        }
    }
}

/// What to do with a picture of this shape that is not polar.
fn fitting(width: usize, height: usize) -> String {
    let fitting = Projection::all().filter(|p| p.check(width, height).is_ok());
    let names: Vec<_> = fitting.map(Projection::name).collect();
    match &names[..] {
        [] => "crop it".into(),
        [name] => format!("its shape fits `ambake map … --from {name}`"),
        [names @ .., last] => {
            let names = names.join(", ");
            format!("its shape fits `ambake map … --from {names} or {last}`")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Image;

    fn file(width: usize, height: usize, labels: &[(&str, &str)]) -> ImageFile {
        let label = |(name, word): &(&str, &str)| (name.to_string(), word.to_string());
        ImageFile {
            image: Image::filled(width, height, [1.0; 3]),
            labels: labels.iter().map(label).collect(),
        }
    }

    #[test]
    fn an_unknown_word_in_a_header_is_an_error_that_names_it_and_the_flag() {
        for (label, word, flag, known) in [
            ("ambakeProjection", "mercator", "--from", "polar, cube"),
            ("ambakeProjection", "Polar", "--from", "polar, cube"),
            (
                "ambakeOrientation",
                "maya",
                "--from-orientation",
                "ambake, gltf",
            ),
        ] {
            let file = file(8, 4, &[(label, word)]);
            let error = file.layout("room.exr".as_ref(), None, None).unwrap_err();
            assert!(matches!(error, Error::Header { .. }), "{error:?}");
            let text = error.to_string();
            for part in ["room.exr", label, &format!("\"{word}\""), flag, known] {
                assert!(text.contains(part), "{part} is not in: {text}");
            }
            assert_eq!(text.lines().count(), 1, "{text}");
            // Whoever says what it is need not mend the header.
            let said = (Some(Projection::Polar), Some(Orientation::Gltf));
            let layout = file.layout("room.exr".as_ref(), said.0, said.1);
            assert_eq!(layout.unwrap().orientation, Orientation::Gltf);
        }
    }

    #[test]
    fn a_header_is_followed_and_without_one_a_map_is_polar() {
        let labels = [
            ("ambakeProjection", "ortho"),
            ("ambakeOrientation", "ambake"),
        ];
        let path = Path::new("room.exr");
        let layout = file(8, 4, &labels).layout(path, None, None).unwrap();
        assert_eq!(layout.projection, Projection::Ortho);
        let layout = file(8, 4, &[]).layout(path, None, None).unwrap();
        let polar = MapLayout {
            projection: Projection::Polar,
            orientation: Orientation::Ambake,
            size: (8, 4),
        };
        assert_eq!(layout, polar);
    }

    #[test]
    fn a_picture_of_another_shape_is_told_which_projections_it_fits() {
        for (width, height, flags) in [
            (8, 6, "`ambake map … --from cross`"),
            (6, 8, "`ambake map … --from cross`"),
            (24, 4, "--from strip`"),
            (4, 24, "--from cube or strip`"),
            (6, 6, "--from ball, angular or octahedral`"),
            (7, 7, "--from ball or angular`"),
            (7, 5, "crop it"),
        ] {
            let error = file(width, height, &[]).layout("room.hdr".as_ref(), None, None);
            let text = error.unwrap_err().to_string();
            for part in ["room.hdr", "twice as wide", flags] {
                assert!(
                    text.contains(part),
                    "{width} x {height}: {part} is not in: {text}"
                );
            }
            assert!(!text.contains("face"), "{text}");
        }
    }

    #[test]
    fn a_face_of_a_cube_is_told_the_cubes_name() {
        for labels in [&[][..], &[("ambakeProjection", "cube")]] {
            let error = file(6, 6, labels).layout("in/my_room_nz.exr".as_ref(), None, None);
            let text = error.unwrap_err().to_string();
            assert!(text.contains("read my_room.exr with --from cube"), "{text}");
        }
    }
}
