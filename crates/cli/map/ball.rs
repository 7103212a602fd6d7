//! `ambake map ball`: photographs of a mirrored ball to an illumination map.

use super::args::{Ball, GainsName};
use super::file;
use crate::host;
use crate::outcome::{say, say_json};
use anyhow::{Context, bail};
use environment::{Image, MapLayout, Orientation};
use maps::Gains;
use maps::ball::{self, Circle, Found, Optics, Photo};
use serde_json::json;
use std::path::Path;

/// Runs the sub-verb.
pub fn run(args: &Ball) -> anyhow::Result<()> {
    host::set_threads(args.common.threads)?;
    let count = args.inputs.len();
    let matches = |given: usize| given == 0 || given == count;
    if !matches(args.circle.len()) || !matches(args.toward.len()) {
        bail!("{count} photographs take {count} times --circle and --toward, or none of them");
    }
    if args.toward.is_empty() && count > 1 {
        bail!(
            "several photographs need --toward for each, the direction from the ball to the camera"
        );
    }
    if !matches(args.distance.len()) && args.distance.len() != 1 {
        bail!("{count} photographs take one --distance, or one for each");
    }
    let mut images: Vec<Image> = Vec::new();
    let mut outlines = Vec::new();
    let read = file::photographs(args.response.as_deref())?;
    for (index, path) in args.inputs.iter().enumerate() {
        let image = read(path)?;
        outlines.push(match args.circle.get(index) {
            Some(circle) => (*circle, None),
            None => {
                let found = ball::find(&image).with_context(|| path.display().to_string())?;
                (found.circle, Some(found))
            }
        });
        images.push(image);
    }
    let gains = match args.gains {
        GainsName::Off => Gains::none(count),
        GainsName::Auto => ball::gains(&photos(args, &images, &outlines))?,
    };
    for (image, factors) in images.iter_mut().zip(&gains.factors) {
        let even = |v: f32, factor: f64| (f64::from(v) * factor).min(f64::from(f32::MAX)) as f32;
        for pixel in image.pixels.iter_mut().filter(|_| *factors != [1.0; 3]) {
            *pixel = std::array::from_fn(|c| even(pixel[c], factors[c]));
        }
    }
    let photos = photos(args, &images, &outlines);
    let size = match args.size {
        Some(size) => file::picture_size(args.to, size),
        None => {
            // A circle of directions, by the angle that a pixel in the middle spans.
            let density = photos.iter().map(|p| p.circle.radius * p.optics.slope(0.0));
            let texels = std::f64::consts::TAU * density.fold(0.0, f64::max);
            args.to.size(texels.clamp(1.0, 32768.0).ceil() as usize)
        }
    };
    let unwrapped = ball::unwrap(&photos, args.to, size, args.reflectance)?;
    let layout = MapLayout {
        projection: args.to,
        orientation: Orientation::Ambake,
        size,
    };
    let target = file::Target {
        path: &args.output,
        inputs: &args.inputs,
    };
    let files = file::write_with_confidence(
        &target,
        &unwrapped.image,
        &unwrapped.confidence,
        layout,
        "radiance; where confidence is 0 no ball shows the direction, and the mean of all that are seen stands",
    )?;
    let areas = args.to.solid_angles(size);
    let texels = unwrapped.confidence.iter().zip(&areas);
    let masked = texels
        .filter(|(c, omega)| **c == 0.0 && **omega > 0.0)
        .count();
    let unseen = (1.0 - unwrapped.seen / ambient::convention::SPHERE).max(0.0);
    if args.common.json {
        let balls: Vec<_> = photos
            .iter()
            .zip(&outlines)
            .zip(&args.inputs)
            .map(|((photo, (c, found)), path)| {
                json!({
                    "photograph": path, "circle": [c.x, c.y, c.radius],
                    "rim_residual_pixels": found.map(|f| f.residual), "rim_found": found.map(|f| f.rim),
                    "blind_half_angle_deg": photo.optics.blind().to_degrees(),
                })
            })
            .collect();
        return say_json(&json!({
            "schema_version": 1, "balls": balls, "projection": args.to.name(), "size": [size.0, size.1],
            "gains": (args.gains == GainsName::Auto).then_some(&gains.factors), "masked_texels": masked,
            "unseen": unseen, "files": files,
        }));
    }
    if args.common.quiet {
        return Ok(());
    }
    let mut text = String::new();
    for ((photo, (_, found)), path) in photos.iter().zip(&outlines).zip(&args.inputs) {
        text += &line(photo, *found, path);
    }
    text += &format!(
        "{masked} texels, {:.3} % of the sphere, are seen by no ball: confidence 0, filled with the mean\n",
        100.0 * unseen
    );
    for file in &files {
        text += &format!("wrote {}\n", file.display());
    }
    say(&text)
}

/// The photographs with what the arguments say of them.
fn photos<'a>(
    args: &Ball,
    images: &'a [Image],
    outlines: &[(Circle, Option<Found>)],
) -> Vec<Photo<'a>> {
    let optics = |index: usize| {
        let given = args.distance.get(index).or(args.distance.first());
        given.map_or(Optics::Orthographic, |d| Optics::Near(*d))
    };
    let photo = |(index, image): (usize, &'a Image)| Photo {
        image,
        circle: outlines[index].0,
        from: args.toward.get(index).copied().unwrap_or([0.0, 0.0, 1.0]),
        optics: optics(index),
    };
    images.iter().enumerate().map(photo).collect()
}

/// What is known about one photograph.
fn line(photo: &Photo, found: Option<Found>, path: &Path) -> String {
    let c = photo.circle;
    let how = match found {
        Some(f) => format!(
            "found on {:.0} % of the rim, residual {:.2} pixels",
            100.0 * f.rim,
            f.residual
        ),
        None => "given".to_owned(),
    };
    format!(
        "{}: circle {:.2},{:.2},{:.2} {how}; blind cone of {:.2} degrees about {:?}\n",
        path.display(),
        c.x,
        c.y,
        c.radius,
        photo.optics.blind().to_degrees(),
        photo.from.map(|v| if v == 0.0 { 0.0 } else { -v }),
    )
}
