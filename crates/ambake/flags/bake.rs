//! The flags of a bake. Their names, help, ranges and defaults stand here alone: the command line, `ambake.toml`,
//! Python's keyword arguments and the table of docs/flags.md are read from them.

use super::common::{Common, Shining};
use super::parse::{at_least_zero, color, exponent, positive, whole};
use super::sky::{SkyArg, sky};
use super::values::{
    Density, Eyes, bounces, buried_of, choice, coefficient, density, density_of, either, engine,
    eyes, layer, memory, pages, target_error, view, word,
};
use crate::bake::Bake;
use crate::error::Error;
use crate::options::{Backend, Effort, Options, Pages, Uv};
use crate::scene::Scene;
use ::bake::{
    AmbientCoefficient, Bounces, Buried, Choice, Denoise, Footprint, Model, Seams, Shading, View,
};
use clap::{ArgAction, Args};
use environment::Up;
use glam::DVec3;
use layers::Layer;
use report::Engine;
use std::path::PathBuf;

/// Files for engines.
#[derive(Args)]
pub struct Engines {
    /// Also write files for these engines, separated by commas: gltf, three, blender, bevy, godot, unity, unreal.
    /// `bake.json` says how each is used
    #[arg(help_heading = "Files")]
    #[arg(long = "for", value_name = "ENGINE,..", value_delimiter = ',', value_parser = engine)]
    pub engines: Vec<Engine>,
    /// Compress the lightmaps of three and bevy for the graphics processor, an eighth as large: BC6H in place of
    /// uncompressed KTX2, and occlusion as BC7
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long)]
    pub compress: bool,
}

/// An earlier bake.
#[derive(Args)]
pub struct Earlier {
    /// Start from the finished bake in OLD of an earlier version of the scene: only texels that the change can reach
    /// are baked, all others keep their values bit for bit, and charts keep their places. OLD is only read, and it may
    /// be DIR itself
    #[arg(help_heading = "Runs")]
    #[arg(long, value_name = "OLD")]
    pub update: Option<PathBuf>,
    /// With --update: bake one in a hundred of the kept texels again; a bit that differs is an error
    #[arg(help_heading = "Runs", hide_short_help = true)]
    #[arg(long, requires = "update")]
    pub verify: bool,
}

