//! The ambient models integrated where a ray meets the scene, with lights and luminous surfaces.
//!
//! Light arrives from the sky where nothing is in the way, and from surfaces that shine by themselves. In a scene
//! without those the result is exactly the model that a bake stores, seen from the true eye: the specular lobe stands
//! about R = 2(N·E)N − E of every point.

use crate::microfacets::Coat;
use crate::{Lamps, Light, Lightmap, Sample, TexelPlace};
use ambient::Frame;
use ambient::closed_form::phong_open;
use ambient::lunar::lommel_seeliger;
use ambient::models;
use ambient::sampling::{Lobe, Mixture, Stream};
use glam::DVec3;
use rays::{
    Arrival, Coherence, Overrides, Ray, RayBackend, RayPacket, SurfaceHit, SurfacePoint, Surfaces,
};

/// Which ambient model shades a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// A constant times the open share of the hemisphere.
    Traditional,
    /// The same constant times what an open surface reflects, matte and specular, in closed form.
    TraditionalClosed,
    /// Equation (5) of the paper.
    Lambert,
    /// Equation (9) of the paper.
    Phong,
    /// GGX microfacets over a matte base.
    Ggx,
    /// Loose dust, as on the Moon: [`ambient::lunar`].
    LommelSeeliger,
    /// Albedo times the cosine to the eye, without any light.
    FacingRatio,
}

