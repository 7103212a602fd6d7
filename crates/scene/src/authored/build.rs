//! Turns what a program hands over into a scene, under the same rules as a file.

use super::{Material, Mesh, Texture, hash};
use crate::material::{MAX_EXPONENT, conserving, untinted};
use crate::source::{Input, short};
use crate::validate::{self, Parts, clamped};
use crate::{
    Alpha, Error, Format, Image, Instance, MeshOrigin, Scene, Surface, TextureRef, WarningKind,
    Wrap,
};
use glam::{Vec2, Vec3};
use std::path::Path;

impl Scene {
    /// The scene of meshes and materials in memory, validated and repaired as a file's would be.
    ///
    /// Each mesh becomes one object, in the order given. Without materials every mesh is of the default one, and its
    /// [`material`](Mesh::material) is 0. [`Scene::path`] is `scene`, the stem of the files that a bake of it writes.
    ///
    /// # Errors
    /// [`Error::Authored`], one line that names the mesh or the material: a position that a triangle uses is not finite
    /// or beyond 1e18, a vertex or material number is out of range, normals or UVs are not one a vertex, a transform is
    /// not affine, a texture has more or fewer pixels than its size says, or no triangle with an area is left.
    ///
    /// ```
    /// use ambake_scene::{Scene, authored::{Material, Mesh}};
    ///
    /// let mut floor = Mesh::default();
    /// floor.name = "floor".into();
    /// floor.positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, 0.0]];
    /// floor.triangles = vec![[0, 1, 2], [0, 2, 3]];
    /// let mut lid = floor.clone();
    /// lid.name = "lid".into();
    /// lid.material = 1;
    /// lid.transform[3] = [0.0, 1.5, 0.0, 1.0];
    ///
    /// let mut brick = Material::default();
    /// brick.albedo = [0.6, 0.3, 0.2];
    /// let scene = Scene::from_meshes(vec![floor, lid], vec![Material::default(), brick])?;
    /// assert_eq!(scene.instances[1].transform.translation.y, 1.5);
    /// # Ok::<(), ambake_scene::Error>(())
    /// ```
    pub fn from_meshes(meshes: Vec<Mesh>, materials: Vec<Material>) -> Result<Scene, Error> {
        let mut input = Input::new(Path::new("scene"), crate::Files::Inside);
        hash::update(&mut input.hasher, &meshes, &materials);
        parts(&mut input, meshes, materials)
            .and_then(|parts| validate::scene(input, Format::Memory, parts))
            .map_err(without_file)
    }
}

/// The errors of the readers name a file; here there is none.
fn without_file(error: Error) -> Error {
    match error {
        Error::Invalid { place, problem, .. } => Error::Authored { place, problem },
        Error::NoTriangles { hint, .. } => Error::Authored {
            place: "scene".into(),
            problem: format!("no mesh has a triangle with an area; hand over at least one{hint}"),
        },
        other => other,
    }
}

fn parts(input: &mut Input, meshes: Vec<Mesh>, materials: Vec<Material>) -> Result<Parts, Error> {
    let mut parts = Parts::default();
    for (number, given) in materials.into_iter().enumerate() {
        let material = material(input, &mut parts, number, given)?;
        parts.materials.push(material);
    }
    if parts.materials.is_empty() {
        parts.materials.push(untinted("none"));
    }
    for (number, given) in meshes.into_iter().enumerate() {
        add(input, &mut parts, number, given)?;
    }
    Ok(parts)
}

