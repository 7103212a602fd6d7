//! What one step of a gang sends out.

use ambient::lanes::{LANES, Wide};

/// What one step sends out.
pub(super) struct Step {
    pub directions: [Wide; 3],
    /// Weights of each ray in the two sums.
    pub weights: [Wide; 2],
    /// Lanes whose ray leaves the surface upward.
    pub above: u32,
    pub drawn: Drawn,
}

/// How the directions of a step were drawn, as far as light of a map needs it.
pub(super) enum Drawn {
    /// Probability per steradian is what the weights say.
    Hemisphere,
    /// From the lobes.
    Lobe(Kernel),
    /// Texels of the map, and the axes of the lobes; under GGX the views.
    Sky([u32; LANES], [Wide; 3]),
}

/// What lobes say of directions that they drew.
#[derive(Default)]
pub(super) struct Kernel {
    /// Probability per steradian, times the lobe's rays for each that another technique takes.
    pub density: Wide,
    /// What the light counts, without colour and times (1 - V·H)^5.
    pub plain: Wide,
    pub white: Wide,
}
