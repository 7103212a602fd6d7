//! The brightest surfaces of a gather: few, small, and what makes single texels bright where rays meet them by chance.
//!
//! A lamp lights a spot on the ceiling beside it, the sun one on the floor. Nearly all the light that goes on may come
//! from there, and few rays of a far texel meet it. So texels that send much more than the mean are put together in at
//! most [`MOST`] spheres, and a part of a texel's rays is aimed at those. A ray counts whatever it meets, weighed by
//! the balance heuristic beside the rays of the cosine (E. Veach, L. Guibas, "Optimally Combining Sampling Techniques
//! for Monte Carlo Rendering", 1995). So the choice of spheres moves no mean; it only decides where there is less
//! noise.

use super::mean;
use super::patches::Patch;
use super::radiosity::PageLight;
use glam::DVec3;
use rays::around;
use std::f64::consts::TAU;

/// Spheres of a gather, at most.
const MOST: usize = 32;
/// How much more than the mean of all surfaces a bright one sends.
const BRIGHT: f64 = 3.0;
/// Share of all light that bright surfaces send, at least.
const LEAST_SHARE: f64 = 0.01;
/// Part of a texel's aim below which a sphere is left out.
const LEAST_PART: f64 = 1.0 / 128.0;
/// What a sphere counts to a texel that its surfaces face away from: they may be round.
const BEHIND: f64 = 0.1;

/// The spheres that rays of a gather are aimed at.
#[derive(Debug, Clone, Default)]
pub(super) struct Spots(Vec<Spot>);

/// A sphere about bright surfaces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    centre: DVec3,
    radius: f64,
    /// Radiosity times area, mean of the channels.
    power: f64,
    /// Mean normal of what shines, shorter the more they differ.
    normal: DVec3,
}

/// How often aimed rays met what they were aimed at, spot by spot.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reach {
    aimed: [u32; MOST],
    met: [u32; MOST],
}

/// Where the aimed rays of a texel go: directions of cones, each with a part of the rays.
#[derive(Debug, Clone, Default)]
pub(super) struct Aim(Vec<Cone>);

#[derive(Debug, Clone, Copy)]
struct Cone {
    spot: usize,
    axis: DVec3,
    /// 1 less the cosine of the half angle.
    cap: f64,
    /// Sum of the parts of the cones before this one and with it.
    until: f64,
    /// Density of rays per steradian within.
    density: f64,
}

/// A bright texel.
struct Bright {
    position: DVec3,
    radius: f64,
    normal: DVec3,
    power: f64,
}

impl Spots {
    /// Those of pages that send `light`. None where light is even enough.
    pub fn of(patches: &[Vec<Patch>], light: &[PageLight]) -> Self {
        let lit = || {
            patches.iter().zip(light).flat_map(|(patches, light)| {
                patches.iter().map(|patch| {
                    let irradiance = light.irradiance[patch.index as usize].map(f64::from);
                    let sent = f64::from(patch.albedo) * mean(DVec3::from(irradiance));
                    (patch, sent)
                })
            })
        };
        let (mut all, mut area) = (0.0, 0.0);
        for (patch, sent) in lit() {
            area += f64::from(patch.area);
            all += f64::from(patch.area) * sent;
        }
        let least = BRIGHT * all / area;
        let bright = lit().filter(|(_, sent)| *sent > least);
        let mut bright: Vec<Bright> = bright
            .map(|(patch, sent)| Bright {
                position: patch.position(),
                // Reaches past the corners of a square.
                radius: f64::from(patch.area).sqrt(),
                normal: patch.normal(),
                power: sent * f64::from(patch.area),
            })
            .collect();
        let power: f64 = bright.iter().map(|bright| bright.power).sum();
        match power > LEAST_SHARE * all {
            true => Self(clustered(&mut bright)),
            false => Self::default(),
        }
    }

