//! OBJ and MTL.

use super::support::{Folder, png};
use ambake_scene::{Alpha, MaterialModel, Scene, WarningKind};
use glam::{Vec2, Vec3};

pub fn load(text: &str) -> Scene {
    Folder::new()
        .load("a.obj", text)
        .unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn negative_indices_crlf_continuations_and_a_missing_newline_give_the_plain_triangle() {
    let plain = load("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let odd = load("v 0 0 0\r\nv 1 0 \\\r\n 0\r\nv 0 1 0 0.5 0.5 0.5\r\nf -3 -2 3 # corner");
    assert_eq!(plain.meshes[0].positions, odd.meshes[0].positions);
    assert_eq!(plain.meshes[0].triangles, odd.meshes[0].triangles);
    assert!(plain.meshes[0].normals.is_empty() && plain.meshes[0].uv_sets.is_empty());
}

#[test]
fn a_concave_polygon_covers_its_area_once() {
    let scene = load("v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 2 3 4 1\n");
    let mesh = &scene.meshes[0];
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
        (b - a).cross(c - a).z / 2.0
    };
    assert_eq!(
        mesh.triangles
            .iter()
            .map(area)
            .collect::<Vec<_>>()
            .iter()
            .sum::<f32>(),
        4.0
    );
    assert!(mesh.triangles.iter().all(|t| area(t) > 0.0));
}

#[test]
fn corners_without_vt_or_vn_do_not_shift_the_others() {
    let scene = load(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.25 0.75\nvn 0 3 4\nf 1 2 3\nf 2/1/1 4/1/1 3/1/1\nf 1//1 2//1 4/1\n",
    );
    let mesh = &scene.meshes[0];
    let corner = |t: usize, k: usize| mesh.triangles[t][k] as usize;
    assert_eq!(mesh.uv_sets[0][corner(1, 0)], Vec2::new(0.25, 0.25));
    assert_eq!(mesh.normals[corner(1, 0)], Vec3::new(0.0, 0.6, 0.8));
    // No vn: the geometric normal; no vt: the origin, counted.
    assert_eq!(mesh.normals[corner(0, 0)], Vec3::Z);
    assert_eq!(mesh.uv_sets[0][corner(0, 0)], Vec2::ZERO);
    assert_eq!(
        (
            scene.warned(WarningKind::MissingUvs),
            scene.warned(WarningKind::BadNormals)
        ),
        (5, 4)
    );
}

#[test]
fn groups_and_materials_make_parts_and_a_part_may_be_resumed() {
    let folder = Folder::new();
    folder.write(
        "a.mtl",
        "newmtl red\nKd 1 0 0\nKs 0.5\nNs 20\nKe 2 3 0.5\nnewmtl thin\nKd 2 nan 0.5\nTr 0.75\n",
    );
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\no box\nusemtl red\nf 1 2 3\nusemtl thin\nf 1 2 3\n\
                usemtl red\nf 1 3 2\ng lid\nf 1 2 3\no ball\nusemtl gone\nf 1 2 3\n";
    let scene = folder.load("a.obj", text).unwrap();
    let parts: Vec<_> = scene
        .meshes
        .iter()
        .map(|m| (m.name.as_str(), m.material, m.triangles.len()))
        .collect();
    assert_eq!(
        parts,
        [
            ("box", 0, 2),
            ("box", 1, 1),
            ("box/lid", 0, 1),
            ("ball", 2, 1)
        ]
    );
    let MaterialModel::Phong {
        albedo,
        specular,
        exponent,
        ..
    } = scene.materials[0].surface
    else {
        panic!()
    };
    assert_eq!(
        (albedo, specular, exponent),
        (
            Vec3::X * (1.0f64 / 1.5) as f32,
            Vec3::splat((0.5f64 / 1.5) as f32),
            20.0
        ),
        "Kd 1 beside Ks 0.5: both divided by 1.5"
    );
    assert_eq!(scene.materials[0].emission, Vec3::new(2.0, 3.0, 0.5));
    assert_eq!(scene.materials[1].emission, Vec3::ZERO);
    let MaterialModel::Phong { albedo, .. } = scene.materials[1].surface else {
        panic!()
    };
    assert_eq!(albedo, Vec3::new(1.0, 1.0, 0.5));
    assert!(matches!(scene.materials[1].alpha, Alpha::Blend { factor, .. } if factor == 0.25));
    assert!(scene.materials.iter().all(|m| m.double_sided));
    assert_eq!(
        (
            scene.warned(WarningKind::UnknownMaterials),
            scene.warned(WarningKind::ClampedFactors)
        ),
        (1, 2)
    );
}

#[test]
fn junk_is_dropped_with_the_numbers_of_what_is_left() {
    let scene = load(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nv nan 0 0\nf 1 1 2\nf 1 2 3\nf 1 2 4\nf 3 2 4\nl 1 2\np 1\n",
    );
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.source_triangles, [1, 3]);
    assert_eq!(
        (
            scene.warned(WarningKind::ZeroAreaTriangles),
            scene.warned(WarningKind::IgnoredLinesAndPoints)
        ),
        (2, 2)
    );
    // Scripts look for the words.
    let words: Vec<_> = scene
        .warnings
        .iter()
        .map(|w| serde_json::to_value(w).unwrap()["kind"].clone())
        .collect();
    assert_eq!(words, ["ignored-lines-and-points", "zero-area-triangles"]);
}

