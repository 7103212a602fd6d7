//! The options of a bake, set one by one, and its start.

mod prepare;

use crate::job::Made;
use crate::layout::Layout;
use crate::memory::Limit;
use crate::options::{Backend, Effort, Options, Pages, Uv};
use crate::scene::Scene;
use crate::sky::Sky;
use ::bake::{
    AmbientCoefficient, Bounces, Buried, Choice, Denoise, Footprint, Model, Seams, Shading, View,
};
use environment::Up;
use layers::Layer;
use rays::{Light, RayBackend, World};
use report::Engine;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// Setters of options of the same name: what they say, and `Some` where the option may be absent.
macro_rules! setters {
    ($($(#[$doc:meta])* $name:ident($value:ident: $kind:ty) $($some:ident)?;)*) => {$(
        $(#[$doc])*
        pub fn $name(mut self, $value: $kind) -> Self {
            self.options.$name = $($some)?($value);
            self
        }
    )*};
}

/// A bake of a scene, not yet started. The options are named as the flags of the command line; each has the default of
/// its flag.
///
/// ```
/// # fn main() -> Result<(), ambake::Error> {
/// # let scene = ambake::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/wall_long.obj"))?;
/// use ambake::{Bake, Layer};
/// let baked = Bake::new(&scene)
///     .size(64)
///     .rays(16)
///     .sky([0.4, 0.6, 1.0])
///     .layers([Layer::Bent, Layer::Irradiance])
///     .run(&())?;
/// assert_eq!(baked.page(0).size(), 64);
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct Bake {
    scene: Scene,
    options: Options,
    made: Made,
    threads: Option<usize>,
    layout: Option<Layout>,
    layout_file: Option<PathBuf>,
    update: Option<PathBuf>,
    verify: bool,
    limit: Limit,
}

impl fmt::Debug for Bake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bake")
            .field("scene", &self.scene.path)
            .field("options", &self.options)
            .field("backend", &self.made.0)
            .field("threads", &self.threads)
            .finish_non_exhaustive()
    }
}

impl Bake {
    /// The default bake of the scene: 1024² texels a page, 256 rays a texel, denoised, a white sky.
    pub fn new(scene: &Scene) -> Self {
        Self {
            scene: scene.clone(),
            options: Options::default(),
            made: (Backend::best(), None),
            threads: None,
            layout: None,
            layout_file: None,
            update: None,
            verify: false,
            limit: Limit::default(),
        }
    }

    /// All options at once.
    pub fn options(mut self, options: Options) -> Self {
        self.options = options;
        self
    }

    setters! {
        /// Page edge in texels, 1..=16384; 1024 by default.
        size(texels: u32);

        /// Texels per scene unit of every object, above 0; pages are added as needed. By default the texels of one page
        /// are shared by a rule that no large plane can ruin.
        density(texels_per_unit: f64) Some;

        /// How many pages there are: by default one, and more where a density needs them or the charts do not fit.
        pages(pages: Pages);

        /// Makes it an error if a mesh does not fit on one page. By default its charts are then spread over several.
        one_page_per_mesh(together: bool);

        /// Lightmap coordinates: keep the file's, unwrap, or keep them where they are usable.
        uv(uv: Uv);

        /// Texels that stay empty around every chart that is packed, at most 128; 2 by default.
        gutter(texels: u32);

        /// Mip levels on which no look-up mixes packed charts, at most 6; 0 by default.
        mips(levels: u32);

        /// Edge in texels of the blocks that never hold texels of two packed charts, 1..=16; 1, for none, by default.
        align(texels: u32);

        /// Where the samples of a texel lie; all over its area by default.
        footprint(footprint: Footprint);

        /// How integrated terms are denoised; by regression by default, but for one ray a texel.
        denoise(denoise: Denoise) Some;

        /// Between which charts a bilinear look-up is made to agree across the edge that they share; those of any
        /// objects by default.
        seams(seams: Seams);

        /// Where the eye of the specular term stands: by default on every texel's normal.
        view(view: View);

        /// What happens to samples inside of solids; dropped by default.
        buried(buried: Buried);

        /// What smooth shading sees between the horizon of a shading normal and the plane of its facet; production by
        /// default.
        shading(shading: Shading);

        /// A thin layer at most so many scene units above a surface (paper on a desk, a decal, a rug) takes no light
        /// from it, so that no dark line is seen around it; 0 for none. By default an eighth of a texel. It fades out
        /// up to twice as far.
        under(distance: f64) Some;

        /// Occluders farther than this many scene units do not count; by default there is no limit.
        max_distance(distance: f32) Some;

        /// The axis of the scene that points upward, y by default: a sky that is a map stands upright on it, and so
        /// does the first picture. Coordinates and directions stay the scene's.
        up(up: Up);

        /// What the highlight is: the paper's Phong lobe, or GGX, whose layer then stands in place of [`Layer::Phong`].
        /// By default GGX for glTF and for metallic-roughness materials in memory, and Phong for other scenes, unless
        /// layers or an exponent ask for one of them ([`Options::model`]).
        model(model: Model) Some;

        /// How often surfaces send on the light that they receive; never by default.
        bounces(bounces: Bounces);

        /// Whether the lights of the scene's file are baked (glTF `KHR_lights_punctual`): lux and candela count as
        /// W·m⁻² and W·sr⁻¹.
        file_lights(on: bool) Some;

        /// Whether normal maps of materials bend the shading normals; not by default.
        normal_maps(on: bool);

        /// Lobe exponent of every material, 0..=1e6.
        exponent(exponent: f64) Some;

        /// k_a, by which the layer `traditional` reflects ambient light; the albedo by default. Each channel of a
        /// colour is from 0 to 1e6.
        ambient_coefficient(coefficient: AmbientCoefficient);

        /// Diffuse reflectance of every material, linear RGB, each channel 0 or above.
        albedo(rgb: [f32; 3]) Some;

        /// Specular reflectance of every material, linear RGB, each channel 0 or above.
        specular(rgb: [f32; 3]) Some;

        /// Seed of the sample points; 0 by default. The same scene, options and seed give the same bytes at any number
        /// of threads.
        seed(seed: u64);

        /// Makes lightmaps and occlusion of the engines that read such in blocks of 4 x 4 texels: BC6H, in place of
        /// uncompressed KTX2, and BC7. Three and Bevy do; pages must be a multiple of 4 wide. Off by default.
        compress(compress: bool);
    }

