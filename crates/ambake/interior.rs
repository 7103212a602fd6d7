//! Finds out whether a scene is an interior: there the sky reaches little, and a limit of distance shows more.

use crate::job::Job;
use crate::lit::on_page;
use crate::options::Options;
use ::bake::{BakedPage, Bounces};
use atlas::SurfacePoint;
use glam::DVec2;
use layers::Layer;
use report::WarningReport;

/// Points that stand for the surface, so many for each equal part of it.
const POINTS: usize = 4096;
/// A point in the dark sees less of the sky, weighed by the cosine.
const DARK: f32 = 0.1;
/// Where no more of the surface than this share sees a hundredth of the sky, next to no light gets in.
const FAINT: f32 = 0.01;
const LEAKS: f64 = 0.001;
/// So many of the points on the outsides of rooms may lie in rooms beside: borders of charts.
const BORDERS: f64 = 1.0 / 64.0;

/// The diffuse term of a point of the surface.
struct Seen {
    point: SurfacePoint,
    /// Its page, and its place there as a part of the page's edge.
    page: u32,
    at: DVec2,
    /// `None` until its page comes in.
    diffuse: Option<f32>,
}

/// How much of the sky the surface sees, while pages come in.
#[derive(Default)]
pub(crate) struct Brightness(Vec<Seen>);

impl Brightness {
    /// Takes what a page says of the points on it. A page without the diffuse term says nothing.
    pub fn add(&mut self, job: &Job, page: &BakedPage) {
        let Some(diffuse) = page.layer(Layer::Diffuse) else {
            return;
        };
        if self.0.is_empty() {
            self.0 = over_surface(job);
        }
        let last = page.size as usize - 1;
        for seen in self.0.iter_mut().filter(|seen| seen.page == page.page) {
            let texel = (seen.at * f64::from(page.size))
                .as_usizevec2()
                .min([last; 2].into());
            seen.diffuse = Some(diffuse[texel.y * page.size as usize + texel.x]);
        }
    }

    /// The warning that names `--bounces` and `--max-distance`, where most of the surface is dark and neither was
    /// given; bounces help only where some light gets in. None where there are lamps.
    ///
    /// * `hides`: points on outsides of rooms, which nobody within sees.
    /// * `covers`: dark points that something lies on: between two cubes there is no room.
    /// * `shuts`: dark points in shut spaces that are no rooms, which nobody looks at if there is more.
    /// * `texels`: of the whole atlas.
    pub fn interior(
        &self,
        options: &Options,
        has_lamps: bool,
        hides: impl Fn(&SurfacePoint) -> bool,
        covers: impl Fn(&SurfacePoint) -> bool,
        shuts: impl Fn(&SurfacePoint) -> bool,
        texels: u64,
    ) -> Option<WarningReport> {
        if options.max_distance.is_some() || has_lamps {
            return None;
        }
        let is_covered = |seen: &Seen, value: f32| value < DARK && covers(&seen.point);
        let known = self.0.iter().filter(|seen| {
            let value = seen.diffuse;
            value.is_some_and(|value| !is_covered(seen, value))
        });
        let (hidden, shown): (Vec<_>, Vec<_>) = known.partition(|seen| hides(&seen.point));
        let below = |least: f32| {
            let darker = |seen: &&&Seen| seen.diffuse.is_some_and(|value| value < least);
            shown.iter().filter(darker).count()
        };
        let (all, dark) = (shown.len(), below(DARK));
        let lit = all - below(FAINT);
        let is_closed = lit as f64 <= LEAKS * all as f64 + BORDERS * hidden.len() as f64;
        let is_told = is_closed || options.bounces == Bounces::Off;
        if !is_told || 2 * dark <= all {
            return None;
        }
        let is_shut =
            |seen: &&&Seen| seen.diffuse.is_some_and(|value| value < FAINT) && shuts(&seen.point);
        let shut = match is_closed {
            true => 0,
            false => shown.iter().filter(is_shut).count(),
        };
        // Where hardly anything else is, or that is dark too, people look at what is in there.
        if 10 * shut <= 9 * all && 2 * (dark - shut) <= all - shut {
            return None;
        }
        let share = dark as f64 / all.max(1) as f64;
        let message = match is_closed {
            true => {
                "next to no light of the sky gets in: all is closed, and between surfaces there is nothing to \
                 send on; `--max-distance D` shows corners and contacts, with D about a third of a room's height, \
                 and `--point` or `--sphere` puts a lamp inside"
                    .into()
            }
            false => format!(
                "{:.0} % of the surface sees less than {:.0} % of the sky: `--bounces auto` lets light go on from \
                 surface to surface there, and `--max-distance D` lets nothing farther away than D darken it, in a \
                 room about a third of its height",
                100.0 * share,
                100.0 * DARK
            ),
        };
        Some(WarningReport {
            kind: "interior".into(),
            place: "scene".into(),
            count: (share * texels as f64) as u64,
            message,
        })
    }
}

