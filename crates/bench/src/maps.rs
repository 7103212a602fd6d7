//! Convolution of maps against the plain double sum of the 1984 text: time and error in one run.
//!
//! The double sum adds I · Area · f over all texels of the map for every texel of the result, section 6. It is run on
//! some texels of the result and its time scaled to all. The convolution counts a texel as an area, the double sum as
//! its middle; so errors are also given against the sum over 2 x 2 Gauss nodes a texel.

use crate::clock::time;
use crate::summary::{median, rounded};
use environment::{Direction, IlluminationMap, Image, Projection};
use maps::{Error, Lobe, Normalise, ReflectionMap, Request};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::{FRAC_1_PI, TAU};

/// One kernel of a case, or all kernels of it at once.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Which case: the map that is convolved.
    pub case: String,
    /// The lobe and the size of the result.
    pub kernel: String,
    /// Median wall seconds of the convolution by itself; a row of all kernels shares the analysis.
    pub seconds: f64,
    /// Wall seconds of the double sum on `sampled` texels, scaled to the whole result.
    pub double_sum_seconds: f64,
    /// Texels of the result that the double sum was run on.
    pub sampled: usize,
    /// `double_sum_seconds / seconds`.
    pub ratio: f64,
    /// Largest difference from the double sum on the sampled texels, over the largest value of the whole result.
    pub from_double_sum: f64,
    /// The same from the sum over 2 x 2 nodes a texel of the map.
    pub from_fine_sum: f64,
}

/// Texels of a result on which the double sum is timed; the brightest is one of them.
const SAMPLED: usize = 32;

/// All cases in the current pool of threads.
///
/// # Errors
/// None is expected: the requests are sound.
pub fn maps(repeats: usize) -> Result<Vec<Row>, Error> {
    let request = |lobe, projection, size| Request {
        lobe,
        normalise: Normalise::Radiance,
        projection,
        size,
    };
    let mut four = vec![request(Lobe::Lambert, Projection::Polar, (72, 36))];
    four.extend(
        [10.0, 100.0, 1000.0].map(|n| request(Lobe::Phong(n), Projection::Polar, (512, 256))),
    );
    // A mip chain: a face of half the side for a lobe of half the exponent.
    let chain = (0..9).map(|k| {
        let (side, exponent) = (256 >> k, f64::from(2048 >> k));
        request(Lobe::Phong(exponent), Projection::Cube, (side, 6 * side))
    });
    let polar = environment(Projection::Polar, (2048, 1024))?;
    let cube = environment(Projection::Cube, (256, 6 * 256))?;
    let mut rows = case("polar 2048x1024", &polar, &four, repeats)?;
    rows.extend(case(
        "cube of 256x256",
        &cube,
        &chain.collect::<Vec<_>>(),
        repeats,
    )?);
    Ok(rows)
}

/// Rows of a CSV file with a head.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "case,kernel,seconds,double_sum_seconds,sampled,ratio,from_double_sum,from_fine_sum\n",
    );
    for row in rows {
        text += &format!(
            "{},{},{},{},{},{},{},{}\n",
            row.case,
            row.kernel,
            row.seconds,
            row.double_sum_seconds,
            row.sampled,
            row.ratio,
            row.from_double_sum,
            row.from_fine_sum
        );
    }
    text
}

/// A table of the rows, with what was measured and what was scaled.
pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "Wall seconds: the convolution's are the median of the repeats and of the whole result. The plain double sum \
         is timed once, on some texels of the result (`timed`), and scaled to all of them, so the ratio has no spread \
         and is given to two digits. Differences are the largest on those texels, over the largest value of the \
         result. `all of them`: the convolutions share one analysis of the map, the double sums are added up.\n\n\
         | map | kernel, size of the result | convolution, s | plain double sum, s, scaled | timed | ratio \
         | from the double sum | from 2 x 2 nodes a texel |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        text += &format!(
            "| {} | {} | {:.4} | {} | {} | {} | {:.1e} | {:.1e} |\n",
            row.case,
            row.kernel,
            row.seconds,
            rounded(row.double_sum_seconds, 2),
            row.sampled,
            rounded(row.ratio, 2),
            row.from_double_sum,
            row.from_fine_sum
        );
    }
    text
}

