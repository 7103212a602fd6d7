//! Finds out whether a scene is an interior, where the sky reaches little and a limit of distance shows more, and what
//! stands around everything.

use crate::job::Job;
use crate::options::Options;
use crate::shell::over;
use atlas::ObjectName;
use glam::DVec3;
use rays::Ray;
use report::WarningReport;

/// Bins of the diffuse term, over 0..=1.
const BINS: usize = 100;
/// At this median of the diffuse term or below, half of the scene hardly sees the sky.
const DARK: f64 = 0.1;
/// A sky dome has at least this share of the scene's largest side, and may end so far short of what is in it.
const LARGE: f64 = 0.49;
const NEAR: f64 = 0.001;
/// Faces of an object that are asked what they see. Of their rays one in so many may leave a dome, and one in so many
/// meets it.
const FACES: u32 = 32;
/// So many of the objects within a dome are asked, at most.
const OBJECTS: usize = 64;
/// So many objects may be that dome, the largest ones.
const CANDIDATES: usize = 4;
const FEW: u64 = 50;
const MANY: u64 = 10;

/// How many texels have which diffuse term, over all pages.
#[derive(Debug, Clone)]
pub(crate) struct Brightness([u64; BINS]);

impl Default for Brightness {
    fn default() -> Self {
        Self([0; BINS])
    }
}

impl Brightness {
    /// Adds the covered texels of a page.
    pub fn add(&mut self, diffuse: &[f32], coverage: &[f32]) {
        for (value, _) in diffuse.iter().zip(coverage).filter(|(_, c)| **c > 0.0) {
            self.0[((value * BINS as f32) as usize).min(BINS - 1)] += 1;
        }
    }

    /// The warning that names `--bounces` and `--max-distance`, where the median is dark and neither was given.
    pub fn interior(&self, options: &Options) -> Option<WarningReport> {
        let helped = options.max_distance.is_some() || options.adds_light();
        let dark: u64 = self.0[..(DARK * BINS as f64) as usize].iter().sum();
        let all: u64 = self.0.iter().sum();
        (!helped && all > 0 && 2 * dark > all).then(|| WarningReport {
            kind: "interior".into(),
            place: "scene".into(),
            count: dark,
            message: format!(
                "most texels see less than {:.0} % of the sky, as inside a building; `--bounces auto` lets light go on from surface to \
                 surface there, and `--max-distance D` shows corners and contacts, with D about a third of a room's height",
                100.0 * DARK
            ),
        })
    }
}

/// The warning that names a sheet around most of a scene, such as a sky dome, which hides the sky from all that is in it.
/// `None` where light was asked for that needs no sky.
pub(crate) fn enclosed(job: &Job) -> Option<WarningReport> {
    let (world, options) = (job.world(), job.options());
    if options.max_distance.is_some() || options.adds_light() {
        return None;
    }
    let objects = atlas::object_names(world.scene());
    let around = |object: &ObjectName| {
        let boxes = object.instances.iter().filter_map(|&i| world.box_of(i));
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    };
    let boxes: Vec<Option<(DVec3, DVec3)>> = objects.iter().map(around).collect();
    let large = LARGE * (world.bounds().max - world.bounds().min).max_element();
    let side = |object: usize| {
        let casts = objects[object].instances.iter().any(|&i| world.casts(i));
        let (low, high) = boxes[object].filter(|_| casts)?;
        Some((high - low).max_element()).filter(|&side| side >= large)
    };
    let mut candidates: Vec<(usize, f64)> = (0..objects.len())
        .filter_map(|object| Some((object, side(object)?)))
        .collect();
    candidates.sort_by(|a, b| b.1.total_cmp(&a.1));
    let hides = |&(object, side): &(usize, f64)| {
        let Some((low, high)) = boxes[object] else {
            return false;
        };
        let slack = NEAR * side;
        let holds = |other: &usize| {
            let is_in = |&(l, h): &(DVec3, DVec3)| {
                low.cmple(l + slack).all() && high.cmpge(h - slack).all()
            };
            *other != object && boxes[*other].as_ref().is_some_and(is_in)
        };
        let within: Vec<usize> = (0..objects.len()).filter(holds).collect();
        let holds_most = !within.is_empty() && 2 * within.len() >= objects.len() - 1;
        let step = within.len().div_ceil(OBJECTS).max(1);
        let some = within.iter().step_by(step);
        let some: Vec<u32> = some
            .flat_map(|&k| objects[k].instances.iter().copied())
            .collect();
        holds_most && is_sheet_around(job, &objects[object], &some)
    };
    let (found, _) = candidates.into_iter().take(CANDIDATES).find(hides)?;
    Some(WarningReport {
        kind: "enclosed".into(),
        place: format!("object `{}`", objects[found].name),
        count: 1,
        message: "what stands in it sees no sky; where it is a sky dome or a shell, `--no-cast NAME` lets the light \
                  through it"
            .into(),
    })
}

/// True where next to no ray from faces of some objects that see a further one leaves the scene, many meet that one
/// first, and nothing is beyond it.
fn is_sheet_around(job: &Job, sheet: &ObjectName, within: &[u32]) -> bool {
    let (world, backend) = (job.world(), job.backend());
    let off = 1e-5 * world.bounds().diagonal();
    let cast = |origin: DVec3, direction: DVec3| Ray {
        origin: origin.as_vec3().to_array(),
        direction: direction.as_vec3().to_array(),
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    // Rays, those that leave, those that meet the sheet, and those that meet something beyond it.
    let mut sums = [0_u64; 4];
    for &instance in within {
        let count = world.part(instance).1.triangles().len() as u32;
        let step = count.div_ceil(FACES).max(1);
        for triangle in (0..count).step_by(step as usize) {
            let normal = world.upward(instance, triangle);
            let centre = world.corners(instance, triangle).iter().sum::<DVec3>() / 3.0;
            let mut of_face = [0_u64; 4];
            for direction in over(normal) {
                of_face[0] += 1;
                let Some(hit) = backend.closest(&cast(centre + normal * off, direction)) else {
                    of_face[1] += 1;
                    continue;
                };
                if sheet.instances.contains(&hit.instance) {
                    of_face[2] += 1;
                    let there = centre + normal * off + direction * (f64::from(hit.t) + off);
                    of_face[3] += u64::from(backend.occluded(&cast(there, direction)));
                }
            }
            if of_face[2] > 0 {
                sums.iter_mut()
                    .zip(of_face)
                    .for_each(|(sum, own)| *sum += own);
            }
        }
    }
    let [all, left, met, beyond] = sums;
    FEW * left <= all && MANY * met >= all && met > 0 && MANY * beyond <= met
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::bake::Bounces;

    #[test]
    fn a_dark_median_is_an_interior_unless_a_distance_or_bounces_were_given() {
        let mut pages = Brightness::default();
        pages.add(
            &[0.02, 0.05, 0.7, 0.0, 0.0, 0.0],
            &[1.0, 0.3, 1.0, 0.0, 0.0, 0.0],
        );
        let warning = pages
            .interior(&Options::default())
            .expect("two of three covered texels are dark");
        assert!(warning.message.contains("--max-distance"));
        assert!(warning.message.contains("--bounces"));
        let (mut limited, mut bounced) = (Options::default(), Options::default());
        (limited.max_distance, bounced.bounces) = (Some(1.0), Bounces::Auto);
        assert!(pages.interior(&limited).is_none());
        assert!(pages.interior(&bounced).is_none());
        pages.add(&[0.9], &[1.0]);
        assert!(
            pages.interior(&Options::default()).is_none(),
            "half is not most"
        );
    }
}