/// [`POINTS`] points, spread by area over all surfaces with texels that somebody may see.
fn over_surface(job: &Job) -> Vec<Seen> {
    let (world, atlas) = (job.world(), job.atlas());
    let instances = 0..atlas.placements.len() as u32;
    let triangles = instances.flat_map(|instance| {
        let mesh = world.scene().instances[instance as usize].mesh;
        let layout = &atlas.meshes[mesh as usize];
        (0..layout.triangles.len() as u32).filter_map(move |triangle| {
            let is_hidden = layout.hidden.get(triangle as usize) == Some(&true);
            let (page, corners) = on_page(job, instance, triangle).filter(|_| !is_hidden)?;
            let [a, b, c] = world.corners(instance, triangle);
            let area = (b - a).cross(c - a).length();
            Some((instance, triangle, area, page, corners))
        })
    });
    let whole: f64 = triangles.clone().map(|of| of.2).sum();
    let (mut along, mut points) = (0.0, Vec::with_capacity(POINTS));
    for (instance, triangle, area, page, corners) in triangles {
        along += area;
        while points.len() < POINTS && (points.len() as f64 + 0.5) * whole < along * POINTS as f64 {
            // Of a triangle's points each has its own place in it.
            let k = points.len() as f64;
            let [u, v] = [0.754_877_666, 0.569_840_291].map(|turn| (k * turn).fract());
            let root = f64::sqrt(u);
            let weights = [1.0 - root, root * (1.0 - v), root * v];
            let at = corners.iter().zip(weights);
            points.push(Seen {
                point: SurfacePoint {
                    instance,
                    triangle,
                    weights,
                },
                page,
                at: at.map(|(corner, weight)| corner.as_dvec2() * weight).sum(),
                diffuse: None,
            });
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A surface of which the k-th point of so many has such a diffuse term.
    fn surface(parts: &[(f32, usize)]) -> Brightness {
        let seen = |number: usize, diffuse: f32| Seen {
            point: SurfacePoint {
                instance: 0,
                triangle: number as u32,
                weights: [1.0, 0.0, 0.0],
            },
            page: 0,
            at: DVec2::ZERO,
            diffuse: Some(diffuse),
        };
        let values = parts
            .iter()
            .flat_map(|&(diffuse, count)| vec![diffuse; count]);
        Brightness(
            values
                .enumerate()
                .map(|(k, value)| seen(k, value))
                .collect(),
        )
    }

    /// Where nothing hides, covers or shuts.
    fn plain(
        of: &Brightness,
        options: &Options,
        has_lamps: bool,
        texels: u64,
    ) -> Option<WarningReport> {
        let none = |_: &SurfacePoint| false;
        of.interior(options, has_lamps, none, none, none, texels)
    }

    #[test]
    fn a_dark_median_is_an_interior_unless_a_distance_or_bounces_were_given() {
        let pages = surface(&[(0.7, 1), (0.02, 1), (0.05, 1)]);
        let warning =
            plain(&pages, &Options::default(), false, 100).expect("two of three parts are dark");
        assert!(warning.message.contains("--max-distance"));
        assert!(warning.message.contains("--bounces"));
        assert!(warning.message.starts_with("67 % of the surface"));
        assert_eq!(warning.count, 66);
        let (mut limited, mut bounced) = (Options::default(), Options::default());
        (limited.max_distance, bounced.bounces) = (Some(1.0), Bounces::Auto);
        assert!(plain(&pages, &limited, false, 100).is_none());
        assert!(plain(&pages, &bounced, false, 100).is_none());
        let pages = surface(&[(0.7, 1), (0.9, 1), (0.02, 1), (0.05, 1)]);
        let told = |hidden: u32| {
            let hides = |point: &SurfacePoint| point.triangle < hidden;
            pages.interior(&Options::default(), false, hides, |_| false, |_| false, 100)
        };
        assert!(told(0).is_none(), "half is not most");
        assert!(told(1).is_some(), "two of three, but for what lies outside");
    }

    #[test]
    fn where_no_light_gets_in_nothing_is_said_of_bounces() {
        let pages = surface(&[(0.0004, 5000)]);
        let closed = plain(&pages, &Options::default(), false, 5000).expect("all is dark");
        assert!(closed.message.contains("--max-distance") && !closed.message.contains("bounces"));
        let bounced = Options {
            bounces: Bounces::Auto,
            ..Options::default()
        };
        let still = plain(&pages, &bounced, false, 5000).map(|warning| warning.message);
        assert_eq!(still, Some(closed.message), "there is nothing to send on");
        assert!(
            plain(&pages, &bounced, true, 5000).is_none(),
            "a lamp is in it"
        );
        let pages = surface(&[(0.0004, 5000), (0.05, 50)]);
        let lit = plain(&pages, &Options::default(), false, 5050).expect("most is dark");
        assert!(lit.message.contains("--bounces"));
    }

    #[test]
    fn shut_spaces_are_no_interior_beside_what_light_gets_to() {
        let told = |parts: &[(f32, usize)], shut: u32| {
            let shuts = |point: &SurfacePoint| point.triangle < shut;
            let found = surface(parts).interior(
                &Options::default(),
                false,
                |_| false,
                |_| false,
                shuts,
                1000,
            );
            found.map(|warning| (warning.message, warning.count))
        };
        // Cupboards of 60 of a hundred points, and a lit kitchen around them.
        assert_eq!(told(&[(0.0, 60), (0.05, 3), (0.7, 37)], 60), None);
        // The kitchen is dark too: a level of a game may be such rooms.
        let (message, count) = told(&[(0.0, 60), (0.05, 30), (0.7, 10)], 60).expect("a line");
        assert!(message.starts_with("90 % of the surface"), "{message}");
        assert_eq!(count, 900);
        // What gets some light is not asked.
        assert!(told(&[(0.05, 60), (0.7, 40)], 60).is_some());
        // Next to nothing else is there.
        let (message, _) = told(&[(0.0, 95), (0.05, 5)], 95).expect("a line");
        assert!(message.starts_with("100 % of the surface"), "{message}");
        // All is shut: a room.
        let (message, _) = told(&[(0.0, 100)], 100).expect("a line");
        assert!(message.contains("all is closed"), "{message}");
    }
}
