//! No surface reflects more than it receives, however its material is written.

use super::support::{Document, Folder};
use ambake_scene::authored::{Material, Mesh};
use ambake_scene::{
    MaterialModel, Scene, WarningKind, phong_from_metallic_roughness,
    phong_from_specular_glossiness,
};
use glam::Vec3;
use serde_json::json;
use std::fmt::Write;

/// Rounding of a sum of three products in f32.
const ROUNDING: f32 = 1e-6;

/// Albedo and specular reflectance of each material.
fn reflectances(scene: &Scene) -> Vec<(Vec3, Vec3)> {
    let of = |surface: &MaterialModel| match *surface {
        MaterialModel::Phong {
            albedo, specular, ..
        } => (albedo, specular),
        MaterialModel::MetallicRoughness {
            base,
            metallic,
            roughness,
            dielectric,
            ..
        } => {
            let (albedo, specular, _) =
                phong_from_metallic_roughness(base, metallic, roughness, dielectric);
            (albedo, specular)
        }
        MaterialModel::SpecularGlossiness {
            diffuse, specular, ..
        } => {
            let (albedo, specular, _) = phong_from_specular_glossiness(diffuse, specular, 1.0);
            (albedo, specular)
        }
    };
    scene.materials.iter().map(|m| of(&m.surface)).collect()
}

#[test]
fn no_gltf_material_reflects_more_than_it_receives() {
    let mut materials = Vec::new();
    for metallic in [0.0, 0.132_571_8, 0.5, 0.9, 1.0] {
        for roughness in [0.0, 0.3, 1.0] {
            for base in [[1.0, 1.0, 1.0], [0.9, 0.5, 0.1], [1.0, 0.0, 1.0]] {
                for ior in [0.0, 1.0, 1.5, 2.42] {
                    for tint in [
                        [1.0, 1.0, 1.0],
                        [0.0, 0.0, 0.0],
                        [1.0, 0.2, 0.0],
                        [30.0, 7.0, 1.0],
                    ] {
                        for factor in [0.0, 0.7, 1.0] {
                            materials.push(json!({
                                "pbrMetallicRoughness": { "baseColorFactor": [base[0], base[1], base[2], 1.0],
                                    "metallicFactor": metallic, "roughnessFactor": roughness },
                                "extensions": { "KHR_materials_ior": { "ior": ior },
                                    "KHR_materials_specular":
                                        { "specularFactor": factor, "specularColorFactor": tint } },
                            }));
                        }
                    }
                }
            }
        }
    }
    let mut document = Document::triangle();
    document.wear(json!(materials));
    let scene = document.load().unwrap();
    let mut most = 0.0f32;
    for ((albedo, specular), json) in reflectances(&scene).into_iter().zip(&materials) {
        let sum = (albedo + specular).max_element();
        assert!(sum <= 1.0 + ROUNDING, "{albedo} + {specular}: {json}");
        assert!(
            (albedo.min(specular)).min_element() >= 0.0,
            "{albedo} {specular}: {json}"
        );
        most = most.max(sum);
    }
    assert_eq!(scene.materials.len(), materials.len());
    assert!(most >= 1.0, "the grid reaches the bound: {most}");
}

#[test]
fn a_white_dielectric_and_a_white_metal_reflect_all_they_receive() {
    for roughness in [0.0, 0.25, 0.5, 1.0] {
        let (albedo, specular, _) =
            phong_from_metallic_roughness(Vec3::ONE, 1.0, roughness, Vec3::splat(0.04));
        assert_eq!((albedo, specular), (Vec3::ZERO, Vec3::ONE));
        for code in 0..=1000 {
            let dielectric = Vec3::splat(code as f32 / 1000.0);
            let (albedo, specular, _) =
                phong_from_metallic_roughness(Vec3::ONE, 0.0, roughness, dielectric);
            assert_eq!(albedo + specular, Vec3::ONE, "dielectric {dielectric}");
        }
    }
}

