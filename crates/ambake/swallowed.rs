//! Finds large objects that lie whole in another, such as a car in its body for collisions.

use crate::points::{area, points_on};
use crate::shell::Stand;
use atlas::{ObjectName, SurfacePoint};
use rays::World;
use std::collections::{BTreeMap, BTreeSet};

/// Points of an object that are asked.
const POINTS: u32 = 64;
/// So many of them lie in the solid that holds nearly all.
const WITHIN: u32 = POINTS - POINTS / 8;
/// The share of the scene's surface that an object has at least: bolts in plates and cores of walls are smaller.
const LARGE: f64 = 0.01;

/// An object and what lies in it.
pub(crate) struct Swallowed {
    /// The object of which closed surfaces are solids.
    pub holder: String,
    /// The largest object of which nearly all lies in those, and how many further ones do.
    pub largest: String,
    pub others: usize,
}

/// The object in which most surface of large objects `wanted` lies buried; none where nothing large does.
pub(crate) fn swallowed(world: &World, wanted: impl Fn(&ObjectName) -> bool) -> Option<Swallowed> {
    if world.solids().count() == 0 {
        return None;
    }
    let mut objects = atlas::object_names(world.scene());
    let areas: Vec<f64> = objects.iter().map(|of| area(world, of)).collect();
    let least = LARGE * areas.iter().sum::<f64>();
    let mut known = None;
    let mut found: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (k, object) in objects.iter().enumerate() {
        if areas[k] < least || !wanted(object) {
            continue;
        }
        let points = points_on(world, object, POINTS);
        let is_buried = |of: &&SurfacePoint| {
            !world.keeps_buried(of.instance)
                && world.is_buried(of.instance, of.triangle, of.weights)
        };
        if (points.iter().filter(is_buried).count() as u32) < WITHIN {
            continue;
        }
        let owners = known.get_or_insert_with(|| owners(world, &objects));
        let mut counts: BTreeMap<usize, u32> = BTreeMap::new();
        for holder in points.iter().flat_map(|of| holders(world, owners, of)) {
            *counts.entry(holder).or_default() += 1;
        }
        let most = counts.into_iter().filter(|of| of.0 != k);
        if let Some((holder, WITHIN..)) = most.max_by_key(|of| of.1) {
            found.entry(holder).or_default().push(k);
        }
    }
    let sum = |held: &[usize]| held.iter().map(|&k| areas[k]).sum::<f64>();
    let (holder, held) = found
        .into_iter()
        .max_by(|a, b| sum(&a.1).total_cmp(&sum(&b.1)))?;
    let largest = held
        .iter()
        .max_by(|a, b| areas[**a].total_cmp(&areas[**b]))?;
    let mut name = |k: usize| std::mem::take(&mut objects[k].name);
    Some(Swallowed {
        holder: name(holder),
        largest: name(*largest),
        others: held.len() - 1,
    })
}

/// The object of the first triangle of each body.
fn owners(world: &World, objects: &[ObjectName]) -> Vec<Option<usize>> {
    let solids = world.solids();
    let mut owners = vec![None; solids.bodies() as usize];
    for (k, object) in objects.iter().enumerate() {
        for &instance in &object.instances {
            for triangle in 0..world.part(instance).1.triangles().len() as u32 {
                if let Some(body) = solids.own(instance, triangle) {
                    owners[body as usize].get_or_insert(k);
                }
            }
        }
    }
    owners
}

/// The objects in solids of which a point lies. What is behind a ground or outside of a room lies in none.
fn holders(world: &World, owners: &[Option<usize>], point: &SurfacePoint) -> BTreeSet<usize> {
    let solids = world.solids();
    let Some(at) = Stand::at(world, point).map(|stand| stand.place) else {
        return BTreeSet::new();
    };
    let own = solids.own(point.instance, point.triangle);
    let about = solids.about(at, at).into_iter();
    let holds = |body: &u32| solids.rooted(*body).is_empty() && solids.depth(*body, at, own) > 0;
    let held = about.filter(holds);
    held.filter_map(|body| owners[body as usize]).collect()
}
