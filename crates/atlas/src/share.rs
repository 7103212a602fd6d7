//! How many texels each object gets.
//!
//! With equal density everywhere the largest surface takes nearly all texels: a ground of 2 km around forty houses takes
//! 99.6 % of them. So without a density of the user's, this rule holds. `B` is the number of texels that there are.
//!
//! 1. **Equal density.** All objects have one density, so that parts which abut match.
//! 2. **Ceiling.** The largest objects, those over a [`ALIKE`]th of the largest extent, take at most [`CEILING`] of `B`
//!    together, and so does each object alone, while the others can use the rest. The others then share it at one higher
//!    density. They can use it until they have [`USEFUL`] of a page's edge across their extent, or as many texels as the
//!    largest object has across its own at equal density, if that is less: a lamp in a room needs no more than a wall.
//! 3. **Floor.** Every object has at least [`FLOOR`] of a page's edge across its extent: 16 texels at 1024². Where all
//!    floors take more than [`FLOORS`] of `B`, they shrink by one factor until they take that much.
//!
//! What this costs the largest objects is bounded: they keep 60 % of their texels, which is 77 % of their density (less the
//! floors). What it gives the rest is not: forty houses on the 2 km ground go from 0.4 % of the texels to 40 %, ten times
//! the density. Only the largest objects are held back, because a rule from the median size would starve walls under a
//! hundred cups. Objects whose density was asked for have it; the rule shares what they leave.

use crate::objects::Object;

/// Objects count as the largest down to this part of the largest extent: tiles of one ground, walls of one house.
const ALIKE: f64 = 4.0;
/// Largest share of the texels that the largest objects together, or any object, take from the others.
pub(crate) const CEILING: f64 = 0.6;
/// Least texels across an object's extent, in page edges.
pub(crate) const FLOOR: f64 = 1.0 / 64.0;
/// From so many texels across its extent, in page edges, an object needs no more than its equal share.
const USEFUL: f64 = 0.5;
/// The floors take at most this share of the texels.
const FLOORS: f64 = 0.5;

/// The density of each object, in texels per scene unit, when all have about `budget` texels together on pages of
/// `edge` texels; 0 for objects that take none.
pub(crate) fn densities(objects: &[Object], budget: f64, edge: u32) -> Vec<f64> {
    let asked_for = |o: &Object| o.asked.filter(|_| o.included).unwrap_or(0.0);
    let mut out: Vec<f64> = objects.iter().map(asked_for).collect();
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

/// The rule over objects without a density of their own.
fn shares(objects: &[&Object], budget: f64, edge: f64) -> Vec<f64> {
    match objects {
        [] => return Vec::new(),
        [only] => return vec![(budget / only.area).sqrt()],
        _ => {}
    }
    let texels =
        |f: &dyn Fn(&Object) -> f64| -> f64 { objects.iter().map(|o| o.area * f(o).powi(2)).sum() };
    let across = |part: f64| {
        move |o: &Object| {
            if o.extent > 0.0 {
                edge * part / o.extent
            } else {
                0.0
            }
        }
    };
    let floors = texels(&across(FLOOR));
    let shrink = (FLOORS * budget / floors).sqrt().min(1.0);
    let equal = (budget / texels(&|_| 1.0)).sqrt();
    let largest = objects.iter().map(|o| o.extent).fold(0.0, f64::max);
    let useful = USEFUL.min(equal * largest / edge);
    let rule = Rule {
        floor: &|o| shrink * across(FLOOR)(o),
        most: &|o| across(useful)(o).max(equal),
        ceiling: &|o| (CEILING * budget / o.area).sqrt(),
    };
    let (large, rest): (Vec<&Object>, Vec<&Object>) =
        objects.iter().partition(|o| ALIKE * o.extent > largest);
    let (of_large, of_rest) = {
        let all = rule.solve(objects, budget);
        if rest.is_empty() || rule.texels(&large, all) <= CEILING * budget {
            (all, all)
        } else {
            let of_rest = rule.solve(&rest, (1.0 - CEILING) * budget);
            let left = budget - rule.texels(&rest, of_rest);
            (rule.solve(&large, left), of_rest)
        }
    };
    let density = |o: &&Object| match ALIKE * o.extent > largest {
        true => rule.density(o, of_large),
        false => rule.density(o, of_rest),
    };
    let mut densities: Vec<f64> = objects.iter().map(density).collect();
    // Where the others have all that they can use, the rest goes to those under the ceiling.
    let taken: f64 = objects
        .iter()
        .zip(&densities)
        .map(|(o, d)| o.area * d * d)
        .sum();
    let capped = |d: f64, o: &Object| d >= (rule.ceiling)(o) * (1.0 - 1e-9);
    let full: f64 = objects
        .iter()
        .zip(&densities)
        .filter(|(o, d)| capped(**d, o))
        .map(|(o, d)| o.area * d * d)
        .sum();
    if full > 0.0 && taken < budget {
        let more = ((budget - taken + full) / full).sqrt();
        for (o, d) in objects.iter().zip(&mut densities) {
            *d *= if capped(*d, o) { more } else { 1.0 };
        }
    }
    densities
}

/// Limits of an object's density, in texels per scene unit.
struct Rule<'a> {
    floor: &'a dyn Fn(&Object) -> f64,
    most: &'a dyn Fn(&Object) -> f64,
    ceiling: &'a dyn Fn(&Object) -> f64,
}

