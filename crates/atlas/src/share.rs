//! How many texels each object gets.
//!
//! Without a density of the user's, this rule holds.
//!
//! 1. **Equal density.** All objects have one density, so that parts which abut match.
//! 2. **Small objects.** One that has few texels then gets more, up to [`MOST`] times that density, until it has
//!    [`USEFUL`] of a page's edge across its extent, or as many texels as the largest object has across its own, if
//!    that is less: a lamp in a room needs no more than a wall. Where this would take more than the share [`GIVEN`]
//!    of the texels of the others, all such objects get so many times less.
//! 3. **Floor.** Every object has at least [`FLOOR`] texels, those of its charts that nobody sees among them. Where all
//!    floors take more than [`FLOORS`] of the texels, they shrink by one factor until they take that much.
//!
//! So no object has more texels than its area allows: its share is at most 16 times what it would be at equal
//! density, and a surface that has what it needs gets no more than another. Only specks of fewer than 16 texels have
//! more than [`MOST`] times the density of others, and small copies of a mesh (`copies.rs`). Objects whose density was
//! asked for have it; the rule shares what they leave.

use crate::objects::Object;

/// Times the common density that a small object has, at most.
const MOST: f64 = 4.0;
/// From so many texels across its extent, in page edges, an object needs no more than its equal share.
const USEFUL: f64 = 1.0 / 16.0;
/// Share of their texels that objects give to the small ones, at most.
pub(crate) const GIVEN: f64 = 0.4;
/// Least texels of an object, just below 16.
pub(crate) const FLOOR: f64 = 15.99;
/// The floors take at most this share of the texels.
const FLOORS: f64 = 0.5;

/// The density of each object, in texels per scene unit, when all have about `budget` texels together on pages of
/// `edge` texels; 0 for objects that are not included.
///
/// * `even`: the first point of the rule alone.
pub(crate) fn densities(objects: &[Object], budget: f64, edge: u32, even: bool) -> Vec<f64> {
    let asked_for = |o: &Object| o.asked.filter(|_| o.included).unwrap_or(0.0);
    let mut out: Vec<f64> = objects.iter().map(asked_for).collect();
    let may_choose = |&i: &usize| objects[i].included && objects[i].asked.is_none();
    let (free, hidden): (Vec<usize>, Vec<usize>) = (0..objects.len())
        .filter(may_choose)
        .partition(|&i| objects[i].area > 0.0);
    let taken = |o: &Object| match o.asked {
        Some(density) if o.included => o.area * density * density,
        _ => 0.0,
    };
    let asked: f64 = objects.iter().map(taken).sum();
    // What was asked for may take more than there is: the rest then has its floors, and the page overflows.
    let rest = (budget - asked).max(budget / 16.0);
    let shared: Vec<&Object> = free.iter().map(|&i| &objects[i]).collect();
    let shares = match even {
        true => vec![common(&shared, rest); shared.len()],
        false => shares(&shared, rest, f64::from(edge)),
    };
    for (&i, density) in free.iter().zip(shares) {
        out[i] = density;
    }
    // What is hidden takes one texel a chart at any density, and is laid out by a number above 0.
    let equal = Some(common(&shared, rest)).filter(|density| density.is_finite());
    for i in hidden {
        out[i] = equal.unwrap_or(1.0);
    }
    out
}

/// How fine the parts of an object are, in texels per scene unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// As it should be.
    pub density: f64,
    /// Up to which the rule holds as well.
    pub most: f64,
    /// Which a copy of a mesh may have where larger ones would take more texels without.
    pub last: f64,
}

impl Limits {
    /// Just this density.
    pub fn law(density: f64) -> Self {
        Self {
            density,
            most: density,
            last: density,
        }
    }
}

/// The limits of objects that have these densities by the rule.
pub(crate) fn limits(objects: &[Object], densities: &[f64], even: bool) -> Vec<Limits> {
    let is_shared = |object: &Object| object.included && object.asked.is_none();
    let all = || objects.iter().zip(densities);
    let shared = all().filter(|(object, _)| is_shared(object) && object.area > 0.0);
    let least = shared.fold(f64::INFINITY, |least, (_, density)| least.min(*density));
    let of = |(object, &density): (&Object, &f64)| match is_shared(object) && !even {
        true => Limits {
            density,
            most: density.max(MOST * least),
            last: f64::INFINITY,
        },
        false => Limits::law(density),
    };
    all().map(of).collect()
}

