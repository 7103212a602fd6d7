//! What a bake was asked to do, typed and validated by the caller.

use crate::choice::Choice;
use ambient::any_view::Lobe;
use ambient::ggx::alpha_of;
pub use ambient::sampling::PointSet;
pub use environment::Sky;
use glam::DVec3;
use layers::{Layer, Term};
use rays::{Light, Overrides};

/// Options of one bake. The command line's words are turned into this once; nothing below reads flags.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Rays per texel over the hemisphere; lobes take what they are worth beside them.
    pub effort: Effort,
    /// Where sample points come from.
    pub points: PointSet,
    /// Where in a texel samples lie.
    pub footprint: Footprint,
    /// How integrated terms are denoised.
    pub denoise: Denoise,
    /// Where seams are solved.
    pub seams: Seams,
    /// Seed of every sample stream.
    pub seed: u64,
    /// Radiance that arrives where nothing blocks it.
    pub sky: Sky,
    /// Directions are drawn from an illumination map too; off only to measure what that saves.
    pub draw_sky: bool,
    /// View rule of the specular term.
    pub view: View,
    /// What lies between a shading normal's horizon and the plane of its facet.
    pub shading: Shading,
    /// What happens to samples inside of solids.
    pub buried: Buried,
    /// A thin layer at most so far above a surface, in scene units, takes no light from it; 0 for none. `None` for an
    /// eighth of a texel. From there to twice as far that fades.
    pub under: Option<f64>,
    /// Occluders farther than this do not count, in scene units; `None` for no limit.
    pub max_distance: Option<f32>,
    /// What the highlight is.
    pub model: Model,
    /// How often surfaces send light on.
    pub bounces: Bounces,
    /// Lights without extent, in scene units.
    pub lights: Vec<Light>,
    /// Layers to produce, without repeats.
    pub layers: Vec<Layer>,
    /// Rings of void texels that are filled around charts, at most 250.
    pub rings: u32,
    /// Normal maps bend the shading normals.
    pub normal_maps: bool,
    /// Highlights take as many rays as the hemisphere, however little of them comes through to what is composed.
    pub full_highlights: bool,
    /// k_a of the traditional model.
    pub ambient: AmbientCoefficient,
    /// Values that replace the materials' own.
    pub overrides: Overrides,
    /// Planner choices that are switched off: what they would leave out is modelled all the same.
    pub switched_off: Vec<Choice>,
}

/// k_a, by which the traditional model reflects ambient light: equation (1) of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum AmbientCoefficient {
    /// That of ambient light reflected by a Lambertian surface: k_d.
    #[default]
    Albedo,
    /// One for all materials, linear RGB.
    Rgb([f32; 3]),
    /// Each material's own ([`scene::Material::ambient`]); the albedo where it has none.
    Material,
}

/// How many rays a texel takes over the hemisphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effort {
    /// So many, at least 1.
    Rays(u32),
    /// As many, tile by tile, as the root mean square of a page's standard errors asks for, after denoising where pages
    /// are denoised by fits.
    Target {
        /// That root mean square, above 0.
        error: f64,
        /// An error of so much of the value counts as one of `error`, where that is more: 0 for nothing, below 1.
        relative: f64,
        /// The most rays, at least 16.
        max_rays: u32,
    },
}

/// Where the samples of a texel lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Footprint {
    /// All over the part of its square that charts cover: a texel is a mean over its area.
    #[default]
    Texel,
    /// At the point of that part nearest to the texel's centre, as in bakers that know no areas.
    Centre,
}

/// What happens to the terms of a page after they are integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Denoise {
    /// Nothing: every texel is unbiased.
    #[default]
    Off,
    /// Local regression over the texels of a surface, by two independent halves of the rays: at least 2 rays.
    Regression,
    /// Intel Open Image Denoise, which [`oidn::load`] must find. Standard errors stay those of the plain values.
    Oidn,
}

/// Between which charts a look-up is made to agree across the edge that they share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Seams {
    /// None: every texel stays the mean over its footprint.
    Off,
    /// Charts of one object.
    Object,
    /// Charts of any objects.
    #[default]
    Scene,
}

/// Where the eye of the specular term stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum View {
    /// V = N at every point: the view that a lightmap without a camera can state.
    Normal,
    /// The eye is a point in world space.
    Eye(DVec3),
}

/// What smooth shading sees in the wedge of directions above the horizon of the shading normal and below the plane of
/// the facet. `docs/surfaces.md` derives both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shading {
    /// Each direction of the wedge sees what its mirror image in the plane of the facet sees: a convex body does not
    /// darken itself.
    #[default]
    Production,
    /// The facet hides the wedge: the integral over the triangles as they are.
    Exact,
}

/// The model of the highlight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// The lobe of the paper, (R·V)^n.
    #[default]
    Phong,
    /// Microfacets: GGX, with [`Layer::Ggx`] in place of [`Layer::Phong`].
    Ggx,
}

