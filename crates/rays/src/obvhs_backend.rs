//! Rays through obvhs: its trees find candidates, our f64 test decides.
//!
//! Triangles in world space share one tree. An instanced geometry has a tree of its own in mesh space; a tree over the
//! placed boxes leads to it, and the ray goes there by the inverse of the f32 transform, in f64. Its direction is not
//! normalised, so t is the same in both spaces.

use crate::alpha_test::AlphaTest;
use crate::backend::{Coherence, Ray, RayBackend, RayPacket, Stops, SurfaceHit, TreeKind};
use crate::coincident::Coincident;
use crate::tree::Tree;
use crate::triangle::ShearedRay;
use crate::world::World;
use glam::{DAffine3, DVec3};
use scene::around;

/// obvhs over a world.
pub struct ObvhsBackend {
    kind: TreeKind,
    flat: Group,
    groups: Vec<Group>,
    placements: Vec<Placement>,
    top: Tree,
    parts: Vec<PartTraits>,
    coincident: Coincident,
}

/// Triangles of one space.
struct Group {
    tree: Tree,
    /// In the tree's order.
    leaves: Vec<Leaf>,
}

struct Leaf {
    corners: [[f32; 3]; 3],
    triangle: u32,
    /// Meaningless in an instanced geometry.
    instance: u32,
}

#[derive(Clone, Copy)]
struct Placement {
    instance: u32,
    group: u32,
    inverse: DAffine3,
}

struct PartTraits {
    alpha: Option<AlphaTest>,
    /// The corners in the tree turn the other way than in the mesh.
    reversed: bool,
}

/// A ray in f64 with its interval.
#[derive(Clone, Copy)]
struct Query {
    sight: ShearedRay,
    t_min: f32,
    t_max: f32,
    /// [`Ray::id`], for alpha tests.
    id: u32,
}

impl ObvhsBackend {
    /// Builds all trees, in the current rayon pool.
    pub fn build(world: &World, kind: TreeKind) -> Self {
        let wide = kind == TreeKind::Cwbvh;
        let mut flat = Vec::new();
        let mut groups = Vec::new();
        let mut group_of = vec![None; world.geometries.len()];
        let mut placements = Vec::new();
        let mut boxes = Vec::new();
        for (instance, part) in world.parts.iter().enumerate() {
            let instance = instance as u32;
            let geometry = &world.geometries[part.geometry as usize];
            if geometry.triangles().is_empty() || !world.casts(instance) {
                continue;
            }
            let triangles =
                (0..geometry.triangles().len() as u32).map(|triangle| (instance, triangle));
            if part.transform.is_none() {
                flat.extend(triangles);
                continue;
            }
            let group = *group_of[part.geometry as usize].get_or_insert_with(|| {
                groups.push(Group::build(world, &triangles.collect::<Vec<_>>(), wide));
                groups.len() as u32 - 1
            });
            placements.push(Placement {
                instance,
                group,
                inverse: *part.inverse(),
            });
            let outline = part.outline(geometry.extent);
            boxes.push(around(outline).into());
        }
        let (top, order) = Tree::build(boxes.len(), |index| boxes[index], wide);
        Self {
            kind,
            flat: Group::build(world, &flat, wide),
            groups,
            placements: order
                .iter()
                .map(|&index| placements[index as usize])
                .collect(),
            top,
            parts: world
                .parts
                .iter()
                .map(|part| PartTraits {
                    alpha: world.geometries[part.geometry as usize].alpha.clone(),
                    reversed: part.transform.is_none() && part.mirrors(),
                })
                .collect(),
            coincident: Coincident::of(world),
        }
    }

    #[inline]
    fn test(&self, leaf: &Leaf, instance: u32, query: &Query) -> Option<SurfaceHit> {
        let crossing = query.sight.cross(&leaf.corners)?;
        let t = crossing.t as f32;
        if !(t > query.t_min && t <= query.t_max && t.is_finite()) {
            return None;
        }
        let part = &self.parts[instance as usize];
        let barycentric = crossing.barycentric.map(|weight| weight as f32);
        if part
            .alpha
            .as_ref()
            .is_some_and(|alpha| !alpha.keep(leaf.triangle, barycentric, query.id))
        {
            return None;
        }
        let front = crossing.front != part.reversed;
        Some(SurfaceHit {
            t,
            instance,
            triangle: leaf.triangle,
            barycentric,
            front,
        })
    }

    fn any(&self, query: &Query) -> bool {
        let flat = self
            .flat
            .tree
            .any(query.sight, query.t_max.into(), |index| {
                let leaf = &self.flat.leaves[index];
                self.test(leaf, leaf.instance, query).is_some()
            });
        flat || !self.placements.is_empty()
            && self.top.any(query.sight, query.t_max.into(), |index| {
                let placement = &self.placements[index];
                let group = &self.groups[placement.group as usize];
                let query = placement.carry(query);
                group.tree.any(query.sight, query.t_max.into(), |index| {
                    self.test(&group.leaves[index], placement.instance, &query)
                        .is_some()
                })
            })
    }

