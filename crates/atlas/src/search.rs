//! The highest densities at which everything fits its pages.

use crate::drafts::Drafts;
use crate::objects::Object;
use crate::pack::{Frame, Shape};
use crate::pages::{Packed, Spread, spread};
use crate::share::{FLOOR, densities};
use crate::{Error, Options, Pages};
use layers::Progress;

/// Everything to place at some densities.
pub(crate) struct Cut<T> {
    pub shapes: Vec<Shape>,
    /// The group of each shape: those of a group go on one page where they can.
    pub groups: Vec<u32>,
    /// What the caller needs besides to read the result.
    pub kept: T,
}

/// A finished search.
pub(crate) struct Found<T> {
    pub densities: Vec<f64>,
    pub packed: Packed,
    pub kept: T,
}

/// Under `--pages auto` a page is added while an object has fewer texels, half of its floor, and fewer across its
/// extent, in page edges: 4 at 1024².
const LEAST: f64 = 0.5 * FLOOR;
const LEAST_ACROSS: f64 = 1.0 / 256.0;
/// Where one page does not do, `--pages auto` adds pages until this share of them is inside charts.
const LEAST_INSIDE: f64 = 0.25;
/// Pages that `--pages auto` adds at most.
pub(crate) const MOST_PAGES: u32 = 1024;
/// Texels that can be laid out at most: the pages of such an atlas take 4 GiB a channel.
const MOST_TEXELS: f64 = (1u64 << 30) as f64;
/// The search ends when the budget is known to this factor.
const CLOSE: f64 = 1.012;
/// Where drafts promised too little, so many steps up are short.
const SHORT_RISES: i32 = 4;
/// What was found to fit is raised to so many times as much, two at once.
const RISE: [f64; 2] = [1.02, 1.05];
/// Whether few shapes fit is much by chance: of so many at most it is also asked whether they fit so many times larger.
const FEW: usize = 1000;
const CHANCES: [[f64; 2]; 2] = [[1.015, 1.025], [1.035, 1.05]];
/// The share of the pages that shapes with their gutters fill about.
const FILL: f64 = 0.93;