fn add(input: &mut Input, parts: &mut Parts, number: usize, given: Mesh) -> Result<(), Error> {
    let place = place("mesh", number, &given.name);
    let vertices = given.positions.len();
    for (what, count) in [("normals", given.normals.len()), ("uvs", given.uvs.len())] {
        if count != 0 && count != vertices {
            let problem =
                format!("{count} {what} for {vertices} positions; give one a vertex or none");
            return Err(input.invalid(place, problem));
        }
    }
    if given.material >= parts.materials.len() {
        let problem = format!(
            "it is of material {} but there are {}, numbered from 0; correct its number",
            given.material,
            parts.materials.len()
        );
        return Err(input.invalid(place, problem));
    }
    let transform = validate::affine(given.transform.map(|column| column.map(f64::from))).ok_or_else(|| {
        let problem = "its transform is not affine (the last row is not 0 0 0 1); are rows and columns exchanged?";
        input.invalid(place.as_str(), problem)
    })?;
    let mut mesh = crate::Mesh {
        name: named(&given.name, || format!("mesh {number}")),
        positions: vectors(given.positions),
        normals: vectors(given.normals),
        tangents: Vec::new(),
        colors: Vec::new(),
        alphas: Vec::new(),
        uv_sets: Vec::new(),
        triangles: given.triangles,
        source_triangles: Vec::new(),
        source_vertices: Vec::new(),
        material: given.material as u32,
        origin: MeshOrigin {
            mesh: number as u32,
            primitive: 0,
        },
    };
    if !given.uvs.is_empty() {
        let uvs = given.uvs.into_iter().map(Vec2::from_array);
        mesh.uv_sets.push(uvs.collect());
    }
    if validate::mesh(input, &mut mesh, &place)? {
        parts.instances.push(Instance {
            name: mesh.name.clone(),
            mesh: parts.meshes.len() as u32,
            transform,
            node: 0,
            copy: None,
            casts: true,
            keeps_buried: None,
        });
        parts.meshes.push(mesh);
    }
    Ok(())
}

fn material(
    input: &mut Input,
    parts: &mut Parts,
    number: usize,
    given: Material,
) -> Result<crate::Material, Error> {
    let place = place("material", number, &given.name);
    let name = named(&given.name, || format!("material {number}"));
    let mut changed = 0;
    let mut color = |color: [f32; 3], high: f32, fallback: f32| {
        Vec3::from_array(color.map(|v| clamped(v, 0.0, high, fallback, &mut changed)))
    };
    let albedo = color(given.albedo, 1.0, 1.0);
    let specular = color(given.specular, 1.0, 0.0);
    let emission = color(given.emission, f32::MAX, 0.0);
    let factor = clamped(given.alpha, 0.0, 1.0, 1.0, &mut changed);
    let cutoff = given
        .alpha_cutoff
        .map(|cutoff| clamped(cutoff, 0.0, f32::MAX, 0.5, &mut changed));
    let exponent = match given.exponent {
        n if n.is_nan() => 0.0,
        n => n.clamp(0.0, MAX_EXPONENT),
    };
    changed += u64::from(exponent != given.exponent);
    let message = "factors out of range are clamped";
    input.warn(
        WarningKind::ClampedFactors,
        place.as_str(),
        changed,
        message,
    );
    let [albedo, specular] = conserving(input, &place, [albedo, specular]);

    let texture = given.albedo_texture;
    let map = texture
        .map(|texture| image(texture, &name).map_err(|problem| input.invalid(place, problem)))
        .transpose()?
        .map(|image| {
            parts.images.push(image);
            TextureRef {
                image: parts.images.len() as u32 - 1,
                uv_set: 0,
                wrap: [Wrap::Repeat; 2],
                linear: true,
                transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            }
        });
    Ok(crate::Material {
        name,
        alpha: cutoff.map_or(Alpha::Opaque, |cutoff| Alpha::Mask {
            cutoff,
            factor,
            map: map.clone(),
        }),
        surface: Surface::Phong {
            albedo,
            albedo_map: map,
            specular,
            exponent,
        },
        ambient: None,
        emission,
        emission_map: None,
        transmission: None,
        normal_map: None,
        double_sided: given.double_sided,
    })
}

fn image(texture: Texture, name: &str) -> Result<Image, String> {
    let Texture {
        width,
        height,
        pixels,
    } = texture;
    if pixels.is_empty() || pixels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(format!(
            "its texture has {} pixels, but {width} x {height} are announced; give as many, at least one",
            pixels.len()
        ));
    }
    Ok(Image {
        name: name.into(),
        width,
        height,
        pixels,
    })
}

fn vectors(arrays: Vec<[f32; 3]>) -> Vec<Vec3> {
    arrays.into_iter().map(Vec3::from_array).collect()
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
