//! Shading from tables: error and flicker of each look-up against 1,024 samples a pixel, and frames a second.
//!
//! A body without symmetry turns before a sky with a small sun. RMS is over the pixels that show the body and all
//! frames; flicker is the RMS of what the difference from the truth changes by between successive frames. Both in units
//! of the body's mean radiance.

use crate::clock::time;
use crate::maps::sunlit;
use crate::summary::median;
use crate::tables_truth::{body, truth, turned};
use environment::{Image, Projection};
use frames::{GBuffer, Lookup, Shader, Surfel, Table, View};
use glam::DVec3;
use render::Camera;
use serde::Serialize;

/// Error and flicker of a look-up in one case.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The body, its size in the picture and the table.
    pub case: String,
    /// The look-up.
    pub lookup: String,
    /// Pixels that show the body, a frame.
    pub pixels: usize,
    /// RMS of the difference from the truth over the mean of the truth.
    pub rms: f64,
    /// RMS of its change from frame to frame over the mean of the truth.
    pub flicker: f64,
}

/// Speed of a look-up.
#[derive(Debug, Clone, Serialize)]
pub struct Speed {
    /// The look-up.
    pub lookup: String,
    /// Pixels of the picture, all of which show the body.
    pub pixels: usize,
    /// Median milliseconds of shading a frame with D and S from a buffer in memory.
    pub milliseconds: f64,
    /// Slowest and fastest of the repeats.
    pub spread: [f64; 2],
}

const LOOKUPS: [Lookup; 5] = [
    Lookup::Nearest,
    Lookup::Bilinear,
    Lookup::Recursive,
    Lookup::Quad,
    Lookup::Summed,
];

/// Frames of a turn, and the angle between them in radians.
const FRAMES: u32 = 8;
const STEP: f64 = 0.02;

/// Radiance of the sun, half a degree wide, beside a sky of 1.
const SUN: f64 = 1e3;

/// Error and flicker of all look-ups in all cases, in the current pool of threads.
///
/// # Errors
/// None is expected: the maps are sound.
pub fn quality() -> Result<Vec<Row>, frames::Error> {
    let sky = sunlit(Projection::Polar, (1024, 512), SUN)?;
    let mirror = Table::new(&sky)?;
    let glossy = Table::new(&maps::specular(&sky, 100.0, (512, 256))?)?;
    let polished = Table::new(&maps::specular(&sky, 1000.0, (512, 256))?)?;
    let mut rows = Vec::new();
    for (name, wrinkles, size) in [
        ("smooth, 64 pixels", 0.0, 64),
        ("wrinkled, 64 pixels", 0.15, 64),
        ("smooth, far away, 16 pixels", 0.0, 16),
    ] {
        for (of, table) in [
            ("n = 100", &glossy),
            ("n = 1000", &polished),
            ("mirror", &mirror),
        ] {
            let case = format!("{name}, {of}");
            rows.extend(measure(
                &case,
                wrinkles,
                size,
                &Shader::of(None, Some(table)),
            )?);
        }
    }
    Ok(rows)
}

fn measure(
    case: &str,
    wrinkles: f64,
    size: u32,
    shader: &Shader,
) -> Result<Vec<Row>, frames::Error> {
    let eye = DVec3::new(0.5, 0.6, 3.0);
    let camera = Camera::new(eye, DVec3::ZERO, DVec3::Y, 0.7, [size, size])?;
    let hit = |eye, direction| body(wrinkles, eye, direction);
    let side = size as usize;
    let mut sums = vec![[0.0f64; 2]; LOOKUPS.len()];
    let mut before: Vec<Vec<Option<[f64; 3]>>> = vec![vec![None; side * side]; LOOKUPS.len()];
    let (mut mean, mut pixels, mut pairs) = (0.0, 0, 0);
    for frame in 0..FRAMES {
        let turn = turned(f64::from(frame) * STEP);
        let exact = truth(&camera, turn, shader, hit);
        let view = View {
            camera: &camera,
            turn,
            samples: 2,
            corners: true,
        };
        let buffer = GBuffer::take(&view, &(), hit)?;
        for place in buffer.places() {
            mean += exact[place].iter().sum::<f64>() / 3.0;
        }
        pixels += buffer.pixels();
        for (k, lookup) in LOOKUPS.into_iter().enumerate() {
            let mut picture = Image::filled(side, side, [0.0; 3]);
            shader.frame(&buffer, lookup, &mut picture);
            let mut now = vec![None; side * side];
            for (place, coverage) in buffer.places().zip(buffer.coverage()) {
                let shown = picture.pixels[place].map(|v| f64::from(v / coverage));
                let off = [0, 1, 2].map(|c: usize| shown[c] - exact[place][c]);
                sums[k][0] += square(off);
                if let Some(last) = before[k][place] {
                    sums[k][1] += square([0, 1, 2].map(|c: usize| off[c] - last[c]));
                    pairs += usize::from(k == 0);
                }
                now[place] = Some(off);
            }
            before[k] = now;
        }
    }
    let mean = mean / pixels as f64;
    let rows = LOOKUPS.into_iter().zip(sums).map(|(lookup, sums)| Row {
        case: case.into(),
        lookup: lookup.name().into(),
        pixels: pixels / FRAMES as usize,
        rms: (sums[0] / pixels as f64).sqrt() / mean,
        flicker: (sums[1] / pairs as f64).sqrt() / mean,
    });
    Ok(rows.collect())
}