/// Finds densities and places. `cut` makes the shapes at given densities (texels per scene unit, one an object); asked
/// for a draft it may leave out all turns but the first.
///
/// # Errors
///
/// What was asked for does not fit, or the caller cancels.
pub(crate) fn search<T: Send>(
    objects: &[Object],
    options: &Options,
    progress: &dyn Progress,
    cut: impl Fn(&[f64], bool) -> Result<Cut<T>, Error> + Sync,
) -> Result<Found<T>, Error> {
    progress.phase("packing charts");
    let size = options.page_size;
    let frame = Frame {
        width: size,
        height: size,
        gutter: options.gutter,
        border: options.gutter,
    };
    let how = |pages| Spread {
        frame,
        pages,
        together: options.one_page_per_mesh,
    };
    let most = match options.pages {
        Pages::Auto => MOST_PAGES,
        Pages::Most(pages) => pages,
    };
    let shared = |budget: f64| densities(objects, budget, size, options.even);
    let attempt = |densities: Vec<f64>, pages: u32| -> Result<Option<Found<T>>, Error> {
        if progress.cancelled() {
            return Err(Error::Cancelled);
        }
        let Cut {
            shapes,
            groups,
            kept,
        } = cut(&densities, false)?;
        let packed = spread(&shapes, &groups, how(pages));
        Ok(packed.map(|packed| Found {
            densities,
            packed,
            kept,
        }))
    };
    let texels: f64 = texels(objects, &shared(0.0));
    if texels > MOST_TEXELS {
        return Err(Error::TooManyTexels(texels as u64));
    }
    if objects
        .iter()
        .all(|o| o.asked.is_some() || !o.included || o.area <= 0.0)
    {
        let densities = shared(0.0);
        let draft = cut(&densities, true)?;
        too_large(&draft.shapes, size, options.gutter)?;
        let found = attempt(densities, most)?;
        return found.ok_or(Error::PagesFull { pages: most, size });
    }
    // The least that a layout can be: one texel and its gutter a chart.
    let page = f64::from(size).powi(2);
    let texels_of = |densities: &[f64]| self::texels(objects, densities);
    let mut drafts = Drafts::new(|budget: f64| -> Result<f64, Error> {
        if progress.cancelled() {
            return Err(Error::Cancelled);
        }
        let draft = cut(&shared(budget), true)?;
        if too_large(&draft.shapes, size, options.gutter).is_err() {
            return Ok(f64::INFINITY);
        }
        let grown = draft.shapes.iter().map(|s| s[0].grown_area(options.gutter));
        Ok(grown.sum::<u64>() as f64)
    });
    let least = drafts.grown(1.0)?;
    let mut pages = match options.pages {
        Pages::Auto => 1,
        Pages::Most(pages) => pages,
    };
    if least.is_finite() {
        pages = pages.max((least / page).ceil() as u32);
    }
    // Pages that a density asked for brings about are not filled with the others: these have one page's texels at most.
    let limit = match options.pages {
        Pages::Auto if texels > 0.0 => texels + page,
        _ => f64::INFINITY,
    };
    let coarse = |densities: &[f64]| {
        let mut free = (objects.iter().zip(densities)).filter(|(o, _)| o.asked.is_none());
        !options.even
            && free.any(|(o, &d)| {
                // What nobody sees has no area, and needs none.
                let is_small = o.area > 0.0 && o.area * d * d < LEAST;
                d > 0.0 && is_small && o.extent * d < LEAST_ACROSS * f64::from(size)
            })
    };
    let more = |pages: u32| match pages < most {
        true => (pages + 1 + pages / 4).min(most),
        false => pages + 1,
    };
    let mut before = 0.0;
    let mut promised = 0.0;
    while pages <= most && least.is_finite() {
        let capacity = f64::from(pages) * page;
        // One page is what users expect, however full of gutters. Several that are mostly gutters help nobody, unless
        // more would not help either, as where a page is small for a single chart.
        let inside = |densities: &[f64]| match pages {
            1 => 1.0,
            _ => texels_of(densities) / capacity,
        };
        // Shapes that leave no texel empty show what pages can hold at most: where even that is too little,
        // nothing is tried.
        if pages < most {
            let best = shared(drafts.around(capacity, capacity.min(limit))?.1);
            let inside = inside(&best);
            let is_empty = inside < LEAST_INSIDE && inside > promised && limit.is_infinite();
            if coarse(&best) || is_empty {
                promised = if pages == 1 { 0.0 } else { inside };
                pages = more(pages);
                continue;
            }
        }
        let found = fullest(capacity, limit, least, &mut drafts, &|budget| {
            attempt(shared(budget), pages)
        })?;
        match found {
            Some(found) if pages == most => return Ok(found),
            Some(found) if !coarse(&found.densities) => {
                let inside = inside(&found.densities);
                if inside >= LEAST_INSIDE || inside <= before || limit.is_finite() {
                    return Ok(found);
                }
                before = inside;
                pages = more(pages);
            }
            _ => pages = more(pages),
        }
    }
    Err(match options.pages {
        Pages::Most(pages) => Error::PagesFull { pages, size },
        Pages::Auto => Error::PageFull {
            charts: cut(&shared(1.0), true)?.shapes.len() as u32,
            size,
        },
    })
}

/// The fullest layout of at most `limit` texels: bisects the budget between one that fits and one that does not.
///
/// * `least`: what shapes take with their gutters where each is as small as it gets.
/// * `drafts`: what they take at other budgets.
fn fullest<T: Send>(
    capacity: f64,
    limit: f64,
    least: f64,
    drafts: &mut Drafts<impl Fn(f64) -> Result<f64, Error>>,
    attempt: &(dyn Fn(f64) -> Result<Option<Found<T>>, Error> + Sync),
) -> Result<Option<Found<T>>, Error> {
    // With gutters the shapes take more than their budget, so drafts say where to begin.
    let most = capacity.min(limit);
    // Where gutters alone are more than fills the pages, shapes that take no more than the smallest fit if these do.
    let is_tight = least > FILL * capacity;
    let (low, _) = drafts.around(least.max(FILL * capacity), most)?;
    let mut best: Option<(f64, Found<T>)> = None;
    // Larger shapes may fit where smaller ones do not: what counts is the largest that fits, and what fails above it.
    let mut failed: Vec<f64> = Vec::new();
    let mut rises = 0;
    let mut chances = CHANCES.into_iter();
    let mut pair = match is_tight {
        true => [1.0, low],
        false => [0.95 * low, low].map(|b| b.max(1.0)),
    };
    loop {
        // Two at once, whatever the number of threads, so that the result is the same at any.
        let (less, more) = rayon::join(|| attempt(pair[0]), || attempt(pair[1]));
        for (budget, found) in pair.into_iter().zip([less?, more?]) {
            match found {
                Some(found) => best = Some((budget, found)),
                None => failed.push(budget),
            }
        }
        let fits = best.as_ref().map_or(0.0, |best| best.0);
        let above = failed.iter().filter(|&&budget| budget > fits);
        let fails = above.copied().fold(f64::INFINITY, f64::min);
        pair = match best {
            Some((fits, ref found)) if fails < fits * CLOSE => {
                let is_few = found.packed.spots.len() <= FEW;
                let Some(steps) = chances.next().filter(|_| is_few) else {
                    break;
                };
                steps.map(|step| (step * fits).min(most))
            }
            Some((fits, _)) if fails.is_finite() => {
                let third = (fails / fits).cbrt();
                [fits * third, fits * third * third]
            }
            Some((fits, _)) if fits >= most => break,
            // Charts of a texel or two stay as they are over many steps: these become longer.
            Some((fits, _)) => {
                rises += 1;
                let steps = 1 << (rises - SHORT_RISES).clamp(0, 16);
                // Gutters take so much of small charts that a step in texels is a long one in budgets.
                RISE.map(|step| {
                    (step.powi(steps) * fits)
                        .max(drafts.times(fits, step))
                        .min(most)
                })
            }
            None if fails <= 1.0 => break,
            // So far below what drafts promise, first of all whether anything fits.
            None if fails < 0.5 * low => [1.0, (0.9 * fails).max(1.0)],
            None => [0.8, 0.9].map(|step| (step * fails).max(1.0)),
        };
    }
    Ok(best.map(|(_, found)| found))
}

