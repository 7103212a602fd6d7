//! The flags of balls in a picture.

use ambake::flags::parse::number;
use ambake::flags::probes::corners;
use clap::Args as ClapArgs;
use std::path::PathBuf;

/// Balls in the picture.
#[derive(ClapArgs)]
pub struct Balls {
    /// White ball in the light of the place X,Y,Z of this radius, by the nine harmonics of a probe that is gathered
    /// there; several are separated by semicolons. With --bake its light is that of the bake. It casts no shadow
    /// [default radius: a fortieth of the scene]
    #[arg(help_heading = "Balls")]
    #[arg(long, value_name = "X,Y,Z[,RADIUS];..", value_delimiter = ';', allow_hyphen_values = true,
          value_parser = ball, conflicts_with_all = ["figure", "shading", "encode"])]
    pub probe_ball: Vec<Place>,
    /// Light the balls by the volume in this STEM.probes.json, as engines do: linearly between the probes around
    #[arg(help_heading = "Balls", hide_short_help = true)]
    #[arg(long, value_name = "FILE", requires = "probe_ball")]
    pub probes: Option<PathBuf>,
    /// Mirror ball at X,Y,Z of this radius, along whose rays the scene is seen; as --probe-ball
    #[arg(help_heading = "Balls")]
    #[arg(long, value_name = "X,Y,Z[,RADIUS];..", value_delimiter = ';', allow_hyphen_values = true,
          value_parser = ball, conflicts_with_all = ["figure", "shading", "encode"])]
    pub mirror_ball: Vec<Place>,
    /// Let mirror balls show this map of their surroundings, as engines do: a picture that `ambake probes
    /// --reflections` wrote, .exr or .hdr
    #[arg(help_heading = "Balls", hide_short_help = true)]
    #[arg(long, value_name = "FILE", requires = "mirror_ball")]
    pub reflection: Option<PathBuf>,
    /// The map is as far away as the walls of this box, by two corners: the `room` of the reflection [default:
    /// endlessly far]
    #[arg(help_heading = "Balls", hide_short_help = true)]
    #[arg(
        long,
        value_name = "X,Y,Z:X,Y,Z",
        requires = "reflection",
        allow_hyphen_values = true
    )]
    #[arg(value_parser = corners)]
    pub room: Option<[[f64; 3]; 2]>,
}

/// A ball as it was typed.
#[derive(Clone, Copy)]
pub struct Place {
    pub center: [f64; 3],
    /// `None` for a share of the scene.
    pub radius: Option<f64>,
}

fn ball(text: &str) -> Result<Place, String> {
    let numbers: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    let (center, radius) = match *numbers.as_slice() {
        [x, y, z] => ([x, y, z], None),
        [x, y, z, radius] if radius > 0.0 => ([x, y, z], Some(radius)),
        [_, _, _, radius] => return Err(format!("the radius {radius} must be above 0")),
        _ => return Err("expected X,Y,Z or X,Y,Z,RADIUS".into()),
    };
    Ok(Place { center, radius })
}
