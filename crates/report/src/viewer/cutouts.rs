//! Surfaces that are not opaque, as the viewer embeds them: their alpha pictures, and what each vertex reads of them.

use super::embed::blob;
use glam::Vec2;
use scene::{Alpha, Image, Mesh, Scene, TextureRef, Wrap};
use serde_json::{Value, json};

/// Longest edge of an embedded alpha picture: enough to see the outline of a leaf, little in a file.
const MOST_EDGE: u32 = 1024;

/// The alpha pictures of a scene. Meshes that read the same image in the same way share one.
pub(super) struct Cutouts<'a> {
    scene: &'a Scene,
    pictures: Vec<&'a TextureRef>,
}

impl<'a> Cutouts<'a> {
    pub fn of(scene: &'a Scene) -> Self {
        let mut pictures: Vec<&TextureRef> = Vec::new();
        for map in scene
            .meshes
            .iter()
            .filter_map(|mesh| alpha(scene, mesh)?.map)
        {
            if !pictures.iter().any(|known| same(known, map)) {
                pictures.push(map);
            }
        }
        Self { scene, pictures }
    }

    /// What the head says of a mesh: its picture, or -1, and its cutoff, or -1 where it is see-through; nothing where
    /// the mesh is opaque.
    pub fn head(&self, mesh: &Mesh) -> Option<Value> {
        let alpha = alpha(self.scene, mesh)?;
        let number = |map| self.pictures.iter().position(|known| same(known, map));
        let picture = alpha.map.and_then(number).map_or(-1, |at| at as i64);
        Some(json!({ "picture": picture, "cutoff": alpha.cutoff }))
    }

    /// Coordinates on the picture and the alpha that multiplies it, as three f32 a vertex; empty where the mesh is
    /// opaque.
    pub fn vertices(&self, mesh: &Mesh) -> Vec<u8> {
        let Some(alpha) = alpha(self.scene, mesh) else {
            return Vec::new();
        };
        let numbers = (0..mesh.positions.len()).flat_map(|vertex| {
            let place = alpha.map.and_then(|map| {
                let uv = *mesh.uv_sets.get(map.uv_set as usize)?.get(vertex)?;
                Some(map.transform.map(|[a, b, c]| a * uv.x + b * uv.y + c))
            });
            let own = mesh.alphas.get(vertex).copied().unwrap_or(1.0);
            let [u, v] = place.unwrap_or_default();
            [u, v, alpha.factor * own]
        });
        numbers.flat_map(f32::to_le_bytes).collect()
    }

    /// For each picture what the head says of it, and its rows of one byte a pixel as an embedded blob.
    pub fn pictures(&self) -> Vec<(Value, String)> {
        let picture = |map: &&TextureRef| {
            let image = &self.scene.images[map.image as usize];
            let (size, bytes) = reduced(image);
            let head = json!({ "size": size, "wrap": map.wrap.map(word), "linear": map.linear });
            (head, blob(&bytes))
        };
        self.pictures.iter().map(picture).collect()
    }
}

/// What lets light through a mesh.
struct Through<'a> {
    factor: f32,
    map: Option<&'a TextureRef>,
    /// Least alpha that stops light; -1 where the surface stops its share of it.
    cutoff: f32,
}

fn alpha<'a>(scene: &'a Scene, mesh: &Mesh) -> Option<Through<'a>> {
    let material = &scene.materials[mesh.material as usize];
    let (factor, map, cutoff) = match &material.alpha {
        Alpha::Opaque => match &material.transmission {
            // The viewer knows alpha alone: a pane is as clear as its factor says.
            Some(transmission) => (1.0 - transmission.factor, &None, -1.0),
            None => return None,
        },
        Alpha::Mask {
            cutoff,
            factor,
            map,
        } => (*factor, map, *cutoff),
        Alpha::Blend { factor, map } => (*factor, map, -1.0),
    };
    // As in a bake, a map whose coordinates the mesh lacks is left out.
    let map = map.as_ref().filter(|map| {
        let set = mesh.uv_sets.get(map.uv_set as usize);
        set.is_some_and(|set: &Vec<Vec2>| set.len() == mesh.positions.len())
    });
    Some(Through {
        factor,
        map,
        cutoff,
    })
}

