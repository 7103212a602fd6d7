//! A scene from standard input: `ambake bake - -o DIR`.

use anyhow::{Context, bail};
use std::io::{Read, Write};
use std::path::Path;

/// The scene in standard input: GLB by its first bytes, glTF where it begins with a brace, else OBJ. Files that it
/// names are not found; a GLB or a glTF with embedded buffers needs none. Outputs are called `scene`.
pub fn load() -> anyhow::Result<ambake::Scene> {
    let mut bytes = Vec::new();
    let mut input = std::io::stdin().lock();
    input
        .read_to_end(&mut bytes)
        .context("cannot read standard input")?;
    if bytes.is_empty() {
        bail!("standard input is empty; pipe a .glb, .gltf or .obj file into it");
    }
    let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
    let path = folder.path().join(format!("scene.{}", ending(&bytes)));
    let written = std::fs::File::create(&path).and_then(|mut file| file.write_all(&bytes));
    written.with_context(|| format!("cannot write {}", path.display()))?;
    // What is said of the file says it of standard input.
    let plain = |text: String| {
        let text = text.replace(&path.display().to_string(), "standard input");
        text.replace(&format!("{}/", folder.path().display()), "")
    };
    let mut scene =
        scene::load(&path).map_err(|error| anyhow::anyhow!(plain(error.to_string())))?;
    for warning in &mut scene.warnings {
        warning.message = plain(std::mem::take(&mut warning.message));
        warning.place = plain(std::mem::take(&mut warning.place));
    }
    scene.path = Path::new("scene").with_extension(ending(&bytes));
    scene.inputs.clear();
    Ok(scene.into())
}

/// The ending of a file with these bytes.
fn ending(bytes: &[u8]) -> &'static str {
    let first = bytes.iter().find(|byte| !byte.is_ascii_whitespace());
    match (bytes.starts_with(b"glTF"), first) {
        (true, _) => "glb",
        (_, Some(b'{')) => "gltf",
        _ => "obj",
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_format_is_told_by_the_bytes() {
        for (bytes, ending) in [
            (&b"glTF\x02"[..], "glb"),
            (b" \n{}", "gltf"),
            (b"v 0 0 0", "obj"),
            (b"", "obj"),
        ] {
            assert_eq!(super::ending(bytes), ending);
        }
    }
}
