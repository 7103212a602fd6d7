//! What several verbs do.

use ambake::Backend;
use anyhow::Context;
use rays::{RayBackend, World, WorldOptions};
use scene::Scene;
use std::path::Path;
use std::sync::Arc;

/// A scene as camera rays see it. Coordinates count from [`World::origin`].
pub fn build(
    scene: Scene,
    backend: Option<Backend>,
    threads: usize,
) -> anyhow::Result<(World, Box<dyn RayBackend>)> {
    let world = World::near(Arc::new(scene), WorldOptions::default())?;
    let backend = rays::build(
        backend.unwrap_or_else(Backend::best).kind(),
        &world,
        threads,
    )?;
    Ok((world, backend))
}

/// What a text file holds; errors name it.
pub fn parsed<T, E>(path: &Path, parse: impl FnOnce(&str) -> Result<T, E>) -> anyhow::Result<T>
where
    E: std::error::Error + Send + Sync + 'static,
{
    parse(&text_file(path)?).with_context(|| path.display().to_string())
}

/// The text of a regular file; errors name it.
pub fn text_file(path: &Path) -> anyhow::Result<String> {
    let text = report::check_regular(path).and_then(|()| std::fs::read_to_string(path));
    let text = text.with_context(|| format!("cannot read {}", path.display()))?;
    Ok(text.trim_start_matches('\u{feff}').to_owned())
}
