//! A photograph of a mirrored ball, and where it shows a direction.

use super::optics::Optics;
use environment::{Direction, Error, Image};

/// The outline of a ball, in pixels from the top left corner of the photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Middle, to the right.
    pub x: f64,
    /// Middle, down.
    pub y: f64,
    /// Radius, above 0.
    pub radius: f64,
}

/// One photograph of a ball.
#[derive(Debug, Clone, Copy)]
pub struct Photo<'a> {
    /// The photograph, linear.
    pub image: &'a Image,
    /// The outline of the ball in it.
    pub circle: Circle,
    /// Direction from the ball to the camera, not along ±y; +y is upward in the photograph.
    pub from: Direction,
    /// The camera's distance.
    pub optics: Optics,
}

impl Photo<'_> {
    /// Pixels a radian in the middle of the ball.
    pub(super) fn density(&self) -> f64 {
        self.circle.radius * self.optics.slope(0.0)
    }

    /// Where it shows a direction, given its [`frame`], and how well: the resolution along the radius there, 1 in the
    /// middle of the ball. `None` in the blind cone.
    pub(super) fn place(
        &self,
        frame: &[Direction; 3],
        direction: Direction,
    ) -> Option<((f64, f64), f64)> {
        let dot = |a: &Direction| (0..3).map(|c| a[c] * direction[c]).sum::<f64>();
        let [x, y, z] = [dot(&frame[0]), dot(&frame[1]), dot(&frame[2])];
        let across = x.hypot(y);
        let alpha = self.optics.point(across.atan2(z))?;
        // The outermost pixels are mixed with what stands behind the ball; the ring inside them takes their place.
        let inner = (self.circle.radius - std::f64::consts::SQRT_2).max(0.0);
        let radius = (self.circle.radius * self.optics.radius(alpha)).min(inner);
        let (cos, sin) = if across > 0.0 {
            (x / across, y / across)
        } else {
            (1.0, 0.0)
        };
        let place = (self.circle.x + radius * cos, self.circle.y - radius * sin);
        let resolution = self.optics.slope(alpha) / self.optics.slope(0.0);
        Some((place, resolution))
    }

    /// The value at a place, between the centres of four pixels.
    pub(super) fn at(&self, place: (f64, f64)) -> [f64; 3] {
        let (x, y) = place;
        let image = self.image;
        let x = (x - 0.5).clamp(0.0, image.width as f64 - 1.0);
        let y = (y - 0.5).clamp(0.0, image.height as f64 - 1.0);
        let (i, j) = (x as usize, y as usize);
        let (fx, fy) = (x - i as f64, y - j as f64);
        let (right, low) = ((i + 1).min(image.width - 1), (j + 1).min(image.height - 1));
        let [a, b, c, d] = [
            image.at(i, j),
            image.at(right, j),
            image.at(i, low),
            image.at(right, low),
        ];
        std::array::from_fn(|k| {
            let top = f64::from(a[k]) * (1.0 - fx) + f64::from(b[k]) * fx;
            let bottom = f64::from(c[k]) * (1.0 - fx) + f64::from(d[k]) * fx;
            top * (1.0 - fy) + bottom * fy
        })
    }

    /// # Errors
    /// [`Error::Shape`] for a circle that leaves the picture, a camera inside the ball or along ±y; `index` from 1 is
    /// named in it.
    pub(super) fn check(&self, index: usize) -> Result<(), Error> {
        let shape = |text: String| Err(Error::Shape(text));
        let c = self.circle;
        let (w, h) = (self.image.width as f64, self.image.height as f64);
        // The outline may be off by a pixel.
        let inside =
            |middle: f64, side: f64| middle - c.radius >= -1.0 && middle + c.radius <= side + 1.0;
        let inside = c.radius > 0.0 && inside(c.x, w) && inside(c.y, h);
        if !inside {
            return shape(format!(
                "the circle {},{},{} of photograph {index} leaves its {w} x {h} pixels; correct --circle",
                c.x, c.y, c.radius
            ));
        }
        if let Optics::Near(d) = self.optics
            && !(d > 1.0 && d.is_finite())
        {
            return shape(format!(
                "the camera of photograph {index} is {d} ball radii from the middle of the ball; it stands outside, \
                 give a --distance above 1"
            ));
        }
        let [x, y, z] = self.from;
        if !(y.is_finite() && x.hypot(z).is_finite() && x.hypot(z) > 1e-9 * y.abs()) {
            return shape(format!(
                "the camera of photograph {index} is along {x},{y},{z}; \
                 give a direction that is not straight up or down"
            ));
        }
        Ok(())
    }
}

/// Right, up and toward a camera in the direction `from`.
pub(super) fn frame(from: Direction) -> [Direction; 3] {
    let [x, y, z] = from;
    let length = (x * x + y * y + z * z).sqrt();
    let toward = from.map(|v| v / length);
    let flat = x.hypot(z);
    let right = [z / flat, 0.0, -x / flat];
    let up = [
        toward[1] * right[2] - toward[2] * right[1],
        toward[2] * right[0] - toward[0] * right[2],
        toward[0] * right[1] - toward[1] * right[0],
    ];
    [right, up, toward]
}
