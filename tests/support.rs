//! What every integration test needs: running the program, and reading what it wrote.

use environment::{Format, Image, Labels};
use exr::prelude::{AnyChannels, FlatSamples, Layer, ReadChannels, ReadLayers, read};
use serde_json::Value;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

#[path = "skip.rs"]
mod skip_reason;
pub use skip_reason::{model, say, skip};

/// What starts the program: its path, behind the words of the loader that starts the tests themselves where one is set.
fn start() -> Vec<String> {
    let runner = std::env::var("CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER").unwrap_or_default();
    let words = runner.split_whitespace().map(str::to_owned);
    words.chain([env!("CARGO_BIN_EXE_ambake").into()]).collect()
}

/// A command that starts the program.
pub fn ambake() -> Command {
    let words = start();
    let mut command = Command::new(&words[0]);
    command.args(&words[1..]).stdin(Stdio::null());
    command
}

/// A shell that runs `line`, in which `ambake` is the program. What is added to it are `$1`, `$2` and so on.
#[cfg(unix)]
pub fn shell(line: &str) -> Command {
    let words: Vec<String> = start().iter().map(|word| format!("'{word}'")).collect();
    let line = format!("ambake() {{ {} \"$@\"; }}; {line}", words.join(" "));
    let mut command = Command::new("sh");
    command.args(["-c", &line, "sh"]).stdin(Stdio::null());
    command
}

/// Runs the program to its end.
pub fn run<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Output {
    ambake()
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// Runs the program, which must succeed; returns its standard output.
pub fn run_well<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> String {
    let mut command = ambake();
    command.args(arguments);
    let output = command.output().expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{command:?} ended with {}\n{errors}",
        output.status
    );
    String::from_utf8(output.stdout).expect("standard output is UTF-8")
}

/// The status and the words of a command that must end soon; `None` where it hangs.
#[cfg(unix)]
pub fn ended(mut child: std::process::Child) -> Option<(Option<i32>, String)> {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(60) {
        if child.try_wait().expect("a status").is_some() {
            let output = child.wait_with_output().expect("a status");
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            return Some((output.status.code(), text));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    // SIGTERM may be what it does not obey.
    child.kill().expect("it runs");
    child.wait().expect("a status");
    None
}

/// An authored scene.
pub fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name)
}

/// The rows of a table of exact values, without its comment and its header.
pub fn table(name: &str) -> Vec<String> {
    let path = tables().join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(str::to_owned).collect()
}

/// The folder of the tables of exact values.
pub fn tables() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tables")
}

/// True where the program was built with Embree; prints a skip line where it was not.
pub fn has_embree() -> bool {
    let found = embree::header_version().is_some();
    if !found {
        skip("this build has no Embree");
    }
    found
}

/// The ray backends of this build.
pub fn backends() -> Vec<&'static str> {
    if has_embree() {
        vec!["embree", "obvhs"]
    } else {
        vec!["obvhs"]
    }
}

/// The picture in a file.
pub fn load_image(path: impl AsRef<Path>) -> Image {
    environment::read(path.as_ref()).expect("a picture").image
}

/// Writes a picture to an .exr file.
pub fn save_image(path: impl AsRef<Path>, image: &Image) {
    let bytes = environment::encode(image, Format::Exr, &Labels::new()).expect("finite pixels");
    std::fs::write(path, bytes).expect("a file");
}

/// The first layer of an EXR file, with all of its channels.
pub fn exr_layer(path: &Path) -> Layer<AnyChannels<FlatSamples>> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path);
    image
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()))
        .layer_data
}

/// One page read back: every channel by its full name.
pub struct Page {
    /// Page edge in texels.
    pub size: usize,
    channels: BTreeMap<String, Vec<f32>>,
}

