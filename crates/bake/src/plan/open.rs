//! A certain and cheap test for open triangles: nothing of the scene stands above their tangent plane.
//!
//! On such a triangle every ray of the upper hemisphere escapes, so the terms have closed forms and no ray is needed. A
//! convex body standing alone is the case in which every triangle passes. The test asks for the scene's support in the
//! direction of the normal, over a tree of boxes around its vertices, the farthest boxes first, and stops at the first
//! vertex above the plane. That vertex is tried first on the next triangle. "Above" means by more than the rounding
//! bound that ray origins keep from the surface anyway.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rays::{Patch, PlaneErrors, World, around};
use std::sync::atomic::{AtomicBool, Ordering};

/// Vertices in one leaf box, and children of one inner box.
const LEAF: usize = 32;
const FAN: usize = 8;

/// For every object and triangle: is it open?
#[derive(Debug, Clone, Default)]
pub struct OpenTriangles {
    /// One flag list an object; an empty list means that none is open.
    flags: Vec<Vec<bool>>,
    /// How many triangles are open.
    pub open: u64,
    /// How many there are.
    pub total: u64,
    /// The shading normals of an open triangle leave its geometric normal.
    pub tilted: bool,
}

impl OpenTriangles {
    /// The answer for one triangle.
    pub fn contains(&self, instance: u32, triangle: u32) -> bool {
        self.flags
            .get(instance as usize)
            .and_then(|flags| flags.get(triangle as usize))
            .copied()
            .unwrap_or(false)
    }

    /// Tests every triangle of every object against [`World::hull_points`], which is certain but more cautious for
    /// instanced meshes: they count as their boxes.
    pub(crate) fn of(world: &World, errors: &PlaneErrors) -> Self {
        let tree = SupportTree::build(world.hull_points());
        let tilted = AtomicBool::new(false);
        let flags: Vec<Vec<bool>> = (0..world.parts.len() as u32)
            .map(|instance| {
                let count = world.part(instance).1.triangles().len() as u32;
                let flags: Vec<bool> = (0..count)
                    .into_par_iter()
                    .map_init(
                        || 0,
                        |witness, triangle| {
                            let patch = Patch::of(world, errors, instance, triangle);
                            let normal = patch.geometric;
                            let height = patch
                                .corners
                                .iter()
                                .map(|c| c.dot(normal))
                                .fold(f64::MIN, f64::max);
                            let open = !tree.any_above(normal, height + patch.rounding(), witness);
                            if open && !patch.is_flat() {
                                tilted.store(true, Ordering::Relaxed);
                            }
                            open
                        },
                    )
                    .collect();
                if flags.contains(&true) {
                    flags
                } else {
                    Vec::new()
                }
            })
            .collect();
        let open = flags.iter().flatten().filter(|&&flag| flag).count() as u64;
        let total = (0..world.parts.len() as u32)
            .map(|i| world.part(i).1.triangles().len() as u64)
            .sum();
        Self {
            flags,
            open,
            total,
            tilted: tilted.into_inner(),
        }
    }
}

/// Boxes over points, level by level from the leaves; a node's children are `FAN` neighbours of the level below.
struct SupportTree {
    points: Vec<DVec3>,
    levels: Vec<Vec<(DVec3, DVec3)>>,
}

impl SupportTree {
    fn build(mut points: Vec<DVec3>) -> Self {
        let (low, high) = around(points.iter().copied());
        let scale = (high - low).max_element().max(f64::MIN_POSITIVE);
        points.sort_by_cached_key(|p| morton(((*p - low) / scale).as_vec3()));
        let leaves = points.chunks(LEAF).map(|part| around(part.iter().copied()));
        let mut levels = vec![leaves.collect::<Vec<_>>()];
        while levels.last().is_some_and(|level| level.len() > 1) {
            let below = &levels[levels.len() - 1];
            let level = below
                .chunks(FAN)
                .map(|boxes| around(boxes.iter().flat_map(|&(low, high)| [low, high])))
                .collect();
            levels.push(level);
        }
        Self { points, levels }
    }

    /// True where some point p has `normal . p > height`. `witness` is a point to try first, and becomes the one that
    /// was found.
    fn any_above(&self, normal: DVec3, height: f64, witness: &mut usize) -> bool {
        if self
            .points
            .get(*witness)
            .is_some_and(|p| normal.dot(*p) > height)
        {
            return true;
        }
        let top = self.levels.len() - 1;
        let found =
            (0..self.levels[top].len()).find_map(|node| self.above(top, node, normal, height));
        if let Some(found) = found {
            *witness = found;
        }
        found.is_some()
    }

    /// A point of the node above the plane, which the node's box may reach. The child that reaches farthest is looked
    /// at first.
    fn above(&self, level: usize, node: usize, normal: DVec3, height: f64) -> Option<usize> {
        if level == 0 {
            let end = ((node + 1) * LEAF).min(self.points.len());
            return (node * LEAF..end).find(|&i| normal.dot(self.points[i]) > height);
        }
        let below = &self.levels[level - 1];
        let first = node * FAN;
        let mut reaches = [f64::NEG_INFINITY; FAN];
        for (reach, (low, high)) in reaches.iter_mut().zip(&below[first..]) {
            *reach = normal.dot(DVec3::select(normal.cmpge(DVec3::ZERO), *high, *low));
        }
        loop {
            let (child, reach) = (0..FAN)
                .map(|child| (child, reaches[child]))
                .max_by(|a, b| a.1.total_cmp(&b.1))?;
            match reach > height {
                true => reaches[child] = f64::NEG_INFINITY,
                false => return None,
            }
            let found = self.above(level - 1, first + child, normal, height);
            if found.is_some() {
                return found;
            }
        }
    }
}

/// 30-bit Morton code of a point in the unit cube.
fn morton(p: Vec3) -> u32 {
    let spread = |v: f32| {
        let mut x = (v * 1023.0) as u32 & 0x3ff;
        x = (x | (x << 16)) & 0x0300_00ff;
        x = (x | (x << 8)) & 0x0300_f00f;
        x = (x | (x << 4)) & 0x030c_30c3;
        (x | (x << 2)) & 0x0924_9249
    };
    spread(p.x) | (spread(p.y) << 1) | (spread(p.z) << 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn support_of_a_grid_agrees_with_a_plain_scan() {
        let points: Vec<DVec3> = (0..4000)
            .map(|i| DVec3::new((i % 20) as f64, (i / 20 % 20) as f64, (i / 400) as f64))
            .collect();
        let tree = SupportTree::build(points.clone());
        for k in 0..200 {
            let a = f64::from(k) * 0.7;
            let normal = DVec3::new(a.sin(), (1.3 * a).cos(), (0.4 * a).sin()).normalize();
            let support = points
                .iter()
                .map(|p| p.dot(normal))
                .fold(f64::MIN, f64::max);
            assert!(!tree.any_above(normal, support, &mut 0), "normal {normal}");
            assert!(
                tree.any_above(normal, support - 1e-9, &mut 7),
                "normal {normal}"
            );
        }
    }
}
