//! `STEM.lit.png`: the lit scene of a bake, from the view that fits it.

use crate::dome::surrounding;
use crate::job::Job;
use crate::options::{Effort, Options};
use ::bake::{BakedPage, LayerPlanes};
use environment::Image;
use glam::{DVec3, Vec2, Vec3};
use rays::{Overrides, SurfaceHit, Surfaces};
use render::{Camera, Direct, Exposure, Framing, Lamps, Lit, TexelPlace};
use std::time::Instant;

/// Layers that can light a scene, the best one first.
const LAYERS: [&str; 7] = [
    "ggx",
    "phong",
    "lambert",
    "traditional",
    "irradiance",
    "diffuse",
    "visibility",
];

/// A share of the sky's light that comes through cracks alone.
const FAINT: f64 = 1e-4;

/// What is darker in a picture than 8 of 255 is black, and a picture is black where less than a 16th of its surfaces is
/// brighter.
const BLACK: f32 = 0.0024;
const SHOWN: f64 = 1.0 / 16.0;
const HALF: f64 = 0.5;

/// Rays by which surfaces without texels are lit.
const RAYS: u32 = 16;

/// The picture while pages come in.
#[derive(Default)]
pub(crate) struct LitScene {
    /// Found with the first page: from the view that fits the scene, and where that is within it from others there and
    /// outside that may be brighter.
    lit: Vec<(Camera, Lit)>,
    backdrop: DVec3,
    /// How much a picture is brightened at most.
    most_stops: f64,
    seconds: f64,
}

impl LitScene {
    /// Adds the light of a page. A bake without any layer of light has no picture.
    pub fn add(&mut self, job: &Job, page: &BakedPage) {
        let clock = Instant::now();
        let layer = LAYERS
            .iter()
            .find_map(|name| page.planes.iter().find(|p| p.layer.name() == *name));
        if let Some(LayerPlanes { values, .. }) = layer {
            if self.lit.is_empty() {
                self.backdrop = render::backdrop(job.options().sky.mean().into());
                self.most_stops = most_stops(job.options());
                self.lit = job.within(|| look(job)).unwrap_or_default();
            }
            let mut planes = values.chunks_exact(page.texels());
            let red = planes.next().unwrap_or_default();
            let [green, blue] = [0, 1].map(|_| planes.next().unwrap_or(red));
            for (_, lit) in &mut self.lit {
                lit.add(page.page, page.size, [red, green, blue]);
            }
        }
        self.seconds += clock.elapsed().as_secs_f64();
    }

    /// The picture as a PNG file, and its camera; `None` where no layer can light it. Where less than half of the first
    /// is bright it is that from within of which most is, and that from outside, the last one, where all those are
    /// black.
    pub fn picture(&mut self) -> Option<(Vec<u8>, Camera)> {
        let clock = Instant::now();
        let bright = |(picture, alpha): &(Image, Vec<f32>)| {
            let surfaces = picture.pixels.iter().zip(alpha);
            let surfaces = surfaces.filter(|(_, alpha)| **alpha > 0.5);
            let bright = surfaces
                .clone()
                .filter(|(p, _)| Vec3::from(**p).max_element() > BLACK);
            bright.count() as f64 / surfaces.count().max(1) as f64
        };
        let ((mut camera, first), others) =
            self.lit.split_first().map(|(a, b)| ((a.0, &a.1), b))?;
        let mut chosen = self.developed(first);
        let mut share = bright(&chosen);
        for (left, (other_camera, lit)) in (0..others.len()).rev().zip(others) {
            let least = if left == 0 { SHOWN } else { HALF };
            let other = (share < least).then(|| self.developed(lit));
            if let Some(other) = other.filter(|other| bright(other) > share) {
                (share, chosen, camera) = (bright(&other), other, *other_camera);
            }
        }
        let (mut picture, alpha) = chosen;
        let behind = self.backdrop.as_vec3();
        for (pixel, alpha) in picture.pixels.iter_mut().zip(alpha) {
            *pixel = (Vec3::from(*pixel) + (1.0 - alpha) * behind).to_array();
        }
        let png = report::picture_png(picture.width, &picture.pixels);
        self.seconds += clock.elapsed().as_secs_f64();
        Some((png, camera))
    }

