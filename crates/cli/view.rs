//! `ambake view` and `bake --report`: the one file in which a finished bake is looked at.

use crate::args::View as Args;
use crate::common::{build, text_file};
use crate::outcome::{Outcome, say};
use anyhow::bail;

use ambake::{ProbeReport, ProbeVolume};
use glam::DVec3;
use rays::{RayBackend, SurfaceHit, Surfaces, World};
use render::{Camera, Direct, Framing, Lamps, Lit, TexelPlace};
use report::{EmbeddedPage, EmbeddedProbes, Kernel, Output, REPORT_NAME, Viewer};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Texels of all pages that are embedded, at most; larger pages are reduced.
const MOST_TEXELS: u64 = 1 << 25;
/// Longest edge of an embedded page: what every WebGL 2 takes is less, what those in use take is this.
const MOST_EDGE: u32 = 8192;
/// Layers that decide how bright the first view is, the best one first.
const LIGHT: [&str; 6] = [
    "ggx",
    "phong",
    "lambert",
    "traditional",
    "irradiance",
    "diffuse",
];

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let path = write(&args.dir)?;
    let opened = !args.no_open && open(&path);
    if !args.quiet {
        let opened = if opened {
            " (opened in the browser)"
        } else {
            ""
        };
        say(&format!("{}{opened}\n", path.display()))?;
    }
    Ok(Outcome::Done)
}

/// Writes `DIR/report.html` and adds it to the files that `DIR/bake.json` lists, so that a rebake removes or replaces
/// it.
pub fn write(dir: &Path) -> anyhow::Result<PathBuf> {
    let json_path = dir.join("bake.json");
    let mut bake = report::read_bake_report(&json_path)?;
    let mut json: Value = serde_json::from_str(&text_file(&json_path)?)?;
    // What is embedded says nothing of the file that it is embedded in, so that a second one has the same bytes.
    if let Some(names) = json["files"].as_array_mut() {
        names.retain(|name| name != REPORT_NAME);
    }
    if let Some(hashes) = json["hashes"].as_object_mut() {
        hashes.shift_remove(REPORT_NAME);
    }
    let files = report::page_files(dir, &bake)?;
    let stem = files.first().map_or("", |file| file.stem.as_str());
    let (scene, page_of) = render::baked_scene(dir, stem)?;
    let (world, backend) = build(scene, None, 1)?;
    let framing = Framing {
        size: [800, 600],
        ..Framing::default()
    };
    let around = ambake::surrounding(&world, backend.as_ref(), framing.up);
    let camera = framing.fitted(&world, backend.as_ref(), &around, false)?;
    let distance = (world.bounds().center() - camera.eye).dot(camera.forward);
    let look = camera.eye
        + camera.forward * distance.max(0.1 * (world.bounds().max - world.bounds().min).length());

    let mut lit = look_at(&world, backend.as_ref(), &camera, &page_of)?;
    let step = step(files.len() as u64, bake.atlas.page_size);
    let mut pages = Vec::with_capacity(files.len());
    for file in &files {
        let page = report::read_page(dir, &bake, file)?.page;
        if let Some(layer) = LIGHT.iter().find_map(|name| page.layer(name)) {
            let last = layer.channels.len() - 1;
            let planes = [0, 1, 2].map(|k: usize| &layer.channels[k.min(last)].values[..]);
            lit.add(file.page, page.size, planes);
        }
        pages.push(EmbeddedPage::of(&page, step));
    }
    if pages.iter().all(EmbeddedPage::is_empty) {
        bail!(
            "{}: the bake has no layer to look at; bake again with the layer diffuse",
            dir.display()
        );
    }
    let bench = benchmark(dir);
    let probes = probes(dir, stem, &bake);
    let (seen, alpha) = lit.picture(|radiance| radiance);
    let viewer = Viewer {
        title: stem,
        scene: world.scene(),
        page_of: &page_of,
        pages: &pages,
        view: [camera.eye, look],
        fov: 2.0 * camera.slope.atan(),
        stops: render::Exposure::of(&seen, &alpha).stops.round() as i32,
        kernel: kernel(&bake),
        probes: probes
            .as_ref()
            .and_then(|(report, light)| EmbeddedProbes::of(report, light)),
        bake: &json,
        bench: bench.as_deref(),
    };
    let mut output = Output::create(dir)?;
    output.stage_bytes(REPORT_NAME, viewer.html().as_bytes())?;
    report::stage_report(&mut output, &mut bake, stem)?;
    output.publish()?;
    Ok(dir.join(REPORT_NAME))
}

