//! From one layout to another with every texel's energy kept.
//!
//! Each pair of texels that lie over each other gets a weight in steradians: small cells of the finer side, shared out
//! bilinearly among the texels of the coarser one. The weights are then fitted to the exact solid angles of both sides
//! in turn (iterative proportional fitting, W. Deming, F. Stephan 1940), which makes a constant map come out constant;
//! the last fit is to the input, so that its energy is kept.

use crate::map::{taps, texel};
use crate::{Error, IlluminationMap, Image, Orientation, Projection};

/// A layout of the sphere as one tool has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MapLayout {
    /// How directions are laid out.
    pub projection: Projection,
    /// Whose axes.
    pub orientation: Orientation,
    /// Width and height in texels.
    pub size: (usize, usize),
}

/// The map in another projection and size. Its integral over the sphere is kept; texels that show nothing are 0.
///
/// ```
/// use ambake_environment::{IlluminationMap, Image, Projection, convert};
/// let mut image = Image::filled(64, 32, [1.0; 3]);
/// image.pixels[64 * 10 + 7] = [5000.0; 3];
/// let polar = IlluminationMap::new(image, Projection::Polar)?;
/// let cube = convert(&polar, Projection::Cube, Projection::Cube.size(64))?;
/// assert_eq!(cube.size(), (16, 96));
/// assert!((cube.integral()[0] / polar.integral()[0] - 1.0).abs() < 1e-7);
/// # Ok::<(), ambake_environment::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] for a size that does not fit the projection.
pub fn convert(
    map: &IlluminationMap,
    projection: Projection,
    size: (usize, usize),
) -> Result<IlluminationMap, Error> {
    let layout = |projection, size| MapLayout {
        projection,
        orientation: Orientation::Ambake,
        size,
    };
    let to = layout(projection, size);
    let image = convert_image(map.image(), layout(map.projection(), map.size()), to)?;
    IlluminationMap::new(image, projection)
}

/// A tool's picture as another tool's: see [`convert`].
///
/// ```
/// use ambake_environment::{Image, MapLayout, Orientation, Projection, convert_image};
/// // glTF viewers have +x in the middle of a polar picture, ambake has +z there.
/// let from = MapLayout { projection: Projection::Polar, orientation: Orientation::Gltf, size: (8, 4) };
/// let to = MapLayout { orientation: Orientation::Ambake, ..from };
/// let picture = Image::filled(8, 4, [1.0, 2.0, 3.0]);
/// assert_eq!(convert_image(&picture, from, to)?.at(3, 1), [1.0, 2.0, 3.0]);
/// # Ok::<(), ambake_environment::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] for a size that does not fit its projection, or a tool that has no such pictures.
pub fn convert_image(image: &Image, from: MapLayout, to: MapLayout) -> Result<Image, Error> {
    for layout in [from, to] {
        layout.projection.check(layout.size.0, layout.size.1)?;
        layout.orientation.check(layout.projection)?;
    }
    assert_eq!(from.size, (image.width, image.height));
    if from == to {
        return Ok(image.clone());
    }
    let mut input = image.clone();
    from.orientation.exchange_faces(from.projection, &mut input);
    let overlaps = Overlaps::of(from, to);
    let mut output = overlaps.apply(&input, to.size);
    to.orientation.exchange_faces(to.projection, &mut output);
    Ok(output)
}

/// Which texels overlap by how much.
struct Overlaps {
    /// Input texel, output texel, weight in steradians before fitting.
    pairs: Vec<(u32, u32, f32)>,
    inputs: Vec<f64>,
    outputs: Vec<f64>,
}

/// Rounds of fitting. Weights start within some per cent; a round leaves a tenth or less.
const ROUNDS: usize = 12;

