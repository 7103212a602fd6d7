//! What a program hands over to have a scene without a file: see [`Scene::from_meshes`](crate::Scene::from_meshes) and
//! [`Scene::from_placements`](crate::Scene::from_placements).
//!
//! The types carry the names of their loaded counterparts, for they are what a caller calls a mesh and a material; a
//! [`Scene`](crate::Scene) holds the loaded ones.

mod build;
mod hash;
mod material;

use crate::input::short;

/// Triangles with one material, placed in the world.
///
/// Fields are assigned after `Mesh::default()`, which is empty, of material 0 and stands where its vertices say.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Mesh {
    /// Name of the object in messages, reports and written glTF; `mesh 3` where it is empty.
    pub name: String,
    /// Vertex positions. Units are the program's; y is up only where a sky map is used.
    pub positions: Vec<[f32; 3]>,
    /// Shading normals, one a vertex, of any length above 0; empty for flat shading by the geometric normals.
    pub normals: Vec<[f32; 3]>,
    /// Unit tangents along u of the normal texture, one a vertex, `w` the side of the bitangent `w (normal x tangent)`,
    /// as glTF's `TANGENT`; empty for those that follow from the UVs.
    pub tangents: Vec<[f32; 4]>,
    /// Texture coordinates, one a vertex, in glTF's orientation (v grows down); empty for none. The material's textures
    /// read them, and they are a candidate for the lightmap.
    pub uvs: Vec<[f32; 2]>,
    /// Coordinates made for a lightmap, one a vertex, in the same orientation; empty for none. They are the first
    /// candidate for it.
    pub lightmap_uvs: Vec<[f32; 2]>,
    /// Linear RGB and alpha, 0..=1, one a vertex, that multiply the material's albedo and alpha; empty for white.
    pub colors: Vec<[f32; 4]>,
    /// Vertex numbers, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Number of the material in the list that is handed over with the meshes.
    pub material: usize,
    /// Mesh space to world space, column by column as in glTF: the last column is the translation, the last row is
    /// 0 0 0 1.
    pub transform: [[f32; 4]; 4],
}

/// One place at which a mesh stands.
///
/// Fields are assigned after `Placement::default()`, which places mesh 0 where its own transform says.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Placement {
    /// Name of the object in messages, reports and written glTF; the mesh's where it is empty.
    pub name: String,
    /// Number of the mesh in the list that is handed over.
    pub mesh: usize,
    /// Where it stands, column by column as [`Mesh::transform`], which comes before it.
    pub transform: [[f32; 4]; 4],
}

impl Default for Placement {
    fn default() -> Placement {
        Placement {
            name: String::new(),
            mesh: 0,
            transform: glam::Mat4::IDENTITY.to_cols_array_2d(),
        }
    }
}

impl Default for Mesh {
    fn default() -> Mesh {
        Mesh {
            name: String::new(),
            positions: Vec::new(),
            normals: Vec::new(),
            tangents: Vec::new(),
            uvs: Vec::new(),
            lightmap_uvs: Vec::new(),
            colors: Vec::new(),
            triangles: Vec::new(),
            material: 0,
            transform: glam::Mat4::IDENTITY.to_cols_array_2d(),
        }
    }
}