fn case(
    name: &str,
    map: &IlluminationMap,
    requests: &[Request],
    repeats: usize,
) -> Result<Vec<Row>, Error> {
    let measured = |requests: &[Request]| -> Result<(Vec<ReflectionMap>, f64), Error> {
        let mut results = maps::convolve(map, requests)?; // once to warm up
        let mut seconds = Vec::new();
        for _ in 0..repeats {
            let (again, spent) = time(|| maps::convolve(map, requests));
            results = again?;
            seconds.push(spent.wall);
        }
        Ok((results, median(seconds)))
    };
    let fine = Areas::of(map, 2);
    let mut rows = Vec::new();
    for request in requests {
        let (results, seconds) = measured(std::slice::from_ref(request))?;
        let places = sampled(&results[0]);
        let (areas, once) = time(|| Areas::of(map, 1));
        let (plain, each) = time(|| areas.double_sum(&request.lobe, &places));
        let texels = request.size.0 * request.size.1;
        let double_sum_seconds = once.wall + each.wall * texels as f64 / places.len() as f64;
        let peak = results[0]
            .image()
            .pixels
            .iter()
            .flatten()
            .fold(0.0, |a: f32, b| a.max(*b));
        let worst = |sums: &[[f64; 3]]| {
            let pairs = places.iter().zip(sums);
            let differences = pairs.flat_map(|((at, _), sum)| {
                let ours = results[0].image().pixels[*at];
                (0..3).map(move |c| (f64::from(ours[c]) - sum[c]).abs())
            });
            differences.fold(0.0, f64::max) / f64::from(peak)
        };
        rows.push(Row {
            case: name.into(),
            kernel: kernel(request),
            seconds,
            double_sum_seconds,
            sampled: places.len(),
            ratio: double_sum_seconds / seconds,
            from_double_sum: worst(&plain),
            from_fine_sum: worst(&fine.double_sum(&request.lobe, &places)),
        });
    }
    let (_, seconds) = measured(requests)?;
    let total: f64 = rows.iter().map(|row| row.double_sum_seconds).sum();
    let largest = |of: fn(&Row) -> f64| rows.iter().map(of).fold(0.0, f64::max);
    rows.push(Row {
        case: name.into(),
        kernel: "all of them".into(),
        seconds,
        double_sum_seconds: total,
        sampled: rows.iter().map(|row| row.sampled).sum(),
        ratio: total / seconds,
        from_double_sum: largest(|row| row.from_double_sum),
        from_fine_sum: largest(|row| row.from_fine_sum),
    });
    Ok(rows)
}

fn kernel(request: &Request) -> String {
    let lobe = match request.lobe {
        Lobe::Lambert => "D".into(),
        Lobe::Phong(n) => format!("S n = {n}"),
        ref other => format!("{other:?}"),
    };
    format!("{lobe} {}x{}", request.size.0, request.size.1)
}

/// Texels of a result with their directions: the brightest, and others spread over it.
fn sampled(map: &ReflectionMap) -> Vec<(usize, Direction)> {
    let pixels = &map.image().pixels;
    let brightest = (0..pixels.len()).max_by(|a, b| pixels[*a][1].total_cmp(&pixels[*b][1]));
    let spread = (1..SAMPLED).map(|k| k * pixels.len() / SAMPLED + k % 7);
    let width = map.size().0;
    let place = |at: usize| {
        let (x, y) = ((at % width) as f64 + 0.5, (at / width) as f64 + 0.5);
        map.projection()
            .direction(map.size(), x, y)
            .map(|d| (at, d))
    };
    let mut texels: Vec<usize> = brightest.into_iter().chain(spread).collect();
    texels.retain(|at| *at < pixels.len());
    texels.sort_unstable();
    texels.dedup();
    texels.into_iter().filter_map(place).collect()
}

/// Parts of texels with their flux.
struct Areas {
    parts: Vec<(Direction, [f64; 3])>,
}

