//! The picture in which a ball is looked for.

use environment::Image;

/// Logarithmic luminance, so that a lamp is no stronger than an outline.
pub(super) struct Gray {
    pub width: usize,
    pub height: usize,
    values: Vec<f64>,
}

impl Gray {
    pub fn of(image: &Image) -> Gray {
        let luminance = |p: &[f32; 3]| {
            0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2])
        };
        let values: Vec<f64> = image.pixels.iter().map(luminance).collect();
        let mut sorted = values.clone();
        let (_, middle, _) = sorted.select_nth_unstable_by(values.len() / 2, f64::total_cmp);
        let unit = if *middle > 0.0 { *middle } else { 1.0 };
        Gray {
            width: image.width,
            height: image.height,
            values: values
                .into_iter()
                .map(|v| (1.0 + 4.0 * v / unit).ln())
                .collect(),
        }
    }

    pub fn longest(&self) -> usize {
        self.width.max(self.height)
    }

    pub fn at(&self, x: usize, y: usize) -> f64 {
        self.values[y.min(self.height - 1) * self.width + x.min(self.width - 1)]
    }

    pub fn half(&self) -> Gray {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mean = |i: usize| {
            let (x, y) = (2 * (i % width), 2 * (i / width));
            let sum = self.at(x, y) + self.at(x + 1, y) + self.at(x, y + 1) + self.at(x + 1, y + 1);
            0.25 * sum
        };
        Gray {
            width,
            height,
            values: (0..width * height).map(mean).collect(),
        }
    }

    /// Between the centres of four pixels; the edge goes on outside.
    pub fn bilinear(&self, x: f64, y: f64) -> f64 {
        let (x, y) = ((x - 0.5).max(0.0), (y - 0.5).max(0.0));
        let (i, j) = (x as usize, y as usize);
        let (fx, fy) = (x - i as f64, y - j as f64);
        let top = self.at(i, j) * (1.0 - fx) + self.at(i + 1, j) * fx;
        let bottom = self.at(i, j + 1) * (1.0 - fx) + self.at(i + 1, j + 1) * fx;
        top * (1.0 - fy) + bottom * fy
    }
}
