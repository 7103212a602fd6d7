//! Materials of OBJ: libraries, textures and colours.

use super::obj::{TRIANGLE, load};
use super::support::{Folder, png};
use ambake_scene::{Alpha, MaterialModel, WarningKind, Wrap};
use glam::Vec3;

#[test]
fn absent_libraries_and_textures_are_counted_and_broken_lines_too() {
    let folder = Folder::new();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    let scene = folder
        .load("a.obj", format!("mtllib no.mtl\n{triangle}"))
        .unwrap();
    assert_eq!(
        (
            scene.warned(WarningKind::MissingMaterialLibraries),
            scene.warned(WarningKind::UnknownMaterials)
        ),
        (1, 1)
    );
    folder.write("b.mtl", "newmtl m\nmap_Kd no.png\nKd\nNs x\nnewmtl\n");
    let scene = folder
        .load("b.obj", format!("mtllib b.mtl\n{triangle}"))
        .unwrap();
    assert_eq!(
        (
            scene.warned(WarningKind::MissingTextures),
            scene.warned(WarningKind::IgnoredMtlLines)
        ),
        (1, 3)
    );
    folder.write("words.png", "this is no picture");
    folder.write("c.mtl", "newmtl m\nmap_Kd words.png\n");
    let scene = folder
        .load("c.obj", format!("mtllib c.mtl\n{triangle}"))
        .unwrap();
    assert_eq!(scene.warned(WarningKind::MissingTextures), 1);
    assert!(scene.images.is_empty(), "the factor stands alone");
}

#[test]
fn bump_and_normal_maps_are_counted_one_each() {
    let folder = Folder::new();
    folder.write(
        "a.mtl",
        "newmtl a\nmap_Bump -bm 0.5 b.png\nnorm n.png\nnewmtl b\nbump b.png\nnewmtl c\nmap_bump\nKd 1 1 1\n",
    );
    let scene = folder
        .load(
            "a.obj",
            format!(
                "mtllib a.mtl\n{TRIANGLE}usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n"
            ),
        )
        .unwrap();
    let counted: Vec<_> = scene
        .warnings
        .iter()
        .map(|w| (w.kind, w.place.as_str(), w.count))
        .filter(|w| w.0 == WarningKind::IgnoredNormalMaps)
        .collect();
    assert_eq!(
        counted,
        [
            (WarningKind::IgnoredNormalMaps, "material `a`", 2),
            (WarningKind::IgnoredNormalMaps, "material `b`", 1)
        ]
    );
    assert_eq!(scene.warned(WarningKind::IgnoredMtlLines), 1);
    assert!(scene.images.is_empty());
}

#[test]
fn textures_are_read_with_their_options() {
    let folder = Folder::new();
    folder.write("my wall.png", png(&[[255, 0, 0, 255], [0, 0, 255, 255]]));
    folder.write(
        "b.mtl",
        "newmtl m\nmap_Kd -clamp on -o 0.5 0 my wall.png\nmap_d my wall.png\n",
    );
    let text =
        "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvt 0.25 0\nusemtl m\nf 1/1 2/2 3/1\n";
    let scene = folder.load("b.obj", text).unwrap();
    let MaterialModel::Phong {
        albedo_map: Some(map),
        ..
    } = &scene.materials[0].surface
    else {
        panic!()
    };
    assert_eq!(map.wrap, [Wrap::Clamp; 2]);
    let uv = scene.meshes[0].uv_sets[0][1];
    assert_eq!(scene.color(map, uv), Vec3::Z);
    // A mask without an alpha channel would give its grey; this one is opaque.
    let Alpha::Mask { map: Some(map), .. } = &scene.materials[0].alpha else {
        panic!()
    };
    assert_eq!(scene.alpha(map, uv), 1.0);
    assert_eq!(scene.images.len(), 2);
}

#[test]
fn materials_in_use_that_let_all_light_through_are_counted() {
    let folder = Folder::new();
    folder.write(
        "a.mtl",
        "newmtl a\nTr 1\nnewmtl b\nd 0\nnewmtl c\nTr 0\nnewmtl d\nd 1\nTr 1\nnewmtl unused\nd 0\n",
    );
    let faces: String = ["a", "b", "c", "d"]
        .map(|m| format!("usemtl {m}\nf 1 2 3\n"))
        .concat();
    let scene = folder
        .load("a.obj", format!("mtllib a.mtl\n{TRIANGLE}{faces}"))
        .unwrap();
    let places: Vec<_> = scene
        .warnings
        .iter()
        .map(|w| (w.kind, w.place.as_str()))
        .collect();
    let kind = WarningKind::InvisibleMaterials;
    assert_eq!(places, [(kind, "material `a`"), (kind, "material `b`")]);
}

