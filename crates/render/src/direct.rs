//! The ambient models integrated where a ray meets the scene, with lights and luminous surfaces.
//!
//! Light arrives from the sky where nothing is in the way, and from surfaces that shine by themselves. In a scene
//! without those the result is exactly the model that a bake stores, seen from the true eye: the specular lobe stands
//! about R = 2(N·E)N − E of every point.

use crate::{Lamps, Light, Lightmap, Sample, TexelPlace};
use ambient::Frame;
use ambient::models;
use ambient::sampling::{Lobe, Mixture, Stream};
use glam::DVec3;
use rays::{Coherence, Overrides, Ray, RayBackend, RayPacket, SurfaceHit, SurfacePoint, Surfaces};

/// Which ambient model shades a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// A constant times the open share of the hemisphere.
    Traditional,
    /// Equation (5) of the paper.
    Lambert,
    /// Equation (9) of the paper.
    Phong,
}

impl Model {
    /// The word for it on the command line, and its layer in a bake.
    pub fn name(self) -> &'static str {
        match self {
            Model::Traditional => "traditional",
            Model::Lambert => "lambert",
            Model::Phong => "phong",
        }
    }
}

/// Shades rays by integration.
pub struct Direct<'a> {
    /// What the rays meet.
    pub surfaces: &'a Surfaces<'a>,
    /// Who casts them.
    pub backend: &'a dyn RayBackend,
    /// The ambient model.
    pub model: Model,
    /// Rays over the hemisphere of every camera sample, and as many over a specular lobe; where surfaces shine, as many
    /// again toward those. 0 leaves all of this light out.
    pub rays: u32,
    /// Uniform sky radiance.
    pub sky: DVec3,
    /// What a camera ray that meets nothing shows.
    pub background: DVec3,
    /// Lights without extent; they cast shadows.
    pub lights: &'a [Light],
    /// Occluders farther than this do not count.
    pub max_distance: f32,
    /// Values that replace the materials' own.
    pub overrides: Overrides,
    /// Seed of the sample streams.
    pub seed: u64,
    /// The surfaces that shine by themselves.
    pub lamps: &'a Lamps,
}

/// Stream labels.
const HEMISPHERE: u32 = 1;
const LOBE: u32 = 2;

