//! `ambake render --figure`: the figures of the papers.

use crate::render::frames;
use crate::render::run::{Args, shader};
use crate::{Outcome, host};
use ::bench::figures::{Fig3, fig1, fig1_csv, fig1_svg, fig3};
use ::render::Lamps;
use anyhow::bail;
use clap::ValueEnum;
use maps::{Format, Image, Labels};
use rays::{RayBackend, Surfaces, World};
use report::Output;
use serde_json::json;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Figure {
    /// Specular ambient term against view angle and exponent: fig1.svg and fig1.csv
    Fig1,
    /// The scene in ambient light only by the three models, with their differences: fig3_*.exr, fig3_*.png and fig3.csv
    Fig3,
    /// The scene in six materials before --environment: balls.png and balls.exr
    Balls,
}

/// Draws a figure into the one directory of the arguments.
pub fn draw(
    figure: Figure,
    args: &Args,
    world: &World,
    backend: &dyn RayBackend,
) -> anyhow::Result<Outcome> {
    let [dir] = args.output.as_slice() else {
        bail!("--figure takes one -o DIR");
    };
    let surfaces = Surfaces::new(world);
    let lamps = Lamps::of(world);
    let mut direct = shader(args, &surfaces, backend, &[], &lamps);
    match figure {
        Figure::Fig1 => {
            let points = fig1(&mut direct);
            let mut output = Output::create(dir)?;
            output.stage_bytes("fig1.csv", fig1_csv(&points).as_bytes())?;
            output.stage_bytes("fig1.svg", fig1_svg(&points).as_bytes())?;
            output.publish()?;
            Ok(Outcome::Done)
        }
        Figure::Fig3 => {
            let camera = args.view.camera(world)?;
            let figure = fig3(&mut direct, &camera, args.view.samples);
            let about = json!({
                "scene": world.scene().content_hash,
                "rays": args.rays,
                "samples": args.view.samples,
                "eye": camera.eye.to_array(),
                "forward": camera.forward.to_array(),
                "fov_deg": args.view.fov_deg,
                "sky": args.sky,
                "seed": args.common.seed,
            });
            let mut output = Output::create(dir)?;
            stage(&mut output, &figure, &about.to_string())?;
            output.publish()?;
            Ok(Outcome::Done)
        }
        Figure::Balls => frames::balls(args, dir, world, backend),
    }
}

/// Pictures in sRGB, differences in colours about white with a scale.
fn stage(output: &mut Output, figure: &Fig3, about: &str) -> anyhow::Result<()> {
    let labels = Labels::from([
        ("ambakeVersion".into(), host::VERSION.into()),
        ("ambakeOptions".into(), about.into()),
    ]);
    output.stage_bytes("fig3.csv", figure.csv().as_bytes())?;
    for (name, image) in figure.pictures() {
        let exr = maps::encode(image, Format::Exr, &labels)?;
        output.stage_bytes(&format!("fig3_{name}.exr"), &exr)?;
    }
    for (name, image) in figure.pictures().take(3) {
        let png = report::picture_png(image.width, &image.pixels);
        output.stage_bytes(&format!("fig3_{name}.png"), &png)?;
    }
    for (name, image) in figure.pictures().skip(3) {
        output.stage_bytes(&format!("fig3_{name}.png"), &difference(name, image))?;
    }
    Ok(())
}

/// The channel of each pixel that differs most.
fn difference(name: &str, image: &Image) -> Vec<u8> {
    let farther = |most: f32, &v: &f32| if v.abs() > most.abs() { v } else { most };
    let value = |pixel: &[f32; 3]| f64::from(pixel.iter().fold(0.0, farther));
    let most = image.pixels.iter().map(|p| value(p).abs());
    let limit = report::nice_limit(most.fold(0.0, f64::max));
    let title = name.replace('-', " - ");
    let size = [image.width as u32, image.height as u32];
    report::difference_picture(size, &title, limit, |at| Some(value(&image.pixels[at])))
}
