//! What a program hands over to have a scene without a file: see [`Scene::from_meshes`](crate::Scene::from_meshes).
//!
//! The types carry the names of their loaded counterparts, for they are what a caller calls a mesh and a material; a
//! [`Scene`](crate::Scene) holds the loaded ones.

mod build;
mod hash;

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
    /// Texture coordinates, one a vertex, in glTF's orientation (v grows down); empty for none. The one set is read by
    /// the material's texture and is a candidate for the lightmap.
    pub uvs: Vec<[f32; 2]>,
    /// Vertex numbers, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Number of the material in the list that is handed over with the meshes.
    pub material: usize,
    /// Mesh space to world space, column by column as in glTF: the last column is the translation, the last row is
    /// 0 0 0 1.
    pub transform: [[f32; 4]; 4],
}

impl Default for Mesh {
    fn default() -> Mesh {
        Mesh {
            name: String::new(),
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            triangles: Vec::new(),
            material: 0,
            transform: glam::Mat4::IDENTITY.to_cols_array_2d(),
        }
    }
}

/// Parameters of the Phong model.
///
/// Fields are assigned after `Material::default()`: white, Lambertian, opaque, so that baked light carries no tint.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Material {
    /// Name in messages and written glTF; `material 3` where it is empty.
    pub name: String,
    /// Diffuse reflectance, linear RGB, 0..=1. Where albedo and specular add up to more than 1 in a channel, the scene
    /// gets darker ones and a warning: no surface reflects more than it receives.
    pub albedo: [f32; 3],
    /// Picture that multiplies `albedo`, read with the mesh's `uvs`.
    pub albedo_texture: Option<Texture>,
    /// Specular reflectance, linear RGB, 0..=1.
    pub specular: [f32; 3],
    /// Exponent of the specular lobe, 0..=1e6.
    pub exponent: f64,
    /// Radiance that the surface sends out by itself, linear RGB, 0 or more.
    pub emission: [f32; 3],
    /// Constant alpha, 0..=1; it multiplies the texture's. Without effect where `alpha_cutoff` is `None`.
    pub alpha: f32,
    /// Rays pass where alpha is below this threshold; `None` for a surface that blocks them all.
    pub alpha_cutoff: Option<f32>,
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
            emission: [0.0; 3],
            alpha: 1.0,
            alpha_cutoff: None,
            double_sided: true,
        }
    }
}

/// A picture of 8-bit pixels: red, green and blue in sRGB, and alpha. It repeats beyond 0..1 and is read bilinearly.
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