/// The density at which objects have so many texels together.
fn common(objects: &[&Object], budget: f64) -> f64 {
    (budget / objects.iter().map(|o| o.area).sum::<f64>()).sqrt()
}

/// The rule over objects without a density of their own.
fn shares(objects: &[&Object], budget: f64, edge: f64) -> Vec<f64> {
    match objects {
        [] => return Vec::new(),
        [only] => return vec![(budget / only.area).sqrt()],
        _ => {}
    }
    let shrink = (FLOORS * budget / (FLOOR * objects.len() as f64)).min(1.0);
    let equal = common(objects, budget);
    let largest = objects.iter().map(|o| o.extent).fold(0.0, f64::max);
    let useful = (USEFUL * edge).min(equal * largest);
    let wishes: Vec<Wish> = objects
        .iter()
        .map(|o| Wish {
            area: o.area,
            wanted: useful / o.extent.max(f64::MIN_POSITIVE),
            floor: ((shrink * FLOOR - o.hidden).max(0.0) / o.area).sqrt(),
        })
        .collect();
    let fits = |common: f64, times: f64| {
        let texels = wishes
            .iter()
            .map(|w| w.area * w.density(common, times).powi(2));
        texels.sum::<f64>() <= budget
    };
    let kept = (1.0 - GIVEN).sqrt() * equal;
    let mut times = MOST;
    if !fits(kept, times) {
        let (mut low, mut high) = (1.0, MOST);
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            match fits(kept, middle) {
                true => low = middle,
                false => high = middle,
            }
        }
        times = low;
    }
    let common = bisect(0.0, equal, |common| fits(common, times));
    wishes.iter().map(|w| w.density(common, times)).collect()
}

/// What an object would have: the densities at which it is large enough, and at which it has its floor.
struct Wish {
    area: f64,
    wanted: f64,
    floor: f64,
}

impl Wish {
    /// Its density where the others have `common`, and small ones so many times that at most.
    fn density(&self, common: f64, times: f64) -> f64 {
        common.max(self.wanted.min(times * common)).max(self.floor)
    }
}

/// Steps in which it is found how many times the common density small objects get.
const STEPS: u32 = 10;

