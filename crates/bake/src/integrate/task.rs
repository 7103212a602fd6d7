//! What the texels of a bake are integrated with.

use super::sums::{REPLICATES, Technique};
use crate::labels;
use crate::options::{Model, Shading, Sky, View};
use crate::survey::Texel;
use ambient::sampling::{Mixture, PointSet, Stream};
use atlas::TILE;
use glam::DVec3;
use pulp::Arch;
use rays::RayBackend;

/// Everything about a page that integration reads.
pub(crate) struct Task<'a> {
    pub backend: &'a dyn RayBackend,
    pub arch: Arch,
    pub seed: u64,
    pub page: u32,
    /// Page edge in texels.
    pub size: u32,
    /// Rays of each texel over the hemisphere.
    pub rays: u32,
    pub points: PointSet,
    pub model: Model,
    pub view: View,
    pub shading: Shading,
    pub t_max: f32,
    /// Highlights take as many rays as the hemisphere, however faint they are.
    pub full_lobes: bool,
    /// How hemisphere directions are drawn.
    pub mixture: Mixture,
    /// A layer needs the hemisphere.
    pub hemisphere: bool,
    /// Where texels are open, or whence their light comes, is asked for.
    pub directional: bool,
    /// Order of the harmonics that any view is evaluated from, where it is asked for.
    pub any_view: Option<usize>,
    pub sky: &'a Sky,
    /// See [`crate::Options::draw_sky`].
    pub draw_sky: bool,
}

/// What the points of a tile's texels have in common.
pub(super) struct Joint {
    pub label: u32,
    pub streams: [Stream; REPLICATES as usize],
}

impl Task<'_> {
    /// A texel's own stream.
    pub fn stream(&self, x: u32, y: u32, label: u32, replicate: u32) -> Stream {
        Stream::new(self.seed, self.page, y * self.size + x, label, replicate)
    }

    /// What the texels of a tile have in common of a replicate.
    fn shared(&self, texel: &Texel, label: u32, replicate: u32) -> Stream {
        // Tiles have labels that no texel has.
        let across = self.size.div_ceil(TILE);
        let tile = 1 << 31 | (texel.y / TILE * across + texel.x / TILE);
        Stream::new(self.seed, self.page, tile, label, replicate)
    }

    /// What the replicates of the texels of `texel`'s tile have in common. Guided points are independent of those
    /// that their guide was made of.
    pub(super) fn joint(&self, texel: &Texel, technique: Technique, is_guided: bool) -> Joint {
        let label = match technique {
            Technique::Hemisphere if is_guided => labels::GUIDED,
            Technique::Hemisphere => labels::HEMISPHERE,
            Technique::Lobe => labels::LOBE,
            Technique::Sky => labels::SKY,
        };
        let streams = std::array::from_fn(|k| self.shared(texel, label, k as u32));
        Joint { label, streams }
    }

    /// The unit vector to the eye.
    pub fn view_from(&self, position: DVec3, normal: DVec3) -> DVec3 {
        match self.view {
            View::Normal => normal,
            View::Eye(eye) => (eye - position).try_normalize().unwrap_or(normal),
        }
    }

    /// R = 2 (N.V) N - V, the axis of the specular lobe.
    pub fn mirrored_view(&self, position: DVec3, normal: DVec3) -> DVec3 {
        match self.view {
            View::Normal => normal,
            View::Eye(eye) => {
                let v = (eye - position).try_normalize().unwrap_or(normal);
                2.0 * normal.dot(v) * normal - v
            }
        }
    }
}
