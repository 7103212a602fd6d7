//! A library without the files of bakes has no earlier one to start from.

use crate::error::Error;
use crate::options::Options;
use crate::scene::Scene;
use atlas::{Atlas, Seen};
use std::path::Path;

/// The finished bake that an update starts from: none.
pub(crate) enum Earlier {}

impl Earlier {
    /// An error that names the feature.
    pub fn open(_: &Path, _: &Scene, _: bool) -> Result<Self, Error> {
        Err(Error::option("update", "needs the feature `write`"))
    }

    /// As that of what can be opened.
    pub fn asked(&self) -> (&Path, bool) {
        match *self {}
    }

    /// As that of what can be opened.
    pub fn layout(&mut self, _: &Scene, _: &Options, _: Option<&Seen<'_>>) -> Option<Atlas> {
        match *self {}
    }
}
