//! `ambake map ball`: photographs of a mirrored ball to an illumination map.

use crate::map::{self, Common};
use crate::{args, host, map_file, say};
use anyhow::{Context, bail};
use clap::Args as ClapArgs;
use maps::ball::{self, Circle, Found, Optics, Photo};
use maps::{Image, Layout, Orientation, Projection};
use serde_json::json;
use std::path::PathBuf;

#[derive(ClapArgs)]
pub struct Args {
    /// Photographs of a mirrored ball: .hdr, .exr, or .png and .jpg taken as sRGB; two from directions 90 degrees apart
    /// hide each other's rim and camera best
    #[arg(value_name = "IN", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Map to write: .exr, with the channel `confidence`, or .hdr; for a cube NAME.exr stands for NAME_px.exr … NAME_nz.exr
    #[arg(short = 'o', long = "output", value_name = "OUT")]
    pub output: PathBuf,
    /// Outline of the ball: its middle from the left and from the top, and its radius, in pixels; once for each IN
    /// [default: found by its edge]
    #[arg(long, value_name = "X,Y,R", allow_hyphen_values = true, value_parser = circle)]
    pub circle: Vec<Circle>,
    /// Distance of the camera from the middle of the ball, in radii of the ball; once, or once for each IN [default: far
    /// away, an orthographic picture]
    #[arg(long, value_name = "D", allow_hyphen_values = true, value_parser = distance)]
    pub distance: Vec<f64>,
    /// Direction from the ball to the camera in ambake's axes, +y up; once for each IN [default for one IN: 0,0,1]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = args::triple)]
    pub toward: Vec<[f64; 3]>,
    /// Reflectance of the ball, one number or R,G,B; it is divided out
    #[arg(long, value_name = "R,G,B", default_value = "1", value_parser = reflectance)]
    pub reflectance: [f64; 3],
    /// Projection of OUT: polar, cube, cross, strip, ortho, ball, angular, octahedral
    #[arg(long, value_name = "PROJECTION", default_value = "polar", value_parser = map::projection)]
    pub to: Projection,
    /// Width and height of OUT in texels; of one face for a cube [default: as fine as the middle of the largest ball]
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    pub size: Option<[u32; 2]>,
    #[command(flatten)]
    pub common: Common,
}

/// Runs the verb.
pub fn run(args: &Args) -> anyhow::Result<()> {
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
    for (index, path) in args.inputs.iter().enumerate() {
        let image = maps::read(path)?.image;
        outlines.push(match args.circle.get(index) {
            Some(circle) => (*circle, None),
            None => {
                let found = ball::find(&image).with_context(|| path.display().to_string())?;
                (found.circle, Some(found))
            }
        });
        images.push(image);
    }
    let optics = |index: usize| {
        let given = args.distance.get(index).or(args.distance.first());
        given.map_or(Optics::Orthographic, |d| Optics::Near(*d))
    };
    let photos: Vec<Photo> = (0..count)
        .map(|index| Photo {
            image: &images[index],
            circle: outlines[index].0,
            from: args.toward.get(index).copied().unwrap_or([0.0, 0.0, 1.0]),
            optics: optics(index),
        })
        .collect();
    let size = match args.size {
        Some(size) => map_file::picture_size(args.to, size),
        None => {
            // A circle of directions, by the angle that a pixel in the middle spans.
            let density = photos.iter().map(|p| p.circle.radius * p.optics.slope(0.0));
            let texels = std::f64::consts::TAU * density.fold(0.0, f64::max);
            args.to.size(texels.clamp(1.0, 32768.0).ceil() as usize)
        }
    };
    let unwrapped = ball::unwrap(&photos, args.to, size, args.reflectance)?;
    let layout = Layout {
        projection: args.to,
        orientation: Orientation::Ambake,
        size,
    };
    let files = map_file::write_with_confidence(
        &args.output,
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
        let json = json!({
            "schema_version": 1, "balls": balls, "projection": args.to.name(), "size": [size.0, size.1],
            "masked_texels": masked, "unseen": unseen, "files": files,
        });
        return say(&format!("{}\n", serde_json::to_string_pretty(&json)?));
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

/// What is known about one photograph.
fn line(photo: &Photo, found: Option<Found>, path: &std::path::Path) -> String {
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

fn circle(text: &str) -> Result<Circle, String> {
    let [x, y, radius] = args::triple(text)?;
    Ok(Circle { x, y, radius })
}

fn distance(text: &str) -> Result<f64, String> {
    args::number(text)
}

fn reflectance(text: &str) -> Result<[f64; 3], String> {
    match text.contains(',') {
        true => args::triple(text),
        false => Ok([args::number(text)?; 3]),
    }
}
