//! Broken bytes by the thousand: a load returns, whatever they are.

use super::support::{Document, Folder, U8, png};
use serde_json::json;

/// A small deterministic generator (SplitMix64).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) % n as u64) as usize
    }

    /// The bytes cut, changed, repeated or shifted in a few places.
    fn broken(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut out = bytes.to_vec();
        for _ in 0..1 + self.below(4) {
            let at = self.below(out.len().max(1));
            match self.below(6) {
                0 => out.truncate(at),
                1 => out
                    .get_mut(at..)
                    .into_iter()
                    .flatten()
                    .take(4)
                    .for_each(|b| *b = 0xff),
                2 => out.insert(
                    at.min(out.len()),
                    b"0123456789-.e/ \n{}[]\""[self.below(21)],
                ),
                3 if at < out.len() => drop(out.remove(at)),
                4 if at < out.len() => out[at] ^= 1 << self.below(8),
                _ if at < out.len() => out[at] = b"0123456789-"[self.below(11)],
                _ => {}
            }
        }
        out
    }
}

/// A document that uses most of what is read.
fn rich() -> Document {
    let mut document = Document::square();
    let indices = document.accessor(U8, "SCALAR", 6, &[0, 1, 2, 0, 2, 3]);
    let uvs = document.floats("VEC2", &[0., 0., 1., 0., 1., 1., 0., 1.]);
    let normals = document.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let (numbers, values) = (document.view(&[1, 3]), document.view(&[0; 24]));
    document.json["accessors"][normals]["sparse"] = json!({ "count": 2, "values": { "bufferView": values },
        "indices": { "bufferView": numbers, "componentType": U8 } });
    let image = document.view(&png(&[[255, 0, 0, 255], [0, 255, 0, 0]]));
    document.json["images"] = json!([{ "bufferView": image, "mimeType": "image/png" }]);
    document.json["textures"] = json!([{ "source": 0 }]);
    document.json["materials"] = json!([{ "alphaMode": "MASK",
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    *document.primitive() = json!({ "indices": indices, "material": 0,
        "attributes": { "POSITION": 1, "TEXCOORD_0": uvs, "NORMAL": normals } });
    let places = document.floats("VEC3", &[0., 0., 1., 0., 0., 2.]);
    let instancing =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    document.json["nodes"] =
        json!([{ "children": [1], "scale": [1, 2, 3] }, { "mesh": 0, "extensions": instancing }]);
    document
}

#[test]
fn no_damage_makes_a_load_panic() {
    let folder = Folder::new();
    folder.write("a.mtl", "newmtl m\nKd 1 0 0\nmap_Kd -s 1 1 a.png\nd 0.5\n");
    folder.write("a.png", png(&[[1, 2, 3, 4]]));
    let document = rich();
    let data = format!(
        "data:;base64,{}",
        base64::Engine::encode(&base64::prelude::BASE64_STANDARD, &document.bin)
    );
    let obj = "mtllib a.mtl\no a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\nusemtl m\n\
               f 1/1/1 2/2/1 3/1/1 4//1\ng b\nf -4 -3 -2\n";
    let mut random = Random(1);
    let mut loaded = 0;
    for (name, bytes) in [
        ("a.glb", document.glb()),
        ("a.gltf", document.gltf(&data).into()),
        ("a.obj", obj.into()),
    ] {
        folder.load(name, &bytes).unwrap_or_else(|e| panic!("{e}"));
        for _ in 0..3000 {
            match folder.load(name, random.broken(&bytes)) {
                Ok(scene) => {
                    loaded += 1;
                    // What loads keeps the promises of `Scene`, and what the loader did not need can be asked for.
                    if let Some(source) = &scene.source {
                        for elements in (0..9).flat_map(|i| source.accessor(i)) {
                            let last = elements.count.wrapping_sub(1);
                            assert_eq!(elements.bytes(last).is_some(), elements.count > 0);
                            assert_eq!(elements.bytes(elements.count), None);
                        }
                    }
                    for mesh in &scene.meshes {
                        assert!(
                            mesh.triangles
                                .iter()
                                .flatten()
                                .all(|&i| (i as usize) < mesh.positions.len())
                        );
                        assert!(mesh.positions.iter().all(|p| p.is_finite()));
                        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6));
                    }
                }
                Err(e) => assert!(!e.to_string().contains('\n'), "{e}"),
            }
        }
    }
    println!("{loaded} of 9000 damaged files load");
}

#[test]
fn a_broken_material_library_or_image_does_not_panic() {
    let folder = Folder::new();
    let image = png(&[[1, 2, 3, 4]; 16]);
    let library =
        "newmtl m\nKd 1 0 0\nKs 0.5\nNs 1e3\nmap_Kd -s 1 1 -clamp on a.png\nd 0.5\nmap_d a.png\n";
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    let mut random = Random(2);
    for round in 0..1000 {
        let (library, image) = match round % 2 {
            0 => (random.broken(library.as_bytes()), image.clone()),
            _ => (library.into(), random.broken(&image)),
        };
        folder.write("a.mtl", library);
        folder.write("a.png", image);
        let _ = folder.load("a.obj", obj);
    }
}