/// Kd and Ks as a file or a program gives them, with values beyond 1 among them.
fn pairs() -> Vec<([f32; 3], [f32; 3])> {
    let colors = [
        [0.0, 0.0, 0.0],
        [0.6, 0.3, 0.1],
        [0.8, 0.8, 0.8],
        [1.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [3.0, 0.5, 0.0],
    ];
    let with = |kd: [f32; 3]| colors.map(|ks| (kd, ks));
    colors.into_iter().flat_map(with).collect()
}

fn obj(pairs: &[([f32; 3], [f32; 3])]) -> Scene {
    let (folder, mut library) = (Folder::new(), String::new());
    for (i, ([r, g, b], [sr, sg, sb])) in pairs.iter().enumerate() {
        writeln!(
            library,
            "newmtl m{i}\nKd {r} {g} {b}\nKs {sr} {sg} {sb}\nNs 9"
        )
        .unwrap();
    }
    folder.write("a.mtl", library);
    let faces = (0..pairs.len()).map(|i| format!("usemtl m{i}\nf 1 2 3\n"));
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned() + &faces.collect::<String>();
    folder.load("a.obj", text).unwrap()
}

fn built(pairs: &[([f32; 3], [f32; 3])]) -> Scene {
    let material = |&(kd, ks): &_| {
        let mut material = Material::default();
        (material.albedo, material.specular) = (kd, ks);
        material
    };
    let mut mesh = Mesh::default();
    mesh.positions = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    mesh.triangles = vec![[0, 1, 2]];
    Scene::from_meshes(vec![mesh], pairs.iter().map(material).collect()).unwrap()
}

#[test]
fn kd_and_ks_add_up_to_at_most_one_and_what_was_scaled_is_counted() {
    let pairs = pairs();
    let clamped = |c: [f32; 3]| Vec3::from_array(c).clamp(Vec3::ZERO, Vec3::ONE);
    for scene in [obj(&pairs), built(&pairs)] {
        let mut scaled = 0;
        for (&(kd, ks), (albedo, specular)) in pairs.iter().zip(reflectances(&scene)) {
            let (kd, ks) = (clamped(kd), clamped(ks));
            let sum = (albedo + specular).max_element();
            assert!(
                sum <= 1.0 + ROUNDING,
                "{kd} + {ks} became {albedo} + {specular}"
            );
            if (kd + ks).max_element() <= 1.0 {
                assert_eq!((albedo, specular), (kd, ks), "both stay");
                continue;
            }
            scaled += 1;
            // One factor for all channels of both, and no smaller than it must be.
            let factor = 1.0 / (kd + ks).max_element();
            let off = (albedo - kd * factor).abs() + (specular - ks * factor).abs();
            assert!(
                off.max_element() <= ROUNDING && sum >= 1.0 - ROUNDING,
                "{kd} + {ks} became {albedo} + {specular}"
            );
        }
        assert_eq!(scene.warned(WarningKind::ReflectanceScaled), scaled);
        assert!(scaled > 0);
    }
}

#[test]
fn decimals_that_add_up_to_one_are_not_scaled() {
    let tenths: Vec<_> = (0..=1000)
        .map(|i| ([i as f32 / 1000.0; 3], [(1000 - i) as f32 / 1000.0; 3]))
        .collect();
    let scene = obj(&tenths);
    assert_eq!(scene.warned(WarningKind::ReflectanceScaled), 0);
    for ((kd, _), (albedo, _)) in tenths.iter().zip(reflectances(&scene)) {
        assert_eq!(albedo.to_array(), *kd);
    }
}

#[test]
fn both_reflectances_are_scaled_by_one_factor() {
    let scene = obj(&[([1.0, 0.5, 0.25], [1.0; 3]), ([1.0; 3], [0.6, 0.5, 0.5])]);
    let [first, second] = reflectances(&scene)[..] else {
        panic!("two materials")
    };
    assert_eq!(first, (Vec3::new(0.5, 0.25, 0.125), Vec3::splat(0.5)));
    assert_eq!(second.0, Vec3::splat(0.625));
    // All say the same, so that they are printed as one line.
    let whole = "multiplied by what makes the sum 1, by 0.5000 where it is largest";
    for (warning, place) in scene
        .warnings
        .iter()
        .zip(["material `m0`", "material `m1`"])
    {
        let told = (warning.kind.name(), warning.place.as_str(), warning.count);
        assert_eq!(told, ("reflectance-scaled", place, 1));
        assert!(warning.message.ends_with(whole), "{}", warning.message);
    }
    assert_eq!(scene.warnings.len(), 2);
    let alone = &obj(&[([1.0, 0.5, 0.25], [1.0; 3])]).warnings[0];
    let message = &alone.message;
    assert!(message.ends_with("multiplied by 0.5000"), "{message}");
}

/// The GLB of a bake has the coat off and its highlight in `extras`; who switches the coat on has changed the material.
#[test]
fn the_highlight_that_ambake_wrote_is_read_where_the_coat_is_off() {
    let highlight = |ks: serde_json::Value| json!({ "ambake": { "Ks": ks, "Ns": 30 } });
    let material = |factor: f32, metallic: f32, extras: serde_json::Value| {
        json!({
            "pbrMetallicRoughness": { "baseColorFactor": [0.25, 0.5, 0.75, 1], "metallicFactor": metallic },
            "extensions": { "KHR_materials_specular": { "specularFactor": factor } },
            "extras": extras,
        })
    };
    let ks = json!([0.5, 0.25, 0.125]);
    let mut document = Document::triangle();
    document.wear(json!([
        material(0.0, 0.0, highlight(ks.clone())),
        material(0.0, 0.0, highlight(json!([7.0, -1.0, 0.0]))),
        material(1.0, 0.0, highlight(ks.clone())),
        material(0.0, 1.0, highlight(ks)),
        material(0.0, 0.0, highlight(json!("bronze"))),
        material(0.0, 0.0, json!([1, 2])),
    ]));
    let scene = document.load().unwrap();
    let base = Vec3::new(0.25, 0.5, 0.75);
    let matt = (base, Vec3::ZERO);
    let expected = [
        (base, Vec3::new(0.5, 0.25, 0.125)),
        (base * 0.8, Vec3::X * 0.8),
        (base * 0.96, Vec3::splat(0.04)),
        (Vec3::ZERO, base),
        matt,
        matt,
    ];
    for (i, (found, expected)) in reflectances(&scene).into_iter().zip(expected).enumerate() {
        let off = (found.0 - expected.0)
            .abs()
            .max((found.1 - expected.1).abs());
        assert!(
            off.max_element() < ROUNDING,
            "material {i}: {found:?}, not {expected:?}"
        );
    }
    assert!(matches!(
        scene.materials[0].surface,
        MaterialModel::Phong { exponent: 30.0, .. }
    ));
}
