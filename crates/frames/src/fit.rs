//! Material coefficients from pictures of a known shape in ambient light.
//!
//! X. Zhang, Y. Gao, "Generalised Ambient Reflection Models for Lambertian and Phong Surfaces", ICIP 2009, sections 3
//! and 4. With the shape known, equation (9) is linear in the two reflectances of a channel once the exponent is:
//!
//! ```text
//! pixel = exposure (albedo D + specular S(n)),
//! ```
//!
//! where D and S(n) are the same pixel of a surface of albedo 1 and of one of specular reflectance 1. Both are
//! integrated by rays, with one set of directions for every n. For each exponent the reflectances follow from linear
//! least squares; the exponent that leaves the least is looked for on a scale of ln(n + 1). Standard errors are those
//! of the linearised problem of all seven numbers, with the variance that the pixels leave.

use ambient::Estimate;
use environment::Image;
use glam::DVec3;
use layers::Progress;
use rays::Overrides;
use render::{Camera, Direct, Error, Model, Part, Sample, each};

/// Most pixels that are compared: those of a regular grid over all pictures.
const MOST_PIXELS: usize = 3000;
/// Exponents of the first search, as steps of ln(n + 1) up to n = 1000.
const STEPS: u32 = 12;
/// Steps of the golden section: each leaves 0.618 of the interval.
const SECTIONS: u32 = 12;
/// A reflectance this far below what could be told from 0.
const TOLD: f64 = 1e-9;

/// A photograph and the camera that took it, of the same size.
pub struct Shot<'a> {
    /// Where it was taken from.
    pub camera: Camera,
    /// Linear radiance.
    pub picture: &'a Image,
}

/// What the pictures say of the material.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Diffuse reflectance of each channel.
    pub albedo: [Estimate; 3],
    /// Specular reflectance of each channel.
    pub specular: [Estimate; 3],
    /// Lobe exponent; none where nothing reflects specularly.
    pub exponent: Option<Estimate>,
    /// Root mean square of what is left, in the unit of the pictures.
    pub residual: f64,
    /// Pixels that were compared.
    pub pixels: usize,
}

/// A pixel that shows the shape alone.
#[derive(Clone, Copy)]
struct Pixel {
    shot: usize,
    index: u32,
    /// What the picture has there, over the exposure.
    value: DVec3,
}

/// The best reflectances for one exponent.
struct Linear {
    albedo: DVec3,
    specular: DVec3,
    squares: f64,
}

