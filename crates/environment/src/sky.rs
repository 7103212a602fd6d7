//! The light that arrives where nothing stands in the way.

use crate::SkyMap;
use std::sync::Arc;

/// Radiance of the sky, linear RGB.
#[derive(Debug, Clone, PartialEq)]
pub enum Sky {
    /// The same from every direction, each channel finite and `>= 0`.
    Uniform([f32; 3]),
    /// An illumination map.
    Map(Arc<SkyMap>),
}

impl Sky {
    /// No light at all.
    pub const BLACK: Sky = Sky::Uniform([0.0; 3]);
    /// A radiance of 1 from every direction.
    pub const WHITE: Sky = Sky::Uniform([1.0; 3]);

    /// What is the same from every direction.
    pub fn floor(&self) -> [f64; 3] {
        match self {
            Sky::Uniform(sky) => sky.map(f64::from),
            Sky::Map(map) => map.floor(),
        }
    }

    /// Mean radiance over the sphere: the constant of the traditional model.
    pub fn mean(&self) -> [f64; 3] {
        match self {
            Sky::Uniform(_) => self.floor(),
            Sky::Map(map) => map.mean(),
        }
    }

    /// That mean over the channels.
    pub fn brightness(&self) -> f64 {
        self.mean().iter().sum::<f64>() / 3.0
    }

    /// What stands out of the floor, where anything does.
    pub fn map(&self) -> Option<&SkyMap> {
        match self {
            Sky::Map(map) if map.scale() > 0.0 => Some(map),
            _ => None,
        }
    }

    /// True where no light arrives from any direction.
    pub fn is_black(&self) -> bool {
        self.mean() == [0.0; 3]
    }

    /// What a camera sees in a unit direction: linear between the middles of a map's texels.
    pub fn seen(&self, toward: [f64; 3]) -> [f64; 3] {
        match self.map() {
            None => self.floor(),
            Some(map) => map.seen(toward),
        }
    }
}