/// What a surface reflects, sends out and lets through: the Phong model, or metallic-roughness as glTF has it where
/// [`Material::metallic_roughness`] is given.
///
/// Fields are assigned after `Material::default()`: white, Lambertian, opaque, so that baked light carries no tint.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Material {
    /// Name in messages and written glTF; `material 3` where it is empty.
    pub name: String,
    /// Diffuse reflectance, or the base colour of metallic-roughness, linear RGB, 0..=1. Where albedo and specular add
    /// up to more than 1 in a channel, the scene gets darker ones and a warning: no surface reflects more than it
    /// receives.
    pub albedo: [f32; 3],
    /// Picture that multiplies `albedo`, and whose alpha multiplies `alpha`.
    pub albedo_texture: Option<Texture>,
    /// Specular reflectance, linear RGB, 0..=1. Without effect beside `metallic_roughness`.
    pub specular: [f32; 3],
    /// Exponent of the specular lobe, 0..=1e6. Without effect beside `metallic_roughness`.
    pub exponent: f64,
    /// The metallic-roughness model in place of `specular` and `exponent`.
    pub metallic_roughness: Option<MetallicRoughness>,
    /// Radiance that the surface sends out by itself, linear RGB, 0 or more.
    pub emission: [f32; 3],
    /// Picture that multiplies `emission`, which has to be above 0 for it to shine.
    pub emission_texture: Option<Texture>,
    /// Normals in tangent space, coded as glTF has them (y to the top of the picture), for a bake that takes normal
    /// maps in. Their alpha counts for nothing, and they are numbers, not sRGB.
    pub normal_texture: Option<Texture>,
    /// Multiplies the coded normals' components along the surface.
    pub normal_scale: f32,
    /// Constant alpha, 0..=1; it multiplies the texture's. Without effect where the surface is opaque.
    pub alpha: f32,
    /// How alpha lets rays pass; not at all by default.
    pub alpha_mode: AlphaMode,
    /// Both sides are drawn. Every surface blocks rays from both.
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Material {
        Material {
            name: String::new(),
            albedo: [1.0; 3],
            albedo_texture: None,
            specular: [0.0; 3],
            exponent: 0.0,
            metallic_roughness: None,
            emission: [0.0; 3],
            emission_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            alpha: 1.0,
            alpha_mode: AlphaMode::Opaque,
            double_sided: true,
        }
    }
}

/// How alpha lets rays pass.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum AlphaMode {
    /// Blocks every ray.
    #[default]
    Opaque,
    /// Rays pass where alpha is below the threshold.
    Mask {
        /// The threshold, 0 or more.
        cutoff: f32,
    },
    /// Alpha is the share of the rays that are blocked.
    Blend,
}

/// The metallic-roughness model of glTF 2.0.
///
/// Fields are assigned after `MetallicRoughness::default()`: rough plastic.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct MetallicRoughness {
    /// 0 for a dielectric, 1 for a metal.
    pub metallic: f32,
    /// 0 for a mirror, 1 for the roughest.
    pub roughness: f32,
    /// Picture of numbers, not sRGB: blue multiplies `metallic`, green `roughness`.
    pub texture: Option<Texture>,
    /// Reflectance of the dielectric at normal view, linear RGB, 0..=1; 0.04 by default, as of an index of refraction
    /// of 1.5.
    pub dielectric: [f32; 3],
}

impl Default for MetallicRoughness {
    fn default() -> MetallicRoughness {
        MetallicRoughness {
            metallic: 0.0,
            roughness: 1.0,
            texture: None,
            dielectric: [0.04; 3],
        }
    }
}

/// A picture of 8-bit pixels: red, green and blue in sRGB where they are a colour, and alpha. The mesh's `uvs` read it
/// bilinearly; it repeats beyond 0..1.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Texture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` RGBA pixels, row by row from the top.
    pub pixels: Vec<[u8; 4]>,
}

impl Texture {
    /// A picture of `width` by `height` pixels, row by row from the top. Whether the numbers fit is judged by
    /// [`Scene::from_meshes`](crate::Scene::from_meshes).
    pub fn new(width: u32, height: u32, pixels: Vec<[u8; 4]>) -> Texture {
        Texture {
            width,
            height,
            pixels,
        }
    }
}

/// A name, or the stand-in for an empty one.
fn named(name: &str, or: impl Fn() -> String) -> String {
    if name.is_empty() {
        or()
    } else {
        name.to_owned()
    }
}

/// What messages call a mesh or a material.
fn place(what: &str, number: usize, name: &str) -> String {
    if name.is_empty() {
        format!("{what} {number}")
    } else {
        format!("{what} {number} `{}`", short(name))
    }
}