#[test]
fn faces_without_an_area_are_counted_and_not_triangles_that_a_polygon_was_cut_into() {
    // A square with corners in the middle of its sides and one twice, a square of four corners in line, a triangle
    // between coincident ones, and one that is sound.
    let corners = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\nv 2 2 0\nv 1 2 0\nv 0 2 0\nv 0 1 0\n";
    let outlines = "f 1 2 3 4 5 6 7 8\nf 1 3 3 5 7\n";
    let sound = load(&format!("{corners}{outlines}"));
    assert!(sound.warnings.is_empty(), "{:?}", sound.warnings);
    let twice: f32 = (sound.meshes[0].triangles.iter())
        .map(|t| t.map(|k| sound.meshes[0].positions[k as usize]))
        .map(|[a, b, c]| (b - a).cross(c - a).length())
        .sum();
    assert_eq!(twice, 16.0);
    let scene = load(&format!(
        "{corners}f 1 2 3 2\n{outlines}f 1 2 2\nf 1 2 3\nf 1 3 5\n"
    ));
    assert_eq!(scene.warned(WarningKind::ZeroAreaTriangles), 3);
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.source_triangles.len(), mesh.triangles.len());
    assert_eq!(mesh.source_triangles.last(), Some(&13));
}

#[test]
fn the_hash_covers_every_file_read() {
    let folder = Folder::new();
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
    folder.write("a.mtl", "newmtl m\n");
    let first = folder.load("a.obj", text).unwrap().content_hash;
    assert_eq!(first, blake3_of(&[text, "newmtl m\n"].concat()));
    folder.write("a.mtl", "newmtl n\n");
    assert_ne!(first, folder.load("a.obj", text).unwrap().content_hash);
}