/// What the harmonics of a bake by the Phong model are evaluated with, where it has any. The colours of microfacets
/// change with the view, which pages do not hold.
fn kernel(bake: &report::BakeReport) -> Option<Kernel> {
    let order = bake.any_view.as_ref()?.order;
    let phong = bake.options.get("model").is_none_or(|model| model != "ggx");
    let table = phong.then(|| bake::KernelTable::new(order as usize, false))?;
    Some(Kernel {
        order,
        columns: table.columns(),
        values: table.values,
    })
}

/// The probes of the scene that stand beside the bake, and the light that each is shown with.
fn probes(
    dir: &Path,
    stem: &str,
    bake: &report::BakeReport,
) -> Option<(ProbeReport, Vec<Vec<DVec3>>)> {
    let report = report::read_probes(&dir.join(report::probe_file(stem))).ok()?;
    if report.scene_hash != bake.scene.content_hash {
        return None;
    }
    let light = match ProbeVolume::of(&report) {
        Some(volume) => volume.probes().to_vec(),
        None => report.lights().collect(),
    };
    Some((report, light))
}

/// The rows of a benchmark that stands in the folder of the bake or in its `bench`, where there is one.
fn benchmark(dir: &Path) -> Option<String> {
    let places = ["bench.csv", "bench/bench.csv"].map(|name| dir.join(name));
    let mut texts = places.iter().filter_map(|path| text_file(path).ok());
    texts.find(|text| text.starts_with("technique,effort,"))
}

/// Texels across, of which one is embedded.
fn step(pages: u64, edge: u32) -> u32 {
    let fits = |step: u32| {
        let edge = edge.div_ceil(step);
        edge <= MOST_EDGE && pages * u64::from(edge).pow(2) <= MOST_TEXELS
    };
    (1..).find(|&step| fits(step) || step >= edge).unwrap_or(1)
}

/// What the first view sees, in a few pixels: enough to know how bright it is.
fn look_at(
    world: &World,
    backend: &dyn RayBackend,
    camera: &Camera,
    page_of: &[Option<u32>],
) -> Result<Lit, render::Error> {
    let (surfaces, lamps) = (Surfaces::new(world), Lamps::of(world));
    let direct = Direct {
        rays: 1,
        ..Direct::new(&surfaces, backend, &lamps)
    };
    let camera = Camera {
        size: [160, 120],
        ..*camera
    };
    let place = |hit: &SurfaceHit| TexelPlace::in_scene(world.scene(), page_of, hit);
    Lit::look(&direct, &camera, 1, &(), 1, place)
}

/// Opens a file in the browser of the desktop; false where there is none.
fn open(path: &Path) -> bool {
    let desktop = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let program = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else if desktop("DISPLAY") || desktop("WAYLAND_DISPLAY") || desktop("BROWSER") {
        "xdg-open"
    } else {
        return false;
    };
    let mut command = Command::new(program);
    let quiet = command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    quiet.arg(path).spawn().is_ok()
}

#[cfg(test)]
mod tests {
    use super::step;

    #[test]
    fn pages_are_reduced_until_a_browser_takes_them() {
        for (pages, edge, expected) in [
            (1, 1024, 1),
            (8, 2048, 1),
            (9, 2048, 2),
            (1, 16_384, 3),
            (1, 1, 1),
        ] {
            assert_eq!(step(pages, edge), expected, "{pages} pages of {edge}");
        }
    }
}