/// Mean of the squares.
fn square(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) / 3.0
}

/// Time of shading 1920 x 1080 pixels, all on a globe, with D of 72 x 36 and S of 512 x 256 texels.
///
/// # Errors
/// None is expected: the maps are sound.
pub fn speed(repeats: usize) -> Result<Vec<Speed>, frames::Error> {
    let sky = sunlit(Projection::Polar, (1024, 512), SUN)?;
    let diffuse = Table::new(&maps::diffuse(&sky, (72, 36))?)?;
    let specular = Table::new(&maps::specular(&sky, 100.0, (512, 256))?)?;
    let eye = DVec3::new(0.2, 0.3, 1.0).normalize() * 1.2;
    let camera = Camera::new(eye, DVec3::ZERO, DVec3::Y, 0.6, [1920, 1080])?;
    let view = View {
        camera: &camera,
        turn: turned(0.0),
        samples: 1,
        corners: true,
    };
    let buffer = GBuffer::take(&view, &(), globe)?;
    let shader = Shader::of(Some(&diffuse), Some(&specular));
    let mut picture = Image::filled(1920, 1080, [0.0; 3]);
    let rows = LOOKUPS.map(|lookup| {
        let mut milliseconds = Vec::new();
        // Once to warm up.
        for repeat in 0..=repeats {
            let ((), spent) = time(|| shader.frame(&buffer, lookup, &mut picture));
            if repeat > 0 {
                milliseconds.push(1e3 * spent.wall);
            }
        }
        let fold =
            |start: f64, pick: fn(f64, f64) -> f64| milliseconds.iter().copied().fold(start, pick);
        Speed {
            lookup: lookup.name().into(),
            pixels: buffer.pixels(),
            spread: [fold(0.0, f64::max), fold(f64::INFINITY, f64::min)],
            milliseconds: median(milliseconds.clone()),
        }
    });
    Ok(rows.into())
}

/// A diffuse and glossy globe of radius 1.
fn globe(eye: DVec3, direction: DVec3) -> Option<Surfel> {
    let b = eye.dot(direction);
    let root = b * b - eye.length_squared() + 1.0;
    (root >= 0.0 && b < 0.0).then(|| Surfel {
        normal: (eye + direction * (-b - root.sqrt())).normalize(),
        albedo: DVec3::splat(0.5),
        specular: DVec3::splat(0.5),
        ..Surfel::default()
    })
}

/// Rows of error and flicker as a CSV file with a head.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from("case,lookup,pixels,rms,flicker\n");
    for row in rows {
        text += &format!(
            "\"{}\",{},{},{},{}\n",
            row.case, row.lookup, row.pixels, row.rms, row.flicker
        );
    }
    text
}

/// Rows of speed as a CSV file with a head.
pub fn speed_csv(rows: &[Speed]) -> String {
    let mut text = String::from("lookup,pixels,milliseconds,slowest,fastest\n");
    for row in rows {
        text += &format!(
            "{},{},{},{},{}\n",
            row.lookup, row.pixels, row.milliseconds, row.spread[0], row.spread[1]
        );
    }
    text
}

/// Both as tables.
pub fn markdown(rows: &[Row], speed: &[Speed]) -> String {
    let mut text = String::from(
        "RMS of the difference from 1,024 samples a pixel and of its change from frame to frame (flicker), over the \
         mean radiance of the body, with S alone:\n\n| body, table | look-up | pixels | RMS | flicker |\n\
         |---|---|---|---|---|\n",
    );
    for row in rows {
        text += &format!(
            "| {} | {} | {} | {:.4} | {:.4} |\n",
            row.case, row.lookup, row.pixels, row.rms, row.flicker
        );
    }
    text += "\nTime of shading another picture, a globe that fills 1920 x 1080 pixels, with D and S (n = 100) from a \
             buffer in memory. It is not the price of the errors above, which are of smaller pictures and \
             without D:\n\n\
             | look-up | pixels | shading, ms a frame | slowest, fastest | frames shaded a second |\n\
             |---|---|---|---|---|\n";
    for row in speed {
        text += &format!(
            "| {} | {} | {:.2} | {:.2}, {:.2} | {:.1} |\n",
            row.lookup,
            row.pixels,
            row.milliseconds,
            row.spread[0],
            row.spread[1],
            1e3 / row.milliseconds
        );
    }
    text
}
