//! `--for godot`: Godot 3 itself imports what a bake wrote, and shows the light at the second coordinates.

use crate::support::{bake, files, report, scene, skip};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Godot without a window, of Debian's package of that name.
const GODOT: &str = "godot3-server";

/// Prints a line of JSON for each surface of a scene.
const LOOK: &str = r#"
extends SceneTree

func _init():
	var words = OS.get_cmdline_args()
	_walk(load(words[words.size() - 1]).instance())
	quit()

func _walk(node):
	if node is MeshInstance:
		for i in node.mesh.get_surface_count():
			var material = node.mesh.surface_get_material(i)
			var arrays = node.mesh.surface_get_arrays(i)
			var light = material.detail_albedo
			var told = {"name": material.resource_name, "unshaded": material.flags_unshaded, "detail": material.detail_enabled}
			told["second"] = material.detail_uv_layer == SpatialMaterial.DETAIL_UV_2
			told["multiplies"] = material.detail_blend_mode == SpatialMaterial.BLEND_MODE_MUL
			told["light"] = light.resource_path if light else ""
			told["half"] = light.get_data().get_format() == Image.FORMAT_RGBH if light else false
			told["uv2"] = []
			for uv in arrays[Mesh.ARRAY_TEX_UV2]:
				told["uv2"].append([uv.x, uv.y])
			print("SURFACE " + to_json(told))
	for child in node.get_children():
		_walk(child)
"#;

/// What Godot did within a minute: it may hang when it ends.
fn godot(project: &Path, words: &[&str], done: &dyn Fn() -> bool) -> Output {
    let mut child = Command::new(GODOT)
        .args(["--path", project.to_str().expect("a UTF-8 path")])
        .args(words)
        .env("HOME", project)
        .stdout(fs::File::create(project.join("out.txt")).expect("a file"))
        .stderr(fs::File::create(project.join("errors.txt")).expect("a file"))
        .spawn()
        .expect("Godot starts");
    let end = Instant::now() + Duration::from_secs(60);
    let status = loop {
        match child.try_wait().expect("a child") {
            Some(status) => break status,
            None if done() || Instant::now() > end => {
                child.kill().expect("it ends");
                break child.wait().expect("a status");
            }
            None => sleep(Duration::from_millis(50)),
        }
    };
    let read = |name| fs::read(project.join(name)).expect("what it said");
    Output {
        status,
        stdout: read("out.txt"),
        stderr: read("errors.txt"),
    }
}

#[test]
fn godot_3_shows_the_light_at_the_second_coordinates() {
    if Command::new(GODOT).arg("--version").output().is_err() {
        skip("godot3-server is not installed");
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary directory");
    let room = folder.path().join("a room 50%.obj");
    fs::copy(scene("instances_twin.obj"), &room).expect("copied");
    let options = ["--size=32", "--density=6", "--rays=8", "--for=godot"];
    let (baked, _) = bake(&room, &options);
    let pages = report(baked.path())["pages"].as_array().map(Vec::len);
    assert!(pages > Some(1), "{pages:?} pages");

    let project = tempfile::tempdir().expect("a temporary directory");
    let into = project.path();
    let wanted = |name: &String| {
        name.contains(".godot.") || name.contains(".godot3.") || name.contains(".lightmap.exr")
    };
    let copied: Vec<String> = files(baked.path()).into_iter().filter(wanted).collect();
    assert_eq!(copied.len(), 3 + 2 * pages.expect("pages"), "{copied:?}");
    for name in &copied {
        fs::copy(baked.path().join(name), into.join(name)).expect("copied");
    }
    fs::write(into.join("project.godot"), "config_version=4\n").expect("a project");
    fs::write(into.join("look.gd"), LOOK).expect("a script");
    let imported = |begin: &str, ending: &str| {
        let named = |name: &String| name.starts_with(begin) && name.ends_with(ending);
        into.join(".import").is_dir() && files(&into.join(".import")).iter().any(named)
    };
    let done = || imported("a room 50%.godot.glb", ".md5");
    let import = godot(into, &["--editor", "--quit"], &done);
    let errors = String::from_utf8_lossy(&import.stderr);
    assert!(imported("a room 50%.godot.glb", ".scn"), "{errors}");
    assert!(!errors.contains("ambake"), "{errors}");

    let look = godot(
        into,
        &["-s", "look.gd", "res://a room 50%.godot.glb"],
        &|| false,
    );
    let said = String::from_utf8_lossy(&look.stdout).into_owned();
    let surfaces: Vec<Value> = (said.lines())
        .filter_map(|line| serde_json::from_str(line.strip_prefix("SURFACE ")?).ok())
        .collect();
    assert!(
        surfaces.len() > 3,
        "{said} {}",
        String::from_utf8_lossy(&look.stderr)
    );
    let mut shown = Vec::new();
    for surface in &surfaces {
        for what in ["unshaded", "detail", "second", "multiplies", "half"] {
            assert_eq!(surface[what], true, "{what}: {surface}");
        }
        let page = surface["name"]
            .as_str()
            .and_then(|name| name.rsplit('.').next());
        let page: usize = page.and_then(|page| page.parse().ok()).expect("a page");
        assert_eq!(
            surface["light"],
            format!("res://a room 50%.{page}.lightmap.exr")
        );
        let corners = surface["uv2"].as_array().expect("a list");
        let within =
            |uv: &Value| (0..2).all(|k| (0.0..=1.0).contains(&uv[k].as_f64().unwrap_or(-1.0)));
        assert!(
            !corners.is_empty() && corners.iter().all(within),
            "{surface}"
        );
        shown.push(page);
    }
    shown.sort_unstable();
    shown.dedup();
    assert_eq!(Some(shown.len()), pages);
}
