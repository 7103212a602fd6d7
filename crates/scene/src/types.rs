//! The plain data of a scene: what `load` returns and every later stage reads.
//!
//! Nothing here is derived: positions are as the file gave them (in mesh space), transforms are composed node
//! transforms, materials are mapped to the Phong model's parameters. Invariants that [`crate::load`] guarantees: every
//! index is in range, every number is finite, every triangle has a non-zero area in mesh space, images are decoded.

use crate::{GltfDocument, NormalMap, PackedImage, Warning};
use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;

/// A whole scene, validated. The default is empty, from no file.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// The file that was loaded; `scene` for one built in memory, whose files take their stem from it.
    pub path: PathBuf,
    /// What kind of file it was, if any.
    pub format: Format,
    /// Distinct triangle meshes, each with one material.
    pub meshes: Vec<Mesh>,
    /// Placements of meshes in the world: the *objects* of a bake. Order is the file's order.
    pub instances: Vec<Instance>,
    /// Materials; [`Mesh::material`] indexes here. Never empty: a file without any gets one default.
    pub materials: Vec<Material>,
    /// Decoded images; [`TextureRef::image`] indexes here.
    pub images: Vec<Image>,
    /// Images that are decoded only where they are asked for; [`NormalMap::texture`] indexes here.
    pub packed_images: Vec<PackedImage>,
    /// Lights without extent (glTF `KHR_lights_punctual`) that stand in the scene.
    pub lights: Vec<Light>,
    /// Everything that was repaired or ignored while loading, counted.
    pub warnings: Vec<Warning>,
    /// Blake3 hash, in hex, of all the bytes read for this scene (the file, its buffers, images and material files), or
    /// of all that was handed over for a built one. Images that only `source` holds are not part of it.
    pub content_hash: String,
    /// The whole glTF document for the writer to patch; `None` for OBJ and for scenes built in memory.
    pub source: Option<Arc<GltfDocument>>,
    /// Every file that the scene was read from, the main one first; empty for scenes built in memory.
    pub inputs: Vec<PathBuf>,
}

/// Where a scene comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Wavefront OBJ with MTL.
    Obj,
    /// glTF 2.0 as JSON.
    Gltf,
    /// glTF 2.0 binary container.
    Glb,
    /// No file: [`Scene::from_meshes`].
    #[default]
    Memory,
}

/// Triangles that share one vertex array and one material: a glTF primitive, an OBJ group's part with one material, or
/// a mesh handed over in memory. The default has no triangle.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Name for messages: the file's, else `mesh 3 primitive 0`.
    pub name: String,
    /// Vertex positions in mesh space. For glTF the vertex numbers are the file's, unless the primitive uses a small
    /// part of a large shared array (see `vendor-notes/gltf.md`): then they are ranks among the numbers it uses.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one a vertex; empty where the file has none (shade with the geometric normal).
    pub normals: Vec<Vec3>,
    /// Unit tangents along u of the normal map, one a vertex, `w` the side of the bitangent `w (normal x tangent)`:
    /// glTF `TANGENT`; empty where the file has none.
    pub tangents: Vec<Vec4>,
    /// Vertex colours (glTF `COLOR_0`, OBJ `v x y z r g b`), linear, 0..=1 a channel, one a vertex; they multiply the
    /// material's base colour or diffuse reflectance. Empty for white everywhere.
    pub colors: Vec<Vec3>,
    /// Alpha of the vertex colours (glTF `COLOR_0`), one a vertex; it multiplies the material's. Empty for 1
    /// everywhere.
    pub alphas: Vec<f32>,
    /// UV sets in the file's order (TEXCOORD_0, TEXCOORD_1, …), glTF orientation (v grows down), one a vertex each.
    /// OBJ's v is flipped on load.
    pub uv_sets: Vec<Vec<Vec2>>,
    /// Vertex indices; counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle, its number in the file's primitive (before zero-area triangles were dropped); empty where
    /// nothing was dropped, so the numbers are equal.
    pub source_triangles: Vec<u32>,
    /// For each vertex, its number in the file's arrays; empty where the arrays were loaded whole, so the numbers are
    /// equal.
    pub source_vertices: Vec<u32>,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Where it stands in a glTF file.
    pub origin: MeshOrigin,
}

/// The place of a mesh in its file. For OBJ `mesh` counts the loaded parts, for a built scene the meshes handed over,
/// and `primitive` is 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct MeshOrigin {
    /// glTF mesh index.
    pub mesh: u32,
    /// glTF primitive index within the mesh.
    pub primitive: u32,
}

