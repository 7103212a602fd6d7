//! Normal maps on surfaces: the mean normal of a piece of a triangle, bent by the map of its material.
//!
//! **Tangent space.** glTF's: tangents are the file's where it has them, else MikkTSpace's, made from the texture
//! coordinates that the map is read at. Between corners normal and tangent are interpolated and brought to unit length,
//! the bitangent is their cross product times the file's sign, so `n = x t + y b + z n0` points to where the map's red
//! (to the image's right) and green (to its top) say.
//!
//! **Placement.** A normal is bent in the mesh's own space and then carried into the world by the inverse transpose, as
//! every normal is. So relief is part of the shape: it is mirrored with a mirrored instance and flattened with a
//! flattened one, and mirrored texture coordinates need only their sign.
//!
//! **Mean.** A texel has one normal over each piece of a triangle: the mean of the bent normals over it, of unit length
//! again. `docs/sampling.md` says what that keeps of the relief and what not.

use crate::error::Error;
use crate::part::Part;
use crate::tangents::{normals, tangents};
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use rayon::prelude::*;
use scene::{Image, Mesh, NormalMap, Scene};

/// Points along the edge of a piece at which the map is read, at most.
const MOST_POINTS: u32 = 16;

/// The normal maps of a scene with what reading them needs.
#[derive(Debug)]
pub(crate) struct NormalMaps {
    /// By packed image; `None` where no mesh that is placed reads it, or it is broken.
    images: Vec<Option<Image>>,
    /// Names of the broken ones that such meshes read, and what is wrong.
    pub broken: Vec<(String, String)>,
    /// By mesh: tangents of the corners of each triangle; empty for a mesh without a normal map.
    tangents: Vec<Vec<[Vec4; 3]>>,
}

impl NormalMaps {
    /// Decodes the maps that placed meshes read, but for broken ones, and makes the tangents of these meshes.
    pub fn of(scene: &Scene) -> Result<Self, Error> {
        let mut placed = vec![false; scene.meshes.len()];
        for instance in &scene.instances {
            placed[instance.mesh as usize] = true;
        }
        let map = |mesh: &Mesh| scene.materials[mesh.material as usize].normal_map.as_ref();
        let read = |image: usize| {
            let meshes = scene.meshes.iter().zip(&placed);
            let maps = meshes.filter_map(|(mesh, placed)| map(mesh).filter(|_| *placed));
            maps.into_iter()
                .find(|map| map.texture.image as usize == image)
        };
        let maps: Vec<_> = (0..scene.packed_images.len()).map(read).collect();
        scene.check_normal_images((0..maps.len()).filter(|&image| maps[image].is_some()))?;
        let read: Vec<_> = maps
            .into_par_iter()
            .map(|map| map.map(|map| scene.normal_image(map)))
            .collect();
        let of_image = read.iter().zip(&scene.packed_images);
        let broken = of_image.filter_map(|(read, image)| {
            let error = read.as_ref()?.as_ref().err()?;
            Some((image.name.clone(), error.to_string()))
        });
        let broken = broken.collect();
        let images = read.into_iter().map(|read| read?.ok()).collect();
        let tangents = scene
            .meshes
            .par_iter()
            .zip(&placed)
            .map(|(mesh, placed)| match map(mesh) {
                Some(map) if *placed => tangents(mesh, |corner| place(mesh, map, corner)),
                _ => Vec::new(),
            })
            .collect();
        Ok(Self {
            images,
            broken,
            tangents,
        })
    }

    /// The unit mean, in the world, of the bent shading normals over a piece of a triangle of a placed mesh; `None`
    /// where the mesh has no normal map, or the normals cancel.
    ///
    /// * `corners`: corner weights of the triangle at three corners of the piece.
    /// * `square`: the piece is the parallelogram on them, not the triangle.
    pub fn mean(
        &self,
        scene: &Scene,
        part: &Part,
        mesh: u32,
        triangle: u32,
        corners: [DVec3; 3],
        square: bool,
    ) -> Option<DVec3> {
        let (surface, map, image) = self.surface(scene, mesh, triangle)?;
        let points = points(&surface, map, image, corners);
        let fold = if square { 0.0 } else { 0.5 };
        let mut sum = DVec3::ZERO;
        for i in 0..points {
            for j in 0..points {
                let [s, t] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(points));
                // The square is folded onto the triangle, as samples are.
                let folded = fold * s.min(t);
                let (s, t) = (s - folded, t - folded);
                let [a, b, c] = corners;
                let bent = surface.bent(a + (b - a) * s + (c - a) * t, map, image);
                sum += part.carry_normal(bent).normalize_or_zero();
            }
        }
        sum.try_normalize()
    }

    /// The unit bent shading normal, in the world, at a point of a triangle of a placed mesh; `None` where the mesh has
    /// no normal map.
    ///
    /// * `weights`: corner weights of the triangle.
    pub fn at(
        &self,
        scene: &Scene,
        part: &Part,
        mesh: u32,
        triangle: u32,
        weights: DVec3,
    ) -> Option<DVec3> {
        let (surface, map, image) = self.surface(scene, mesh, triangle)?;
        let bent = surface.bent(weights, map, image);
        part.carry_normal(bent).try_normalize()
    }

    /// A triangle with what bends its normals.
    fn surface<'a>(
        &'a self,
        scene: &'a Scene,
        mesh: u32,
        triangle: u32,
    ) -> Option<(Corners<'a>, &'a NormalMap, &'a Image)> {
        let tangents = self.tangents[mesh as usize].get(triangle as usize)?;
        let mesh = &scene.meshes[mesh as usize];
        let material = &scene.materials[mesh.material as usize];
        let map = material.normal_map.as_ref()?;
        let image = self.images[map.texture.image as usize].as_ref()?;
        let surface = Corners::of(mesh, map, triangle, tangents)?;
        Some((surface, map, image))
    }
}

