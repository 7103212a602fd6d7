//! The texels of a page as the denoiser sees them.

use glam::Vec3;

/// What is known of a page's texels, row by row; nothing is read where the coverage is 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Field<'a> {
    /// Page edge in texels.
    pub size: usize,
    pub coverage: &'a [f32],
    /// Share of each footprint that can be seen; what cannot be seen at all has no values of its own. `None` where all
    /// can.
    pub validity: Option<&'a [f32]>,
    /// World positions.
    pub position: [&'a [f32]; 3],
    /// Unit shading normals.
    pub normal: [&'a [f32]; 3],
    pub object: &'a [f32],
}

impl Field<'_> {
    pub fn has_data(&self, texel: usize) -> bool {
        self.coverage[texel] > 0.0 && self.validity.is_none_or(|valid| valid[texel] > 0.0)
    }

    pub fn position(&self, texel: usize) -> Vec3 {
        Vec3::from(self.position.map(|plane| plane[texel]))
    }

    pub fn normal(&self, texel: usize) -> Vec3 {
        Vec3::from(self.normal.map(|plane| plane[texel]))
    }
}
