//! The ambient models integrated where a ray meets the scene, with lights and luminous surfaces.
//!
//! Light arrives from the sky where nothing is in the way, and from surfaces that shine by themselves. In a scene
//! without those the result is exactly the model that a bake stores, seen from the true eye: the specular lobe stands
//! about R = 2(N·E)N − E of every point.

use crate::microfacets::Coat;
use crate::weight::Weight;
use crate::{Lamps, Light, Lightmap, Model, Sample, TexelPlace};
use ambient::Frame;
use ambient::closed_form::phong_open;
use ambient::lanes::{LANES, Wide};
use ambient::lunar::lommel_seeliger;
use ambient::models;
use ambient::sampling::{Lobe, Mixture, Stream, power_over_density};
use environment::Sky;
use glam::DVec3;
use rays::{
    Arrival, Coherence, Overrides, Ray, RayBackend, RayPacket, SurfaceHit, SurfacePoint, Surfaces,
};

/// Shades rays by integration.
pub struct Direct<'a> {
    /// What the rays meet.
    pub surfaces: &'a Surfaces<'a>,
    /// Who casts them.
    pub backend: &'a dyn RayBackend,
    /// The ambient model.
    pub model: Model,
    /// Rays over the hemisphere of every camera sample, and as many over a specular lobe; where surfaces shine, as many
    /// again toward those, and under a map as many again toward what is bright in it. 0 leaves all of this light out.
    pub rays: u32,
    /// The sky. To the traditional models it is its mean.
    pub sky: Sky,
    /// What a camera ray that meets nothing shows, where that is not the sky.
    pub background: Option<DVec3>,
    /// Lights without extent; they cast shadows.
    pub lights: &'a [Light],
    /// Share of the Phong highlight of lights by the cosine of their incidence, W of section 2.1 of the 1984 text.
    /// Other models have a Fresnel term of their own, or no highlight.
    pub incidence: Weight,
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

impl<'a> Direct<'a> {
    /// Lambert's model by 64 rays under a white sky, without lights.
    pub fn new(
        surfaces: &'a Surfaces<'a>,
        backend: &'a dyn RayBackend,
        lamps: &'a Lamps,
    ) -> Direct<'a> {
        Direct {
            surfaces,
            backend,
            model: Model::Lambert,
            rays: 64,
            sky: Sky::WHITE,
            background: None,
            lights: &[],
            incidence: Weight::Constant,
            max_distance: f32::INFINITY,
            overrides: Overrides::default(),
            seed: 0,
            lamps,
        }
    }
}

