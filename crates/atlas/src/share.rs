//! How many texels each object gets.
//!
//! With equal density everywhere the largest surface takes nearly all texels: a ground of 2 km around forty houses takes
//! 99.6 % of them. So without a density of the user's, this rule holds. `d` is a density that all objects share, `B` the
//! number of texels that there are, `L` an object's extent and `A` its surface.
//!
//! 1. **Equal density.** An object has the density `d`, so that abutting parts of like size match.
//! 2. **Falling.** Objects larger than [`LARGE`] times the median extent `M` have `d (LARGE M / L)^q`. The exponent `q`
//!    is the smallest, from 0 up, at which these objects together take at most [`CEILING`] of the texels. So a scene
//!    without outliers keeps equal density, many tiny parts cannot starve what they stand on (it keeps 60 % of its texels,
//!    which is 77 % of its density), and a large ground cannot starve the rest (which has 40 %).
//! 3. **Ceiling.** No object takes more than [`CEILING`] of `B` while others can use what it leaves. They can until they
//!    have [`USEFUL`] of a page's edge across their extent.
//! 4. **Floor.** Every object has at least [`FLOOR`] of a page's edge across its extent: 16 texels at 1024². Where all
//!    floors take more than half of `B`, they shrink by one factor until they take half.
//!
//! Objects whose density was asked for have it; the rule shares what they leave.

use crate::objects::Object;

/// So many median extents make an object large: between one and two steps of size as people build (door, room, house,
/// street), each of about a factor of four.
const LARGE: f64 = 8.0;
/// Largest share of the texels that one object, or all large ones together, take from the others.
pub(crate) const CEILING: f64 = 0.6;
/// Least texels across an object's extent, in page edges.
pub(crate) const FLOOR: f64 = 1.0 / 64.0;
/// From so many texels across its extent, in page edges, an object needs no more than its share.
const USEFUL: f64 = 0.5;
/// The floors take at most this share of the texels.
const FLOORS: f64 = 0.5;

/// The density of each object, in texels per scene unit, when all have about `budget` texels together on pages of
/// `edge` texels; 0 for objects that take none.
pub(crate) fn densities(objects: &[Object], budget: f64, edge: u32) -> Vec<f64> {
    let mut out: Vec<f64> = objects.iter().map(|o| o.asked.unwrap_or(0.0)).collect();
    let free: Vec<usize> = (0..objects.len())
        .filter(|&i| objects[i].included && objects[i].asked.is_none() && objects[i].area > 0.0)
        .collect();
    let taken = |o: &Object| match o.asked {
        Some(density) if o.included => o.area * density * density,
        _ => 0.0,
    };
    let asked: f64 = objects.iter().map(taken).sum();
    // What was asked for may take more than there is: the rest then has its floors, and the page overflows.
    let rest = (budget - asked).max(budget / 16.0);
    let shared: Vec<&Object> = free.iter().map(|&i| &objects[i]).collect();
    for (&i, density) in free.iter().zip(shares(&shared, rest, f64::from(edge))) {
        out[i] = density;
    }
    out
}

fn shares(objects: &[&Object], budget: f64, edge: f64) -> Vec<f64> {
    match objects {
        [] => return Vec::new(),
        [only] => return vec![(budget / only.area).sqrt()],
        _ => {}
    }
    let factors = falling(objects);
    let squares = |f: &dyn Fn(usize) -> f64| -> f64 {
        objects
            .iter()
            .enumerate()
            .map(|(i, o)| o.area * f(i).powi(2))
            .sum()
    };
    // A surface far from flat may take more texels than its extent squared; an object without extent has no floor.
    let floor = |i: usize| match objects[i].extent {
        extent if extent > 0.0 => edge * FLOOR / extent,
        _ => 0.0,
    };
    let floors = squares(&floor);
    let shrink = (FLOORS * budget / floors).sqrt().min(1.0);
    let equal = (budget / squares(&|_| 1.0)).sqrt();
    let most = |i: usize| match objects[i].extent {
        extent if extent > 0.0 => (edge * USEFUL / extent).max(equal),
        _ => equal,
    };
    let density = |i: usize, d: f64, ceiling: f64| {
        let ceiling = (ceiling * budget / objects[i].area).sqrt();
        (d * factors[i])
            .min(most(i))
            .max(shrink * floor(i))
            .min(ceiling)
    };
    let total = |d: f64, ceiling: f64| squares(&|i| density(i, d, ceiling));
    // Above this, every object has the most that it can use.
    let enough = (0..objects.len())
        .map(|i| most(i) / factors[i])
        .fold(0.0, f64::max);
    let (d, ceiling) = if total(enough, CEILING) >= budget {
        (
            bisect(0.0, enough, |d| total(d, CEILING) <= budget),
            CEILING,
        )
    } else {
        // The others have all they can use: what is left goes to those under the ceiling.
        let (mut d, mut last) = (enough, 0.0);
        while total(d, 1.0) < budget && total(d, 1.0) > last {
            (last, d) = (total(d, 1.0), 2.0 * d);
        }
        (d, bisect(CEILING, 1.0, |c| total(d, c) <= budget))
    };
    (0..objects.len()).map(|i| density(i, d, ceiling)).collect()
}

/// What step 2 leaves of each object's density, above 0 and at most 1.
fn falling(objects: &[&Object]) -> Vec<f64> {
    let mut extents: Vec<f64> = objects.iter().map(|o| o.extent).collect();
    extents.sort_by(f64::total_cmp);
    // The lower one of two in the middle: a prop and its ground have the prop's.
    let knee = LARGE * extents[(extents.len() - 1) / 2];
    let at = |q: f64| -> Vec<f64> {
        let factor = |o: &&Object| {
            (knee / o.extent.max(knee))
                .powf(q)
                .max(f64::MIN_POSITIVE.sqrt())
        };
        objects.iter().map(factor).collect()
    };
    if knee <= 0.0 {
        return vec![1.0; objects.len()];
    }
    let share = |q: f64| {
        let (mut large, mut all) = (0.0, 0.0);
        for (o, factor) in objects.iter().zip(at(q)) {
            let texels = o.area * factor * factor;
            all += texels;
            large += if o.extent > knee { texels } else { 0.0 };
        }
        large / all
    };
    if share(0.0) <= CEILING {
        return at(0.0);
    }
    let most = 64.0;
    at(most - bisect(0.0, most, |less| share(most - less) <= CEILING))
}

/// The largest number in `low..=high` for which `holds`, where it holds below and not above.
fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    if holds(high) {
        return high;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match holds(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}