impl Areas {
    /// `nodes` by `nodes` parts a texel, 1 or 2, at Gauss-Legendre nodes.
    fn of(map: &IlluminationMap, nodes: usize) -> Areas {
        let offsets: &[f64] = match nodes {
            1 => &[0.5],
            _ => &[0.211_324_865_405_187_1, 0.788_675_134_594_812_9],
        };
        let (size, projection) = (map.size(), map.projection());
        let of_texel = |at: usize| {
            let (i, j) = (at % size.0, at / size.0);
            let places = offsets
                .iter()
                .flat_map(|y| offsets.iter().map(move |x| (x, y)));
            let parts: Vec<_> = places
                .filter_map(|(x, y)| {
                    let (x, y) = (i as f64 + x, j as f64 + y);
                    let direction = projection.direction(size, x, y)?;
                    Some((direction, projection.density(size, x, y)))
                })
                .collect();
            let total: f64 = parts.iter().map(|(_, weight)| weight).sum();
            let omega = projection.solid_angle(size, i, j);
            let pixel = map.image().pixels[at].map(f64::from);
            parts.into_iter().map(move |(direction, weight)| {
                (direction, pixel.map(|v| v * omega * weight / total))
            })
        };
        Areas {
            parts: (0..size.0 * size.1)
                .into_par_iter()
                .flat_map_iter(of_texel)
                .collect(),
        }
    }

    /// Σ I Area f at some texels in radiance normalisation.
    fn double_sum(&self, lobe: &Lobe, places: &[(usize, Direction)]) -> Vec<[f64; 3]> {
        let exponent = match lobe {
            Lobe::Phong(n) => *n as i32,
            _ => 1,
        };
        let scale = match lobe {
            Lobe::Phong(n) => (n + 1.0) / TAU,
            _ => FRAC_1_PI,
        };
        let of_texel = |(_, [nx, ny, nz]): &(usize, Direction)| {
            let mut sum = [0.0; 3];
            for ([x, y, z], flux) in &self.parts {
                let cosine = nx * x + ny * y + nz * z;
                if cosine > 0.0 {
                    let value = cosine.powi(exponent);
                    sum = std::array::from_fn(|c| sum[c] + value * flux[c]);
                }
            }
            sum.map(|v| v * scale)
        };
        places.par_iter().map(of_texel).collect()
    }
}

/// A sky above a ground with some grain, and a sun of radiance 10,000, half a degree wide.
fn environment(
    projection: Projection,
    size: (usize, usize),
) -> Result<IlluminationMap, environment::Error> {
    sunlit(projection, size, 1e4)
}

/// The same with a sun of another radiance.
pub(crate) fn sunlit(
    projection: Projection,
    size: (usize, usize),
    radiance: f64,
) -> Result<IlluminationMap, environment::Error> {
    let sun: Direction = [0.48, 0.64, 0.6];
    let pixel = |at: usize| {
        let (x, y) = ((at % size.0) as f64 + 0.5, (at / size.0) as f64 + 0.5);
        let Some(d) = projection.direction(size, x, y) else {
            return [0.0; 3];
        };
        let grain = (at as u32).wrapping_mul(2_654_435_769) >> 16;
        let grain = 0.75 + 0.5 * f64::from(grain) / 65536.0;
        let base = match d[1] > 0.0 {
            true => [0.4 + 0.3 * (1.0 - d[1]), 0.6, 1.0],
            false => [0.3, 0.25, 0.2],
        };
        let cosine: f64 = (0..3).map(|c| d[c] * sun[c]).sum();
        let extra = if cosine > 0.25f64.to_radians().cos() {
            radiance
        } else {
            0.0
        };
        base.map(|v| (v * grain + extra) as f32)
    };
    let pixels = (0..size.0 * size.1).into_par_iter().map(pixel).collect();
    IlluminationMap::new(
        Image {
            width: size.0,
            height: size.1,
            pixels,
        },
        projection,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_says_that_the_double_sum_is_scaled_and_from_how_many_texels() {
        let row = Row {
            case: "polar".into(),
            kernel: "S n = 10 512x256".into(),
            seconds: 0.00876,
            double_sum_seconds: 484.697,
            sampled: 32,
            ratio: 55_353.6,
            from_double_sum: 3.3e-6,
            from_fine_sum: 2.4e-8,
        };
        let text = markdown(&[row]);
        assert!(
            text.contains("plain double sum, s, scaled | timed |"),
            "{text}"
        );
        let cells = "| 0.0088 | 480 | 32 | 55000 | 3.3e-6 | 2.4e-8 |";
        assert!(text.contains(cells), "{text}");
    }
}
