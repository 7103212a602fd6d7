//! One function a format: what a fuzzer hands bytes to, and what the suite replays the corpus through
//! (tests/corpus.rs). Each returns whatever the bytes are; a panic, a hang or memory without end is a finding.

use ambake::{Bake, Layout, Parts, Shard};
use report::Journal;
use serde_json::Value;
use std::cell::RefCell;
use std::path::PathBuf;

/// A format: its name, which is the target's and the corpus folder's, and its function.
pub type Format = (&'static str, fn(&[u8]));

/// Every format that is read.
pub const FORMATS: [Format; 12] = [
    ("obj", obj),
    ("mtl", mtl),
    ("gltf", gltf),
    ("glb", glb),
    ("hdr", hdr),
    ("exr", exr),
    ("picture", picture),
    ("page", page),
    ("report", report_of),
    ("state", state),
    ("part", part),
    ("layout", layout),
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
    let _ = environment::read_unchecked(&file("a.hdr", bytes));
}

/// An OpenEXR picture.
pub fn exr(bytes: &[u8]) {
    let _ = environment::read_unchecked(&file("a.exr", bytes));
}

/// A PNG, JPEG, BMP or TGA picture, as a map and as a texture.
pub fn picture(bytes: &[u8]) {
    let _ = environment::read_unchecked(&file("a.png", bytes));
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

/// The saved state of a bake, the part of a shard, or a layout: they are journals. One that is damaged starts anew,
/// with a line that says so; what is read of a sound one is what it held.
pub fn state(bytes: &[u8]) {
    let path = file(".a.ambake-resume", bytes);
    let found = Journal::open(&path).ok().flatten().map(|mut journal| {
        let blocks = (0..journal.len()).map(|number| {
            let tag = journal.tag(number).expect("it was read before");
            let block = journal.block(number).expect("it was read before");
            assert_eq!(tag.is_some(), block.len() >= 4);
            block.len()
        });
        blocks.collect::<Vec<_>>()
    });
    let resumed = Journal::resume(&path, &Value::Null, |_| true);
    let (journal, damage) = resumed.expect("the folder is writable");
    assert_eq!(damage.is_some(), found.is_none() && !bytes.is_empty());
    assert_eq!(journal.len(), found.map_or(0, |blocks| blocks.len()));
}

/// The part of a shard whose blocks were altered before they were given their checksums: `ambake merge` reads it.
pub fn part(bytes: &[u8]) {
    with_sound(|sound| {
        write_journal(&sound.part_path, &sound.part, bytes);
        let parts = Parts::find(sound.folder.path());
        let line = match parts.map(|parts| sound.job.merge(parts, &())) {
            Ok(Ok(_)) => return,
            Ok(Err(error)) | Err(error) => error.to_string(),
        };
        assert!(!line.contains('\n') && line.len() < 10_000, "{line}");
    });
}

/// A layout whose blocks were altered before they were given their checksums: a bake takes it, or makes its own.
pub fn layout(bytes: &[u8]) {
    with_sound(|sound| {
        write_journal(&sound.layout_path, &sound.layout, bytes);
        let bake = sound.bake.clone().layout_file(&sound.layout_path);
        bake.run(&()).expect("the layout is taken or made anew");
    });
}

/// What a sound bake of one shard leaves, and the bake itself.
struct Sound {
    folder: tempfile::TempDir,
    bake: Bake,
    job: ambake::Job,
    /// Header and blocks.
    part: (Value, Vec<Vec<u8>>),
    part_path: PathBuf,
    /// Header and blocks.
    layout: (Value, Vec<Vec<u8>>),
    layout_path: PathBuf,
}

fn with_sound(work: impl FnOnce(&Sound)) {
    thread_local!(static SOUND: RefCell<Option<Sound>> = const { RefCell::new(None) });
    SOUND.with_borrow_mut(|sound| work(sound.get_or_insert_with(sound_bake)));
}

fn sound_bake() -> Sound {
    let folder = memory_folder();
    let mut mesh = ambake::Mesh::default();
    mesh.positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0]];
    mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
    let scene = ambake::Scene::from_meshes(vec![mesh], vec![]).expect("two triangles");
    let bake = Bake::new(&scene).size(8).rays(1).threads(1);
    let job = bake.prepare().expect("a small bake");
    let one = Shard { index: 1, of: 1 };
    let part = job.run_shard(folder.path(), one, &Value::Null, &());
    let read = |path: &std::path::Path| {
        let mut journal = Journal::open(path).expect("sound").expect("there");
        let blocks = (0..journal.len()).map(|number| journal.block(number).expect("sound"));
        let blocks = blocks.collect();
        (journal.header().clone(), blocks)
    };
    let part_path = part.expect("a small bake").path;
    let layout_path = Layout::path(folder.path(), &scene);
    let laid_out = bake.lay_out().expect("a small bake");
    laid_out
        .write(folder.path())
        .expect("the folder is writable");
    Sound {
        part: read(&part_path),
        layout: read(&layout_path),
        folder,
        bake,
        job,
        part_path,
        layout_path,
    }
}

/// Writes a journal of blocks that were altered. `edits` is a list of: where (u16, little-endian; over all blocks,
/// modulo their length), how many bytes are cut there (u8), how many come in their place (u8), and these bytes.
fn write_journal(path: &std::path::Path, sound: &(Value, Vec<Vec<u8>>), mut edits: &[u8]) {
    let (header, mut blocks) = sound.clone();
    while let [low, high, cut, fresh, rest @ ..] = edits {
        let total = blocks.iter().map(Vec::len).sum::<usize>().max(1);
        let mut at = usize::from(u16::from_le_bytes([*low, *high])) % total;
        let (new, others) = rest.split_at(rest.len().min(usize::from(*fresh)));
        for block in &mut blocks {
            if at < block.len() {
                let end = block.len().min(at + usize::from(*cut));
                block.splice(at..end, new.iter().copied());
                break;
            }
            at -= block.len();
        }
        edits = others;
    }
    let fresh = Journal::resume(path, &header, |_| false);
    let (mut journal, _) = fresh.expect("the folder is writable");
    for block in blocks {
        journal.append(&block).expect("the folder is writable");
    }
}

fn load(name: &str, bytes: &[u8]) {
    if let Err(error) = scene::load(&file(name, bytes)) {
        let line = error.to_string();
        assert!(!line.contains('\n') && line.len() < 10_000, "{line}");
    }
}

/// A file in a folder of this thread.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    thread_local!(static FOLDER: RefCell<Option<tempfile::TempDir>> = const { RefCell::new(None) });
    FOLDER.with_borrow_mut(|folder| {
        let folder = folder.get_or_insert_with(memory_folder);
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("the folder is writable");
        path
    })
}

/// A folder in memory where the system has such a place: a disk would be waited for.
fn memory_folder() -> tempfile::TempDir {
    let made = tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir());
    made.expect("a temporary folder")
}
