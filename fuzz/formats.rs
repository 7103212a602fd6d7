//! One function a format: what a fuzzer hands bytes to, and what the suite replays the corpus through (tests/corpus.rs). Each returns
//! whatever the bytes are; a panic, a hang or memory without end is a finding.

use std::cell::RefCell;
use std::path::PathBuf;

/// A format: its name, which is the target's and the corpus folder's, and its function.
pub type Format = (&'static str, fn(&[u8]));

/// Every format that is read.
pub const FORMATS: [Format; 9] = [
    ("obj", obj),
    ("mtl", mtl),
    ("gltf", gltf),
    ("glb", glb),
    ("hdr", hdr),
    ("exr", exr),
    ("picture", picture),
    ("page", page),
    ("report", report_of),
];

/// An OBJ file.
pub fn obj(bytes: &[u8]) {
    load("a.obj", bytes);
}

/// A material library, read by an OBJ file beside it that names it and its picture.
pub fn mtl(bytes: &[u8]) {
    file("m.mtl", bytes);
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    load("m.obj", obj.as_bytes());
}

/// A glTF document as text.
pub fn gltf(bytes: &[u8]) {
    load("a.gltf", bytes);
}

/// A GLB file.
pub fn glb(bytes: &[u8]) {
    load("a.glb", bytes);
}

/// A Radiance picture.
pub fn hdr(bytes: &[u8]) {
    let _ = maps::read_unchecked(&file("a.hdr", bytes));
}

/// An OpenEXR picture.
pub fn exr(bytes: &[u8]) {
    let _ = maps::read_unchecked(&file("a.exr", bytes));
}

/// A PNG, JPEG, BMP or TGA picture, as a map and as a texture.
pub fn picture(bytes: &[u8]) {
    let _ = maps::read_unchecked(&file("a.png", bytes));
    file("t.mtl", b"newmtl m\nmap_Kd a.png\nnorm a.png\n");
    let obj = "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    load("t.obj", obj.as_bytes());
}

/// A page of a finished bake.
pub fn page(bytes: &[u8]) {
    let _ = report::read_page_exr(&file("a.0.exr", bytes));
}

/// The report of a finished bake.
pub fn report_of(bytes: &[u8]) {
    let _ = report::read_bake_report(&file("bake.json", bytes));
}

fn load(name: &str, bytes: &[u8]) {
    if let Err(error) = scene::load(&file(name, bytes)) {
        let line = error.to_string();
        assert!(!line.contains('\n') && line.len() < 10_000, "{line}");
    }
}

/// A file in a folder of this thread, in memory where the system has such a place: a disk would be waited for.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    thread_local!(static FOLDER: RefCell<Option<tempfile::TempDir>> = const { RefCell::new(None) });
    FOLDER.with_borrow_mut(|folder| {
        let folder = folder.get_or_insert_with(|| {
            tempfile::tempdir_in("/dev/shm")
                .or_else(|_| tempfile::tempdir())
                .expect("a temporary folder")
        });
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("the folder is writable");
        path
    })
}