/// Texels that the objects have at these densities.
fn texels(objects: &[Object], densities: &[f64]) -> f64 {
    let taken = |(o, d): (&Object, &f64)| if o.included { o.area * d * d } else { 0.0 };
    objects.iter().zip(densities).map(taken).sum()
}

/// The error that names the largest shape, if one does not fit on a page.
fn too_large(shapes: &[Shape], size: u32, gutter: u32) -> Result<(), Error> {
    // Of a sliver of any length the width is that of the largest number.
    let padded = |shape: &Shape| {
        [shape[0].width, shape[0].height].map(|edge| edge.saturating_add(2 * gutter))
    };
    match shapes.iter().map(padded).max_by_key(|s| s[0].max(s[1])) {
        Some([width, height]) if width.max(height) > size => Err(Error::ChartTooLarge {
            width,
            height,
            size,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mask::Mask;

    /// The budget that is found where all up to `most` fit, though a draft takes `draft` of the pages, and how many
    /// were tried.
    fn tried(most: f64, draft: f64) -> (Option<f64>, u32) {
        let count = std::sync::atomic::AtomicU32::new(0);
        let attempt = |budget: f64| {
            count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            let packed = Packed {
                spots: Vec::new(),
                pages: 1,
            };
            let found = Found {
                densities: vec![budget],
                packed,
                kept: (),
            };
            Ok((budget <= most).then_some(found))
        };
        let mut drafts = Drafts::new(|_| Ok(draft * 1e6));
        let found = fullest(1e6, f64::INFINITY, draft * 1e6, &mut drafts, &attempt);
        let budget = found.expect("no error").map(|found| found.densities[0]);
        (budget, count.into_inner())
    }

    #[test]
    fn few_layouts_are_tried_however_far_drafts_are_off() {
        // Of a texel each, charts fill the page by gutters alone up to a budget that is far above the first; and the
        // other way round.
        for (most, draft) in [
            (3e4, 0.99),
            (1.5e5, 0.99),
            (2.5, 0.01),
            (5e4, 0.01),
            (9e5, 0.01),
        ] {
            let (budget, count) = tried(most, draft);
            let budget = budget.expect("something fits");
            assert!(
                budget <= most && most < budget * CLOSE,
                "{budget} of {most}"
            );
            assert!(count <= 32, "{count} layouts for {most}");
        }
        let (nothing, count) = tried(0.5, 0.01);
        assert!(
            nothing.is_none() && count <= 12,
            "{count} layouts for nothing"
        );
    }

    #[test]
    fn a_sliver_wider_than_any_number_is_an_error() {
        let sliver = vec![Mask::full(u32::MAX, 1)];
        let error = too_large(&[vec![Mask::full(3, 3)], sliver], 16, 2).unwrap_err();
        let Error::ChartTooLarge {
            width,
            height,
            size,
        } = error
        else {
            panic!("{error}");
        };
        assert_eq!((width, height, size), (u32::MAX, 5, 16));
        // A chart and its gutters just fill the page.
        assert!(too_large(&[vec![Mask::full(12, 3)]], 16, 2).is_ok());
        assert!(too_large(&[vec![Mask::full(13, 3)]], 16, 2).is_err());
    }
}