fn blake3_of(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

pub const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn lines_that_end_in_any_way_are_the_same_lines_and_have_the_same_numbers() {
    let text = format!("{TRIANGLE}vt 0.5 0.25\n\nf 1/1 2/1 \\\n3/1\n");
    let plain = load(&text);
    for end in ["\r\n", "\r"] {
        let odd = load(&text.replace('\n', end));
        assert_eq!(
            odd.meshes[0].positions, plain.meshes[0].positions,
            "{end:?}"
        );
        assert_eq!(odd.meshes[0].uv_sets, plain.meshes[0].uv_sets, "{end:?}");
        let bad = format!("{TRIANGLE}f 1 2 4\n").replace('\n', end);
        let error = Folder::new().load("a.obj", bad).unwrap_err().to_string();
        assert!(error.contains("line 4"), "{error}");
    }
    let folder = Folder::new();
    folder.write("a.mtl", "newmtl m\rKd 0.5 0.25 1\r");
    let scene = folder.load(
        "a.obj",
        format!("mtllib a.mtl\rusemtl m\r{TRIANGLE}f 1 2 3\r"),
    );
    let MaterialModel::Phong { albedo, .. } = scene.unwrap().materials[0].surface else {
        panic!()
    };
    assert_eq!(albedo, Vec3::new(0.5, 0.25, 1.0));
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_first_line() {
    let folder = Folder::new();
    folder.write("a.mtl", "\u{feff}newmtl m\nKd 0.5 0.5 0.5\n");
    let text = format!("mtllib a.mtl\n\u{feff}usemtl m\n\u{feff}{TRIANGLE}\u{feff}f 1 2 3\n");
    assert_eq!(
        folder.load("c.obj", text).unwrap().meshes[0]
            .triangles
            .len(),
        1
    );
    let text = format!("\u{feff}mtllib a.mtl\nusemtl m\n{TRIANGLE}f 1 2 3\n");
    let joined =
        "\u{feff}newmtl first\n\u{feff}# another\n\u{feff}newmtl m\n\u{feff}Kd 0.5 0.5 0.5\n";
    folder.write("a.mtl", joined);
    let scene = folder.load("d.obj", &text).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let own = scene.meshes[0].material as usize;
    assert_eq!(scene.materials[own].name, "m");
    folder.write("a.mtl", "\u{feff}newmtl m\nKd 0.5 0.5 0.5\n");
    let scene = folder.load("a.obj", text).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(scene.materials[0].name, "m");
    let scene = folder
        .load("b.obj", format!("\u{feff}{TRIANGLE}f 1 2 3\n"))
        .unwrap();
    assert_eq!(scene.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
}

#[test]
fn numbers_that_are_none_and_index_0_are_repaired_and_counted() {
    for odd in [
        "nan",
        "-nan",
        "-nan(ind)",
        "nan(snan)",
        "NaNQ",
        "-1.#IND",
        "1.#QNAN",
        "1.#INF00",
        "1.#J",
    ] {
        let text =
            format!("{TRIANGLE}vt {odd} 0\nvt 1 1\nvn 0 0 {odd}\nvn 0 1 0\nf 1/1/1 2/2/2 3/2/2\n");
        let scene = load(&text);
        let mesh = &scene.meshes[0];
        assert_eq!(
            (mesh.normals[0], mesh.normals[1]),
            (Vec3::Z, Vec3::Y),
            "{odd}"
        );
        assert_eq!(mesh.uv_sets[0][0], Vec2::ZERO, "{odd}");
        let counts = [WarningKind::BadUvs, WarningKind::BadNormals].map(|kind| scene.warned(kind));
        assert_eq!(counts, [1, 1], "{odd}");
        let used = format!("v {odd} 0 0\n{TRIANGLE}f 1 2 3\n");
        let error = Folder::new().load("a.obj", used).unwrap_err().to_string();
        assert!(error.contains("not finite"), "{error}");
    }
    let scene = load(&format!(
        "{TRIANGLE}vt 0.5 1\nvn 0 1 0\nf 1/0/0 2/1/1 3/1/1\n"
    ));
    assert_eq!(
        (scene.meshes[0].normals[0], scene.meshes[0].uv_sets[0][0]),
        (Vec3::Z, Vec2::ZERO)
    );
    let kinds = [
        WarningKind::IgnoredUvReferences,
        WarningKind::IgnoredNormalReferences,
    ];
    assert_eq!(kinds.map(|kind| scene.warned(kind)), [1, 1]);
}

#[test]
fn names_of_any_length_stay_names_of_their_own() {
    let (folder, start) = (Folder::new(), "n".repeat(300));
    folder.write(
        "a.mtl",
        format!("newmtl {start}a\nKd 1 0 0\nnewmtl {start}b\nKd 0 1 0\n"),
    );
    let scene = folder.load("a.obj", format!(
        "mtllib a.mtl\n{TRIANGLE}o {start}a\nusemtl {start}a\nf 1 2 3\no {start}b\nusemtl {start}b\nf 1 3 2\n"
    )).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let albedos = [0, 1].map(|mesh| {
        let material = &scene.materials[scene.meshes[mesh].material as usize];
        let MaterialModel::Phong { albedo, .. } = material.surface else {
            panic!()
        };
        albedo
    });
    assert_eq!(albedos, [Vec3::X, Vec3::Y]);
    assert_ne!(scene.meshes[0].name, scene.meshes[1].name);
    assert!(scene.meshes.iter().all(|mesh| mesh.name.len() <= 200));
}

#[test]
fn names_that_are_not_utf_8_stay_names_of_their_own() {
    let folder = Folder::new();
    // In GBK: a window, a bed, and a name of a byte that Latin-1 takes for white space.
    let names: [&[u8]; 3] = [b"\xb4\xb0", b"\xb4\xb2", b"\xb4\xa0"];
    let colours: [&[u8]; 3] = [b"1 0 0", b"0 1 0", b"0 0 1"];
    let line = |keyword: &[u8], rest: &[u8]| [keyword, b" ", rest, b"\n"].concat();
    let library = names
        .iter()
        .zip(colours)
        .map(|(name, colour)| [line(b"newmtl", name), line(b"Kd", colour)].concat());
    folder.write("a.mtl", library.collect::<Vec<_>>().concat());
    let parts = names.map(|name| {
        [
            line(b"o", name),
            line(b"usemtl", name),
            line(b"f", b"1 2 3"),
        ]
    });
    let text = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let text = [&text[..], &parts.concat().concat()].concat();
    let scene = folder.load("a.obj", text).unwrap_or_else(|e| panic!("{e}"));
    let albedos: Vec<Vec3> = (scene.meshes.iter())
        .map(
            |mesh| match scene.materials[mesh.material as usize].surface {
                MaterialModel::Phong { albedo, .. } => albedo,
                _ => panic!("a material of an OBJ"),
            },
        )
        .collect();
    assert_eq!(albedos, Vec3::AXES);
    let names: Vec<&str> = scene.instances.iter().map(|of| &*of.name).collect();
    assert_eq!(names, ["\u{b4}\u{b0}", "\u{b4}\u{b2}", "\u{b4}\u{a0}"]);
}

#[test]
fn files_are_found_beside_the_scene_and_in_other_case_with_a_line() {
    let folder = Folder::new();
    let textures = folder.write("Wall.PNG", png(&[[255, 0, 0, 255]]));
    let textures = textures.with_file_name("Textures");
    std::fs::create_dir(&textures).unwrap();
    std::fs::write(textures.join("floor.png"), png(&[[0, 255, 0, 255]])).unwrap();
    for (named, red) in [
        ("wall.png", true),
        ("/art/of/somebody/wall.png", true),
        ("C:\\art\\wall.png", true),
        ("textures\\Floor.png", false),
        ("D:\\art\\TEXTURES\\FLOOR.png", false),
        ("../elsewhere/textures/floor.png", false),
    ] {
        folder.write("Room.mtl", format!("newmtl m\nmap_Kd {named}\n"));
        let text = format!("mtllib room.MTL\nusemtl m\n{TRIANGLE}vt 0 0\nf 1/1 2/1 3/1\n");
        let scene = folder.load("a.obj", text).unwrap();
        // The library and the texture.
        let kinds: Vec<_> = scene.warnings.iter().map(|w| w.kind).collect();
        assert_eq!(kinds, [WarningKind::FilesFoundElsewhere; 2], "{named}");
        let expected = if red {
            [255, 0, 0, 255]
        } else {
            [0, 255, 0, 255]
        };
        assert_eq!(scene.images[0].pixels, [expected], "{named}");
    }
}
