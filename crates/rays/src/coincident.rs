//! Triangles that stand in the same place, and which of them a ray is said to meet.
//!
//! A sheet that is modelled as two triangles back to back, or an instance that stands twice, is met at one distance.
//! Which of the two a tree finds first depends on its library, and light would be looked up on the wrong side. The rule
//! is that of what can be seen: the first triangle in the order of the scene whose front faces the ray, else the first
//! of all.

use crate::backend::SurfaceHit;
use crate::mix::Mix;
use crate::world::World;
use rayon::prelude::*;
use std::collections::HashMap;

/// The groups of a world's opaque triangles that share all three corners, to the last bit.
#[derive(Debug, Default)]
pub(crate) struct Coincident {
    /// By instance.
    parts: Vec<Placed>,
    /// The group of a triangle, by geometry and triangle, and its corners' order.
    groups: HashMap<[u32; 2], (u32, Order)>,
    /// The first of those that face one way, and of those that face the other way.
    firsts: Vec<[Option<Member>; 2]>,
}

#[derive(Debug, Clone, Copy)]
struct Placed {
    geometry: u32,
    /// The first instance of the same geometry in the same place.
    first: u32,
    /// The corners in the world turn the other way than in the mesh.
    reversed: bool,
}

#[derive(Debug, Clone, Copy)]
struct Member {
    /// `None` within a geometry that instances share: the hit's own.
    instance: Option<u32>,
    triangle: u32,
    order: Order,
}

/// For each corner of a triangle its place in the order of their coordinates.
type Order = [u8; 3];

impl Coincident {
    /// Of the instances that rays meet.
    pub fn of(world: &World) -> Self {
        let mut firsts: HashMap<(u32, [u32; 12]), u32> = HashMap::new();
        let mut owners: Vec<Option<Option<u32>>> = vec![None; world.geometries.len()];
        let mut parts = Vec::with_capacity(world.parts.len());
        for (instance, part) in (0..).zip(&world.parts) {
            let mut first = instance;
            if world.casts(instance) {
                owners[part.geometry as usize] = Some(part.transform.is_none().then_some(instance));
                if let Some(transform) = part.transform {
                    let place = transform.to_cols_array().map(f32::to_bits);
                    first = *firsts.entry((part.geometry, place)).or_insert(instance);
                }
            }
            parts.push(Placed {
                geometry: part.geometry,
                first,
                reversed: part.transform.is_none() && part.mirrors(),
            });
        }
        let opaque = (0..world.geometries.len() as u32).filter(|&geometry| {
            owners[geometry as usize].is_some()
                && world.geometries[geometry as usize].alpha.is_none()
        });
        let of_geometry = |geometry: u32| {
            let count = world.geometries[geometry as usize].triangles().len() as u32;
            (0..count).map(move |triangle| [geometry, triangle])
        };
        let all: Vec<[u32; 2]> = opaque.flat_map(of_geometry).collect();
        // Those of geometries in the world may meet one another; instanced ones are in spaces of their own.
        let space = |[geometry, _]: [u32; 2]| match owners[geometry as usize] {
            Some(None) => geometry + 1,
            _ => 0,
        };
        let key = |&at: &[u32; 2]| -> (u64, [u32; 2]) {
            let (corners, _) = sorted(world, at);
            let mixed = |hash: u64, bits: u32| Mix(hash ^ u64::from(bits)).bits();
            let seed = mixed(0, space(at));
            let hash = corners.iter().flatten().fold(seed, |h, &b| mixed(h, b));
            (hash, at)
        };
        let mut keys: Vec<(u64, [u32; 2])> = all.par_iter().map(key).collect();
        keys.par_sort_unstable();
        let mut found = Coincident {
            parts,
            ..Coincident::default()
        };
        for run in keys.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
            let mut rest: Vec<[u32; 2]> = run.iter().map(|&(_, at)| at).collect();
            // Of equal hashes: those with the corners of the first are one group.
            while let [first, ..] = rest[..] {
                let place = sorted(world, first).0;
                let (same, others): (Vec<_>, Vec<_>) = rest
                    .into_iter()
                    .partition(|&at| (space(at), sorted(world, at).0) == (space(first), place));
                rest = others;
                if same.len() < 2 {
                    continue;
                }
                let mut firsts = [None; 2];
                for at in same {
                    let [geometry, triangle] = at;
                    let instance = owners[geometry as usize].flatten();
                    let order = sorted(world, at).1;
                    let member = Member {
                        instance,
                        triangle,
                        order,
                    };
                    let number = found.firsts.len() as u32;
                    found.groups.insert(at, (number, order));
                    firsts[found.side(instance, order)].get_or_insert(member);
                }
                found.firsts.push(firsts);
            }
        }
        found
    }

    /// The same hit on the triangle that the rule names.
    pub fn resolved(&self, hit: SurfaceHit) -> SurfaceHit {
        let placed = self.parts[hit.instance as usize];
        let hit = SurfaceHit {
            instance: placed.first,
            ..hit
        };
        if self.groups.is_empty() {
            return hit;
        }
        let Some(&(group, order)) = self.groups.get(&[placed.geometry, hit.triangle]) else {
            return hit;
        };
        let firsts = &self.firsts[group as usize];
        let own = self.side(Some(hit.instance), order);
        let faces = if hit.front { own } else { 1 - own };
        let Some(member) = firsts[faces].or(firsts[1 - faces]) else {
            return hit;
        };
        let [b, c] = hit.barycentric;
        let weight = |corner: usize| {
            let same = (0..3).find(|&k| order[k] == member.order[corner]);
            [1.0 - b - c, b, c][same.unwrap_or(corner)]
        };
        let instance = member.instance.unwrap_or(hit.instance);
        let side = self.side(Some(instance), member.order);
        SurfaceHit {
            t: hit.t,
            instance,
            triangle: member.triangle,
            barycentric: [weight(1), weight(2)],
            front: side == faces,
        }
    }

    /// 0 or 1: to which side of its place a triangle faces.
    fn side(&self, instance: Option<u32>, order: Order) -> usize {
        let reversed = instance.is_some_and(|instance| self.parts[instance as usize].reversed);
        usize::from(is_odd(order) != reversed)
    }
}

/// The corners' coordinates as ordered bits, and how the triangle's own corners stand in that order.
fn sorted(world: &World, [geometry, triangle]: [u32; 2]) -> ([[u32; 3]; 3], Order) {
    let geometry = &world.geometries[geometry as usize];
    let corners = geometry.triangles()[triangle as usize].map(|vertex| {
        let corner = geometry.positions[vertex as usize];
        // Adding 0 takes the sign off a zero.
        corner.to_array().map(|v| (v + 0.0).to_bits())
    });
    let mut by_place = [0, 1, 2];
    by_place.sort_by_key(|&k| corners[k]);
    let mut order = [0; 3];
    for (place, &corner) in (0..).zip(&by_place) {
        order[corner] = place;
    }
    (by_place.map(|k| corners[k]), order)
}

/// True for an odd permutation.
fn is_odd(order: Order) -> bool {
    matches!(order, [0, 2, 1] | [1, 0, 2] | [2, 1, 0])
}
