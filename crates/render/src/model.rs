//! The ambient models that a picture can be shaded by.

/// Which ambient model shades a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// A constant times the open share of the hemisphere.
    Traditional,
    /// The same constant times what an open surface reflects, matte and specular, in closed form.
    TraditionalClosed,
    /// Equation (5) of the paper.
    Lambert,
    /// Equation (9) of the paper.
    Phong,
    /// GGX microfacets over a matte base.
    Ggx,
    /// Loose dust, as on the Moon: [`ambient::lunar`].
    LommelSeeliger,
    /// Albedo times the cosine to the eye, without any light.
    FacingRatio,
}

impl Model {
    /// The word for it on the command line, and its layer in a bake.
    pub fn name(self) -> &'static str {
        match self {
            Model::Traditional => "traditional",
            Model::TraditionalClosed => "traditional.closed",
            Model::Lambert => "lambert",
            Model::Phong => "phong",
            Model::Ggx => "ggx",
            Model::LommelSeeliger => "lommel-seeliger",
            Model::FacingRatio => "facing-ratio",
        }
    }
}
