//! Pictures of encoded normals, which are lit by tables later: section 2.4 of the 1984 text.
//!
//! A pixel holds the two numbers of its normal's code and the number of its material, from 1; 0 is no surface. The
//! camera and the materials stand in the file's header, so that the scene is no longer needed.

use crate::Error;
use crate::encoded::NormalCode;
use crate::gbuffer::{GBuffer, Pixel, Turn, View};
use crate::surfel::Surfel;
use environment::{Image, Labels};
use glam::DVec3;
use layers::Progress;
use rays::{Overrides, PhongMaterial};
use render::Camera;
use serde_json::{Value, json};
use std::path::Path;

/// The label that holds the camera, the code and the materials.
const LABEL: &str = "ambakeEncoded";

/// Most materials of a picture: those of a header that can still be read.
const MATERIALS: usize = 1024;

/// What a camera sees, as codes.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoded {
    camera: Camera,
    code: NormalCode,
    pixels: Vec<[f32; 3]>,
    materials: Vec<PhongMaterial>,
}

impl Encoded {
    /// What `hit` finds for a ray through the middle of each pixel, as in [`GBuffer::take`].
    ///
    /// # Errors
    /// [`render::Error::Cancelled`]; [`Error::Tables`] for more than 1,024 materials, as where pictures colour them.
    pub fn take(
        camera: &Camera,
        code: NormalCode,
        progress: &dyn Progress,
        hit: impl Fn(DVec3, DVec3) -> Option<Surfel> + Sync,
    ) -> Result<Encoded, Error> {
        let view = View {
            camera,
            turn: Turn {
                centre: DVec3::ZERO,
                axis: DVec3::Y,
                angle: 0.0,
            },
            samples: 1,
            corners: false,
        };
        let buffer = GBuffer::take(&view, progress, hit)?;
        if buffer.palette.len() > MATERIALS {
            return Err(Error::Tables(format!(
                "{} materials are seen, and {MATERIALS} fit beside the codes; --albedo, --specular and --exponent \
                 give one for all",
                buffer.palette.len()
            )));
        }
        let [width, height] = camera.size.map(|n| n as usize);
        let mut pixels = vec![[0.0; 3]; width * height];
        for (k, place) in buffer.places().enumerate() {
            let normal = DVec3::from([0, 1, 2].map(|c: usize| f64::from(buffer.normal[c][k])));
            let [x, y] = code.cells(code.encode(normal, axes(camera)));
            pixels[place] = [x as f32, y as f32, buffer.material[k] as f32 + 1.0];
        }
        let rgb = |[r, g, b, _]: [f32; 4]| DVec3::new(r.into(), g.into(), b.into());
        let material = |(&[albedo, specular], &exponent): (&[[f32; 4]; 2], &f64)| PhongMaterial {
            albedo: rgb(albedo),
            specular: rgb(specular),
            exponent,
        };
        Ok(Encoded {
            camera: *camera,
            code,
            pixels,
            materials: buffer
                .palette
                .iter()
                .zip(&buffer.exponents)
                .map(material)
                .collect(),
        })
    }

    /// The picture and the label of its file.
    pub fn file(&self) -> (Image, Labels) {
        let Camera {
            eye,
            right,
            up,
            forward,
            slope,
            size,
        } = self.camera;
        let materials = self.materials.iter().map(|material| {
            let rgb = [material.albedo, material.specular].map(|rgb| rgb.to_array());
            json!([rgb[0], rgb[1], material.exponent])
        });
        let camera = [eye, right, up, forward].map(|v| v.to_array());
        let about = json!({
            "code": self.code.name(),
            "camera": camera,
            "slope": slope,
            "materials": materials.collect::<Vec<_>>(),
        });
        let [width, height] = size.map(|n| n as usize);
        let image = Image {
            width,
            height,
            pixels: self.pixels.clone(),
        };
        (image, Labels::from([(LABEL.into(), about.to_string())]))
    }

    /// The picture in a file.
    ///
    /// # Errors
    /// The file cannot be read, or is no such picture.
    pub fn read(path: &Path) -> Result<Encoded, Error> {
        let file = environment::read(path)?;
        let fail = |problem: &str| {
            let path = path.display();
            Error::Tables(format!(
                "{path}: {problem}; write it with `render --encode`"
            ))
        };
        let about = file.labels.get(LABEL);
        let about = about.ok_or_else(|| fail("it holds no encoded normals"))?;
        let about: Value = serde_json::from_str(about).unwrap_or_default();
        let parsed = || -> Option<Encoded> {
            let code = NormalCode::from_name(about["code"].as_str()?)?;
            let [eye, right, up, forward]: [[f64; 3]; 4] =
                serde_json::from_value(about["camera"].clone()).ok()?;
            let materials: Vec<([f64; 3], [f64; 3], f64)> =
                serde_json::from_value(about["materials"].clone()).ok()?;
            let material =
                |(albedo, specular, exponent): ([f64; 3], [f64; 3], f64)| PhongMaterial {
                    albedo: albedo.into(),
                    specular: specular.into(),
                    exponent,
                };
            Some(Encoded {
                camera: Camera {
                    eye: eye.into(),
                    right: right.into(),
                    up: up.into(),
                    forward: forward.into(),
                    slope: about["slope"].as_f64()?,
                    size: [file.image.width as u32, file.image.height as u32],
                },
                code,
                pixels: file.image.pixels.clone(),
                materials: materials.into_iter().map(material).collect(),
            })
        };
        let encoded = parsed().ok_or_else(|| fail("its header is damaged"))?;
        let sides = encoded.code.side() as usize;
        let is_sound = |[x, y, material]: &[f32; 3]| {
            let whole = |v: f32, end: usize| v.fract() == 0.0 && (v as usize) < end;
            whole(*x, sides) && whole(*y, sides) && whole(*material, encoded.materials.len() + 1)
        };
        match encoded.pixels.iter().all(is_sound) {
            true => Ok(encoded),
            false => Err(fail("a pixel holds no code")),
        }
    }

    /// What shading takes, with other values in place of the materials' own.
    pub fn buffer(&self, overrides: &Overrides) -> GBuffer {
        let [width, height] = self.camera.size.map(|n| n as usize);
        let materials = self
            .materials
            .iter()
            .map(|material| overrides.applied(*material));
        let materials: Vec<PhongMaterial> = materials.collect();
        let pixel = |x: usize, y: usize| -> Option<Pixel> {
            let [u, v, number] = self.pixels[y * width + x];
            let material = materials.get((number as usize).checked_sub(1)?)?;
            let code = v as u32 * self.code.side() + u as u32;
            let rgb = [material.albedo, material.specular];
            Some(Pixel {
                column: x as u16,
                coverage: 1.0,
                normal: self.code.decode(code, axes(&self.camera)),
                view: -self.camera.direction(x as f64 + 0.5, y as f64 + 0.5),
                material: rgb.map(|rgb| rgb.as_vec3().extend(0.0).to_array()),
                exponent: material.exponent,
                object: 0,
                shader: 0,
                mirrored: Vec::new(),
            })
        };
        let row = |y: usize| (0..width).filter_map(|x| pixel(x, y)).collect();
        let mut buffer = GBuffer::empty(self.camera);
        buffer.fill((0..height).map(row).collect());
        buffer
    }

    /// The camera that it was taken by.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }
}

/// Right, up and toward the viewer.
fn axes(camera: &Camera) -> [DVec3; 3] {
    [camera.right, camera.up, -camera.forward]
}
