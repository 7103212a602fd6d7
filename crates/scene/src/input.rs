//! What one load has so far, whether of a file or of what a program hands over.

#[cfg(feature = "files")]
use crate::image::Budget;
use crate::{Error, Warning, WarningKind};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Where the files may lie that a scene file names: buffers, pictures, material libraries.
#[cfg(feature = "files")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Files {
    /// In the folder of the scene file or below it, links resolved. A scene from elsewhere cannot have other files
    /// read.
    #[default]
    Inside,
    /// Anywhere: for scenes that you trust.
    Anywhere,
}

/// What one load may read.
#[cfg(feature = "files")]
#[derive(Default)]
pub(crate) struct Bounds {
    /// Where files may lie.
    pub allowed: Files,
    /// What the decoded pictures take.
    pub pictures: Budget,
}

/// The state of one load: which file, the hash of what was read, and the warnings so far.
pub(crate) struct Input {
    pub path: PathBuf,
    /// What it may read.
    #[cfg(feature = "files")]
    pub bounds: Bounds,
    pub hasher: blake3::Hasher,
    pub warnings: Vec<Warning>,
    /// The least factor by which the reflectances of a material were scaled down, and of how many materials.
    pub scaled: (f64, u64),
    /// Every file that was read, the main one first.
    pub files: Vec<PathBuf>,
}

impl Input {
    pub fn new(path: &Path) -> Input {
        Input {
            path: path.to_path_buf(),
            #[cfg(feature = "files")]
            bounds: Bounds::default(),
            hasher: blake3::Hasher::new(),
            warnings: Vec::new(),
            scaled: (1.0, 0),
            files: Vec::new(),
        }
    }

    /// Error about a place in the main file.
    pub fn invalid(&self, place: impl Into<String>, problem: impl Into<String>) -> Error {
        Error::Invalid {
            path: self.path.clone(),
            place: place.into(),
            problem: problem.into(),
        }
    }

    /// Notes that something was repaired or ignored `count` times; nothing for a count of 0.
    pub fn warn(
        &mut self,
        kind: WarningKind,
        place: impl Into<String>,
        count: u64,
        message: impl Into<String>,
    ) {
        if count > 0 {
            let (place, message) = (place.into(), message.into());
            self.warnings.push(Warning {
                kind,
                place,
                count,
                message,
            });
        }
    }
}

/// The longest name that is kept whole.
const LONGEST_NAME: usize = 200;

/// What a scene from an OBJ file calls something of this name: of a very long one the start and a hash are kept, so
/// that it stays a name of its own and memory is bounded.
pub fn kept_name(name: &str) -> Cow<'_, str> {
    if name.len() <= LONGEST_NAME {
        return Cow::Borrowed(name);
    }
    let hash = blake3::hash(name.as_bytes()).to_hex();
    format!("{}{}", short(name), &hash[..16]).into()
}

/// The start of a text without control characters, for a message on one line.
pub(crate) fn short(text: &str) -> String {
    let clean: String = text
        .chars()
        .take(80)
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    if clean.len() < text.len() {
        format!("{clean}…")
    } else {
        clean
    }
}
