//! Whether the files of a scene are still what was read.

use crate::Scene;
use crate::source::open;
use std::io;

impl Scene {
    /// True where the files that decide a bake hold other bytes than [`crate::load`] read, or are gone. A scene that
    /// was made in memory has none.
    ///
    /// The scene itself stays as it was read: a bake of it is right, and its files are no longer its source.
    pub fn was_edited(&self) -> bool {
        let mut hasher = blake3::Hasher::new();
        // Pictures that are carried along unhashed stand behind the others.
        for path in &self.inputs {
            let read = open(path).map(|mut file| io::copy(&mut file, &mut hasher));
            if !matches!(read, Ok(Ok(_))) {
                return true;
            }
            if hasher.finalize().to_hex().as_str() == self.content_hash {
                return false;
            }
        }
        !self.inputs.is_empty()
    }
}
