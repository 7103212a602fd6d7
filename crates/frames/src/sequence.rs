//! Frames: objects that turn before a camera that stands or moves.

use crate::Error;
use crate::antialias::Lookup;
use crate::encoded::NormalCode;
use crate::gbuffer::{GBuffer, Turn, View};
use crate::path::CameraPath;
use crate::shade::{backdrop, frame};
use crate::shader::Shader;
use crate::surfel::Surfel;
use crate::table::Table;
use environment::Image;
use glam::DVec3;
use layers::Progress;
use render::{Camera, Framing, Part};
use std::time::Instant;

/// Where the camera is in each frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// It stands still.
    Still(Camera),
    /// It moves along a path; upright, field of view and size are those of the framing.
    Path(CameraPath, Framing),
}

/// What is shown, frame by frame.
pub struct Sequence<'a> {
    /// Number of frames.
    pub frames: u32,
    /// Where the camera is.
    pub motion: Motion,
    /// How far the objects turn from frame to frame, counter-clockwise seen from the tip of the axis. In degrees, so
    /// that a whole turn of whole numbers is not rounded.
    pub turn_deg: f64,
    /// The point and the unit axis about which they turn.
    pub about: [DVec3; 2],
    /// Rays of a pixel: a regular grid of `samples` by `samples`, at least 1.
    pub samples: u32,
    /// What normals are rounded to; `None` for their full precision.
    pub normals: Option<NormalCode>,
    /// What shades the objects; each surface names one by its number.
    pub shaders: Vec<Shader<'a>>,
    /// How its tables are read.
    pub lookup: Lookup,
    /// I, seen behind the objects; `None` for black.
    pub environment: Option<&'a Table>,
}

/// One frame of a sequence.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Its number, from 0.
    pub number: u32,
    /// The camera.
    pub camera: Camera,
    /// How far the objects are turned, in radians.
    pub angle: f64,
    /// The picture.
    pub picture: Image,
    /// The share of each of its pixels that shows an object, 0..=1.
    pub alpha: Vec<f32>,
    /// Wall time of shading, without the rays that find the surfaces.
    pub shading_seconds: f64,
}

impl Motion {
    /// The camera of frame `number` of `frames`.
    ///
    /// # Errors
    /// [`Error::Frame`] where the path gives it no direction.
    pub fn camera(&self, number: u32, frames: u32) -> Result<Camera, Error> {
        match self {
            Motion::Still(camera) => Ok(*camera),
            Motion::Path(path, framing) => {
                let camera = framing.camera_at(path.at(number, frames));
                camera.map_err(|source| Error::Frame {
                    frame: number,
                    source,
                })
            }
        }
    }
}

