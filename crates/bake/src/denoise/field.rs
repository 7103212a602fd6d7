//! The texels of a page as the denoiser sees them.

use glam::DVec3;

/// What is known of a page's texels, row by row; nothing is read where `data` is 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Field<'a> {
    /// Page edge in texels.
    pub size: usize,
    /// Above 0 where the page has values of its own.
    pub data: &'a [f32],
    /// World positions.
    pub position: [&'a [f32]; 3],
    /// Unit shading normals.
    pub normal: [&'a [f32]; 3],
    pub object: &'a [f32],
}

impl Field<'_> {
    pub fn has_data(&self, texel: usize) -> bool {
        self.data[texel] > 0.0
    }

    pub fn position(&self, texel: usize) -> DVec3 {
        DVec3::from(self.position.map(|plane| f64::from(plane[texel])))
    }

    pub fn normal(&self, texel: usize) -> DVec3 {
        DVec3::from(self.normal.map(|plane| f64::from(plane[texel])))
    }
}