    fn first(&self, query: &Query) -> Option<SurfaceHit> {
        let mut best: Option<SurfaceHit> = None;
        let mut query = *query;
        self.flat
            .tree
            .nearest(query.sight, query.t_max.into(), |index| {
                let leaf = &self.flat.leaves[index];
                self.shorten(leaf, leaf.instance, &mut query, &mut best)
            });
        if self.placements.is_empty() {
            return best;
        }
        self.top.nearest(query.sight, query.t_max.into(), |index| {
            let placement = &self.placements[index];
            let group = &self.groups[placement.group as usize];
            let mut local = placement.carry(&query);
            let mut found = None;
            group
                .tree
                .nearest(local.sight, local.t_max.into(), |index| {
                    found = self
                        .shorten(
                            &group.leaves[index],
                            placement.instance,
                            &mut local,
                            &mut best,
                        )
                        .or(found);
                    found
                });
            query.t_max = local.t_max;
            found
        });
        best
    }

    /// Takes a hit that is nearer than the best, and ends the query there. The first of equals stays.
    #[inline]
    fn shorten(
        &self,
        leaf: &Leaf,
        instance: u32,
        query: &mut Query,
        best: &mut Option<SurfaceHit>,
    ) -> Option<f64> {
        let hit = self.test(leaf, instance, query)?;
        if best.is_some_and(|best| best.t <= hit.t) {
            return None;
        }
        *best = Some(hit);
        query.t_max = hit.t;
        Some(hit.t.into())
    }
}

impl RayBackend for ObvhsBackend {
    fn occluded16(&self, packet: &RayPacket<16>, active: u32, _: Coherence) -> u32 {
        let lanes = (0..16).filter(|lane| active >> lane & 1 == 1);
        lanes
            .filter(|&lane| self.occluded(&packet.get(lane)))
            .fold(0, |mask, lane| mask | 1 << lane)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.any(&Query::of(ray))
    }

    fn closest(&self, ray: &Ray) -> Option<SurfaceHit> {
        let hit = self.first(&Query::of(ray))?;
        Some(self.coincident.resolved(hit))
    }

    fn closest_that(&self, ray: &Ray, stops: Stops) -> Option<SurfaceHit> {
        let query = Query {
            id: stops.id(),
            ..Query::of(ray)
        };
        Some(self.coincident.resolved(self.first(&query)?))
    }

    fn name(&self) -> &'static str {
        "obvhs"
    }

    fn describe(&self) -> String {
        let kind = match self.kind {
            TreeKind::Cwbvh => "cwbvh",
            TreeKind::Bvh2 => "bvh2",
        };
        format!("obvhs 0.4 {kind}, f64 triangle test")
    }

    fn memory_bytes(&self) -> u64 {
        let groups = self.groups.iter().chain([&self.flat]);
        let trees: u64 = groups
            .map(|group| group.tree.memory_bytes() + size_of_val(&*group.leaves) as u64)
            .sum();
        trees
            + self.top.memory_bytes()
            + size_of_val(&*self.placements) as u64
            + size_of_val(&*self.parts) as u64
    }
}

impl Group {
    /// Of triangles given by instance and triangle, in their geometry's space.
    fn build(world: &World, triangles: &[(u32, u32)], wide: bool) -> Self {
        let corners_of = |(instance, triangle): (u32, u32)| {
            let (_, geometry) = world.part(instance);
            geometry.triangles()[triangle as usize]
                .map(|vertex| geometry.positions[vertex as usize])
        };
        let box_of = |index: usize| {
            let [a, b, c] = corners_of(triangles[index]);
            [a.min(b).min(c).as_dvec3(), a.max(b).max(c).as_dvec3()]
        };
        let (tree, order) = Tree::build(triangles.len(), box_of, wide);
        let leaf = |&index: &u32| {
            let (instance, triangle) = triangles[index as usize];
            Leaf {
                corners: corners_of((instance, triangle)).map(|corner| corner.to_array()),
                triangle,
                instance,
            }
        };
        let leaves = order.iter().map(leaf).collect();
        Self { tree, leaves }
    }
}

impl Placement {
    #[inline]
    fn carry(&self, query: &Query) -> Query {
        let ShearedRay {
            origin, direction, ..
        } = query.sight;
        let sight = ShearedRay::new(
            self.inverse.transform_point3(origin),
            self.inverse.transform_vector3(direction),
        );
        Query { sight, ..*query }
    }
}

impl Query {
    #[inline]
    fn of(ray: &Ray) -> Self {
        let origin = DVec3::from_array(ray.origin.map(f64::from));
        let direction = DVec3::from_array(ray.direction.map(f64::from));
        Self {
            sight: ShearedRay::new(origin, direction),
            t_min: if ray.t_min < 0.0 { 0.0 } else { ray.t_min },
            t_max: ray.t_max,
            id: ray.id(),
        }
    }
}
