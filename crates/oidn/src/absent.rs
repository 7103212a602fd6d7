//! Stands in for the library where the feature `library` is left out.

use crate::Error;

/// The loaded library, of which there is none.
pub enum Oidn {}

/// The library.
///
/// # Errors
/// [`Error::LeftOut`].
pub fn load() -> Result<&'static Oidn, Error> {
    Err(Error::LeftOut)
}

impl Oidn {
    /// As that of what can be loaded.
    ///
    /// # Errors
    /// None.
    pub fn denoise(&self, _: &[[f32; 3]], _: [usize; 2], _: usize) -> Result<Vec<[f32; 3]>, Error> {
        match *self {}
    }
}