impl Page {
    /// The page in the file at `path`.
    pub fn read(path: &Path) -> Self {
        let layer = exr_layer(path);
        let size = layer.size;
        assert_eq!(size.0, size.1, "{} is square", path.display());
        let channels = layer.channel_data.list;
        let channels = channels
            .into_iter()
            .map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect()));
        Self {
            size: size.0,
            channels: channels.collect(),
        }
    }

    /// The names of the channels, in order.
    pub fn names(&self) -> Vec<&str> {
        self.channels.keys().map(String::as_str).collect()
    }

    /// The values of a channel, row 0 on top.
    pub fn plane(&self, name: &str) -> &[f32] {
        self.channels
            .get(name)
            .unwrap_or_else(|| panic!("no channel {name} in {:?}", self.names()))
    }

    /// Every value of every channel.
    pub fn values(&self) -> impl Iterator<Item = (&str, f32)> {
        self.channels
            .iter()
            .flat_map(|(name, values)| values.iter().map(move |v| (name.as_str(), *v)))
    }
}

/// Bakes `scene` into a fresh directory; returns it and the first page. Texels stand for themselves, unless the
/// arguments say how they are denoised.
pub fn bake(scene: &Path, arguments: &[&str]) -> (tempfile::TempDir, Page) {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let mut all = vec![
        "bake".as_ref(),
        scene.as_os_str(),
        "-o".as_ref(),
        folder.path().as_os_str(),
        "--quiet".as_ref(),
    ];
    if !arguments.contains(&"--denoise") {
        all.extend(["--denoise", "off"].map(OsStr::new));
    }
    all.extend(arguments.iter().map(OsStr::new));
    run_well(all);
    let page = Page::read(&page_path(folder.path(), scene, 0));
    (folder, page)
}

/// [`bake`] with the scene's own coordinates as they stand, though charts may touch: every texel is where its
/// author put it.
pub fn bake_kept(scene: &Path, arguments: &[&str]) -> (tempfile::TempDir, Page) {
    bake(scene, &[&["--uv", "keep"], arguments].concat())
}

/// Where page `number` of a bake of `scene` lies.
pub fn page_path(folder: &Path, scene: &Path, number: u32) -> PathBuf {
    let stem = scene
        .file_stem()
        .expect("a scene file has a stem")
        .to_string_lossy();
    folder.join(format!("{stem}.{number}.exr"))
}

/// The `bake.json` of a finished bake.
pub fn report(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("bake.json")).expect("bake.json is there");
    serde_json::from_str(&text).expect("bake.json is JSON")
}

/// The names of all files in a directory, sorted; empty where there is no directory.
pub fn files(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut names: Vec<_> = entries
        .map(|e| {
            e.expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    names
}

/// What a script of `tests/tools` prints under Node.js, as JSON.
///
/// # Errors
/// Node.js, or what the script needs, is absent.
pub fn node(script: &str, args: &[&OsStr]) -> Result<Value, String> {
    let tools = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tools");
    let mut node = Command::new("node");
    node.arg(tools.join(script)).args(args).current_dir(&tools);
    let Ok(output) = node.output() else {
        return Err("node is not installed".into());
    };
    let said = String::from_utf8_lossy(&output.stdout);
    if output.status.code() == Some(77) {
        return Err(said.trim().into());
    }
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}\n{errors}");
    Ok(serde_json::from_str(&said).expect("JSON"))
}

/// The sides of a box, counter-clockwise seen from outside, whose corner k has its low or its high x, y and z by the
/// bits 1, 2 and 4 of k.
pub const BOX_SIDES: [[u32; 4]; 6] = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
];

/// Holds a file against Khronos' validator, where that is installed.
pub fn assert_valid_gltf(path: &Path) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tools/validate-gltf.mjs");
    match Command::new("node").arg(script).arg(path).output() {
        Ok(run) if run.status.code() != Some(77) => {
            let said = String::from_utf8_lossy(&run.stdout);
            assert!(
                run.status.success() && said.contains("\"errors\":0"),
                "{said}"
            );
        }
        _ => skip("node or its module gltf-validator is absent (npm install in tests/tools)"),
    }
}