    /// What is seen, exposed, before black, and the share of surfaces of each pixel.
    fn developed(&self, lit: &Lit) -> (Image, Vec<f32>) {
        let (picture, alpha) = lit.picture(|radiance| radiance);
        let exposure = match Exposure::of(&picture, &alpha) {
            // What leaks into a closed room is no picture of it.
            bright if bright.stops > self.most_stops => Exposure::of_stops(0.0),
            exposure => exposure,
        };
        lit.picture(|radiance| exposure.tone(radiance))
    }

    /// Seconds that it took so far.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }
}

/// Powers of two by which the picture is brightened at most: of what is darker than [`FAINT`] beside the sky nothing is
/// shown.
fn most_stops(options: &Options) -> f64 {
    match options.adds_light() {
        true => f64::INFINITY,
        false => -(FAINT * DVec3::from(options.sky.mean()).max_element()).log2(),
    }
}

/// What the fitted camera sees, and where it stands within the scene what brighter ones do; `None` where the scene has
/// no extent to look at.
fn look(job: &Job) -> Option<Vec<(Camera, Lit)>> {
    let (world, options) = (job.world(), job.options());
    let (surfaces, lamps) = (Surfaces::new(world), Lamps::of(world));
    let direct = Direct {
        rays: RAYS,
        sky: options.sky.light.clone(),
        max_distance: options.max_distance.unwrap_or(f32::INFINITY),
        seed: options.seed,
        overrides: Overrides {
            albedo: options.albedo,
            specular: options.specular,
            exponent: options.exponent,
        },
        ..Direct::new(&surfaces, job.backend(), &lamps)
    };
    let (size, grid) = size(job);
    let framing = Framing {
        size,
        up: options.up.direction().into(),
        ..Framing::default()
    };
    let around = surrounding(world, job.backend(), framing.up);
    let fitted = framing.fitted(world, job.backend(), &around, false).ok()?;
    let edge = job.atlas().page_size;
    let look = |camera: &Camera| {
        let lit = Lit::look(&direct, camera, grid, &(), edge, |hit| place(job, hit)).ok()?;
        Some((*camera, lit))
    };
    let mut lit = vec![look(&fitted)?];
    let bounds = world.bounds();
    if fitted.eye.clamp(bounds.min, bounds.max) == fitted.eye {
        let others = framing.brighter(world, job.backend(), &around);
        let others: Vec<Camera> = others.filter(|other| *other != fitted).collect();
        lit.extend(others.iter().filter_map(look));
    }
    Some(lit)
}

/// Width, height and samples across a pixel: the picture's rays are a small part of the bake's.
fn size(job: &Job) -> ([u32; 2], u32) {
    let rays = match job.options().effort {
        Effort::Rays(rays) => rays,
        Effort::Target { .. } => 256,
    };
    match job.atlas().audit.texels * u64::from(rays) {
        0..1_000_000 => ([320, 180], 1),
        1_000_000..4_000_000 => ([320, 180], 2),
        4_000_000..100_000_000 => ([480, 270], 2),
        _ => ([800, 450], 2),
    }
}

/// Where the texels of a hit lie.
fn place(job: &Job, hit: &SurfaceHit) -> Option<TexelPlace> {
    let (page, corners) = on_page(job, hit.instance, hit.triangle)?;
    Some(TexelPlace::of(page, hit, corners))
}

/// The page of a triangle, and where its corners lie there as parts of the page's edge; `None` where it has no texels.
pub(crate) fn on_page(job: &Job, instance: u32, triangle: u32) -> Option<(u32, [Vec2; 3])> {
    let atlas = job.atlas();
    let placement = &atlas.placements[instance as usize];
    if !placement.is_somewhere() {
        return None;
    }
    let mesh = job.world().scene().instances[instance as usize].mesh;
    let layout = &atlas.meshes[mesh as usize];
    let pages = &layout.triangle_pages;
    let further = pages.get(triangle as usize).copied().unwrap_or(0);
    let [scale, offset] = [placement.scale, placement.offset].map(Vec2::from);
    let corners = layout.triangles[triangle as usize];
    Some((
        placement.page + u32::from(further),
        corners.map(|corner| layout.uvs[corner as usize] * scale + offset),
    ))
}