impl Overlaps {
    fn of(from: MapLayout, to: MapLayout) -> Overlaps {
        let inputs = from.projection.solid_angles(from.size);
        let outputs = to.projection.solid_angles(to.size);
        let mut pairs = Vec::new();
        let mut touched = [vec![false; inputs.len()], vec![false; outputs.len()]];
        let mut add = |touched: &mut [Vec<bool>; 2], i: usize, o: usize, weight: f64| {
            if weight > 0.0 && inputs[i] > 0.0 && outputs[o] > 0.0 {
                pairs.push((i as u32, o as u32, weight as f32));
                (touched[0][i], touched[1][o]) = (true, true);
            }
        };
        let output_of = |direction| {
            let world = from.orientation.look_up(from.projection, direction);
            to.orientation.look_up(to.projection, world)
        };
        let input_of = |direction| {
            let world = to.orientation.look_up(to.projection, direction);
            from.orientation.look_up(from.projection, world)
        };
        // Cells of input texels that are finer than the output texel they fall into.
        each_cell(from, |i, direction, share| {
            let look = output_of(direction);
            if inputs[i] < outputs[texel(to.projection, to.size, look)] {
                for (o, weight) in taps(to.projection, to.size, look) {
                    add(&mut touched, i, o, inputs[i] * share * weight);
                }
            }
        });
        // Cells of output texels that are finer than the input texel they fall into, or that nothing fell into.
        let reached = touched[1].clone();
        each_cell(to, |o, direction, share| {
            let look = input_of(direction);
            if !reached[o] || outputs[o] <= inputs[texel(from.projection, from.size, look)] {
                for (i, weight) in taps(from.projection, from.size, look) {
                    add(&mut touched, i, o, outputs[o] * share * weight);
                }
            }
        });
        // Input texels that neither reached, slivers at a disc's rim: no energy is lost.
        let reached = touched[0].clone();
        each_cell(from, |i, direction, share| {
            if !reached[i] {
                let o = texel(to.projection, to.size, output_of(direction));
                add(&mut touched, i, o, inputs[i] * share);
            }
        });
        Overlaps {
            pairs,
            inputs,
            outputs,
        }
    }

    fn apply(&self, image: &Image, (width, height): (usize, usize)) -> Image {
        // Weights are input factor · overlap · output factor.
        let mut of_input = vec![1.0; self.inputs.len()];
        let mut of_output = vec![1.0; self.outputs.len()];
        let mut sums = Vec::new();
        for _ in 0..ROUNDS {
            sums.clear();
            sums.resize(self.outputs.len(), 0.0);
            for (i, o, w) in &self.pairs {
                sums[*o as usize] += f64::from(*w) * of_input[*i as usize];
            }
            fit(&mut of_output, &self.outputs, &sums);
            sums.clear();
            sums.resize(self.inputs.len(), 0.0);
            for (i, o, w) in &self.pairs {
                sums[*i as usize] += f64::from(*w) * of_output[*o as usize];
            }
            fit(&mut of_input, &self.inputs, &sums);
        }
        let mut energy = vec![[0.0; 4]; self.outputs.len()];
        for (i, o, w) in &self.pairs {
            let weight = f64::from(*w) * of_input[*i as usize] * of_output[*o as usize];
            let [r, g, b] = image.pixels[*i as usize];
            let parts = [r, g, b, 1.0].map(|v| weight * f64::from(v));
            let sum = &mut energy[*o as usize];
            *sum = std::array::from_fn(|c| sum[c] + parts[c]);
        }
        // A texel's own weights make its mean; what the fit has left over goes to all alike, so the whole is kept.
        let mean = |[r, g, b, w]: [f64; 4]| [r, g, b].map(|v| if w > 0.0 { v / w } else { 0.0 });
        let total = |values: &mut dyn Iterator<Item = ([f64; 3], f64)>| {
            values.fold([0.0; 3], |sum: [f64; 3], (v, omega)| {
                std::array::from_fn(|c| sum[c] + v[c] * omega)
            })
        };
        let inputs = image.pixels.iter().map(|p| p.map(f64::from));
        let before = total(&mut inputs.zip(self.inputs.iter().copied()));
        let means = energy.iter().map(|sum| mean(*sum));
        let after = total(&mut means.clone().zip(self.outputs.iter().copied()));
        let scale: [f64; 3] = std::array::from_fn(|c| {
            if after[c] > 0.0 {
                before[c] / after[c]
            } else {
                1.0
            }
        });
        let pixels = means.map(|mean| std::array::from_fn(|c| (mean[c] * scale[c]) as f32));
        Image {
            width,
            height,
            pixels: pixels.collect(),
        }
    }
}

/// The factors that bring sums to their targets.
fn fit(factors: &mut [f64], targets: &[f64], sums: &[f64]) {
    for ((factor, target), sum) in factors.iter_mut().zip(targets).zip(sums) {
        *factor = if *sum > 0.0 { target / sum } else { 0.0 };
    }
}

/// Cells of a texel each way.
const CELLS: usize = 3;

