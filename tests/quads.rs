//! glTF scenes of a few quads, written into a folder of their own: for textures, alpha and normal maps.

use serde_json::{Value, json};
use tempfile::TempDir;

/// A quad of two triangles: a corner and the corners to its right and below it, as a picture on it lies.
pub struct Quad {
    pub corner: [f32; 3],
    pub right: [f32; 3],
    pub down: [f32; 3],
    /// UV of the corner, and the change to the right and down, of `TEXCOORD_0` and `TEXCOORD_1`.
    pub uvs: [[[f32; 2]; 3]; 2],
    /// Further attributes: name, and the components of each of the four vertices.
    pub further: Vec<(&'static str, [Vec<f32>; 4])>,
    pub material: usize,
    /// `scale` of the node.
    pub scale: [f32; 3],
}

impl Quad {
    /// A level square about the y axis that faces up; u grows with x and v with z.
    pub fn level(height: f32, edge: f32) -> Quad {
        let half = 0.5 * edge;
        Quad {
            corner: [-half, height, -half],
            right: [edge, 0.0, 0.0],
            down: [0.0, 0.0, edge],
            uvs: [[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]; 2],
            further: Vec::new(),
            material: 0,
            scale: [1.0; 3],
        }
    }

    /// The same value of an attribute at all four corners.
    pub fn with(mut self, name: &'static str, value: &[f32]) -> Quad {
        self.further
            .push((name, std::array::from_fn(|_| value.to_vec())));
        self
    }

    fn place(&self, of: [[f32; 3]; 3], [s, t]: [f32; 2]) -> Vec<f32> {
        let axis = |k: usize| of[0][k] + of[1][k] * s + of[2][k] * t;
        (0..3).map(axis).collect()
    }
}

/// The corners of a picture: left above, right above, right below, left below.
const CORNERS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// Writes `scene.gltf` with its buffer; `extra` holds materials, textures, samplers and the like. Returns its folder.
pub fn write(quads: &[Quad], extra: Value) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let (mut bin, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    let mut accessor = |values: &[Vec<f32>], kind: &str| {
        let start = bin.len();
        bin.extend(values.iter().flatten().flat_map(|x| x.to_le_bytes()));
        views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": bin.len() - start }));
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            let lanes = 0..values[0].len();
            lanes
                .map(|k| values.iter().map(|v| v[k]).reduce(pick).unwrap_or_default())
                .collect()
        };
        accessors.push(json!({
            "bufferView": views.len() - 1, "componentType": 5126, "count": values.len(), "type": kind,
            "min": bound(f32::min), "max": bound(f32::max),
        }));
        accessors.len() - 1
    };
    let (mut meshes, mut nodes) = (Vec::new(), Vec::new());
    for (number, quad) in quads.iter().enumerate() {
        // Counter-clockwise seen from where the picture is not mirrored.
        let corners = [0, 3, 2, 0, 2, 1].map(|i: usize| (i, CORNERS[i]));
        let positions = corners.map(|(_, at)| quad.place([quad.corner, quad.right, quad.down], at));
        let mut attributes = json!({ "POSITION": accessor(&positions, "VEC3") });
        for (set, [origin, right, down]) in quad.uvs.iter().enumerate() {
            let uv = |at: [f32; 2]| {
                let axis = |k: usize| origin[k] + right[k] * at[0] + down[k] * at[1];
                vec![axis(0), axis(1)]
            };
            let uvs = corners.map(|(_, at)| uv(at));
            attributes[format!("TEXCOORD_{set}")] = accessor(&uvs, "VEC2").into();
        }
        for (name, values) in &quad.further {
            let values = corners.map(|(i, _)| values[i].clone());
            let kind = format!("VEC{}", values[0].len());
            attributes[*name] = accessor(&values, &kind).into();
        }
        meshes.push(json!({
            "name": format!("quad {number}"),
            "primitives": [{ "attributes": attributes, "material": quad.material }],
        }));
        nodes.push(json!({ "mesh": number, "scale": quad.scale }));
    }
    let mut document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "uri": "scene.bin", "byteLength": bin.len() }],
    });
    for (key, value) in extra.as_object().into_iter().flatten() {
        document[key] = value.clone();
    }
    std::fs::write(folder.path().join("scene.bin"), bin).expect("a writable folder");
    let text = document.to_string();
    std::fs::write(folder.path().join("scene.gltf"), text).expect("a writable folder");
    folder
}

/// Writes an RGBA picture, row by row from the top.
pub fn picture(folder: &TempDir, name: &str, [width, height]: [u32; 2], pixels: &[[u8; 4]]) {
    let bytes = pixels.as_flattened().to_vec();
    let image =
        image::RgbaImage::from_raw(width, height, bytes).expect("as many pixels as its size");
    image
        .save(folder.path().join(name))
        .expect("a writable folder");
}
