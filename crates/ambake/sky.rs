//! The light that arrives where nothing blocks it.

use crate::error::Error;
use environment::{IlluminationMap, Image, Projection, SkyMap, Up};
use serde::{Serialize, Serializer};
use serde_json::{Value, json};
#[cfg(feature = "sky")]
use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;

/// The largest radiance of a sky, a lamp or a light that is baked. Squares of what it becomes after bounces are still
/// 32-bit numbers.
pub(crate) const MAX_RADIANCE: f32 = 1e12;

/// The sky of a bake: uniform, or an illumination map from a file, from pixels or from a function.
#[derive(Debug, Clone)]
pub struct Sky {
    pub(crate) light: environment::Sky,
    /// What outputs say of it: everything that decides its values.
    described: Value,
    /// The picture it was read from.
    pub(crate) file: Option<PathBuf>,
}

impl Sky {
    /// The same radiance from every direction, linear RGB; each channel is finite and at least 0.
    pub fn uniform(radiance: [f32; 3]) -> Self {
        Self {
            light: environment::Sky::Uniform(radiance),
            described: json!(radiance),
            file: None,
        }
    }

    /// The illumination map in an .hdr or .exr file, polar unless its header says otherwise.
    ///
    /// # Errors
    /// The file is absent or damaged, or holds a value that is no radiance.
    #[cfg(feature = "sky")]
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let sky = environment::read_sky(path)?;
        let (width, height) = sky.map.size();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self {
            described: json!({
                "file": name,
                "hash": sky.hash,
                "size": [width, height],
                "mean": sky.map.mean(),
            }),
            light: environment::Sky::Map(Arc::new(sky.map)),
            file: Some(path.to_owned()),
        })
    }

    /// The illumination map of these pixels, linear RGB, row by row from the top, in the polar projection
    /// ([`Projection::Polar`](environment::Projection::Polar)): twice as wide as high, row 0 looks up (+y), the middle
    /// column toward +z, and +x lies to its right.
    ///
    /// ```
    /// // Bright above the horizon, dark below it.
    /// let mut pixels = vec![[1.0; 3]; 64 * 16];
    /// pixels.resize(64 * 32, [0.0; 3]);
    /// let sky = ambake::Sky::from_pixels(64, 32, pixels)?;
    /// assert!((sky.mean()[0] - 0.5).abs() < 1e-12);
    /// # Ok::<(), ambake::Error>(())
    /// ```
    ///
    /// # Errors
    /// There are not `width * height` pixels, `width` is not `2 * height` or above 65,536, or a value is negative or
    /// not finite.
    pub fn from_pixels(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Result<Self, Error> {
        if width.checked_mul(height) != Some(pixels.len()) {
            let there = pixels.len();
            let problem = format!("a sky of {width} x {height} pixels was given {there} of them");
            return Err(environment::Error::Shape(problem).into());
        }
        let mut hasher = blake3::Hasher::new();
        for pixel in &pixels {
            for value in pixel {
                hasher.update(&value.to_le_bytes());
            }
        }
        let image = Image {
            width,
            height,
            pixels,
        };
        let map = SkyMap::new(&IlluminationMap::new(image, Projection::Polar)?)?;
        Ok(Self {
            described: json!({
                "pixels": hasher.finalize().to_hex().as_str(),
                "size": [width, height],
                "mean": map.mean(),
            }),
            light: environment::Sky::Map(Arc::new(map)),
            file: None,
        })
    }

    /// The illumination map of `2 * height` by `height` pixels that a function paints: it is given the direction of the
    /// middle of each pixel, of unit length in the axes of the scene, and returns linear RGB.
    ///
    /// ```
    /// let overcast = ambake::Sky::from_fn(64, |[_, y, _]| [(1.0 + 2.0 * y.max(0.0)) as f32 / 3.0; 3])?;
    /// # Ok::<(), ambake::Error>(())
    /// ```
    ///
    /// # Errors
    /// `height` is 0 or above 32,768, or a value is negative or not finite.
    pub fn from_fn(
        height: usize,
        mut radiance: impl FnMut([f64; 3]) -> [f32; 3],
    ) -> Result<Self, Error> {
        if height > 1 << 15 {
            let problem = format!("a sky of {height} rows; at most 32768 are drawn from");
            return Err(environment::Error::Shape(problem).into());
        }
        let size = (2 * height, height);
        let places = (0..height).flat_map(|j| (0..2 * height).map(move |i| (i, j)));
        let pixels = places.filter_map(|(i, j)| {
            let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
            Projection::Polar.direction(size, x, y).map(&mut radiance)
        });
        Self::from_pixels(size.0, size.1, pixels.collect())
    }

    /// The same sky over a scene in which that axis points upward.
    pub(crate) fn with_up(mut self, up: Up) -> Self {
        if let environment::Sky::Map(map) = &mut self.light
            && map.up() != up
        {
            let turned = SkyMap::clone(map).with_up(up);
            *map = Arc::new(turned);
        }
        self
    }

    /// The light itself, for what takes it elsewhere.
    pub fn light(&self) -> &environment::Sky {
        &self.light
    }

    /// Mean radiance over the sphere, linear RGB.
    pub fn mean(&self) -> [f64; 3] {
        self.light.mean()
    }

    /// The largest radiance, channel by channel.
    pub(crate) fn largest(&self) -> [f32; 3] {
        match &self.light {
            environment::Sky::Uniform(radiance) => *radiance,
            environment::Sky::Map(map) => {
                let (width, height) = map.size();
                let excess = (0..(width * height) as u32).map(|texel| map.excess(texel));
                let most = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|c| a[c].max(b[c]));
                let (floor, excess) = (map.floor(), excess.fold([0.0; 3], most));
                [0, 1, 2].map(|c| (floor[c] + map.scale() * f64::from(excess[c])) as f32)
            }
        }
    }

    /// True where the sky is an illumination map.
    pub fn is_map(&self) -> bool {
        matches!(self.light, environment::Sky::Map(_))
    }
}