impl Rule<'_> {
    /// The density of an object where `shared` is the one of its fellows.
    fn density(&self, object: &Object, shared: f64) -> f64 {
        let wanted = shared.min((self.most)(object)).max((self.floor)(object));
        wanted.min((self.ceiling)(object))
    }

    fn texels(&self, objects: &[&Object], shared: f64) -> f64 {
        let texels = |o: &&Object| o.area * self.density(o, shared).powi(2);
        objects.iter().map(texels).sum()
    }

    /// The shared density at which these objects take `budget` texels, or all that they can use if that is less.
    fn solve(&self, objects: &[&Object], budget: f64) -> f64 {
        let most = objects.iter().map(|o| (self.most)(o)).fold(0.0, f64::max);
        bisect(0.0, most, |d| self.texels(objects, d) <= budget)
    }
}

/// The largest number in `low..=high`, which are not below 0, for which `holds`, where it holds below and not above. Bits are halved and
/// not differences: densities of a speck and of a street may lie twenty powers of ten apart.
fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    if holds(high) {
        return high;
    }
    for _ in 0..64 {
        let middle = f64::from_bits((low.to_bits() + high.to_bits()) / 2);
        match holds(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn object(area: f64, extent: f64) -> Object {
        Object {
            instances: Vec::new(),
            area,
            extent,
            asked: None,
            included: true,
        }
    }

    const BUDGET: f64 = 8e5;

    fn shares_of(objects: &[Object], densities: &[f64]) -> Vec<f64> {
        let texels: Vec<f64> = objects
            .iter()
            .zip(densities)
            .map(|(o, d)| o.area * d * d)
            .collect();
        let all: f64 = texels.iter().sum();
        assert!(
            (all / BUDGET - 1.0).abs() < 1e-3,
            "{all} texels of {BUDGET}"
        );
        texels.into_iter().map(|t| t / all).collect()
    }

    #[test]
    fn what_is_asked_for_is_taken_from_the_budget_and_the_rest_is_shared() {
        let mut all = vec![object(100.0, 10.0), object(900.0, 30.0)];
        // 100 x 50 x 50 texels of 800,000; the other has what is left.
        all[0].asked = Some(50.0);
        let found = densities(&all, BUDGET, 1024);
        let left: f64 = (BUDGET - 250_000.0) / 900.0;
        assert_eq!(found[0], 50.0);
        assert!((found[1] / left.sqrt() - 1.0).abs() < 1e-9, "{found:?}");
        all[0].included = false;
        let found = densities(&all, BUDGET, 1024);
        assert_eq!(found, [0.0, (BUDGET / 900.0).sqrt()]);
    }

    #[test]
    fn a_large_ground_leaves_forty_percent_to_its_houses() {
        let mut town = vec![object(4e6, 2e3)];
        town.extend((0..40).map(|_| object(500.0, 12.0)));
        town.extend((0..60).map(|_| object(6.0, 1.0)));
        let densities = densities(&town, BUDGET, 1024);
        let shares = shares_of(&town, &densities);
        assert!((shares[0] - CEILING).abs() < 1e-3, "{}", shares[0]);
        assert!(
            densities[1] * 12.0 > 35.0,
            "{} texels across a house",
            densities[1] * 12.0
        );
        assert!(
            densities[50] >= 16.0 - 1e-9,
            "{} texels across a crate",
            densities[50]
        );
    }

    #[test]
    fn tiles_of_a_ground_are_held_back_together() {
        let mut town: Vec<Object> = (0..16).map(|_| object(250e3, 500.0)).collect();
        town.extend((0..40).map(|_| object(500.0, 12.0)));
        let shares = shares_of(&town, &densities(&town, BUDGET, 1024));
        let ground: f64 = shares[..16].iter().sum();
        assert!((ground - CEILING).abs() < 1e-3, "{ground}");
    }

    #[test]
    fn many_small_things_cannot_starve_the_walls() {
        let mut room = vec![object(214.0, 10.0)];
        room.extend((0..16).map(|_| object(2.2, 0.9)));
        room.extend((0..200).map(|_| object(0.05, 0.1)));
        let densities = densities(&room, BUDGET, 1024);
        let equal = (BUDGET / room.iter().map(|o| o.area).sum::<f64>()).sqrt();
        assert!(densities[0] > 0.7 * equal, "{} of {equal}", densities[0]);
    }

    #[test]
    fn objects_of_like_size_have_one_density() {
        let walls: Vec<Object> = (1..=20)
            .map(|k| object(f64::from(k), 3.0 + 0.1 * f64::from(k)))
            .collect();
        let densities = densities(&walls, BUDGET, 1024);
        for d in &densities {
            assert!((d / densities[0] - 1.0).abs() < 1e-9, "{densities:?}");
        }
        assert_eq!(
            shares_of(&walls[..1], &super::densities(&walls[..1], BUDGET, 1024)),
            [1.0]
        );
    }

    #[test]
    fn a_centimetre_beside_ten_kilometres_is_seen() {
        let scene = [object(5e7, 1e4), object(6e-4, 0.01)];
        let densities = densities(&scene, BUDGET, 1024);
        let shares = shares_of(&scene, &densities);
        assert!((shares[0] - CEILING).abs() < 1e-3, "{shares:?}");
        // A thin pole can use little: the ground has what it leaves.
        let scene = [object(1e4, 100.0), object(1.6, 10.0)];
        let densities = super::densities(&scene, BUDGET, 1024);
        assert!((densities[1] * 10.0 - 512.0).abs() < 1.0, "{densities:?}");
        assert!(shares_of(&scene, &densities)[0] > 0.9);
    }

    #[test]
    fn a_lamp_has_no_more_texels_across_than_the_walls_of_its_room() {
        // The Cornell box: its walls, its boxes and its light, in millimetres.
        let scene = [
            object(1.56e6, 560.0),
            object(2.8e5, 330.0),
            object(1.6e5, 206.0),
            object(1.37e4, 130.0),
        ];
        let budget = 5e5;
        let densities = densities(&scene, budget, 1024);
        let equal = (budget / scene.iter().map(|o| o.area).sum::<f64>()).sqrt();
        let across = densities[3] * 130.0;
        assert!(across <= equal * 560.0 * (1.0 + 1e-9), "{across}");
        let share = densities[3].powi(2) * 1.37e4 / budget;
        assert!(share < 0.15, "{share}");
    }

    #[test]
    fn what_was_asked_for_is_law_and_floors_shrink_where_they_must() {
        let mut scene = vec![object(1e4, 100.0), object(100.0, 10.0), object(100.0, 10.0)];
        scene[1].asked = Some(7.5);
        scene[2].included = false;
        let densities = densities(&scene, BUDGET, 1024);
        assert_eq!(densities[1], 7.5);
        assert_eq!(densities[2], 0.0);
        let many: Vec<Object> = (0..10_000)
            .map(|k| object(3.0, if k < 2 { 8.0 } else { 1.0 }))
            .collect();
        let densities = super::densities(&many, BUDGET, 1024);
        shares_of(&many, &densities);
        assert!(
            densities[9] < 16.0 && densities[9] > 4.0,
            "{}",
            densities[9]
        );
    }
}
