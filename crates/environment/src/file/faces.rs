//! The six files of a cube: their names, and hints where one of them is taken for the whole or the whole for one of
//! them.

use std::path::{Path, PathBuf};

/// What the names of a cube's six pictures end in, in the order in which [`crate::Projection::Cube`] stacks them:
/// `NAME_px.exr` is the face toward +x of the cube `NAME.exr`.
pub const FACES: [&str; 6] = ["px", "nx", "py", "ny", "pz", "nz"];

/// What to do with one square face of a cube; empty where the name or the shape does not say that it is one.
pub(super) fn face_hint(path: &Path, (width, height): (usize, usize)) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let cube = stem.rsplit_once('_').filter(|(_, end)| FACES.contains(end));
    match cube {
        Some((name, _)) if width == height => {
            let cube = renamed(path, name);
            let name = cube.file_name().unwrap_or_default().to_string_lossy();
            format!("; where it is a face of a cube, read {name} with --from cube")
        }
        _ => String::new(),
    }
}

/// What to do where nothing is at `path`; empty unless faces of a cube of that name are there.
pub(super) fn absent_hint(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut faces = FACES
        .map(|face| renamed(path, &format!("{stem}_{face}")))
        .into_iter();
    match faces.find(|face| face.exists()) {
        Some(face) => {
            let name = face.file_name().unwrap_or_default().to_string_lossy();
            format!("; there is {name}: `ambake map … --from cube` reads the six faces of a cube")
        }
        None => String::new(),
    }
}

/// `DIR/NAME.ENDING` of `DIR/STEM.ENDING`.
fn renamed(path: &Path, name: &str) -> PathBuf {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{name}.{ending}"))
}

#[cfg(test)]
mod tests {
    use crate::{Format, Image, Labels};

    #[test]
    fn a_name_without_a_file_but_with_faces_is_told_the_flag() {
        let folder = tempfile::tempdir().unwrap();
        let face = Image::filled(4, 4, [1.0; 3]);
        let bytes = crate::encode(&face, Format::Hdr, &Labels::new()).unwrap();
        let path = folder.path().join("room.hdr");
        let plain = crate::read(&path).unwrap_err().to_string();
        assert!(!plain.contains("cube"), "{plain}");
        std::fs::write(folder.path().join("room_ny.hdr"), bytes).unwrap();
        let text = crate::read(&path).unwrap_err().to_string();
        for part in ["room.hdr", "room_ny.hdr", "--from cube"] {
            assert!(text.contains(part), "{part} is not in: {text}");
        }
    }
}