    /// Where rays of a surface of this size at `position` are aimed, by what the spheres would send it if nothing stood
    /// between, and what `reach` tells of that.
    pub fn aim(&self, position: DVec3, normal: DVec3, size: f64, reach: &Reach) -> Aim {
        let parts = self.0.iter().enumerate().filter_map(|(at, spot)| {
            let toward = spot.centre - position;
            let (distance, radius) = (toward.length(), spot.radius + size);
            if distance <= radius {
                return None;
            }
            let (axis, sine) = (toward / distance, radius / distance);
            let received = (axis.dot(normal) + sine).min(1.0);
            let sent = (-axis.dot(spot.normal)).max(0.0) + BEHIND;
            let part = spot.power * received * sent / (distance * distance) * reach.share(at);
            let cap = sine * sine / (1.0 + (1.0 - sine * sine).sqrt());
            (received > 0.0).then_some((at, axis, cap, part))
        });
        let parts: Vec<_> = parts.collect();
        let whole: f64 = parts.iter().map(|part| part.3).sum();
        let kept = || parts.iter().filter(|part| part.3 > LEAST_PART * whole);
        let whole: f64 = kept().map(|part| part.3).sum();
        let mut until = 0.0;
        let cones = kept().map(|&(spot, axis, cap, part)| {
            until += part / whole;
            Cone {
                spot,
                axis,
                cap,
                until,
                density: part / whole / (TAU * cap),
            }
        });
        Aim(cones.collect())
    }

    /// Counts a ray that was aimed at a spot and met a surface at `met`, if any.
    pub fn count(&self, reach: &mut Reach, spot: usize, met: Option<DVec3>) {
        let Spot { centre, radius, .. } = self.0[spot];
        let reached = met.is_some_and(|met| met.distance_squared(centre) <= radius * radius);
        reach.aimed[spot] += 1;
        reach.met[spot] += u32::from(reached);
    }
}

impl Reach {
    /// Adds what other texels tell.
    pub fn add(&mut self, other: &Self) {
        let pairs = self.aimed.iter_mut().zip(other.aimed);
        pairs.for_each(|(own, other)| *own += other);
        let pairs = self.met.iter_mut().zip(other.met);
        pairs.for_each(|(own, other)| *own += other);
    }

    /// Share of the rays that meet what they are aimed at.
    fn share(&self, spot: usize) -> f64 {
        (f64::from(self.met[spot]) + 0.5) / (f64::from(self.aimed[spot]) + 1.0)
    }
}

impl Aim {
    /// True where there is nothing to aim at.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A spot and a unit direction to it for a point of the unit square; there must be one.
    pub fn sample(&self, u: [f64; 2]) -> (usize, DVec3) {
        let last = self.0.len() - 1;
        let chosen = self.0.partition_point(|cone| cone.until <= u[0]).min(last);
        let before = chosen.checked_sub(1).map_or(0.0, |last| self.0[last].until);
        let cone = &self.0[chosen];
        // The place within the cone's part is a fresh number.
        let along = ((u[0] - before) / (cone.until - before)).min(1.0);
        let height = 1.0 - along * cone.cap;
        let sine = (1.0 - height * height).max(0.0).sqrt();
        let (y, x) = (TAU * u[1]).sin_cos();
        let frame = ambient::Frame::from_normal(cone.axis);
        (
            cone.spot,
            frame.to_world(DVec3::new(sine * x, sine * y, height)),
        )
    }

    /// Density per steradian of aimed rays in a unit direction.
    pub fn pdf(&self, toward: DVec3) -> f64 {
        let within = |cone: &&Cone| cone.axis.dot(toward) >= 1.0 - cone.cap;
        self.0.iter().filter(within).map(|cone| cone.density).sum()
    }
}

/// Puts bright texels together in spheres: what has most light over most room is parted first.
fn clustered(bright: &mut [Bright]) -> Vec<Spot> {
    let mut parts = vec![(0..bright.len(), sphere(bright), true)];
    while parts.len() < MOST {
        let cost = |spot: &Spot| spot.power * spot.radius;
        let open = parts.iter().enumerate().filter(|(_, part)| part.2);
        let most = open.max_by(|(_, a), (_, b)| cost(&a.1).total_cmp(&cost(&b.1)));
        let Some((chosen, _)) = most else {
            break;
        };
        let range = parts[chosen].0.clone();
        let middle = range.start + part(&mut bright[range.clone()]);
        if middle == range.start || middle == range.end {
            parts[chosen].2 = false;
            continue;
        }
        parts[chosen] = (
            range.start..middle,
            sphere(&bright[range.start..middle]),
            true,
        );
        parts.push((middle..range.end, sphere(&bright[middle..range.end]), true));
    }
    parts.into_iter().map(|(_, spot, _)| spot).collect()
}

/// Parts texels at the mean of their light along the longest axis of their box, and says how many lie before it.
fn part(bright: &mut [Bright]) -> usize {
    let (low, high) = around(bright.iter().map(|one| one.position));
    let axis = (high - low).max_position();
    let (mut sum, mut power) = (0.0, 0.0);
    for one in bright.iter() {
        sum += one.power * one.position[axis];
        power += one.power;
    }
    bright.sort_by(|a, b| a.position[axis].total_cmp(&b.position[axis]));
    bright.partition_point(|one| one.position[axis] < sum / power)
}