/// The largest number in `low..=high`, which are not below 0, for which `holds`, where it holds below and not above.
/// Bits are halved and not differences: densities of a speck and of a street may lie twenty powers of ten apart.
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
            hidden: 0.0,
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
        let found = densities(&all, BUDGET, 1024, false);
        let left: f64 = (BUDGET - 250_000.0) / 900.0;
        assert_eq!(found[0], 50.0);
        assert!((found[1] / left.sqrt() - 1.0).abs() < 1e-9, "{found:?}");
        all[0].included = false;
        let found = densities(&all, BUDGET, 1024, false);
        assert_eq!(found, [0.0, (BUDGET / 900.0).sqrt()]);
    }

    #[test]
    fn an_even_density_is_one_for_all_that_asked_for_none() {
        let mut all = vec![object(900.0, 30.0), object(0.01, 0.1), object(100.0, 10.0)];
        let found = densities(&all, BUDGET, 1024, true);
        shares_of(&all, &found);
        assert!(found.iter().all(|&d| d == found[0]), "{found:?}");
        all[2].asked = Some(50.0);
        let found = densities(&all, BUDGET, 1024, true);
        assert_eq!((found[0], found[2]), (found[1], 50.0));
        shares_of(&all, &found);
    }

    #[test]
    fn houses_on_a_large_ground_have_four_times_its_density() {
        let mut town = vec![object(4e6, 2e3)];
        town.extend((0..40).map(|_| object(500.0, 12.0)));
        town.extend((0..60).map(|_| object(6.0, 1.0)));
        let densities = densities(&town, BUDGET, 1024, false);
        shares_of(&town, &densities);
        assert!((densities[1] / densities[0] - 4.0).abs() < 1e-9);
        assert!(
            densities[1] * 12.0 > 18.0,
            "{} across a house",
            densities[1] * 12.0
        );
        assert!((densities[50] / densities[0] - 4.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_wholly_hidden_is_laid_out_by_the_equal_density() {
        let scene = [object(100.0, 10.0), object(0.0, 3.0), object(400.0, 20.0)];
        let found = densities(&scene, BUDGET, 1024, false);
        assert!(
            (found[1] - (BUDGET / 500.0).sqrt()).abs() < 1e-9,
            "{found:?}"
        );
        let alone = densities(&scene[1..2], BUDGET, 1024, false);
        assert!(alone[0].is_finite() && alone[0] > 0.0, "{alone:?}");
    }

    #[test]
    fn a_table_has_no_more_than_its_area_allows() {
        // A room of 12 x 3 x 12 and its table, a hundredth of all area: 93 texels a unit at equal density are 148
        // across.
        let room = [object(432.0, 12.0), object(4.4, 1.6)];
        let densities = densities(&room, BUDGET, 1024, false);
        let equal = f64::sqrt(BUDGET / 436.4);
        assert!((densities[0] - equal).abs() < 1e-9 * equal && densities[0] == densities[1]);
        // A cup of a tenth has 64 texels across where four times the density leave it so many.
        let room = [object(432.0, 12.0), object(0.05, 0.1)];
        let densities = super::densities(&room, BUDGET, 1024, false);
        let across = densities[1] * 0.1;
        assert!(
            (densities[1] / densities[0] - 4.0).abs() < 1e-9 && across < 64.0,
            "{across}"
        );
    }

    #[test]
    fn many_small_things_cannot_starve_the_walls() {
        let mut room = vec![object(214.0, 10.0)];
        room.extend((0..16).map(|_| object(2.2, 0.9)));
        room.extend((0..200).map(|_| object(0.05, 0.1)));
        let densities = densities(&room, BUDGET, 1024, false);
        let equal = (BUDGET / room.iter().map(|o| o.area).sum::<f64>()).sqrt();
        assert!(densities[0] > 0.77 * equal, "{} of {equal}", densities[0]);
        let most = densities.iter().copied().fold(0.0, f64::max);
        assert!(most < 4.001 * densities[0], "{most}");
    }

    #[test]
    fn objects_of_like_size_have_one_density() {
        let walls: Vec<Object> = (1..=20)
            .map(|k| object(f64::from(k), 3.0 + 0.1 * f64::from(k)))
            .collect();
        let densities = densities(&walls, BUDGET, 1024, false);
        for d in &densities {
            assert!((d / densities[0] - 1.0).abs() < 1e-9, "{densities:?}");
        }
        assert_eq!(
            shares_of(
                &walls[..1],
                &super::densities(&walls[..1], BUDGET, 1024, false)
            ),
            [1.0]
        );
    }

    #[test]
    fn a_centimetre_beside_ten_kilometres_is_seen() {
        let scene = [object(5e7, 1e4), object(6e-4, 0.01)];
        let densities = densities(&scene, BUDGET, 1024, false);
        assert!(
            (densities[1].powi(2) * 6e-4 - FLOOR).abs() < 1e-6,
            "{densities:?}"
        );
        assert!(shares_of(&scene, &densities)[0] > 0.999);
    }

    #[test]
    fn texels_of_what_nobody_sees_count_towards_the_least_that_an_object_has() {
        let mut scene = vec![object(5e7, 1e4), object(6e-4, 0.01), object(6e-4, 0.01)];
        (scene[1].hidden, scene[2].hidden) = (3.75, 20.0);
        let densities = densities(&scene, BUDGET, 1024, false);
        let seen = densities[1].powi(2) * 6e-4;
        assert!((seen - (FLOOR - 3.75)).abs() < 1e-6, "{seen}");
        // With 16 texels or more it has no more than four times the density of others.
        assert!((densities[2] / densities[0] - MOST).abs() < 1e-9);
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
        let densities = densities(&scene, budget, 1024, false);
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
        let densities = densities(&scene, BUDGET, 1024, false);
        assert_eq!(densities[1], 7.5);
        assert_eq!(densities[2], 0.0);
        let many: Vec<Object> = (0..10_000)
            .map(|k| object(3.0, if k < 2 { 8.0 } else { 1.0 }))
            .collect();
        let densities = super::densities(&many, BUDGET, 1024, false);
        shares_of(&many, &densities);
        assert!(
            densities[9] < 16.0 && densities[9] > 4.0,
            "{}",
            densities[9]
        );
    }
}
