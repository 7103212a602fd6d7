//! The light that arrives where nothing blocks it.

use crate::error::Error;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The largest radiance of a sky, a lamp or a light that is baked. Squares of what it becomes after bounces are still
/// 32-bit numbers.
pub(crate) const MAX_RADIANCE: f32 = 1e12;

/// The sky of a bake: uniform, or an illumination map from a file.
#[derive(Debug, Clone)]
pub struct Sky {
    pub(crate) light: maps::Sky,
    /// What outputs say of it: everything that decides its values.
    described: Value,
    /// The picture it was read from.
    pub(crate) file: Option<PathBuf>,
}

impl Sky {
    /// The same radiance from every direction, linear RGB; each channel is finite and at least 0.
    pub fn uniform(radiance: [f32; 3]) -> Self {
        Self {
            light: maps::Sky::Uniform(radiance),
            described: json!(radiance),
            file: None,
        }
    }

    /// The illumination map in an .hdr or .exr file, polar unless its header says otherwise.
    ///
    /// # Errors
    /// The file is absent or damaged, or holds a value that is no radiance.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let sky = maps::read_sky(path)?;
        let (width, height) = sky.map.size();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self {
            described: json!({
                "file": name,
                "hash": sky.hash,
                "size": [width, height],
                "mean": sky.map.mean(),
            }),
            light: maps::Sky::Map(Arc::new(sky.map)),
            file: Some(path.to_owned()),
        })
    }

    /// The light itself, for what takes it elsewhere.
    pub fn light(&self) -> &maps::Sky {
        &self.light
    }

    /// Mean radiance over the sphere, linear RGB.
    pub fn mean(&self) -> [f64; 3] {
        self.light.mean()
    }

    /// The largest radiance, channel by channel.
    pub(crate) fn largest(&self) -> [f32; 3] {
        match &self.light {
            maps::Sky::Uniform(radiance) => *radiance,
            maps::Sky::Map(map) => {
                let (width, height) = map.size();
                let excess = (0..(width * height) as u32).map(|texel| map.excess(texel));
                let most = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|c| a[c].max(b[c]));
                let (floor, excess) = (map.floor(), excess.fold([0.0; 3], most));
                [0, 1, 2].map(|c| (floor[c] + map.scale() * f64::from(excess[c])) as f32)
            }
        }
    }

    /// True where the sky is an illumination map.
    pub fn is_map(&self) -> bool {
        self.file.is_some()
    }
}

impl From<[f32; 3]> for Sky {
    fn from(radiance: [f32; 3]) -> Self {
        Self::uniform(radiance)
    }
}

impl Default for Sky {
    fn default() -> Self {
        Self::uniform([1.0; 3])
    }
}

impl Serialize for Sky {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.described.serialize(serializer)
    }
}