fn same(a: &TextureRef, b: &TextureRef) -> bool {
    (a.image, a.wrap, a.linear) == (b.image, b.wrap, b.linear)
}

fn word(wrap: Wrap) -> &'static str {
    match wrap {
        Wrap::Repeat => "REPEAT",
        Wrap::Clamp => "CLAMP_TO_EDGE",
        Wrap::Mirror => "MIRRORED_REPEAT",
    }
}

/// The alpha of an image in 8 bits: means of blocks where it is larger than is embedded.
fn reduced(image: &Image) -> ([u32; 2], Vec<u8>) {
    let step = image.width.max(image.height).div_ceil(MOST_EDGE).max(1);
    let (width, height) = (image.width.div_ceil(step), image.height.div_ceil(step));
    let block = |x: u32, y: u32| {
        let (mut sum, mut count) = (0, 0);
        for y in y * step..((y + 1) * step).min(image.height) {
            for x in x * step..((x + 1) * step).min(image.width) {
                sum += u32::from(image.pixels[(y * image.width + x) as usize][3]);
                count += 1;
            }
        }
        (f64::from(sum) / f64::from(count.max(1))).round() as u8
    };
    let rows = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let bytes = rows.map(|(x, y)| block(x, y)).collect();
    ([width, height], bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_picture_is_reduced_to_means() {
        let pixels = (0..2050u32).map(|x| [0, 0, 0, if x % 3 == 0 { 255 } else { 0 }]);
        let image = Image {
            name: String::new(),
            width: 2050,
            height: 1,
            pixels: pixels.collect(),
        };
        let (size, bytes) = reduced(&image);
        assert_eq!(size, [684, 1]);
        assert!(bytes[..683].iter().all(|&alpha| alpha == 85));
        // The last block has one pixel, the 2050th.
        assert_eq!(bytes[683], 255);
    }

    #[test]
    fn a_vertex_has_its_place_on_the_picture_and_its_own_alpha() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/masked_card.gltf");
        let mut scene = scene::load(std::path::Path::new(path)).unwrap();
        let masked =
            |mesh: &Mesh| !matches!(scene.materials[mesh.material as usize].alpha, Alpha::Opaque);
        let at = scene.meshes.iter().position(masked).unwrap();
        let (uvs, count) = (
            scene.meshes[at].uv_sets[0].clone(),
            scene.meshes[at].positions.len(),
        );
        scene.meshes[at].alphas = (0..count).map(|i| i as f32 / 8.0).collect();
        let material = &mut scene.materials[scene.meshes[at].material as usize];
        let (Alpha::Mask { factor, map, .. } | Alpha::Blend { factor, map }) = &mut material.alpha
        else {
            panic!("the card is masked");
        };
        *factor = 0.5;
        // Half as wide, turned over and moved.
        map.as_mut().unwrap().transform = [[0.5, 0.0, 0.25], [0.0, -1.0, 1.0]];
        let cutouts = Cutouts::of(&scene);
        let bytes = cutouts.vertices(&scene.meshes[at]);
        let numbers: Vec<f32> = (bytes.as_chunks().0.iter())
            .map(|&word| f32::from_le_bytes(word))
            .collect();
        let expected = |i: usize| [0.5 * uvs[i].x + 0.25, 1.0 - uvs[i].y, i as f32 / 16.0];
        let expected: Vec<f32> = (0..count).flat_map(expected).collect();
        assert_eq!(numbers, expected);
        let opaque = (scene.meshes.iter())
            .find(|mesh| alpha(&scene, mesh).is_none())
            .unwrap();
        assert!(cutouts.vertices(opaque).is_empty() && cutouts.head(opaque).is_none());
        assert_eq!(cutouts.head(&scene.meshes[at]).unwrap()["picture"], 0);
        assert_eq!(cutouts.pictures().len(), 1);
    }
}