#[test]
fn vertex_colours_in_srgb_tint_their_vertices_and_the_others_are_white() {
    let scene = load(
        "v 0 0 0\nv 1 0 0 1 0.5 0.04\nv 0 1 0 2\nv 0 0 1 nan 0 0\no a\nf 1 2 3\no b\nf 1 3 4\n",
    );
    // IEC 61966-2-1, by hand: ((0.5 + 0.055) / 1.055)^2.4 and 0.04 / 12.92.
    let tint = Vec3::new(1.0, 0.214_041_14, 0.003_095_975_2);
    let colors = &scene.meshes[0].colors;
    assert_eq!(
        (colors[0], colors[2]),
        (Vec3::ONE, Vec3::ONE),
        "a fourth number alone is no colour"
    );
    assert!(
        (colors[1] - tint).abs().max_element() < 1e-7,
        "{}",
        colors[1]
    );
    assert_eq!(
        scene.meshes[1].colors[2],
        Vec3::new(1.0, 0.0, 0.0),
        "NaN counts as 1"
    );
    assert_eq!(scene.warned(WarningKind::ClampedFactors), 1);
}

#[test]
fn black_beside_a_picture_is_the_picture_and_is_told_of() {
    let folder = Folder::new();
    let mut png = std::io::Cursor::new(Vec::new());
    let picture = image::RgbImage::from_pixel(2, 2, image::Rgb([255, 128, 0]));
    picture
        .write_to(&mut png, image::ImageFormat::Png)
        .expect("it is encoded");
    folder.write("p.png", png.into_inner());
    let text = "newmtl pictured\nKd 0 0 0\nmap_Kd p.png\nnewmtl black\nKd 0 0 0\nnewmtl dark\nKd 0 0 0.01\n\
        map_Kd p.png\n";
    folder.write("a.mtl", text);
    let uses = ["pictured", "black", "dark"].map(|name| format!("usemtl {name}\nf 1/1 2/2 3/3\n"));
    let uvs = "vt 0 0\nvt 1 0\nvt 0 1\n";
    let scene = folder.load(
        "a.obj",
        format!("mtllib a.mtl\n{TRIANGLE}{uvs}{}", uses.concat()),
    );
    let scene = scene.expect("a scene");
    let albedos = scene
        .materials
        .iter()
        .map(|material| match material.surface {
            MaterialModel::Phong { albedo, .. } => albedo,
            _ => panic!("OBJ has Phong's materials"),
        });
    let expected = [Vec3::ONE, Vec3::ZERO, Vec3::new(0.0, 0.0, 0.01)];
    assert_eq!(albedos.collect::<Vec<_>>(), expected);
    assert_eq!(scene.warned(WarningKind::BlackDiffuse), 2);
}

/// Four materials of the library have what is told of, and the faces have the last.
#[test]
fn materials_that_no_face_has_are_neither_read_nor_told_of() {
    let folder = Folder::new();
    let library = "newmtl black\nKd 0 0 0\nnewmtl bright\nKd 1 1 1\nKs 1 1 1\nnewmtl pictured\nmap_Kd none.png\n\
        newmtl far\nmap_Kd ../../elsewhere.png\nbump no.png\nNs -5\nnewmtl paint\nKd 0.8 0.3 0.2\n";
    folder.write("a.mtl", library);
    let text = format!("mtllib a.mtl\n{TRIANGLE}usemtl black\nusemtl paint\nf 1 2 3\n");
    let scene = folder.load("a.obj", text).expect("a scene");
    assert_eq!(scene.warnings, []);
    let MaterialModel::Phong { albedo, .. } =
        scene.materials[scene.meshes[0].material as usize].surface
    else {
        panic!("OBJ has Phong's materials")
    };
    assert_eq!(
        (albedo, scene.materials.len()),
        (Vec3::new(0.8, 0.3, 0.2), 1)
    );
}

#[test]
fn a_map_that_names_a_folder_or_nothing_is_none_and_one_line_says_so() {
    let folder = Folder::new();
    std::fs::create_dir(folder.write("b.mtl", "").with_file_name("pictures")).expect("a folder");
    let uvs = "vt 0 0\nvt 1 0\nvt 0 1\n";
    for named in [
        ".",
        "..",
        "./",
        "-s 1 1 1",
        "pictures",
        "C:\\art\\",
        "/art/",
    ] {
        // Beside a picture black would be white.
        let library = format!("newmtl m\nKd 0 0 0\nmap_Kd {named}\nmap_Ks {named}\nbump {named}\n");
        folder.write("a.mtl", library);
        let text = format!("mtllib a.mtl\n{TRIANGLE}{uvs}usemtl m\nf 1/1 2/2 3/3\n");
        let scene = folder.load("a.obj", text).expect("a scene");
        let told: Vec<_> = scene.warnings.iter().map(|w| (w.kind, w.count)).collect();
        let expected = [
            (WarningKind::UnreadTextures, 3),
            (WarningKind::BlackDiffuse, 1),
        ];
        assert_eq!(told, expected, "{named}");
        let material = &scene.materials[0];
        let MaterialModel::Phong {
            albedo, albedo_map, ..
        } = &material.surface
        else {
            panic!("OBJ has Phong's materials")
        };
        assert!(*albedo == Vec3::ZERO && albedo_map.is_none(), "{named}");
        assert!(material.normal_map.is_none(), "{named}");
    }
}