/// The sphere about texels.
fn sphere(bright: &[Bright]) -> Spot {
    let (low, high) = around(bright.iter().map(|one| one.position));
    let centre = 0.5 * (low + high);
    let reach = |one: &Bright| one.position.distance(centre) + one.radius;
    let power: f64 = bright.iter().map(|one| one.power).sum();
    let normal: DVec3 = bright.iter().map(|one| one.power * one.normal).sum();
    Spot {
        centre,
        radius: bright.iter().map(reach).fold(0.0, f64::max),
        power,
        normal: normal / power,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A floor of 16 x 16 texels on which a few shine.
    fn floor(lit: &[u32]) -> Spots {
        let patch = |index: u32| {
            let at = DVec3::new(
                f64::from(index % 16) + 0.5,
                f64::from(index / 16) + 0.5,
                0.0,
            );
            Patch::new(index, at, DVec3::Z, 1.0, 0.5)
        };
        let mut light = PageLight {
            irradiance: vec![[0.01; 3]; 256],
            holds: vec![true; 256],
        };
        for &index in lit {
            light.irradiance[index as usize] = [4.0, 2.0, 1.0];
        }
        Spots::of(&[(0..256).map(patch).collect()], &[light])
    }

    #[test]
    fn even_light_has_no_spots() {
        assert!(floor(&[]).0.is_empty());
    }

    #[test]
    fn aimed_directions_have_the_density_that_is_stated_and_meet_what_shines() {
        let spots = floor(&[17, 18, 33, 200, 201]);
        assert_eq!(spots.0.len(), 5, "one sphere for each bright texel");
        let (eye, down) = (DVec3::new(3.0, 12.0, 5.0), DVec3::NEG_Z);
        let aim = spots.aim(eye, down, 0.1, &Reach::default());
        // The mean of 1/pdf is the solid angle of all cones together, and that of any share of them is that share's.
        const POINTS: u32 = 1 << 12;
        let stream = ambient::sampling::Stream::new(0, 0, 0, 0, 0);
        let (mut near, mut all) = (0.0, 0.0);
        for point in 0..POINTS {
            let [u, v, ..] = stream.point(point);
            let (spot, ray) = aim.sample([u, v]);
            let floor = eye - ray * (eye.z / ray.z);
            let Spot { centre, radius, .. } = spots.0[spot];
            let missed = (centre - eye).cross(ray).length();
            assert!(missed < radius + 0.1 + 1e-9, "{missed} beside {centre}");
            all += 1.0 / aim.pdf(ray);
            near += if floor.y > 8.0 {
                1.0 / aim.pdf(ray)
            } else {
                0.0
            };
        }
        // The same by even directions.
        let (mut exact_near, mut exact_all) = (0.0, 0.0);
        const EVEN: u32 = 1 << 16;
        for point in 0..EVEN {
            let [u, v, ..] = stream.point(point);
            let (y, x) = (TAU * v).sin_cos();
            let r = (1.0 - u * u).sqrt();
            let ray = DVec3::new(r * x, r * y, -u);
            let floor = eye - ray * (eye.z / ray.z);
            let within = if aim.pdf(ray) > 0.0 {
                TAU / f64::from(EVEN)
            } else {
                0.0
            };
            exact_all += within;
            exact_near += if floor.y > 8.0 { within } else { 0.0 };
        }
        for (found, exact) in [(all, exact_all), (near, exact_near)] {
            let found = found / f64::from(POINTS);
            assert!((found / exact - 1.0).abs() < 0.01, "{found}, not {exact}");
        }
    }

    #[test]
    fn what_cannot_be_reached_gets_few_rays() {
        let spots = floor(&[17, 200]);
        let eye = DVec3::new(5.0, 7.0, 6.0);
        let mut reach = Reach::default();
        for _ in 0..30 {
            spots.count(&mut reach, 0, None);
            spots.count(&mut reach, 1, Some(spots.0[1].centre));
        }
        let aim = spots.aim(eye, DVec3::NEG_Z, 0.1, &reach);
        let hidden = (0..100).filter(|k| aim.sample([(f64::from(*k) + 0.5) / 100.0, 0.3]).0 == 0);
        assert!(hidden.count() < 10);
    }
}
