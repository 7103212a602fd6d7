//! Broken OBJ files.

use super::{Case, refuse_all};
use crate::support::{bake, report};

const SOUND: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn face(line: &str) -> Vec<u8> {
    format!("{SOUND}{line}\n").into_bytes()
}

#[test]
fn broken_obj_files_are_refused() {
    refuse_all(&[
        Case::scene("no byte at all", "empty.obj", []),
        Case::scene("no face", "no_face.obj", SOUND),
        Case::scene("an index of 0", "zero.obj", face("f 0 1 2")),
        Case::scene(
            "an index beyond the vertices",
            "beyond.obj",
            face("f 1 2 4"),
        ),
        Case::scene(
            "a negative index beyond the vertices",
            "negative.obj",
            face("f -1 -2 -4"),
        ),
        Case::scene(
            "an index beyond 64 bits",
            "huge_index.obj",
            face("f 1 2 99999999999999999999999"),
        ),
        Case::scene(
            "an index of 4 thousand million",
            "large_index.obj",
            face("f 1 2 4294967295"),
        ),
        Case::scene(
            "a UV index beyond the UVs",
            "uv_index.obj",
            face("vt 0 0\nf 1/1 2/1 3/2"),
        ),
        Case::scene(
            "a normal index beyond the normals",
            "normal_index.obj",
            face("vn 0 0 1\nf 1//1 2//1 3//5"),
        ),
        Case::scene("a face of letters", "letters.obj", face("f a b c")),
        Case::scene("a face of two corners only", "two.obj", face("f 1 2")),
        Case::scene(
            "a position that is not a number",
            "nan.obj",
            "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        ),
        Case::scene(
            "an infinite position",
            "infinite.obj",
            "v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        ),
        Case::scene(
            "a position beyond f32",
            "large.obj",
            "v 1e39 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        ),
        Case::scene(
            "a position of two numbers",
            "short.obj",
            "v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        ),
        Case::scene(
            "a position of letters",
            "words.obj",
            "v x y z\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        ),
        Case::scene(
            "only a triangle without area",
            "flat.obj",
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
        ),
        Case::scene(
            "bytes of something else",
            "binary.obj",
            (0..=255u8).cycle().take(5000).collect::<Vec<_>>(),
        ),
    ]);
}

#[test]
fn absent_material_file_is_a_counted_warning() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let path = folder.path().join("no_mtl.obj");
    std::fs::write(
        &path,
        format!("mtllib nowhere.mtl\n{SOUND}usemtl gone\nf 1 2 3\n"),
    )
    .expect("the folder is writable");
    let (out, _page) = bake(&path, &["--size", "32", "--rays", "4"]);
    let warnings = report(out.path())["warnings"].to_string();
    assert!(warnings.contains("nowhere.mtl"), "{warnings}");
}
