//! What a layout writes: `layout.json`, pictures of its charts, and a file from which bakes take it.

use crate::error::Error;
use crate::layout::{Layout, picture_name};
use atlas::PageRaster;
use rayon::prelude::*;
use report::Output;
use std::path::{Path, PathBuf};

impl Layout {
    /// Writes `layout.json`, a picture of each page's charts, and the file that bakes take the layout from.
    ///
    /// # Errors
    /// The directory cannot be written, or an output would replace an input.
    pub fn write(&self, dir: &Path) -> Result<Vec<PathBuf>, Error> {
        let stem = self.scene.stem();
        let mut output = Output::create(dir)?;
        output.protect(self.scene.inputs.clone());
        let path = Self::path(dir, &self.scene);
        output.check(&format!("{stem}.layout"))?;
        for page in 0..self.atlas.page_count {
            output.stage_bytes(&picture_name(&stem, page), &self.picture(page))?;
        }
        let text = format!("{:#}\n", self.describe());
        output.stage_bytes("layout.json", text.as_bytes())?;
        report::write_layout(&path, &self.key, &self.atlas)?;
        let mut files = vec![path];
        files.extend(output.publish()?);
        Ok(files)
    }

    /// A page as a PNG: each chart in a colour of its own, darker where a texel is covered in part, black where it is
    /// free.
    fn picture(&self, page: u32) -> Vec<u8> {
        let size = self.atlas.page_size as usize;
        let raster = PageRaster::new(&self.scene, &self.atlas, page);
        let charts: Vec<Vec<u32>> = self.atlas.meshes.par_iter().map(atlas::charts).collect();
        let tiles: Vec<Vec<(usize, [f32; 3])>> = (0..raster.tiles().len())
            .into_par_iter()
            .map(|tile| {
                let tile = raster.tile(tile);
                let texel = |footprint: &atlas::Footprint| {
                    let piece = &tile.pieces_of(footprint)[0];
                    let mesh = self.scene.instances[piece.instance as usize].mesh as usize;
                    let chart = charts[mesh][piece.triangle as usize];
                    let at = footprint.y as usize * size + footprint.x as usize;
                    let shade = 0.3 + 0.7 * footprint.coverage;
                    (at, colour(piece.instance, chart).map(|c| c * shade))
                };
                tile.footprints.iter().map(texel).collect()
            })
            .collect();
        let mut pixels = vec![[0.0; 3]; size * size];
        for (at, colour) in tiles.into_iter().flatten() {
            pixels[at] = colour;
        }
        report::picture_png(size, &pixels)
    }
}

/// A colour that differs from one chart to the next: hues by the golden ratio, brightness by the object.
fn colour(instance: u32, chart: u32) -> [f32; 3] {
    let hue = (f64::from(instance) * 0.381_966 + f64::from(chart) * 0.618_034).fract() as f32;
    let value = 0.5 + 0.4 * (instance % 2) as f32;
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|shift: f32| {
        let ramp = ((hue + shift).fract() * 6.0 - 3.0).abs() - 1.0;
        value * (0.25 + 0.75 * ramp.clamp(0.0, 1.0))
    })
}
