//! Balls in a picture that show what light is at a place: white ones in the light of a probe, and mirrors.

use crate::{Direct, Sample};
use ambient::harmonics::matt;
use environment::IlluminationMap;
use glam::DVec3;

/// A ball. It hides what is behind it, casts no shadow and is in no mirror.
#[derive(Debug, Clone, PartialEq)]
pub struct Ball {
    /// Its middle, in coordinates of the world.
    pub center: DVec3,
    /// Its radius in scene units, above 0.
    pub radius: f64,
    /// What is seen on it.
    pub shows: Shows,
}

/// What a ball shows.
#[derive(Debug, Clone, PartialEq)]
pub enum Shows {
    /// A matt white surface in the light of these coefficients by [`ambient::harmonics::basis`], linear RGB.
    Light(Vec<DVec3>),
    /// A mirror, along whose rays the scene is seen.
    Mirror,
    /// A mirror that shows a map of what is around its middle, as far away as the walls of a box; without a box
    /// endlessly far.
    Map {
        /// The map.
        map: IlluminationMap,
        /// The least and the largest corner of the box, in coordinates of the world.
        room: Option<[DVec3; 2]>,
    },
}

impl Ball {
    /// How far a sample goes to the ball, and the unit normal there; `None` where it passes by, or begins inside.
    fn meets(&self, sample: &Sample) -> Option<(f64, DVec3)> {
        let toward = self.center - sample.eye;
        let along = toward.dot(sample.direction);
        let past = (toward - along * sample.direction).length_squared();
        let half = (self.radius * self.radius - past).max(0.0).sqrt();
        let distance = along - half;
        let point = distance * sample.direction - toward;
        (half > 0.0 && distance > 0.0).then(|| (distance, point / self.radius))
    }

    /// The direction from its middle to what a ray from `point` meets of a box, along which a map shows it. The point
    /// is in the box.
    fn parallax(&self, point: DVec3, direction: DVec3, [low, high]: [DVec3; 2]) -> DVec3 {
        let walls = DVec3::select(direction.cmplt(DVec3::ZERO), low, high);
        // Along an axis that the ray does not take a wall is infinitely far.
        let distance = (walls - point) / direction;
        let nearest = distance.map(|d| if d.is_nan() { f64::INFINITY } else { d });
        point + nearest.min_element().max(0.0) * direction - self.center
    }
}

