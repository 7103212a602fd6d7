//! Everything that decides the values of a bake, in one type: what the baker and the layout are given, what headers and
//! `bake.json` say, and what an interrupted bake must share with the one that continues it are all made from it.

pub(crate) mod check;
pub(crate) mod describe;

use crate::error::Error;
use crate::scene::Scene;
use crate::sky::Sky;
use ::bake::{
    AmbientCoefficient, Bounces, Buried, Choice, Denoise, Footprint, Model, PointSet, Seams,
    Shading, View,
};
use ::scene::{Format, Instance, MaterialModel};
use environment::Up;
use layers::Layer;
use rays::{Light, Overrides};
use report::Engine;

pub use crate::choices::{Backend, Uv};
pub use ::bake::Effort;
pub use atlas::Pages;

/// The type of options, each with its default.
macro_rules! options {
    ($($(#[$doc:meta])* $name:ident: $kind:ty = $default:expr;)*) => {
        /// The options of a bake. [`crate::Bake`] sets them one by one; `Options::default()` are those of a plain bake.
        #[derive(Debug, Clone)]
        #[non_exhaustive]
        pub struct Options {
            $($(#[$doc])* pub $name: $kind,)*
        }

        impl Default for Options {
            fn default() -> Self {
                Self { $($name: $default,)* }
            }
        }
    };
}

options! {
    /// Page edge in texels, 1..=16384.
    size: u32 = 1024;
    /// Texels per scene unit of every object; `None` shares the texels of the pages by a rule.
    density: Option<f64> = None;
    /// All objects have one density, the largest that fits the pages, but for those with one of their own.
    even_density: bool = false;
    /// Texels per scene unit of the objects that a name with wildcards fits; later ones win.
    density_of: Vec<(String, f64)> = Vec::new();
    /// Names, with wildcards, of the objects that take texels; empty for all.
    include: Vec<String> = Vec::new();
    /// Names, with wildcards, of objects that take no texels; they still occlude.
    exclude: Vec<String> = Vec::new();
    /// Names, with wildcards, of objects that block no light; they take texels.
    no_cast: Vec<String> = Vec::new();
    /// What happens to samples that are buried, of the objects that a name with wildcards fits; later ones win.
    buried_of: Vec<(String, Buried)> = Vec::new();
    /// Eye points in scene units: charts that none of them sees take one texel; empty for no such test.
    seen_from: Vec<[f64; 3]> = Vec::new();
    /// The same for the outsides of a scene of rooms, which nobody within sees; no other scene changes.
    seen_from_within: bool = false;
    /// How many pages there are.
    pages: Pages = Pages::Auto;
    /// A mesh that does not fit on one page is an error.
    one_page_per_mesh: bool = false;
    /// Lightmap coordinates.
    uv: Uv = Uv::Auto;
    /// Texels that stay empty around every chart that is packed, 0..=128.
    gutter: u32 = 2;
    /// Mip levels on which no look-up mixes packed charts, 0..=6: the gutter grows as needed.
    mips: u32 = 0;
    /// Edge in texels of the blocks that never hold texels of two packed charts, 1..=16; 1 for none.
    align: u32 = 1;
    /// How many rays a texel takes.
    effort: Effort = Effort::Rays(256);
    /// Where the samples of a texel lie.
    footprint: Footprint = Footprint::Texel;
    /// How integrated terms are denoised; `None`: see [`Options::denoises`].
    denoise: Option<Denoise> = None;
    /// Where seams are solved.
    seams: Seams = Seams::default();
    /// Seed of every sample stream.
    seed: u64 = 0;
    /// The light that arrives where nothing blocks it.
    sky: Sky = Sky::default();
    /// The axis of the scene that points upward, for a sky that is a map and for the first picture.
    up: Up = Up::Y;
    /// Where the eye of the specular term stands.
    view: View = View::Normal;
    /// What smooth shading sees below the plane of a facet.
    shading: Shading = Shading::Production;
    /// What happens to samples inside of solids.
    buried: Buried = Buried::Drop;
    /// How far above a surface a thin layer may lie that takes no light from it, in scene units; `None` for an eighth
    /// of a texel.
    under: Option<f64> = None;
    /// Occluders farther than this do not count, in scene units.
    max_distance: Option<f32> = None;
    /// What the highlight is; under GGX the layer `ggx` stands in place of `phong`. `None`: the model that layers or an
    /// exponent ask for, else GGX for glTF and for metallic-roughness in memory, which are defined by it, and Phong for
    /// other scenes.
    model: Option<Model> = None;
    /// How often surfaces send on the light that they receive.
    bounces: Bounces = Bounces::Off;
    /// Suns, point lights and spots, in scene units.
    lights: Vec<Light> = Vec::new();
    /// Whether the lights of the scene's file join [`Options::lights`]; `None` for no, and a warning names them.
    file_lights: Option<bool> = None;
    /// Layers to produce, coverage first, without repeats.
    layers: Vec<Layer> = Layer::STANDARD.to_vec();
    /// Normal maps of materials bend the shading normals.
    normal_maps: bool = false;
    /// k_a, by which the layer `traditional` reflects.
    ambient_coefficient: AmbientCoefficient = AmbientCoefficient::Albedo;
    /// Diffuse reflectance of every material, linear RGB.
    albedo: Option<[f32; 3]> = None;
    /// Specular reflectance of every material, linear RGB.
    specular: Option<[f32; 3]> = None;
    /// Lobe exponent of every material, 0..=1e6.
    exponent: Option<f64> = None;
    /// Highlights take as many rays as the hemisphere, however faint they are. So they do too with an exponent, an eye
    /// point, or layers that show them by themselves.
    full_highlights: bool = false;
    /// Planner choices that are switched off.
    plan_off: Vec<Choice> = Vec::new();
    /// Engines that get files of their own; these change no value.
    engines: Vec<Engine> = Vec::new();
    /// Their lightmaps and occlusion are compressed, where an engine reads that; it changes no value.
    compress: bool = false;
    /// The diffuse term is also written at vertices; it changes no value.
    vertices: bool = false;
}

impl Options {
    /// How terms are denoised: as was asked, else by regression wherever it can be. A single ray has no halves to
    /// compare.
    pub fn denoises(&self) -> Denoise {
        self.denoise.unwrap_or(match self.effort {
            Effort::Rays(1) => Denoise::Off,
            _ => Denoise::Regression,
        })
    }

    /// Adds the layers that engine files are made of and that no ray is cast for: the light, which no other layer holds
    /// under a map or with bounces, in every bake of the models; all of it where engines are named.
    pub(crate) fn complete(&mut self) {
        let mut wanted = Vec::new();
        if !self.engines.is_empty() {
            wanted.push(Layer::Diffuse);
        }
        let light = self.layers.contains(&Layer::Lambert) || !self.engines.is_empty();
        if light && self.light_varies() {
            wanted.push(Layer::Irradiance);
        }
        if light && !self.lights.is_empty() {
            wanted.push(Layer::Direct);
        }
        for layer in wanted {
            if !self.layers.contains(&layer) {
                self.layers.push(layer);
            }
        }
    }

    /// The scene, in which what [`Options::no_cast`] names blocks no light and objects are told what happens to what is
    /// buried of them. Where one drops it, [`Options::buried`] says so, and each of the others that keeps it.
    pub(crate) fn cast(&mut self, scene: &Scene) -> Result<Scene, Error> {
        let drops = |of: &Instance| of.keeps_buried == Some(false);
        let is_told = self.buried == Buried::Keep && scene.instances.iter().any(drops);
        if self.no_cast.is_empty() && self.buried_of.is_empty() && !is_told {
            return Ok(scene.clone());
        }
        let named = |pattern: &str, flag: &'static str| {
            let named = atlas::instances_named(scene, pattern, flag);
            named.map_err(|source| Error::Layout {
                scene: scene.path.display().to_string(),
                source,
            })
        };
        let mut own = ::scene::Scene::clone(scene);
        for pattern in &self.no_cast {
            for instance in named(pattern, "--no-cast")? {
                own.instances[instance as usize].casts = false;
            }
        }
        for (pattern, buried) in &self.buried_of {
            for instance in named(pattern, "--buried-of")? {
                own.instances[instance as usize].keeps_buried = Some(*buried == Buried::Keep);
            }
        }
        if self.buried == Buried::Keep && own.instances.iter().any(drops) {
            let others = own.instances.iter_mut();
            others.for_each(|of| of.keeps_buried = of.keeps_buried.or(Some(true)));
            self.buried = Buried::Drop;
        }
        Ok(own.into())
    }

    /// True where the light that arrives is more than the sky's mean times the diffuse term.
    pub(crate) fn light_varies(&self) -> bool {
        self.sky.is_map() || self.adds_light()
    }

    /// True where light is added to finished pages: that of lights, and what surfaces send on.
    pub(crate) fn adds_light(&self) -> bool {
        self.bounces != Bounces::Off || !self.lights.is_empty()
    }

    /// The model that was asked for, or that what was asked for needs, or else that the materials of such a file are
    /// made for.
    fn model_for(&self, scene: &Scene) -> Model {
        let asks = |layers: &[Layer]| self.layers.iter().any(|layer| layers.contains(layer));
        // What is stored for any view has no colours of its own under GGX.
        let phong = [
            Layer::DifferencePhong,
            Layer::AnyView,
            Layer::AnyView4,
            Layer::AnyView8,
        ];
        let is_metallic_roughness = |material: &::scene::Material| {
            matches!(material.surface, MaterialModel::MetallicRoughness { .. })
        };
        self.model.unwrap_or(match scene.format {
            _ if asks(&[Layer::Ggx, Layer::Base]) => Model::Ggx,
            _ if asks(&phong) || self.exponent.is_some() => Model::Phong,
            Format::Gltf | Format::Glb => Model::Ggx,
            Format::Memory if scene.materials.iter().any(is_metallic_roughness) => Model::Ggx,
            Format::Obj | Format::Memory => Model::Phong,
        })
    }

    /// The same for a scene: with its lights where they are baked, and with a model, and its layer in place of
    /// another's.
    pub(crate) fn settled(mut self, scene: &Scene) -> Self {
        if self.file_lights == Some(true) {
            self.lights.extend(scene.lights.iter().map(Light::from));
        }
        self.sky = self.sky.with_up(self.up);
        let model = self.model_for(scene);
        self.model = Some(model);
        if model == Model::Ggx {
            let has = self.layers.contains(&Layer::Ggx);
            self.layers.retain(|layer| !(has && *layer == Layer::Phong));
            for layer in self
                .layers
                .iter_mut()
                .filter(|layer| **layer == Layer::Phong)
            {
                *layer = Layer::Ggx;
            }
        }
        self
    }

    /// What the baker is given.
    pub(crate) fn baker(&self) -> ::bake::Options {
        ::bake::Options {
            effort: self.effort,
            points: PointSet::default(),
            footprint: self.footprint,
            denoise: self.denoises(),
            seams: self.seams,
            seed: self.seed,
            sky: self.sky.light.clone(),
            draw_sky: true,
            view: self.view,
            shading: self.shading,
            buried: self.buried,
            under: self.under,
            max_distance: self.max_distance,
            model: self.model.unwrap_or_default(),
            bounces: self.bounces,
            lights: self.lights.clone(),
            layers: self.layers.clone(),
            normal_maps: self.normal_maps,
            rings: atlas::RINGS.max(self.layout().gutter),
            ambient: self.ambient_coefficient,
            overrides: Overrides {
                albedo: self.albedo,
                specular: self.specular,
                exponent: self.exponent,
            },
            full_highlights: self.has_full_highlights(),
            switched_off: self.plan_off.clone(),
        }
    }

    /// True for layers that show the specular term by itself.
    pub(crate) fn shows_highlight(layer: Layer) -> bool {
        matches!(
            layer,
            Layer::Specular
                | Layer::StdErrSpecular
                | Layer::HalfSpecular
                | Layer::Reflection
                | Layer::StdErrReflection
                | Layer::HalfReflection
        )
    }

    /// True where the specular term was asked for by itself. [`Layer::STANDARD`] has it too, but there it stands beside
    /// what it is part of.
    fn has_full_highlights(&self) -> bool {
        let mut further = self
            .layers
            .iter()
            .filter(|&&layer| layer != Layer::Specular);
        self.full_highlights
            || self.exponent.is_some()
            || self.view != View::Normal
            || further.any(|&layer| Self::shows_highlight(layer))
    }

    /// What the layout is given.
    pub(crate) fn layout(&self) -> atlas::Options {
        atlas::Options {
            uv: match self.uv {
                Uv::Auto => atlas::UvMode::Auto,
                Uv::Keep => atlas::UvMode::Keep,
                Uv::Unwrap => atlas::UvMode::Unwrap,
            },
            page_size: self.size,
            density: self.density,
            even: self.even_density,
            cut_hidden: self.seen_from_within,
            density_of: self.density_of.clone(),
            include: self.include.clone(),
            exclude: self.exclude.clone(),
            pages: self.pages,
            one_page_per_mesh: self.one_page_per_mesh,
            gutter: atlas::gutter::needed(self.gutter, self.mips, self.align),
        }
    }
}