/// What decides the values of a bake.
#[derive(Clone, Args)]
pub struct Job {
    /// Page edge in texels
    #[arg(help_heading = "Texels")]
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = whole::<u32>(1..=16384))]
    pub size: u32,
    /// Texels per scene unit of every object, for which pages are added as needed; `even` is one for all, the
    /// largest that fits the pages [default: one page, shared so that no large object ruins the rest]
    #[arg(help_heading = "Texels")]
    #[arg(long, value_name = "D|even", value_parser = density)]
    pub density: Option<Density>,
    /// Texels per scene unit of the objects with this name; * and ? are wildcards, and the flag may be repeated
    #[arg(help_heading = "Texels", hide_short_help = true)]
    #[arg(long, value_name = "NAME=D", value_parser = density_of)]
    pub density_of: Vec<(String, f64)>,
    /// Axis of the scene that points upward: glTF has y there, and OBJ files may have z. The sky of a file and the
    /// first picture stand upright on it; coordinates that are typed stay those of the scene
    #[arg(help_heading = "Input", hide_short_help = true)]
    #[arg(long, default_value = "y", value_parser = word::<Up>())]
    pub up: Up,
    /// Only objects with this name take texels, the others still occlude; * and ? are wildcards, and the flag may be
    /// repeated
    #[arg(help_heading = "Input")]
    #[arg(long, value_name = "NAME")]
    pub include: Vec<String>,
    /// Objects with this name take no texels, but still occlude; * and ? are wildcards, and the flag may be repeated
    #[arg(help_heading = "Input")]
    #[arg(long, value_name = "NAME")]
    pub exclude: Vec<String>,
    /// Objects with this name block no light, such as decals, water or a sky dome: no ray meets them. They take texels,
    /// unless --exclude
    /// names them; * and ? are wildcards, and the flag may be repeated
    #[arg(help_heading = "Input", hide_short_help = true)]
    #[arg(long, value_name = "NAME")]
    pub no_cast: Vec<String>,
    /// Eye points in scene units, and boxes between two corners, separated by semicolons: charts that none of them sees
    /// take one texel; `auto` finds the outsides of rooms, which nobody within sees
    #[arg(help_heading = "Texels", hide_short_help = true)]
    #[arg(
        long,
        value_name = "auto|X,Y,Z[:X,Y,Z][;..]",
        allow_hyphen_values = true,
        value_delimiter = ';'
    )]
    #[arg(value_parser = eyes)]
    pub seen_from: Vec<Eyes>,
    /// Pages of --size: auto takes one, and more where a density needs them, where the charts do not fit, or where an
    /// object would have fewer texels across than a 256th of the page's edge; a number is the most
    #[arg(help_heading = "Texels")]
    #[arg(long, value_name = "auto|N", default_value = "auto", value_parser = pages)]
    pub pages: Pages,
    /// A mesh that does not fit on one page is an error; otherwise its charts are then spread over several
    #[arg(help_heading = "Texels", hide_short_help = true)]
    #[arg(long)]
    pub one_page_per_mesh: bool,
    /// Rays per texel over the hemisphere, up to a quarter more where little of the sky is seen; a highlight takes what
    /// it is worth beside them, or as many where it is asked for itself
    #[arg(help_heading = "Rays")]
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = whole::<u32>(1..=16_777_216))]
    pub rays: u32,
    /// Instead of a fixed number: the rays by which the root mean square of a page's standard errors is at most E, tile
    /// by tile, after denoising and before seams move texels
    #[arg(help_heading = "Rays")]
    #[arg(long, value_name = "E", value_parser = target_error, conflicts_with = "rays")]
    pub target_error: Option<f64>,
    /// With --target-error: an error of R times the value counts as one of E, where that is more than E
    #[arg(help_heading = "Rays", hide_short_help = true)]
    #[arg(long, value_name = "R", value_parser = target_error, requires = "target_error", conflicts_with = "rays")]
    pub target_relative: Option<f64>,
    /// With --target-error: the most rays that a texel may take over the hemisphere
    #[arg(help_heading = "Rays", hide_short_help = true)]
    #[arg(
        long,
        value_name = "N",
        default_value_t = 16_384,
        requires = "target_error",
        conflicts_with = "rays"
    )]
    #[arg(value_parser = whole::<u32>(16..=16_777_216))]
    pub max_rays: u32,
    /// Where the samples of a texel lie: all over the part that charts cover, or at its point nearest to the texel's
    /// centre, to compare with programs that sample centres
    #[arg(long, hide = true, default_value = "texel", value_parser = word::<Footprint>())]
    pub footprint: Footprint,
    /// What takes the grain off. `regression` fits the texels of a surface and keeps the plain value where that does
    /// not help, at a small bias that the layer `error` includes; `oidn` is Intel Open Image Denoise where it is
    /// installed (docs/quality.md); `off` leaves the grain on [default: regression; off with --rays 1, which leaves no
    /// two halves to compare]
    #[arg(help_heading = "Rays")]
    #[arg(long, value_parser = word::<Denoise>(), alias = "filter")]
    pub denoise: Option<Denoise>,
    /// Between which charts a bilinear look-up is made to agree across the edge that they share: none, those of one
    /// object, or those of any objects that abut
    #[arg(help_heading = "Texels", hide_short_help = true)]
    #[arg(long, default_value = "scene", value_parser = word::<Seams>())]
    pub seams: Seams,
    /// Sky radiance, linear: R,G,B for a uniform sky, or an illumination map (.hdr, .exr; .png and .jpg as sRGB; polar
    /// unless its header says otherwise), from whose light as many rays again are drawn
    #[arg(help_heading = "Light")]
    #[arg(long, value_name = "R,G,B|FILE", default_value = "1,1,1", value_parser = sky)]
    pub sky: SkyArg,
    /// View of the specular term: `normal` (V = N everywhere) or an eye point X,Y,Z in scene units
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_name = "normal|X,Y,Z", default_value = "normal", allow_hyphen_values = true, value_parser = view)]
    pub view: View,
    /// What smooth shading sees between the horizon of its normal and the plane of the facet
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, default_value = "production", value_parser = word::<Shading>())]
    pub shading: Shading,
    /// What happens to samples inside of other solids, where nobody sees them
    #[arg(help_heading = "Texels", hide_short_help = true)]
    #[arg(long, default_value = "drop", value_parser = word::<Buried>())]
    pub buried: Buried,
    /// The same for the objects with this name; * and ? are wildcards, and the flag may be repeated
    #[arg(help_heading = "Texels", hide_short_help = true)]
    #[arg(long, value_name = "NAME=drop|keep", value_parser = buried_of)]
    pub buried_of: Vec<(String, Buried)>,
    /// A thin layer at most so many scene units above a surface, such as paper on a desk, a decal or a rug, takes no
    /// light from it, so that no dark line is seen around it; 0 for none [default: an eighth of a texel]
    #[arg(help_heading = "Texels", hide_short_help = true)]
    #[arg(long, value_name = "D", value_parser = at_least_zero)]
    pub under: Option<f64>,
    /// Occluders farther than this many scene units do not count [default: no limit]
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_name = "D", value_parser = positive)]
    pub max_distance: Option<f64>,
    /// What the highlight is: the paper's lobe about the mirrored view, or microfacets of the roughness that the
    /// exponent stands for; the layer `ggx` then stands in place of `phong` [default: what --layers, --only or
    /// --exponent ask for, else ggx for glTF and phong for OBJ]
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_parser = word::<Model>())]
    pub model: Option<Model>,
    /// How often surfaces send on the light that they receive: so many gathers, or auto until what is missing is less
    /// than the target error, or than half a step of 8 bits. Surfaces that shine join in
    #[arg(help_heading = "Light")]
    #[arg(long, value_name = "N|auto", default_value = "0", value_parser = bounces)]
    pub bounces: Bounces,
    /// Lights of the scene's file (glTF KHR_lights_punctual): bake them, lux as W/m² and candela as W/sr, or leave them
    /// out. Surfaces that shine are no such lights: where light bounces they send theirs, and --no-cast keeps one from
    /// it [default: none, and a line names them]
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_parser = either(["file", "none"], "file"))]
    pub lights: Option<bool>,
    #[command(flatten)]
    pub shining: Shining,
    /// Memory that the bake may take, such as 8G or 512M; one that would take more is refused before it starts
    /// [default: what the system has]
    #[arg(help_heading = "Machine", hide_short_help = true)]
    #[arg(long, value_name = "SIZE", value_parser = memory)]
    pub max_memory: Option<u64>,
    /// Ray library [default: embree where it is built in, else obvhs]
    #[arg(help_heading = "Machine", hide_short_help = true)]
    #[arg(long, value_parser = word::<Backend>())]
    pub backend: Option<Backend>,
    /// Lightmap coordinates: keep the file's, unwrap, or keep them where they are usable
    #[arg(help_heading = "Texels")]
    #[arg(long, default_value = "auto", value_parser = word::<Uv>())]
    pub uv: Uv,
    /// Texels kept empty around every chart that is packed: two charts are 2 N texels apart. All of them are filled
    #[arg(help_heading = "Texels", hide_short_help = true)]
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = whole::<u32>(0..=128))]
    pub gutter: u32,
    /// Mip levels of the page on which no bilinear, trilinear or bicubic look-up mixes packed charts: the gutter grows
    /// to 4, 9, 19, 39 texels for 1, 2, 3, 4 levels
    #[arg(help_heading = "Texels", hide_short_help = true)]
    #[arg(long, value_name = "L", default_value_t = 0, value_parser = whole::<u32>(0..=6))]
    pub mips: u32,
    /// Blocks of N x N texels never hold texels of two packed charts or their gutters, for compressed textures: 4 for
    /// BC, up to 12 for ASTC
    #[arg(help_heading = "Texels", hide_short_help = true)]
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1..=16))]
    pub align: u32,
    #[arg(help_heading = "Files")]
    #[arg(long, value_name = "A,B,C", value_delimiter = ',', value_parser = layer)]
    #[arg(help = "Further layers, separated by commas; --help lists them")]
    #[arg(long_help = layer_help("Further layers, separated by commas"))]
    pub layers: Vec<Layer>,
    /// Exactly these layers (coverage is always written); terms that none of them needs are not computed
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long, value_name = "A,B,C", value_delimiter = ',', value_parser = layer, conflicts_with = "layers")]
    pub only: Vec<Layer>,
    /// Where the diffuse term goes: to pages alone, or to vertices too: STEM.vertices.glb has it as vertex colours, for
    /// engines that take occlusion from there
    #[arg(help_heading = "Files", hide_short_help = true)]
    #[arg(long, action = ArgAction::Set, default_value = "pages")]
    #[arg(value_parser = either(["pages", "vertices"], "vertices"))]
    pub to: bool,
    /// Let normal maps of materials bend the shading normals: a texel gets the mean of the bent normals over it
    #[arg(help_heading = "Input", hide_short_help = true)]
    #[arg(long)]
    pub normal_maps: bool,
    /// Lobe exponent of every material, 0 to 1e6
    #[arg(help_heading = "Input", hide_short_help = true)]
    #[arg(long, value_name = "N", value_parser = exponent)]
    pub exponent: Option<f64>,
    /// By what the layer `traditional` reflects ambient light: one colour for all materials, linear, or `file`: the Ka
    /// of each material of an OBJ file [default: the albedo, as a Lambertian surface reflects ambient light]
    #[arg(help_heading = "Light", hide_short_help = true)]
    #[arg(long, value_name = "R,G,B|albedo|file", value_parser = coefficient)]
    pub ambient_coefficient: Option<AmbientCoefficient>,
    /// Diffuse reflectance of every material, linear, as R,G,B
    #[arg(help_heading = "Input", hide_short_help = true)]
    #[arg(long, value_name = "R,G,B", value_parser = color)]
    pub albedo: Option<[f32; 3]>,
    /// Specular reflectance of every material, linear, as R,G,B
    #[arg(help_heading = "Input", hide_short_help = true)]
    #[arg(long, value_name = "R,G,B", value_parser = color)]
    pub specular: Option<[f32; 3]>,
    /// Planner choices to switch off: sky, diffuse, visibility, specular, open, instances, alpha_test, bounces, lights
    #[arg(long, hide = true, value_name = "NAME,..", value_delimiter = ',', value_parser = choice)]
    pub plan_off: Vec<Choice>,
}