/// One mesh placed in the world: an object.
#[derive(Debug, Clone)]
pub struct Instance {
    /// Node name and mesh name, for messages.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Mesh space to world space, composed in f64 over the node hierarchy; invertible.
    pub transform: DAffine3,
    /// glTF node index; 0 without glTF.
    pub node: u32,
    /// Which copy of the node's mesh this is under `EXT_mesh_gpu_instancing`; `None` without it.
    pub copy: Option<u32>,
    /// It blocks light. What does not is met by no ray, buries nothing and sends nothing; it takes texels like the
    /// others.
    pub casts: bool,
    /// What lies inside of other bodies or is hidden behind them is baked like the rest of it; `None` leaves that to
    /// the bake.
    pub keeps_buried: Option<bool>,
    /// Texels per scene unit that the file asks for, above 0.
    pub density: Option<f64>,
    /// It takes texels; what does not only blocks light.
    pub bakes: bool,
}

impl Instance {
    /// A mesh at a place, of which nothing else is said: it blocks light and takes texels.
    pub fn new(name: impl Into<String>, mesh: u32, transform: DAffine3) -> Self {
        Self {
            name: name.into(),
            mesh,
            transform,
            node: 0,
            copy: None,
            casts: true,
            keeps_buried: None,
            density: None,
            bakes: true,
        }
    }
}

/// A light without extent, as the file has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// The file's name for it, else its node's, else `light 3`.
    pub name: String,
    /// How it shines.
    pub kind: LightKind,
    /// Colour times intensity, linear RGB: lux where it is directional, else candela.
    pub strength: DVec3,
    /// Distance from which on it lights nothing; infinite for none.
    pub range: f64,
    /// World position.
    pub position: DVec3,
    /// Unit vector along which it shines.
    pub direction: DVec3,
}

/// How a [`Light`] shines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightKind {
    /// From so far away that its rays are parallel.
    Directional,
    /// From its place in all directions.
    Point,
    /// From its place into a cone.
    Spot {
        /// Angle from the axis within which it has all of its light, radians.
        inner: f64,
        /// Angle from which on it has none, at most a right one.
        outer: f64,
    },
}

/// Parameters of the Phong model, from MTL directly or mapped from metallic-roughness (see `material.rs`).
#[derive(Debug, Clone)]
pub struct Material {
    /// The file's name, else `material 3`.
    pub name: String,
    /// Surface colour model.
    pub surface: MaterialModel,
    /// k_a of the traditional ambient term, linear, 0..=1 a channel (OBJ `Ka`); `None` where the file gives none.
    pub ambient: Option<Vec3>,
    /// Radiance that the surface sends out by itself, linear (OBJ `Ke`; glTF `emissiveFactor` times its strength).
    pub emission: Vec3,
    /// Colour texture that multiplies `emission` (glTF `emissiveTexture`).
    pub emission_map: Option<TextureRef>,
    /// How alpha lets rays pass.
    pub alpha: Alpha,
    /// What passes straight through where alpha stops a ray; `None` for nothing.
    pub transmission: Option<Transmission>,
    /// What bends the shading normal, where a bake asks for it.
    pub normal_map: Option<NormalMap>,
    /// Both sides are visible surfaces (glTF `doubleSided`; OBJ is always double sided). Occluders always are.
    pub double_sided: bool,
}

/// Where albedo, specular and exponent come from.
#[derive(Debug, Clone)]
pub enum MaterialModel {
    /// The Phong model itself (OBJ: Kd, Ks, Ns, map_Kd). Albedo and specular add up to at most 1 in every channel.
    Phong {
        /// Diffuse reflectance, linear, 0..=1 a channel.
        albedo: Vec3,
        /// Colour texture that multiplies `albedo` (sRGB in the file, linear in [`Image`]).
        albedo_map: Option<TextureRef>,
        /// Specular reflectance, linear, 0..=1 a channel.
        specular: Vec3,
        /// Lobe exponent n, finite and >= 0.
        exponent: f64,
    },
    /// glTF metallic-roughness, mapped per texel by [`crate::phong_from_metallic_roughness`].
    MetallicRoughness {
        /// `baseColorFactor`, linear RGB.
        base: Vec3,
        /// `baseColorTexture`.
        base_map: Option<TextureRef>,
        /// `metallicFactor`.
        metallic: f64,
        /// `roughnessFactor`.
        roughness: f64,
        /// Metallic in blue, roughness in green, linear.
        metallic_roughness_map: Option<TextureRef>,
        /// Reflectance of a dielectric at normal view (0.04, or from KHR_materials_ior and KHR_materials_specular).
        dielectric: Vec3,
    },
    /// glTF specular-glossiness (KHR_materials_pbrSpecularGlossiness), mapped per texel by
    /// [`crate::phong_from_specular_glossiness`].
    SpecularGlossiness {
        /// `diffuseFactor`, linear RGB.
        diffuse: Vec3,
        /// `diffuseTexture`.
        diffuse_map: Option<TextureRef>,
        /// `specularFactor`, linear RGB.
        specular: Vec3,
        /// `glossinessFactor`.
        glossiness: f64,
        /// `specularGlossinessTexture`: specular colour in sRGB, glossiness in alpha.
        specular_glossiness_map: Option<TextureRef>,
    },
}

