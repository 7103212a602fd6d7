//! What a file is that is no scene file of ours: told by its first bytes, so that the error says what helps.

/// So many bytes of a file are looked at.
pub(crate) const LOOKED_AT: usize = 4096;

/// What a file is and what to do about it, where its first bytes tell that no reader of ours reads it, whatever its
/// ending, in lower case. The words follow "FILE is".
pub(crate) fn by_content(start: &[u8], ending: &str) -> Option<&'static str> {
    let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let lower = text.trim_ascii_start().to_ascii_lowercase();
    let begins = |with: &[&[u8]]| with.iter().any(|with| lower.starts_with(with));
    if is_pointer(start) {
        Some(POINTER)
    } else if begins(&[b"<!doctype html", b"<html"]) {
        Some("a web page and no model; download the file itself")
    } else if begins(&[b"<?xml", b"<collada"]) {
        match contains(&lower, b"<collada") {
            true => Some(OF_COLLADA),
            false => Some("an XML file, which is not read; export the scene as glTF (.glb)"),
        }
    } else if begins(&[b"kaydara fbx binary", b"; fbx "]) {
        Some(
            "an FBX file, which is not read; open it in Blender or another program and export glTF (.glb)",
        )
    } else if start.starts_with(b"BLENDER") {
        Some(OF_BLENDER)
    } else if begins(&[b"ply\n", b"ply\r"]) {
        Some(
            "a PLY file, which is not read; open it in Blender or another program and export glTF (.glb)",
        )
    } else if begins(&[b"pxr-usdc", b"#usda "]) {
        Some(OF_USD)
    } else if start.starts_with(b"PK\x03\x04") {
        Some(match ending {
            "usdz" => OF_USD,
            _ => "a ZIP archive, which is not read; unpack it and give the scene in it",
        })
    } else if start.starts_with(b"\x1f\x8b") || start.starts_with(b"\x28\xb5\x2f\xfd") {
        Some(match ending {
            "blend" => OF_BLENDER,
            _ => "a compressed file, which is not read; unpack it and give the scene in it",
        })
    } else {
        None
    }
}

/// What a Git LFS pointer is.
pub(crate) const POINTER: &str =
    "a Git LFS pointer and not the file that it stands for; `git lfs pull` fetches that";
const OF_COLLADA: &str =
    "a COLLADA file, which is not read; open it in a program that does and export glTF (.glb)";
const OF_BLENDER: &str = "a file of Blender, which is not read; export glTF (.glb) from there";
const OF_USD: &str =
    "a USD file, which is not read; open it in Blender or another program and export glTF (.glb)";

/// The same of a file whose content tells nothing, by its ending in lower case, or by what of ours it holds under
/// another name.
pub(crate) fn by_ending(ending: &str, start: &[u8]) -> &'static str {
    match ending {
        "blend" => OF_BLENDER,
        "dae" => OF_COLLADA,
        "usd" | "usda" | "usdc" | "usdz" => OF_USD,
        "3ds" | "abc" | "fbx" | "ply" | "stl" | "wrl" | "x3d" => {
            "a model in a format that is not read; open it in Blender or another program and export glTF (.glb)"
        }
        "mtl" => "a library of materials; give the .obj file that names it",
        "bin" => "a file of numbers; give the .gltf file that names it",
        _ if is_gltf(start) => "glTF by its content and not by its ending; rename it to .gltf",
        _ if is_obj(start) => "OBJ by its content and not by its ending; rename it to .obj",
        _ => {
            "neither OBJ nor glTF by its ending; open it in the program that wrote it and export glTF (.glb)"
        }
    }
}

/// True for what a clone without `git lfs` leaves in place of a large file.
pub(crate) fn is_pointer(start: &[u8]) -> bool {
    start.starts_with(b"version https://git-lfs.github.com/spec/")
}

/// True for JSON with a word of glTF's.
pub(crate) fn is_gltf(start: &[u8]) -> bool {
    let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let words: [&[u8]; 3] = [b"\"asset\"", b"\"accessors\"", b"\"bufferViews\""];
    text.trim_ascii_start().starts_with(b"{") && words.iter().any(|word| contains(text, word))
}

/// True where some line is a vertex.
fn is_obj(start: &[u8]) -> bool {
    let vertex = |line: &[u8]| {
        let mut words = line
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty());
        let is_number = |word: &[u8]| {
            let text = std::str::from_utf8(word);
            text.is_ok_and(|text| text.parse::<f32>().is_ok())
        };
        words.next() == Some(b"v") && words.next().is_some_and(is_number)
    };
    start
        .split(|byte| matches!(byte, b'\n' | b'\r'))
        .any(vertex)
}

fn contains(bytes: &[u8], word: &[u8]) -> bool {
    bytes.windows(word.len()).any(|part| part == word)
}