/// What a triangle has at its corners, in the mesh's space.
struct Corners<'a> {
    normals: [Vec3; 3],
    tangents: &'a [Vec4; 3],
    uvs: [Vec2; 3],
}

impl<'a> Corners<'a> {
    /// `None` where the mesh lacks the texture coordinates of the map.
    fn of(
        mesh: &Mesh,
        map: &NormalMap,
        triangle: u32,
        tangents: &'a [Vec4; 3],
    ) -> Option<Corners<'a>> {
        let set = mesh.uv_sets.get(map.texture.uv_set as usize)?;
        let vertices = mesh.triangles[triangle as usize];
        Some(Corners {
            normals: normals(mesh, triangle as usize),
            tangents,
            uvs: vertices.map(|v| set[v as usize]),
        })
    }

    /// The bent normal with these corner weights.
    fn bent(&self, weights: DVec3, map: &NormalMap, image: &Image) -> DVec3 {
        let mean =
            |of: &dyn Fn(usize) -> DVec3| of(0) * weights.x + of(1) * weights.y + of(2) * weights.z;
        let normal = mean(&|i| self.normals[i].as_dvec3()).normalize_or_zero();
        let tangent = mean(&|i| self.tangents[i].truncate().as_dvec3()).normalize_or_zero();
        let bitangent = normal.cross(tangent) * f64::from(self.tangents[0].w);
        let local = map.normal(image, self.uv(weights)).as_dvec3();
        tangent * local.x + bitangent * local.y + normal * local.z
    }

    fn uv(&self, weights: DVec3) -> Vec2 {
        let [a, b, c] = self.uvs.map(|uv| uv.as_dvec2());
        (a * weights.x + b * weights.y + c * weights.z).as_vec2()
    }
}

/// Where the map is read at a vertex.
fn place(mesh: &Mesh, map: &NormalMap, [triangle, corner]: [usize; 2]) -> Vec2 {
    let texture = &map.texture;
    let set = mesh.uv_sets.get(texture.uv_set as usize);
    let vertex = mesh.triangles[triangle][corner] as usize;
    let uv = set.map_or(Vec2::ZERO, |set| set[vertex]);
    let row = |[a, b, c]: [f32; 3]| a * uv.x + b * uv.y + c;
    Vec2::from(texture.transform.map(row))
}

/// How many points along each edge of a piece meet about every pixel of the map, within 2..=[`MOST_POINTS`].
fn points(surface: &Corners, map: &NormalMap, image: &Image, corners: [DVec3; 3]) -> u32 {
    let size = DVec2::new(f64::from(image.width), f64::from(image.height));
    let [a, b, c] = corners.map(|weights| {
        let uv = surface.uv(weights);
        let row = |[x, y, shift]: [f32; 3]| f64::from(x * uv.x + y * uv.y + shift);
        DVec2::from(map.texture.transform.map(row)) * size
    });
    let pixels = (b - a).perp_dot(c - a).abs().sqrt();
    (pixels.ceil() as u32)
        .saturating_add(1)
        .clamp(2, MOST_POINTS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{scene, square, world};
    use scene::{TextureRef, Wrap};

    #[test]
    fn the_mean_over_a_piece_is_that_of_points_all_over_it() {
        // Leans to the right more and more from left to right, and up from bottom to top.
        let pixel = |i: u32| [48 + 20 * (i % 8) as u8, 48 + 20 * (i / 8) as u8, 160, 255];
        let image = Image {
            name: "lean".into(),
            width: 8,
            height: 8,
            pixels: (0..64).map(pixel).collect(),
        };
        let map = NormalMap {
            texture: TextureRef {
                wrap: [Wrap::Clamp; 2],
                ..TextureRef::new(0)
            },
            scale: 1.0,
            heights: false,
        };
        let mut scene = scene(vec![square(0.0)]);
        scene.materials[0].normal_map = Some(map.clone());
        let mesh = &scene.meshes[0];
        let maps = NormalMaps {
            tangents: vec![tangents(mesh, |corner| place(mesh, &map, corner))],
            broken: Vec::new(),
            images: vec![Some(image)],
        };
        let world = world(scene.clone());
        let (part, _) = world.part(0);
        let surface = Corners::of(mesh, &map, 0, &maps.tangents[0][0]).unwrap();
        let piece = [
            DVec3::new(0.8, 0.1, 0.1),
            DVec3::new(0.1, 0.9, 0.0),
            DVec3::new(0.3, 0.1, 0.6),
        ];
        for square in [false, true] {
            let mean = maps.mean(&scene, part, 0, 0, piece, square).unwrap();
            let mut sum = DVec3::ZERO;
            for i in 0..300 {
                for j in 0..300 {
                    let [s, t] = [i, j].map(|k| (f64::from(k) + 0.5) / 300.0);
                    if square || s + t <= 1.0 {
                        let [a, b, c] = piece;
                        let at = a + (b - a) * s + (c - a) * t;
                        let image = maps.images[0].as_ref().unwrap();
                        sum += surface.bent(at, &map, image).normalize();
                    }
                }
            }
            let off = (mean - sum.normalize()).length();
            // About one point a pixel, of which the normals of neighbours differ by 0.15.
            assert!(off < 0.01, "square {square}: {mean} {off}");
        }
    }
}