impl Model {
    /// The lobe of a material of this exponent, for any view.
    pub(crate) fn lobe(self, exponent: f64) -> Lobe {
        match self {
            Self::Phong => Lobe::Phong(exponent),
            Self::Ggx => Lobe::Ggx(alpha_of(exponent)),
        }
    }
}

/// How often surfaces send on the light that they receive, see [`crate::Baker::bounce`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bounces {
    /// Never: only the sky shines.
    #[default]
    Off,
    /// So often, at least 1.
    Most(u32),
    /// Until what is missing is less than a target error, or half a step of 8 bits where there is none.
    Auto,
}

impl Bounces {
    /// The gathers before the last one, which brings their light and one more.
    pub(crate) fn before_last(self) -> Self {
        match self {
            Bounces::Most(gathers) => Bounces::Most(gathers.saturating_sub(1)),
            other => other,
        }
    }
}

/// What happens to samples of a surface that lie inside of other solids, where nobody sees them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Buried {
    /// They are dropped: a texel is the mean over what can be seen of it, and one that cannot be seen is filled from
    /// its neighbours.
    #[default]
    Drop,
    /// They count as what they are, dark.
    Keep,
}

impl Default for Options {
    /// A plain bake: 256 rays a texel under a white sky, the standard layers.
    fn default() -> Self {
        Self {
            effort: Effort::Rays(256),
            points: PointSet::default(),
            footprint: Footprint::default(),
            denoise: Denoise::default(),
            seams: Seams::default(),
            seed: 0,
            sky: Sky::WHITE,
            draw_sky: true,
            view: View::Normal,
            shading: Shading::default(),
            buried: Buried::default(),
            under: None,
            max_distance: None,
            model: Model::default(),
            bounces: Bounces::default(),
            lights: Vec::new(),
            layers: Layer::STANDARD.to_vec(),
            rings: atlas::RINGS,
            normal_maps: false,
            full_highlights: true,
            ambient: AmbientCoefficient::Albedo,
            overrides: Overrides::default(),
            switched_off: Vec::new(),
        }
    }
}

impl Options {
    /// True where a planner choice may be taken.
    pub(crate) fn allows(&self, choice: Choice) -> bool {
        !self.switched_off.contains(&choice)
    }

    /// True where an asked layer needs the term.
    pub(crate) fn wants(&self, term: Term) -> bool {
        self.kept()
            .iter()
            .any(|layer| layer.needs().contains(&term))
    }

    /// The order of the harmonics that the asked layers hold; `None` where none does.
    pub fn any_view(&self) -> Option<usize> {
        let asks = |layer| self.layers.contains(&layer);
        if asks(Layer::AnyView8) {
            Some(8)
        } else if asks(Layer::AnyView) || asks(Layer::AnyView4) || asks(Layer::StdErrAnyView) {
            Some(4)
        } else {
            None
        }
    }

    /// True where an asked layer says where texels are open or whence their light comes.
    pub(crate) fn is_directional(&self) -> bool {
        let asks = |layer| self.layers.contains(&layer);
        asks(Layer::Bent) || asks(Layer::BentTangent) || asks(Layer::Sh)
    }

    /// True where light is added to finished pages: that of lights, and what surfaces send on.
    pub fn adds_light(&self) -> bool {
        self.bounces != Bounces::Off || !self.lights.is_empty()
    }

    /// True where an asked layer shows light that is added to finished pages.
    pub(crate) fn shows_light(&self) -> bool {
        self.adds_light() && self.asks_for_light()
    }

    /// True where an asked layer would show light that is added to finished pages.
    pub fn asks_for_light(&self) -> bool {
        let shows = |layer: &Layer| {
            matches!(
                layer,
                Layer::Irradiance
                    | Layer::Reflection
                    | Layer::StdErrIrradiance
                    | Layer::StdErrReflection
                    | Layer::Lambert
                    | Layer::Phong
                    | Layer::Ggx
                    | Layer::DifferenceLambert
                    | Layer::DifferencePhong
                    | Layer::Sh
                    | Layer::Direct
            )
        };
        self.layers.iter().any(shows)
    }

    /// The layers of a finished page: those that were asked for and, where light is added to it, what that needs until
    /// it is.
    pub(crate) fn kept(&self) -> Vec<Layer> {
        let mut layers = self.layers.clone();
        if self.shows_light() {
            let base = (self.model == Model::Ggx).then_some(Layer::Base);
            let light = [
                Layer::Irradiance,
                Layer::Albedo,
                Layer::Reflectance,
                Layer::Validity,
            ];
            let normal = self.layers.contains(&Layer::Sh).then_some(Layer::Normal);
            for layer in light.into_iter().chain(base).chain(normal) {
                if !layers.contains(&layer) {
                    layers.push(layer);
                }
            }
        }
        layers
    }
}