    /// Texels per scene unit, above 0, of the objects that `name` fits; `*` and `?` are wildcards. Later calls win.
    pub fn density_of(mut self, name: impl Into<String>, texels_per_unit: f64) -> Self {
        self.options.density_of.push((name.into(), texels_per_unit));
        self
    }

    /// One density for all objects, the largest that fits the pages, but for those with one of their own.
    pub fn even_density(mut self) -> Self {
        self.options.even_density = true;
        self
    }

    /// Only objects that one of these names fits take texels; `*` and `?` are wildcards. The others still occlude.
    pub fn include(mut self, name: impl Into<String>) -> Self {
        self.options.include.push(name.into());
        self
    }

    /// Objects that one of these names fits take no texels; `*` and `?` are wildcards. They still occlude.
    pub fn exclude(mut self, name: impl Into<String>) -> Self {
        self.options.exclude.push(name.into());
        self
    }

    /// The objects with this name, which may have wildcards, block no light: no ray meets them and nothing counts as
    /// buried in them.
    /// They take texels.
    pub fn no_cast(mut self, name: impl Into<String>) -> Self {
        self.options.no_cast.push(name.into());
        self
    }

    /// What happens to samples that are buried, of the objects with this name, which may have wildcards; later ones
    /// win.
    pub fn buried_of(mut self, name: impl Into<String>, buried: Buried) -> Self {
        self.options.buried_of.push((name.into(), buried));
        self
    }

    /// Charts that can be seen from none of these points, in scene units, take one texel; their texels go to the
    /// others.
    pub fn seen_from(mut self, eyes: impl IntoIterator<Item = [f64; 3]>) -> Self {
        self.options.seen_from.extend(eyes);
        self
    }

    /// Charts on the outsides of a scene of rooms, which nobody within sees, take one texel; their texels go to
    /// the others.
    pub fn seen_from_within(mut self) -> Self {
        self.options.seen_from_within = true;
        self
    }

    /// Rays per texel over the hemisphere, at least 1; a highlight takes what it is worth beside them
    /// ([`Options::full_highlights`]).
    pub fn rays(mut self, rays: u32) -> Self {
        self.options.effort = Effort::Rays(rays);
        self
    }

    /// Takes the rays by which the root mean square of a page's standard errors is at most `std_err`, above 0 and below
    /// 1, tile by tile, instead of a fixed number.
    pub fn target_error(mut self, std_err: f64) -> Self {
        let (relative, max_rays) = match self.options.effort {
            Effort::Target {
                relative, max_rays, ..
            } => (relative, max_rays),
            Effort::Rays(_) => (0.0, 16_384),
        };
        self.options.effort = Effort::Target {
            error: std_err,
            relative,
            max_rays,
        };
        self
    }

    /// With [`Bake::target_error`], set before: an error of `share` of the value counts as one of the target, where
    /// that is more; at least 0 and below 1, 0 by default.
    pub fn target_relative(mut self, share: f64) -> Self {
        if let Effort::Target { relative, .. } = &mut self.options.effort {
            *relative = share;
        }
        self
    }

    /// With [`Bake::target_error`], set before: the most rays that a texel may take, at least 16; 16,384 by default.
    pub fn max_rays(mut self, rays: u32) -> Self {
        if let Effort::Target { max_rays, .. } = &mut self.options.effort {
            *max_rays = rays;
        }
        self
    }

    /// The sky: a uniform radiance `[r, g, b]`, or an illumination map from [`Sky::load`]. White by default.
    pub fn sky(mut self, sky: impl Into<Sky>) -> Self {
        self.options.sky = sky.into();
        self
    }