impl Sequence<'_> {
    /// The frames in order, each made when it is asked for. `hit` is that of [`GBuffer::take`]; `progress` hears of the
    /// pixels of all frames.
    ///
    /// A frame is an error where [`Motion::camera`] is one, or [`render::Error::Cancelled`].
    pub fn frames(
        &self,
        progress: &dyn Progress,
        hit: impl Fn(DVec3, DVec3) -> Option<Surfel> + Sync,
    ) -> impl Iterator<Item = Result<Frame, Error>> {
        // The environment stays, so a camera that stays sees the same of it.
        let mut behind: Option<(Camera, Image)> = None;
        (0..self.frames).map(move |number| {
            let camera = self.motion.camera(number, self.frames)?;
            let angle = (self.turn_deg * f64::from(number)).to_radians();
            let [centre, axis] = self.about;
            let view = View {
                camera: &camera,
                turn: Turn {
                    centre,
                    axis,
                    angle,
                },
                samples: self.samples,
                corners: self.lookup.needs_corners(),
            };
            let part = Part {
                whole: progress,
                index: number.into(),
                count: self.frames.into(),
            };
            let mut buffer = GBuffer::take(&view, &part, &hit)?;
            if let Some(code) = self.normals {
                buffer.encode(code);
            }
            let mut picture = match &behind {
                Some((taken, picture)) if *taken == camera => picture.clone(),
                _ => {
                    let picture = backdrop(&camera, self.environment);
                    behind.insert((camera, picture)).1.clone()
                }
            };
            let mut alpha = vec![0.0; picture.pixels.len()];
            for (place, share) in buffer.places().zip(buffer.coverage()) {
                alpha[place] = *share;
            }
            let before = Instant::now();
            frame(&self.shaders, &buffer, self.lookup, &mut picture);
            Ok(Frame {
                number,
                camera,
                angle,
                picture,
                alpha,
                shading_seconds: before.elapsed().as_secs_f64(),
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use environment::{IlluminationMap, Projection};
    use std::sync::Mutex;

    /// A globe at the origin that mirrors all.
    fn globe(eye: DVec3, direction: DVec3) -> Option<Surfel> {
        let b = eye.dot(direction);
        let root = b * b - eye.length_squared() + 1.0;
        (root >= 0.0 && b < 0.0).then(|| Surfel {
            normal: (eye + direction * (-b - root.sqrt())).normalize(),
            albedo: DVec3::ZERO,
            specular: DVec3::ONE,
            ..Surfel::default()
        })
    }

    /// Remembers the last that it heard and cancels from a number on.
    struct Heard(Mutex<(u64, u64)>, u64);

    impl Progress for Heard {
        fn advance(&self, done: u64, total: u64) {
            let mut last = self.0.lock().unwrap();
            *last = (*last).max((done, total));
        }

        fn cancelled(&self) -> bool {
            self.0.lock().unwrap().0 >= self.1
        }
    }

    #[test]
    fn a_path_from_the_still_eye_gives_the_still_picture_and_frames_end_where_they_are_cancelled() {
        let mut sky = Image::filled(16, 8, [0.0; 3]);
        for (at, pixel) in sky.pixels.iter_mut().enumerate() {
            *pixel = [at as f32, (at % 16) as f32, (at / 16) as f32];
        }
        let table = Table::new(&IlluminationMap::new(sky, Projection::Polar).unwrap()).unwrap();
        let framing = Framing {
            eye: None,
            look: None,
            up: DVec3::Y,
            fov: 0.9,
            size: [20, 16],
        };
        let keys = vec![[DVec3::Z * 4.0, DVec3::ZERO], [DVec3::X * 4.0, DVec3::ZERO]];
        let sequence = |motion| Sequence {
            frames: 2,
            motion,
            turn_deg: 0.0,
            about: [DVec3::ZERO, DVec3::Y],
            samples: 2,
            normals: None,
            shaders: vec![Shader::of(None, Some(&table))],
            lookup: Lookup::Bilinear,
            environment: Some(&table),
        };
        let still = sequence(Motion::Still(framing.camera_at(keys[0]).unwrap()));
        let path = CameraPath::new(keys).unwrap();
        let moving = sequence(Motion::Path(path, framing));
        let heard = Heard(Mutex::new((0, 0)), u64::MAX);
        let frames: Vec<Frame> = still.frames(&heard, globe).map(Result::unwrap).collect();
        assert_eq!(*heard.0.lock().unwrap(), (2 * 320, 2 * 320));
        let moved: Vec<Frame> = moving.frames(&(), globe).map(Result::unwrap).collect();
        assert_eq!(frames[0].picture, frames[1].picture, "nothing turns");
        assert_eq!(frames[0].picture, moved[0].picture, "the first key");
        assert_ne!(moved[0].picture, moved[1].picture);
        // Half of the first frame.
        let heard = Heard(Mutex::new((0, 0)), 160);
        let first = still.frames(&heard, globe).next();
        assert!(
            matches!(first, Some(Err(Error::Render(render::Error::Cancelled)))),
            "{first:?}"
        );
    }

    #[test]
    fn a_frame_without_a_direction_is_named() {
        let framing = Framing {
            eye: None,
            look: None,
            up: DVec3::Y,
            fov: 0.9,
            size: [4, 4],
        };
        let path = CameraPath::new(vec![[DVec3::ONE; 2]]).unwrap();
        let error = Motion::Path(path, framing).camera(0, 1).unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with("frame 0: the camera looks"), "{text}");
    }
}