impl MaterialModel {
    /// The textures that decide what the surface reflects.
    pub fn textures(&self) -> impl Iterator<Item = &TextureRef> {
        let maps = match self {
            MaterialModel::Phong { albedo_map, .. } => [albedo_map, &None],
            MaterialModel::MetallicRoughness {
                base_map,
                metallic_roughness_map,
                ..
            } => [base_map, metallic_roughness_map],
            MaterialModel::SpecularGlossiness {
                diffuse_map,
                specular_glossiness_map,
                ..
            } => [diffuse_map, specular_glossiness_map],
        };
        maps.into_iter().flatten()
    }
}

impl Material {
    /// A white, opaque Lambertian surface, so that the baked terms carry no tint: what a mesh without a material gets.
    ///
    /// glTF's own default (white, metallic 1, roughness 1) would make every unassigned mesh a rough metal with a black
    /// albedo: of no use for a lightmap, whose geometry is what the file is about. OBJ defines no default.
    pub fn untinted(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            surface: MaterialModel::Phong {
                albedo: Vec3::ONE,
                albedo_map: None,
                specular: Vec3::ZERO,
                exponent: 0.0,
            },
            ambient: None,
            emission: Vec3::ZERO,
            emission_map: None,
            alpha: Alpha::Opaque,
            transmission: None,
            normal_map: None,
            double_sided: true,
        }
    }

    /// Blocks every ray.
    pub fn is_opaque(&self) -> bool {
        matches!(self.alpha, Alpha::Opaque) && self.transmission.is_none()
    }

    /// Every texture that decides what the surface reflects, sends out or lets through.
    pub fn textures(&self) -> impl Iterator<Item = &TextureRef> {
        let alpha = match &self.alpha {
            Alpha::Opaque => &None,
            Alpha::Mask { map, .. } | Alpha::Blend { map, .. } => map,
        };
        let transmission = self.transmission.as_ref().and_then(|t| t.map.as_ref());
        let maps = [alpha, &self.emission_map].into_iter().flatten();
        self.surface.textures().chain(maps).chain(transmission)
    }
}

/// Light that goes straight through a surface, as through a window (`KHR_materials_transmission`).
///
/// The share is `factor * red(map)` of what is no metal, tinted by the base colour. The surface scatters that much
/// less.
#[derive(Debug, Clone)]
pub struct Transmission {
    /// Share of the light, 0..=1.
    pub factor: f32,
    /// Red of this texture multiplies `factor`.
    pub map: Option<TextureRef>,
}

/// How alpha lets rays pass.
#[derive(Debug, Clone)]
pub enum Alpha {
    /// Blocks every ray.
    Opaque,
    /// Blocks a ray where `factor * alpha(map) >= cutoff` (glTF MASK; OBJ `map_d` with cutoff 0.5).
    Mask {
        /// The threshold.
        cutoff: f32,
        /// Constant alpha.
        factor: f32,
        /// Alpha channel of this texture multiplies `factor`.
        map: Option<TextureRef>,
    },
    /// Blocks the share `factor * alpha(map)` of the rays that meet it (glTF BLEND; OBJ `d` and `Tr` below 1).
    Blend {
        /// Constant alpha.
        factor: f32,
        /// Alpha channel of this texture multiplies `factor`.
        map: Option<TextureRef>,
    },
}

/// A use of an image.
#[derive(Debug, Clone)]
pub struct TextureRef {
    /// Index into [`Scene::images`].
    pub image: u32,
    /// Which of [`Mesh::uv_sets`] it reads.
    pub uv_set: u32,
    /// Wrap rule in u and v.
    pub wrap: [Wrap; 2],
    /// Bilinear (true) or nearest (false) look-up.
    pub linear: bool,
    /// KHR_texture_transform as a matrix: `uv' = transform * (u, v, 1)`, rows first.
    pub transform: [[f32; 3]; 2],
}

impl TextureRef {
    /// All of an image by the first UV set, repeated and bilinear.
    pub fn new(image: u32) -> Self {
        Self {
            image,
            uv_set: 0,
            wrap: [Wrap::Repeat; 2],
            linear: true,
            transform: UNMOVED,
        }
    }
}

/// [`TextureRef::transform`] that leaves coordinates as they are.
pub(crate) const UNMOVED: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Texture wrap rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrap {
    /// Repeat.
    Repeat,
    /// Clamp to the edge.
    Clamp,
    /// Repeat, mirrored.
    Mirror,
}

/// A decoded 8-bit image, RGBA, row 0 on top, as stored in the file (colour still in its own transfer function).
#[derive(Debug, Clone)]
pub struct Image {
    /// Name for messages.
    pub name: String,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` RGBA pixels.
    pub pixels: Vec<[u8; 4]>,
}
