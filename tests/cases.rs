//! Small public files that users reported, where they lie beside the project: what is loaded of each is held against
//! values found without ambake. Areas are those of the polygons as a parser of twenty lines in another language reads
//! them; albedos follow from the materials by hand: 0.96 of a dielectric's base colour, 188 in sRGB for 0.502886.

use crate::support::{Page, bake, report, run_well, say};
use serde_json::Value;
use std::ffi::OsStr;
use std::path::Path;

/// File, area of all surfaces in the world, mean albedo by area, and the kinds of its warnings in order.
type Case = (&'static str, f64, f64, &'static [&'static str]);

const FILES: &[Case] = &[
    ("anim_without_node.glb", 6.0, 0.96, &[]),
    ("anim_pointer.glb", 6.0, 0.96, &[]),
    ("scene_without_nodes.glb", 6.0, 0.96, &[]),
    ("khr_node_visibility_false.glb", 4.0, 0.96, &[]),
    ("mesh_features.glb", 6.0, 0.96, &[]),
    ("touching.glb", 22.0, 0.96, &[]),
    ("sky_dome.glb", 60_036.0, 0.96, &[]),
    ("steps_o.glb", 66.179_2, 0.96, &[]),
    ("comb510.obj", 8.4, 1.0, &[]),
    ("comb514.obj", 8.4, 1.0, &[]),
    ("stairs_origin.obj", 82.279_2, 1.0, &[]),
    ("stairs_100km.obj", 82.279_2, 1.0, &[]),
    ("stairs_utm.obj", 82.279_2, 1.0, &[]),
    ("steps_utm_root.glb", 66.179_2, 0.96, &[]),
    ("bom_mtllib.obj", 24.0, 0.25, &[]),
    ("bom_v.obj", 24.0, 1.0, &[]),
    ("bom_short.obj", 3.414_213_56, 1.0, &[]),
    ("cr_only.obj", 24.0, 1.0, &[]),
    ("nan_ind.obj", 24.0, 1.0, &["bad-normals"]),
    ("msvc_ind.obj", 24.0, 1.0, &["missing-uvs", "bad-uvs"]),
    (
        "vn_zero.obj",
        24.0,
        1.0,
        &["ignored-normal-references", "bad-normals"],
    ),
    ("tr1.obj", 88.0, 1.0, &["invisible-materials"]),
    ("color_alpha_f32.glb", 8.0, 0.96, &[]),
    ("color_alpha_u8n.glb", 8.0, 0.96, &[]),
    ("color_alpha_u16n.glb", 8.0, 0.96, &[]),
    ("color_alpha_u8_notnorm.glb", 8.0, 0.96, &[]),
    // A lid of 4 that is all hole, on a well of 20.
    (
        "specgloss_mask.glb",
        24.0,
        (20.0 * 0.96 + 4.0 * 0.502_886) / 24.0,
        &[],
    ),
    // A lid of 4 that scatters nothing.
    ("glass_lid.glb", 24.0, 20.0 * 0.96 / 24.0, &[]),
];

/// Metals scatter nothing, of which those are told that are metal all over; a material of both its part: 0.96 of the
/// base colour times what is not metallic.
const LIGHT: &[Case] = &[
    ("av_boxes41.gltf", 47.838_617, 1.0, &[]),
    ("av_walls42.gltf", 51.842_903, 1.0, &[]),
    ("bounce_room1.gltf", 101.145_499, 0.561_764, &[]),
    (
        "ggx_walls28.gltf",
        52.762_696,
        0.075_857,
        &["black-metals"; 4],
    ),
    ("sky_boxes65.gltf", 48.532_295, 0.0, &["black-metals"]),
    ("ka.obj", 4.0, 0.3, &["ambient-coefficients"]),
];

const SCENES: &[Case] = &[
    ("cave.glb", 706.606_772, 0.356_947, &[]),
    ("curtain.glb", 74.294_316, 0.628_074, &["black-metals"]),
    ("kit.glb", 2_088.933_913, 0.304_734, &["black-metals"]),
    (
        "shelf.glb",
        86.841_068,
        0.533_666,
        &["zero-area-triangles"; 3],
    ),
    ("street.glb", 9_347.972_142, 0.303_872, &["black-metals"]),
];

const ATTACK: &[Case] = &[
    ("coplanar_500.glb", 1_167.754_300, 1.0, &[]),
    ("coplanar_2000.glb", 4_635.666_575, 1.0, &[]),
    ("touch_sep_1000.glb", 20.0, 1.0, &[]),
    ("touch_sep_4000.glb", 80.0, 1.0, &[]),
];

#[test]
fn every_public_case_has_the_area_the_albedo_and_the_warnings_that_are_its_own() {
    let mut wrong = Vec::new();
    for (name, cases) in [
        ("files", FILES),
        ("light", LIGHT),
        ("scenes", SCENES),
        ("attack", ATTACK),
    ] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/cases");
        let folder = folder.join(name);
        if !folder.is_dir() {
            say(&format!("../shared/cases/{name} is not here"));
            continue;
        }
        for &(file, area, albedo, warnings) in cases {
            let scene = scene::load(&folder.join(file)).unwrap_or_else(|e| panic!("{e}"));
            let kinds: Vec<&str> = scene.warnings.iter().map(|w| w.kind.name()).collect();
            if kinds != warnings {
                wrong.push(format!("{name}/{file}: {:?}", scene.warnings));
            }
            let [found, mean] = area_and_albedo(&scene);
            // Positions are in f32: teeth of a thousandth lie at coordinates of 1.
            if (found / area - 1.0).abs() > 1e-5 {
                wrong.push(format!("{name}/{file}: area {found}, not {area}"));
            }
            if (mean - albedo).abs() > 1e-5 {
                wrong.push(format!("{name}/{file}: albedo {mean}, not {albedo}"));
            }
        }
        // A case that is added beside the project has to be added here.
        for entry in std::fs::read_dir(&folder).expect("a folder").flatten() {
            let file = entry.file_name().to_string_lossy().into_owned();
            let ending = Path::new(&file).extension().and_then(|e| e.to_str());
            let is_scene = matches!(ending, Some("glb" | "gltf" | "obj"));
            if is_scene && !cases.iter().any(|case| case.0 == file) {
                wrong.push(format!("{name}/{file} is held against nothing"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What a bake on 256² warns of beside what is wrong with the file: kinds and places, and why. Of other cases it has
/// nothing to say. Of those of `attack` only the cost is known.
type Told = (
    &'static str,
    &'static [(&'static str, &'static str)],
    &'static str,
);

const TOLD: &[Told] = &[
    (
        "sky_dome.glb",
        &[
            ("uneven-density", "object `sky dome`"),
            ("enclosed", "object `sky dome`"),
            ("interior", "scene"),
        ],
        "a closed box of 100 around a floor of 6, which gets four times its density",
    ),
    (
        "stairs_origin.obj",
        STAIRS,
        "36 of 82.3 are the ground's, and as steps stand side by side 10.6 are seen of none; posts are 0.1 wide",
    ),
    ("stairs_100km.obj", STAIRS, "as at the origin"),
    ("stairs_utm.obj", STAIRS, "as at the origin"),
    (
        "bounce_room1.gltf",
        &[
            ("dark-lamps", "material `material 8`"),
            ("interior", "scene"),
        ],
        "a closed room, whose lamp sends nothing where no light bounces",
    ),
    (
        "cave.glb",
        &[("large-share", "object `cave`"), ("interior", "scene")],
        "68 % of the surface is a tube 26 deep and 5 wide, open at one end, and stones in it are a twentieth as long",
    ),
    (
        "curtain.glb",
        &[("interior", "scene")],
        "a room with one window, and a curtain before it",
    ),
    (
        "kit.glb",
        &[("outsides", "scene")],
        "a house of two rooms, of which the outer sides of walls and roof are a third",
    ),
    (
        "shelf.glb",
        &[
            ("coarse-objects", "object `key_0_0`"),
            ("small-page", "pages of 256²"),
            ("hidden-faces", "scene"),
        ],
        "369 objects of 2,700 sides; keys are 17 mm wide in a room of 4 m; of 139 books the sides 1.3 mm apart are \
         16 % of all, and what stands on the desk and against the wall adds to it",
    ),
    (
        "street.glb",
        &[
            ("small-page", "pages of 256²"),
            ("uneven-density", "object `lamp_0`"),
        ],
        "170 objects along 60 m, of which those of half a metre get four times the density of houses",
    ),
];

const STAIRS: &[(&str, &str)] = &[("large-share", "object `ground`")];

#[test]
fn a_bake_of_every_public_case_warns_of_what_is_so_and_of_nothing_else() {
    let mut wrong = Vec::new();
    for (name, cases) in [("files", FILES), ("light", LIGHT), ("scenes", SCENES)] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/cases");
        let folder = folder.join(name);
        if !folder.is_dir() {
            say(&format!("../shared/cases/{name} is not here"));
            continue;
        }
        for &(file, _, _, of_file) in cases {
            let baked = tempfile::tempdir().expect("a temporary directory");
            let words = ["--size", "256", "--rays", "16", "--quiet", "-o"];
            let mut all = vec![OsStr::new("bake")];
            let scene = folder.join(file);
            all.push(scene.as_os_str());
            all.extend(words.map(OsStr::new));
            all.push(baked.path().as_os_str());
            run_well(all);
            let told = TOLD.iter().find(|of| of.0 == file);
            let (expected, why) = told.map_or((&[][..], ""), |of| (of.1, of.2));
            let report = report(baked.path());
            let warnings = report["warnings"].as_array().expect("a list");
            let text = |of: &Value, key: &str| of[key].as_str().expect("a text").to_owned();
            let found = warnings.iter();
            let found = found.map(|of| (text(of, "kind"), text(of, "place")));
            let mut found: Vec<(String, String)> = found.collect();
            found.retain(|of| !of_file.contains(&of.0.as_str()));
            let expected: Vec<(String, String)> = expected
                .iter()
                .map(|of| (of.0.into(), of.1.into()))
                .collect();
            if found != expected {
                wrong.push(format!("{name}/{file}: {found:?}, not {expected:?}: {why}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// File, flags, object, layer, and the mean over the object's texels that the page beside the cases says is right.
type Lit = (
    &'static str,
    &'static [&'static str],
    f32,
    &'static str,
    f64,
);

const LIT: &[Lit] = &[
    ("specgloss_mask.glb", &[], 0.0, "diffuse", 0.2),
    ("specgloss_mask.glb", &[], 1.0, "lambert.R", 0.503),
    // As open as without the glass.
    ("glass_lid.glb", &[], 0.0, "diffuse", 0.2),
    ("khr_node_visibility_false.glb", &[], 0.0, "diffuse", 1.0),
    ("sky_dome.glb", &["--no-cast=sky dome"], 1.0, "diffuse", 1.0),
    // The alpha of the card's corners lies below its cutoff.
    ("color_alpha_f32.glb", &[], 0.0, "diffuse", 1.0),
    ("color_alpha_u8n.glb", &[], 0.0, "diffuse", 1.0),
    ("color_alpha_u16n.glb", &[], 0.0, "diffuse", 1.0),
    ("color_alpha_u8_notnorm.glb", &[], 0.0, "diffuse", 1.0),
    ("tr1.obj", &[], 0.0, "diffuse", 1.0),
];

#[test]
fn public_cases_bake_the_light_that_is_right() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/cases/files");
    if !folder.is_dir() {
        say("../shared/cases/files is not here");
        return;
    }
    for &(file, flags, object, layer, expected) in LIT {
        let words = ["--size", "256", "--rays", "64", "--layers", "object"];
        let (_folder, page) = bake(&folder.join(file), &[&words, flags].concat());
        let mean = mean_of(&page, object, layer);
        assert!((mean - expected).abs() < 2e-3, "{file}: {layer} {mean}");
    }
}

/// The mean of a layer over the texels of an object.
fn mean_of(page: &Page, object: f32, layer: &str) -> f64 {
    let (covered, objects) = (page.plane("coverage"), page.plane("object"));
    let texels = 0..covered.len();
    let own = texels.filter(|&texel| covered[texel] > 0.0 && objects[texel] == object);
    let (count, sum) = own.fold((0, 0.0), |(count, sum), texel| {
        (count + 1, sum + f64::from(page.plane(layer)[texel]))
    });
    sum / f64::from(count)
}

#[test]
fn stairs_bake_alike_wherever_they_stand() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/cases/files");
    if !folder.is_dir() {
        say("../shared/cases/files is not here");
        return;
    }
    let mut at_home = None;
    for file in ["stairs_origin.obj", "stairs_100km.obj", "stairs_utm.obj"] {
        let scene = scene::load(&folder.join(file)).unwrap_or_else(|e| panic!("{e}"));
        let triangles: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        assert_eq!(triangles, 170, "{file}");
        let step = scene.instances.iter().position(|of| of.name == "step3");
        let step = step.expect("a step") as f32;
        let more = ["--size", "256", "--rays", "64", "--layers", "object"];
        let (baked, page) = bake(&folder.join(file), &more);
        let mean = mean_of(&page, step, "diffuse");
        // The value beside the case is .483, of which a fifth of the texels was the bottom, which stands on the ground
        // and would show the sky below it: 1. It is buried. Texels are others in another layout.
        let without_bottom = (0.483 - 0.19) / (1.0 - 0.19);
        assert!((mean - without_bottom).abs() < 0.02, "{file}: {mean}");
        let home = *at_home.get_or_insert(mean);
        assert!((mean - home).abs() < 0.003, "{file}: {mean}, not {home}");
        // What is written stands in the author's coordinates.
        let stem = file.strip_suffix(".obj").expect("an ending");
        let glb = baked.path().join(format!("{stem}.glb"));
        let written = scene::load(&glb).unwrap_or_else(|e| panic!("{e}"));
        let corner = |scene: &scene::Scene| {
            let (instance, mesh) = (&scene.instances[0], &scene.meshes[0]);
            let at = mesh.triangles[0].map(|v| mesh.positions[v as usize].as_dvec3());
            let at = at.map(|p| instance.transform.transform_point3(p));
            at.into_iter().sum::<glam::DVec3>() / 3.0
        };
        let (read, written) = (corner(&scene), corner(&written));
        assert!((read - written).length() < 1e-5, "{file}: {read} {written}");
    }
}

/// The area of all instances, and the mean of their albedos over it, all channels together, from the middles of
/// triangles.
fn area_and_albedo(scene: &scene::Scene) -> [f64; 2] {
    let (mut area, mut sum) = (0.0, 0.0);
    for (number, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let corner = |v: u32| mesh.positions[v as usize].as_dvec3();
            let [a, b, c] = triangle.map(|v| instance.transform.transform_point3(corner(v)));
            let own = (b - a).cross(c - a).length() / 2.0;
            let material = rays::material_at(scene, number as u32, t as u32, [1.0 / 3.0; 3]);
            area += own;
            sum += own * material.albedo.element_sum() / 3.0;
        }
    }
    [area, sum / area]
}