impl Model {
    /// The word for it on the command line, and its layer in a bake.
    pub fn name(self) -> &'static str {
        match self {
            Model::Traditional => "traditional",
            Model::TraditionalClosed => "traditional.closed",
            Model::Lambert => "lambert",
            Model::Phong => "phong",
            Model::Ggx => "ggx",
            Model::LommelSeeliger => "lommel-seeliger",
            Model::FacingRatio => "facing-ratio",
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
const SHADOWS: u32 = 3;

/// Shadow rays of a sample to each light with extent.
const SHADOW_RAYS: u32 = 16;

/// Points of a coat where no rays are asked for.
const LEAST_POINTS: u32 = 64;

impl Direct<'_> {
    /// The radiance that reaches the eye of a sample.
    pub fn radiance(&self, sample: &Sample) -> DVec3 {
        let Some((_, point)) = self.surface(sample) else {
            return self.background;
        };
        let stream = |term| Stream::new(self.seed, 0, sample.pixel, term, sample.number);
        let view = -sample.direction;
        if self.model == Model::FacingRatio {
            return point.emission + point.material.albedo * point.normal.dot(view).max(0.0);
        }
        let coat = self.coat(&point, view, stream(LOBE));
        let ambient = self.ambient(&point, view, coat.as_ref(), stream);
        point.emission + ambient + self.direct(&point, view, coat.as_ref(), stream(SHADOWS))
    }

    /// The same with the ambient model taken from a bake; surfaces without texels are integrated.
    pub fn radiance_baked(&self, sample: &Sample, map: &Lightmap) -> DVec3 {
        let scene = self.surfaces.world().scene();
        let Some(hit) = self.hit(sample) else {
            return self.background;
        };
        let (radiance, place) = self.beside_texels(sample, &hit, map.place(scene, &hit));
        radiance + place.map_or(DVec3::ZERO, |place| map.at(place))
    }

    /// The radiance of what a sample meets but for what a bake holds, and the place in the bake that holds the rest,
    /// where there is one.
    pub(crate) fn beside_texels(
        &self,
        sample: &Sample,
        hit: &SurfaceHit,
        place: Option<TexelPlace>,
    ) -> (DVec3, Option<TexelPlace>) {
        if place.is_some() && self.lights.is_empty() && !self.surfaces.may_shine(hit) {
            return (DVec3::ZERO, place);
        }
        let point = self.point(sample, hit);
        let view = -sample.direction;
        let stream = |term| Stream::new(self.seed, 0, sample.pixel, term, sample.number);
        let coat = self.coat(&point, view, stream(LOBE));
        let mut radiance =
            point.emission + self.direct(&point, view, coat.as_ref(), stream(SHADOWS));
        if place.is_none() {
            radiance += self.ambient(&point, view, coat.as_ref(), stream);
        }
        (radiance, place)
    }

    /// True where a sample shows a surface, not the background.
    pub fn meets(&self, sample: &Sample) -> bool {
        self.surface(sample).is_some()
    }

    /// What a camera ray meets first.
    fn surface(&self, sample: &Sample) -> Option<(SurfaceHit, SurfacePoint)> {
        let hit = self.hit(sample)?;
        let point = self.point(sample, &hit);
        Some((hit, point))
    }

    pub(crate) fn hit(&self, sample: &Sample) -> Option<SurfaceHit> {
        self.backend.closest(&Ray {
            origin: sample.eye.as_vec3().to_array(),
            direction: sample.direction.as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        })
    }

    fn point(&self, sample: &Sample, hit: &SurfaceHit) -> SurfacePoint {
        let mut point = self.surfaces.at(hit, -sample.direction);
        point.material = self.overrides.applied(point.material);
        point
    }

    /// The coat of a point for a unit direction to the eye, where the model has one and the material shines.
    fn coat(&self, point: &SurfacePoint, view: DVec3, stream: Stream) -> Option<Coat> {
        let material = &point.material;
        if self.model != Model::Ggx || material.specular == DVec3::ZERO {
            return None;
        }
        let count = if self.rays == 0 {
            LEAST_POINTS
        } else {
            self.rays
        };
        let points = (0..count).map(|index| {
            let [u0, u1, ..] = stream.point(index);
            [u0, u1]
        });
        Some(Coat::of(material, point.normal, view, points))
    }

    /// Ambient light reflected toward the unit direction `view`.
    fn ambient(
        &self,
        point: &SurfacePoint,
        view: DVec3,
        coat: Option<&Coat>,
        stream: impl Fn(u32) -> Stream,
    ) -> DVec3 {
        if self.rays == 0 {
            return DVec3::ZERO;
        }
        let frame = Frame::from_normal(point.normal);
        let (normal, material) = (point.normal, &point.material);
        let mixture = match self.model {
            Model::Traditional | Model::TraditionalClosed => Mixture::UNIFORM,
            _ => Mixture::COSINE,
        };
        let matte = match self.model {
            Model::TraditionalClosed => {
                let [cos, sin] = [normal.dot(view), normal.cross(view).length()];
                material.albedo + material.specular * phong_open(material.exponent, cos, sin)
            }
            _ => coat.map_or(material.albedo, |coat| coat.base),
        };
        let hemisphere = if matte == DVec3::ZERO {
            DVec3::ZERO
        } else {
            self.arriving(
                point,
                stream(HEMISPHERE),
                |u| frame.to_world(mixture.sample(u)),
                |toward| mixture.pdf(frame.to_local(toward)),
                |toward| DVec3::splat(self.beside_lambert(normal, toward, view)),
            )
        };
        let reflected = models::lambert(hemisphere, matte);
        if let Some(coat) = coat {
            return reflected
                + self.arriving(
                    point,
                    stream(LOBE),
                    |u| coat.sample(u),
                    |toward| coat.pdf(toward),
                    |toward| coat.weight(toward),
                );
        }
        if self.model != Model::Phong || material.specular == DVec3::ZERO {
            return reflected;
        }
        let about = Frame::from_normal(mirrored(normal, view));
        let lobe = Lobe::new(material.exponent);
        let specular = self.arriving(
            point,
            stream(LOBE),
            |u| about.to_world(lobe.sample(u)),
            |toward| lobe.pdf(about.to_local(toward)),
            |_| DVec3::ONE,
        );
        reflected + material.specular * specular
    }

    /// Mean weighted radiance from directions of a distribution; those below the shading or the geometric horizon bring none.
    ///
    /// * `pdf`: the distribution's probability per steradian of a unit direction.
    /// * `weight`: what radiance from a unit direction counts.
    fn arriving(
        &self,
        point: &SurfacePoint,
        stream: Stream,
        direction: impl Fn([f64; 2]) -> DVec3,
        pdf: impl Fn(DVec3) -> f64,
        weight: impl Fn(DVec3) -> DVec3,
    ) -> DVec3 {
        let mut sum = DVec3::ZERO;
        let mut packet = RayPacket::<16>::new();
        let mut weights = [DVec3::ZERO; 16];
        let mut lanes = 0;
        let mut open = DVec3::ZERO;
        for index in 0..self.rays {
            let [u0, u1, u2, u3] = stream.point(index);
            let toward = direction([u0, u1]);
            if !self.lamps.is_empty() {
                sum += self.luminous(point, toward, &pdf, &weight);
                sum += self.aimed(point, [u2, u3], &pdf, &weight);
                continue;
            }
            if above(point, toward) {
                packet.set(lanes, &self.ray(point, toward));
                weights[lanes] = weight(toward);
                lanes += 1;
            }
            if lanes == 16 || (index + 1 == self.rays && lanes > 0) {
                let active = u32::MAX >> (32 - lanes);
                let blocked = self
                    .backend
                    .occluded16(&packet, active, Coherence::Incoherent);
                let lit = (0..lanes).filter(|lane| blocked >> lane & 1 == 0);
                open += lit.map(|lane| weights[lane]).sum::<DVec3>();
                lanes = 0;
            }
        }
        (sum + self.sky * open) / f64::from(self.rays)
    }

    /// What a ray of the distribution brings: the sky, or its share of a lamp's radiance.
    fn luminous(
        &self,
        point: &SurfacePoint,
        toward: DVec3,
        pdf: impl Fn(DVec3) -> f64,
        weight: impl Fn(DVec3) -> DVec3,
    ) -> DVec3 {
        if !above(point, toward) {
            return DVec3::ZERO;
        }
        let radiance = match self.backend.closest(&self.ray(point, toward)) {
            None => self.sky,
            Some(hit) => self.shared(&hit, toward, pdf(toward)),
        };
        weight(toward) * radiance
    }

    /// What a ray toward a lamp brings: the other share, where that lamp is what it meets first.
    fn aimed(
        &self,
        point: &SurfacePoint,
        u: [f64; 2],
        pdf: impl Fn(DVec3) -> f64,
        weight: impl Fn(DVec3) -> DVec3,
    ) -> DVec3 {
        let (place, target) = self.lamps.sample(self.surfaces.world(), u);
        let toward = (target - point.position).normalize_or_zero();
        let density = pdf(toward);
        if density == 0.0 || !above(point, toward) {
            return DVec3::ZERO;
        }
        match self.backend.closest(&self.ray(point, toward)) {
            Some(hit) if (hit.instance, hit.triangle) == place => {
                weight(toward) * self.shared(&hit, toward, density)
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

    /// What the model's matte part is times Lambert's, for a light and an eye in these unit directions.
    fn beside_lambert(&self, normal: DVec3, toward: DVec3, view: DVec3) -> f64 {
        match self.model {
            Model::LommelSeeliger => lommel_seeliger(normal.dot(toward), normal.dot(view)),
            _ => 1.0,
        }
    }

    /// Light of the lights reflected toward the unit direction `view`.
    fn direct(
        &self,
        point: &SurfacePoint,
        view: DVec3,
        coat: Option<&Coat>,
        stream: Stream,
    ) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for light in self.lights {
            let rays = if light.has_extent() { SHADOW_RAYS } else { 1 };
            let ray = |index: u32| {
                let [u0, u1, ..] = stream.point(index);
                self.reflected(&light.at(point.position, [u0, u1]), point, view, coat)
            };
            sum += (0..rays).map(ray).sum::<DVec3>() / f64::from(rays);
        }
        sum
    }

    /// What of a light arrives, past what stands before it, and is reflected toward the unit direction `view`.
    fn reflected(
        &self,
        arrival: &Arrival,
        point: &SurfacePoint,
        view: DVec3,
        coat: Option<&Coat>,
    ) -> DVec3 {
        let matte = coat.map_or(point.material.albedo, |coat| coat.base);
        let mut reflected = arrival.diffuse(point.normal, matte)
            * self.beside_lambert(point.normal, arrival.toward, view);
        if let Some(coat) = coat {
            reflected += coat.reflected(arrival.toward) * arrival.irradiance;
        } else if self.model == Model::Phong {
            let mirror = mirrored(point.normal, view);
            reflected += arrival.specular(point.normal, mirror, &point.material);
        }
        if reflected == DVec3::ZERO || point.geometric.dot(arrival.toward) <= 0.0 {
            return DVec3::ZERO;
        }
        let ray = Ray {
            origin: point.origin,
            direction: arrival.toward.as_vec3().to_array(),
            t_min: 0.0,
            t_max: arrival.distance as f32,
        };
        match self.backend.occluded(&ray) {
            true => DVec3::ZERO,
            false => reflected,
        }
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
