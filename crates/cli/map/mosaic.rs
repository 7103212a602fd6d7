//! `ambake map mosaic`: six photographs to an illumination map without seams.

use super::args::{GainsName, Mosaic};
use super::file::{self, Target, picture_size};
use crate::host;
use crate::outcome::{say, say_json};
use environment::{MapLayout, Orientation, Projection};
use serde_json::json;

/// Runs the sub-verb.
pub fn run(args: &Mosaic) -> anyhow::Result<()> {
    host::set_threads(args.common.threads)?;
    let inputs = file::face_paths(&args.input)?;
    let read = file::photographs(args.response.as_deref())?;
    let [px, nx, py, ny, pz, nz] = inputs.each_ref().map(|path| read(path));
    let photos = [px?, nx?, py?, ny?, pz?, nz?];
    let equal = args.gains == GainsName::Auto;
    let found = maps::mosaic(&photos, args.fov_deg.to_radians(), equal)?;
    let cube = MapLayout {
        projection: Projection::Cube,
        orientation: Orientation::Ambake,
        size: (found.image.width, found.image.height),
    };
    let layout = MapLayout {
        projection: args.to,
        size: match args.size {
            Some(size) => picture_size(args.to, size),
            None => args.to.size(cube.projection.texels(cube.size)),
        },
        ..cube
    };
    let image = match layout == cube {
        true => found.image,
        false => environment::convert_image(&found.image, cube, layout)?,
    };
    let target = Target {
        path: &args.output,
        inputs: &inputs,
    };
    let normalisation = "radiance up to one factor for each channel";
    let files = file::write(&target, &[(None, &image)], layout, normalisation)?;
    let gains = &found.gains;
    if args.common.json {
        return say_json(&json!({
            "schema_version": 1, "photographs": inputs, "projection": args.to.name(),
            "size": [layout.size.0, layout.size.1],
            "gains": equal.then_some(&gains.factors), "gains_std_err": equal.then_some(&gains.std_err),
            "files": files,
        }));
    }
    if args.common.quiet {
        return Ok(());
    }
    let mut text = String::new();
    for (k, path) in inputs.iter().enumerate().filter(|_| equal) {
        let [r, g, b] = gains.factors[k];
        let error = gains.std_err[k].iter().copied().fold(0.0, f64::max);
        text += &format!(
            "{}: times {r:.4}, {g:.4}, {b:.4}, give or take {:.2} %\n",
            path.display(),
            100.0 * error
        );
    }
    for file in &files {
        text += &format!("wrote {}\n", file.display());
    }
    say(&text)
}
