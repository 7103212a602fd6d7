//! Scenes built in memory.

use super::support::Folder;
use ambake_scene::authored::{AlphaMode, Material, Mesh, MetallicRoughness, Placement, Texture};
use ambake_scene::{Alpha, Error, Format, MaterialModel, Scene, WarningKind};
use glam::{DVec3, Vec2, Vec3};

/// A square of edge 1 in the plane z = 0.
fn square() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.name = "square".into();
    mesh.positions = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
    mesh
}

fn built(mesh: Mesh) -> Scene {
    Scene::from_meshes(vec![mesh], vec![]).unwrap_or_else(|e| panic!("{e}"))
}

fn of_material(material: Material) -> Scene {
    let mut mesh = square();
    mesh.uvs = vec![[0., 1.], [1., 1.], [1., 0.], [0., 0.]];
    Scene::from_meshes(vec![mesh], vec![material]).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_built_scene_equals_the_loaded_one() {
    let text = "o square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n\
                f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\n";
    let loaded = Folder::new().load("a.obj", text).unwrap();
    let mut mesh = square();
    mesh.normals = vec![[0., 0., 1.]; 4];
    mesh.uvs = vec![[0., 1.], [1., 1.], [1., 0.], [0., 0.]];
    let built = built(mesh);
    assert_eq!(
        format!("{:?}", built.meshes),
        format!("{:?}", loaded.meshes)
    );
    assert_eq!(
        format!("{:?}", built.instances),
        format!("{:?}", loaded.instances)
    );
    assert_eq!(
        format!("{:?}", built.materials),
        format!("{:?}", loaded.materials)
    );
    assert_eq!(
        (built.format, built.path.to_str()),
        (Format::Memory, Some("scene"))
    );
    assert!(built.warnings.is_empty(), "{:?}", built.warnings);
}

#[test]
fn the_default_material_is_the_one_of_a_scene_without_materials() {
    let (given, none) = (of_material(Material::default()), built(square()));
    let [given, none] = [given, none].map(|scene| {
        let mut material = scene.materials[0].clone();
        material.name.clear();
        format!("{material:?}")
    });
    assert_eq!(given, none);
}

#[test]
fn transforms_are_column_major_and_names_have_stand_ins() {
    let mut mesh = square();
    mesh.name.clear();
    mesh.transform = [
        [0., 2., 0., 0.],
        [-1., 0., 0., 0.],
        [0., 0., 1., 0.],
        [5., 6., 7., 1.],
    ];
    let scene = built(mesh);
    assert_eq!(
        scene.instances[0].transform.transform_point3(DVec3::X),
        DVec3::new(5.0, 8.0, 7.0)
    );
    assert_eq!(
        (
            scene.meshes[0].name.as_str(),
            scene.instances[0].name.as_str()
        ),
        ("mesh 0", "mesh 0")
    );
}

#[test]
fn materials_reach_the_scene_with_their_texture() {
    let mut leaf = Material::default();
    leaf.albedo = [0.5, 1.0, 0.25];
    leaf.specular = [0.25, 0.0, 0.0];
    leaf.exponent = 20.0;
    leaf.emission = [0.0, 3.0, 0.0];
    leaf.alpha = 0.75;
    leaf.alpha_mode = AlphaMode::Mask { cutoff: 0.4 };
    leaf.double_sided = false;
    leaf.albedo_texture = Some(Texture::new(1, 2, vec![[255, 0, 0, 255], [0, 255, 0, 0]]));
    let scene = of_material(leaf);
    let material = &scene.materials[0];
    let MaterialModel::Phong {
        albedo,
        albedo_map: Some(map),
        specular,
        exponent,
    } = &material.surface
    else {
        panic!("{material:?}")
    };
    assert_eq!(
        (*albedo, *specular, *exponent),
        (Vec3::new(0.5, 1.0, 0.25), Vec3::X * 0.25, 20.0)
    );
    assert_eq!(
        (material.emission, material.double_sided),
        (Vec3::Y * 3.0, false)
    );
    // Row 0 is the top of the picture, where v is small.
    assert_eq!(scene.color(map, Vec2::new(0.5, 0.25)), Vec3::X);
    let Alpha::Mask {
        cutoff: 0.4,
        factor: 0.75,
        map: Some(map),
    } = &material.alpha
    else {
        panic!("{:?}", material.alpha)
    };
    assert_eq!(scene.alpha(map, Vec2::new(0.5, 0.75)), 0.0);
}

#[test]
fn junk_is_repaired_and_counted_as_in_a_file() {
    let mut mesh = square();
    mesh.triangles.push([0, 1, 1]);
    mesh.positions.push([f32::NAN; 3]);
    mesh.normals = vec![
        [0., 0., 2.],
        [0., 0., 0.],
        [0., 0., 1.],
        [0., 0., 1.],
        [1., 0., 0.],
    ];
    mesh.uvs = vec![[0., 0.], [f32::NAN, 0.], [1., 1.], [0., 1.], [0., 0.]];
    let mut flat = square();
    flat.transform[2][2] = 0.0;
    let mut paint = Material::default();
    paint.albedo = [2.0, 0.5, f32::NAN];
    paint.exponent = f64::INFINITY;
    paint.alpha_mode = AlphaMode::Mask { cutoff: -1.0 };
    let scene = Scene::from_meshes(vec![mesh, flat], vec![paint]).unwrap();
    assert_eq!(
        scene.meshes[0].normals,
        [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::Z, Vec3::X]
    );
    for (kind, count) in [
        (WarningKind::ZeroAreaTriangles, 1),
        (WarningKind::UnusedBadVertices, 1),
        (WarningKind::BadNormals, 1),
        (WarningKind::BadUvs, 1),
        (WarningKind::SingularTransforms, 1),
        (WarningKind::ClampedFactors, 4),
    ] {
        assert_eq!(scene.warned(kind), count, "{kind}: {:?}", scene.warnings);
    }
    assert_eq!(scene.warnings[0].place, "material 0");
    assert_eq!(scene.instances.len(), 1);

    let mut paint = Material::default();
    paint.albedo_texture = Some(Texture::new(1, 1, vec![[0; 4]]));
    let scene = Scene::from_meshes(vec![square()], vec![paint]).unwrap();
    assert_eq!(scene.warned(WarningKind::TexturesWithoutUvs), 1);
}

/// The message for the scene of one mesh and materials, checked for its form.
fn refused(needle: &str, edit: impl FnOnce(&mut Mesh, &mut Vec<Material>)) {
    let (mut mesh, mut materials) = (square(), Vec::new());
    edit(&mut mesh, &mut materials);
    let error = Scene::from_meshes(vec![mesh], materials).expect_err(needle);
    assert!(matches!(error, Error::Authored { .. }), "{error:?}");
    let message = error.to_string();
    assert!(message.contains(needle), "`{needle}` is not in: {message}");
    assert!(
        !message.contains('\n') && !message.contains("file"),
        "{message}"
    );
}

#[test]
fn contradictions_are_one_line_that_names_the_mesh() {
    let name = "mesh 0 `square`: ";
    let at = |problem: &str| format!("{name}{problem}");
    refused(
        &at("triangle 1 uses vertices [0, 2, 4] but there are 4"),
        |m, _| {
            m.triangles[1][2] = 4;
        },
    );
    refused(&at("vertex 2 of triangle 0 lies at (inf, 0, 0)"), |m, _| {
        m.positions[2] = [f32::INFINITY, 0.0, 0.0];
    });
    refused(
        &at("vertex 0 of triangle 0 lies at (2000000000000000000"),
        |m, _| {
            m.positions[0][0] = 2e18;
        },
    );
    refused(&at("3 normals for 4 positions"), |m, _| {
        m.normals = vec![[0., 0., 1.]; 3]
    });
    refused(&at("5 uvs for 4 positions"), |m, _| {
        m.uvs = vec![[0.0; 2]; 5]
    });
    refused(&at("1 colors for 4 positions"), |m, _| {
        m.colors = vec![[0.0; 4]]
    });
    refused(&at("it is of material 1 but there are 1"), |m, _| {
        m.material = 1
    });
    refused(&at("its transform is not affine"), |m, _| {
        m.transform[0][3] = 1.0
    });
    refused(&at("its transform is not affine"), |m, _| {
        m.transform[3][3] = f32::NAN
    });
    refused("square: its transform puts the mesh beyond", |m, _| {
        m.transform[0][0] = 1e30
    });
    refused("square: its transform puts the mesh beyond", |m, _| {
        m.transform[0][0] = f32::NAN
    });
    refused("a b: its transform puts the mesh beyond", |m, _| {
        m.name = "a\nb".into();
        m.transform[0][0] = 1e30;
    });
    refused(
        "material 0 `wood`: its texture has 1 pixels, but 1 x 2",
        |_, materials| {
            let mut wood = Material::default();
            wood.name = "wood".into();
            wood.albedo_texture = Some(Texture::new(1, 2, vec![[0; 4]]));
            materials.push(wood);
        },
    );
    refused("its texture has 0 pixels", |_, materials| {
        let mut wood = Material::default();
        wood.albedo_texture = Some(Texture::new(0, 2, vec![]));
        materials.push(wood);
    });
}

#[test]
fn a_scene_without_a_triangle_is_refused_with_what_was_ignored() {
    let empty = Scene::from_meshes(vec![], vec![]).unwrap_err().to_string();
    assert_eq!(
        empty,
        "scene: no mesh has a triangle with an area; hand over at least one"
    );
    refused("; the mesh has no triangle with an area", |m, _| {
        m.triangles.clear()
    });
    refused(
        "; faces without an area are dropped; the mesh has no",
        |m, _| m.triangles = vec![[0, 1, 1]],
    );
    refused("; the transform has no inverse", |m, _| {
        m.transform[1][1] = 0.0
    });
    let shrunk = |m: &mut Mesh, size: f32| {
        (0..3).for_each(|k| m.transform[k][k] = size);
        // Where it stands says nothing about how large it is.
        m.transform[3][0] = 1e9;
    };
    refused("; the instance is smaller than", move |m, _| {
        shrunk(m, 1e-13)
    });
    let mut small = square();
    shrunk(&mut small, 1e-11);
    assert!(Scene::from_meshes(vec![small], vec![Material::default()]).is_ok());
}

type Edit = fn(&mut Mesh, &mut Material);

fn texture() -> Texture {
    Texture::new(1, 1, vec![[7; 4]])
}

fn metal(edit: fn(&mut MetallicRoughness)) -> MetallicRoughness {
    let mut of = MetallicRoughness::default();
    edit(&mut of);
    of
}

#[test]
fn placements_share_their_mesh_and_come_after_its_own_transform() {
    let mut mesh = square();
    mesh.transform[3] = [1.0, 0.0, 0.0, 1.0];
    let mut far = Placement::default();
    far.name = "far".into();
    far.transform[0][0] = 2.0;
    far.transform[3] = [0.0, 0.0, 5.0, 1.0];
    let two = vec![Placement::default(), far.clone()];
    let scene = Scene::from_placements(vec![mesh.clone(), square()], vec![], two.clone());
    let scene = scene.unwrap();
    assert_eq!(scene.meshes.len(), 1, "a mesh without a place is left out");
    let names: Vec<_> = scene.instances.iter().map(|of| of.name.as_str()).collect();
    assert_eq!(names, ["square", "far"]);
    let at = |k: usize| scene.instances[k].transform.transform_point3(DVec3::X);
    assert_eq!((at(0), at(1)), (DVec3::X * 2.0, DVec3::new(4.0, 0.0, 5.0)));

    let once = Scene::from_meshes(vec![mesh.clone(), square()], vec![]).unwrap();
    assert_ne!(once.content_hash, scene.content_hash);
    far.mesh = 2;
    let error = Scene::from_placements(vec![mesh, square()], vec![], vec![far]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "placement 0 `far`: it places mesh 2 but there are 2, numbered from 0; correct its number"
    );
    let none = Scene::from_placements(vec![square()], vec![], vec![]);
    assert!(matches!(none, Err(Error::Authored { .. })));
}

#[test]
fn a_normal_texture_comes_back_pixel_by_pixel() {
    let pixels: Vec<[u8; 4]> = (0..6).map(|k| [40 * k, 255 - k, 128, k]).collect();
    let mut material = Material::default();
    material.normal_texture = Some(Texture::new(3, 2, pixels.clone()));
    let scene = of_material(material);
    let map = scene.materials[0].normal_map.as_ref().expect("a map");
    assert_eq!(scene.normal_image(map).unwrap().pixels, pixels);
}

#[test]
fn the_hash_covers_everything_handed_over() {
    let hash = |edit: Edit| {
        let (mut mesh, mut material) = (square(), Material::default());
        mesh.normals = vec![[0., 0., 1.]; 4];
        mesh.uvs = vec![[0.0; 2]; 4];
        material.albedo_texture = Some(Texture::new(1, 2, vec![[9; 4]; 2]));
        edit(&mut mesh, &mut material);
        let scene = Scene::from_meshes(vec![mesh], vec![material, Material::default()]);
        scene.unwrap().content_hash
    };
    let edits: [Edit; 33] = [
        |_, _| {},
        |mesh, _| mesh.name.push('s'),
        |mesh, _| mesh.positions[3][2] = -0.0,
        |mesh, _| mesh.normals[3][2] = 2.0,
        |mesh, _| mesh.normals.clear(),
        |mesh, _| mesh.uvs[3][1] = 0.5,
        |mesh, _| mesh.triangles.truncate(1),
        |mesh, _| mesh.material = 1,
        |mesh, _| mesh.transform[3][1] = 1.0,
        |_, material| material.name.push('m'),
        |_, material| material.albedo[2] = 0.5,
        |_, material| material.albedo_texture = Some(Texture::new(2, 1, vec![[9; 4]; 2])),
        |_, material| material.albedo_texture = Some(Texture::new(1, 2, vec![[9; 4], [8; 4]])),
        |_, material| material.specular[0] = 0.5,
        |_, material| material.exponent = 1.0,
        |_, material| material.emission[1] = 1.0,
        |_, material| material.alpha = 0.5,
        |_, material| material.alpha_mode = AlphaMode::Mask { cutoff: 0.5 },
        |_, material| material.double_sided = false,
        |_, material| material.alpha_mode = AlphaMode::Mask { cutoff: 0.0 },
        |_, material| material.alpha_mode = AlphaMode::Blend,
        |mesh, _| mesh.tangents = vec![[1., 0., 0., 1.]; 4],
        |mesh, _| mesh.lightmap_uvs = vec![[0.0; 2]; 4],
        |mesh, _| mesh.colors = vec![[1.0; 4]; 4],
        |_, material| material.emission_texture = Some(texture()),
        |_, material| material.normal_texture = Some(texture()),
        |_, material| material.normal_scale = 2.0,
        |_, material| material.metallic_roughness = Some(metal(|_| ())),
        |_, material| material.metallic_roughness = Some(metal(|of| of.metallic = 0.5)),
        |_, material| material.metallic_roughness = Some(metal(|of| of.roughness = 0.5)),
        |_, material| material.metallic_roughness = Some(metal(|of| of.dielectric[1] = 0.5)),
        |_, material| material.metallic_roughness = Some(metal(|of| of.texture = Some(texture()))),
        |mesh, material| {
            mesh.colors = vec![[0.5; 4]; 4];
            material.metallic_roughness = Some(metal(|_| ()));
        },
    ];
    let hashes: Vec<String> = edits.iter().map(|edit| hash(*edit)).collect();
    for (i, a) in hashes.iter().enumerate() {
        assert!(a.len() == 64 && !hashes[..i].contains(a), "edit {i}: {a}");
    }
    assert_eq!(hashes[0], hash(|_, _| {}));
}