    /// One more light: a sun, a point light, a spot, a ball or a panel, in scene units. Its light arrives
    /// straight, with shadows; with [`Bake::bounces`] surfaces send it on.
    pub fn light(mut self, light: Light) -> Self {
        self.options.lights.push(light);
        self
    }

    /// Layers on top of those that are produced so far; by default [`Layer::STANDARD`].
    pub fn layers(mut self, layers: impl IntoIterator<Item = Layer>) -> Self {
        self.add_layers(layers);
        self
    }

    /// Exactly these layers and the coverage; terms that none of them needs are not computed.
    pub fn only(mut self, layers: impl IntoIterator<Item = Layer>) -> Self {
        self.options.layers = vec![Layer::Coverage];
        self.add_layers(layers);
        self
    }

    fn add_layers(&mut self, layers: impl IntoIterator<Item = Layer>) {
        for layer in layers {
            if layer == Layer::Phong {
                // It is among those that every bake has, but this one is asked for by name.
                self.options.model.get_or_insert(Model::Phong);
            }
            // Likewise: who asks for the term itself wants it as exact as the others.
            self.options.full_highlights |= Options::shows_highlight(layer);
            if !self.options.layers.contains(&layer) {
                self.options.layers.push(layer);
            }
        }
    }

    /// Planner choices that are switched off: what they would leave out is modelled all the same.
    pub fn plan_off(mut self, choices: impl IntoIterator<Item = Choice>) -> Self {
        self.options.plan_off = choices.into_iter().collect();
        self
    }

    /// Files for these engines beside the others: the flag `--for`. None by default.
    pub fn for_engines(mut self, engines: impl IntoIterator<Item = Engine>) -> Self {
        for engine in engines {
            if !self.options.engines.contains(&engine) {
                self.options.engines.push(engine);
            }
        }
        self
    }

    /// Also writes `STEM.vertices.glb`: the scene with the layer `diffuse` as vertex colours, by area-weighted least
    /// squares over the texels ([`crate::Baked::vertex_values`]), times the colours of the file. Off by default.
    pub fn to_vertices(mut self, vertices: bool) -> Self {
        self.options.vertices = vertices;
        self
    }

    /// Which library answers rays; by default Embree where it is built in.
    pub fn backend(mut self, backend: Backend) -> Self {
        self.made = (backend, None);
        self
    }

    /// A ray backend of your own, made over the world that the plan builds. `examples/custom_backend.rs` shows one.
    pub fn with_backend(
        mut self,
        make: impl Fn(&World) -> Result<Box<dyn RayBackend>, rays::Error> + Send + Sync + 'static,
    ) -> Self {
        self.made.1 = Some(Arc::new(make));
        self
    }

    /// Worker threads, at least 1. By default the bake runs in the rayon pool that calls it.
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads);
        self
    }

    /// A layout that [`Bake::lay_out`] made of this scene with the options that decide a layout; [`Bake::prepare`]
    /// refuses another. To bake it again see [`Bake::prepare_on`], which keeps the ray scene too.
    pub fn layout(mut self, layout: Layout) -> Self {
        self.layout = Some(layout);
        self
    }

    /// A file that [`Layout::write`](crate::Layout::write) made: its layout is taken where the file exists and is of
    /// this scene and these options. It is what would be made anew.
    pub fn layout_file(mut self, path: impl Into<PathBuf>) -> Self {
        self.layout_file = Some(path.into());
        self
    }

    /// The folder of an earlier bake of this scene, before it changed: charts of what is the same keep their places,
    /// and texels that no change can reach keep their values. The result is that of a whole bake with that layout, bit
    /// for bit. Where another version, options or ray library baked it, all is baked, and `bake.json` says why. The
    /// earlier bake must be one that [`Job::run_into`](crate::Job::run_into) or the program wrote:
    /// [`Baked::write`](crate::Baked::write) no longer has the tiles as they were before whole pages were finished.
    pub fn update(mut self, dir: impl Into<PathBuf>) -> Self {
        self.update = Some(dir.into());
        self
    }

    /// With [`Bake::update`]: bakes one in a hundred of the kept tiles again; where a bit differs, the bake fails.
    pub fn verify(mut self, on: bool) -> Self {
        self.verify = on;
        self
    }

    /// Bytes of memory that the bake may take: [`Bake::prepare`] refuses one that would take more.
    pub fn max_memory(mut self, bytes: u64) -> Self {
        self.limit.given = Some(bytes);
        self
    }

    /// Where no memory is given, [`Bake::prepare`] refuses a bake that would take more than the system has.
    pub fn within_memory(mut self) -> Self {
        self.limit.system = true;
        self
    }

    /// Only [`Job::run_shard`](crate::Job::run_shard) will be called: no memory is needed for pages.
    pub fn in_parts(mut self) -> Self {
        self.limit.without_pages = true;
        self
    }
}