/// Calls `visit` with texel, direction and share of the texel's solid angle for a few cells of every texel.
fn each_cell(layout: MapLayout, mut visit: impl FnMut(usize, [f64; 3], f64)) {
    let (size, projection) = (layout.size, layout.projection);
    for texel in 0..size.0 * size.1 {
        let (i, j) = (texel % size.0, texel / size.0);
        if projection.solid_angle(size, i, j) == 0.0 {
            continue;
        }
        let mut cells = [([0.0; 3], 0.0); CELLS * CELLS];
        let mut total = 0.0;
        for (k, cell) in cells.iter_mut().enumerate() {
            let at = |k: usize| (k as f64 + 0.5) / CELLS as f64;
            let (x, y) = (i as f64 + at(k % CELLS), j as f64 + at(k / CELLS));
            if let Some(direction) = projection.direction(size, x, y) {
                *cell = (direction, projection.density(size, x, y));
                total += cell.1;
            }
        }
        if total == 0.0 {
            cells[0] = (
                projection.nearest_direction(size, i as f64 + 0.5, j as f64 + 0.5),
                1.0,
            );
            total = 1.0;
        }
        for (direction, weight) in cells.into_iter().filter(|cell| cell.1 > 0.0) {
            visit(texel, direction, weight / total);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth but for one texel that holds as much as all others.
    fn picture(projection: Projection, texels: usize) -> IlluminationMap {
        let size = projection.size(texels);
        let mut image = Image::filled(size.0, size.1, [0.0; 3]);
        for (at, pixel) in image.pixels.iter_mut().enumerate() {
            let (x, y) = ((at % size.0) as f64 + 0.5, (at / size.0) as f64 + 0.5);
            if let Some([x, y, z]) = projection.direction(size, x, y) {
                *pixel = [1.0 + x as f32, 1.5 + (y * z) as f32, 0.25];
            }
        }
        let sun = texel(projection, size, [0.36, 0.48, 0.8]);
        image.pixels[sun] = [1e5; 3];
        IlluminationMap::new(image, projection).unwrap()
    }

    #[test]
    fn energy_is_kept_and_a_constant_stays_one() {
        for from in Projection::all() {
            let map = picture(from, 64);
            let white = Image::filled(map.size().0, map.size().1, [1.0; 3]);
            let white = IlluminationMap::new(white, from).unwrap();
            for to in Projection::all() {
                for texels in [40, 96] {
                    let size = to.size(texels);
                    let result = convert(&map, to, size).unwrap();
                    let (before, after) = (map.integral(), result.integral());
                    for c in 0..3 {
                        let change = (after[c] / before[c] - 1.0).abs();
                        // Pixels are f32, each rounded by at most 6e-8.
                        assert!(
                            change < 6e-8,
                            "{from:?} to {to:?} {texels}: energy changed by {change:e}"
                        );
                    }
                    let result = convert(&white, to, size).unwrap();
                    for (at, pixel) in result.image().pixels.iter().enumerate() {
                        let shown = to.solid_angle(size, at % size.0, at / size.0) > 0.0;
                        let error = (pixel[0] - f32::from(u8::from(shown))).abs();
                        assert!(
                            error < 1e-6,
                            "{from:?} to {to:?} {texels}: {error:e} at {at}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_sun_stays_where_it_is() {
        // The energy of one bright texel lies within two texels of its direction.
        for to in [Projection::Polar, Projection::Cube, Projection::Octahedral] {
            let direction = [0.36, 0.48, 0.8];
            let size = Projection::Polar.size(256);
            let mut image = Image::filled(size.0, size.1, [0.0; 3]);
            image.pixels[texel(Projection::Polar, size, direction)] = [1.0; 3];
            let map = IlluminationMap::new(image, Projection::Polar).unwrap();
            let result = convert(&map, to, to.size(128)).unwrap();
            for (at, pixel) in result
                .image()
                .pixels
                .iter()
                .enumerate()
                .filter(|(_, p)| p[0] > 0.0)
            {
                let (x, y) = (
                    (at % result.size().0) as f64 + 0.5,
                    (at / result.size().0) as f64 + 0.5,
                );
                let d = to.direction(result.size(), x, y).unwrap();
                let cosine: f64 = (0..3).map(|c| d[c] * direction[c]).sum();
                assert!(cosine > 0.15f64.cos(), "{to:?}: {pixel:?} at {d:?}");
            }
        }
    }
}