impl From<[f32; 3]> for Sky {
    fn from(radiance: [f32; 3]) -> Self {
        Self::uniform(radiance)
    }
}

impl Default for Sky {
    fn default() -> Self {
        Self::uniform([1.0; 3])
    }
}

impl Serialize for Sky {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.described.serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bake, Layer, Mesh, Scene};

    /// The radiance, linear in the direction, of which a floor sees 1 + 2/3 · 0.5 upward: ∫ y cos dω = 2π/3.
    fn brighter_above([_, y, _]: [f64; 3]) -> [f32; 3] {
        [1.0 + 0.5 * y as f32, 1.0, 0.0]
    }

    #[test]
    fn a_floor_receives_what_a_painted_sky_sends_it() {
        let mut floor = Mesh::default();
        floor.positions = vec![
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [1.0, 0.0, 0.0],
        ];
        floor.triangles = vec![[0, 1, 2], [0, 2, 3]];
        let scene = Scene::from_meshes(vec![floor], vec![]).unwrap();
        let sky = Sky::from_fn(64, brighter_above).unwrap();
        assert!(sky.is_map());
        let bake = Bake::new(&scene).size(16).rays(1024).sky(sky.clone());
        let baked = bake.layers([Layer::Irradiance]).run(&()).unwrap();
        let page = baked.page(0);
        let inside = |texel: &usize| page.layer(Layer::Coverage)[*texel] == 1.0;
        let texels: Vec<usize> = (0..256).filter(inside).collect();
        assert!(texels.len() > 50, "{}", texels.len());
        for (channel, exact) in [4.0 / 3.0, 1.0, 0.0].into_iter().enumerate() {
            let light = page.channel(Layer::Irradiance, channel);
            let sum: f64 = texels.iter().map(|&texel| f64::from(light[texel])).sum();
            // Rows of 2.8 degrees tell y to 1e-4 on average; 1024 rays in many texels leave less.
            let mean = sum / texels.len() as f64;
            assert!((mean - exact).abs() < 2e-3, "{channel}: {mean} for {exact}");
        }
    }

    #[test]
    fn a_floor_whose_z_points_upward_receives_what_stands_above_it() {
        let mut floor = Mesh::default();
        floor.positions = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ];
        floor.triangles = vec![[0, 1, 2], [0, 2, 3]];
        let scene = Scene::from_meshes(vec![floor], vec![]).unwrap();
        let sky = Sky::from_fn(64, brighter_above).unwrap();
        let red = |up: Up| {
            let bake = Bake::new(&scene).size(16).rays(1024).sky(sky.clone());
            let baked = bake.up(up).layers([Layer::Irradiance]).run(&()).unwrap();
            let page = baked.page(0);
            let coverage = page.layer(Layer::Coverage);
            let inside = |&texel: &usize| coverage[texel] == 1.0;
            let light = page.channel(Layer::Irradiance, 0);
            let all: Vec<f64> = (0..256).filter(inside).map(|i| light[i].into()).collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        // From the side as much comes from the brighter half as from the darker one.
        for (up, exact) in [(Up::Z, 4.0 / 3.0), (Up::Y, 1.0)] {
            assert!((red(up) - exact).abs() < 2e-3, "{up:?}: {}", red(up));
        }
    }

    #[test]
    fn pixels_are_told_by_their_content_and_refused_where_they_are_no_sky() {
        let told = |sky: Sky| serde_json::to_value(&sky).unwrap();
        let painted = Sky::from_fn(2, |[x, _, z]| [(x > 0.0).into(), (z > 0.0).into(), 0.5]);
        // Columns look toward -x -z, -x +z, +x +z and +x -z.
        let row = [
            [0.0, 0.0, 0.5],
            [0.0, 1.0, 0.5],
            [1.0, 1.0, 0.5],
            [1.0, 0.0, 0.5],
        ];
        let pixels = Sky::from_pixels(4, 2, [row, row].concat()).unwrap();
        let value = told(painted.unwrap());
        assert_eq!(value, told(pixels));
        assert_eq!(value["size"], json!([4, 2]));
        assert_ne!(value, told(Sky::from_fn(2, |_| [0.5; 3]).unwrap()));
        let line = |sky: Result<Sky, Error>| sky.unwrap_err().to_string();
        let short = line(Sky::from_pixels(4, 2, vec![[1.0; 3]; 7]));
        assert_eq!(short, "a sky of 4 x 2 pixels was given 7 of them");
        let square = line(Sky::from_pixels(2, 2, vec![[1.0; 3]; 4]));
        assert!(square.contains("twice as wide as high"), "{square}");
        let negative = line(Sky::from_fn(2, |_| [1.0, -1.0, 1.0]));
        assert!(
            negative.contains("the sky: green of pixel (0, 0) is -1"),
            "{negative}"
        );
        assert!(Sky::from_fn(0, |_| [1.0; 3]).is_err());
    }
}
