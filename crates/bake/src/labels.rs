//! Labels of sample streams: what a texel's points serve. Two streams with different labels are independent.

/// Points over the footprint, for means of textured materials.
pub const SURVEY: u32 = 0;
/// Hemisphere directions.
pub const HEMISPHERE: u32 = 1;
/// Directions of the specular lobe.
pub const LOBE: u32 = 2;
/// Directions drawn from an illumination map.
pub const SKY: u32 = 4;
/// Hemisphere directions by a guide.
pub const GUIDED: u32 = 5;
/// Light that surfaces send on: six labels a gather, from here on.
pub const BOUNCE: u32 = 16;