impl Direct<'_> {
    /// The radiance of the ball that a sample shows; `None` where it shows none, or something before them. `around`
    /// tells the radiance of samples that mirrors send on.
    pub fn on_balls(
        &self,
        sample: &Sample,
        balls: &[Ball],
        around: impl Fn(&Sample) -> DVec3,
    ) -> Option<DVec3> {
        let met = |ball| Some((ball, Ball::meets(ball, sample)?));
        let nearest = balls.iter().filter_map(met);
        let (ball, (distance, normal)) = nearest.min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0))?;
        if (self.hit(sample)).is_some_and(|hit| distance >= f64::from(hit.t)) {
            return None;
        }
        let direction = sample.direction - 2.0 * sample.direction.dot(normal) * normal;
        let eye = sample.eye + distance * sample.direction;
        Some(match &ball.shows {
            Shows::Light(light) => matt(light, normal).max(DVec3::ZERO),
            Shows::Mirror => around(&Sample {
                eye,
                direction,
                ..*sample
            }),
            Shows::Map { map, room } => {
                let shown = room.map_or(direction, |room| ball.parallax(eye, direction, room));
                DVec3::from(map.bilinear(shown.normalize().to_array()).map(f64::from))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{white, world};
    use environment::{Image, Projection};
    use glam::Vec3;
    use rays::{Lamps, Surfaces};

    #[test]
    fn a_ball_shows_the_light_of_its_normal_before_what_is_behind_it() {
        let wall = [Vec3::new(-9.0, -9.0, -5.0), Vec3::X * 18.0, Vec3::Y * 18.0];
        let (world, backend) = world(&[white(wall)]);
        let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
        let direct = Direct::new(&surfaces, backend.as_ref(), &lamps);
        let origin = world.origin();
        // 1 in all directions, and 3 more along +y: E / pi is 1 + 3 * 2/3 y.
        let root = (4.0 * std::f64::consts::PI).sqrt();
        let light = vec![DVec3::splat(root), DVec3::splat(root * 3.0 / 3f64.sqrt())];
        let ball = |z: f64| Ball {
            center: DVec3::new(0.0, 0.0, z) - origin,
            radius: 1.0,
            shows: Shows::Light(light.clone()),
        };
        let sample = |eye: DVec3, direction: DVec3| Sample {
            pixel: 0,
            number: 0,
            eye: eye - origin,
            direction,
        };
        let seen = |eye, direction, z| {
            direct.on_balls(&sample(eye, direction), &[ball(z)], |_| DVec3::ONE)
        };
        let is = |found: Option<DVec3>, value: f64| {
            found.is_some_and(|found| (found - DVec3::splat(value)).length() < 1e-9)
        };
        assert!(is(seen(DVec3::Z * 4.0, DVec3::NEG_Z, 0.0), 1.0));
        assert!(is(seen(DVec3::Y * 4.0, DVec3::NEG_Y, 0.0), 3.0));
        // Less than no light is none.
        assert!(is(seen(DVec3::Y * -4.0, DVec3::Y, 0.0), 0.0));
        assert_eq!(seen(DVec3::Z * 4.0, DVec3::Z, 0.0), None, "behind the eye");
        assert_eq!(
            seen(DVec3::Z * 4.0, DVec3::NEG_Z, -8.0),
            None,
            "behind the wall"
        );
        assert_eq!(
            seen(DVec3::new(1.1, 0.0, 4.0), DVec3::NEG_Z, 0.0),
            None,
            "beside it"
        );
    }
    #[test]
    fn a_mirror_and_its_map_in_a_box_show_the_same_wall() {
        let (world, backend) = world(&[white([Vec3::splat(-99.0), Vec3::X, Vec3::Y])]);
        let (surfaces, lamps) = (Surfaces::new(&world), Lamps::of(&world));
        let direct = Direct::new(&surfaces, backend.as_ref(), &lamps);
        // What stands around is a box whose walls are as bright as the places on them are high.
        let room = [DVec3::new(-2.0, -1.0, -3.0), DVec3::new(2.0, 3.0, 1.5)];
        let height = |from: DVec3, along: DVec3| {
            let walls = DVec3::select(along.cmplt(DVec3::ZERO), room[0], room[1]);
            let distance = ((walls - from) / along).min_element();
            DVec3::splat(2.0 + (from + distance * along).y)
        };
        let size = (512, 256);
        let texel = |k: usize| {
            let (x, y) = ((k % size.0) as f64 + 0.5, (k / size.0) as f64 + 0.5);
            let along = Projection::Polar.direction(size, x, y).unwrap();
            height(DVec3::ZERO, along.into()).as_vec3().to_array()
        };
        let image = Image {
            width: size.0,
            height: size.1,
            pixels: (0..size.0 * size.1).map(texel).collect(),
        };
        let map = IlluminationMap::new(image, Projection::Polar).unwrap();
        let ball = |shows| Ball {
            center: DVec3::ZERO,
            radius: 0.5,
            shows,
        };
        let boxed = [ball(Shows::Map {
            map: map.clone(),
            room: Some(room),
        })];
        let (mirror, far) = (
            [ball(Shows::Mirror)],
            [ball(Shows::Map { map, room: None })],
        );
        let mut off = 0.0f64;
        for k in 0..100 {
            let sample = Sample {
                pixel: 0,
                number: 0,
                eye: DVec3::new(1.0, 0.3, 0.9),
                direction: (DVec3::new(0.004 * f64::from(k) - 0.2, 0.1, 0.05)
                    - DVec3::new(1.0, 0.3, 0.9))
                .normalize(),
            };
            let seen = |balls: &[Ball]| {
                let around = |sample: &Sample| height(sample.eye, sample.direction);
                direct.on_balls(&sample, balls, around).unwrap().x
            };
            // A texel is 0.02 of a distance of 3 at most.
            let (exact, found) = (seen(&mirror), seen(&boxed));
            assert!((exact - found).abs() < 0.05, "{k}: {found} for {exact}");
            off = off.max((exact - seen(&far)).abs());
        }
        assert!(off > 0.1, "without the box it shows other places: {off}");
    }
}