/// Fits one material of the whole scene to pictures. `direct` says how the shape is seen: its sky, its rays; its model
/// and its materials are replaced. `grid` is the number of camera samples of a pixel along an axis, `exposure` what
/// radiance was multiplied by.
///
/// # Errors
/// [`Error::Text`] where too little of the shape is seen or the terms cannot be told apart; [`Error::Cancelled`].
pub fn fit(
    direct: &mut Direct<'_>,
    shots: &[Shot<'_>],
    (grid, exposure): (u32, f64),
    progress: &dyn Progress,
) -> Result<Fit, Error> {
    direct.model = Model::Phong;
    direct.background = Some(DVec3::NAN);
    let all = u64::from(STEPS + SECTIONS + 6);
    let mut passes = 0..all;
    let mut basis = |pixels: &[Pixel], specular: Option<f64>| {
        let [albedo, reflectance] = if specular.is_some() {
            [0.0, 1.0]
        } else {
            [1.0, 0.0]
        };
        direct.overrides = Overrides {
            albedo: Some([albedo; 3]),
            specular: Some([reflectance; 3]),
            exponent: Some(specular.unwrap_or(0.0)),
        };
        let part = Part {
            whole: progress,
            index: passes.next().unwrap_or(all - 1),
            count: all,
        };
        let direct = &*direct;
        each(pixels.len(), 1, &part, |at| {
            let pixel = pixels[at];
            let sample = |number| Sample::of(&shots[pixel.shot].camera, grid, pixel.index, number);
            let sum: DVec3 = (0..grid * grid).map(|n| direct.radiance(&sample(n))).sum();
            sum / f64::from(grid * grid)
        })
    };
    let candidates = candidates(shots, exposure);
    let seen = basis(&candidates, None)?;
    let kept = candidates.iter().zip(&seen).filter(|(_, d)| d.is_finite());
    let (pixels, diffuse): (Vec<Pixel>, Vec<DVec3>) = kept.map(|(p, d)| (*p, *d)).unzip();
    if pixels.len() < 16 {
        return Err(Error::Text(
            "fewer than 16 pixels show the shape alone; check --eye, --look and --fov-deg, or give larger pictures",
        ));
    }
    let mut best: Option<(f64, Linear, Vec<DVec3>)> = None;
    let mut try_at = |scale: f64, best: &mut Option<(f64, Linear, Vec<DVec3>)>| {
        let specular = basis(&pixels, Some(scale.exp_m1()))?;
        let found = linear(&pixels, &diffuse, &specular);
        let squares = found.squares;
        if best.as_ref().is_none_or(|(_, b, _)| squares < b.squares) {
            *best = Some((scale, found, specular));
        }
        Ok::<f64, Error>(squares)
    };
    let step = 1001f64.ln() / f64::from(STEPS);
    for k in 0..=STEPS {
        try_at(step * f64::from(k), &mut best)?;
    }
    let middle = best.as_ref().map_or(0.0, |(scale, ..)| *scale);
    let (mut low, mut high) = ((middle - step).max(0.0), middle + step);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let mut inner = [high - golden * (high - low), low + golden * (high - low)];
    let mut squares = [try_at(inner[0], &mut best)?, try_at(inner[1], &mut best)?];
    for _ in 0..SECTIONS {
        if squares[0] < squares[1] {
            (high, inner[1], squares[1]) = (inner[1], inner[0], squares[0]);
            inner[0] = high - golden * (high - low);
            squares[0] = try_at(inner[0], &mut best)?;
        } else {
            (low, inner[0], squares[0]) = (inner[0], inner[1], squares[1]);
            inner[1] = low + golden * (high - low);
            squares[1] = try_at(inner[1], &mut best)?;
        }
    }
    let Some((scale, found, specular)) = best else {
        return Err(Error::Text("the pictures have no pixels"));
    };
    // How S changes with ln(n + 1), over the step that rays resolve.
    const NEAR: f64 = 0.05;
    let [above, below] = [scale + NEAR, (scale - NEAR).max(0.0)]
        .map(|at| basis(&pixels, Some(at.exp_m1())).map(|plane| (at, plane)));
    let ((above, more), (below, less)) = (above?, below?);
    let slopes: Vec<DVec3> = more
        .iter()
        .zip(&less)
        .map(|(a, b)| (*a - *b) / (above - below))
        .collect();
    uncertain(&pixels, [&diffuse, &specular, &slopes], scale, &found)
}

/// The pixels of a regular grid over all pictures whose values are finite.
fn candidates(shots: &[Shot<'_>], exposure: f64) -> Vec<Pixel> {
    let total: usize = shots.iter().map(|shot| shot.picture.pixels.len()).sum();
    // The same step in both directions, so that thin parts are met too.
    let step = ((total as f64 / MOST_PIXELS as f64).sqrt().ceil() as usize).max(1);
    let mut pixels = Vec::new();
    for (shot, of) in shots.iter().enumerate() {
        for y in (step / 2..of.picture.height).step_by(step) {
            for x in (step / 2..of.picture.width).step_by(step) {
                let index = y * of.picture.width + x;
                let value = DVec3::from(of.picture.pixels[index].map(f64::from)) / exposure;
                if value.is_finite() {
                    pixels.push(Pixel {
                        shot,
                        index: index as u32,
                        value,
                    });
                }
            }
        }
    }
    pixels
}

/// Sums of products of D and S in one channel.
fn products(diffuse: &[DVec3], specular: &[DVec3], channel: usize) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (d, s) in diffuse.iter().zip(specular) {
        let (d, s) = (d[channel], s[channel]);
        sums[0] += d * d;
        sums[1] += d * s;
        sums[2] += s * s;
    }
    sums
}

/// Least squares for one exponent; reflectances are 0 or more.
fn linear(pixels: &[Pixel], diffuse: &[DVec3], specular: &[DVec3]) -> Linear {
    let mut found = Linear {
        albedo: DVec3::ZERO,
        specular: DVec3::ZERO,
        squares: 0.0,
    };
    for channel in 0..3 {
        let [dd, ds, ss] = products(diffuse, specular, channel);
        let (mut dv, mut sv) = (0.0, 0.0);
        for ((pixel, d), s) in pixels.iter().zip(diffuse).zip(specular) {
            dv += d[channel] * pixel.value[channel];
            sv += s[channel] * pixel.value[channel];
        }
        let alone = |own: f64, with: f64| {
            if own > 0.0 {
                (with / own).max(0.0)
            } else {
                0.0
            }
        };
        let determinant = dd * ss - ds * ds;
        let both = [
            (dv * ss - sv * ds) / determinant,
            (sv * dd - dv * ds) / determinant,
        ];
        let solution = match determinant > TOLD * dd * ss && both[0] >= 0.0 && both[1] >= 0.0 {
            true => both,
            false => {
                // One of them is at 0: whichever leaves less.
                let (a, s) = (alone(dd, dv), alone(ss, sv));
                if a * dv >= s * sv { [a, 0.0] } else { [0.0, s] }
            }
        };
        [found.albedo[channel], found.specular[channel]] = solution;
        for ((pixel, d), s) in pixels.iter().zip(diffuse).zip(specular) {
            let left = pixel.value[channel] - solution[0] * d[channel] - solution[1] * s[channel];
            found.squares += left * left;
        }
    }
    found
}

/// The solution with the standard errors of all seven numbers: three 2 x 2 blocks that the exponent couples.
fn uncertain(
    pixels: &[Pixel],
    [diffuse, specular, slopes]: [&[DVec3]; 3],
    scale: f64,
    found: &Linear,
) -> Result<Fit, Error> {
    let shines = found.specular.max_element() > TOLD;
    let unknowns = if shines { 7.0 } else { 6.0 };
    let variance = found.squares / (3.0 * pixels.len() as f64 - unknowns);
    let mut blocks = [[0.0; 3]; 3];
    let mut coupled = [[0.0; 2]; 3];
    let mut left = 0.0;
    for channel in 0..3 {
        let [dd, ds, ss] = products(diffuse, specular, channel);
        let determinant = dd * ss - ds * ds;
        if determinant <= TOLD * dd * ss {
            return Err(Error::Text(
                "the pictures do not tell diffuse and specular light apart; \
                 show the shape at more angles to its surface",
            ));
        }
        let inverse = [ss / determinant, -ds / determinant, dd / determinant];
        let (mut own, mut with) = (0.0, [0.0; 2]);
        for ((d, s), slope) in diffuse.iter().zip(specular).zip(slopes) {
            let t = found.specular[channel] * slope[channel];
            own += t * t;
            with[0] += d[channel] * t;
            with[1] += s[channel] * t;
        }
        let through = [
            inverse[0] * with[0] + inverse[1] * with[1],
            inverse[1] * with[0] + inverse[2] * with[1],
        ];
        left += own - with[0] * through[0] - with[1] * through[1];
        (blocks[channel], coupled[channel]) = (inverse, through);
    }
    let scale_variance = match shines && left > 0.0 {
        true => variance / left,
        false => 0.0,
    };
    let with_error = |value: f64, own: f64, through: f64| Estimate {
        value,
        std_err: (variance * own + through * through * scale_variance).sqrt(),
    };
    let channels = [0, 1, 2];
    Ok(Fit {
        albedo: channels.map(|c| with_error(found.albedo[c], blocks[c][0], coupled[c][0])),
        specular: channels.map(|c| with_error(found.specular[c], blocks[c][2], coupled[c][1])),
        exponent: shines.then(|| Estimate {
            value: scale.exp_m1(),
            std_err: scale.exp() * scale_variance.sqrt(),
        }),
        residual: (found.squares / (3.0 * pixels.len() as f64)).sqrt(),
        pixels: pixels.len(),
    })
}