impl Job {
    /// The bake that was asked for.
    ///
    /// # Errors
    /// The sky's picture cannot be read.
    pub fn bake(&self, scene: &Scene, common: &Common) -> Result<Bake, Error> {
        let job = self.clone();
        let places = |eyes: &Eyes| match eyes {
            Eyes::Within => Vec::new(),
            Eyes::At(places) => places.clone(),
        };
        let options = Options {
            size: job.size,
            density: match job.density {
                Some(Density::Of(density)) => Some(density),
                _ => None,
            },
            even_density: job.density == Some(Density::Even),
            density_of: job.density_of,
            include: job.include,
            exclude: job.exclude,
            no_cast: job.no_cast,
            buried_of: job.buried_of,
            seen_from_within: job.seen_from.contains(&Eyes::Within),
            seen_from: job.seen_from.iter().flat_map(places).collect(),
            pages: job.pages,
            one_page_per_mesh: job.one_page_per_mesh,
            uv: job.uv,
            gutter: job.gutter,
            mips: job.mips,
            align: job.align,
            effort: match job.target_error {
                None => Effort::Rays(job.rays),
                Some(error) => Effort::Target {
                    error,
                    relative: job.target_relative.unwrap_or(0.0),
                    max_rays: job.max_rays,
                },
            },
            footprint: job.footprint,
            denoise: job.denoise,
            seams: job.seams,
            seed: common.seed,
            sky: job.sky.load()?,
            up: job.up,
            view: job.view,
            shading: job.shading,
            buried: job.buried,
            under: job.under,
            max_distance: job.max_distance.map(|d| d as f32),
            model: job.model,
            bounces: job.bounces,
            lights: job.shining.lights(DVec3::ZERO),
            file_lights: job.lights,
            normal_maps: job.normal_maps,
            ambient_coefficient: job.ambient_coefficient.unwrap_or_default(),
            albedo: job.albedo,
            specular: job.specular,
            exponent: job.exponent,
            plan_off: job.plan_off,
            vertices: job.to,
            ..Options::default()
        };
        let mut bake = Bake::new(scene)
            .options(options)
            .backend(job.backend.unwrap_or_else(Backend::best));
        if let Some(bytes) = job.max_memory {
            bake = bake.max_memory(bytes);
        }
        Ok(match job.only.is_empty() {
            true => bake.layers(job.layers),
            false => bake.only(job.only),
        })
    }
}

/// What `--layers` and `--only` take, for help.
fn layer_help(start: &str) -> String {
    let standard = |layer: &Layer| Layer::STANDARD.contains(layer);
    let further = Layer::all().filter(|layer| !standard(layer));
    let rows = further.map(|layer| format!("{} ({})", layer.name(), layer.help()));
    let names: Vec<_> = Layer::STANDARD.iter().map(|layer| layer.name()).collect();
    format!(
        "{start}: {}. Written by default: {}",
        rows.collect::<Vec<_>>().join(", "),
        names.join(", ")
    )
}