impl Direct<'_> {
    /// The radiance that reaches the eye of a sample.
    pub fn radiance(&self, sample: &Sample) -> DVec3 {
        let Some((_, point)) = self.surface(sample) else {
            return self.background;
        };
        let stream = |term| Stream::new(self.seed, 0, sample.pixel, term, sample.number);
        let view = -sample.direction;
        point.emission + self.ambient(&point, view, stream) + self.direct(&point, view)
    }

    /// The same with the ambient model taken from a bake; surfaces without texels are integrated.
    pub fn radiance_baked(&self, sample: &Sample, map: &Lightmap) -> DVec3 {
        let scene = self.surfaces.world().scene();
        let (radiance, place) = self.beside_texels(sample, |hit| map.place(scene, hit));
        radiance + place.map_or(DVec3::ZERO, |place| map.at(place))
    }

    /// The radiance of a sample but for what a bake holds, and the place in the bake that holds the rest.
    pub(crate) fn beside_texels(
        &self,
        sample: &Sample,
        place: impl Fn(&SurfaceHit) -> Option<TexelPlace>,
    ) -> (DVec3, Option<TexelPlace>) {
        let Some((hit, point)) = self.surface(sample) else {
            return (self.background, None);
        };
        let place = place(&hit);
        let view = -sample.direction;
        let mut radiance = point.emission + self.direct(&point, view);
        if place.is_none() {
            let stream = |term| Stream::new(self.seed, 0, sample.pixel, term, sample.number);
            radiance += self.ambient(&point, view, stream);
        }
        (radiance, place)
    }

    /// True where a sample shows a surface, not the background.
    pub fn meets(&self, sample: &Sample) -> bool {
        self.surface(sample).is_some()
    }

    /// What a camera ray meets first.
    fn surface(&self, sample: &Sample) -> Option<(SurfaceHit, SurfacePoint)> {
        let hit = self.backend.closest(&Ray {
            origin: sample.eye.as_vec3().to_array(),
            direction: sample.direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        })?;
        let mut point = self.surfaces.at(&hit, -sample.direction);
        point.material = self.overrides.applied(point.material);
        Some((hit, point))
    }

    /// Ambient light reflected toward the unit direction `view`.
    fn ambient(&self, point: &SurfacePoint, view: DVec3, stream: impl Fn(u32) -> Stream) -> DVec3 {
        if self.rays == 0 {
            return DVec3::ZERO;
        }
        let frame = Frame::from_normal(point.normal);
        let mixture = match self.model {
            Model::Traditional => Mixture::UNIFORM,
            Model::Lambert | Model::Phong => Mixture::COSINE,
        };
        let material = &point.material;
        let hemisphere = if material.albedo == DVec3::ZERO {
            DVec3::ZERO
        } else {
            self.arriving(
                point,
                stream(HEMISPHERE),
                |u| frame.to_world(mixture.sample(u)),
                |toward| mixture.pdf(frame.to_local(toward)),
            )
        };
        let reflected = models::lambert(hemisphere, material.albedo);
        if self.model != Model::Phong || material.specular == DVec3::ZERO {
            return reflected;
        }
        let about = Frame::from_normal(mirrored(point.normal, view));
        let lobe = Lobe::new(material.exponent);
        let specular = self.arriving(
            point,
            stream(LOBE),
            |u| about.to_world(lobe.sample(u)),
            |toward| lobe.pdf(about.to_local(toward)),
        );
        reflected + material.specular * specular
    }

    /// Mean radiance from directions of a distribution; those below the shading or the geometric horizon bring none.
    ///
    /// * `pdf`: the distribution's probability per steradian of a unit direction.
    fn arriving(
        &self,
        point: &SurfacePoint,
        stream: Stream,
        direction: impl Fn([f64; 2]) -> DVec3,
        pdf: impl Fn(DVec3) -> f64,
    ) -> DVec3 {
        let mut sum = DVec3::ZERO;
        let mut packet = RayPacket::<16>::new();
        let mut lanes = 0;
        let mut open = 0u32;
        for index in 0..self.rays {
            let [u0, u1, u2, u3] = stream.point(index);
            let toward = direction([u0, u1]);
            if !self.lamps.is_empty() {
                sum += self.luminous(point, toward, &pdf);
                sum += self.aimed(point, [u2, u3], &pdf);
                continue;
            }
            if above(point, toward) {
                packet.set(lanes, &self.ray(point, toward));
                lanes += 1;
            }
            if lanes == 16 || (index + 1 == self.rays && lanes > 0) {
                let active = u32::MAX >> (32 - lanes);
                let blocked = self
                    .backend
                    .occluded16(&packet, active, Coherence::Incoherent);
                open += (active & !blocked).count_ones();
                lanes = 0;
            }
        }
        (sum + self.sky * f64::from(open)) / f64::from(self.rays)
    }

    /// What a ray of the distribution brings: the sky, or its share of a lamp's radiance.
    fn luminous(&self, point: &SurfacePoint, toward: DVec3, pdf: impl Fn(DVec3) -> f64) -> DVec3 {
        if !above(point, toward) {
            return DVec3::ZERO;
        }
        let Some(hit) = self.backend.closest(&self.ray(point, toward)) else {
            return self.sky;
        };
        self.shared(&hit, toward, pdf(toward))
    }

    /// What a ray toward a lamp brings: the other share, where that lamp is what it meets first.
    fn aimed(&self, point: &SurfacePoint, u: [f64; 2], pdf: impl Fn(DVec3) -> f64) -> DVec3 {
        let (place, target) = self.lamps.sample(self.surfaces.world(), u);
        let toward = (target - point.position).normalize_or_zero();
        let density = pdf(toward);
        if density == 0.0 || !above(point, toward) {
            return DVec3::ZERO;
        }
        match self.backend.closest(&self.ray(point, toward)) {
            Some(hit) if (hit.instance, hit.triangle) == place => {
                self.shared(&hit, toward, density)
            }
            _ => DVec3::ZERO,
        }
    }

    /// Radiance of a hit times the share of `density` in it and the probability of aiming there.
    fn shared(&self, hit: &SurfaceHit, toward: DVec3, density: f64) -> DVec3 {
        let emission = self.surfaces.emission(hit);
        if emission == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let world = self.surfaces.world();
        emission * (density / (density + self.lamps.pdf(world, hit, toward)))
    }

    /// The ambient ray from a point.
    fn ray(&self, point: &SurfacePoint, toward: DVec3) -> Ray {
        Ray {
            origin: point.origin,
            direction: toward.as_vec3().to_array(),
            t_min: 0.0,
            t_max: self.max_distance,
        }
    }

    /// Light of the lights reflected toward the unit direction `view`.
    fn direct(&self, point: &SurfacePoint, view: DVec3) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for light in self.lights {
            let arrival = light.at(point.position);
            let mut reflected = arrival.diffuse(point.normal, point.material.albedo);
            if self.model == Model::Phong {
                let mirror = mirrored(point.normal, view);
                reflected += arrival.specular(point.normal, mirror, &point.material);
            }
            if reflected == DVec3::ZERO || point.geometric.dot(arrival.toward) <= 0.0 {
                continue;
            }
            let ray = Ray {
                origin: point.origin,
                direction: arrival.toward.as_vec3().to_array(),
                t_min: 0.0,
                t_max: arrival.distance as f32,
            };
            if !self.backend.occluded(&ray) {
                sum += reflected;
            }
        }
        sum
    }
}

/// True above the shading and the geometric horizon.
fn above(point: &SurfacePoint, toward: DVec3) -> bool {
    toward.dot(point.normal) > 0.0 && toward.dot(point.geometric) > 0.0
}

/// R = 2(N·E)N − E.
fn mirrored(normal: DVec3, view: DVec3) -> DVec3 {
    2.0 * normal.dot(view) * normal - view
}