impl Direct<'_> {
    /// The radiance that reaches the eye of a sample.
    pub fn radiance(&self, sample: &Sample) -> DVec3 {
        self.through(sample, |hit| self.leaving(sample, &self.point(sample, hit)))
    }

    /// The radiance that a point sends back along a sample.
    fn leaving(&self, sample: &Sample, point: &SurfacePoint) -> DVec3 {
        let stream = |term| Stream::new(self.seed, 0, sample.pixel, term, sample.number);
        let view = -sample.direction;
        if self.model == Model::FacingRatio {
            return point.emission + point.material.albedo * point.normal.dot(view).max(0.0);
        }
        let coat = self.coat(point, view, stream(LOBE));
        let ambient = self.ambient(point, view, coat.as_ref(), stream);
        point.emission + ambient + self.direct(point, view, coat.as_ref(), stream(SHADOWS))
    }

    /// The same with the ambient model taken from a bake; surfaces without texels are integrated.
    pub fn radiance_baked(&self, sample: &Sample, map: &Lightmap) -> DVec3 {
        let scene = self.surfaces.world().scene();
        self.through(sample, |hit| {
            let (radiance, place) = self.beside_texels(sample, hit, map.place(scene, hit));
            radiance + place.map_or(DVec3::ZERO, |place| map.at(place))
        })
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

    /// What panes before the surface that a ray meets, if any, leave of the channels for their mean.
    fn tint(&self, ray: &Ray, hit: Option<&SurfaceHit>) -> DVec3 {
        let end = hit.map_or(ray.t_max, |hit| hit.t);
        self.surfaces.world().tint(self.backend, ray, end)
    }

    pub(crate) fn hit(&self, sample: &Sample) -> Option<SurfaceHit> {
        self.backend.closest(&camera_ray(sample))
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
        let (mixture, sky) = match self.model {
            Model::Traditional | Model::TraditionalClosed => {
                let mean = self.sky.mean().map(|v| v as f32);
                (Mixture::UNIFORM, &Sky::Uniform(mean))
            }
            _ => (Mixture::COSINE, &self.sky),
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
                sky,
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
                    sky,
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
            sky,
            point,
            stream(LOBE),
            |u| about.to_world(lobe.sample(u)),
            |toward| lobe.pdf(about.to_local(toward)),
            |_| DVec3::ONE,
        );
        reflected + material.specular * specular
    }

    /// Mean weighted radiance from directions of a distribution; those below the shading or the geometric horizon bring
    /// none.
    ///
    /// Rays of the distribution find all light. As many that are aimed at lamps, and under a map at what is bright in
    /// it, find the same light again, each by its share: E. Veach, "Robust Monte Carlo Methods for Light Transport
    /// Simulation" (1997), 9.2.
    ///
    /// * `pdf`: the distribution's probability per steradian of a unit direction.
    /// * `weight`: what radiance from a unit direction counts.
    fn arriving(
        &self,
        sky: &Sky,
        point: &SurfacePoint,
        stream: Stream,
        direction: impl Fn([f64; 2]) -> DVec3,
        pdf: impl Fn(DVec3) -> f64,
        weight: impl Fn(DVec3) -> DVec3,
    ) -> DVec3 {
        let floor = DVec3::from(sky.floor());
        // Of the light beyond all surfaces.
        let tint = |toward| self.tint(&self.ray(point, toward), None);
        let mut sum = DVec3::ZERO;
        for first in (0..self.rays).step_by(LANES) {
            let lanes = (self.rays - first).min(LANES as u32) as usize;
            let points: [[f64; 4]; LANES] = std::array::from_fn(|l| stream.point(first + l as u32));
            let own: [DVec3; LANES] = points.map(|[u0, u1, ..]| direction([u0, u1]));
            let open = if self.lamps.is_empty() {
                self.open(point, &own[..lanes])
            } else {
                let mut open = 0;
                for (l, &toward) in own[..lanes].iter().enumerate() {
                    let [_, _, u2, u3] = points[l];
                    sum += self.aimed(point, [u2, u3], &pdf, &weight);
                    if above(point, toward) {
                        let ray = self.ray(point, toward);
                        match self.backend.closest(&ray) {
                            None => open |= 1 << l,
                            Some(hit) => {
                                let light = self.shared(&hit, toward, pdf(toward));
                                sum += weight(toward) * light * self.tint(&ray, Some(&hit));
                            }
                        }
                    }
                }
                open
            };
            let of = |open: u32| (0..lanes).filter(move |l| open >> l & 1 == 1);
            let tinted = |l: usize| weight(own[l]) * tint(own[l]);
            sum += floor * of(open).map(tinted).sum::<DVec3>();
            let Some(map) = sky.map() else { continue };
            let texels = map.texels16(&wide(&own));
            for l in of(open) {
                let (light, drawn) = map.above(texels[l]);
                let density = pdf(own[l]);
                let share = density * power_over_density(density, drawn);
                sum += tinted(l) * DVec3::from(light) * share;
            }
            let [u2, u3]: [Wide; 2] = [2, 3].map(|k| points.map(|point| point[k] as f32));
            let (axes, texels) = map.sample16(&u2, &u3);
            let drawn: [DVec3; LANES] =
                std::array::from_fn(|l| DVec3::from(axes.map(|axis| f64::from(axis[l]))));
            for l in of(self.open(point, &drawn[..lanes])) {
                let density = pdf(drawn[l]);
                if density > 0.0 {
                    let (light, of_map) = map.above(texels[l]);
                    let share = density * power_over_density(of_map, density);
                    sum += weight(drawn[l]) * DVec3::from(light) * share * tint(drawn[l]);
                }
            }
        }
        sum / f64::from(self.rays)
    }

    /// Which of sixteen directions or fewer nothing blocks, a bit each; those below a horizon are blocked.
    fn open(&self, point: &SurfacePoint, toward: &[DVec3]) -> u32 {
        let mut packet = RayPacket::<LANES>::new();
        let mut active = 0;
        for (lane, &toward) in toward.iter().enumerate() {
            if above(point, toward) {
                packet.set(lane, &self.ray(point, toward));
                active |= 1 << lane;
            }
        }
        if active == 0 {
            return 0;
        }
        active
            & !self
                .backend
                .occluded16(&packet, active, Coherence::Incoherent)
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
        let ray = self.ray(point, toward);
        match self.backend.closest(&ray) {
            Some(hit) if (hit.instance, hit.triangle) == place => {
                weight(toward) * self.shared(&hit, toward, density) * self.tint(&ray, Some(&hit))
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
            let weight = self.incidence.at(point.normal.dot(arrival.toward) as f32);
            let weight = DVec3::from(weight.map(f64::from));
            reflected += weight * arrival.specular(point.normal, mirror, &point.material);
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
        reflected * self.surfaces.world().passed(self.backend, &ray)
    }
}

/// The ray of a camera sample.
pub(crate) fn camera_ray(sample: &Sample) -> Ray {
    Ray {
        origin: sample.eye.as_vec3().to_array(),
        direction: sample.direction.as_vec3().to_array(),
        t_min: 0.0,
        t_max: f32::INFINITY,
    }
}

/// Directions axis by axis.
fn wide(directions: &[DVec3; LANES]) -> [Wide; 3] {
    [0, 1, 2].map(|axis| directions.map(|direction| direction[axis] as f32))
}

/// True above the shading and the geometric horizon.
fn above(point: &SurfacePoint, toward: DVec3) -> bool {
    toward.dot(point.normal) > 0.0 && toward.dot(point.geometric) > 0.0
}

/// R = 2(N·E)N − E.
fn mirrored(normal: DVec3, view: DVec3) -> DVec3 {
    2.0 * normal.dot(view) * normal - view
}
