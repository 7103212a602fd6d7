//! What the planner may leave out.

use serde::Serialize;

/// Something the planner may leave out. Each can be switched off by name; then it is modelled whatever the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(into = "&'static str")]
pub enum Choice {
    /// No map look-up where the sky is uniform.
    Sky,
    /// No hemisphere rays where only the specular term is asked for.
    Diffuse,
    /// No share of uniform directions where no asked layer needs the visibility.
    Visibility,
    /// No lobe rays where nothing reflects specularly or no asked layer shows it.
    Specular,
    /// Closed forms and no rays on triangles that nothing stands above.
    Open,
    /// No instance level in the ray scene where nothing is instanced.
    Instances,
    /// No alpha test in the ray query where no material is alpha-masked.
    AlphaTest,
    /// No gathers where they are not asked for or no surface sends light to another.
    Bounces,
    /// No shadow rays where there are no lights or no asked layer shows them.
    Lights,
}

impl Choice {
    /// Every choice, in the order in which the planner reports them.
    pub const ALL: [Self; 9] = [
        Self::Sky,
        Self::Diffuse,
        Self::Visibility,
        Self::Specular,
        Self::Open,
        Self::Instances,
        Self::AlphaTest,
        Self::Bounces,
        Self::Lights,
    ];

    /// The name on the command line and in `bake.json`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sky => "sky",
            Self::Diffuse => "diffuse",
            Self::Visibility => "visibility",
            Self::Specular => "specular",
            Self::Open => "open",
            Self::Instances => "instances",
            Self::AlphaTest => "alpha_test",
            Self::Bounces => "bounces",
            Self::Lights => "lights",
        }
    }

    /// The choice of that name; `filter` is the old word for `alpha_test`.
    pub fn from_name(name: &str) -> Option<Self> {
        if name == "filter" {
            return Some(Self::AlphaTest);
        }
        Self::ALL.into_iter().find(|choice| choice.name() == name)
    }
}

impl From<Choice> for &'static str {
    fn from(choice: Choice) -> Self {
        choice.name()
    }
}
