//! Map files that shading looks up: polar, in ambake's own axes.

use environment::{Error, IlluminationMap, Orientation, Projection, read};
use std::path::Path;

/// A polar map with what its header says.
#[derive(Debug, Clone, PartialEq)]
pub struct PolarFile {
    /// The map.
    pub map: IlluminationMap,
    /// By what its values are normalised; `None` where the header does not say.
    pub normalisation: Option<String>,
}

/// The map in the file at `path`. A header that says nothing of projection and axes is taken for a polar one's.
///
/// # Errors
/// Those of [`read`]; [`Error::Shape`] for another projection, other axes, or a picture that is not twice as wide as
/// high.
pub fn read_polar(path: &Path) -> Result<PolarFile, Error> {
    let file = read(path)?;
    let label = |name: &str| file.labels.get(name).map(String::as_str);
    let projection = label("ambakeProjection").unwrap_or(Projection::Polar.name());
    let orientation = label("ambakeOrientation").unwrap_or(Orientation::Ambake.name());
    if projection != Projection::Polar.name() || orientation != Orientation::Ambake.name() {
        return Err(Error::Shape(format!(
            "{} is a {projection} map with the axes of {orientation}; run ambake map convert --to polar on it",
            path.display()
        )));
    }
    let normalisation = label("ambakeNormalisation").map(String::from);
    let map = IlluminationMap::new(file.image, Projection::Polar)
        .map_err(|error| Error::Shape(format!("{}: {error}", path.display())))?;
    Ok(PolarFile { map, normalisation })
}

#[cfg(test)]
mod tests {
    use super::*;
    use environment::{Format, Image, Labels, encode};

    #[test]
    fn only_a_polar_map_in_own_axes_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.exr");
        let with = |size: (usize, usize), labels: &[(&str, &str)]| {
            let labels: Labels = labels
                .iter()
                .map(|(name, text)| (name.to_string(), text.to_string()))
                .collect();
            let image = Image::filled(size.0, size.1, [0.5; 3]);
            std::fs::write(&path, encode(&image, Format::Exr, &labels).unwrap()).unwrap();
            read_polar(&path)
        };
        let plain = with((8, 4), &[]).unwrap();
        assert_eq!(plain.map.size(), (8, 4));
        assert_eq!(plain.normalisation, None);
        let labelled = [
            ("ambakeProjection", "polar"),
            ("ambakeNormalisation", "seed"),
        ];
        let seed = with((8, 4), &labelled).unwrap();
        assert_eq!(seed.normalisation.as_deref(), Some("seed"));
        for (size, labels, word) in [
            ((8, 4), [("ambakeProjection", "ball")], "ball map"),
            ((8, 4), [("ambakeOrientation", "gltf")], "axes of gltf"),
            ((8, 8), [("ambakeProjection", "polar")], "twice as wide"),
        ] {
            let error = with(size, &labels).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
            assert!(error.contains("map.exr"), "{error}");
        }
    }
}
